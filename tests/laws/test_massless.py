"""Law: a mass that tends to nothing tends to no mass at all, on any mechanism.

To a body of a random mechanism a light body is hung on a slide, with springs, with and without dampers, to its
carrier and to another body. Where the light body's state is the one that balances of forces give, the other
bodies accelerate as without the mass but for what is in proportion to it.
"""

from __future__ import annotations

import random
from dataclasses import replace

import numpy as np
import pytest

import symbody as sb
from symbody.model import resolve_parameters
from tests.formulations import FORMULATIONS, name_of
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.evaluation import evaluator
from tests.laws.mechanisms import random_mechanism
from tests.laws.parts import Mechanism, Units
from tests.laws.rotations import Array
from tests.tiers import cases

SLIDE = "light_s"
# Of masses of order one; the second is where rounding is still below what the mass does.
MASSES = (1e-4, 1e-6)
# The difference is in proportion to the mass, up to its square.
PROPORTION = MASSES[0] / MASSES[1] * 0.9


def hung(mechanism: Mechanism, mass: float, *, damped: bool) -> sb.Model:
    """The mechanism with a light body on a slide."""
    rng = random.Random(mechanism.seed)
    model = build_model(mechanism)
    names = [body.name for body in model.bodies]
    carrier = rng.choice(names)
    other = rng.choice(["ground", *(name for name in names if name != carrier)])
    damping = 1.7 if damped else 0
    drive = sb.Drive(stiffness=2.3, free=0.2, damping=damping)
    light = [
        sb.Body("Light", mass=mass),
        sb.Prismatic("light_slide", carrier, "Light", axis=(1, 2, -2), coordinate=SLIDE, force=drive),
        sb.SpringDamper("light_spring", other, "Light", stiffness=1.9, damping=damping / 2),
    ]
    others = (*model.elements, *light)
    return sb.Model(
        model.name, others, model.gravity, model.parameters, model.inputs, model.initial, model.ground
    )


def accelerations(model: sb.Model, state: State, formulation: object = None) -> tuple[Array, Array, State]:
    """Of the massive bodies, (k, 6); the power and the rate of the energy; the state with the light body's."""
    eqs = sb.form_equations(model, formulation)  # type: ignore[arg-type]
    if eqs.multiplier_names:
        eqs = eqs.for_values({name: float(x) for name, x in resolve_parameters(model).items()})
    state = balanced(eqs, state)
    bodies = [body.name for body in model.bodies if body.name != "Light"]
    words = [f"frame {kind} {body} ground ground" for body in bodies for kind in ("vdot", "wdot")]
    light = [f"({SLIDE}_dot)"]
    values = at(eqs, state, [*words, *light])
    known = {**state.known, f"{SLIDE}_dot": float(values[light[0]])}
    return (
        np.array([values[word] for word in words]).reshape(-1, 6),
        values[light[0]],
        replace(state, known=known),
    )


def balanced(eqs: sb.EquationSet, state: State) -> State:
    """The state with the light body where the forces on it are in balance, if that is a constraint."""
    name = f"balance_{SLIDE}"
    if name not in eqs.multiplier_names:
        return state
    row = eqs.multiplier_names.index(name)
    known = dict(state.known)
    for _ in range(3):  # the balance is of first degree in the displacement: one step, and rounding
        values = at(eqs, replace(state, known=known), ["constraints", "position_jacobian"])
        slope = values["position_jacobian"][row, eqs.coordinate_names.index(SLIDE)]
        known[SLIDE] -= float(values["constraints"][row] / slope)
    known[f"{SLIDE}_dot"] = 0.0
    values = at(eqs, replace(state, known=known), ["velocity_constraints", "jacobian"])
    slope = values["jacobian"][row, eqs.speed_names.index(f"{SLIDE}_dot")]
    known[f"{SLIDE}_dot"] = -float(values["velocity_constraints"][row] / slope)
    return replace(state, known=known)


def at(eqs: sb.EquationSet, state: State, outputs: list[str]) -> dict[str, Array]:
    """Outputs at a state."""
    names = (eqs.coordinate_names, eqs.speed_names, eqs.input_names)
    return evaluator(eqs, outputs)(state.t, *(state.of(group) for group in names))


def compare(seed: int, *, damped: bool) -> None:
    """Compare without mass, in all formulations, and with little mass."""
    mechanism = random_mechanism(seed, Units())
    start = consistent_state(mechanism)
    start = replace(start, known={**start.known, SLIDE: 0.4, f"{SLIDE}_dot": 0.0})
    first, _, state = accelerations(hung(mechanism, 0, damped=damped), start)
    size = max(float(np.abs(first).max()), 1.0)
    for formulation in FORMULATIONS:
        other = accelerations(hung(mechanism, 0, damped=damped), start, formulation)[0]
        assert np.abs(other - first).max() <= 1e-8 * size, formulation
    gaps = [
        float(np.abs(accelerations(hung(mechanism, mass, damped=damped), state)[0] - first).max())
        for mass in MASSES
    ]
    # What rounding leaves in systems whose masses are six decades apart.
    assert gaps[1] <= max(gaps[0] / PROPORTION * 1.3, 1e-8 * size), gaps


@pytest.mark.parametrize("damped", cases([True, False], fast=[True]))
@pytest.mark.parametrize("seed", [1])
def test_little_mass_is_nearly_none(seed: int, damped: bool) -> None:
    compare(seed, damped=damped)


@pytest.mark.exhaustive
@pytest.mark.parametrize("damped", [True, False])
@pytest.mark.parametrize("seed", range(60))
def test_little_mass_is_nearly_none_often(seed: int, damped: bool) -> None:
    compare(seed, damped=damped)


@pytest.mark.parametrize("formulation", cases(FORMULATIONS, fast=FORMULATIONS[1:3]), ids=name_of)
def test_the_light_speed_is_no_state_where_a_damper_acts(formulation: object) -> None:
    mechanism = random_mechanism(1, Units())
    damped = sb.form_equations(hung(mechanism, 0, damped=True), formulation)  # type: ignore[arg-type]
    assert f"{SLIDE}_dot" not in damped.speed_names and SLIDE in damped.coordinate_names
    free = sb.form_equations(hung(mechanism, 0, damped=False), formulation)  # type: ignore[arg-type]
    assert f"balance_{SLIDE}" in free.multiplier_names
