"""What a motion notes at its start, and what a motion that failed shows."""

from __future__ import annotations

import pytest

import symbody as sb
from tests.display.test_views import oscillator


def pendulum(*more: sb.Body, **options: object) -> sb.EquationSet:
    rod = sb.Body("Rod", mass=1, inertia=(0, 0, 1), frames={"pin": sb.Frame(at=(-1, 0, 0))})
    pin = sb.Revolute("pin", "ground", "Rod.pin", coordinate="theta", torque=sb.Drive(applied="T"))
    return sb.form_equations(sb.Model("pendulum", [rod, *more, pin], (0, -9.81, 0), inputs=["T"], **options))


def turns(run: sb.Trajectory) -> list[str]:
    return [note for note in run.notes if " deg; for " in note]


@pytest.mark.parametrize("where", ["initial", "guess"])
def test_angles_beyond_a_turn_as_plain_numbers_are_noted(where: str) -> None:
    eqs = pendulum()
    (note,) = turns(sb.simulate(eqs, 0.1, **{where: {"theta": 30}}))
    assert note == "theta = 30 rad is 1719 deg; for 30 degrees write '30 deg'"
    assert turns(sb.simulate(eqs, 0.1, **{where: {"theta": "-30"}}))


@pytest.mark.parametrize("value", ["30 deg", "10*pi", 6.28, "0.5"])
def test_other_angles_are_not(value: float | str) -> None:
    eqs = pendulum()
    assert not turns(sb.simulate(eqs, 0.1, {"theta": value, "theta_dot": 30}))


def test_values_of_the_file_count_and_displacements_do_not() -> None:
    assert turns(sb.simulate(pendulum(initial={"theta": 90}), 0.1))
    assert not turns(sb.simulate(sb.form_equations(oscillator()), 0.1, {"x": 30}))


def test_bodies_without_a_joint_are_named() -> None:
    eqs = pendulum(sb.Body("Lost", mass=1, inertia=(1, 1, 1)))
    notes = sb.simulate(eqs, 0.1).notes
    assert "body Lost has no joint and moves freely, with six degrees of freedom" in notes
    falling = sb.form_equations(sb.Model("stone", [sb.Body("Stone", mass=1, inertia=(1, 1, 1))]))
    assert not any("no joint" in note for note in sb.simulate(falling, 0.1).notes)  # meant to fly


def test_a_mechanism_that_cannot_move_says_so() -> None:
    frames = {"end": sb.Frame(at=(1, 0, 0)), "start": sb.Frame(at=(-1, 0, 0))}
    bars = [sb.Body(name, mass=1, inertia=(1, 1, 1), frames=frames) for name in "AB"]
    joints = [
        sb.Revolute("a", "ground", "A.start", coordinate="phi"),
        sb.Revolute("b", "A.end", "B.start", coordinate="psi"),
        sb.Revolute("c", ("ground", "post"), "B.end"),
    ]
    ground = {"post": sb.Frame(at=(2, 2, 0))}
    model = sb.Model("triangle", [*bars, *joints], ground=ground, initial={"phi": "0.1", "psi": "pi/2"})
    (note,) = [
        note for note in sb.simulate(sb.form_equations(model), 0.1).notes if "no degree of freedom" in note
    ]
    assert "2 constraints for 2 speeds" in note


def test_inputs_without_a_value_are_noted_with_their_unit() -> None:
    run = sb.simulate(pendulum(), 0.1)
    assert run.notes[0] == "input T has no value and is 0 N m" and run.units["T"] == "N m"


def test_a_motion_that_failed_shows_what_to_try_and_its_notes() -> None:
    run = sb.simulate(pendulum(), 10.0, max_steps=5)
    head, status, *notes = str(run).splitlines()
    assert head == repr(run) and status.strip() == sb.Status.TOO_MANY_STEPS.value
    assert [line.strip() for line in notes] == [f"note: {note}" for note in run.notes] and notes
    assert sb.Status.TOO_MANY_STEPS.value in run._repr_html_()
    whole = sb.simulate(pendulum(), 0.1)
    assert str(whole).splitlines() == [repr(whole), *(f"  note: {note}" for note in whole.notes)]


def test_one_time_of_inverse_dynamics_is_noted() -> None:
    one, several = (sb.inverse_dynamics(pendulum(), {"theta": "t"}, "T", times) for times in (1.0, [1.0]))
    assert one.t.size == 1 and "np.linspace(0, 1, 101)" in one.notes[-1]
    assert several.notes == ()


def test_inputs_of_c_are_listed_in_their_order() -> None:
    text = sb.generate_code(pendulum(), ["xdot"], language="c")
    head = text.partition("Outputs:")[0].splitlines()
    places = [line.split()[1] for line in head if "]" in line]
    assert places == ["q[0]", "u[0]", "r[0]"]
    assert any("c is not read" in line for line in head)


def test_a_loop_that_a_motion_drives_moves() -> None:
    bar = {"P": sb.Frame(at=(-0.5, 0, 0)), "Q": sb.Frame(at=(0.5, 0, 0))}
    bodies = [sb.Body(name, 1, (0, 0, 0.1), frames=bar) for name in ("A", "B", "C")]
    joints = [
        sb.Revolute("a", "ground", "A.P", coordinate="a", motion="1 + t"),
        sb.Revolute("b", "A.Q", "B.P", coordinate="b"),
        sb.Revolute("c", "B.Q", "C.Q"),
        sb.Revolute("d", "ground.D", "C.P", coordinate="d"),
    ]
    ground = {"D": sb.Frame(at=(1.3, 0, 0))}
    model = sb.Model("driven", [*bodies, *joints], ground=ground, initial={"b": -0.8, "d": 1.5})
    run = sb.simulate(sb.form_equations(model), 0.1)
    assert run.success
    assert abs(run["d"][-1] - run["d"][0]) > 0.01
    assert not [note for note in run.notes if "no freedom" in note]


def test_a_relative_tolerance_below_the_default_absolute_one_is_told() -> None:
    free = sb.Prismatic(
        "j", "ground", sb.Body("B", mass=1, frames={"tip": sb.Frame(at=(2, 0, 0))}), axis="x", coordinate="x"
    )
    eqs = sb.form_equations(sb.Model("mass", [free]))
    strict = sb.simulate(eqs, 1.0, rtol=1e-12, times=[0.0, 1.0]).notes
    assert [note for note in strict if "rtol = 1e-12" in note and "atol=2e-12" in note]
    for given in ({"rtol": 1e-12, "atol": 2e-12}, {"rtol": 1e-10}, {}):
        assert not [note for note in sb.simulate(eqs, 1.0, times=[0.0, 1.0], **given).notes if "rtol" in note]
