"""MuJoCo on stiff mechanisms: steps of its own loop, contact and friction as callbacks with the same laws."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import singledispatch
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

from benchmarks.stiff_problems import GRAVITY, Ball, Beam, Box, Bushing, Floats, Stiff

Law = Callable[[float, float], float]


def motion(problem: Stiff, end: float, integrator: str) -> Callable[[float], Floats]:
    """Return what moves a mechanism for `end` seconds in steps of a length, and gives coordinates there."""
    bodies, start, law = describe(problem)
    flags = '<flag contact="disable" autoreset="disable"/>'  # what became unstable shall be seen
    option = f'<option gravity="0 {-GRAVITY} 0" integrator="{integrator}">{flags}</option>'
    text = f"<mujoco>{option}<worldbody>{bodies}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.set_mju_user_warning(lambda text: None)  # steps that are too long are expected, and judged later
    first = np.concatenate([[0.0], start, np.zeros(model.nv)])

    def passive(model: Any, data: Any) -> None:
        data.qfrc_passive[0] += 0.0 if law is None else law(data.qpos[0], data.qvel[0])

    def move(step: float) -> Floats:
        model.opt.timestep = step
        mujoco.set_mjcb_passive(None if law is None else passive)
        try:
            state, _ = rollout.rollout(model, data, first, nstep=round(end / step))
        finally:
            mujoco.set_mjcb_passive(None)
        return np.array(state[0, -1, 1 : 1 + model.nq])

    return move


@singledispatch
def describe(problem: Any) -> tuple[str, Floats, Law | None]:
    """Return the bodies in MuJoCo's XML, the coordinates at the start, and a force on the first of them."""
    raise TypeError(problem)


@describe.register
def _(problem: Beam) -> tuple[str, Floats, Law | None]:
    text = ""
    for k in range(problem.count):
        spring = f'stiffness="{problem.stiffness}" damping="{problem.delay * problem.stiffness}"' if k else ""
        text += f'<body pos="{problem.length if k else 0} 0 0"><joint type="hinge" axis="0 0 1" {spring}/>'
        text += _inertial(problem.mass, problem.inertia, (0.5 * problem.length, 0, 0))
    return text + "</body>" * problem.count, np.zeros(problem.count), None


@describe.register
def _(problem: Bushing) -> tuple[str, Floats, Law | None]:
    rubber = f'stiffness="{problem.stiffness}" damping="{problem.damping}"'
    text = "<body>"
    for axis in ("1 0 0", "0 1 0"):
        text += f'<joint type="slide" axis="{axis}" {rubber}/>'
    text += '<joint type="hinge" axis="0 0 1"/>'
    moments = (0.5 * problem.inertia, 0.5 * problem.inertia, problem.inertia)  # a plane motion has the last
    text += _inertial(problem.mass, moments, (0, -problem.arm, 0)) + "</body>"
    return text, np.array([0.0, 0.0, problem.start]), None


@describe.register
def _(problem: Ball) -> tuple[str, Floats, Law | None]:
    k, d = problem.stiffness, problem.damping

    def law(y: float, rate: float) -> float:
        return float(k * max(-y, 0.0) ** 1.5 * (1.0 - d * rate))

    return _slider("0 1 0", problem.mass), np.array([problem.height]), law


@describe.register
def _(problem: Box) -> tuple[str, Floats, Law | None]:
    k, v0, strength = problem.stiffness, problem.v0, problem.mu * problem.mass * GRAVITY

    def law(x: float, rate: float) -> float:
        return -k * x - strength * rate / math.sqrt(rate * rate + v0 * v0)

    return _slider("1 0 0", problem.mass), np.array([problem.start]), law


def _slider(axis: str, mass: float) -> str:
    return f'<body><joint type="slide" axis="{axis}"/>{_inertial(mass, (mass,) * 3, (0, 0, 0))}</body>'


def _inertial(mass: float, moments: tuple[float, ...], at: tuple[float, ...]) -> str:
    values = " ".join(map(str, moments))
    return f'<inertial pos="{" ".join(map(str, at))}" mass="{mass}" diaginertia="{values}"/>'
