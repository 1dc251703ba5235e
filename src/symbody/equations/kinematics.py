"""Kinematics as a value: position, orientation and velocity of every frame, from a topology.

Names: ``w`` angular velocity, ``v`` velocity, both relative to ground; ``partial`` velocities are
the coefficients of the speeds (Kane & Levinson 1985, section 2.14). Accelerations with all u' = 0 are
the bias accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.expr.calculus import time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.vectors.frame import FrameTree
from symbody.vectors.rotation import Rotation, Turn, rotation_of
from symbody.vectors.vector import NULL, Vector, cross, vector


@dataclass(frozen=True, slots=True)
class Step:
    """How one frame stands in another: turns from parent to child, and the shift of the origin.

    Attributes
    ----------
    turns : tuple of Turn
        From the parent's axes to the child's.
    shift : Vector
        From the parent's origin to the child's, components in the parent.
    """

    child: str
    parent: str
    turns: tuple[Turn, ...]
    shift: Vector


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Placement and motion of all frames relative to ground.

    Attributes
    ----------
    tree : FrameTree
        Orientations.
    positions, velocities, angular_velocities : mapping of frame to Vector
        Of each frame's origin, in terms of q and u.
    rates : mapping of node to node
        q' in terms of u, as `time_derivative` takes it.
    """

    tree: FrameTree
    positions: Mapping[str, Vector]
    velocities: Mapping[str, Vector]
    angular_velocities: Mapping[str, Vector]
    rates: Mapping[int, int]

    def derivative(self, a: Vector, frame: str = "ground") -> Vector:
        """Return the time derivative of a vector as seen from `frame`, with u' as symbols of its own."""
        return _derivative(self.tree, self.rates, self.angular_velocities, a, frame)


def form_kinematics(graph: Graph, steps: Sequence[Step], rates: Mapping[int, int]) -> Kinematics:
    """Return the kinematics of frames given outward from ground, each by a step from an earlier one."""
    parents: dict[str, tuple[str, Rotation]] = {}
    positions: dict[str, Vector] = {"ground": NULL}
    velocities: dict[str, Vector] = {"ground": NULL}
    angular: dict[str, Vector] = {"ground": NULL}
    tree = FrameTree(graph, parents)
    for step in steps:
        _turn(graph, parents, angular, step, rates)
        # Frames that are not turned share one set of components, so that terms can add up.
        shift = Vector({tree.home(frame): components for frame, components in step.shift.terms.items()})
        rate = shift.map(lambda x: _rate(graph, x, rates))
        swing = cross(tree, angular[step.parent], shift)
        positions[step.child] = positions[step.parent] + shift
        velocities[step.child] = velocities[step.parent] + rate + swing
    return Kinematics(tree, positions, velocities, angular, rates)


def _turn(
    graph: Graph,
    parents: dict[str, tuple[str, Rotation]],
    angular: dict[str, Vector],
    step: Step,
    rates: Mapping[int, int],
) -> None:
    """Enter the frames of a step, one more for each turn, with their angular velocities."""
    frame = step.parent
    last = len(step.turns) - 1
    for k, turn in enumerate(step.turns):
        following = step.child if k == last else f"{step.child}#{k + 1}"
        parents[following] = (frame, rotation_of((turn,)))
        speed = _rate(graph, turn.angle, rates)
        x, y, z = turn.axis
        angular[following] = angular[frame] + vector(following, (x * speed, y * speed, z * speed))
        frame = following
    if not step.turns:
        parents[step.child] = (frame, Rotation())
        angular[step.child] = angular[frame]


def _rate(graph: Graph, x: Expr, rates: Mapping[int, int]) -> Expr:
    return Expr(graph, time_derivative(graph, [x.index], rates)[0])


def _derivative(
    tree: FrameTree, rates: Mapping[int, int], angular: Mapping[str, Vector], a: Vector, frame: str
) -> Vector:
    graph = tree.graph
    total = NULL
    for home, components in a.terms.items():
        term = Vector({home: components})
        relative = angular[home] - angular[frame]
        total = total + term.map(lambda x: _rate(graph, x, rates)) + cross(tree, relative, term)
    return total
