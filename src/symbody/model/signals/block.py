"""`SignalBlock`: what expands into signals, the last of which bears its name; and the roles of its gains."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, TypeAlias, dataclass_transform

from symbody.errors import nearest
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.combinators import ByName, ListOf, list_of
from symbody.model.declarations.declaration import declare
from symbody.model.declarations.element_fields import E, element
from symbody.model.declarations.field import REQUIRED, Field
from symbody.model.declarations.fields import Quantity, SymbolElementName
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import Schema
from symbody.model.element import Element
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.numeric_checks import FINITE, Demand, Domain, NumericChecks
from symbody.model.signals.signal import Signal

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


@element
class SignalBlock(Element):
    """Signals that belong together, under one name.

    Attributes
    ----------
    equation, states : str
        For the documentation: what its output is, and which states it has.
    """

    kind: ClassVar[str] = "block"
    equation: ClassVar[str]
    states: ClassVar[str]

    name: SymbolElementName = SymbolElementName("Name of the output, unique among the symbols of the model.")

    def check(self, arguments: Arguments) -> None:
        """Note numbers outside of their domains; formulas are judged when their parameters have values."""
        check = NumericChecks({})
        self.check_numbers(check, "")
        for problem in check.problems:
            arguments.add(problem.code, problem.where, problem.what, problem.why, problem.fix)

    def demands(self) -> Iterator[Demand]:
        """Yield every formula with its domain, then what several have to fulfil together."""
        for name, role in self.fields.items():
            fits = getattr(role, "fits", None)
            domain = fits if isinstance(fits, Domain) else FINITE
            sites = role.formula_sites(self, getattr(self, name), name)
            yield from (Demand(site.path, site.formula, domain) for site in sites)
        yield from self.joint_demands()

    def joint_demands(self) -> Iterator[Demand]:
        """Yield what several arguments have to fulfil together, and what depends on the others given."""
        return iter(())

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers outside of their domains, as far as parameters have values."""
        for path, formula, domain in self.demands():
            domain(check, formula, f"{label}, {path}" if label else path)

    @property
    def continuous(self) -> SignalBlock | None:
        """The block without samples; None where it has no continuous equivalent."""
        return type(self)(**{**self.given_arguments(), "sample": None})

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The signals that it stands for."""
        raise NotImplementedError


def in_brackets(formula: Formula) -> str:
    """Return a formula as part of another."""
    text = formula.text
    return text if text.isidentifier() or text.replace(".", "", 1).isdigit() else f"({text})"


def difference(high: Formula, low: Formula) -> Formula:
    """Return the formula ``high - low``."""
    return Formula.from_value(f"({high.text}) - ({low.text})")
