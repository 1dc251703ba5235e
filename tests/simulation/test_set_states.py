"""States that are set hold: actions in gears, loops and rolling, first values, pages and steppers alike."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.model import resolve_parameters
from symbody.simulation.programs.javascript_simulation import (
    PageView,
    javascript_simulation,
)
from symbody.simulation.programs.motion_request import MotionRequest
from symbody.visual.scene.body_poses import chain_of
from tests.mechanisms import example
from tests.tiers import rows

EXAMPLES = Path(__file__).parents[2] / "examples"
WITH_SAMPLES = {"integrator": sb.Explicit()}


def gears(substitute: bool) -> sb.EquationSet:
    """Two wheels of 1 and 2 kg m^2 with a + 2 b = 0."""
    parts = [
        sb.Revolute("A", "ground", sb.Body("Small", mass=1, inertia=(0, 0, 1)), coordinate="a"),
        sb.Revolute("B", "ground", sb.Body("Large", mass=1, inertia=(0, 0, 2)), coordinate="b"),
        sb.Gear("teeth", coupled=("a", "b"), ratio=-2),
    ]
    return sb.form_equations(sb.Model("gears", parts), substitute=substitute)


def after(run: sb.Trajectory, name: str, number: int = 0) -> float:
    """The value with which a motion went on after an event."""
    return float(run[name][int(np.searchsorted(run.t, run.events[number].t, side="right")) - 1])


@pytest.mark.parametrize("substitute", [False, True])
def test_a_geared_wheel_turns_back(substitute: bool) -> None:
    """b goes on with -1, so a with +2.

    The nearest of all motions (-2, 1) s to the rates (-2, -1) that the action leaves, in the masses 1 and 2, has
    s (4*1 + 2) = 4*1 - 2: the wheel would go on with s = 1/3.
    """
    back = sb.Event("b - 0.5", action={"b_dot": "-b_dot"})
    run = sb.simulate(gears(substitute), 0.8, initial={"b_dot": 1.0}, events=back)
    assert run.success and after(run, "b_dot") == -1.0
    assert abs(after(run, "a_dot") - 2.0) < 1e-14
    assert abs(run["b"][-1] - 0.2) < 1e-9


def test_a_reversed_crank_runs_the_loop_backwards() -> None:
    """One freedom: all rates are multiples of the crank's, so all change sign and the energy stays."""
    eqs = example("four_bar")
    turn = sb.Event("t - 0.05", action={"theta_dot": "-theta_dot"})
    run = sb.simulate(eqs, 0.1, events=turn, **WITH_SAMPLES)
    (_, t, before) = run.events[0]
    for name in eqs.speed_names:  # the loop is closed to 1e-10, of which the ratios of rates follow
        assert abs(after(run, name) + before[name]) < 1e-8 * abs(before["theta_dot"])
    k = int(np.searchsorted(run.t, t, side="right")) - 1
    assert abs(run["energy"][k] - run["energy"][k - 1]) < 1e-9 * run["kinetic_energy"].max()


def test_a_piston_bounces_with_its_restitution() -> None:
    eqs = example("slider_crank")
    start = sb.assemble(eqs)["s"]
    stop = sb.Event(f"s - {start - 0.2!r}", action={"s_dot": "-0.5*s_dot"})
    run = sb.simulate(eqs, 1.0, events=stop, inputs={name: 0 for name in eqs.input_names}, **WITH_SAMPLES)
    assert run.events
    assert abs(after(run, "s_dot") + 0.5 * run.events[0].state["s_dot"]) < 1e-12


def test_a_rolling_disc_rolls_back() -> None:
    """A disc of radius 1 that stands upright on a plane and rolls: its spin is set, and the ground carries it."""
    disc = sb.Body("Disc", mass=1, inertia=(0.25, 0.25, 0.5))
    parts = [
        sb.Planar("place", "ground", disc, axis="z", coordinates=("x", "y", "phi")),
        sb.Constraint("rolls", equations=["x_dot + phi_dot"]),
        sb.Constraint("stays", equations=["y"]),
    ]
    eqs = sb.form_equations(sb.Model("disc", parts))
    back = sb.Event("phi - 1", action={"phi_dot": -1})
    run = sb.simulate(eqs, 1.0, initial={"phi_dot": 2.0}, events=back, **WITH_SAMPLES)
    assert after(run, "phi_dot") == -1.0
    assert abs(after(run, "x_dot") - 1.0) < 1e-14


def test_other_rates_change_with_the_least_kinetic_energy() -> None:
    """Three masses 1, 2, 3 kg with x1 + x2 + x3 constant; x1' is set from 0 to 1.

    Of x2' + x3' = -1 the change with the least 2 x2'^2 + 3 x3'^2 has 2 x2' = 3 x3': x2' = -0.6, x3' = -0.4.
    """
    parts = [
        sb.Prismatic(f"J{k}", "ground", sb.Body(f"B{k}", mass=k), axis="x", coordinate=f"x{k}")
        for k in (1, 2, 3)
    ]
    model = sb.Model("three", [*parts, sb.Constraint("sum", equations=["x1 + x2 + x3"])])
    kick = sb.Event("t - 0.5", action={"x1_dot": 1})
    run = sb.simulate(sb.form_equations(model), 1.0, events=kick, **WITH_SAMPLES)
    found = [after(run, f"x{k}_dot") for k in (1, 2, 3)]
    np.testing.assert_allclose(found, [1.0, -0.6, -0.4], rtol=0, atol=1e-14)
    first = sb.assemble(sb.form_equations(model), fixed={"x1_dot": 1})
    np.testing.assert_allclose([*first.u.values()], [1.0, -0.6, -0.4], rtol=0, atol=1e-14)


def test_what_cannot_be_met_ends_the_motion_with_its_values() -> None:
    both = sb.Event("b - 0.5", name="tear", action={"b_dot": -1, "a_dot": 5})
    run = sb.simulate(gears(False), 1.0, initial={"b_dot": 1.0}, events=both)
    assert run.status is sb.Status.UNMET_ACTION and not run.success
    assert abs(run.t[-1] - 0.5) < 1e-9
    assert any("'tear' sets b_dot = -1, a_dot = 5" in note for note in run.notes)


@pytest.mark.parametrize("words", [{"integrator": sb.Stiff()}, {"constraints": sb.Baumgarte()},
                                   {"integrator": sb.Stiff(), "constraints": sb.GGL()},
                                   {"integrator": sb.GeneralizedAlpha(step=1e-3)},
                                   {"constraints": sb.Partition()}])  # fmt: skip
def test_every_method_goes_on_with_what_was_set(words: dict[str, object]) -> None:
    turn = sb.Event("t - 0.05", action={"theta_dot": -7})
    run = sb.simulate(example("four_bar"), 0.06, events=turn, **words)
    assert abs(after(run, "theta_dot") + 7.0) < 1e-8  # Partition keeps other speeds, which this follows from


def test_sweeps_and_steppers_set_the_same() -> None:
    eqs, turn = example("four_bar"), sb.Event("t - 0.05", action={"phi_dot": -3})
    run = sb.simulate(eqs, 0.06, events=turn, times=[0.05, 0.06], **WITH_SAMPLES)
    cases = sb.sweep(eqs, 0.06, {"m2": [2.0, 2.0]} if "m2" in eqs.parameter_names else {}, events=turn,
                     times=[0.05, 0.06], **WITH_SAMPLES)  # fmt: skip
    stepper = sb.Stepper(eqs, 0.06, events=turn, inputs=(), **WITH_SAMPLES).step()
    assert abs(float(cases["phi_dot"][0, 0]) + 3.0) < 1e-8
    for name in eqs.speed_names:
        assert abs(stepper[name] - run[name][-1]) < 1e-6 * np.abs(run[name]).max()


def test_first_values_hold_if_they_say_so() -> None:
    data = sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml")
    values = {**data.initial, "phi": sb.Initial("96 deg", priority="hold")}
    model = sb.Model(
        data.name, data.elements, data.gravity, data.parameters, data.inputs, values, data.ground
    )
    assert model.held_initial == ("phi",)
    state = sb.assemble(sb.form_equations(model))
    assert state["phi"] == pytest.approx(np.deg2rad(96.0), rel=1e-15)
    both = {**values, "theta": sb.Initial("60 deg", "hold")}
    wrong = sb.Model(data.name, data.elements, data.gravity, data.parameters, data.inputs, both, data.ground)
    with pytest.raises(sb.AssemblyError, match="no configuration has theta = 1.0472, phi = 1.67552"):
        sb.assemble(sb.form_equations(wrong))
    # A caller's value takes the place of the model's.
    assert sb.assemble(sb.form_equations(wrong), guess={"theta": 1.0})["phi"] == pytest.approx(
        np.deg2rad(96.0), rel=1e-15
    )
    with pytest.raises(sb.UsageError, match="'hold' or 'guess'"):
        sb.Initial(1.0, "low")  # type: ignore[arg-type]


@pytest.mark.parametrize("word", ["initial", "guess"])
def test_first_values_of_a_caller_have_priorities(word: str) -> None:
    """The crank at 70 deg holds, although the rocker is asked for what it has at 60: this is a guess.

    With the priorities exchanged the rocker holds. It makes no difference which of `initial=` and `guess=`
    names a value with a priority, nor who starts the motion.
    """
    eqs = example("four_bar")
    begin = sb.assemble(eqs, {"theta": np.deg2rad(60.0)})
    rocker = float(begin["phi"])
    for held, near in (("theta", "phi"), ("phi", "theta")):
        values = {
            "theta": sb.Initial("70 deg", "hold" if held == "theta" else "guess"),
            "phi": sb.Initial(rocker, "hold" if held == "phi" else "guess"),
        }
        first = {word: values}
        expected = sb.assemble(eqs, {held: values[held].value}, {near: values[near].value})
        asked = np.deg2rad(70.0) if held == "theta" else rocker
        assert abs(float(expected[held]) - asked) < 1e-15
        assert abs(float(expected["theta"] - begin["theta"])) < 1e-9 or held == "theta"
        stepper, lanes = sb.Stepper(eqs, 0.01, **first), sb.LaneStepper(eqs, 0.01, 2, **first)
        back = sb.Stepper(eqs, 0.01).reset(values)
        of_lanes = sb.LaneStepper(eqs, 0.01, 2).reset(**values)
        run, cases = sb.simulate(eqs, 0.01, **first), sb.sweep(eqs, 0.01, **first)
        for name in eqs.coordinate_names:
            found = [
                *(float(one[name]) for one in (sb.assemble(eqs, values), stepper, back)),
                run[name][0], cases[name][0, 0], *np.ravel(lanes[name]), *np.ravel(of_lanes[name]),
            ]  # fmt: skip
            assert np.abs(np.array(found) - float(expected[name])).max() < 1e-9, (held, name)


def test_lists_of_a_sweep_take_no_priority() -> None:
    """All values of a list hold; one of its entries cannot be a guess."""
    entries = [sb.Initial("60 deg"), sb.Initial("70 deg")]
    with pytest.raises(sb.UsageError, match="is not a list of numbers") as caught:
        sb.sweep(example("four_bar"), 0.01, initial={"theta": entries})  # type: ignore[dict-item]
    assert caught.value.problems[0].code == "sweep.values"


def test_every_coordinate_that_moved_is_named_in_its_unit() -> None:
    """A wrong guess of the rocker moves the crank by 19 degrees: both are named."""
    data = sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml")
    run = sb.simulate(sb.form_equations(data), 0.01)
    moved = {
        name: value
        for name, value in sb.assemble(sb.form_equations(data)).moved.items()
        if name in data.initial
    }
    (note,) = (note for note in run.notes if "instead of" in note)
    for name, change in moved.items():
        if abs(np.degrees(change)) > 0.1:
            assert f"{name} = {np.degrees(run[name][0]):.6g} deg instead of" in note


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node")
@pytest.mark.parametrize(
    ("name", "length", "share"),
    rows([("four_bar", "L2", 1.03), ("slider_crank", "L2", 0.9), ("spatial_four_bar", "b", 1.02)],
         fast=[("four_bar", "L2", 1.03)]),
)  # fmt: skip
def test_a_page_and_a_stepper_close_alike(name: str, length: str, share: float, tmp_path: Path) -> None:
    eqs = example(name)
    value = share * float(resolve_parameters(eqs.model)[length])
    inside = eqs.formed.topology.rotation_branches & eqs.formed.topology.translation_branches
    chain = chain_of(eqs.model, [body.name for body in eqs.model.bodies], inside=inside)
    view = PageView(chain.outputs, chain.parents, chain.order, 10.0, 12.0)
    request = MotionRequest(tunable=(length,))
    text = javascript_simulation(eqs, request, view)
    (tmp_path / "simulation.mjs").write_text(text.module, encoding="utf-8")
    script = 'import { makeSimulation } from "./simulation.mjs";\nconst s = makeSimulation();\n'
    script += f'const ok = s.setParameter("{length}", {value!r});\n'
    script += "console.log(JSON.stringify([ok, Array.from(s.state)]));\n"
    (tmp_path / "run.mjs").write_text(script, encoding="utf-8")
    done = subprocess.run(
        ["node", str(tmp_path / "run.mjs")], capture_output=True, text=True, timeout=60, check=True
    )
    fits, state = json.loads(done.stdout)
    assert fits
    stepper = sb.Stepper(eqs, 1e-3, inputs=())
    stepper.set(**{length: value})
    ours = np.concatenate([stepper.u, stepper.q])
    # Pages stop at 1e-10 of sizes, assembly at rounding; rates follow from positions through slopes of order 10.
    np.testing.assert_allclose(state[:-1], ours, rtol=0, atol=1e-8 * max(1.0, np.abs(ours).max()))
