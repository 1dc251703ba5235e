"""Law: couplings that are substituted leave the motion, the reactions and the energies as they are."""

from __future__ import annotations

import random
from collections.abc import Iterable

import pytest

import symbody as sb
from tests.formulations import FORMULATIONS
from tests.laws.agreement import acceleration_error, outcome, reaction_error
from tests.laws.building import build_model
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import EPS, values_at
from tests.laws.mechanisms import coupled_mechanism
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array
from tests.laws.tally import Tally, chunks, name_of

NUMBER = 200
SCALARS = ("kinetic_energy", "potential_energy", "power")


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
    """Differences in units of what rounding explains."""
    model, state = build_model(mechanism), consistent_state(mechanism)
    formulation = random.Random(f"coupled {mechanism.seed}").choice([None, *FORMULATIONS])
    full = sb.form_equations(model)
    less = sb.form_equations(model, formulation, substitute=True)
    gone = [name for name in full.multiplier_names if name not in less.multiplier_names]
    assert len(full.coordinate_names) - len(less.coordinate_names) == len(gone)
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


def test_substituted_couplings_change_nothing() -> None:
    compare((73, 98, 110, 143, 151, 164, 183, 194))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_substituted_couplings_change_nothing_often(seeds: range) -> None:
    compare(seeds)
