"""Consistent states of a random mechanism, by names, from NumPy alone: they fit every choice of trees.

The pose closes all loops. Random rates of the tree's freedoms are projected on what loops and prescribed
motions demand; then every joint, cut or not, and every body has its coordinates and speeds.
"""

from __future__ import annotations

import random
from dataclasses import dataclass

import numpy as np

from tests.laws.joint_laws import freedoms, speeds
from tests.laws.motion import (
    Freedoms,
    Places,
    all_freedoms,
    body_places,
    demands,
    freedom_scales,
    relative_motion,
)
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array, quaternion

# In front of the names of a renamed mechanism; rates do not depend on it.
RENAMED = "n_"


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """A state in every coordinate and speed there can be.

    Attributes
    ----------
    places : mapping of body to (position, rotation matrix)
    twists : mapping of body to (velocity of the centre of mass, angular velocity), in ground axes
    known : mapping of name to number
        Coordinates, rates, speeds, inputs and t.
    """

    t: float
    places: Places
    twists: dict[str, tuple[Array, Array]]
    known: dict[str, float]

    def of(self, names: tuple[str, ...]) -> list[float]:
        """The values of names in order."""
        return [self.known[name] for name in names]


def consistent_state(mechanism: Mechanism) -> State:
    """A state at the pose with random admissible speeds."""
    places = body_places(mechanism)
    motion = all_freedoms(mechanism, places)
    return state_of_rates(mechanism, places, motion, admissible_rates(mechanism, places, motion))


def admissible_rates(mechanism: Mechanism, places: Places, motion: Freedoms) -> Array:
    """Random rates of the freedoms, projected on what loops and motions demand."""
    scales = freedom_scales(mechanism, motion)
    time = mechanism.units.time
    s = np.zeros(motion.size)
    for name, columns in motion.columns.items():
        # By name, so that order does not matter; of free bodies in their own axes, so that ground does not.
        rng = random.Random(f"rates {mechanism.seed} {name.removeprefix(RENAMED)}")
        own = np.array([rng.uniform(-1, 1) for _ in range(columns.stop - columns.start)])
        if name in mechanism.placed:
            own = np.concatenate([places[name][1] @ part for part in (own[:3], own[3:])])
        s[columns] = own
    for column, (joint, name) in motion.known.items():
        s[column] = joint.motions[name].rate(mechanism.t) * time / scales[column]
    demand = demands(mechanism, places, motion)
    rows = demand.rows * scales
    open_columns = [k for k in range(motion.size) if k not in motion.known]
    for _ in range(2):  # the second time removes the rounding of the first
        missing = demand.values * time - rows @ s
        if len(missing) and open_columns:
            s[open_columns] += np.linalg.lstsq(rows[:, open_columns], missing, rcond=1e-9)[0]
    found: Array = s * scales / time
    return found


def state_of_rates(mechanism: Mechanism, places: Places, motion: Freedoms, s: Array) -> State:
    """The state with given rates of the freedoms."""
    known = {"t": mechanism.t, **mechanism.inputs}
    for joint in mechanism.joints:
        relative = relative_motion(mechanism, places, motion, joint) @ s
        scale = np.array([1.0] * 3 + [1 / mechanism.units.length] * 3)
        basis = np.vstack(freedoms(joint)) * scale[:, None]
        own = np.linalg.lstsq(basis, relative * scale, rcond=None)[0] if basis.shape[1] else np.zeros(0)
        known |= dict(zip(joint.names, joint.values, strict=True))
        known |= speeds(joint, own)
    twists = {body: (motion.slides[body] @ s, motion.spins[body] @ s) for body in motion.spins}
    for body in mechanism.bodies:
        known |= _absolute(body.name, places[body.name], twists[body.name])
    return State(mechanism.t, places, twists, known)


def _absolute(name: str, place: tuple[Array, Array], twist: tuple[Array, Array]) -> dict[str, float]:
    """Coordinates and speeds of a body without joint: quaternion, v in ground axes, omega in its own."""
    (r, axes), (v, w) = place, twist
    words = ("x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz")
    values = np.concatenate([r, quaternion(axes), v, axes.T @ w])
    return {f"{name}_{word}": float(value) for word, value in zip(words, values, strict=True)}
