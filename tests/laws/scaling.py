"""Laws: a mechanism whose lengths, masses and times are scaled moves as before, scaled.

The numbers of a random mechanism are its parameters here, and arguments of one compiled function: no text of a
decimal stands between them and the motion. Factors that are powers of two (of four for masses, whose square
roots the solver takes) change no digit of anything; other factors change rounding alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

import symbody as sb
from symbody.graph.trees import TreeChoice
from symbody.model import resolve_parameters
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.mechanisms import random_mechanism
from tests.laws.parts import Mechanism, Units
from tests.laws.rotations import Array

ONE = Units()


def plain_mechanism(seed: int, units: Units) -> Mechanism:
    """The mechanism of a seed with numbers as parameters; laws of forces, which are texts, are left out."""
    mechanism = random_mechanism(seed, units)
    joints = tuple(
        replace(joint, drives={name: replace(drive, applied=()) for name, drive in joint.drives.items()})
        for joint in mechanism.joints
    )
    springs = tuple(replace(spring, applied=()) for spring in mechanism.springs)
    return replace(mechanism, symbolic=True, joints=joints, springs=springs, loads=(), inputs={})


def is_scalable(seed: int) -> bool:
    """Whether all numbers of a mechanism that have units are parameters."""
    other = Units(2.0, 4.0, 8.0)
    first, second = (build_model(plain_mechanism(seed, units)) for units in (ONE, other))
    same = first.elements == second.elements and first.ground == second.ground
    return same and first.gravity == second.gravity


def factor(unit: str | None, units: Units) -> float:
    """By what a coordinate or speed is multiplied."""
    factors = {"m": units.length, "m/s": units.length / units.time, "rad/s": 1.0 / units.time}
    return factors.get(unit or "", 1.0)


def parameters_in(seed: int, units: Units) -> dict[str, float]:
    """The values of the parameters in other units."""
    model = build_model(plain_mechanism(seed, units))
    return {name: float(value) for name, value in resolve_parameters(model).items()}


def scaled_state(eqs: sb.EquationSet, state: State, units: Units) -> dict[str, float]:
    """The values of all coordinates and speeds in other units."""
    names = (*eqs.coordinate_names, *eqs.speed_names)
    return {name: state.known[name] * factor(eqs.units.get(name), units) for name in names}


def scaled_sweep(
    eqs: sb.EquationSet, seed: int, units: Units, share: float, *, lanes: bool = False, rtol: float = 1e-8
) -> tuple[sb.Sweep, Array]:
    """The motion in other units by the loop over many cases, and its states (N, n) in the first ones."""
    state = consistent_state(plain_mechanism(seed, ONE))
    span = (state.t * units.time, (state.t + share) * units.time)
    cases: Mapping[str, list[float]] = {name: [value] for name, value in parameters_in(seed, units).items()}
    found = sb.sweep(
        eqs, span, cases, guess=scaled_state(eqs, state, units), times=list(span), combine="list",
        threads=1, lanes=lanes, rtol=rtol,
    )  # fmt: skip
    factors = np.array([factor(eqs.units.get(name), units) for name in eqs.state_names])
    return found, found.x[0].T / factors


def formed(seed: int, tree: TreeChoice) -> sb.EquationSet:
    """The equations of a scalable mechanism."""
    return sb.form_equations(build_model(plain_mechanism(seed, ONE)), tree=tree)


def has_massless(eqs: sb.EquationSet, seed: int) -> bool:
    """Whether some coordinate moves no mass at the first state: its entry of diag(M) is 0."""
    state = consistent_state(plain_mechanism(seed, ONE))
    values = [[state.known[name] for name in names] for names in (eqs.coordinate_names, eqs.speed_names)]
    mass = sb.compile(eqs, "mass_matrix", parameters=parameters_in(seed, ONE))(state.t, *values)
    return not np.diag(np.asarray(mass)).all()
