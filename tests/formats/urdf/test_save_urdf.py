"""Robots written and read again: the same dynamics; what URDF cannot say is refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats import model_from_urdf, model_to_urdf
from tests.faults.refusals import refused
from tests.formats.urdf.robots import arm, joint, link, robot
from tests.oracles.comparison import EPS, computed, sensitivity

ORIGIN = '<origin xyz="0.1 -0.2 0.3" rpy="0.4 1.5707963267948966 -0.7"/>'
CHAIN = robot(
    '<link name="base"/>', link("A"), link("B"), link("C"), '<link name="tip"/>',
    joint("a", "revolute", "base", "A", ORIGIN, '<axis xyz="0 1 0"/>', '<dynamics damping="0.2"/>'),
    joint("b", "prismatic", "A", "B", '<origin rpy="0.1 0.2 0.3"/>', '<axis xyz="1 2 2"/>'),
    joint("c", "planar", "B", "C", '<axis xyz="0 -1 0"/>'),
    joint("f", "fixed", "C", "tip", '<origin xyz="0 0 1" rpy="0 0.5 0"/>'),
)  # fmt: skip
FOLLOWER = robot(
    '<link name="base"/>', link("A"), link("B"), joint("a", "continuous", "base", "A", ORIGIN),
    joint("b", "continuous", "A", "B", ORIGIN, '<mimic joint="a" multiplier="-0.5" offset="0.25"/>'),
)  # fmt: skip


@pytest.mark.parametrize(
    "text", [CHAIN, FOLLOWER, arm("floating", ORIGIN)], ids=["chain", "follower", "floating"]
)
def test_round_trip_keeps_the_dynamics(text: str, tmp_path: Path) -> None:
    model = model_from_urdf(text)
    sb.save_urdf(model, tmp_path / "again.urdf")
    again = sb.load_urdf(tmp_path / "again.urdf")
    assert again.coordinates == model.coordinates and again.inputs == model.inputs
    random = np.random.default_rng(5)
    names = [*model.coordinates, *(f"{name}_dot" for name in model.coordinates), *model.inputs]
    names += [name for j in model.joints for name in j.quasi_speed_names]
    values = dict(zip(names, random.uniform(-1, 1, len(names)), strict=True))
    quaternion = [name for j in model.joints for name in j.quaternion or ()]
    length = np.linalg.norm([values[name] for name in quaternion]) if quaternion else 1.0
    values.update({name: values[name] / length for name in quaternion})
    (first, speeds), (second, same) = (
        computed(m, values, "udot", "mass_matrix", "forcing") for m in (model, again)
    )
    assert same == speeds
    # Written with 17 digits, frames are off by a rounding or two in each joint.
    scale = EPS * sensitivity(first["mass_matrix"], first["forcing"], first["udot"])
    assert np.abs(second["udot"] - first["udot"]).max() <= 100 * scale * np.abs(first["udot"]).max()


def test_names_of_frames_are_kept() -> None:
    again = model_from_urdf(model_to_urdf(model_from_urdf(CHAIN)))
    assert {"tip", "C"} <= set(again.body("C").frames)


def test_parameters_become_numbers() -> None:
    body = sb.Body("A", mass="2*m", inertia=("m", "m", "m"), frames={"P": sb.Frame(at=("L", 0, 0))})
    model = sb.Model("r", [sb.Revolute("q", "ground", body["P"])], parameters={"m": 1.5, "L": None})
    assert 'mass value="3"' in model_to_urdf(model, {"L": 2}) and 'xyz="-2 0 0"' in model_to_urdf(
        model, {"L": 2}
    )
    refused(lambda: model_to_urdf(model))


def test_what_urdf_cannot_say_is_all_named() -> None:
    a, b = sb.Body("A", mass=1), sb.Body("B", mass=1)
    elements = [
        sb.Universal("u", "ground", a), sb.Revolute("q", a, b, torque=sb.Drive(stiffness=3), armature=1),
        sb.Revolute("loop", "ground", b), sb.SpringDamper("s", a, b, stiffness=1),
    ]  # fmt: skip
    found = refused(lambda: model_to_urdf(sb.Model("r", elements)))
    assert {code for code, _ in found} == {"urdf.cannot_say"}
    assert {where for _, where in found} == {"joint u", "joint q", "joint loop", "spring s"}
