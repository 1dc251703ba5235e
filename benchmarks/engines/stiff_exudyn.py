"""Exudyn's implicit solver, its generalized-alpha method, on stiff mechanisms in joint coordinates."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any, Final

import exudyn as exu
import exudyn.utilities as items
import numpy as np

from benchmarks.stiff_problems import GRAVITY, Ball, Beam, Box, Bushing, Floats, Stiff

_TOLERANCE: Final = 1e-10  # of its Newton's method
_DAMPING: Final = 0.9  # what remains after a step of what is too fast for it


def motion(problem: Stiff, end: float) -> Callable[[float], Floats]:
    """Return what moves a mechanism for `end` seconds in steps of a length, and gives coordinates there."""
    system: Any = exu.SystemContainer().AddSystem()
    node = build(problem, system)
    system.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = end
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.relativeTolerance = _TOLERANCE
    settings.timeIntegration.newton.absoluteTolerance = _TOLERANCE
    settings.timeIntegration.generalizedAlpha.spectralRadius = _DAMPING
    settings.solution.file.write = False
    settings.parallel.numberOfThreads = 1

    def move(step: float) -> Floats:
        settings.timeIntegration.numberOfSteps = round(end / step)
        system.SolveDynamic(settings, solverType=exu.DynamicSolverType.GeneralizedAlpha)
        values = system.GetNodeOutput(node, exu.OutputVariableType.Coordinates)
        return np.atleast_1d(np.array(values, dtype=np.float64))

    return move


@singledispatch
def build(problem: Any, system: Any) -> Any:
    """Add a mechanism to a system, and return the node of its coordinates."""
    raise TypeError(problem)


@build.register
def _(problem: Beam, system: Any) -> Any:
    count = problem.count
    offsets = [[0.0, 0.0, 0.0]] + [[problem.length, 0.0, 0.0]] * (count - 1)
    springs = [0.0] + [problem.stiffness] * (count - 1)
    return _tree(
        system, [exu.JointType.RevoluteZ] * count, offsets, [problem.mass] * count,
        np.diag(problem.inertia), [0.5 * problem.length, 0, 0], [0.0] * count, springs,
        [problem.delay * value for value in springs],
    )  # fmt: skip


@build.register
def _(problem: Bushing, system: Any) -> Any:
    kinds = [exu.JointType.PrismaticX, exu.JointType.PrismaticY, exu.JointType.RevoluteZ]
    k, d = problem.stiffness, problem.damping
    return _tree(
        system, kinds, [[0.0, 0.0, 0.0]] * 3, [0.0, 0.0, problem.mass], np.diag([0, 0, problem.inertia]),
        [0, -problem.arm, 0], [0.0, 0.0, problem.start], [k, k, 0.0], [d, d, 0.0],
    )  # fmt: skip


def _tree(
    system: Any, kinds: list[Any], offsets: list[list[float]], masses: list[float], inertia: Floats,
    centre: list[float], start: list[float], stiffness: list[float], damping: list[float],
) -> Any:  # fmt: skip
    """Add a chain of bodies with springs in its joints; where the mass is 0 there is no inertia."""
    count = len(kinds)
    zeros = [0.0] * count
    node = system.AddNode(
        items.NodeGenericODE2(
            referenceCoordinates=zeros, initialCoordinates=start, initialCoordinates_t=zeros,
            numberOfODE2Coordinates=count,
        )
    )  # fmt: skip
    inertias = [inertia if mass else np.zeros((3, 3)) for mass in masses]
    system.AddObject(
        items.ObjectKinematicTree(
            nodeNumber=node, jointTypes=kinds, linkParents=list(range(-1, count - 1)),
            jointTransformations=exu.Matrix3DList([np.eye(3)] * count),
            jointOffsets=exu.Vector3DList(offsets),
            linkInertiasCOM=exu.Matrix3DList(inertias), linkCOMs=exu.Vector3DList([centre] * count),
            linkMasses=masses, gravity=[0, -GRAVITY, 0], jointPositionOffsetVector=zeros,
            jointVelocityOffsetVector=zeros, jointPControlVector=stiffness, jointDControlVector=damping,
        )
    )  # fmt: skip
    return node


@build.register
def _(problem: Ball, system: Any) -> Any:
    k, d = problem.stiffness, problem.damping

    def force(
        mbs: Any, t: Any, itemNumber: Any, displacement: Any, velocity: Any, stiffness: Any, damping: Any,
        offset: Any,
    ) -> Any:  # fmt: skip
        return -k * exu.symbolic.pow(exu.symbolic.max(-displacement, 0.0), 1.5) * (1.0 - d * velocity)

    return _body(system, problem.mass, problem.height, force, weight=-problem.mass * GRAVITY)


@build.register
def _(problem: Box, system: Any) -> Any:
    k, v0, strength = problem.stiffness, problem.v0, problem.mu * problem.mass * GRAVITY

    def force(
        mbs: Any, t: Any, itemNumber: Any, displacement: Any, velocity: Any, stiffness: Any, damping: Any,
        offset: Any,
    ) -> Any:  # fmt: skip
        return k * displacement + strength * velocity / exu.symbolic.sqrt(velocity * velocity + v0 * v0)

    return _body(system, problem.mass, problem.start, force, weight=0.0)


def _body(system: Any, mass: float, start: float, force: Callable[..., Any], weight: float) -> Any:
    """Add a body on a line, held to ground by a force of its place and speed, and pulled by its weight."""
    node = system.AddNode(items.Node1D(referenceCoordinates=[0.0], initialCoordinates=[start]))
    system.AddObject(items.Mass1D(nodeNumber=node, mass=mass))
    ground = system.AddNode(items.NodePointGround())
    ends = [
        system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=place, coordinate=0))
        for place in (ground, node)
    ]
    law = items.CreateSymbolicUserFunction(
        system, force, "springForceUserFunction", itemTypeName="ObjectConnectorCoordinateSpringDamper"
    )
    system.AddObject(items.CoordinateSpringDamper(markerNumbers=ends, springForceUserFunction=law))
    if weight:
        system.AddLoad(items.LoadCoordinate(markerNumber=ends[1], load=weight))
    return node
