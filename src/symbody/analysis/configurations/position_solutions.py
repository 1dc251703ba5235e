"""`solve_positions`: dependent coordinates as closed forms in the independent ones, all assemblies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from symbody.analysis.configurations.closed_gaps import gap_assumptions
from symbody.analysis.configurations.distinct_positions import Formulas, distinct_solutions
from symbody.analysis.scales import mechanism_scales
from symbody.arguments import checked_arguments
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.frame_motion import frame_motion_entries
from symbody.errors import AssemblyError, CompileError, FormulationError, ModelError, Problem, nearest
from symbody.expr.calculus import jacobian
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.opcodes import COS, SIN, TAN
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.solving.budget import solve_within
from symbody.expr.sympy.closed_form import readable
from symbody.expr.sympy.sympy_bridge import (
    SympyEquation,
    SympyExpr,
    nodes_from_equations,
    to_sympy,
)
from symbody.model.model import Model, resolve_parameters
from symbody.tolerances import ROOT

# Open by more, of what rows change by in moves as large as the mechanism, is not an
# assembly: a root of a squared equation.


@dataclass(frozen=True, slots=True)
class PositionSolutions:
    """All closed forms of the dependent coordinates.

    Attributes
    ----------
    dependent : tuple of SymPy functions of time
        In the order of the argument.
    branches : tuple of mapping of coordinate to expression
        One for each way to assemble the mechanism.
    notes : tuple of str
        Ropes and stops that are taken as taut and closed.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> for branch in sb.solve_positions(sb.form_equations(ladder), ["y"]).branches:
    ...     print(list(branch.values()))
    [-sqrt(25 - x(t)**2)]
    [sqrt(25 - x(t)**2)]
    """

    dependent: tuple[SympyExpr, ...]
    branches: tuple[Mapping[SympyExpr, SympyExpr], ...]
    _graph: Graph = field(repr=False)
    _constraints: tuple[int, ...] = field(repr=False)
    _values: tuple[tuple[int, ...], ...] = field(repr=False)
    _names: tuple[str, ...] = field(repr=False)
    _model: Model | None = field(repr=False)
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of branches."""
        return len(self.branches)

    @checked_arguments
    def evaluate(self, values: Mapping[object, float]) -> tuple[Mapping[str, float] | None, ...]:
        """Return the dependent coordinates of each branch by name; None where the branch does not reach.

        Parameters
        ----------
        values : mapping of symbol or name to number
            The independent coordinates, and parameters; t is 0 unless given.

        Raises
        ------
        CompileError
            If something has no value, listing all of it, or a name is unknown.
        """
        known = self._known_values(values)
        found: list[Mapping[str, float] | None] = []
        for nodes in self._values:
            numbers = _numbers(self._graph, nodes, known)
            coordinates = dict(zip(self._names, numbers, strict=True))
            found.append(coordinates if self._is_closed({**known, **coordinates}) else None)
        return tuple(found)

    def _is_closed(self, values: Mapping[str, float]) -> bool:
        """Return whether the constraints hold, each over its change in large moves."""
        graph, rows = self._graph, list(self._constraints)
        symbols = {graph.symbols[graph.left[node]].label: node for node in symbols_of(graph, rows)}
        turning = _periodic(graph, rows, list(symbols))
        lengths = [values[name] for name in symbols if name not in turning and name in values]
        size = max(map(abs, lengths), default=0.0) or 1.0
        names = [name for name in self._names if name in symbols]
        slopes = [entry for row in jacobian(graph, rows, [symbols[name] for name in names]) for entry in row]
        numbers = _numbers(graph, [*rows, *slopes], values)
        sizes = [1.0 if name in turning else size for name in names]
        for k, value in enumerate(numbers[: len(rows)]):
            own = numbers[len(rows) + k * len(names) : len(rows) + (k + 1) * len(names)]
            scale = max((abs(x) * s for x, s in zip(own, sizes, strict=True)), default=0.0) or size
            if not abs(value) <= ROOT * scale:
                return False
        return True

    @checked_arguments
    def nearest(
        self, guess: Mapping[object, float], values: Mapping[object, float]
    ) -> Mapping[SympyExpr, SympyExpr]:
        """Return the branch whose coordinates at `values` are nearest to the `guess`, angles modulo 2 pi.

        Raises
        ------
        AssemblyError
            If no branch reaches these values.
        CompileError
            If something has no value or is not a dependent coordinate.
        """
        wanted = {_name(key): float(value) for key, value in guess.items()}
        unknown = [name for name in wanted if name not in self._names]
        if unknown:
            raise CompileError(
                *(Problem("positions.guess", name, f"{name!r} is not a dependent coordinate", "",
                          nearest(name, self._names)) for name in unknown)
            )  # fmt: skip
        distances = {}
        for k, coordinates in enumerate(self.evaluate(values)):
            if coordinates is not None:
                distances[k] = sum(self._apart(name, coordinates[name], x) ** 2 for name, x in wanted.items())
        if not distances:
            listed = ", ".join(f"{_name(key)} = {value:g}" for key, value in values.items())
            raise AssemblyError(
                Problem("positions.unreachable", "positions", f"no solution exists for {listed}",
                        "the loops do not close there: a square root or an arc cosine has no real value",
                        "give independent coordinates within reach, or correct the lengths")
            )  # fmt: skip
        return self.branches[min(distances, key=distances.__getitem__)]

    def _apart(self, name: str, a: float, b: float) -> float:
        return math.remainder(a - b, 2 * math.pi) if name in self._angles else a - b

    @property
    def _angles(self) -> set[str]:
        """Names of the dependent coordinates that the constraints are periodic in."""
        return _periodic(self._graph, self._constraints, self._names)

    def _known_values(self, values: Mapping[object, float]) -> dict[str, float]:
        graph = self._graph
        nodes = [*self._constraints, *(node for row in self._values for node in row)]
        symbols = [graph.symbols[graph.left[node]] for node in symbols_of(graph, nodes)]
        needed = {symbol.label: symbol for symbol in symbols if symbol.label not in self._names}
        given = {_name(key): value for key, value in values.items()}
        defaults = _parameters(self._model, given)
        numbers = {"t": 0.0, **defaults, **given}
        missing = [name for name in needed if name not in numbers]
        problems = [
            Problem("compile.unknown_parameter", name, f"the solution does not depend on {name!r}", "",
                    nearest(name, needed))
            for name in given if name not in needed and name not in defaults and name != "t"
        ]  # fmt: skip
        if missing:
            problems.append(
                Problem("compile.missing_value", "values", f"no value is given for {', '.join(missing)}",
                        "the computation needs a number", f"give {{{missing[0]!r}: ...}}")
            )  # fmt: skip
        if problems:
            raise CompileError(*problems)
        return {name: float(numbers[name]) for name in needed}


@checked_arguments
def solve_positions(
    constraints: EquationSet | Sequence[SympyExpr | SympyEquation],
    dependent: Sequence[SympyExpr | str],
    *,
    seconds: float = 20.0,
) -> PositionSolutions:
    """Return the dependent coordinates as functions of the independent ones, in closed form.

    Planar dyads and chains of them are solved by cosines and sines, everything else by SymPy, in a process
    that is stopped when the time is up.

    Parameters
    ----------
    constraints : EquationSet or sequence of SymPy expressions
        The position constraints, each equal to 0.
    dependent : sequence of coordinates or names
        As many as there are constraints.
    seconds : float
        The time allowed [s].

    Returns
    -------
    PositionSolutions
        All ``branches``, each a mapping of a dependent coordinate to its formula.

    Raises
    ------
    FormulationError
        If there are not as many dependent coordinates as constraints, one of them appears in no constraint,
        no closed form is found, or none within the time.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> len(sb.solve_positions(eqs, ["y"]).branches)
    2
    """
    names = [_name(item) for item in dependent]
    notes: tuple[str, ...] = ()
    if isinstance(constraints, EquationSet):
        notes = gap_assumptions(constraints)
        model, graph = constraints.model, constraints.formed.graph
        rows = [row.value.index for row in constraints.formed.holonomic]
    else:
        model, graph = None, Graph()
        rows = nodes_from_equations(constraints, graph)
    unknowns = _unknowns(graph, rows, names)
    if not seconds > 0.0:
        raise FormulationError(
            Problem("positions.seconds", "seconds", f"seconds = {seconds!r} is not a valid time", "",
                    "give seconds > 0")
        )  # fmt: skip
    solutions = solve_within(graph, rows, unknowns, seconds)
    if not solutions:
        raise FormulationError(
            Problem("positions.none", "positions", "no closed form was found",
                    "the equations contradict each other, depend on each other, or have no solution in "
                    "roots and inverse trigonometric functions",
                    "choose other dependent coordinates, or solve with numbers by assemble()")
        )  # fmt: skip
    forms = _formulas(constraints, graph, rows, unknowns, solutions)
    kept = tuple(tuple(solutions[k]) for k in distinct_solutions(forms))
    formulas = iter(to_sympy(graph, readable(graph, [node for row in kept for node in row])))
    coordinates = tuple(to_sympy(graph, unknowns))
    branches = tuple({name: next(formulas) for name in coordinates} for _ in kept)
    return PositionSolutions(coordinates, branches, graph, tuple(rows), kept, tuple(names), model, notes)


def _formulas(
    constraints: EquationSet | Sequence[SympyExpr | SympyEquation],
    graph: Graph,
    rows: Sequence[int],
    unknowns: Sequence[int],
    solutions: Sequence[Sequence[int]],
) -> Formulas:
    """Return the solutions with what distinguishes them: the placements of bodies, for a model."""
    placements: tuple[int, ...] = ()
    values: dict[str, float] = {}
    length = None
    if isinstance(constraints, EquationSet):
        formed = constraints.formed
        names = [body.name for body in constraints.model.bodies if body.name in formed.kinematics.velocities]
        frames = [frame_motion_entries(formed, kind, name, "ground")[1] for name in names for kind in "rR"]
        placements = tuple(entry.index for entries in frames for entry in entries)
        values = _parameters(constraints.model, {})
        length = mechanism_scales(constraints, {}).length if values else None
    turning = _rotation_symbols(graph, (*rows, *placements))
    rows, unknowns, branches = tuple(rows), tuple(unknowns), tuple(map(tuple, solutions))
    return Formulas(graph, rows, unknowns, turning, branches, placements, values, length)


def _unknowns(graph: Graph, rows: Sequence[int], names: Sequence[str]) -> list[int]:
    """Return the nodes of the dependent coordinates."""
    nodes = {}
    for node in symbols_of(graph, rows):
        symbol = graph.symbols[graph.left[node]]
        if symbol.kind == SymbolKind.COORDINATE:
            nodes[symbol.label] = node
    problems = [
        Problem("positions.dependent", name, f"{name!r} appears in no constraint", "", nearest(name, nodes))
        for name in names if name not in nodes
    ]  # fmt: skip
    problems += [
        Problem("positions.dependent", name, f"{name!r} is given twice", "", "name each coordinate once")
        for name in dict.fromkeys(names) if names.count(name) > 1
    ]  # fmt: skip
    if len(names) != len(rows):
        problems.append(
            Problem("positions.number", "dependent",
                    f"{len(names)} dependent coordinates are named for {len(rows)} constraints",
                    "each constraint determines one dependent coordinate; the others are independent",
                    f"name {len(rows)} of {', '.join(nodes)}")
        )  # fmt: skip
    if problems:
        raise FormulationError(*problems)
    return [nodes[name] for name in names]


def _name(item: object) -> str:
    """Return the name of a SymPy symbol, of a function of time, or of what is a name already."""
    return str(item).removesuffix("(t)")


def _parameters(model: Model | None, given: Mapping[str, float]) -> dict[str, float]:
    """Return the values of a model's parameters, as far as all of them have values."""
    if model is None:
        return {}
    own = {name: value for name, value in given.items() if name in model.parameters}
    try:
        return {name: float(value) for name, value in resolve_parameters(model, own).items()}
    except ModelError:
        return {}


def _numbers(graph: Graph, nodes: Sequence[int], known: Mapping[str, float]) -> list[float]:
    """Return the values of nodes; what is not real is not a number."""
    names = list(known)
    symbols = {graph.symbols[graph.left[node]].label: node for node in symbols_of(graph, nodes)}
    places = {node: Input(name, "q", names.index(name)) for name, node in symbols.items()}
    sequence = build_sequence(graph, [Roots("values", (len(nodes),), tuple(nodes))], places)
    return [float(value) for value in evaluate_sequence(sequence, {"q": list(known.values())})[0]]


def _periodic(graph: Graph, rows: Sequence[int], names: Sequence[str]) -> set[str]:
    """Return the names of coordinates that stand inside sines and cosines."""
    return {graph.symbols[graph.left[node]].label for node in _rotation_symbols(graph, rows)}.intersection(
        names
    )


def _rotation_symbols(graph: Graph, rows: Sequence[int]) -> frozenset[int]:
    """Return the symbols that stand inside sines and cosines."""
    inside = [node for node in graph.reachable(rows) if graph.ops[node] in (SIN, COS, TAN)]
    return frozenset(symbols_of(graph, [graph.left[node] for node in inside]))
