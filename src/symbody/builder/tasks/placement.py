"""Where the bodies of a mechanism stand in one configuration."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.graph.topology import Topology
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.model import Model
from symbody.visual.scene.basis import scene_basis
from symbody.visual.scene.body_poses import chain_of
from symbody.visual.scene.from_model import draw_scene
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
    numbers = model_numbers(eqs.model, parameters)
    steps = _steps(eqs.formed.topology, numbers, positions, {})
    return _stand(eqs, positions, parameters, frame_transforms(eqs.model, numbers), steps, names)


def draw_at(
    eqs: EquationSet, positions: Mapping[str, float], parameters: Mapping[str, Value] = _NONE
) -> tuple[Scene, SceneMotion]:
    """Return the shapes of a mechanism that stands in a configuration at the start, and where its bodies are.

    Parameters
    ----------
    parameters : mapping of name to number or formula
        Take the place of the model's values.
    """
    numbers = model_numbers(eqs.model, parameters)
    basis = scene_basis(eqs.model, numbers, _courses(positions))
    steps = _steps(eqs.formed.topology, numbers, positions, basis.steps)
    names = scene_bodies(eqs.model)
    return draw_scene(basis), _stand(eqs, positions, parameters, basis.frames, steps, names)


def draw_unassembled(model: Model) -> tuple[Scene, SceneMotion]:
    """Return the shapes of a mechanism without equations, and where its initial values put its bodies."""
    basis = scene_basis(model, model_numbers(model, {}))
    return draw_scene(basis), one_sample(basis.bodies, scene_bodies(model))


def _courses(positions: Mapping[str, float]) -> dict[str, Floats]:
    return {name: np.array([value]) for name, value in positions.items()}


def _stand(
    eqs: EquationSet,
    positions: Mapping[str, float],
    parameters: Mapping[str, Value],
    frames: Mapping[FrameRef, RigidTransform],
    steps: Mapping[str, RigidTransform],
    names: tuple[str, ...],
) -> SceneMotion:
    """Return where bodies stand: by the joints of both trees, or by outputs where these differ."""
    transforms = body_transforms(_branches(eqs.formed.topology), frames, steps)
    if not transforms.keys() >= set(names):
        return _from_outputs(assemble(eqs, guess=dict(positions), parameters=parameters), names)
    return one_sample(transforms, names)


def one_sample(transforms: Mapping[str, RigidTransform], names: tuple[str, ...]) -> SceneMotion:
    """Return a motion of one sample: bodies as they stand."""
    placed = [transforms[name] for name in names]
    positions = np.array([each.place for each in placed]).reshape(1, -1, 3)
    quaternions = np.array([each.quaternion for each in placed]).reshape(1, -1, 4)
    return SceneMotion(np.zeros(1), positions, quaternions)


def scene_bodies(model: Model) -> tuple[str, ...]:
    """Return the bodies in the order of a scene, without the ground."""
    return tuple(body.name for body in model.bodies)


def _steps(
    topology: Topology,
    numbers: ModelNumbers,
    positions: Mapping[str, float],
    given: Mapping[str, RigidTransform],
) -> Mapping[str, RigidTransform]:
    """Return where joints of both trees hold their end frames, those of loose bodies too; some are given."""
    return {
        joint.name: given[joint.name]
        if joint.name in given
        else joint_transform(joint, numbers, joint_coordinates(joint, numbers, positions))
        for joint in _branches(topology)
    }


def _branches(topology: Topology) -> list[Joint]:
    """Return the joints that are in both trees."""
    inside = topology.rotation_branches & topology.translation_branches
    return [joint for joint in topology.joints if joint.name in inside]


def _from_outputs(state: State, names: tuple[str, ...]) -> SceneMotion:
    """Return the same by outputs of the equations, for bodies whose two trees differ."""
    chain = chain_of(state.eqs.model, list(names))
    outputs = {name: np.asarray(state[name])[..., np.newaxis] for name in chain.outputs}
    poses = chain.poses(outputs, 1)
    return SceneMotion(np.zeros(1), poses.positions, poses.quaternions)
