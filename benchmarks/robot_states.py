"""Robots from URDF with the same random states for symbody and Pinocchio, matched by names."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

import symbody as sb
from benchmarks.operations import Robot, unconstrained
from symbody.formats import model_from_urdf
from symbody.model.naming import make_symbol

Floats = NDArray[np.float64]

STATES: Final = 1000
_POSE: Final = ("x", "y", "z", "qw", "qx", "qy", "qz")
_TWIST: Final = ("vx", "vy", "vz", "wx", "wy", "wz")
# Damping and friction: Pinocchio's recursions leave them out.
_DYNAMICS: Final = re.compile(r"<dynamics\b[^>]*?(/>|>\s*</dynamics>)")


@dataclass(frozen=True, slots=True, eq=False)
class States:
    """Random states of a robot, one a row.

    Attributes
    ----------
    text : str
        The URDF that both sides read.
    model : Model
        The tree alone; joints that mimic others move by themselves.
    eqs : EquationSet
        Its equations.
    q, u, r, udot : arrays
        In symbody's order; r are the efforts of the joints, udot random accelerations.
    pin_model : pinocchio.Model or None
        None where the package is not installed.
    pin_q, pin_v, pin_tau, pin_a : arrays
        The same in Pinocchio's order.
    order : (n_v,) array of int
        Where each component of Pinocchio's v stands in u.
    driven : list of int
        Where what each of symbody's inputs drives stands in Pinocchio's v.
    """

    text: str
    model: sb.Model
    eqs: sb.EquationSet
    q: Floats
    u: Floats
    r: Floats
    udot: Floats
    pin_model: Any
    pin_q: Floats
    pin_v: Floats
    pin_tau: Floats
    pin_a: Floats
    order: NDArray[np.int64]
    driven: list[int]

    def fresh(self) -> sb.EquationSet:
        """Return the equations formed anew: what is kept of the others does not shorten the work."""
        return sb.form_equations(self.model)

    @property
    def r_and_udot(self) -> Floats:
        """Zero efforts and the accelerations: what `inverse_dynamics` takes as r."""
        return np.hstack([0 * self.r, self.udot])


def robot_states(path: Path, robot: Robot, pin: Any, count: int = STATES) -> States:
    """Return a robot with `count` states; angles within 2 rad, rates, efforts, accelerations within 1."""
    text = _DYNAMICS.sub("", path.read_text(encoding="utf-8"))
    tree = unconstrained(model_from_urdf(text, floating_base=robot.floating))
    eqs = sb.form_equations(tree)
    random = np.random.default_rng(2024)
    q = random.uniform(-2.0, 2.0, (count, len(eqs.coordinate_names)))
    for names in eqs.quaternions:
        places = [eqs.coordinate_names.index(name) for name in names]
        e = random.normal(size=(count, 4))
        q[:, places] = e / np.linalg.norm(e, axis=1, keepdims=True)
    u, udot = random.uniform(-1.0, 1.0, (2, count, len(eqs.speed_names)))
    r = random.uniform(-1.0, 1.0, (count, len(eqs.input_names)))
    if pin is None:
        none = np.zeros((0, 0))
        return States(text, tree, eqs, q, u, r, udot, None, none, none, none, none, np.zeros(0, np.int64), [])
    model = pin.buildModelFromXML(text, *([pin.JointModelFreeFlyer()] if robot.floating else []))
    order = np.array([eqs.speed_names.index(name) for name in _speeds(model)])
    pin_q = _positions(model, eqs, q)
    speeds = [f"tau_{name.removesuffix('_dot')}" for name in _speeds(model)]
    driven = [speeds.index(name) for name in eqs.input_names]
    tau = np.zeros((count, model.nv))
    tau[:, driven] = r
    v, a = np.ascontiguousarray(u[:, order]), np.ascontiguousarray(udot[:, order])
    return States(text, tree, eqs, q, u, r, udot, model, pin_q, v, tau, a, order, driven)


def _joints(model: Any) -> list[tuple[str, Any]]:
    named = zip(model.names, model.joints, strict=True)
    found = [(make_symbol(str(name)), joint) for name, joint in named][1:]
    return [("base" if name == "root_joint" else name, joint) for name, joint in found]


def _speeds(model: Any) -> list[str]:
    """Return what symbody calls the components of v."""
    names: list[str] = []
    for name, joint in _joints(model):
        names += [f"{name}_{part}" for part in _TWIST] if joint.nv == 6 else [f"{name}_dot"]
    return names


def _positions(model: Any, eqs: sb.EquationSet, q: Floats) -> Floats:
    """Return Pinocchio's q: quaternions with the scalar last, continuous angles as cosine and sine."""
    place = {name: k for k, name in enumerate(eqs.coordinate_names)}
    found = np.zeros((len(q), model.nq))
    for name, joint in _joints(model):
        if joint.nv == 6:
            columns = q[:, [place[f"{name}_{part}"] for part in _POSE]]
            found[:, joint.idx_q : joint.idx_q + 7] = columns[:, [0, 1, 2, 4, 5, 6, 3]]
            continue
        angle = q[:, place[name]]
        if joint.nq == 2:
            found[:, joint.idx_q], found[:, joint.idx_q + 1] = np.cos(angle), np.sin(angle)
        else:
            found[:, joint.idx_q] = angle
    return found
