"""Which elements read names that others bring: the wires of the diagram, as formulas are read."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

from symbody.builder.formulas import formula_texts
from symbody.errors import SymbodyError
from symbody.expr.language.formula import Formula
from symbody.formats.schema import VERSION, check_structure
from symbody.model.body import Body
from symbody.model.checks.structure import free_joints
from symbody.model.checks.symbols import Meaning, element_entries, joint_entries
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.model import KINDS
from symbody.model.naming import GROUND
from symbody.model.output_arguments import OutputScope, make_scope
from symbody.model.output_names import read_output
from symbody.model.registry import read_element
from symbody.model.signals.signal import Signal

Wire = dict[str, Any]

# Words that begin a group of names; those after them, until the next, are derivatives of the same.
_FIRST: Final = frozenset({"coordinate", "speed", "signal"})
_PART: Final = "include"


@dataclass(frozen=True, slots=True)
class Sources:
    """Where names come from.

    Attributes
    ----------
    symbols : mapping of name to (pointer, name)
        What brings a symbol, and the symbol whose rate it is, or itself.
    elements : mapping of name to pointer
        Elements, which names of outputs contain.
    parts : mapping of prefix to pointer
        Included files; what they bring begins with their prefix.
    scope : OutputScope
        What names of outputs refer to.
    """

    symbols: Mapping[str, tuple[str, str]]
    elements: Mapping[str, str]
    parts: Mapping[str, str]
    scope: OutputScope

    def of_symbol(self, name: str) -> tuple[str, str] | None:
        """Return what brings a symbol, None of parameters and of what nothing brings."""
        return self.symbols.get(name) or self._of_part(name)

    def of_address(self, word: str) -> tuple[str, str] | None:
        """Return the element of a word in the name of an output, such as ``arm.tip``."""
        name = word.partition(".")[0]
        pointer = self.elements.get(name)
        return (pointer, name) if pointer is not None else self.of_symbol(name)

    def _of_part(self, name: str) -> tuple[str, str] | None:
        fitting = [prefix for prefix in self.parts if name.startswith(f"{prefix}_")]
        return (self.parts[max(fitting, key=len)], name) if fitting else None


def model_wires(data: Mapping[str, Any]) -> list[Wire]:
    """Return who reads what of whom, in the order of the readers.

    A wire has ``source`` and ``target``, pointers such as ``"/signal/0"`` or ``"/inputs/1"``; ``names``, as
    the formulas of the target write them; and ``roots``, the symbols whose rates they are, or themselves.
    Entries that are no elements yet are read as far as their formulas are some.
    """
    sources = find_sources(data)
    wires: dict[tuple[str, str], Wire] = {}
    for kind in (*KINDS, _PART):
        for k, entry in enumerate(_entries(data, kind)):
            target = f"/{kind}/{k}"
            for name, (source, root) in _readings(kind, entry, sources):
                if source == target:
                    continue
                wire = wires.setdefault(
                    (source, target), {"source": source, "target": target, "names": [], "roots": []}
                )
                if name not in wire["names"]:
                    wire["names"].append(name)
                    wire["roots"].append(root)
    return list(wires.values())


def find_sources(data: Mapping[str, Any]) -> Sources:
    """Return what the entries of a model bring; of two with one name the first counts."""
    symbols: dict[str, tuple[str, str]] = {}
    elements: dict[str, str] = {}
    complete: list[Element] = []
    for kind in KINDS:
        for k, entry in enumerate(_entries(data, kind)):
            pointer = f"/{kind}/{k}"
            elements.setdefault(str(entry.get("name")), pointer)
            element = _element_of(kind, entry)
            complete += [] if element is None else [element]
            for name, root in _symbols_of(kind, entry, element):
                symbols.setdefault(name, (pointer, root))
    for joint in _free_joints(data):
        for name, root in _with_roots(joint_entries(joint, "")):
            symbols.setdefault(name, (elements[joint.name], root))
    inputs = data.get("inputs")
    for k, name in enumerate(inputs if isinstance(inputs, list) else []):
        symbols.setdefault(str(name), (f"/inputs/{k}", str(name)))
    parts = {str(entry.get("prefix")): f"/{_PART}/{k}" for k, entry in enumerate(_entries(data, _PART))}
    bodies = [each for each in complete if isinstance(each, Body)]
    return Sources(symbols, elements, parts, make_scope(complete, bodies, {}))


def _symbols_of(kind: str, entry: Mapping[str, Any], element: Element | None) -> Iterator[tuple[str, str]]:
    """Yield the symbols that an element brings, each with its root; of what is none yet, its name."""
    if element is not None and kind != "table":
        yield from _with_roots(element_entries(element, ""))
    elif kind in ("signal", "block", "table"):
        yield str(entry.get("name")), str(entry.get("name"))


def _with_roots(entries: Iterable[tuple[str, Meaning]]) -> Iterator[tuple[str, str]]:
    root = ""
    for name, meaning in entries:
        root = name if meaning.word in _FIRST else root
        yield name, root


def _free_joints(data: Mapping[str, Any]) -> list[Joint]:
    """Return the joints that stand for the motion of bodies without one."""
    read = {kind: [_element_of(kind, entry) for entry in _entries(data, kind)] for kind in ("body", "joint")}
    bodies = [each for each in read["body"] if isinstance(each, Body)]
    joints = [each for each in read["joint"] if isinstance(each, Joint)]
    return free_joints(bodies, joints) if len(joints) == len(read["joint"]) else []


def _readings(kind: str, entry: Mapping[str, Any], sources: Sources) -> Iterator[tuple[str, tuple[str, str]]]:
    """Yield the names that an entry reads and that something brings, each with its source and root."""
    for name in _names(kind, entry):
        source = sources.of_symbol(name)
        if source is not None:
            yield name, source
    element = _element_of(kind, entry)
    if isinstance(element, Signal) and element.output is not None:
        for word in _addresses(element.output, sources.scope):
            address = sources.of_address(word)
            if address is not None and word != GROUND:
                yield word, address


def _addresses(output: str, scope: OutputScope) -> Iterator[str]:
    """Yield what the name of an output, or an expression of outputs, reads."""
    asked = read_output(output, scope)
    if asked is not None:
        yield from asked.addresses
        return
    try:
        formula = Formula.from_value(output, has_outputs=True)
    except SymbodyError:
        return  # its field says what is wrong
    yield from formula.names
    for inner in formula.outputs:
        yield from _addresses(inner, scope)


def _names(kind: str, entry: Mapping[str, Any]) -> Iterator[str]:
    element = _element_of(kind, entry)
    if element is not None:
        for site in element.formula_sites():
            yield from (name for name in site.formula.names if name not in site.local_names)
        return
    parts = {"table": ("argument",), _PART: ("connect", "parameters")}.get(kind)
    texts = entry if parts is None else {key: entry[key] for key in parts if key in entry}
    for _, text in formula_texts({**texts, "output": None}, ""):
        try:
            yield from Formula.from_value(text).names
        except SymbodyError:
            continue  # its field says what is wrong


def _entries(data: Mapping[str, Any], kind: str) -> list[Mapping[str, Any]]:
    entries = data.get(kind)
    usable = isinstance(entries, list) and all(isinstance(entry, Mapping) for entry in entries)
    return list(entries) if usable and isinstance(entries, list) else []


def _element_of(kind: str, entry: Mapping[str, Any]) -> Element | None:
    """Return the element of an entry, None where it is not complete, or its content stands in a file."""
    if kind not in KINDS or kind == "table":
        return None
    return _read(kind, json.dumps(entry, sort_keys=True))


@lru_cache(maxsize=4096)  # a check follows each change, of which most leave all entries but one as they are
def _read(kind: str, text: str) -> Element | None:
    try:
        entry = {key: value for key, value in json.loads(text).items() if value is not None}
        check_structure({"version": VERSION, "name": "entry", kind: [entry]}, lambda path: "")
        return read_element(kind, entry)
    except SymbodyError:
        return None
