"""Linear equations of random mechanisms: what they say follows from 40-digit differences of the full ones.

Deviations of all states are those that the constraints admit, as many as there are freedoms; the rates of the
independent ones change as the exact accelerations do.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import EPS, condition, equations, evaluator
from tests.laws.mechanisms import random_mechanism, turning_mechanism
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array
from tests.laws.tally import Tally, chunks, name_of

H = mpmath.mpf(10) ** -15  # differences are good to h^2, and to 40 digits less those of h
CONSTRAINTS = ("constraints", "velocity_constraints")


def out_of(lin: sb.Linearization, column: Array) -> tuple[Array, Array]:
    """The deviations (du, dq) for one of the independent states, quaternions by their own product rule."""
    eqs, known = lin.at.eqs, lin.recover(column)
    du = np.array([float(known[name]) for name in eqs.speed_names])
    joints = {joint.quaternion: joint.name for joint in eqs.formed.topology.joints}
    dq = {name: float(known[name]) for name in eqs.coordinate_names if name in known}
    for four in eqs.quaternions:
        w, x, y, z = (lin.at.q[name] for name in four)
        a, b, c = (float(known[f"{joints[four]}_r{axis}"]) / 2 for axis in "xyz")
        product = (
            -x * a - y * b - z * c,
            w * a + y * c - z * b,
            w * b + z * a - x * c,
            w * c + x * b - y * a,
        )
        dq |= dict(zip(four, product, strict=True))
    return du, np.array([dq[name] for name in eqs.coordinate_names])


def between(
    eqs: sb.EquationSet, states: Sequence[str], one: Sequence[Any], other: Sequence[Any]
) -> list[Any]:
    """What states differ by in two motions, given (u, q): numbers, and rotation vectors in end axes of the one."""
    names = (*eqs.speed_names, *eqs.coordinate_names)
    near, far = ({name: x for name, x in zip(names, motion, strict=True)} for motion in (one, other))
    found = {name: far[name] - near[name] for name in names}
    joints = {joint.quaternion: joint.name for joint in eqs.formed.topology.joints}
    for four in eqs.quaternions:
        (w, x, y, z), (a, b, c, d) = [near[n] for n in four], [far[n] for n in four]
        turn = (
            w * b - x * a - y * d + z * c,
            w * c - y * a - z * b + x * d,
            w * d - z * a - x * c + y * b,
        )
        # 2 sin(angle / 2) along the axis: the rotation vector, up to its cube.
        found |= {f"{joints[four]}_r{axis}": 2 * part for axis, part in zip("xyz", turn, strict=True)}
    return [found[name] for name in states]


def check(seeds: Iterable[int], make: Callable[[int], Mechanism]) -> None:
    tally = Tally()
    for seed in seeds:
        mechanism = make(seed)
        state = consistent_state(mechanism)
        eqs = equations(mechanism)
        guess = {name: state.known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
        inputs = {name: state.known[name] for name in eqs.input_names}
        at = sb.assemble(eqs, guess=guess, inputs=inputs, t=state.t)
        lin = sb.linearize(eqs, at)
        assert lin.A.shape[0] == len(lin.state_names), seed
        compare(lin, seed, mechanism.units.time, tally)
    tally.close("A against differences", may_be_empty=True)


def compare(lin: sb.Linearization, seed: int, time: float, tally: Tally) -> None:
    """Enter what A and B differ by from the motions beside that through the state; `time` is a unit of time."""
    eqs, at = lin.at.eqs, lin.at
    f = evaluator(
        eqs, ["udot", "qdot", "lambda", *CONSTRAINTS, "mass_matrix", "forcing", "jacobian", "gamma"]
    )
    t, q, u = at.t, np.array(list(at.q.values())), np.array(list(at.u.values()))
    r = [float(at.inputs[name]) for name in eqs.input_names]  # type: ignore[arg-type]
    bound = EPS * condition(f(t, list(q), list(u), r)).number
    # The deviations themselves are rounded, off what the constraints admit.
    length = mechanism_scales(eqs, at.parameters, near=at.q).length
    sizes = np.array([length if eqs.units.get(name) == "m" else 1.0 for name in eqs.coordinate_names])
    full = np.abs(sb.compile(eqs, "A")(t, q, u, np.array(r)))
    with mpmath.workdps(50):
        through = Beside(u, q, f.precise(t, q, u, r))
        for k in range(len(lin.state_names)):
            du, dq = out_of(lin, np.eye(len(lin.state_names))[k])
            size = max(np.abs(du).max(initial=0.0), np.abs(dq).max(initial=0.0))
            h = H * lin_size(lin, k)
            ends = [
                Beside(u + s * h * du, q + s * h * dq, f.precise(t, q + s * h * dq, u + s * h * du, r))
                for s in (1, -1)
            ]
            slopes = slopes_between(ends, h)
            assert size > 0
            expected = rates_between(lin, through, ends, h, time)
            rounded = float(np.max(full @ np.abs(np.concatenate([du, dq])), initial=0.0))
            # Forces are sums of terms a*f(q), with f of angles in radians and lengths over the mechanism's size.
            # Their derivatives are again such terms, as large as the accelerations that they make; where all
            # of them cancel, as about an axis that nothing depends on, their rounding is what is left.
            turned = float(np.max(np.abs(dq) / sizes, initial=0.0))
            rounded += float(np.abs(ends[0].rates["udot"].astype(float)).max(initial=0.0)) * turned
            unit = bound * (free_size(slopes, ends[0].rates) + rounded)
            tally.enter(seed, f"A {lin.state_names[k]}", error(lin.A[:, k], expected, unit))
            # Rows of constraints keep their values: assembly closes to 1e-9 at worst, with pivots of 2e-2.
            rates_too = np.abs(dq).max(initial=0.0) * np.abs(u).max(initial=0.0)
            for name, moved in (("constraints", dq), ("velocity_constraints", du)):
                left = np.abs(np.array(slopes[name], dtype=float)).max(initial=0.0)
                scale = np.abs(moved).max(initial=0.0) + rates_too
                assert left <= 1e-7 * scale, (seed, name, left, scale)
        for k, name in enumerate(lin.input_names):
            step = [H * (i == k) for i in range(len(r))]
            ends = [
                Beside(u, q, f.precise(t, q, u, [x + s * d for x, d in zip(r, step, strict=True)]))
                for s in (1, -1)
            ]
            slopes = slopes_between(ends, H)
            expected = rates_between(lin, through, ends, H, time)
            # The pull of an input whose arms cancel is rounding of what inputs do as a rule.
            pulled = float(np.abs(through.rates["udot"].astype(float)).max(initial=0.0)) / abs(r[k])
            unit = bound * (free_size(slopes, ends[0].rates) + pulled)
            tally.enter(seed, f"B {name}", error(lin.B[:, k], expected, unit))


@dataclass(frozen=True, slots=True, eq=False)
class Beside:
    """A state with its rates."""

    u: Array
    q: Array
    rates: dict[str, Array]

    def after(self, t: Any) -> list[object]:
        """(u, q) a short time later, to first order."""
        return [*(self.u + t * self.rates["udot"]), *(self.q + t * self.rates["qdot"])]


def rates_between(lin: sb.Linearization, through: Beside, ends: list[Beside], h: Any, time: float) -> Array:
    """How fast the difference from the motion `through` the state grows, by that of the motions of both ends.

    The derivative of the flow: to first order in time a motion is a line, along which differences of u, q are
    linear in time, and products of two quaternions quadratic; so the central difference in time is exact.
    """
    step = mpmath.mpf(time) / 1000
    grown = []
    for t in (step, -step):
        one, other = (between(lin.at.eqs, lin.state_names, through.after(t), end.after(t)) for end in ends)
        grown.append([(a - b) / (2 * h) for a, b in zip(one, other, strict=True)])
    return np.array(
        [(later - earlier) / (2 * step) for later, earlier in zip(*grown, strict=True)], dtype=float
    )


def slopes_between(ends: list[Beside], h: Any) -> dict[str, Array]:
    """Central differences of everything computed at both ends."""
    one, other = (end.rates for end in ends)
    return {name: (one[name] - other[name]) / (2 * h) for name in one}


def lin_size(lin: sb.Linearization, k: int) -> float:
    return max(abs(float(lin.at.q.get(lin.state_names[k], 1.0))), 1e-3)


def free_size(slopes: dict[str, Array], values: dict[str, Array]) -> float:
    """How much forces and pulls of constraints change accelerations, each alone: what cancels in the sum."""
    mass = np.diag(values["mass_matrix"]).astype(float)
    pulls = np.abs(values["jacobian"].astype(float)).T @ np.abs(slopes["lambda"].astype(float))
    forces = np.abs(slopes["forcing"].astype(float)) + pulls
    free = (forces[mass > 0] / mass[mass > 0]).max(initial=0.0)
    return float(
        max(free, *(np.abs(slopes[word].astype(float)).max(initial=0.0) for word in ("udot", "qdot")))
    )


def error(found: Array, expected: Array, bound: float) -> float:
    return float(np.abs(found - expected).max(initial=0.0) / bound) if bound else 0.0


def test_linear_equations_follow_from_differences() -> None:
    check((5,), random_mechanism)


def test_linear_equations_of_turning_bodies_follow_from_differences() -> None:
    """States that move, with all parametrizations of rotations."""
    check((1, 9), turning_mechanism)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(100), ids=name_of)
def test_linear_equations_follow_from_differences_often(seeds: range) -> None:
    check(seeds, random_mechanism)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_linear_equations_of_turning_bodies_follow_from_differences_often(seeds: range) -> None:
    check(seeds, turning_mechanism)
