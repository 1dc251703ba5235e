"""`ConstraintEvaluator`: the constraints of a mechanism as numbers, with the scales they are measured by."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.curvature import (
    RowCurvature,
    curved_coordinates,
    output_curvature,
    row_curvatures,
)
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.analysis.signal_values import signal_values
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem
from symbody.manifold import ConstraintManifold, rank
from symbody.single_flight import SingleFlight
from symbody.tolerances import ALIGNED, ASSEMBLED, DIFFERENCE, SAME_POSITION, SHARP_RANK

Floats = NDArray[np.float64]

STARTS: Final = 24  # of a search about a guess
NOTHING_FIXED: Final[Mapping[str, float]] = MappingProxyType({})


@dataclass(frozen=True, slots=True, eq=False)
class ConstraintEvaluator:
    """Equations with values of parameters and inputs at one time.

    Attributes
    ----------
    sizes : (n_q,) array
        Size of changes of each coordinate: 1 rad, or the size of the mechanism [m].
    speed_sizes : (n_u,) array
        Size of displacements along each speed: 1 rad, or the size of the mechanism.
    scales : (n_h,) array
        Size of the constraints: that of the mechanism for lengths, 1 for angles.
    angles : frozenset of str
        Names of angles.
    mechanism : Scales
        Length, time and mass of the mechanism, from which the sizes above follow.
    signals : (n_s,) array
        States of signals, for outputs that read them.
    """

    eqs: EquationSet
    parameters: Mapping[str, Value]
    inputs: Mapping[str, Value]
    t: float
    sizes: Floats
    speed_sizes: Floats
    scales: Floats
    constraints: Callable[..., Any]
    angles: frozenset[str] = frozenset()
    mechanism: Scales = Scales()
    signals: Floats = field(default_factory=lambda: np.zeros(0))
    # Functions compiled so far; they follow from the fields above.
    functions: SingleFlight[str | tuple[str, ...], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )
    _quaternions: SingleFlight[None, list[list[int]]] = field(default_factory=SingleFlight, repr=False)

    @property
    def is_tree(self) -> bool:
        """Whether there is nothing to close."""
        return not self.eqs.multiplier_names

    def manifold(self, fixed: Mapping[str, float] = NOTHING_FIXED) -> ConstraintManifold:
        """Return the constraints on positions, with coordinates that keep values.

        Those in q stay as they are in every configuration; those of cut joints are further conditions.
        """
        still = np.zeros(len(self.eqs.speed_names))
        measured = {name: x for name, x in fixed.items() if name not in self.eqs.coordinate_names}

        def evaluate(q: Floats) -> tuple[Floats, Floats]:
            point = self.constraints(self.t, q, still)
            if not measured:
                return point.constraints, point.position_jacobian
            values, rows = [point.constraints], [point.position_jacobian]
            for name, value in measured.items():
                present, row = self._measure_row(name, q)
                values.append(np.array([self._difference(name, present, value)]))
                rows.append(row[np.newaxis, :])
            return np.concatenate(values), np.vstack(rows)

        scales = np.append(self.scales, [self._measured_size(name) for name in measured])
        places, free = self.quaternions(), self.free_coordinates(fixed)
        rows = [*row_curvatures(self.eqs), *map(self._measured_curvature, measured)]
        curved, linear = curved_coordinates(rows, free)
        curved[[place for four in places for place in four]] = True
        return ConstraintManifold(
            evaluate, self.sizes, scales, places, self.is_aligned, free, ASSEMBLED, curved, linear
        )

    def compile(self, outputs: str | Sequence[str]) -> CompiledFunction:
        """Return a compiled function of t, q and u."""
        key = outputs if isinstance(outputs, str) else tuple(outputs)

        def compile_outputs() -> CompiledFunction:
            inputs = dict.fromkeys(self.eqs.input_names, 0) | dict(self.inputs)
            return bound_function(self.eqs, outputs, self.parameters, (), inputs, quick=True)

        return self.functions.get(key, compile_outputs)

    def split_values(self, values: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values of positions, and those of velocities."""
        coordinates: frozenset[str] = self.eqs.plans.get("names of positions", self._position_names)
        positions = {name: value for name, value in values.items() if name in coordinates}
        return positions, {name: value for name, value in values.items() if name not in coordinates}

    def _position_names(self) -> frozenset[str]:
        topology = self.eqs.formed.topology
        joints = (name for joint in topology.joints for name in joint.coordinates)
        return frozenset([*joints, *topology.model.coordinates, *self.eqs.coordinate_names])

    def initial_coordinates(self, values: Mapping[str, float]) -> Floats:
        """Return coordinates with given values, 0 for the others; quaternions are normalized."""
        return self.normalize(np.array([values.get(name, 0.0) for name in self.eqs.coordinate_names]))

    def normalize(self, q: Floats) -> Floats:
        """Return coordinates with quaternions of unit norm; one that is zero becomes 1, 0, 0, 0."""
        result = q.copy()
        for places in self.quaternions():
            norm = float(np.linalg.norm(result[places]))
            result[places] = result[places] / norm if norm > 0 else np.array([1.0, 0.0, 0.0, 0.0])
        return result

    def starts(self, start: Floats, fixed: Mapping[str, float], growth: float = 1.25) -> Iterator[Floats]:
        """Yield a start and others about it, farther and farther away, the same at every call."""
        yield start
        random, free = np.random.default_rng(1), self.free_coordinates(fixed)
        for k in range(1, STARTS):
            q = start.copy()
            q[free] += 0.1 * growth**k * random.standard_normal(int(free.sum())) * self.sizes[free]
            yield self.normalize(q)

    def free_coordinates(self, fixed: Mapping[str, float]) -> NDArray[np.bool_]:
        """Return a mask of the coordinates that may move."""
        return np.array([name not in fixed for name in self.eqs.coordinate_names], dtype=np.bool_)

    def velocity_rows(self, q: Floats, fixed: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Return A and b of all conditions ``A u = b`` on velocities."""
        names = self.eqs.speed_names
        still = np.zeros(len(names))
        point = self.constraints(self.t, q, still)
        rows, right = [point.jacobian], [-point.velocity_constraints]
        for name, value in fixed.items():
            row, value_left = self.speed_row(q, name, value)
            rows.append(row[np.newaxis, :])
            right.append(np.array([value_left]))
        matrix, right_hand = np.vstack(rows), np.concatenate(right)
        self._check_finite(np.column_stack([matrix, right_hand]))
        return matrix, right_hand

    def _check_finite(self, rows: Floats) -> None:
        """Refuse velocities that constraints cannot have here, as at the two ends of a rod of length 0."""
        wrong = np.flatnonzero(~np.isfinite(rows).all(axis=1)).tolist()
        if not wrong:
            return
        constraint_rows = self.eqs.formed.rows
        elements = dict.fromkeys(
            constraint_rows[k].element if k < len(constraint_rows) else "" for k in wrong
        )
        raise indefinite_rows(", ".join(filter(None, elements)) or "fixed")

    @property
    def all_speeds(self) -> tuple[str, ...]:
        """Names of the speeds, those eliminated too, in the order of the joints."""
        elimination = self.eqs.formed.elimination
        return self.eqs.speed_names if elimination is None else tuple(u.label for u in elimination.speeds)

    def speed_row(self, q: Floats, name: str, value: float) -> tuple[Floats, float]:
        """Return a and b of the condition ``a . u = b`` that a speed, or a rate, has a value."""
        names = self.eqs.speed_names
        row = np.zeros(len(names))
        if name in names:
            row[names.index(name)] = 1.0
            return row, value
        rate = self.compile(name)
        drift = float(rate(self.t, q, np.zeros(len(names))))
        row[:] = [float(rate(self.t, q, unit)) - drift for unit in np.eye(len(names))]
        return row, value - drift

    def is_aligned(self, q: Floats) -> bool:
        """Return whether no joint is closed with opposite axes."""
        point = self.constraints(self.t, q, np.zeros(len(self.eqs.speed_names)))
        return bool((point.alignment > ALIGNED).all())

    def differs(self, a: Floats, b: Floats, tolerance: float = SAME_POSITION) -> bool:
        """Return whether two sets of coordinates are different configurations, by more than a tolerance."""
        apart = (a - b) / self.sizes
        for k, name in enumerate(self.eqs.coordinate_names):
            if self._is_angle(name):
                apart[k] = np.arctan2(np.sin(apart[k]), np.cos(apart[k]))
        for places in self.quaternions():
            if a[places] @ b[places] < 0.0:
                apart[places] = a[places] + b[places]
        return bool(np.abs(apart).max(initial=0.0) > tolerance)

    def is_isolated(self, q: Floats, fixed: Mapping[str, float]) -> bool:
        """Return whether the conditions leave no free motion at a configuration."""
        columns = self.manifold(fixed).jacobian(q)
        return bool(rank(columns, SHARP_RANK) == columns.shape[1])

    def gaps(self, q: Floats) -> dict[str, tuple[float, float]]:
        """Return the distance [m] and angle [rad] by which each joint is open, the farthest open first."""
        values = self.constraints(self.t, q, np.zeros(len(self.eqs.speed_names))).constraints
        gaps: dict[str, list[float]] = {}
        for row, value in zip(self.eqs.formed.holonomic, values, strict=True):
            gap = gaps.setdefault(row.element, [0.0, 0.0])
            place = 1 if row.force.is_zero else 0
            gap[place] = float(np.hypot(gap[place], value))
        scale = self.mechanism.length
        # Of joints that share a gap equally, to six digits, the first of the model is named first.
        ordered = sorted(gaps, key=lambda name: -round(gaps[name][0] / scale + gaps[name][1], 6))
        return {name: (gaps[name][0], float(np.arcsin(min(gaps[name][1], 1.0)))) for name in ordered}

    def quaternions(self) -> list[list[int]]:
        """Return the places of each quaternion in q."""
        names = self.eqs.coordinate_names
        return self._quaternions.get(
            None, lambda: [[names.index(name) for name in four] for four in self.eqs.quaternions]
        )

    def _is_angle(self, name: str) -> bool:
        return name in self.angles

    def _difference(self, name: str, a: float, b: float) -> float:
        """Return the difference of two values; of an angle that counts no turns within half a turn."""
        counts = name not in self.eqs.measured_angles
        return a - b if counts else float(np.arctan2(np.sin(a - b), np.cos(a - b)))

    def _measured_curvature(self, name: str) -> RowCurvature:
        """Return the curvature of a condition on a coordinate of a cut joint."""
        row = output_curvature(self.eqs, name)
        # An angle that counts no turns has the same value after one.
        counts = name not in self.eqs.measured_angles
        return row if counts else row._replace(stepped=row.inside)

    def _measured_size(self, name: str) -> float:
        """Return the size of changes of a coordinate of a cut joint."""
        return self.mechanism.length if self.eqs.units.get(name) == "m" else 1.0

    def measure(self, name: str, q: Floats) -> float:
        """Return a coordinate of a cut joint."""
        return float(self.compile(name)(self.t, q, np.zeros(len(self.eqs.speed_names))))

    def _measure_row(self, name: str, q: Floats) -> tuple[float, Floats]:
        f, still = self.compile(name), np.zeros(len(self.eqs.speed_names))
        row = np.zeros(q.size)
        for k in range(q.size):
            step = np.zeros(q.size)
            step[k] = DIFFERENCE * self.sizes[k]
            rise = self._difference(
                name, float(f(self.t, q + step, still)), float(f(self.t, q - step, still))
            )
            row[k] = rise / (2.0 * step[k])
        return float(f(self.t, q, still)), row


def constraint_function(
    eqs: EquationSet,
    parameters: Mapping[str, Value],
    inputs: Mapping[str, Value],
    free: Iterable[str] = (),
) -> CompiledFunction:
    """Return the constraints of an evaluator as a function of t, q, u and the `free` parameters."""
    given = dict.fromkeys(eqs.input_names, 0) | dict(inputs)
    return bound_function(eqs, ConstraintValues._fields, parameters, free, given, quick=True)


def constraint_evaluator(
    eqs: EquationSet,
    parameters: Mapping[str, Value],
    inputs: Mapping[str, Value],
    t: float,
    scales: Scales | None = None,
    constraints: Callable[..., Any] | None = None,
    signals: Floats | None = None,
) -> ConstraintEvaluator:
    """Return the constraints of equations as numbers, by default with the scales and signals of the model.

    `constraints` is a `constraint_function` with these parameters, where it is compiled already.
    """
    mechanism = mechanism_scales(eqs, parameters) if scales is None else scales
    angles: frozenset[str] = eqs.plans.get(
        "names in rad", lambda: frozenset(name for name, unit in eqs.units.items() if unit == "rad")
    )
    function: Callable[..., Any]
    if constraints is not None:
        function = constraints
    elif eqs.multiplier_names:
        function = constraint_function(eqs, parameters, inputs)
    else:
        function = Unconstrained(len(eqs.coordinate_names), len(eqs.speed_names))
    sizes = mechanism.coordinates(eqs), mechanism.displacements(eqs)
    scales_of_rows = mechanism.constraints(eqs)[: len(eqs.formed.holonomic)]
    return ConstraintEvaluator(
        eqs, parameters, inputs, t, *sizes, scales_of_rows, function, angles, mechanism,
        signal_values(eqs, {}, parameters) if signals is None else signals,
    )  # fmt: skip


def indefinite_rows(where: str) -> AssemblyError:
    """Return the error of constraints whose conditions on velocities have no value at a configuration."""
    return AssemblyError(
        Problem("assembly.not_finite", where, "its condition on velocities has no finite value here",
                "a distance of length 0 has no direction, and values above 1.8e308 overflow",
                "give it a length, or another constraint, such as a joint between the two points; or start "
                "near this position")
    )  # fmt: skip


class ConstraintValues(NamedTuple):
    """Constraints on positions (n_h,), on velocities at rest (n_c,), their Jacobians, and cosines of axes."""

    constraints: Floats
    position_jacobian: Floats
    jacobian: Floats
    velocity_constraints: Floats
    alignment: Floats


@dataclass(frozen=True, slots=True)
class Unconstrained:
    """The constraints of a tree, for which nothing has to be compiled."""

    coordinates: int
    speeds: int

    def __call__(self, t: float, q: Floats, u: Floats) -> ConstraintValues:
        """Return no values, with as many columns as there are coordinates (n_q,) and speeds (n_u,)."""
        none = np.zeros(0)
        return ConstraintValues(none, np.zeros((0, self.coordinates)), np.zeros((0, self.speeds)), none, none)
