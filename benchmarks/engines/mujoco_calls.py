"""MuJoCo's forward and inverse dynamics without contacts and limits, called by address."""

from __future__ import annotations

import ctypes
import re
from pathlib import Path
from typing import Any, Final

import mujoco
import numpy as np

from benchmarks.engines.call_loops.loops import loops, rows

# Meshes are not needed, and MuJoCo reads few of their formats.
_SHAPES: Final = re.compile(r"<(visual|collision)\b.*?</\1>", re.S)
# Inertias of 0, which MuJoCo refuses.
_NO_MASS: Final = re.compile(
    r"<inertial>((?!</inertial>).)*<mass value=[\"']0(\.0*)?[\"']\s*/>.*?</inertial>", re.S
)
_ROOT: Final = re.compile(r"<robot\b[^>]*>")


class MujocoCalls:
    """A robot in MuJoCo at given states; they are its own random ones, of the same kinds.

    Parameters
    ----------
    text : str
        URDF.
    floating : bool
        Whether the root link is free.
    """

    def __init__(self, text: str, floating: bool, count: int) -> None:
        self.model = _model(text, floating)
        self.data: Any = mujoco.MjData(self.model)
        random = np.random.default_rng(2024)
        self.q = random.uniform(-2.0, 2.0, (count, self.model.nq))
        if floating:
            e = random.normal(size=(count, 4))
            self.q[:, 3:7] = e / np.linalg.norm(e, axis=1, keepdims=True)
        self.u, self.x = random.uniform(-1.0, 1.0, (2, count, self.model.nv))
        if floating:
            self.x[:, :6] = 0.0

    def nanoseconds(self, inverse: bool = False) -> float:
        """Return what `mj_forward` or `mj_inverse` takes, state after state [ns]."""
        data = self.data
        word, given, found = "mj_forward", data.qfrc_applied, data.qacc
        if inverse:
            word, given, found = "mj_inverse", data.qacc, data.qfrc_inverse
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco*"))))
        took: float = loops().time_mujoco(
            ctypes.cast(getattr(library, word), ctypes.c_void_p),
            ctypes.c_void_p(self.model._address),
            ctypes.c_void_p(data._address),
            ctypes.c_long(len(self.q)),
            *rows(self.q, self.u),
            *(ctypes.c_void_p(x.ctypes.data) for x in (self.x, data.qpos, data.qvel, given, found)),
        )
        return took


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
