"""`Closure`: the constraints of a mechanism as numbers, with scales, for who looks for configurations."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.constraint_values import ConstraintValues, Unconstrained
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.analysis.state import State
from symbody.codegen.compile import Value, form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, SimulationError
from symbody.manifold import ALIGNED, ConstraintManifold, rank
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]

# Rounding of solve_saddle on badly scaled mechanisms is far below; a broken row is of order one.
_CONSISTENT: Final = 1e-3
_SINGULAR: Final = Problem(
    "assembly.singular", "configuration", "the accelerations do not exist here",
    "it is a singular position, such as a flat parallelogram's, with velocities that no motion through it "
    "has", "start beside this position, or give other velocities",
)  # fmt: skip
# Rates closer to their guess are that up to the rounding of a least squares solution.
_CHANGED: Final = 1e-9
_STAYED: Final = 1e-12  # of the size of a coordinate
_STEP: Final = 1e-6  # of central differences for coordinates that are measured


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """Equations with values of parameters and inputs at one time.

    Attributes
    ----------
    sizes : (n_q,) array
        What counts as a large change of each coordinate: 1 rad, or the size of the mechanism [m].
    speed_sizes : (n_u,) array
        What counts as a large displacement along each speed: 1 rad, or the size of the mechanism.
    scales : (n_h,) array
        What the constraints are measured by: the size of the mechanism for lengths, 1 for angles.
    angles : frozenset of str
        Names of angles.
    mechanism : Scales
        Length, time and mass of the mechanism, from which the sizes above follow.
    size : float
        1, the residual of a mechanism that is as far open as it is large.
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
    size: float = 1.0
    # Functions already compiled; they follow from the fields above.
    _functions: SingleFlight[str | tuple[str, ...], CompiledFunction] = field(
        default_factory=SingleFlight, repr=False
    )
    _fours: SingleFlight[None, list[list[int]]] = field(default_factory=SingleFlight, repr=False)

    @property
    def is_tree(self) -> bool:
        """Whether there is nothing to close."""
        return not self.eqs.multiplier_names

    @property
    def manifold(self) -> ConstraintManifold:
        """The constraints on positions."""
        still = np.zeros(len(self.eqs.speed_names))

        def evaluate(q: Floats) -> tuple[Floats, Floats]:
            found = self.constraints(self.t, q, still)
            return found.constraints, found.position_jacobian

        return ConstraintManifold(evaluate, self.sizes, self.scales, self.quaternions(), self.is_aligned)

    def function(self, outputs: str | Sequence[str]) -> CompiledFunction:
        """Return a compiled function of t, q and u."""
        key = outputs if isinstance(outputs, str) else tuple(outputs)

        def compiled() -> CompiledFunction:
            inputs = dict.fromkeys(self.eqs.input_names, 0) | dict(self.inputs)
            sequence = form_sequence(self.eqs, outputs, self.parameters, (), inputs)
            return CompiledFunction(*sequence, quick=True)

        return self._functions.get(key, compiled)

    def parted(self, wanted: Mapping[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Return what is wanted of positions, and of velocities."""
        topology = self.eqs.formed.topology
        coordinates = {name for joint in topology.joints for name in joint.coordinates}
        coordinates.update(topology.model.coordinates)
        coordinates.update(self.eqs.coordinate_names)
        positions = {name: value for name, value in wanted.items() if name in coordinates}
        return positions, {name: value for name, value in wanted.items() if name not in coordinates}

    def start(self, known: Mapping[str, float]) -> Floats:
        """Return coordinates with known values, 0 where none is known; quaternions are normalized."""
        return self.normalized(np.array([known.get(name, 0.0) for name in self.eqs.coordinate_names]))

    def normalized(self, q: Floats) -> Floats:
        """Return coordinates with quaternions of unit norm; one that is zero becomes 1, 0, 0, 0."""
        result = q.copy()
        for places in self.quaternions():
            norm = float(np.linalg.norm(result[places]))
            result[places] = result[places] / norm if norm > 0 else np.array([1.0, 0.0, 0.0, 0.0])
        return result

    def free(self, fixed: Mapping[str, float]) -> NDArray[np.bool_]:
        """Return which coordinates may move."""
        return np.array([name not in fixed for name in self.eqs.coordinate_names], dtype=np.bool_)

    def residuals(self, q: Floats, fixed: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Return all conditions on positions, scaled, and their derivatives by q."""
        found = self.constraints(self.t, q, np.zeros(len(self.eqs.speed_names)))
        values = [found.constraints / self.scales]
        slopes = [found.position_jacobian / self.scales[:, np.newaxis]]
        for places in self.quaternions():
            row = np.zeros((1, q.size))
            row[0, places] = q[places]
            values.append(np.array([(q[places] @ q[places] - 1.0) / 2.0]))
            slopes.append(row)
        for name, value in fixed.items():
            if name not in self.eqs.coordinate_names:
                measured, row = self._measured(name, q)
                apart, size = measured - value, self._measured_size(name)
                if self._is_angle(name):
                    apart = float(np.arctan2(np.sin(apart), np.cos(apart)))
                values.append(np.array([apart / size]))
                slopes.append(row[np.newaxis, :] / size)
        return np.concatenate(values), np.vstack(slopes)

    def velocity_rows(self, q: Floats, fixed: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Return A and b of all conditions ``A u = b`` on velocities."""
        names = self.eqs.speed_names
        still = np.zeros(len(names))
        found = self.constraints(self.t, q, still)
        rows, right = [found.jacobian], [-found.velocity_constraints]
        for name, value in fixed.items():
            row, rest = self.speed_row(q, name, value)
            rows.append(row[np.newaxis, :])
            right.append(np.array([rest]))
        matrix, wanted = np.vstack(rows), np.concatenate(right)
        self._check_finite(np.column_stack([matrix, wanted]))
        return matrix, wanted

    def _check_finite(self, rows: Floats) -> None:
        """Refuse velocities that constraints cannot have here, as at the two ends of a rod of length 0."""
        wrong = np.flatnonzero(~np.isfinite(rows).all(axis=1)).tolist()
        if not wrong:
            return
        own = self.eqs.formed.rows
        elements = dict.fromkeys(own[k].element if k < len(own) else "" for k in wrong)
        where = ", ".join(filter(None, elements)) or "fixed"
        raise AssemblyError(
            Problem("assembly.not_finite", where, "its condition on velocities has no finite value here",
                    "a distance of length 0 has no direction, and values beyond 1.8e308 are no numbers",
                    "give it a length, or another constraint, such as a joint between the two points; or "
                    "start beside this position")
        )  # fmt: skip

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
        rate = self.function(name)
        drift = float(rate(self.t, q, np.zeros(len(names))))
        row[:] = [float(rate(self.t, q, unit)) - drift for unit in np.eye(len(names))]
        return row, value - drift

    def is_aligned(self, q: Floats) -> bool:
        """Return whether no joint is closed with opposite axes."""
        found = self.constraints(self.t, q, np.zeros(len(self.eqs.speed_names)))
        return bool((found.alignment > ALIGNED).all())

    def differs(self, a: Floats, b: Floats, tolerance: float = 1e-5) -> bool:
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
        columns = (self.residuals(q, fixed)[1] * self.sizes)[:, self.free(fixed)]
        return bool(np.linalg.matrix_rank(columns, tol=1e-8) == columns.shape[1])

    def gaps(self, q: Floats) -> dict[str, tuple[float, float]]:
        """Return the distance [m] and angle [rad] by which each joint is open, the farthest open first."""
        values = self.constraints(self.t, q, np.zeros(len(self.eqs.speed_names))).constraints
        gaps: dict[str, list[float]] = {}
        for row, value in zip(self.eqs.formed.holonomic, values, strict=True):
            gap = gaps.setdefault(row.element, [0.0, 0.0])
            place = 1 if row.force.is_zero else 0
            gap[place] = float(np.hypot(gap[place], value))
        scale = self.mechanism.length
        # Of joints that share a gap equally, up to what is told, the first of the model is named first.
        ordered = sorted(gaps, key=lambda name: -round(gaps[name][0] / scale + gaps[name][1], 6))
        return {name: (gaps[name][0], float(np.arcsin(min(gaps[name][1], 1.0)))) for name in ordered}

    def state(
        self,
        q: Floats,
        u: Floats,
        start: Floats,
        guess: Mapping[str, float],
        others: Callable[[], Iterable[State]] = tuple,
    ) -> State:
        """Return the state with its accelerations and multipliers; `guess` has the rates guessed."""
        eqs = self.eqs
        solved = self._accelerations(q, u)
        sizes = self.speed_sizes
        if not (_exist(u, solved, sizes, 0.0) or _exist(u, solved, sizes, self._free_acceleration(q, u))):
            raise AssemblyError(_SINGULAR)
        phi = self.constraints(self.t, q, u).constraints
        places = zip(eqs.coordinate_names, q - start, self.sizes, strict=True)
        moved = {name: float(d) for name, d, size in places if abs(d) > _STAYED * size}
        moved |= self._changed_rates(q, u, guess)
        return State(
            eqs,
            dict(zip(eqs.coordinate_names, q.tolist(), strict=True)),
            dict(zip(eqs.speed_names, u.tolist(), strict=True)),
            dict(zip(eqs.acceleration_names, solved.udot.tolist(), strict=True)),
            dict(zip(eqs.multiplier_names, np.ravel(solved[1]).tolist(), strict=True)),
            float(np.abs(phi).max(initial=0.0)),
            moved,
            self.t,
            self.parameters,
            self.inputs,
            others,
            _functions=self._functions,
            _dependent=_dependent(solved.jacobian),
        )

    def _accelerations(self, q: Floats, u: Floats) -> Any:
        """Return accelerations, multipliers, J and gamma.

        Raises
        ------
        SimulationError
            If no mass resists some motion, naming its coordinates.
        """
        try:
            return self.function(("udot", "lambda", "jacobian", "gamma"))(self.t, q, u)
        except SimulationError as error:
            eqs = self.eqs
            places = massless_speeds(*self.function(("mass_matrix", "jacobian"))(self.t, q, u))
            if not places:
                raise
            names = [eqs.speed_names[k] for k in places]
            raise SimulationError(
                massless_problem("numerics.singular_mass", names, eqs.coordinate_names)
            ) from error

    def _free_acceleration(self, q: Floats, u: Floats) -> float:
        """Return the largest acceleration that the forces would give without constraints, over its size."""
        found, sizes = self.function(("mass_matrix", "forcing"))(self.t, q, u), self.speed_sizes
        mass = found.mass_matrix * np.outer(sizes, sizes)
        free = np.linalg.lstsq(mass, found.forcing * sizes, rcond=None)[0]
        return float(np.abs(free).max(initial=0.0))

    def _changed_rates(self, q: Floats, u: Floats, guess: Mapping[str, float]) -> dict[str, float]:
        """Return by how much speeds, and rates of coordinates, differ from what was guessed for them."""
        eqs = self.eqs
        rates = dict(zip(eqs.speed_names, u.tolist(), strict=True))
        names = [f"{name}_dot" for name in eqs.coordinate_names]
        if any(name in guess and name not in rates for name in names):
            found = self.function("qdot")(self.t, q, u).tolist()
            rates = dict(zip(names, found, strict=True)) | rates
        for name in self.parted(guess)[1]:  # of cut joints
            if name not in rates:
                rates[name] = float(self.function(name)(self.t, q, u))
        scale = max(map(abs, [*rates.values(), *guess.values()]), default=0.0)
        changes = {name: rates[name] - value for name, value in guess.items() if name in rates}
        return {name: change for name, change in changes.items() if abs(change) > _CHANGED * scale}

    def quaternions(self) -> list[list[int]]:
        """Return the places of each quaternion in q."""
        names = self.eqs.coordinate_names
        return self._fours.get(
            None, lambda: [[names.index(name) for name in four] for four in self.eqs.quaternions]
        )

    def _is_angle(self, name: str) -> bool:
        return name in self.angles

    def _measured_size(self, name: str) -> float:
        """Return what counts as a large change of a coordinate of a cut joint."""
        return self.mechanism.length if self.eqs.units.get(name) == "m" else 1.0

    def measured(self, name: str, q: Floats) -> float:
        """Return a coordinate of a cut joint."""
        return float(self.function(name)(self.t, q, np.zeros(len(self.eqs.speed_names))))

    def _measured(self, name: str, q: Floats) -> tuple[float, Floats]:
        f, still = self.function(name), np.zeros(len(self.eqs.speed_names))
        row = np.zeros(q.size)
        for k in range(q.size):
            step = np.zeros(q.size)
            step[k] = _STEP * self.sizes[k]
            rise = float(f(self.t, q + step, still)) - float(f(self.t, q - step, still))
            if self._is_angle(name):
                rise = float(np.arctan2(np.sin(rise), np.cos(rise)))
            row[k] = rise / (2.0 * step[k])
        return float(f(self.t, q, still)), row


def constraint_function(
    eqs: EquationSet,
    parameters: Mapping[str, Value],
    inputs: Mapping[str, Value],
    free: Iterable[str] = (),
) -> CompiledFunction:
    """Return what a `Closure` evaluates, as a function of t, q, u and the `free` parameters."""
    given = dict.fromkeys(eqs.input_names, 0) | dict(inputs)
    program = form_sequence(eqs, ConstraintValues._fields, parameters, free, given)
    return CompiledFunction(*program, quick=True)


def closure(
    eqs: EquationSet,
    parameters: Mapping[str, Value],
    inputs: Mapping[str, Value],
    t: float,
    scales: Scales | None = None,
    constraints: Callable[..., Any] | None = None,
) -> Closure:
    """Return the constraints of equations as numbers, by default with the scales of the model.

    `constraints` is a `constraint_function` with these parameters, where it is compiled already.
    """
    known = mechanism_scales(eqs, parameters) if scales is None else scales
    angles = frozenset(name for name, unit in eqs.units.items() if unit == "rad")
    function: Callable[..., Any]
    if constraints is not None:
        function = constraints
    elif eqs.multiplier_names:
        function = constraint_function(eqs, parameters, inputs)
    else:
        function = Unconstrained(len(eqs.coordinate_names), len(eqs.speed_names))
    sizes = known.coordinates(eqs), known.displacements(eqs)
    scales_of_rows = known.constraints(eqs)[: len(eqs.formed.holonomic)]
    return Closure(eqs, parameters, inputs, t, *sizes, scales_of_rows, function, angles, known)


def _exist(u: Floats, solved: Any, sizes: Floats, held: float) -> bool:
    """Return whether accelerations fulfil ``J u' = gamma``, which has no solution at some singular positions.

    Parameters
    ----------
    sizes : (n_u,) array
        What counts as a large displacement along each speed.
    held : float
        Accelerations, over their sizes, that constraints keep from happening: what is left of them is
        rounding.
    """
    udot, jacobian, gamma = solved.udot / sizes, solved.jacobian * sizes, solved.gamma
    slopes = np.abs(jacobian).max(axis=1, initial=0.0)
    # gamma is quadratic in u; where all its terms cancel, that is what they are small against.
    fastest = float(np.abs(u / sizes).max(initial=0.0))
    largest = slopes * (fastest * fastest)  # infinite rather than a fault
    wanted = np.abs(jacobian) @ np.abs(udot) + np.abs(gamma) + largest
    # A row whose accelerations vanish holds nothing but the rounding of the others, and of the velocities
    # that cancel in its gamma: at a change point nothing else may be left of the row itself.
    eps = udot.size * np.finfo(float).eps
    rounding = slopes * eps * max(held, float(np.abs(udot).max(initial=0.0)))
    rounding = rounding + eps * float(largest.max(initial=0.0))
    apart: Floats = np.abs(jacobian @ udot - gamma)
    return not (apart > _CONSISTENT * wanted + rounding + 1e-300).any()


def _dependent(rows: Floats) -> int:
    """Return how many rows follow from the others; those of zeros are not among them."""
    return int(np.abs(rows).max(axis=1, initial=0.0).astype(bool).sum()) - rank(rows)
