"""Values that no mechanism has, spins that nothing resists, and events at any scale."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import symbody as sb


@cache
def cart() -> sb.EquationSet:
    """A mass on a slide with a spring, and a point mass hung on it."""
    frames = {"p": sb.Frame(at=(0, "l", 0))}
    slide = sb.Prismatic("slide", "ground", "Cart", axis="x", coordinate="x", force=sb.Drive(stiffness=4))
    pin = sb.Revolute("pin", "Cart", "Bob.p", coordinate="phi")
    bodies = [sb.Body("Cart", mass="m"), sb.Body("Bob", mass=1, inertia=(0, 0, "I"), frames=frames)]
    model = sb.Model(
        "cart", [*bodies, slide, pin], gravity=(0, -9.81, 0), parameters={"m": 2, "l": 0.5, "I": 0.1},
        initial={"phi": 0.3},
    )  # fmt: skip
    return sb.form_equations(model)


@pytest.mark.parametrize("values", [{"m": -1.0}, {"I": -0.1}, {"m": "-l"}])
@pytest.mark.parametrize(
    "call",
    [
        lambda p: sb.simulate(cart(), 1.0, parameters=p),
        lambda p: sb.assemble(cart(), parameters=p),
        lambda p: sb.linearize(cart(), {"phi": 0.0}, parameters=p),
        lambda p: sb.find_equilibrium(cart(), parameters=p),
        lambda p: sb.compile(cart(), "udot", parameters=p),
        lambda p: sb.generate_code(cart(), ["udot"], language="c", parameters=p),
    ],
    ids=["simulate", "assemble", "linearize", "equilibrium", "compile", "code"],
)
def test_impossible_masses_are_refused_as_those_of_a_file(
    call: Callable[[dict[str, object]], object], values: dict[str, object]
) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        call(values)
    assert all(problem.fix for problem in caught.value.problems)
    assert any(word in str(caught.value) for word in ("body Cart", "body Bob"))


@pytest.mark.parametrize("lanes", [False, True])
def test_cases_of_a_sweep_with_impossible_masses_do_not_start(lanes: bool) -> None:
    found = sb.sweep(cart(), 0.5, {"m": [1.0, -1.0, 2.0, -3.0]}, initial={"phi": 0.3}, lanes=lanes)
    assert [status.name for status in found.status] == ["SUCCESS", "NOT_STARTED", "SUCCESS", "NOT_STARTED"]
    alone = sb.simulate(cart(), 0.5, {"phi": 0.3}, parameters={"m": 2.0})
    np.testing.assert_allclose(found["phi"][2, -1], alone["phi"][-1], rtol=1e-6)


@cache
def ball() -> sb.EquationSet:
    slide = sb.Prismatic("fall", "ground", "Ball", axis="y", coordinate="y")
    return sb.form_equations(sb.Model("ball", [sb.Body("Ball", mass=1), slide], gravity=(0, -9.81, 0)))


@pytest.mark.parametrize("scale", ["1", "1e-300", "1e-150", "1e200"])
def test_events_do_not_depend_on_the_scale_of_their_expression(scale: str) -> None:
    """A ball falls h = 2 m in sqrt(2 h / g)."""
    event = sb.Event(f"{scale}*y", -1, "stop")
    run = sb.simulate(ball(), 10.0, {"y": 2.0}, events=event)
    assert run.t[-1] == pytest.approx(np.sqrt(4.0 / 9.81), rel=1e-9)


def test_a_ball_released_just_above_the_floor_stops_there() -> None:
    """From 1e-17 m it falls for sqrt(2e-17 / g), 1.4 ns; before the floor nothing else happens."""
    run = sb.simulate(ball(), 1.0, {"y": 1e-17}, events=sb.Event("y", -1, "stop"))
    assert run.t[-1] == pytest.approx(np.sqrt(2e-17 / 9.81), rel=1e-6)


@pytest.mark.parametrize("angles", ["313", "123", "quaternion"])
def test_the_spin_of_a_rod_that_nothing_resists_is_noted(angles: str) -> None:
    """A rod along z has no inertia about z: a spin about it follows from the choice of speeds alone."""
    rod = sb.Body("Rod", mass=1, inertia=(1, 1, 0))
    ball_joint = sb.Spherical("ball", "ground", rod, angles=angles, speeds="end")
    eqs = sb.form_equations(sb.Model("rod", [rod, ball_joint], gravity=(0, 0, 0)))
    names = eqs.coordinate_names
    first = {names[0]: 0.3, names[1]: 0.7, names[2]: 0.2} if angles != "quaternion" else {}
    run = sb.simulate(eqs, 0.1, {**first, eqs.speed_names[0]: 1.0, eqs.speed_names[2]: 2.0})
    assert any("no mass or inertia" in note and eqs.speed_names[2] in note for note in run.notes)


def test_a_value_of_a_call_may_read_parameters_that_stand_behind_it() -> None:
    """m = 2 l = 1 kg, in whatever order the model lists them."""
    for call in (sb.assemble, lambda eqs, **given: sb.simulate(eqs, 0.1, **given)):
        call(cart(), parameters={"m": "2*l"})
    f, g = (sb.compile(cart(), "udot", parameters={"m": m}) for m in ("2*l", 1.0))
    np.testing.assert_array_equal(f(0.0, [0.1, 0.3], [0.0, 0.0]), g(0.0, [0.1, 0.3], [0.0, 0.0]))
    with pytest.raises(sb.SymbodyError):
        sb.assemble(cart(), parameters={"m": "2*l", "l": "m"})
