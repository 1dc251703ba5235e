"""MuJoCo on bodies that fall: its own contact, as stiff and as lossy at an impact, in its own loop."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.contact_problems import GRAVITY, MU, SAMPLE, Falling, Floats

_JOINTS = {
    "line": '<joint type="slide" axis="0 0 1"/>',
    "plane": '<joint type="slide" axis="0 0 1"/><joint type="slide" axis="1 0 0"/>'
    '<joint type="hinge" axis="0 1 0"/>',
    "space": "<freejoint/>",
}


def motion(problem: Falling) -> Callable[[str, float], Floats]:
    """Return what moves a body by an integrator in steps of a length, and gives its places at the samples."""
    model = mujoco.MjModel.from_xml_string(describe(problem))
    data = mujoco.MjData(model)
    mujoco.set_mju_user_warning(lambda text: None)  # steps that are too long are expected, and judged later
    first = np.concatenate([[0.0], _start(problem)])
    places = {"line": 1, "plane": 2, "space": 3}[problem.place]

    def move(integrator: str, step: float) -> Floats:
        model.opt.timestep = step
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        every = round(SAMPLE / step)
        state, _ = rollout.rollout(model, data, first, nstep=every * problem.times.size)
        return np.array(state[0, every - 1 :: every, 1 : 1 + places].T)

    return move


def describe(problem: Falling) -> str:
    """Return the scene in MuJoCo's XML.

    Its contact is a spring and a damper for each unit of mass: with the duration of an elastic impact by
    Hertz's law, and the damping with which a spring and a damper have the restitution.
    """
    rate, loss = math.pi / problem.duration, -math.log(problem.restitution)
    damping = 2 * rate * loss / math.hypot(math.pi, loss)
    law = f'solref="{-rate * rate} {-damping}" solimp="0.99 0.99 0.001"'
    shape = "sphere" if problem.is_ball else "box"
    size = " ".join(str(each if problem.is_ball else each / 2) for each in problem.sizes)
    sliding = f'friction="{MU}" condim="{1 if problem.place == "line" else 3}"'
    return (
        f'<mujoco><option gravity="0 0 {-GRAVITY}"><flag autoreset="disable"/></option>'
        f'<default><geom {law}/></default><worldbody><geom type="plane" size="0 0 1" {sliding}/>'
        f'<body>{_JOINTS[problem.place]}<geom type="{shape}" size="{size}" mass="{problem.mass}" {sliding}/>'
        "</body></worldbody></mujoco>"
    )


def _start(problem: Falling) -> Floats:
    """Return its first coordinates and speeds; in space rates are along the axes of the body."""
    if problem.place == "line":
        return np.array([problem.height, 0.0])
    if problem.place == "plane":
        x, w = problem.velocity[0], problem.rates[1]
        return np.array([problem.height, 0.0, problem.angles[1], 0.0, x, w])
    return np.array([0, 0, problem.height, *problem.quaternion, *problem.velocity, *problem.rates])
