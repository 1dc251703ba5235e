"""Analyses and ways to simulate under the scaling law: each gives its numbers in the first units."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import null_space, qr

import symbody as sb
from symbody.errors import SymbodyError
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.joint_laws import translations
from tests.laws.motion import all_freedoms, body_places, coordinate_rates, demands, freedom_scales
from tests.laws.parts import DrivePart, Mechanism, Term, Units
from tests.laws.rotations import Array
from tests.laws.scaling import ONE, factor, parameters_in, plain_mechanism, scaled_state

SHARE = 0.1  # of the mechanism's unit of time
RTOL = 1e-8
OFF = 0.1  # by how much guesses are off, in units
LED = 0.02  # between times of inverse dynamics


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """A mechanism at its pose in other units; parameters stay arguments."""

    eqs: sb.EquationSet
    seed: int
    units: Units

    @property
    def parameters(self) -> dict[str, float]:
        return parameters_in(self.seed, self.units)

    @property
    def state(self) -> State:
        return consistent_state(plain_mechanism(self.seed, ONE))

    @property
    def t(self) -> float:
        return self.state.t * self.units.time

    def factors(self, names: Iterable[str]) -> Array:
        """By what quantities in the first units are multiplied."""
        return np.array([factor(self.eqs.units.get(name), self.units) for name in names])

    def place(self, off: float = 0.0) -> dict[str, float]:
        """The state, with offsets of all coordinates and speeds."""
        rng = random.Random(f"place {self.seed}")
        known = scaled_state(self.eqs, self.state, self.units)
        wrong = self.factors(known) * [off * rng.uniform(-1, 1) for _ in known]
        return dict(zip(known, (np.array(list(known.values())) + wrong).tolist(), strict=True))

    def plain(self, values: Mapping[str, Any]) -> Array:
        """Values by name in the first units."""
        return np.array(list(values.values()), dtype=float) / self.factors(values)


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Numbers in the first units, with the error that they may have; words that must not depend on units."""

    numbers: Array
    words: tuple[object, ...] = ()
    allowed: float = 0.0


Analysis = Callable[[Question], Answer]


def answer(analysis: Analysis, question: Question) -> Answer:
    """What an analysis gives, or the codes of the error that it ends with."""
    try:
        return analysis(question)
    except SymbodyError as error:
        return Answer(np.zeros(0), tuple(problem.code for problem in error.problems))


def assembled(question: Question) -> Answer:
    """The state nearest to a wrong one; assembly closes to 1e-9."""
    found = sb.assemble(question.eqs, guess=question.place(OFF), parameters=question.parameters, t=question.t)
    return Answer(question.plain({**found.q, **found.u}), allowed=1e-8)


def linearized(question: Question) -> Answer:
    """The linear equations about the moving state, with rates in the first units of time."""
    eqs, time = question.eqs, question.units.time
    at = sb.assemble(eqs, guess=question.place(), parameters=question.parameters, t=question.t)
    lin = sb.linearize(eqs, at)
    factors = question.factors(lin.state_names)  # names of rotations have no unit: they are angles
    A = lin.A * factors / factors[:, np.newaxis] * time
    numbers = np.concatenate([A.ravel(), lin.affine / factors * time])
    return Answer(numbers, (lin.state_names, lin.is_stationary), 1e-8)


def balanced(question: Question) -> Answer:
    """The nearest equilibrium. Where stiffness almost vanishes, places are as good as forces over it."""
    names = question.eqs.coordinate_names
    guess = {name: value for name, value in question.place().items() if name in names}
    found = sb.find_equilibrium(question.eqs, guess, question.parameters, t=question.t)
    return Answer(question.plain(found.q), (found.verdict, len(found.branches)), 1e-6)


def with_inputs(mechanism: Mechanism) -> Mechanism:
    """The mechanism with an input along every coordinate that can be led."""
    joints, inputs = [], {}
    for joint in mechanism.joints:
        drives = dict(joint.drives)
        for name in joint.names if is_led(mechanism, joint.name) else ():
            inputs[f"r_{name}"] = 0.0
            push = (Term(1.0, "line", f"r_{name}"),)
            drives[name] = replace(drives.get(name, DrivePart()), applied=push)
        joints.append(replace(joint, drives=drives))
    return replace(mechanism, joints=tuple(joints), inputs=inputs)


def is_led(mechanism: Mechanism, name: str) -> bool:
    joint = mechanism.joint(name)
    return joint.named and not joint.motions and joint.kind not in ("spherical", "free", "weld")


def led_names(mechanism: Mechanism) -> list[str]:
    """Coordinates that determine the motion, as far as there are such that can be led."""
    places = body_places(mechanism)
    motion = all_freedoms(mechanism, places)
    scales = freedom_scales(mechanism, motion)
    fixed = np.vstack(
        [demands(mechanism, places, motion).rows * scales, np.eye(motion.size)[list(motion.known)]]
    )
    free = null_space(fixed, rcond=1e-9) if len(fixed) else np.eye(motion.size)
    rows = {}
    for joint in mechanism.joints:
        if is_led(mechanism, joint.name):
            rates = coordinate_rates(mechanism, places, motion, joint) * scales
            rows |= dict(zip(joint.names, rates @ free, strict=True))
    if not rows or not free.size:
        return []
    _, r, order = qr(np.array(list(rows.values())).T, mode="economic", pivoting=True)
    rank = int((np.abs(np.diag(r)) > 1e-3).sum())
    return [list(rows)[k] for k in order[:rank]]


def inverted(question: Question) -> Answer:
    """The efforts that lead coordinates at constant rates, as many as there are freedoms."""
    mechanism, units, t = plain_mechanism(question.seed, ONE), question.units, question.t
    chosen = led_names(mechanism)
    lengths = {name for joint in mechanism.joints for name in translations(joint)}
    known = question.state.known

    def led(name: str) -> Callable[[float], tuple[float, float, float]]:
        size = units.length if name in lengths else 1.0
        rate = known[f"{name}_dot"] * size / units.time
        return lambda s: (known[name] * size + rate * (s - t), rate, 0.0)

    own = replace(question, eqs=sb.form_equations(build_model(with_inputs(mechanism))))
    run = sb.inverse_dynamics(
        own.eqs, {name: led(name) for name in chosen}, [f"r_{name}" for name in chosen],
        t + LED * units.time * np.arange(3), parameters=question.parameters, guess=own.place(),
    )  # fmt: skip
    efforts = [
        run[f"r_{name}"] / (units.force if name in lengths else units.torque)
        for name in chosen
    ]  # fmt: skip
    return Answer(np.array(efforts).ravel(), (tuple(chosen),), 1e-8)


# Of backward differentiation the last correction is controlled, which is some hundred times less exact.
IMPLICIT = 100.0


def ways(time: float) -> dict[str, tuple[float, dict[str, Any]]]:
    """Ways to integrate, with numbers that follow the unit of time, and how much less exact they are."""
    return {
        "Baumgarte": (1.0, {"constraints": sb.Baumgarte(alpha=3.7 / time, beta=4.3 / time)}),
        "Partition": (1.0, {"constraints": sb.Partition()}),
        "Explicit": (1.0, {"integrator": sb.Explicit(order=5)}),
        "FixedStep": (1.0, {"integrator": sb.FixedStep(time / 512)}),
        "GeneralizedAlpha": (IMPLICIT, {"integrator": sb.GeneralizedAlpha(step=time / 512)}),
        "GGL": (IMPLICIT, {"constraints": sb.GGL()}),
        "Stiff": (IMPLICIT, {"integrator": sb.Stiff()}),
    }


def moved(way: str) -> Analysis:
    """The end of a motion, off by the errors of all steps."""

    def run(question: Question) -> Answer:
        less_exact, options = ways(question.units.time)[way]
        span = (question.t, question.t + SHARE * question.units.time)
        cases = {name: [value] for name, value in question.parameters.items()}
        found = sb.sweep(
            question.eqs, span, cases, guess=question.place(), times=list(span), combine="list", threads=1,
            rtol=RTOL, **options,
        )  # fmt: skip
        status, steps = found.status[0], float(found.counts[0, 0])
        if not status.success:
            return Answer(np.zeros(0), (status,))
        numbers = question.plain(dict(zip(question.eqs.state_names, found.x[0].T[-1], strict=True)))
        return Answer(numbers, (status,), less_exact * RTOL * steps)

    return run


ANALYSES: dict[str, Analysis] = {
    "assemble": assembled, "linearize": linearized, "find_equilibrium": balanced, "inverse_dynamics": inverted,
    **{way: moved(way) for way in ways(1.0)},
}  # fmt: skip
# Explicit methods compute in one order of operations whatever the numbers are: powers of two change no bit. Of
# `Baumgarte` those of its constants go with the unit of time; they are not powers of two, which are left out as 1.
SAME_BITS = ("Explicit", "FixedStep", "GeneralizedAlpha", "Baumgarte")
