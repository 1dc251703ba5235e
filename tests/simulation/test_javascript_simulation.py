"""Whole simulations as JavaScript, run by Node: the numbers of `simulate`, sliders, pulled bodies."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.errors import UsageError
from symbody.simulation.programs.javascript_simulation import (
    PageView,
    SimulationText,
    javascript_simulation,
)
from symbody.simulation.programs.motion_request import MotionRequest
from symbody.visual.scene.body_poses import chain_of

EXAMPLES = Path(__file__).parents[2] / "examples"
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="needs Node")
BEARABLE_SECONDS = 60


@cache
def equations(name: str) -> sb.EquationSet:
    folder = EXAMPLES / name
    path = folder / f"{name}.toml"
    model = sb.load_model(path) if path.exists() else sb.load_urdf(folder / f"{name}.urdf")
    return sb.form_equations(model)


def program(eqs: sb.EquationSet, **words: Any) -> SimulationText:
    trees = eqs.formed.topology
    inside = trees.rotation_branches & trees.translation_branches
    chain = chain_of(eqs.model, [body.name for body in eqs.model.bodies], inside=inside)
    view = PageView(chain.outputs, chain.parents, chain.order, 10.0, 12.0)
    return javascript_simulation(eqs, MotionRequest(**words), view)


@pytest.fixture
def run(tmp_path: Path) -> Callable[[SimulationText, str], Any]:
    """Run statements with a simulation `s` and return what they leave in `result`."""

    def node(text: SimulationText, statements: str) -> Any:
        (tmp_path / "simulation.mjs").write_text(text.module, encoding="utf-8")
        script = tmp_path / "run.mjs"
        script.write_text(
            'import { makeSimulation } from "./simulation.mjs";\n'
            "const s = makeSimulation();\nlet result;\nconst list = (x) => Array.from(x);\n"
            "const energy = () => { const e = s.energies(); return e.kinetic + e.potential - e.work; };\n"
            f"{statements}\nconsole.log(JSON.stringify(result));\n",
            encoding="utf-8",
        )
        done = subprocess.run(
            ["node", str(script)], capture_output=True, text=True, timeout=BEARABLE_SECONDS, check=False
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return node


Runner = Callable[[SimulationText, str], Any]
EXHAUSTIVE = pytest.mark.exhaustive


def last_state(motion: sb.Trajectory) -> np.ndarray:
    assert motion.success
    return np.concatenate([motion.u[:, -1], motion.q[:, -1]])


@needs_node
@pytest.mark.parametrize(
    "name",
    [
        "slider_crank",
        "spinning_top",
        *(pytest.param(n, marks=EXHAUSTIVE) for n in ("four_bar", "bicycle", "robot_arm")),
    ],
)
def test_ten_seconds_end_where_simulate_ends(name: str, run: Runner) -> None:
    eqs = equations(name)
    found = run(program(eqs, rtol=1e-11, last=10.0), "s.advanceTo(10); result = [s.code, list(s.state)];")
    expected = last_state(sb.simulate(eqs, 10.0, rtol=1e-11, integrator=sb.Explicit()))
    assert found[0] == 0 or found[0] == 2
    np.testing.assert_allclose(found[1][:-1], expected, rtol=1e-9, atol=1e-9)


@needs_node
def test_steps_of_one_length_are_those_of_simulate(run: Runner) -> None:
    eqs = equations("slider_crank")
    text = program(eqs, integrator=sb.FixedStep(1e-3), inputs={"F": "20*sin(3*t)"}, last=2.0)
    found = run(text, "s.advanceTo(2); result = list(s.state);")
    motion = sb.simulate(eqs, 2.0, inputs={"F": "20*sin(3*t)"}, integrator=sb.FixedStep(1e-3))
    np.testing.assert_allclose(found[:-1], last_state(motion), rtol=1e-10, atol=1e-10)


@needs_node
def test_frames_between_steps_lie_on_the_motion_and_on_the_constraints(run: Runner) -> None:
    eqs = equations("slider_crank")
    found = run(
        program(eqs, rtol=1e-10),
        "result = []; for (let k = 1; k <= 120; k += 1) "
        "{ s.advanceTo(k / 60); result.push([list(s.state), s.violation()]); }",
    )
    times = np.arange(1, 121) / 60
    motion = sb.simulate(eqs, 2.0, times=times, rtol=1e-10)
    states = np.array([state[:-1] for state, _ in found])
    np.testing.assert_allclose(states, np.concatenate([motion.u, motion.q]).T, rtol=1e-7, atol=1e-7)
    assert max(violation for _, violation in found) < 1e-9


@needs_node
def test_poses_are_those_of_the_frames(run: Runner) -> None:
    eqs = equations("robot_arm")
    found = run(
        program(eqs),
        "s.advanceTo(0.1); const p = s.computePose(); result = [list(s.state), list(p.positions), list(p.axes)];",
    )
    n_u = len(eqs.speed_names)
    u, q = np.array(found[0][:n_u]), np.array(found[0][n_u:-1])
    for k, body in enumerate(eqs.model.bodies):
        outputs = (f'frame r "{body.name}" ground ground', f'frame R "{body.name}" ground')
        place, axes = sb.compile(eqs, outputs)(0.1, q, u, np.zeros(len(eqs.input_names)))
        np.testing.assert_allclose(found[1][3 * k : 3 * k + 3], np.ravel(place), atol=1e-12)
        np.testing.assert_allclose(found[2][9 * k : 9 * k + 9], np.ravel(axes), atol=1e-12)


@needs_node
def test_a_new_mass_or_input_goes_on_from_the_state_that_is_shown(run: Runner) -> None:
    eqs = equations("slider_crank")
    text = program(eqs, tunable=("m2",), free_inputs=("F",), rtol=1e-11, last=1.0)
    found = run(
        text,
        's.advanceTo(0.3); const before = list(s.state); s.setParameter("m2", 2.5); s.setInput("F", 15);'
        "result = [before, list(s.state)]; s.advanceTo(1); result.push(list(s.state));",
    )
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12, atol=1e-12)
    start = dict(zip((*eqs.speed_names, *eqs.coordinate_names), found[1], strict=False))
    motion = sb.simulate(
        eqs, (0.3, 1.0), guess=start, initial={"theta": start["theta"], "theta_dot": start["theta_dot"]},
        parameters={"m2": 2.5}, inputs={"F": 15.0}, rtol=1e-11,
    )  # fmt: skip
    np.testing.assert_allclose(found[2][:-1], last_state(motion), rtol=1e-8, atol=1e-8)


@needs_node
def test_a_length_assembles_anew_or_leaves_all_as_it_is(run: Runner) -> None:
    eqs = equations("slider_crank")
    text = program(eqs, tunable=("L2",))
    found = run(
        text,
        's.advanceTo(0.2); result = [s.setParameter("L2", 1.6, ["theta", "theta_dot"]), s.violation(), '
        's.initial("theta"), s.initial("s")];'
        'const before = list(s.state); result.push(s.setParameter("L2", 0.1, ["theta"]), s.parameter("L2"), '
        "before.every((x, k) => x === s.state[k]));",
    )
    fits, violation, theta, s, fails, kept, same = found
    assert fits is True and fails is False and kept == 1.6 and same is True
    assert violation < 1e-9
    expected = sb.assemble(eqs, {"theta": theta}, None, parameters={"L2": 1.6})
    assert theta == pytest.approx(sb.assemble(eqs)["theta"]) and s == pytest.approx(expected["s"], abs=1e-9)


@needs_node
def test_first_values_hold_and_those_in_contradiction_follow(run: Runner) -> None:
    eqs = equations("slider_crank")
    found = run(
        program(eqs),
        's.advanceTo(0.2); result = [s.setInitial({ theta: 1.2, theta_dot: -2 }, "theta"), s.time, list(s.state)];'
        'result.push(s.setInitial({ theta: 1.2, s: 1.1 }, "s"), list(s.state), '
        's.setInitial({ s: 5 }, "s"), list(s.state));',
    )
    expected = sb.assemble(eqs, {"theta": 1.2, "theta_dot": -2.0})
    assert found[:2] == [True, 0]
    np.testing.assert_allclose(found[2][:-1], [*expected.u.values(), *expected.q.values()], atol=1e-8)
    names = eqs.state_names
    assert found[3] is True and found[4][names.index("s")] == pytest.approx(1.1)
    assert found[5] is False and found[6] == found[4]  # out of reach: nothing changes


@needs_node
def test_leaders_share_what_is_set_although_their_coupling_is_substituted(run: Runner) -> None:
    """With moments 1 and 3 of a and c, and a - k b - c = 0: least move and least energy; then the same from where it is."""
    bodies = [sb.Body(name, inertia=(0, 0, moment)) for name, moment in (("A", 1), ("B", 5), ("C", 3))]
    joints = [sb.Revolute(f"J{x}", "ground", x, coordinate=x.lower()) for x in "ABC"]
    model = sb.Model("shafts", [*bodies, *joints, sb.Constraint("K", "a - k*b - c")], parameters={"k": 1.0})
    eqs = sb.form_equations(model, substitute=True)
    found = run(
        program(eqs, tunable=("k",)),
        's.setInitial({ b: 0.2, b_dot: -1 }, "b"); result = [list(s.state)];'
        's.setParameter("k", 1.1); result.push(list(s.state));',
    )
    names = eqs.state_names
    first, second = (dict(zip(names, state, strict=False)) for state in found)
    whole = sb.Stepper(sb.form_equations(model), 0.1, initial={"b": 0.2, "b_dot": -1.0})
    for seen, expected in ((first, whole), (second, whole.copy().set(k=1.1))):
        for name in names:
            assert seen[name] == pytest.approx(expected[name], abs=1e-14)
    assert first["c"] == pytest.approx(-0.1) and first["c_dot"] == pytest.approx(0.25)


@needs_node
def test_a_pulled_body_comes_to_the_pointer_and_its_work_is_counted(run: Runner) -> None:
    eqs = equations("rr_robot")
    found = run(
        program(eqs, rtol=1e-9),
        "result = [energy()]; const p = s.computePose().positions;"
        "const goal = [p[3] * 0.9 - p[4] * 0.4, p[4] * 0.9 + p[3] * 0.4, p[5]];"
        "s.hold(1, [0, 0, 0], goal); s.advanceTo(6); s.computePose();"
        "result.push(energy(), s.placeOf(1, [0, 0, 0]), goal, s.isPulled); s.release(); s.advanceTo(7);"
        "result.push(energy(), s.isPulled);",
    )
    first, pulled, place, goal, is_pulled, later, still_pulled = found
    assert pulled == pytest.approx(first, abs=1e-5) and later == pytest.approx(first, abs=1e-5)
    assert np.linalg.norm(np.subtract(place, goal)) < 0.25 and is_pulled and not still_pulled


def test_bodies_without_joints_can_be_pulled() -> None:
    bodies = [sb.Body(name, mass=1, inertia=(1, 1, 1)) for name in "AB"]
    eqs = sb.form_equations(sb.Model("loose", [*bodies, sb.Revolute("J", "ground", "A", coordinate="a")]))
    assert program(eqs).motion.wrench is not None


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ({"inputs": {"F": lambda t, q, u: 1.0}}, "animation.live_input"),
        ({"integrator": sb.Stiff()}, "animation.live_integrator"),
        ({"constraints": sb.GGL()}, "animation.live_constraints"),
        ({"constraints": sb.Partition()}, "animation.live_constraints"),
    ],
)
def test_what_needs_python_is_refused(words: dict[str, Any], code: str) -> None:
    with pytest.raises(UsageError) as caught:
        program(equations("slider_crank"), **words)
    assert [problem.code for problem in caught.value.problems] == [code]


@needs_node
def test_a_page_by_generalized_alpha_follows_its_sliders(run: Callable[[SimulationText, str], Any]) -> None:
    """A stiff damper and a spring: the rate of the slow one after a parameter has changed at t = 1."""
    slow = sb.Drive(applied="-k*x - 2e4*(x_dot - y_dot)")
    fast = sb.Drive(applied="2e4*(x_dot - y_dot)")
    parts = [
        sb.Prismatic("a", "ground", sb.Body("A", 1), axis="x", coordinate="x", force=slow),
        sb.Prismatic("b", "ground", sb.Body("B", 1), axis="x", coordinate="y", force=fast),
    ]
    eqs = sb.form_equations(sb.Model("stiff", parts, parameters={"k": 2.0}, initial={"x": 1.0, "x_dot": 1.0}))
    text = program(eqs, tunable=("k",), integrator=sb.GeneralizedAlpha(), rtol=1e-7)
    script = (
        "s.advanceTo(1); s.setParameter('k', 8); s.advanceTo(2); result = [...s.state, s.counts().accepted];"
    )
    *state, steps = run(text, script)
    halves = sb.simulate(eqs, 1.0, rtol=1e-10)
    start = {name: halves[name][-1] for name in eqs.state_names}
    end = sb.simulate(eqs, 1.0, start, parameters={"k": 8.0}, rtol=1e-10)
    assert np.abs(np.array(state[:4]) - [end[name][-1] for name in eqs.state_names]).max() < 1e-4
    assert steps < 2000  # an explicit method needs 2e4/3 steps a second to be stable


@needs_node
def test_stick_slip_belt_in_a_page_is_that_of_simulate(run: Callable[[SimulationText, str], Any]) -> None:
    """A block on a belt, held by a spring: it sticks to the belt until the spring tears it off, again and again."""
    parts = [
        sb.Prismatic("belt", "ground", sb.Body("Belt", 1), coordinate="b", motion="0.1*t"),
        sb.Prismatic("slide", "Belt", sb.Body("Block", 1), coordinate="x",
                     friction=sb.Friction(force=2.0, static=3.0)),
        sb.SpringDamper("spring", "ground", "Block", stiffness=20, free=0),
    ]  # fmt: skip
    eqs = sb.form_equations(sb.Model("belt", parts, initial={"x": 0.05, "x_dot": 0.0}))
    times = np.linspace(0.0, 6.0, 61)
    motion = sb.simulate(eqs, 6.0, times=times, rtol=1e-10)
    assert sum(change.mode == "sticks" for change in motion.modes) > 2
    place = eqs.state_names.index("x")
    asked = f"{json.dumps(times[1:].tolist())}.map((t) => {{ s.advanceTo(t); return s.state[{place}]; }})"
    shown = run(program(eqs, rtol=1e-10), f"result = {asked};")
    assert np.abs(np.array(shown) - motion["x"][1:]).max() < 1e-8
