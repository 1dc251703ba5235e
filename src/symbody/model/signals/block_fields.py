"""The roles that arguments of blocks have: gains by name, limits, coefficients, matrices."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, dataclass_transform

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.declaration import Field, declare
from symbody.model.declarations.element_fields import E
from symbody.model.declarations.fields import Quantity, SymbolElementName, read_list
from symbody.model.declarations.formula_site import FormulaSite, Scope
from symbody.model.frozen_mapping import FrozenMapping

Rows = tuple[tuple[Formula, ...], ...]


@dataclass(frozen=True, eq=False, repr=False)
class NamedGains(Field[Mapping[str, Value], FrozenMapping[Formula]]):
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
    words: tuple[str, ...] = ()

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> FrozenMapping[Formula]:
        """Return the gains."""
        gains = arguments.table(value, path, arguments.formula)
        for name in gains:
            if name not in self.words:
                cure = nearest(name, self.words)
                arguments.add("block.unknown_gain", f"{path}.{name}", f"there is no gain {name!r}", "", cure)
        return gains

    def formula_sites(self, owner: object, value: Mapping[str, Formula], path: str) -> Iterator[FormulaSite]:
        """Return where the gains stand."""
        return (FormulaSite(f"{path}.{name}", gain, Scope.LOAD) for name, gain in value.items())


@dataclass(frozen=True, eq=False, repr=False)
class OutputLimits(Field[Iterable[Value] | None, tuple[Formula, ...] | None]):
    """The lowest and the highest value of an output, or none."""

    role: ClassVar[str] = "limits"
    takes: ClassVar[str] = "(2,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value] | None"

    _: KW_ONLY
    default: Any = None

    def read(
        self, owner: object, arguments: Arguments, value: object, path: str
    ) -> tuple[Formula, ...] | None:
        """Return two formulas, or None for None."""
        if value is None:
            return None
        why = "the first is the lower limit, the second the upper"
        items = read_list(arguments, value, path, 2, "limits", why, 'write limits = ["-Tmax", "Tmax"]')
        return tuple(arguments.formula(item, f"{path}[{k}]") for k, item in enumerate(items or (0, 0)))

    def formula_sites(
        self, owner: object, value: tuple[Formula, ...] | None, path: str
    ) -> Iterator[FormulaSite]:
        """Return where the limits stand."""
        return (FormulaSite(f"{path}[{k}]", limit, Scope.LOAD) for k, limit in enumerate(value or ()))


@dataclass(frozen=True, eq=False, repr=False)
class Coefficients(Field[Iterable[Value], tuple[Formula, ...]]):
    """A list of numbers or formulas."""

    role: ClassVar[str] = "coefficients"
    takes: ClassVar[str] = "(n,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    _: KW_ONLY
    scope: Scope = Scope.CONSTANT

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Formula, ...]:
        """Return the formulas."""
        items = arguments.items(value, path)
        return tuple(arguments.formula(item, f"{path}[{k}]") for k, item in enumerate(items))

    def formula_sites(self, owner: object, value: tuple[Formula, ...], path: str) -> Iterator[FormulaSite]:
        """Return where they stand."""
        return (FormulaSite(f"{path}[{k}]", entry, self.scope) for k, entry in enumerate(value))


class MatrixRows(Field[Iterable[Iterable[Value]], Rows]):
    """A matrix, row by row."""

    role: ClassVar[str] = "matrix"
    takes: ClassVar[str] = "(n, m) number or formula"
    annotation: ClassVar[str] = "Iterable[Iterable[Value]]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Rows:
        """Return the rows."""
        rows = []
        for i, row in enumerate(arguments.items(value, path)):
            items = arguments.items(row, f"{path}[{i}]")
            rows.append(tuple(arguments.formula(item, f"{path}[{i}][{j}]") for j, item in enumerate(items)))
        return tuple(rows)

    def formula_sites(self, owner: object, value: Rows, path: str) -> Iterator[FormulaSite]:
        """Return where the entries stand."""
        for i, row in enumerate(value):
            for j, entry in enumerate(row):
                yield FormulaSite(f"{path}[{i}][{j}]", entry, Scope.CONSTANT)


@dataclass_transform(
    field_specifiers=(Field, Quantity, SymbolElementName, NamedGains, OutputLimits, Coefficients, MatrixRows)
)
def block(kind: type[E]) -> type[E]:
    """Return a class as a block that declares its arguments by the roles of this file and of `fields`."""
    return declare(kind)
