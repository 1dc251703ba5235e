"""The prescribed motion: positions by continuation, speeds and accelerations exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assemble
from symbody.analysis.kinematics.follower import Follower
from symbody.analysis.kinematics.held import element_of
from symbody.analysis.redundancy import redundancy
from symbody.analysis.scales import Scales, mechanism_scales
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, SimulationError, SymbodyError, UsageError

Floats = NDArray[np.float64]

_CONSISTENT: Final = 1e-7  # of the largest term: positions are good to 1e-12 and times may be long


class Samples(NamedTuple):
    """A motion at times: q (n_q, N), u and udot (n_u, N)."""

    t: Floats
    q: Floats
    u: Floats
    udot: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """A mechanism with a motion of its driven coordinates, and its first position."""

    eqs: EquationSet
    follower: Follower
    parameters: Mapping[str, Value]
    scales: Scales
    first: Floats

    def samples(self, times: Floats) -> Samples:
        """Return the motion at times.

        Raises
        ------
        UsageError
            If the motion leaves freedoms.
        SimulationError
            If the motion contradicts the constraints, or leads out of reach, naming time and joint.
        """
        first = self.follower.closed(float(times[0]), self.first)
        q = self.first if first is None else first
        states = []
        for k, t in enumerate(times.tolist()):
            if k:
                reached, q = self.follower.reached(float(times[k - 1]), q, t)
                if reached != t:
                    raise SimulationError(self._reach_problem(reached, t, q))
            u, udot = self.motion(t, q)
            states.append((q, u, udot))
        columns = [np.array([one[k] for one in states]).T for k in range(3)]
        return Samples(times, *columns)

    def motion(self, t: float, q: Floats) -> tuple[Floats, Floats]:
        """Return speeds and accelerations at a position.

        Raises
        ------
        UsageError
            If the driven coordinates leave freedoms.
        SimulationError
            If they contradict the constraints, or each other.
        """
        follower = self.follower
        still = np.zeros(len(self.eqs.speed_names))
        jacobian, rate, _ = follower.rows(t, q, still)
        basis = follower.freedoms(jacobian)
        if basis.shape[1]:
            raise UsageError(self._freedoms_left(t, q, basis * follower.speed_sizes[:, np.newaxis]))
        u, error = follower.solve(jacobian, rate)
        self._check(t, "speeds", error, rate)
        jacobian, _, acceleration = follower.rows(t, q, u)
        udot, error = follower.solve(jacobian, acceleration)
        self._check(t, "accelerations", error, acceleration)
        return u, udot

    def _check(self, t: float, what: str, error: float, demanded: Floats) -> None:
        largest = float(np.abs(demanded / self.follower.scales).max(initial=0.0))
        natural = self.follower.time ** (-2 if what == "accelerations" else -1)
        if error <= _CONSISTENT * (natural + largest):
            return
        driven = ", ".join(self.follower.driven)
        raise SimulationError(
            Problem("inverse.motion_conflict", f"motion {driven}",
                    f"at t = {t:.9g} s no {what} of the mechanism have the prescribed motion; it misses by "
                    f"{error:.3g} of the mechanism's size",
                    "the driven coordinates depend on each other, or the mechanism stands in a singular "
                    "position", "drive fewer coordinates, or motions that fit the constraints")
        )  # fmt: skip

    def _freedoms_left(self, t: float, q: Floats, basis: Floats) -> Problem:
        """Return the refusal of a motion that leaves freedoms, with their number and speeds."""
        names, left = self.eqs.speed_names, basis.copy()
        speeds = []
        for _ in range(basis.shape[1]):
            scaled = np.linalg.norm(left / self.follower.speed_sizes[:, np.newaxis], axis=1)
            k = int(scaled.argmax())
            speeds.append(names[k])
            row = left[k] / np.linalg.norm(left[k])
            left = left - np.outer(left @ row, row)
        count, driven = basis.shape[1], ", ".join(self.follower.driven) or "nothing"
        near = dict(zip(self.eqs.coordinate_names, q, strict=True))
        generic = redundancy(self.eqs, self.parameters, near, scales=self.scales.sizes)
        if len(self.follower.driven) >= generic.degrees_of_freedom:
            why = "the mechanism stands in a singular position, at which the driven coordinates do not tell"
            fix = "ask for times beside it, or drive another coordinate"
        else:
            why = f"it has {generic.degrees_of_freedom} freedoms, and driven are {driven}"
            fix = "give motions of further coordinates, or sb.simulate with the inputs"
        word = "freedom is" if count == 1 else "freedoms are"
        return Problem("inverse.freedoms_left", "motion",
                       f"at t = {t:.9g} s {count} {word} left: {', '.join(speeds)}", why, fix)  # fmt: skip

    def _reach_problem(self, reached: float, t: float, q: Floats) -> Problem:
        """Return the refusal of a motion that cannot go on, with time and joint."""
        joint = self.follower.stuck(reached, q)
        coordinates = dict(zip(self.eqs.coordinate_names, q.tolist(), strict=True))
        try:
            assemble(self.eqs, self.follower.asked(t), coordinates, self.parameters, None, t)
            why = "at the next time the mechanism closes again, but no motion leads there"
        except AssemblyError as error:
            why = f"at t = {t:.9g} s {error.problems[0].what}"
        except SymbodyError:
            why = "no position farther on has these coordinates"
        asked = ", ".join(f"{name} = {value:.6g}" for name, value in self.follower.asked(reached).items())
        return Problem("inverse.out_of_reach", element_of(self.eqs, joint),
                       f"at t = {reached:.9g} s the motion cannot go on; there {asked}", why,
                       "end the motion before this time, or ask for one within reach; "
                       "sb.trace_positions finds the limits")  # fmt: skip


def path_of(
    eqs: EquationSet,
    follower: Follower,
    parameters: Mapping[str, Value],
    guess: Mapping[str, Value],
    scales: Mapping[str, float],
    times: Floats,
) -> Path:
    """Return the path of a motion, with scales of its own where the model has no length.

    Raises
    ------
    AssemblyError
        If the loops do not close at the first time.
    """
    t = float(times[0])
    state = assemble(eqs, follower.asked(t), guess, parameters, None, t, scales=scales)
    targets = [follower.asked(float(s)) for s in times]
    farthest = {name: max(abs(one[name]) for one in targets) for name in follower.driven}
    mechanism = mechanism_scales(eqs, parameters, scales, {**state.q, **farthest})
    return Path(eqs, follower.scaled(mechanism), parameters, mechanism, np.array(list(state.q.values())))
