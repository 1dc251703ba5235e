"""The role that gains of blocks have, and which roles blocks are declared with."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, TypeAlias, dataclass_transform

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import ByName, ListOf, list_of
from symbody.model.declarations.declaration import declare
from symbody.model.declarations.element_fields import E
from symbody.model.declarations.field import REQUIRED, Field
from symbody.model.declarations.fields import Quantity, SymbolElementName
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import Schema
from symbody.model.frozen_mapping import FrozenMapping

Rows = tuple[tuple[Formula, ...], ...]
FormulaRows: TypeAlias = ListOf[Iterable[Iterable[Value]], Rows]


@dataclass(frozen=True, eq=False, repr=False)
class NamedGains(ByName[Mapping[str, Value], Formula]):
    """Gains by name.

    Attributes
    ----------
    words : tuple of str
        The names there are.
    """

    role: ClassVar[str] = "gains"
    takes: ClassVar[str] = "mapping of str to number or formula"
    annotation: ClassVar[str] = "Mapping[str, Value]"

    _: KW_ONLY
    default: Any = REQUIRED
    item: Any = field(default_factory=lambda: Quantity(scope=Scope.LOAD))
    words: tuple[str, ...] = ()

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> FrozenMapping[Formula]:
        """Return the gains."""
        gains = arguments.table(value, path, arguments.formula)
        for name in gains:
            if name not in self.words:
                cure = nearest(name, self.words)
                arguments.add("block.unknown_gain", f"{path}.{name}", f"there is no gain {name!r}", "", cure)
        return gains

    def schema(self) -> Schema:
        """Return an object with these names only."""
        return {**ByName.schema(self), "propertyNames": {"enum": [*self.words]}}


@dataclass_transform(field_specifiers=(Field, Quantity, SymbolElementName, NamedGains, list_of))
def block(kind: type[E]) -> type[E]:
    """Return a class as a block that declares its arguments by the roles of this file and of `fields`."""
    return declare(kind)
