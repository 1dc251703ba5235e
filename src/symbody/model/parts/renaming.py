"""Elements under other names: every name, address and formula in them, by what each argument is."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from symbody.expr.language.formula import Formula
from symbody.model.body import Frames
from symbody.model.declarations.declaration import Declared, Field
from symbody.model.declarations.element_fields import Coupled
from symbody.model.declarations.fields import ElementName, OptionalText, SymbolElementName, SymbolName
from symbody.model.declarations.joint_fields import (
    Armature,
    Coordinate,
    CoordinateDrive,
    CoordinateDrives,
    Coordinates,
    PrescribedAngle,
    PrescribedMotions,
)
from symbody.model.element import Element, FrameRef
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.joints.orientation import SpeedNames
from symbody.model.naming import GROUND

E = TypeVar("E", bound=Declared)

# Mappings whose keys are coordinates.
_BY_COORDINATE = (Armature, CoordinateDrive, CoordinateDrives, PrescribedAngle, PrescribedMotions)
# First words of outputs, behind which names of elements and frames stand.
_OF_ELEMENTS = frozenset("reaction effort frame length angle friction rope_tension".split())


@dataclass(frozen=True, slots=True)
class Renaming:
    """New names for the elements and symbols of a part.

    Attributes
    ----------
    prefix : str
        Of elements and of frames on the ground.
    symbols : mapping of str to str
        All symbols of the part with their new names.
    elements : tuple of str
        The names of its elements.
    at : FrameRef
        What is the ground of the part.
    """

    prefix: str
    symbols: Mapping[str, str]
    elements: tuple[str, ...]
    at: FrameRef

    def element_name(self, name: str) -> str:
        """Return the new name of an element."""
        return f"{self.prefix}_{name}"

    def symbol(self, name: str) -> str:
        """Return the new name of a symbol."""
        return self.symbols.get(name, name)

    def frame(self, address: FrameRef) -> FrameRef:
        """Return where a frame of the part is."""
        if address.body != GROUND:
            return FrameRef(self.element_name(address.body), address.frame)
        return FrameRef(self.at.body, self.element_name(address.frame)) if address.frame else self.at

    def formula(self, formula: Formula) -> Formula:
        """Return a formula in the new names."""
        return formula.rename(self.symbols)

    def output(self, text: str) -> str:
        """Return the name of an output, or an expression, in the new names."""
        first, blank, rest = text.partition(" ")
        if first in _OF_ELEMENTS and blank:
            return f"{first} {self._addresses(rest)}"
        quoted = re.compile(r"'([^']*)'")
        symbols = re.compile(r"(?<![\w.])[^\W\d]\w*")  # not the exponent of 1e3
        pieces, end = [], 0
        for found in quoted.finditer(text):
            pieces += [symbols.sub(lambda m: self.symbol(m[0]), text[end : found.start()])]
            pieces += [f"'{self.output(found[1])}'"]
            end = found.end()
        return "".join((*pieces, symbols.sub(lambda m: self.symbol(m[0]), text[end:])))

    def _addresses(self, text: str) -> str:
        names = sorted((*self.elements, *self.symbols, GROUND), key=len, reverse=True)
        words = "|".join(map(re.escape, names))
        return re.sub(rf"(?<![\w.])({words})(?!\w)(\.\w+)?", self._new_address, text)

    def _new_address(self, found: re.Match[str]) -> str:
        name, frame = found[1], (found[2] or "")[1:]
        if name == GROUND:
            return self.frame(FrameRef(GROUND, frame)).full_name
        if name in self.elements:
            return f"{self.element_name(name)}.{frame}" if frame else self.element_name(name)
        return self.symbol(name)


def rename_element(element: Element, renaming: Renaming) -> Element:
    """Return an element of a part under its new name."""
    return _rename_declared(element, renaming)


def rename_part(part: E, renaming: Renaming) -> E:
    """Return a frame, shape or other part of an element with its formulas in the new names."""
    return _rename_declared(part, renaming)


def _rename_declared(declared: E, renaming: Renaming) -> E:
    changes: dict[str, Any] = {}
    for name, field in declared.fields.items():
        value = getattr(declared, name)
        changed = _rename_argument(field, value, renaming)
        if changed is not value:
            changes[name] = changed
    return replace(declared, **changes) if changes else declared


def _rename_argument(field: Field[Any, Any], value: Any, renaming: Renaming) -> Any:
    if isinstance(field, SymbolElementName | SymbolName | Coordinate):
        return None if value is None else renaming.symbol(value)
    if isinstance(field, ElementName):
        return renaming.element_name(value)
    if isinstance(field, Coordinates | SpeedNames | Coupled):
        return None if value is None else tuple(renaming.symbol(name) for name in value)
    if isinstance(field, OptionalText):
        return None if value is None else renaming.output(value)
    if isinstance(field, Frames):
        return FrozenMapping({name: rename_part(frame, renaming) for name, frame in value.items()})
    if isinstance(field, _BY_COORDINATE):
        return FrozenMapping({renaming.symbol(k): _rename_value(v, renaming) for k, v in value.items()})
    return _rename_value(value, renaming)


def _rename_value(value: Any, renaming: Renaming) -> Any:
    """Return a value whose formulas and addresses are renamed."""
    if isinstance(value, Formula):
        return renaming.formula(value)
    if isinstance(value, FrameRef):
        return renaming.frame(value)
    if isinstance(value, FrozenMapping):
        return FrozenMapping({k: _rename_value(v, renaming) for k, v in value.items()})
    if isinstance(value, Declared):
        return _rename_declared(value, renaming)
    if type(value) is tuple and not all(isinstance(item, str | int | float) for item in value):
        return tuple(_rename_value(item, renaming) for item in value)
    return value
