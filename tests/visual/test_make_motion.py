"""Poses over time: they are those of the run, few, and what is interpolated between them is as near as promised."""

from __future__ import annotations

from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import symbody as sb
from symbody.errors import UsageError
from symbody.visual.scene import make_motion, make_scene
from symbody.visual.scene.body_poses import Poses, angle_between, interpolate, of_one_sign, slerp
from symbody.visual.scene.sampling import ANGLE, CURVE_SHARE, LENGTH_SHARE
from symbody.visual.scene.scene import Scene, SceneMotion
from symbody.visual.viewer.still import run_of_state
from tests.tiers import cases, rows

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = ["bicycle", "four_bar", "projectile", "rr_robot", "slider_crank", "spatial_four_bar", "spinning_top",
         "spring_mass_damper"]  # fmt: skip


@cache
def run_of(name: str, tree: str | None = None, end: float = 3.0) -> sb.Trajectory:
    model = sb.load_model(EXAMPLES / name / f"{name}.toml")
    return sb.simulate(sb.form_equations(model, tree=tree), end)


def scene_of(run: sb.Trajectory) -> Scene:
    assert run.model is not None
    return make_scene(run.model, run.parameters)


def poses_at(run: sb.Trajectory, scene: Scene, times: np.ndarray) -> Poses:
    """Poses by the outputs of each body relative to ground."""
    there = run.at(times)
    names = [body.name for body in scene.bodies[1:]]
    positions = np.array([there[f"frame r {name}"].T for name in names])
    rotations = [Rotation.from_matrix(np.moveaxis(there[f"frame R {name}"], -1, 0)) for name in names]
    quaternions = np.array([rotation.as_quat()[:, [3, 0, 1, 2]] for rotation in rotations])
    return Poses(np.moveaxis(positions, 0, 1), np.moveaxis(quaternions, 0, 1))


def poses_of(motion: SceneMotion) -> Poses:
    return Poses(motion.positions, motion.quaternions)


@pytest.mark.parametrize(
    ("name", "tree"),
    rows(
        product(["four_bar", "spatial_four_bar"], [None, "absolute"]),
        fast=[("four_bar", "absolute"), ("spatial_four_bar", None)],
    ),
)
def test_poses_are_those_of_the_run(name: str, tree: str | None) -> None:
    run = run_of(name, tree, 0.5)
    scene = scene_of(run)
    motion = make_motion(run, scene)
    truth = poses_at(run, scene, motion.times)
    # Composed along the joints, so rounding adds up over a few rotations.
    np.testing.assert_allclose(motion.positions, truth.positions, rtol=0.0, atol=1e-13)
    assert angle_between(motion.quaternions, truth.quaternions).max() < 1e-12
    np.testing.assert_allclose(np.linalg.norm(motion.quaternions, axis=-1), 1.0, rtol=1e-14)


@pytest.mark.parametrize("name", cases(NAMES, fast=lambda name: name != "bicycle"))
def test_between_samples_the_error_is_bounded(name: str) -> None:
    run = run_of(name)
    scene = scene_of(run)
    motion = make_motion(run, scene)
    assert motion.times.size < 1000
    times = np.random.default_rng(0).uniform(motion.times[0], motion.times[-1], 2000)
    before = np.clip(np.searchsorted(motion.times, times) - 1, 0, motion.times.size - 2)
    shares = (times - motion.times[before]) / np.diff(motion.times)[before]
    guess, truth = interpolate(poses_of(motion), before, shares), poses_at(run, scene, times)
    assert np.linalg.norm(guess.positions - truth.positions, axis=-1).max() < LENGTH_SHARE * scene.size
    assert angle_between(guess.quaternions, truth.quaternions).max() < ANGLE
    for curve in motion.curves:
        off = np.abs(np.interp(times, motion.times, curve.values) - run.at(times)[curve.name]).max()
        assert off < CURVE_SHARE * np.ptp(curve.values) + 1e-12


def test_rest_needs_two_samples() -> None:
    body = sb.Body("Rod", mass=1, inertia=(1, 1, 1))
    model = sb.Model("rest", [sb.Revolute("hinge", "ground", body, axis="z", coordinate="phi")])
    run = sb.simulate(sb.form_equations(model), 100.0)
    assert make_motion(run, scene_of(run)).times.tolist() == [0.0, 100.0]


@pytest.mark.exhaustive
def test_a_long_run_stays_small() -> None:
    run = run_of("four_bar", None, 400.0)
    motion = make_motion(run, scene_of(run))
    assert run.t.size > 20_000 > 4000 >= motion.times.size > 3000
    assert (np.diff(motion.times) > 0.0).all() and motion.times[-1] == 400.0


def test_quaternions_are_of_one_sign() -> None:
    run = run_of("spinning_top")
    motion = make_motion(run, scene_of(run))
    products = (motion.quaternions[1:] * motion.quaternions[:-1]).sum(axis=-1)
    assert (products > 0.0).all()
    flipped = of_one_sign(
        motion.quaternions * np.where(np.arange(motion.times.size) % 3, 1.0, -1.0)[:, None, None]
    )
    np.testing.assert_array_equal(flipped, -motion.quaternions)


def test_interpolation_is_rotation_about_a_fixed_axis() -> None:
    first = np.array([1.0, 0.0, 0.0, 0.0])
    for angle in (1e-12, 1e-6, 0.3, 3.0, np.pi - 1e-9):
        second = -np.array(
            [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]
        )  # the other sign: the same rotation
        for share in (0.0, 0.25, 1.0):
            between = slerp(first, second, np.array(share))
            expected = [np.cos(share * angle / 2), 0.0, 0.0, np.sin(share * angle / 2)]
            np.testing.assert_allclose(between, expected, rtol=0.0, atol=1e-15 + 1e-9 * (angle > 3.1))


def test_times_are_taken_as_they_are() -> None:
    run = run_of("four_bar")
    motion = make_motion(run, scene_of(run), times=[0.5, 0.1, 0.5])
    assert motion.times.tolist() == [0.1, 0.5]
    part = make_motion(run, scene_of(run), span=(0.5, 1.0))
    assert (part.times[0], part.times[-1]) == (0.5, 1.0)


def test_runs_without_dense_output_show_their_samples(tmp_path: Path) -> None:
    eqs = run_of("slider_crank").evaluate.problem.eqs  # type: ignore[union-attr]
    times = np.linspace(0.0, 0.3, 7)
    case = sb.sweep(eqs, 0.3, times=times, parameters={"L1": [0.3, 0.4]}).trajectory(0)
    assert case.dense_output is None
    scene = make_scene(case.model, case.parameters)  # type: ignore[arg-type]
    motion = make_motion(case, scene)
    assert np.isin(motion.times, times).all()
    places = np.searchsorted(times, motion.times)
    np.testing.assert_allclose(motion.positions[:, 0].T, case["frame r Crank"][:, places], atol=1e-14)
    assert make_motion(case, scene, times=times[2:4]).times.tolist() == times[2:4].tolist()
    with pytest.raises(UsageError, match="between the samples was not stored"):
        make_motion(case, scene, times=[0.123])


def test_backwards_motions_run_forwards_in_time() -> None:
    model = sb.load_model(EXAMPLES / "projectile" / "projectile.toml")
    run = sb.simulate(sb.form_equations(model), (1.0, 0.0))
    motion = make_motion(run, scene_of(run))
    assert (motion.times[0], motion.times[-1]) == (0.0, 1.0) and (np.diff(motion.times) > 0.0).all()
    np.testing.assert_allclose(motion.positions[0, 0], run.at(0.0)[f"frame r {scene_of(run).bodies[1].name}"])


def hammer(**changes: object) -> sb.Model:
    """A pendulum with a spring to ground, a force in its own axes and a torque."""
    rod = sb.Body("Rod", mass=2, inertia=(0, 0, "1/6"),
                  frames={"pin": sb.Frame(at=(-0.5, 0, 0)), "tip": sb.Frame(at=(0.5, 0, 0))})  # fmt: skip
    parts = [
        rod, sb.Revolute("hinge", "ground", rod["pin"], axis="z", coordinate="phi"),
        sb.Force("push", rod["tip"], (0, "F*sin(t)", 0), resolved_in=rod), sb.Torque("wind", rod, (0, 0, 3)),
        sb.SpringDamper("wire", "ground.post", rod["tip"], stiffness=50, free="1/2"),
    ]  # fmt: skip
    return sb.Model(
        "hammer", parts, gravity=(0, -9.81, 0), ground={"post": sb.Frame(at=(0, 1, 0))}, inputs=["F"]
    )


def test_forces_have_their_place_and_their_axes() -> None:
    run = sb.simulate(sb.form_equations(hammer()), 1.0, initial={"phi": 0.3}, inputs={"F": 7})
    scene = scene_of(run)
    motion = make_motion(run, scene, vectors="all")
    there = run.at(motion.times)
    arrows = {(vector.name, vector.kind): vector for vector in motion.vectors}
    assert set(arrows) == {("force push", "force"), ("torque wind", "torque"), ("spring wire", "force"),
                           ("reaction hinge", "force")}  # fmt: skip
    phi, t = there["phi"], motion.times
    push = 7 * np.sin(t) * np.array([-np.sin(phi), np.cos(phi), 0 * t])
    np.testing.assert_allclose(arrows["force push", "force"].values, push.T, atol=1e-12)
    np.testing.assert_array_equal(arrows["torque wind", "torque"].values, [[0.0, 0.0, 3.0]] * t.size)
    tip = np.array([np.cos(phi), np.sin(phi) - 1.0, 0 * t])
    length = np.linalg.norm(tip, axis=0)
    np.testing.assert_allclose(
        arrows["spring wire", "force"].values, (-50 * (length - 0.5) * tip / length).T, atol=1e-9
    )
    reaction = arrows["reaction hinge", "force"]
    np.testing.assert_allclose(
        reaction.values, there["reaction hinge"][:3].T, atol=1e-9
    )  # ground's axes are its own
    rod = [body.name for body in scene.bodies].index("Rod")
    assert (reaction.anchor.body, reaction.anchor.at) == (rod, (-0.5, 0.0, 0.0))
    assert arrows["force push", "force"].anchor.at == (0.5, 0.0, 0.0)


def test_forces_are_chosen_by_name() -> None:
    run = sb.simulate(sb.form_equations(hammer()), 0.1, inputs={"F": 7})
    scene = scene_of(run)

    def names(vectors: object) -> list[str]:
        return [vector.name for vector in make_motion(run, scene, vectors=vectors).vectors]  # type: ignore[arg-type]

    assert names(None) == names("applied") == ["force push", "torque wind"]
    assert names("none") == names(()) == []
    assert names("hinge") == names(["reaction hinge"]) == ["reaction hinge"]
    assert names(["wire", "push"]) == ["spring wire", "force push"]
    with pytest.raises(UsageError, match="did you mean 'hinge'") as caught:
        names(["hinges"])
    assert caught.value.problems[0].code == "animation.unknown_vector"


def test_curves_are_outputs_with_their_units() -> None:
    run = run_of("slider_crank")
    motion = make_motion(run, scene_of(run), curves=["s", "energy", "frame r Rod"])
    assert [(curve.name, curve.unit) for curve in motion.curves] == [
        ("s", "m"), ("energy", "J"), ("r Rod x", "m"), ("r Rod y", "m"), ("r Rod z", "m")]  # fmt: skip
    np.testing.assert_array_equal(motion.curves[1].values, run.at(motion.times)["energy"])


def test_events_are_told() -> None:
    model = sb.load_model(EXAMPLES / "slider_crank" / "slider_crank.toml")
    run = sb.simulate(sb.form_equations(model), 1.0, events=sb.Event("s - 1.2", name="half way"))
    motion = make_motion(run, scene_of(run))
    assert [name for name, _ in motion.events] == [name for name, _, _ in run.events] != []


@pytest.mark.exhaustive
def test_two_hundred_bodies_are_computed_by_one_function() -> None:
    parts: list[object] = []
    before: object = "ground"
    for k in range(200):
        rod = sb.Body(
            f"B{k}",
            mass=1,
            inertia=(1, 1, 1),
            frames={"a": sb.Frame(at=(-1, 0, 0)), "b": sb.Frame(at=(1, 0, 0))},
        )
        parts += [rod, sb.Revolute(f"J{k}", before, rod["a"], axis="xyz"[k % 3], coordinate=f"q{k}")]
        before = rod["b"]
    model = sb.Model("chain", parts)  # type: ignore[arg-type]
    state = sb.assemble(sb.form_equations(model), {f"q{k}": 0.01 * k for k in range(200)})
    run = run_of_state(state)
    motion = make_motion(run, scene_of(run), curves=())
    functions = run.evaluate.problem._functions  # type: ignore[union-attr]
    assert len(functions) == 1
    np.testing.assert_allclose(motion.positions[0, -1], run["frame r B199"][:, 0], atol=1e-10)
