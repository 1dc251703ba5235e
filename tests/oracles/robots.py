"""Robots from URDF beside Pinocchio: one state by name, both programs' matrices and accelerations."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.formats import model_from_urdf, robot_from_text
from symbody.model.naming import make_symbol
from tests.oracles.comparison import Floats

POSITION, TWIST = ("x", "y", "z", "qw", "qx", "qy", "qz"), ("vx", "vy", "vz", "wx", "wy", "wz")
_DYNAMICS = re.compile(r"<dynamics\b[^>]*?(/>|>\s*</dynamics>)")
_ANGLES = re.compile(r"""\brpy\s*=\s*["']([-+.eE\d\s]*)["']""")


def example_robots() -> list[Path]:
    """The URDF files of example-robot-data, or a skip where it is not installed."""
    package: Any = pytest.importorskip("pinocchio")
    for folder in Path(package.__file__).parents:
        found = sorted((folder / "share" / "example-robot-data" / "robots").rglob("*.urdf"))
        if found:
            return found
    pytest.skip("example-robot-data is not installed")


def comparable(text: str) -> str:
    """A robot as both programs read it alike.

    Pinocchio's algorithms leave damping and friction out; angles within 2e-11 of a multiple of pi/12 are that
    for symbody.
    """

    def exact(found: re.Match[str]) -> str:
        values = []
        for value in map(float, found.group(1).split()):
            near = round(value * 12 / math.pi) * math.pi / 12
            values.append(near if abs(value - near) <= 2e-11 else value)
        return f'rpy="{" ".join(map(repr, values))}"'

    return _ANGLES.sub(exact, _DYNAMICS.sub("", text))


@dataclass(frozen=True, slots=True)
class PinocchioRobot:
    """A robot in Pinocchio; joints that follow others are tied by rows ``J u = 0``.

    Attributes
    ----------
    ties : list of (follower, leader, factor, offset)
    """

    pin: Any
    model: Any
    data: Any
    ties: list[tuple[str, str, float, float]]

    @classmethod
    def of(cls, text: str, floating: bool) -> PinocchioRobot:
        pin: Any = pytest.importorskip("pinocchio")
        model = pin.buildModelFromXML(text, *([pin.JointModelFreeFlyer()] if floating else []))
        joints = robot_from_text(text).joints
        ties = []
        for joint in joints.values():
            factor, offset, leader = 1.0, 0.0, joint
            while leader.mimic is not None:
                offset += factor * float(leader.mimic.offset)
                factor *= float(leader.mimic.multiplier)
                leader = joints[leader.mimic.leader]
            if leader is not joint:
                ties.append((make_symbol(joint.name), make_symbol(leader.name), factor, offset))
        return cls(pin, model, model.createData(), ties)

    @property
    def joints(self) -> list[tuple[str, Any]]:
        return [
            (make_symbol(str(name)), joint)
            for name, joint in zip(self.model.names, self.model.joints, strict=True)
        ][1:]

    @property
    def speeds(self) -> list[str]:
        """What symbody calls the components of v."""
        names: list[str] = []
        for name, joint in self.joints:
            if joint.nv == 6:
                prefix = "base" if name == "root_joint" else name
                names += [f"{prefix}_{part}" for part in TWIST]
            else:
                names.append(f"{name}_dot")
        return names

    def state(self, number: int) -> tuple[dict[str, float], dict[str, float]]:
        """Random coordinates and speeds by symbody's names; followers where their leaders put them."""
        random = np.random.default_rng(number)
        q: dict[str, float] = {}
        u = dict(zip(self.speeds, random.uniform(-1.0, 1.0, len(self.speeds)), strict=True))
        for name, joint in self.joints:
            if joint.nv == 6:
                prefix = "base" if name == "root_joint" else name
                e = random.normal(size=4)
                values = [*random.uniform(-1.0, 1.0, 3), *(e / np.linalg.norm(e))]
                q.update(zip((f"{prefix}_{part}" for part in POSITION), values, strict=True))
            else:
                q[name] = random.uniform(-2.0, 2.0)
        for own, leader, factor, offset in self.ties:
            q[own] = factor * q[leader] + offset
            u[f"{own}_dot"] = factor * u[f"{leader}_dot"]
        return q, u

    def vectors(self, q: Mapping[str, float], u: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Pinocchio's q and v: quaternions with the scalar last, continuous angles as cosine and sine."""
        here = self.pin.neutral(self.model)
        for name, joint in self.joints:
            place = slice(joint.idx_q, joint.idx_q + joint.nq)
            if joint.nv == 6:
                prefix = "base" if name == "root_joint" else name
                x, y, z, e0, e1, e2, e3 = (q[f"{prefix}_{part}"] for part in POSITION)
                here[place] = x, y, z, e1, e2, e3, e0
            else:
                here[place] = (np.cos(q[name]), np.sin(q[name])) if joint.nq == 2 else q[name]
        return here, np.array([u[name] for name in self.speeds])

    def matrices(self, q: Mapping[str, float], u: Mapping[str, float]) -> tuple[Floats, Floats]:
        """Mass matrix and what gravity and velocities need of effort."""
        here, v = self.vectors(q, u)
        M = np.array(self.pin.crba(self.model, self.data, here))
        M = np.triu(M) + np.triu(M, 1).T
        return M, np.array(self.pin.nonLinearEffects(self.model, self.data, here, v))

    def inverse(self, q: Mapping[str, float], u: Mapping[str, float], a: Floats) -> Floats:
        """Efforts that give accelerations, by the recursive Newton-Euler algorithm."""
        here, v = self.vectors(q, u)
        return np.array(self.pin.rnea(self.model, self.data, here, v, a))

    def accelerations(self, q: Mapping[str, float], u: Mapping[str, float], tau: Floats) -> Floats:
        """By the articulated-body algorithm, or with ties by all equations at once."""
        if not self.ties:
            here, v = self.vectors(q, u)
            return np.array(self.pin.aba(self.model, self.data, here, v, tau))
        M, h = self.matrices(q, u)
        J = np.zeros((len(self.ties), len(M)))
        for row, (own, leader, factor, _) in zip(J, self.ties, strict=True):
            row[self.speeds.index(f"{own}_dot")] = 1.0
            row[self.speeds.index(f"{leader}_dot")] = -factor
        K = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
        found: Floats = np.linalg.solve(K, np.concatenate([tau - h, np.zeros(len(J))]))[: len(M)]
        return found


def loaded(text: str, floating: bool) -> sb.Model:
    """The robot as symbody sees it."""
    return model_from_urdf(text, floating_base=floating)
