"""The fault checklist, I: linearization, equilibrium, inverse dynamics, rows 91 to 98."""

from __future__ import annotations

import math

import numpy as np
import pytest

import symbody as sb
from tests.analysis.test_assembly import slider_crank
from tests.analysis.test_linearize import cart_pendulum, four_bar, pendulum
from tests.faults.refusals import refused
from tests.simulation.test_inverse_dynamics import FOUR_BAR
from tests.simulation.test_inverse_dynamics import slider_crank as driven_crank


def block(friction: sb.Friction | None, law: str = "F") -> sb.EquationSet:
    slide = sb.Prismatic("slide", "ground", sb.Body("B", mass=2), axis="x", coordinate="x",
                         force=sb.Drive(applied=law), friction=friction)  # fmt: skip
    return sb.form_equations(sb.Model("block", [slide], gravity=(0, 0, -9.81), inputs=["F"]))


def test_row_91_not_an_equilibrium_is_told_with_what_is_left() -> None:
    lin = sb.linearize(pendulum(), {"theta": 0.3})
    assert not lin.is_stationary and lin.affine[0] == pytest.approx(-9.81 * math.sin(0.3))
    (note,) = (note for note in lin.notes if "neither an equilibrium" in note)
    assert "theta_dot' = -2.899" in note and "find_equilibrium" in note
    # Of a loop, too: the rates that are left are those of the independent states.
    loop = sb.linearize(four_bar(), {"q1": 1.2})
    assert not loop.is_stationary and "x' = A x + B r describes deviations" in loop.notes[-1]


def test_row_92_no_inputs_and_no_outputs() -> None:
    lin = sb.linearize(four_bar(), {"q1": 1.2})
    assert [part.shape for part in lin] == [(2, 2), (2, 0), (0, 2), (0, 0)]
    assert lin.input_names == lin.output_names == ()


def test_row_93_friction_at_rest() -> None:
    """The smooth law has its steep slope mu m g / v0 there; under the law that sticks the block is held."""
    smooth = sb.linearize(block(sb.Friction(mu=0.3, v0=0.01)))
    assert smooth.A[0, 0] == pytest.approx(-0.3 * 9.81 / 0.01, rel=1e-9)
    rest = sb.find_equilibrium(block(sb.Friction(mu=0.3, v0=0.01)))
    assert any("friction is assumed to be 0 at rest" in note for note in rest.notes)
    sticking = sb.find_equilibrium(block(sb.Friction(mu=0.3)))
    assert any("with sticking, more configurations" in note for note in sticking.notes)
    for lin in (sb.linearize(block(sb.Friction(mu=0.3))), sticking.linearization):
        assert any("joint slide sticks, 5.886 below" in note for note in lin.notes)  # mu m g
        assert lin.state_names == ("x",) and lin.A[0, 0] == 0.0
    sliding = sb.linearize(block(sb.Friction(mu=0.3)), {"x_dot": 1.0})
    assert not any("switches at" in note for note in (*sliding.notes, *smooth.notes))


def test_row_93_friction_of_hinges_at_rest() -> None:
    """What a smooth law is guarded by, and what only conditions read, is no corner of it."""
    frames = {"end": sb.Frame(at=(0, -1, 0))}
    elements: list[sb.Body | sb.Revolute] = []
    for k, below in ((1, "ground"), (2, "B1.end")):
        friction = sb.Friction(mu=0.1, v0=0.1, radius=0.05)
        elements += [
            sb.Body(f"B{k}", mass=1, inertia=(0, 0, 0.1), frames=frames),
            sb.Revolute(f"J{k}", below, f"B{k}", axis="z", friction=friction),
        ]
    eqs = sb.form_equations(sb.Model("hinges", elements, gravity=(0, -9.81, 0)))
    assert not any("switches at" in note for note in sb.linearize(eqs).notes)


def test_row_93_a_long_formula_is_shortened() -> None:
    law = "abs(" + " + ".join(f"sin({k}*x)" for k in range(1, 60)) + ")"
    (note,) = (note for note in sb.linearize(block(None, f"F -{law}")).notes if "switches at" in note)
    assert "sin(" in note and " ... = 0" in note and len(note) < 600


@pytest.mark.parametrize(
    ("law", "word"), [("-0.5*sign(x_dot)", "sign"), ("-abs(x)", "abs"), ("-min(x, 2*x)", "min")]
)
def test_row_93_laws_with_a_corner(law: str, word: str) -> None:
    eqs = block(None, f"F {law}")
    assert any(note.startswith(f"{word} switches at this state") for note in sb.linearize(eqs).notes)
    beside = sb.linearize(eqs, {"x": 0.5, "x_dot": 0.1})
    assert not any("switches at" in note for note in beside.notes)


def test_row_93_a_slope_without_end() -> None:
    assert refused(lambda: sb.linearize(block(None, "F - sqrt(abs(x))")), words="x_dot' has no finite") == [
        ("linearize.infinite", "state x")
    ]


@pytest.mark.parametrize("theta", [0.0, 0.5 * math.pi, math.pi])
def test_row_94_dependent_coordinates_are_chosen_by_their_pivots(theta: float) -> None:
    """The coordinate chosen determines the motion wherever it stands; one that does not is refused."""
    eqs = sb.form_equations(slider_crank())
    state = sb.assemble(eqs, {"theta": theta}, {"s": 4.0})
    lin = sb.linearize(eqs, state)
    assert lin.A.shape == (2, 2) and np.isfinite(lin.A).all()
    ratios = sb.velocity_ratios(eqs, at=state)
    # No ratio is large: the coordinate that moves most is the one that leads.
    assert np.abs(ratios.at(state)).max() < 4.0
    if theta in (0.0, math.pi):
        assert refused(lambda: sb.linearize(eqs, state, independent=["s"]), words="are determined by s") == [
            ("linearize.singular_choice", "independent")
        ]


def test_row_95_no_equilibrium_tells_the_best_residual() -> None:
    assert refused(lambda: sb.find_equilibrium(pendulum(), inputs={"T": 1.5}), words="0.519 N m") == [
        ("equilibrium.none", "pendulum")
    ]


def test_row_96_a_continuum_is_reported() -> None:
    found = sb.find_equilibrium(cart_pendulum(), {"x": 2.0, "phi": 0.4})
    assert found["x"] == pytest.approx(2.0, abs=1e-12)
    assert "continuum of 1 dimension(s) along x" in found.notes[0]


def test_row_97_too_few_and_too_many_inputs() -> None:
    """Too few are refused by name; too many share the load with the least sum of squares, with a note."""
    assert refused(
        lambda: sb.inverse_dynamics(FOUR_BAR, {"theta": "0.4 + t"}, [], [0.0, 1.0], guess={"phi": 1.8}),
        words="theta",
    ) == [("inverse.underactuated", "motion theta")]
    run = sb.inverse_dynamics(FOUR_BAR, {"theta": "0.4 + t"}, ["T", "U"], [0.0, 0.5, 1.0])
    assert any("least sum of squares" in note for note in run.notes)
    eqs = sb.form_equations(driven_crank())
    (problem,) = _problems(
        lambda: sb.inverse_dynamics(
            eqs, {"theta": "t"}, "F", [0.0], parameters={"J": 1}, inputs={"T": 1}, guess={"s": 4}
        )
    )
    assert problem.code == "inverse.underactuated" and "F cannot influence" in problem.why


def test_row_98_a_motion_that_breaks_constraints() -> None:
    """With its time and by how much, where speeds disagree; where it goes out of reach, with the joint."""
    start = sb.assemble(FOUR_BAR, {"theta": 0.4}).q["phi"]
    motion = {"theta": "0.4 + 0.1*t", "phi": f"{start} + 0.1*t"}
    (problem,) = _problems(
        lambda: sb.inverse_dynamics(FOUR_BAR, motion, ["T", "U"], [0.0, 1.0], guess={"theta": 0.4})
    )
    assert problem.code == "inverse.motion_conflict" and "t = 0 s" in problem.what and problem.fix
    (problem,) = _problems(
        lambda: sb.inverse_dynamics(FOUR_BAR, {"phi": "2 - t"}, "T", np.linspace(0, 2, 21),
                                    guess={"theta": 0.4, "phi": 1.8})
    )  # fmt: skip
    assert problem.code == "inverse.out_of_reach" and problem.where.startswith("joint ")


def _problems(ask: object) -> tuple[sb.Problem, ...]:
    assert callable(ask)
    with pytest.raises(sb.SymbodyError) as caught:
        ask()
    return caught.value.problems
