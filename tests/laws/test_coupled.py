"""Law: couplings that are substituted leave the motion, the reactions and the energies as they are.

At consistent states, and along whole motions: motions with and without substitution end at one place, and at
the states that the substituted one passes both kinds of equations say the same.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from tests.formulations import FORMULATIONS
from tests.laws.agreement import acceleration_error, outcome, reaction_error
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.evaluation import EPS, for_own_values, values_at
from tests.laws.mechanisms import coupled_mechanism
from tests.laws.motions import Motion, motion_of
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array
from tests.laws.sensitivity import sensitivity
from tests.laws.tally import Tally, chunks, name_of
from tests.laws.test_motion import GROWTH, SHARE, STOPPED, check_alone, tolerance

NUMBER = 200
SCALARS = ("kinetic_energy", "potential_energy", "power")
# Samples of a motion at which both kinds of equations are compared: in the middle and at the end.
PLACES = (0.5, 1.0)


def compare(seeds: Iterable[int]) -> None:
    """Compare the equations of each seed with those in which its couplings are substituted."""
    tallies: dict[str, Tally] = {}
    for seed in seeds:
        mechanism = coupled_mechanism(seed)
        for law, error in errors(mechanism).items():
            tallies.setdefault(law, Tally()).enter(seed, law, error)
    for law, tally in tallies.items():
        tally.close(law, may_be_empty=True)


def errors(mechanism: Mechanism) -> dict[str, float | None]:
    """Differences at a consistent state, in units of what rounding explains."""
    model, state = build_model(mechanism), consistent_state(mechanism)
    formulation = random.Random(f"coupled {mechanism.seed}").choice([None, *FORMULATIONS])
    full, less = _both(model, formulation)
    assert len(full.coordinate_names) - len(less.coordinate_names) == len(_gone(full, less))
    return differences(mechanism, full, less, state)


def _both(model: sb.Model, formulation: Formulation | None = None) -> tuple[sb.EquationSet, sb.EquationSet]:
    """The equations without and with substitution."""
    return sb.form_equations(model), sb.form_equations(model, formulation, substitute=True)


def _gone(full: sb.EquationSet, less: sb.EquationSet) -> list[str]:
    return [name for name in full.multiplier_names if name not in less.multiplier_names]


def differences(
    mechanism: Mechanism, full: sb.EquationSet, less: sb.EquationSet, state: State
) -> dict[str, float | None]:
    """Differences of two kinds of equations at a state, in units of what rounding explains."""
    gone = _gone(full, less)
    one, two = outcome(mechanism, full, state), outcome(mechanism, less, state)
    rounding = EPS * max(one.condition.number, two.condition.number)
    first, second = (values_at(eqs, state, [*SCALARS, *gone]) for eqs in (full, less))
    found = {
        "accelerations": acceleration_error(mechanism, state, one, two),
        "reactions": reaction_error(mechanism, one, two),
    }
    units = mechanism.units
    energy = sum(body.mass for body in mechanism.bodies) * units.acceleration * units.length
    for name, unit in zip(SCALARS, (energy, energy, energy / units.time), strict=True):
        found[name] = _gap(first[name], second[name], unit) / rounding
    if not mechanism.redundant:  # else efforts of couplings may be undetermined
        names = [name for name in gone if name.startswith("lambda_K")]
        sizes = [_effort_unit(mechanism, name) for name in names]
        pairs = [(first[name], second[name], unit) for name, unit in zip(names, sizes, strict=True)]
        found["multipliers"] = max((_gap(*pair) / rounding for pair in pairs), default=None)
    return found


def _effort_unit(mechanism: Mechanism, name: str) -> float:
    """The unit of the multiplier of a coupling: force, or torque."""
    coupling = next(part for part in mechanism.couplings if name.startswith(f"lambda_{part.name}_"))
    force = sum(body.mass for body in mechanism.bodies) * mechanism.units.acceleration
    return force if coupling.kind in ("rack", "belt") else force * mechanism.units.length


def _gap(one: Array, two: Array, unit: float) -> float:
    return float(abs(one - two) / max(abs(float(one)), unit))


def check_motions(seeds: Iterable[int]) -> None:
    """Compare motions with and without substitution; energies are balanced, and samples closed, in both."""
    tallies: dict[str, Tally] = {}
    stopped, worst = 0, 0.0
    for seed in seeds:
        mechanism = coupled_mechanism(seed)
        state = consistent_state(mechanism)
        full, less = (for_own_values(eqs) for eqs in _both(build_model(mechanism)))
        first, other = (motion_of(mechanism, eqs, state, SHARE) for eqs in (full, less))
        for one in (first, other):
            check_alone(one, seed)
        stopped += not first.run.success
        error = apart(mechanism, state, first, other)
        assert error <= 1.0, (seed, error)
        worst = max(worst, error)
        # Where a motion stops, accelerations grow without bounds.
        for place in PLACES if other.run.success else PLACES[:1]:
            there = passed_state(mechanism, full, state, other.run, place)
            for law, rounded in differences(mechanism, full, less, there).items():
                tallies.setdefault(law, Tally()).enter(seed, law, rounded)
    print(f"{stopped} stopped; others are apart by at most {worst:.2g} of what errors explain")
    for law, tally in tallies.items():
        tally.close(law, may_be_empty=True)


def apart(mechanism: Mechanism, state: State, first: Motion, other: Motion) -> float:
    """How far apart two motions end, in units of what their errors explain; of those that stop, their times."""
    if not (first.run.success and other.run.success):
        assert first.run.status in STOPPED and other.run.status in STOPPED, mechanism.seed
        reached = [one.run.t[-1] - state.t for one in (first, other)]
        return float(abs(reached[0] - reached[1]) / (1e-2 * max(reached)))
    places = max(np.abs(first.places[b][-1] - r[-1]).max() for b, r in other.places.items())
    error = float(places) / mechanism.units.length / tolerance(first, other)
    if error <= 1.0:
        return error
    return error * GROWTH / max(GROWTH, sensitivity(mechanism, state, None, first))


def passed_state(
    mechanism: Mechanism, eqs: sb.EquationSet, start: State, run: sb.Trajectory, place: float
) -> State:
    """A state that a motion passes, with all that equations without substitution name."""
    k = round(place * (run.t.size - 1))
    names = (*eqs.coordinate_names, *eqs.speed_names)
    known = {**start.known, "t": float(run.t[k]), **{name: float(run[name][k]) for name in names}}
    axes = {body.name: run[f"frame R {body.name} ground"][..., k] for body in mechanism.bodies}
    places = {name: (np.zeros(3), matrix) for name, matrix in axes.items()}
    return State(float(run.t[k]), places, {}, known)


def test_substituted_couplings_change_nothing() -> None:
    compare((73, 98, 110, 143, 151, 164, 183, 194))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_substituted_couplings_change_nothing_often(seeds: range) -> None:
    compare(seeds)


def test_motions_are_those_of_the_constraints() -> None:
    check_motions((73,))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_motions_are_those_of_the_constraints_often(seeds: range) -> None:
    check_motions(seeds)
