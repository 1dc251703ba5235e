"""`Continuation`: positions, speeds and accelerations of a mechanism whose coordinates are driven.

Positions by Newton's method from the tangent at the last ones, with steps halved where that does not lead
on (continuation; Allgower & Georg 1990, chapter 2); speeds and accelerations by the differentiated
constraints, exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.derivatives import laws_key
from symbody.analysis.kinematics.driven import DRIVEN, drive_coordinates, joint_of
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.expr.language.formula import Formula
from symbody.manifold import ConstraintManifold, least_solution, null_space
from symbody.model.declarations.arguments import plain_value
from symbody.tolerances import SHARP_RANK, TRACED

Floats = NDArray[np.float64]
# From the parameter of a path to a coordinate, its first and its second derivative.
Law = Callable[[float], tuple[float, float, float]]

_LARGEST_MOVE: Final = 0.3  # of a coordinate in one step [rad, or sizes of the mechanism]
_CORRECTION: Final = 0.25  # of the move; more means that the tangent leads elsewhere
_SMALL: Final = 0.02  # corrections below are always believed
_SHORTEST: Final = 1e-11  # share of a path below which a step leads nowhere


@dataclass(frozen=True, slots=True, eq=False)
class Continuation:
    """A mechanism with driven coordinates.

    Attributes
    ----------
    eqs : EquationSet
        With the rows of the driven coordinates among the constraints.
    driven : tuple of str
        The driven coordinates.
    laws : mapping of coordinate to callable
        Laws that are not formulas, of the parameter of the path.
    clock : callable
        From that parameter to time.
    sizes, speed_sizes : (n_q,), (n_u,) arrays
        Sizes: 1 for angles, that of the mechanism for lengths.
    scales : (n_c,) array
        Sizes of the constraints.
    time : float
        The time of the mechanism [s], see `Scales`.
    angles : (n_q,) array
        Mask of the angles.
    wrapped : tuple of int
        Rows of measured angles, which jump by a turn.
    """

    eqs: EquationSet
    driven: tuple[str, ...]
    laws: Mapping[str, Law]
    clock: Callable[[float], float]
    sizes: Floats
    speed_sizes: Floats
    scales: Floats
    time: float
    angles: NDArray[np.bool_]
    wrapped: tuple[int, ...]
    positions: CompiledFunction
    motions: CompiledFunction
    rates: CompiledFunction
    formulas: CompiledFunction

    def rescale(self, mechanism: Scales) -> Continuation:
        """Return the same with other scales, as those of a configuration where the model has no length."""
        eqs = self.eqs
        return replace(
            self,
            sizes=mechanism.coordinates(eqs),
            speed_sizes=mechanism.displacements(eqs),
            scales=_scales(eqs, mechanism),
            time=mechanism.time,
        )

    @property
    def n_h(self) -> int:
        """Rows on positions, those of driven coordinates last."""
        return len(self.positions.outputs[0].values)

    @property
    def own_rows(self) -> NDArray[np.bool_]:
        """Mask of the rows of J that belong to the mechanism itself."""
        return np.array([not row.name.startswith(DRIVEN) for row in self.eqs.formed.rows], dtype=np.bool_)

    def targets(self, s: float) -> Floats:
        """Return value, rate and acceleration of each driven coordinate by its law, (3, n)."""
        values = [self.laws[name](s) if name in self.laws else (0.0, 0.0, 0.0) for name in self.driven]
        return np.array(values, dtype=np.float64).reshape(-1, 3).T

    def driven_values(self, s: float) -> dict[str, float]:
        """Return the values of the driven coordinates."""
        q, u, t = np.zeros(self.sizes.size), np.zeros(self.speed_sizes.size), self.clock(s)
        by_laws = dict(zip(self.driven, self.targets(s)[0].tolist(), strict=True))
        values = self.formulas(t, q, u)[:-2]
        return by_laws | {name: float(x) for name, x in zip(self.driven, values, strict=False)}

    def manifold(self, s: float) -> ConstraintManifold:
        """Return the conditions on positions at the parameter of the path."""
        t, targets, still = self.clock(s), self.targets(s)[0], np.zeros(self.speed_sizes.size)
        places = slice(self.n_h - len(self.driven), self.n_h)
        jumping = list(self.wrapped)

        def evaluate(q: Floats) -> tuple[Floats, Floats]:
            point = self.positions(t, q, still)
            values = np.array(point.constraints)
            values[places] -= targets
            values[jumping] = np.arctan2(np.sin(values[jumping]), np.cos(values[jumping]))
            return values, point.position_jacobian

        names = self.eqs.coordinate_names
        quaternions = [[names.index(name) for name in four] for four in self.eqs.quaternions]
        return ConstraintManifold(evaluate, self.sizes, self.scales[: self.n_h], quaternions, closed=TRACED)

    def correct(self, s: float, q: Floats, plane: tuple[Floats, float] | None = None) -> Floats | None:
        """Return positions near a guess that fulfil all conditions, or None; `plane` adds one of them."""
        return self.manifold(s).correct(q, plane)

    def rows(self, s: float, q: Floats, u: Floats) -> tuple[Floats, Floats, Floats]:
        """Return J, and the right-hand sides of ``J u`` and ``J u'`` for all rows."""
        motion = self.motions(self.clock(s), q, u)
        rate, acceleration = -np.array(motion.velocity_constraints), np.array(motion.gamma)
        jacobian = np.asarray(motion.jacobian, dtype=np.float64)
        rate += jacobian @ u
        places = slice(self.n_h - len(self.driven), self.n_h)
        rate[places] += self.targets(s)[1]
        acceleration[places] += self.targets(s)[2]
        return jacobian, rate, acceleration

    def scaled_rows(self, jacobian: Floats) -> Floats:
        """Return rows of J, all or the mechanism's own, in their scales and by speeds in theirs."""
        scales = self.scales if len(jacobian) == len(self.scales) else self.scales[self.own_rows]
        return np.asarray(jacobian / scales[:, np.newaxis] * self.speed_sizes)

    def solve(self, jacobian: Floats, right: Floats) -> tuple[Floats, float]:
        """Return the least solution of ``J x = right`` and its largest scaled residual."""
        rows, scaled = self.scaled_rows(jacobian), right / self.scales
        x = least_solution(rows, scaled, SHARP_RANK)
        return x * self.speed_sizes, float(np.abs(rows @ x - scaled).max(initial=0.0))

    def freedoms(self, jacobian: Floats) -> Floats:
        """Return unit speeds (n_u, f), in sizes, that rows of J leave."""
        return null_space(self.scaled_rows(jacobian), SHARP_RANK)

    def free_speeds(self, basis: Floats) -> list[str]:
        """Return a speed for each column of `freedoms`: together they say what is left to move."""
        names, left = self.eqs.speed_names, basis.copy()
        chosen = list[str]()
        for _ in range(basis.shape[1]):
            k = int(np.linalg.norm(left, axis=1).argmax())
            chosen.append(names[k])
            row = left[k] / np.linalg.norm(left[k])
            left = left - np.outer(left @ row, row)
        return chosen

    def speeds(self, s: float, q: Floats) -> Floats:
        """Return the speeds that follow from the driven coordinates."""
        jacobian, rate, _ = self.rows(s, q, np.zeros(self.speed_sizes.size))
        return self.solve(jacobian, rate)[0]

    def qdot(self, s: float, q: Floats, u: Floats) -> Floats:
        """Return the rates of the coordinates."""
        rates: Floats = self.rates(self.clock(s), q, u)
        return rates

    def follow(self, start: float, q: Floats, stop: float) -> tuple[float, Floats]:
        """Follow the path from positions at its parameter `start`; return how far it leads, and where to."""
        s, step = start, stop - start
        shortest = _SHORTEST * max(abs(step), abs(start) * 1e-3)
        while s != stop:
            trial = stop if abs(stop - s) <= abs(step) else s + step
            trial_q = self._step(s, q, trial)
            if trial_q is None:
                step = (trial - s) / 2.0
                if abs(step) < shortest:
                    return s, q
                continue
            q, s, step = trial_q, trial, 2.0 * step
        return s, q

    def blocking_joint(self, s: float, q: Floats) -> str:
        """Return the joint that moves fastest where a path ends."""
        jacobian = self.rows(s, q, np.zeros(self.speed_sizes.size))[0]
        direction = np.linalg.svd(self.scaled_rows(jacobian))[2][-1]
        return joint_of(self.eqs, self.eqs.speed_names[int(np.abs(direction).argmax())])

    def _step(self, s: float, q: Floats, to: float) -> Floats | None:
        """Return positions one step on, or None where the step is too large."""
        clocked = 1.0 if self.clock(to) != self.clock(s) else 0.0
        still = np.zeros(self.speed_sizes.size)
        u = self.speeds(s, q)
        rate = self.qdot(s, q, u) - (0.0 if clocked else self.qdot(s, q, still))
        move = rate * (to - s)
        length = float(np.abs(move / self.sizes).max(initial=0.0))
        if not length <= _LARGEST_MOVE:
            return None
        end = self.correct(to, q + move)
        if end is None:
            return None
        change = float(np.abs((end - q - move) / self.sizes).max(initial=0.0))
        return end if change <= max(_CORRECTION * length, _SMALL) else None


def continuation(
    eqs: EquationSet,
    formulas: Mapping[str, Value],
    laws: Mapping[str, Law],
    parameters: Mapping[str, Value],
    clock: Callable[[float], float] = float,
) -> Continuation:
    """Return a mechanism with driven coordinates.

    Parameters
    ----------
    formulas : mapping of coordinate to formula in t and parameters
    laws : mapping of coordinate to callable
        Of the parameter of the path: value, first and second derivative.
    clock : callable
        From the parameter of the path to time [s].

    Raises
    ------
    UsageError
        If a driven coordinate is not free, or its law not a function of time.
    """
    rows = {**formulas, **dict.fromkeys(laws)}
    driven: EquationSet = eqs.variants.get(("driven", laws_key(rows)), lambda: drive_coordinates(eqs, rows))
    mechanism, units = mechanism_scales(eqs, parameters), eqs.units
    first = len(driven.formed.holonomic) - len(formulas) - len(laws)

    def compile_outputs(*names: str) -> CompiledFunction:
        outputs = names if len(names) > 1 else names[0]
        silent = dict.fromkeys(eqs.input_names, 0)
        return bound_function(driven, outputs, parameters, (), silent)

    return Continuation(
        driven,
        (*formulas, *laws),
        laws,
        clock,
        mechanism.coordinates(eqs),
        mechanism.displacements(eqs),
        _scales(driven, mechanism),
        mechanism.time,
        np.array([units.get(name) == "rad" for name in eqs.coordinate_names], dtype=np.bool_),
        tuple(first + k for k, name in enumerate((*formulas, *laws)) if name in eqs.measured_angles),
        compile_outputs("constraints", "position_jacobian"),
        compile_outputs("jacobian", "velocity_constraints", "gamma"),
        compile_outputs("qdot"),
        # Two outputs at least, so that the values are a tuple.
        compile_outputs(
            *(f"({Formula.from_value(plain_value(law)).text})" for law in formulas.values()), "(0)", "(0)"
        ),
    )


def _scales(driven: EquationSet, mechanism: Scales) -> Floats:
    """Return the sizes of constraints, those of driven coordinates too."""
    scales = mechanism.constraints(driven)
    for k, row in enumerate(driven.formed.rows):
        if row.name.startswith(DRIVEN):
            scales[k] = mechanism.length if driven.units.get(row.name.removeprefix(DRIVEN)) == "m" else 1.0
    return scales
