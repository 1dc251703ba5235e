"""The equations as formulas: SymPy matrices in the form in which books print them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from random import Random
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.curve_names import curve_functions, name_curves
from symbody.equations.outputs.frame_motion import frame_motion_entries
from symbody.equations.outputs.friction_outputs import friction_equations
from symbody.equations.outputs.joint_outputs import reaction_axes, reaction_wrench
from symbody.equations.outputs.output_roots import output_roots
from symbody.equations.outputs.signal_outputs import named_signals, signal_equations
from symbody.equations.solving.slopes import inverse_dynamics
from symbody.equations.solving.solution import solve
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.graph import Graph
from symbody.expr.opcodes import CALL
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.rewrite import substitute, symbols_of, tree_sizes
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.sympy.closed_form import ClosedForms, closed_forms, equations_between, readable
from symbody.expr.sympy.sympy_bridge import SympyEquation, SympyExpr, SympyMatrix, to_sympy
from symbody.expr.written_function import write_out
from symbody.single_flight import SingleFlight
from symbody.spatial.vector import components

EMPTY: Final[Mapping[int, int]] = MappingProxyType({})

# Equations in more speeds than this are printed on request only.
MOST_SPEEDS: Final = 8

# The outputs that properties show as formulas.
_SHOWN: Final = (
    "mass_matrix", "forcing", "constraints", "velocity_constraints", "jacobian", "position_jacobian",
    "kinetic_energy", "potential_energy", "qdot",
)  # fmt: skip
# The two sides of the equations of motion, and q' itself.
_SIDES: Final = ("inertial", "driving", "rates")


class Reaction(NamedTuple):
    """A reaction as (3, 1) matrices: force [N], moment [N m]."""

    force: SympyMatrix
    moment: SympyMatrix


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Textbook:
    """Formulas of one set of equations; all entries share one list of definitions.

    Attributes
    ----------
    formed : EquationsOfMotion
        The equations in the expression graph.
    """

    formed: EquationsOfMotion
    # Made on first request; pure functions of `formed`, so they cannot go stale.
    _roots: SingleFlight[str, Roots] = field(default_factory=SingleFlight, repr=False)
    _agreement: SingleFlight[None, None] = field(default_factory=SingleFlight, repr=False)
    _matrices: SingleFlight[str, SympyMatrix] = field(default_factory=SingleFlight, repr=False)
    _closed: SingleFlight[None, ClosedForms] = field(default_factory=SingleFlight, repr=False)

    def __repr__(self) -> str:
        return f"Textbook of {self.formed.topology.model.name!r}: the formulas of its equations"

    def matrix(self, name: str) -> SympyMatrix:
        """Return an output; written out if it is short, else in the symbols of `definitions`."""

        def write() -> SympyMatrix:
            if self._is_long(name):
                return self._long.matrices[name]
            return closed_forms(self.formed.graph, [self.side(name)], EXPAND_LIMIT).matrices[name]

        return self._matrices.get(name, write).copy()

    def derivatives(self, name: str) -> SympyMatrix:
        """Return an output that is not among those shown together; a FormulationError if it is too long."""
        if self._is_long(name):
            what = f"{name} takes more than {EXPAND_LIMIT} operations"
            fix = f"compile(eqs, {name!r}) computes it, generate_code(eqs, {name!r}) writes it"
            raise FormulationError(Problem("equations.too_long", name, what, "", fix))
        return self.matrix(name)

    def equations(self, left: str, right: str) -> list[SympyEquation]:
        """Return ``left = right``, entry by entry, unevaluated."""
        return equations_between(self.matrix(left), self.matrix(right))

    @property
    def definitions(self) -> tuple[tuple[SympyExpr, SympyExpr], ...]:
        """Pairs (z1, expression), ... that long formulas are written in, each by earlier ones."""
        return self._long.definitions if any(map(self._is_long, _SHOWN + _SIDES)) else ()

    @property
    def _long(self) -> ClosedForms:
        """All long formulas together, so that they share one list of definitions."""

        def write() -> ClosedForms:
            names = [name for name in _SHOWN + _SIDES if self._is_long(name)]
            outputs = [self.side(name) for name in names]
            return closed_forms(self.formed.graph, outputs, EXPAND_LIMIT)

        return self._closed.get(None, write)

    def _is_long(self, name: str) -> bool:
        return max(tree_sizes(self.formed.graph, self.side(name).nodes), default=0) > EXPAND_LIMIT

    def side(self, name: str) -> Roots:
        """Return an output, or a side of the equations, in the form in which people read it."""
        if name in _SIDES:
            graph = self.formed.graph
            rates = tuple(graph.symbol(symbol.derivative) for symbol in self.formed.q)
            return {"inertial": self.inertial_side, "driving": self.forcing_side()}.get(
                name, Roots(name, (len(rates),), rates)
            )
        return self.readable(name)

    def readable(self, name: str) -> Roots:
        """Return the roots of an output in the form in which people read it, checked by `check_rewriting`."""
        return self._rewritten(name, {})

    def display(self, name: str) -> Roots:
        """Return the roots of an output as `readable`, with signals that loads read by their names."""
        return self._rewritten(name, named_signals(self.formed))

    def _rewritten(self, name: str, signals: Mapping[int, int]) -> Roots:
        def rewrite() -> Roots:
            if name in ("mass_matrix", "forcing"):
                self._agreement.get(None, partial(check_dynamics, self.formed))
            roots = output_roots(self.formed, name)
            return self._rewrite(name, roots.shape, roots.nodes, signals)

        return self._roots.get(f"shown {name}" if signals else name, rewrite)

    def _rewrite(
        self, name: str, shape: tuple[int, ...], nodes: Sequence[int], signals: Mapping[int, int] = EMPTY
    ) -> Roots:
        """Return roots in the form in which people read them.

        Parameters
        ----------
        signals : mapping of node to node
            Values of signals, and the symbols that stand in their place.
        """
        formed = self.formed
        named = substitute(formed.graph, nodes, signals) if signals else nodes
        named = name_curves(formed.graph, named, curve_functions(formed.topology.model))
        formulas = readable(formed.graph, named, formed.variables.quaternions)
        values = {symbol: value for value, symbol in signals.items()}
        written = substitute(formed.graph, formulas, values) if signals else formulas
        check_rewriting(self.formed, name, nodes, written)
        return Roots(name, shape, tuple(formulas))

    @property
    def inertial_side(self) -> Roots:
        """``M u'`` in the expression graph, one root a speed."""
        graph, n = self.formed.graph, len(self.formed.u)
        accelerations = self.formed.expressions(tuple(symbol.derivative for symbol in self.formed.u))
        mass = [Expr(graph, node) for node in self.readable("mass_matrix").nodes]
        rows = [_sum_of_products(graph, mass[i * n : i * n + n], accelerations).index for i in range(n)]
        return Roots("inertial", (n,), tuple(rows))

    def forcing_side(self, *, has_signals: bool = False) -> Roots:
        """Return ``F + J^T lambda``, one root a speed; on demand signals that loads read have their names."""
        roots = self.display if has_signals else self.readable
        graph, n = self.formed.graph, len(self.formed.u)
        multipliers = self.formed.expressions(self.formed.multipliers)
        jacobian = [Expr(graph, node) for node in roots("jacobian").nodes]
        forcing = roots("forcing").nodes
        rows = [
            (Expr(graph, forcing[i]) + _sum_of_products(graph, jacobian[i::n], multipliers)).index
            for i in range(n)
        ]
        return Roots("driving", (n,), tuple(rows))

    @property
    def signal_equations(self) -> list[tuple[int, int]]:
        """What each signal is, as nodes: the rate of a state, the value of another."""
        equations = signal_equations(self.formed)
        nodes = [right.index for _, right in equations]
        shown = self._rewrite("signals", (len(nodes),), nodes).nodes
        lefts = [self.formed.graph.symbol(symbol) for symbol, _ in equations]
        return list(zip(lefts, shown, strict=True))

    @property
    def friction_equations(self) -> list[tuple[int, int]]:
        """The laws of dry friction, as nodes: the effort of each joint, and the reaction that it reads."""
        equations = friction_equations(self.formed)
        nodes = [right.index for _, right in equations]
        shown = self._rewrite("friction", (len(nodes),), nodes, named_signals(self.formed)).nodes
        return [(left.index, node) for (left, _), node in zip(equations, shown, strict=True)]

    @property
    def norms(self) -> tuple[SympyExpr, ...]:
        """The squared norms of the quaternions."""
        graph = self.formed.graph
        quaternions = self.formed.variables.quaternions
        values = [[Expr(graph, node) for node in nodes] for nodes in quaternions]
        return tuple(to_sympy(graph, [_sum_of_products(graph, four, four).index for four in values]))

    def frame_motion(self, kind: str, end: str, reference: str, resolved_in: str) -> SympyMatrix:
        """Return a motion as a matrix; see `EquationSet.frame_motion`."""
        shape, values = frame_motion_entries(self.formed, kind, end, reference, resolved_in)
        return self._matrix(f"frame {kind}", (3, 1) if shape == (3,) else shape, values)

    def reaction(self, joint: str, on: str, at: str, frame: str) -> Reaction:
        """Return a reaction as matrices; see `EquationSet.reaction`."""
        graph = self.formed.graph
        written = (
            closed_forms(graph, [side], EXPAND_LIMIT) for side in self.reaction_sides(joint, on, at, frame)
        )
        force, moment = (
            forms.matrices[name] for forms, name in zip(written, ("force", "moment"), strict=True)
        )
        return Reaction(force, moment)

    def reaction_sides(self, joint: str, on: str = "", at: str = "", frame: str = "") -> tuple[Roots, Roots]:
        """Return force and moment of a reaction by multipliers and accelerations, to be read."""
        wrench = reaction_wrench(self.formed, joint, on, at)
        tree = self.formed.kinematics.tree
        axes = self.formed.frame(frame) if frame else reaction_axes(self.formed, joint)
        parts = {"force": wrench.force, "moment": wrench.moment}
        force, moment = (
            self._rewrite(name, (3, 1), [x.index for x in components(tree, vector, axes)])
            for name, vector in parts.items()
        )
        return force, moment

    def _matrix(self, name: str, shape: tuple[int, ...], values: Sequence[Expr]) -> SympyMatrix:
        graph = self.formed.graph
        roots = self._rewrite(name, shape, [value.index for value in values])
        return closed_forms(graph, [roots], EXPAND_LIMIT).matrices[name]


def _sum_of_products(graph: Graph, row: Sequence[Expr], column: Sequence[Expr]) -> Expr:
    total = Expr(graph, 0)
    for a, b in zip(row, column, strict=True):
        total = total + a * b
    return total


# Random points at which numbers are compared, and the relative difference that rounding may reach there.
_POINTS: Final = 3
_ROUNDING: Final = 1e-6


class _Pair(NamedTuple):
    """Two nodes that should be the same function, and the place of the entry they belong to."""

    place: str
    computed: int
    shown: int


def check_rewriting(
    formed: EquationsOfMotion, name: str, computed: Sequence[int], shown: Sequence[int]
) -> None:
    """Raise if formulas are not the functions that are computed.

    Parameters
    ----------
    name : str
        The output.
    computed, shown : sequence of int
        Roots as they are compiled, and as they are shown; curves shown by name are compared by their pieces.
    """
    entries = zip(computed, write_out(formed.graph, shown), strict=True)
    _check(formed, [_Pair(f"{name}[{k}]", a, b) for k, (a, b) in enumerate(entries)])


def check_dynamics(formed: EquationsOfMotion) -> None:
    """Raise if mass matrix and forcing do not belong to the accelerations and the inverse dynamics computed.

    With friction nothing is compared: the forcing contains unknown efforts then. With constraints the solver
    of the system takes M, F, J and gamma as they are shown, and only the inverse dynamics are compared.
    """
    if formed.friction:
        return
    given = formed.expressions([u.derivative for u in formed.u])
    balance = zip(_products(formed, given), formed.dynamics.forcing, strict=True)
    sides = zip(inverse_dynamics(formed), balance, strict=True)
    pairs = [_Pair("inverse_dynamics", a.index, (b - force).index) for a, (b, force) in sides]
    _check(formed, pairs)
    if formed.rows:
        return
    try:
        udot, _ = solve(formed)
    except FormulationError:
        return  # no mass resists some speed, which has no acceleration
    solved = zip(_products(formed, udot), formed.dynamics.forcing, strict=True)
    _check(formed, [_Pair("udot", a.index, force.index) for a, force in solved])


def _products(formed: EquationsOfMotion, udot: Sequence[Expr]) -> list[Expr]:
    """Return ``M u'``."""
    return [_sum_of_products(formed.graph, row, udot) for row in formed.dynamics.mass_matrix]


def _check(formed: EquationsOfMotion, pairs: Sequence[_Pair]) -> None:
    graph = formed.graph
    pairs = [pair for pair in pairs if pair.computed != pair.shown]
    nodes = graph.reachable([node for pair in pairs for node in (pair.computed, pair.shown)])
    values = fingerprints(graph, list(nodes))
    doubtful = [pair for pair in pairs if values[pair.computed] != values[pair.shown]]
    different = list(_numerically_different(formed, doubtful))
    if different:
        what = "the formulas shown differ from the functions that are computed"
        why = "this is a bug in symbody, not a fault of the model"
        fix = "report it with the model; another formulation may work in the meantime"
        raise FormulationError(Problem("equations.views_differ", different[0].place, what, why, fix))


def _numerically_different(formed: EquationsOfMotion, pairs: Sequence[_Pair]) -> Iterator[_Pair]:
    """Return the pairs whose values differ by more than rounding at each of several random points."""
    graph, nodes = formed.graph, [node for pair in pairs for node in (pair.computed, pair.shown)]
    if not nodes or any(graph.ops[node] == CALL for node in graph.reachable(nodes)):
        return  # functions of a user's own are not called before anything is computed
    symbols = symbols_of(graph, nodes)
    places = {node: Input(str(k), "x", k) for k, node in enumerate(symbols)}
    program = build_sequence(
        graph, [Roots("", (len(nodes),), tuple(nodes))], places, merge=False, contract=False
    )
    random = Random(7)
    points = [_random_point(formed, symbols, random) for _ in range(_POINTS)]
    values = [evaluate_sequence(program, {"x": point})[0] for point in points]
    for k, pair in enumerate(pairs):
        differences = [
            abs(entries[2 * k] - entries[2 * k + 1]) > _ROUNDING * (1 + abs(entries[2 * k]))
            for entries in values
        ]
        if all(differences):  # not where a value is not a number
            yield pair


def _random_point(formed: EquationsOfMotion, symbols: Sequence[int], random: Random) -> list[float]:
    """Return a number for each symbol; quaternions have norm 1, without which rotations are none."""
    values = {node: random.uniform(0.3, 1.3) for node in symbols}
    for quaternion in formed.variables.quaternions:
        entries = [values.setdefault(node, random.uniform(0.3, 1.3)) for node in quaternion]
        norm = sum(x * x for x in entries) ** 0.5
        values |= {node: x / norm for node, x in zip(quaternion, entries, strict=True)}
    return [values[node] for node in symbols]
