"""Where bodies are over time, and how poses are interpolated between samples."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from symbody.graph.linear_graph import Edge, breadth_first
from symbody.model.model import Model
from symbody.model.naming import GROUND

Floats = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Poses:
    """Positions (N, B, 3) [m] and quaternions (N, B, 4), scalar first, from the bodies' axes to ground's."""

    positions: Floats
    quaternions: Floats


@dataclass(frozen=True, slots=True)
class Chain:
    """Bodies with those that each is placed from: formulas from ground would grow with the distance to it.

    Attributes
    ----------
    names : tuple of str
        The bodies.
    parents : tuple of int
        Of each body another one, or -1 for ground.
    order : tuple of int
        The bodies, each after its parent.
    """

    names: tuple[str, ...]
    parents: tuple[int, ...]
    order: tuple[int, ...]

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs that hold the poses: all positions from the parents, then all rotation matrices."""
        parents = [self.names[k] if k >= 0 else "ground" for k in self.parents]
        pairs = list(zip(self.names, parents, strict=True))
        positions = [f'frame r "{body}" "{parent}" "{parent}"' for body, parent in pairs]
        return (*positions, *(f'frame R "{body}" "{parent}"' for body, parent in pairs))

    def poses(self, outputs: Mapping[str, Floats], count: int) -> Poses:
        """Return the poses of the bodies relative to ground at `count` times; of quaternions either sign."""
        bodies = len(self.names)
        positions, matrices = np.zeros((bodies + 1, count, 3)), np.zeros((bodies + 1, count, 3, 3))
        matrices[-1] = np.eye(3)  # the last one is ground: a parent of -1
        arrays = [np.moveaxis(outputs[name], -1, 0) for name in self.outputs]
        for k in self.order:
            frame = matrices[self.parents[k]]
            positions[k] = positions[self.parents[k]] + np.einsum("nij,nj->ni", frame, arrays[k])
            matrices[k] = frame @ arrays[bodies + k]
        if bodies == 0:
            return Poses(np.empty((count, 0, 3)), np.empty((count, 0, 4)))
        vector_first = Rotation.from_matrix(matrices[:-1].reshape(-1, 3, 3)).as_quat()
        quaternions = np.roll(vector_first.reshape(bodies, count, 4), 1, axis=-1)
        return Poses(np.moveaxis(positions[:-1], 1, 0), np.moveaxis(quaternions, 1, 0))


def chain_of(model: Model, names: Sequence[str], inside: Collection[str] | None = None) -> Chain:
    """Return bodies with their neighbours on the way to ground, along joints `inside` both trees."""
    places = {name: k for k, name in enumerate(names)}
    edges = [
        Edge(joint.name, joint.start.body, joint.end.body)
        for joint in model.joints
        if inside is None or joint.name in inside
    ]
    parents, order = [-1] * len(names), []
    for parent, _, body in breadth_first(edges, GROUND):
        parents[places[body]] = places.get(parent, -1)
        order.append(places[body])
    reached = {*order}
    return Chain(tuple(names), tuple(parents), (*order, *(k for k in range(len(names)) if k not in reached)))


def of_one_sign(quaternions: Floats) -> Floats:
    """Return quaternions (N, ...) of which each is on the side of the one before."""
    products = np.einsum("n...k,n...k->n...", quaternions[1:], quaternions[:-1])
    turns = np.cumprod(np.where(products < 0.0, -1.0, 1.0), axis=0)
    signs = np.concatenate([np.ones((1, *turns.shape[1:])), turns])
    signed: Floats = quaternions * signs[..., np.newaxis]
    return signed


def interpolate(poses: Poses, before: Places, shares: Floats, after: Places | None = None) -> Poses:
    """Return poses between samples: positions along lines, rotations about fixed axes.

    Parameters
    ----------
    before, after : (M,) arrays
        The samples on both sides; by default the one after follows the one before.
    shares : (M,) array
        How much of the way has passed.
    """
    later = before + 1 if after is None else after
    s = shares[:, np.newaxis, np.newaxis]
    positions = poses.positions[before] * (1.0 - s) + poses.positions[later] * s
    return Poses(positions, slerp(poses.quaternions[before], poses.quaternions[later], shares[:, np.newaxis]))


def slerp(first: Floats, second: Floats, shares: Floats) -> Floats:
    """Return the rotation a share of the shorter way from one unit quaternion to another."""
    product = np.einsum("...k,...k->...", first, second)
    near = second * np.where(product < 0.0, -1.0, 1.0)[..., np.newaxis]
    half = np.arctan2(np.linalg.norm(near - first, axis=-1), np.linalg.norm(near + first, axis=-1))
    angle = 2.0 * half
    sine = np.sin(angle)
    flat = sine < 1e-9  # there the chord is the arc
    safe = np.where(flat, 1.0, sine)
    a = np.where(flat, 1.0 - shares, np.sin((1.0 - shares) * angle) / safe)
    b = np.where(flat, shares, np.sin(shares * angle) / safe)
    between: Floats = a[..., np.newaxis] * first + b[..., np.newaxis] * near
    return between


def angle_between(first: Floats, second: Floats) -> Floats:
    """Return the angle of the rotation between orientations [rad]."""
    apart = np.minimum(np.linalg.norm(first - second, axis=-1), np.linalg.norm(first + second, axis=-1))
    return np.asarray(4.0 * np.arcsin(np.minimum(apart / 2.0, 1.0)))
