"""Where the bodies of a mechanism stand in one configuration."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import assemble
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.graph.topology import Topology
from symbody.model.model import Model
from symbody.visual.scene.body_poses import chain_of
from symbody.visual.scene.from_model import make_scene
from symbody.visual.scene.numbers import ModelNumbers, model_numbers
from symbody.visual.scene.poses import (
    RigidTransform,
    body_transforms,
    frame_transforms,
    joint_coordinates,
    joint_transform,
)
from symbody.visual.scene.scene import Scene, SceneMotion

Floats = NDArray[np.float64]

_NONE: Final[Mapping[str, Value]] = MappingProxyType({})


def placed_motion(
    eqs: EquationSet,
    positions: Mapping[str, float],
    names: tuple[str, ...],
    parameters: Mapping[str, Value] = _NONE,
) -> SceneMotion:
    """Return a motion of one sample: bodies, by name, in a configuration.

    Parameters
    ----------
    parameters : mapping of name to number or formula
        Take the place of the model's values.
    """
    transforms = _from_joints(eqs.formed.topology, model_numbers(eqs.model, parameters), positions)
    if not transforms.keys() >= set(names):
        return _from_outputs(assemble(eqs, guess=dict(positions), parameters=parameters), names)
    return one_sample(transforms, names)


def scene_at(model: Model, positions: Mapping[str, float], parameters: Mapping[str, Value] = _NONE) -> Scene:
    """Return the shapes of a mechanism that stands in a configuration at the start."""
    courses = {name: np.array([value]) for name, value in positions.items()}
    return make_scene(model, parameters, courses)


def one_sample(transforms: Mapping[str, RigidTransform], names: tuple[str, ...]) -> SceneMotion:
    """Return a motion of one sample: bodies as they stand."""
    placed = [transforms[name] for name in names]
    positions = np.array([each.place for each in placed]).reshape(1, -1, 3)
    quaternions = np.array([each.quaternion for each in placed]).reshape(1, -1, 4)
    return SceneMotion(np.zeros(1), positions, quaternions)


def scene_bodies(model: Model) -> tuple[str, ...]:
    """Return the bodies in the order of a scene, without the ground."""
    return tuple(body.name for body in model.bodies)


def _from_joints(
    topology: Topology, numbers: ModelNumbers, values: Mapping[str, float]
) -> dict[str, RigidTransform]:
    """Return the bodies that joints in both trees lead to."""
    joints = [
        joint
        for joint in topology.joints
        if joint.name in topology.rotation_branches and joint.name in topology.translation_branches
    ]
    steps = {
        joint.name: joint_transform(joint, numbers, joint_coordinates(joint, numbers, values))
        for joint in joints
    }
    return body_transforms(joints, frame_transforms(topology.model, numbers), steps)


def _from_outputs(state: State, names: tuple[str, ...]) -> SceneMotion:
    """Return the same by outputs of the equations, for bodies whose two trees differ."""
    chain = chain_of(state.eqs.model, list(names))
    outputs = {name: np.asarray(state[name])[..., np.newaxis] for name in chain.outputs}
    poses = chain.poses(outputs, 1)
    return SceneMotion(np.zeros(1), poses.positions, poses.quaternions)
