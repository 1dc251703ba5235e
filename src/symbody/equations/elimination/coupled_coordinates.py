"""Couplings that give a coordinate outright: it is substituted, and the coupling is no constraint.

A coupling of first degree with constant factors, ``sum of c_j q_j + o = 0``, is solved for one of its
coordinates, and those that follow from other couplings are put in (Gauss-Jordan). With all coordinates
``q = W q_i + o`` and W constant, speeds and accelerations are ``u = W u_i``, ``u' = W u_i'``, so that the
equations are ``W^T M W u_i' = W^T F``: a joint whose motion is a function of the speed of another adds to the
equations of that speed by projection (Featherstone 2008, chapters 3 and 9; Jain 2011).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final, NamedTuple

from symbody.equations.constraints.couplings import coupling_value
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placements import fold_zeros
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import substitute, symbols_of
from symbody.model.constraints.couplings import (
    Belt,
    Constraint,
    Differential,
    Gear,
    JointCoupling,
    RackPinion,
)
from symbody.model.element import Element
from symbody.model.model import Model
from symbody.single_flight import SingleFlight


@dataclass(frozen=True, slots=True)
class CoupledCoordinates:
    """Coordinates that follow from others by couplings of first degree.

    Attributes
    ----------
    values : mapping of coordinate to Expr
        Each in independent coordinates and parameters.
    combinations : mapping of coordinate to mapping of multiplier to Expr
        How much of each coupling, as it is written, adds up to ``coordinate - value = 0``.
    leaders : mapping of coordinate to (coordinate, Expr, Expr)
        Of each that follows from one other, this coordinate, the factor of it and the rest.
    divisors : mapping of coordinate to Expr
        Factors in parameters that were divided by.
    notes : tuple of str
        What was substituted, and which couplings stay constraints.
    rows : tuple of ConstraintEquation
        The couplings; they are not among the constraints.
    unsubstituted : SingleFlight
        The same equations with the couplings as constraints, once something has formed them.
    """

    values: Mapping[str, Expr]
    combinations: Mapping[str, Mapping[str, Expr]]
    leaders: Mapping[str, tuple[str, Expr, Expr]] = field(default_factory=dict)
    divisors: Mapping[str, Expr] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    rows: tuple[ConstraintEquation, ...] = ()
    unsubstituted: SingleFlight[None, Any] = field(default_factory=SingleFlight, repr=False, compare=False)

    @property
    def multiplier_names(self) -> frozenset[str]:
        """The multipliers of the couplings."""
        return frozenset(name for shares in self.combinations.values() for name in shares)

    def sources(self, coordinate: str) -> tuple[str, ...]:
        """Return the coordinates that give another one; () for one that no coupling gives."""
        value = self.values.get(coordinate)
        if value is None:
            return ()
        graph = value.graph
        symbols = (graph.symbols[graph.left[node]] for node in symbols_of(graph, [value.index]))
        return tuple(symbol.label for symbol in symbols if _is_coordinate(symbol))

    def assign_roles(self, roles: Sequence[JointRole]) -> tuple[JointRole, ...]:
        """Return the roles of joints whose substituted coordinates are not in q."""
        return tuple(
            replace(role, substituted=tuple(name for name in role.joint.coordinates if name in self.values))
            for role in roles
        )

    def take_rows(
        self, rows: Sequence[ConstraintEquation]
    ) -> tuple[CoupledCoordinates, list[ConstraintEquation]]:
        """Return the coordinates with the rows of their couplings, and the rows that are left."""
        names = self.multiplier_names
        taken = tuple(row for row in rows if row.name in names)
        return replace(self, rows=taken), [row for row in rows if row.name not in names]


# Of a factor, what is left of it where two couplings say the same with typed digits.
_ROUNDING: Final = 1e-12

NONE_COUPLED: Final = CoupledCoordinates({}, {})


@dataclass(frozen=True, slots=True)
class _LinearForm:
    """``sum of factors times coordinates + offset = 0``, and what it is made of."""

    factors: Mapping[str, Expr]
    offset: Expr
    sources: Mapping[str, Expr] = field(default_factory=dict)

    def subtract(self, other: _LinearForm, share: Expr) -> _LinearForm:
        """Return the form less a multiple of another, without factors that vanish."""
        factors, sources = (
            _clear(_less(mine, its, share))
            for mine, its in ((self.factors, other.factors), (self.sources, other.sources))
        )
        return _LinearForm(factors, self.offset - other.offset * share, sources)

    def divide(self, pivot: Expr) -> _LinearForm:
        """Return the form over one of its factors."""
        factors, sources = (
            {name: x / pivot for name, x in group.items()} for group in (self.factors, self.sources)
        )
        return _LinearForm(factors, self.offset / pivot, sources)


def solve_couplings(model: Model, names: Names, roles: Sequence[JointRole]) -> CoupledCoordinates:
    """Return the coordinates that couplings of first degree with constant factors give.

    The first coordinate with the factor 1 or -1 is taken, else the first whose factor is a number, else the
    first whose factor stands in the coupling as it is, and so must not be 0. Couplings that together leave
    factors which are differences of parameters stay constraints: where these differ by rounding alone, what
    is left would hold the mechanism.

    Parameters
    ----------
    names : Names
        With prescribed motions, before any rates.
    """
    free, inside = _substitutable(roles), {name for role in roles for name in role.coordinates}
    inside.update(name for condition in model.constraints for name in condition.coordinates)
    forms: dict[str, _LinearForm] = {}
    left: dict[str, str] = {}
    for condition in model.constraints:
        equations = _EQUATIONS.get(type(condition))
        for label, value, read in () if equations is None else equations(names, condition):
            form, obstacle = _linear_form(names.graph, value, read, inside)
            place = f"constraint {condition.name}: {label} remains a constraint"
            left[label] = f"{place}, because {obstacle}"
            if form is not None:
                forms[label] = replace(form, sources={label: number(names.graph, 1)})
                left[label] = place
    given = _solve(forms, free)
    while given.doubtful:
        for label in given.doubtful:
            left[label] += f", because {_DOUBTFUL.format(', '.join(given.doubtful))}"
            del forms[label]
        given = _solve(forms, free)
    coupled = _coupled_coordinates(names, given.solved)
    stay = [left[label] for label in left if label not in forms]
    stay += [f"{left[label]}, because {reason}" for label, reason in given.left.items()]
    return replace(coupled, divisors=given.divisors, notes=(*coupled.notes, *stay))


_DOUBTFUL: Final = "{} together lead to factors that are differences of parameters and may vanish"


class _Solution(NamedTuple):
    """Forms that are solved for a coordinate each, by it; factors divided by; labels left, with reasons."""

    solved: dict[str, _LinearForm]
    divisors: dict[str, Expr]
    left: dict[str, str]
    doubtful: tuple[str, ...] = ()


def _solve(forms: Mapping[str, _LinearForm], free: set[str]) -> _Solution:
    """Solve forms in turn; the labels of those that together leave doubtful factors end it."""
    given = _Solution({}, {}, {})
    for label, written in forms.items():
        form = _reduce(written, given.solved)
        pivot = _pivot(form, written.factors, free)
        if pivot is not None:
            if form.factors[pivot].number is None:
                given.divisors[pivot] = form.factors[pivot]
            _enter(given.solved, pivot, form.divide(form.factors[pivot]))
        elif form.factors and _pivot(form, written.factors, set(form.factors)) is None:
            return given._replace(doubtful=tuple(name for name in forms if name in form.sources))
        elif form.factors:
            listed = ", ".join(form.factors)
            given.left[label] = (
                f"none of {listed} is a coordinate of a joint in the tree whose rate is a speed"
            )
    return given


def _reduce(form: _LinearForm, solved: Mapping[str, _LinearForm]) -> _LinearForm:
    """Return a form in coordinates that are not solved for."""
    for name in [name for name in form.factors if name in solved]:
        form = form.subtract(solved[name], form.factors[name])
    return form


def _enter(solved: dict[str, _LinearForm], pivot: str, form: _LinearForm) -> None:
    """Enter a form that is solved for a coordinate, and take this out of the others."""
    for name, other in solved.items():
        if pivot in other.factors:
            solved[name] = other.subtract(form, other.factors[pivot])
    solved[pivot] = form


def _coupled_coordinates(names: Names, solved: Mapping[str, _LinearForm]) -> CoupledCoordinates:
    """Return the values of coordinates and the combinations that give them."""
    values, leaders = {}, {}
    for name, form in solved.items():
        value = -form.offset
        others = {other: -factor for other, factor in form.factors.items() if other != name}
        for other, factor in others.items():
            value = value + factor * names.value(other)
        values[name] = value
        if len(others) == 1:
            ((leader, factor),) = others.items()
            leaders[name] = (leader, factor, -form.offset)
    combinations = {name: form.sources for name, form in solved.items()}
    notes = tuple(
        f"{name} = {to_text(names.graph, value.index)} is substituted, from "
        f"{', '.join(combinations[name])}; all of them remain available as outputs"
        for name, value in values.items()
    )
    return CoupledCoordinates(values, combinations, leaders, notes=notes)


def _coupling_equation(names: Names, coupling: JointCoupling) -> Iterator[_Equation]:
    yield f"lambda_{coupling.name}_1", coupling_value(names, coupling), coupling.coupled


def _written_equations(names: Names, constraint: Constraint) -> Iterator[_Equation]:
    for k, formula in enumerate(constraint.equations, start=1):
        value = names.expression(formula, f"constraint {constraint.name}")
        yield f"lambda_{constraint.name}_{k}", value, formula.names


# Multiplier, left-hand side and names read, in their order, of equations in coordinates.
_Equation = tuple[str, Expr, tuple[str, ...]]

# Each function takes the class it stands beside.
_EQUATIONS: Final[Mapping[type[Element], Callable[[Names, Any], Iterator[_Equation]]]] = {
    Gear: _coupling_equation,
    RackPinion: _coupling_equation,
    Belt: _coupling_equation,
    Differential: _coupling_equation,
    Constraint: _written_equations,
}


def _linear_form(
    graph: Graph, value: Expr, read: Sequence[str], inside: set[str]
) -> tuple[_LinearForm | None, str]:
    """Return an equation as a form in coordinates, in the order they are read, or None and why it is none."""
    symbols = {graph.symbols[graph.left[node]]: node for node in symbols_of(graph, [value.index])}
    nodes = {s.label: node for s, node in symbols.items() if _is_coordinate(s)}
    coordinates = {name: nodes[name] for name in read if name in nodes}
    others = {s.kind for s in symbols if not _is_coordinate(s)}
    if SymbolKind.TIME in others:
        return None, "it depends on time"
    if others & {SymbolKind.COORDINATE, SymbolKind.SPEED}:
        return None, "it constrains velocities"
    if others - {SymbolKind.PARAMETER}:
        return None, "it reads inputs or signals"
    cut = [name for name in coordinates if name not in inside]
    if cut:
        return None, f"the joint of {cut[0]} is cut"
    by = list(coordinates.values())
    slopes = fold_zeros(graph, [Expr(graph, node) for node in gradient(graph, value.index, by)])
    kinds = {graph.symbols[graph.left[x]].kind for x in symbols_of(graph, [s.index for s in slopes])}
    if kinds - {SymbolKind.PARAMETER}:
        return None, "it is not linear in the coordinates"
    offset = Expr(graph, substitute(graph, [value.index], dict.fromkeys(by, 0))[0])
    factors = {name: slope for name, slope in zip(coordinates, slopes, strict=True) if not slope.is_zero}
    return _LinearForm(factors, offset), ""


def _is_coordinate(symbol: Symbol) -> bool:
    return symbol.kind is SymbolKind.COORDINATE and symbol.order == 0


def _substitutable(roles: Sequence[JointRole]) -> set[str]:
    """Return the coordinates of joints in the trees whose rates are their speeds."""
    found = set()
    for role in roles:
        joint = role.joint
        parts = {part for _, part in role.quasi_speeds}
        for name in role.unknown_coordinates:
            part = "rotation" if name in joint.rotation_coordinates else "translation"
            if role.is_branch(name) and part not in parts and name not in joint.motions:
                found.add(name)
    return found


def _pivot(form: _LinearForm, written: Mapping[str, Expr], free: set[str]) -> str | None:
    """Return the coordinate that a form is solved for."""
    candidates = {name: form.factors[name] for name in form.factors if name in free}
    numbers = {name: x.number for name, x in candidates.items() if x.number is not None}
    units = [name for name, x in numbers.items() if abs(x) == 1]
    as_written = [name for name, x in candidates.items() if x == written.get(name)]
    return next(iter((*units, *numbers, *as_written)), None)


def _less(mine: Mapping[str, Expr], its: Mapping[str, Expr], share: Expr) -> dict[str, Expr]:
    total = dict(mine)
    for name, x in its.items():
        if name not in total:
            total[name] = -(x * share)
        else:
            rest = total[name] - x * share
            total[name] = rest * 0 if _is_rounding(rest, total[name]) else rest
    return total


def _is_rounding(rest: Expr, whole: Expr) -> bool:
    a, b = rest.number, whole.number
    return a is not None and b is not None and abs(float(a)) <= _ROUNDING * abs(float(b))


def _clear(factors: Mapping[str, Expr]) -> dict[str, Expr]:
    """Return factors without those that vanish identically."""
    if not factors:
        return {}
    graph = next(iter(factors.values())).graph
    cleared = fold_zeros(graph, list(factors.values()))
    return {name: x for name, x in zip(factors, cleared, strict=True) if not x.is_zero}
