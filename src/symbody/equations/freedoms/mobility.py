"""Degrees of freedom: the dimension of the branch of configurations on which the initial values lie.

The rank of J is not that of its formulas: a loop that only just fits moves although a count of its rows
says otherwise (Bennett, Bricard), and at a change point it drops for an instant. So the constraints are
closed near the initial values, and the branch that leads on from there is explored; see `symbody.manifold`.
Constraints on velocities alone take away as many freedoms as they have independent rows on this branch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from random import Random
from typing import Any, Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.output_roots import output_roots
from symbody.equations.outputs.units import output_units
from symbody.equations.solving.negligible_constraints import drop_negligible, input_places
from symbody.equations.solving.parameter_constraints import check_parameter_constraints
from symbody.errors import AssemblyError, Problem
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Roots, build_sequence
from symbody.expr.sequences.sequence import Sequence as Program
from symbody.manifold import (
    ConfigurationBranch,
    ConstraintManifold,
    constraint_manifold,
    explore_branch,
    independent_columns,
    rank,
)
from symbody.model.lengths import model_lengths
from symbody.model.model import resolve_parameters
from symbody.tolerances import ALIGNED

# Spreads of starts about the initial values, in rad and in the mechanism's own length.
_NEAR: Final = 0.3
_STARTS: Final = (0.0,) + (_NEAR,) * 7 + (1.0,) * 8 + (math.pi,) * 8
_FAR_STARTS: Final = (0.0,) + (_NEAR,) * 7 + (math.pi,) * 8


@dataclass(frozen=True, slots=True)
class Mobility:
    """How a mechanism can move from its initial values.

    Attributes
    ----------
    degrees_of_freedom : int
        Dimension of the branch, less independent constraints on velocities alone.
    instantaneous : int
        Independent speeds at the assembled initial values themselves; more than these at a change point.
    independent_speeds : tuple of int
        Speeds that determine all others on the branch, the earliest possible.
    notes : tuple of str
        Where the two counts differ, where branches of several dimensions meet, and what stays undecided.
    """

    degrees_of_freedom: int
    instantaneous: int
    independent_speeds: tuple[int, ...]
    notes: tuple[str, ...] = ()


def mobility(formed: EquationsOfMotion) -> Mobility:
    """Return how a mechanism can move, with the model's values of the parameters.

    Raises
    ------
    AssemblyError
        If the loops close from no start.
    ModelError
        If a parameter has no value.
    """
    n = len(formed.u)
    if not formed.rows:
        return Mobility(n, n, tuple(range(n)))
    resolved = _parameter_values(formed)
    check_parameter_constraints(formed, resolved)
    loops = _Loops(drop_negligible(formed, resolved), resolved)
    q = next(loops.closed_configurations(_STARTS), None)
    if q is None:
        raise _assembly_error(formed)
    return count_freedoms(formed, explore_branch(loops.manifold, q), loops.velocity_rows)


def count_freedoms(
    formed: EquationsOfMotion, branch: ConfigurationBranch, velocity_rows: Callable[[Any], Any]
) -> Mobility:
    """Return the freedoms on a branch of configurations.

    Parameters
    ----------
    velocity_rows : callable
        From a configuration to J, scaled.
    """
    rows, here = velocity_rows(generic_point(branch, velocity_rows)), velocity_rows(branch.q)
    # Each speed that was eliminated stands for a constraint on velocities that is among the rows no more.
    taken = rank(rows) - rank(rows[: len(formed.holonomic)]) + len(formed.dependent_names)
    instantaneous = len(formed.u) - rank(here)
    notes = tuple(_notes(branch, taken, instantaneous))
    return Mobility(branch.dimension - taken, instantaneous, tuple(independent_columns(rows)), notes)


def generic_point(branch: ConfigurationBranch, velocity_rows: Callable[[Any], Any]) -> Any:
    """Return a configuration on a branch at which J has its largest rank."""
    return max(branch.points, key=lambda q: rank(velocity_rows(q)))


def _notes(branch: ConfigurationBranch, taken: int, instantaneous: int) -> Iterator[str]:
    freedoms = branch.dimension - taken
    if instantaneous != freedoms:
        yield (
            f"at the initial values {instantaneous} speeds are independent, near them {freedoms}: "
            + ("branches of the motion meet there" if freedoms else "small displacements cannot be continued")
        )
    if len(branch.dimensions) > 1:
        listed = ", ".join(str(dimension - taken) for dimension in branch.dimensions)
        yield f"branches with {listed} degrees of freedom meet at the initial values; the largest is counted"
    if not branch.is_decided:
        yield (
            f"there may be more than {freedoms} degrees of freedom: not all displacements from the initial "
            "values could be followed. Give initial values near this configuration"
        )


def values_when_assembled(formed: EquationsOfMotion, outputs: Sequence[str]) -> list[list[list[float]]]:
    """Return outputs that depend on positions alone at assembled configurations, near the start and far away.

    Raises
    ------
    AssemblyError
        If the loops close from no start.
    """
    resolved = _parameter_values(formed)
    loops = _Loops(drop_negligible(formed, resolved), resolved)
    program = _program(loops.formed, outputs)
    found = [loops.values(program, q) for q in loops.closed_configurations(_FAR_STARTS)]
    if not found:
        raise _assembly_error(formed)
    return found


@dataclass(frozen=True, eq=False)
class _Loops:
    """The constraints of a mechanism with values of its parameters; q is a list of numbers or an array."""

    formed: EquationsOfMotion
    resolved: Mapping[str, float]

    @cached_property
    def manifold(self) -> ConstraintManifold:
        """The constraints on positions."""
        formed, length = self.formed, self._length()
        program = _program(formed, ("constraints", "position_jacobian"))
        alignment = _program(formed, ("alignment",))
        units = output_units(formed)
        place = {formed.graph.symbol(symbol): k for k, symbol in enumerate(formed.q)}
        return constraint_manifold(
            lambda q: self.values(program, q),
            [length if units.get(q.label) == "m" else 1.0 for q in formed.q],
            [1.0 if row.force.is_zero else length for row in formed.holonomic],
            [[place[node] for node in quaternion] for quaternion in formed.variables.quaternions],
            lambda q: min(self.values(alignment, q)[0], default=1.0) > ALIGNED,
        )

    def closed_configurations(self, spreads: Sequence[float]) -> Iterator[Any]:
        """Yield configurations on which the constraints hold, from starts spread about the initial values."""
        start, random = list(zip(_start(self.formed), self.manifold.sizes.tolist(), strict=True)), Random(1)
        for spread in spreads:
            end = self.manifold.project([x + size * random.uniform(-spread, spread) for x, size in start])
            if end.is_closed:
                yield end.q

    def velocity_rows(self, q: Any) -> list[list[float]]:
        """Return J at a configuration, one list a row, with lengths in units of the mechanism's."""
        n, (sizes, scales) = len(self.formed.u), self._sizes
        (flat,) = self.values(self._jacobian, q)
        rows = [flat[k : k + n] for k in range(0, len(flat), n)]
        return [
            [x * size / scale for x, size in zip(row, sizes, strict=True)]
            for row, scale in zip(rows, scales, strict=True)
        ]

    def values(self, program: Program, q: Any) -> list[list[float]]:
        """Return the outputs of a program at a configuration."""
        formed = self.formed
        inputs = {
            "q": [float(x) for x in q], "p": [self.resolved[p.name] for p in formed.parameters],
            "r": [0.0] * len(formed.inputs), "t": [0.0],
        }  # fmt: skip
        return [[float(x) for x in values] for values in evaluate_sequence(program, inputs)]

    @cached_property
    def _jacobian(self) -> Program:
        return _program(self.formed, ("jacobian",))

    @cached_property
    def _sizes(self) -> tuple[list[float], list[float]]:
        """What counts as large along each speed, and for each row of J."""
        formed, units, length = self.formed, output_units(self.formed), self._length()
        speeds = [length if units.get(u.label) == "m/s" else 1.0 for u in formed.u]
        return speeds, [1.0 if row.force.is_zero else length for row in formed.rows]

    def _length(self) -> float:
        """Return the largest length of the model [m], else the largest initial displacement, else 1."""
        formed, model = self.formed, self.formed.topology.model
        nodes = [formed.names.expression(x, "length").index for x in model_lengths(model)]
        program = build_sequence(
            formed.graph, [Roots("lengths", (len(nodes),), tuple(nodes))], input_places(formed)
        )
        (lengths,) = self.values(program, [0.0] * len(formed.q))
        units = output_units(formed)
        initial = [formula.constant() for name, formula in model.initial.items() if units.get(name) == "m"]
        moved = [abs(float(value)) for value in initial if value is not None]
        return max(map(abs, lengths), default=0.0) or max(moved, default=0.0) or 1.0


def _parameter_values(formed: EquationsOfMotion) -> dict[str, float]:
    return {name: float(value) for name, value in resolve_parameters(formed.topology.model).items()}


def _assembly_error(formed: EquationsOfMotion) -> AssemblyError:
    return AssemblyError(
        Problem("equations.not_assembled", formed.topology.model.name,
                "the degrees of freedom cannot be counted: the loops close from none of the starting points",
                f"{len(_STARTS)} starting points around the initial values were tried",
                "check lengths, or give [initial] values close to a configuration in which the loops close")
    )  # fmt: skip


def _program(formed: EquationsOfMotion, names: Sequence[str]) -> Program:
    roots = [output_roots(formed, name) for name in names]
    return build_sequence(formed.graph, roots, input_places(formed))


def _start(formed: EquationsOfMotion) -> list[float]:
    """Return the initial values of the model as far as they are numbers, 0 otherwise, as `assemble` does."""
    given = {name: formula.constant() for name, formula in formed.topology.model.initial.items()}
    start = [float(given.get(q.name) or 0) for q in formed.q]
    place = {formed.graph.symbol(q): k for k, q in enumerate(formed.q)}
    for quaternion in formed.variables.quaternions:
        places = [place[node] for node in quaternion]
        if not any(start[k] for k in places):
            start[places[0]] = 1.0
    return start
