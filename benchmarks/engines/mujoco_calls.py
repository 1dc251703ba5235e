"""MuJoCo's forward and inverse dynamics without contacts and limits, called by address."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from typing import Any, Final

import mujoco
import numpy as np

from benchmarks.engines.call_loops.loops import Floats, loops, rows
from benchmarks.robot_states import States
from symbody.model.naming import make_symbol

# Meshes are not needed, and MuJoCo reads few of their formats.
_SHAPES: Final = re.compile(r"<(visual|collision)\b.*?</\1>", re.S)
# Inertias of 0, which MuJoCo refuses.
_NO_MASS: Final = re.compile(
    r"<inertial>((?!</inertial>).)*<mass value=[\"']0(\.0*)?[\"']\s*/>.*?</inertial>", re.S
)
_ROOT: Final = re.compile(r"<robot\b[^>]*>")


class MujocoCalls:
    """A robot in MuJoCo at the states of `states`, matched by the names of joints.

    Attributes
    ----------
    model, data : mujoco.MjModel, mujoco.MjData
    q, u, tau, a : arrays
        In MuJoCo's order; the velocity of a free base in axes of the world.
    order : array of int
        Where each component of qacc stands in symbody's u.
    turned : list of int
        Components along axes of the world, which symbody has along those of the base.
    """

    def __init__(self, states: States, floating: bool) -> None:
        self.model = _model(states.text, floating)
        self.data: Any = mujoco.MjData(self.model)
        count, eqs = len(states.q), states.eqs
        coordinate = {name: k for k, name in enumerate(eqs.coordinate_names)}
        speed = {name: k for k, name in enumerate(eqs.speed_names)}
        effort = {name: k for k, name in enumerate(eqs.input_names)}
        self.q, self.turned = np.zeros((count, self.model.nq)), []
        self.u, self.tau, self.a = np.zeros((3, count, self.model.nv))
        self.order = np.zeros(self.model.nv, dtype=np.int64)
        for k in range(self.model.njnt):
            joint = self.model.joint(k)
            at, place = int(joint.qposadr[0]), int(joint.dofadr[0])
            if joint.type[0] == mujoco.mjtJoint.mjJNT_FREE:
                pose = [coordinate[f"base_{part}"] for part in ("x", "y", "z", "qw", "qx", "qy", "qz")]
                twist = [speed[f"base_{part}"] for part in ("vx", "vy", "vz", "wx", "wy", "wz")]
                self.q[:, at : at + 7] = states.q[:, pose]
                self.order[place : place + 6] = twist
                self.turned = [place, place + 1, place + 2]
                v, w = states.u[:, twist[:3]], states.u[:, twist[3:]]
                R = _rotations(self.q[:, at + 3 : at + 7])
                self.u[:, place : place + 3] = np.einsum("kij,kj->ki", R, v)
                self.u[:, place + 3 : place + 6] = w
                inertial = states.udot[:, twist[:3]] + np.cross(w, v)
                self.a[:, place : place + 3] = np.einsum("kij,kj->ki", R, inertial)
                self.a[:, place + 3 : place + 6] = states.udot[:, twist[3:]]
                continue
            name = make_symbol(joint.name)
            self.q[:, at] = states.q[:, coordinate[name]]
            self.order[place] = speed[f"{name}_dot"]
            self.u[:, place] = states.u[:, self.order[place]]
            self.a[:, place] = states.udot[:, self.order[place]]
            if f"tau_{name}" in effort:
                self.tau[:, place] = states.r[:, effort[f"tau_{name}"]]

    def result(self, k: int, inverse: bool = False) -> Floats:
        """Return accelerations or efforts of one state as a user gets them; see `turned`."""
        data = self.data
        data.qpos[:], data.qvel[:] = self.q[k], self.u[k]
        if inverse:
            data.qacc[:] = self.a[k]
            mujoco.mj_inverse(self.model, data)
            return np.array(data.qfrc_inverse)
        data.qfrc_applied[:] = self.tau[k]
        mujoco.mj_forward(self.model, data)
        return np.array(data.qacc)

    def nanoseconds(self, inverse: bool = False) -> float:
        """Return what `mj_forward` or `mj_inverse` takes, state after state [ns]."""
        data = self.data
        word, given, found, x = "mj_forward", data.qfrc_applied, data.qacc, self.tau
        if inverse:
            word, given, found, x = "mj_inverse", data.qacc, data.qfrc_inverse, self.a
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco*"))))
        took: float = loops().time_mujoco(
            ctypes.cast(getattr(library, word), ctypes.c_void_p),
            ctypes.c_void_p(self.model._address),
            ctypes.c_void_p(data._address),
            ctypes.c_long(len(self.q)),
            *rows(self.q, self.u),
            *(ctypes.c_void_p(array.ctypes.data) for array in (x, data.qpos, data.qvel, given, found)),
        )
        return took


def _rotations(e: Floats) -> Floats:
    """Return rotation matrices of quaternions with the scalar first."""
    w, x, y, z = e.T
    matrix = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(matrix), -1, 0)


def _model(text: str, floating: bool) -> Any:
    options = '<mujoco><compiler discardvisual="true" fusestatic="true" balanceinertia="true"/></mujoco>'
    root = _ROOT.search(text)
    head = root.group(0) if root else ""
    text = _NO_MASS.sub("", _SHAPES.sub("", text)).replace(head, head + options, 1)
    specification: Any = mujoco.MjSpec.from_string(text)
    if floating:
        specification.worldbody.first_body().add_freejoint()
    flags = mujoco.mjtDisableBit
    specification.option.disableflags = int(flags.mjDSBL_CONSTRAINT | flags.mjDSBL_CONTACT)
    return specification.compile()
