"""Drake on bodies that fall: point contact by Hunt and Crossley, continuous or in its discrete steps (SAP).

A box has a small ball in each corner, as a box on a plane has one point of contact there, the deepest.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, DiscreteContactApproximation
from pydrake.multibody.tree import FixedOffsetFrame, PlanarJoint, PrismaticJoint, SpatialInertia, UnitInertia
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
from pydrake.systems.framework import DiagramBuilder
from scipy.optimize import brentq

from benchmarks.contact_problems import CREEP, GRAVITY, MU, Falling, Floats

CONTINUOUS, SAP = "Runge-Kutta 3", "SAP"
_CORNER = 1e-3  # m, radius of the ball in a corner


def motion(problem: Falling) -> Callable[[str, float], Floats]:
    """Return what moves a body by a method with an accuracy or a step, and gives places at the samples."""

    def move(method: str, setting: float) -> Floats:
        step = setting if method == SAP else 0.0
        diagram, plant, body = _build(problem, step)  # in the time of a run: a plant keeps its step
        simulator = Simulator(diagram)
        if method == CONTINUOUS:
            config = SimulatorConfig(
                integration_scheme="runge_kutta3",
                max_step_size=1e-2,
                accuracy=setting,
                use_error_control=True,
            )
            ApplySimulatorConfig(config, simulator)
        context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        _start(problem, plant, body, context)
        simulator.Initialize()
        places = []
        for t in problem.times:
            simulator.AdvanceTo(t)
            places.append(plant.EvalBodyPoseInWorld(context, body).translation().copy())
        axes = {"line": [2], "plane": [2, 0], "space": [0, 1, 2]}[problem.place]
        return np.array(places).T[axes]

    return move


def _build(problem: Falling, step: float) -> tuple[Any, Any, Any]:
    """Return a diagram with a body over a floor, the plant in it, and the body."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, step)
    if step > 0.0:
        plant.set_discrete_contact_approximation(DiscreteContactApproximation.kLagged)
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -GRAVITY])
    gyration = UnitInertia(*np.array(problem.inertia) / problem.mass)
    inertia = SpatialInertia(problem.mass, np.zeros(3), gyration)
    body = plant.AddRigidBody("body", inertia)
    world = plant.world_frame()
    if problem.place == "line":
        plant.AddJoint(PrismaticJoint("move", world, body.body_frame(), [0, 0, 1]))
    elif problem.place == "plane":
        turned = RigidTransform(RotationMatrix(np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])))
        frames = [FixedOffsetFrame(name, on, turned) for name, on in _ends(world, body)]
        plant.AddJoint(PlanarJoint("move", *map(plant.AddFrame, frames)))
    corners = 2 if problem.place == "plane" else 1  # at an end of an edge
    rate = np.pi / problem.duration
    properties = ProximityProperties()
    AddContactMaterial(
        properties, dissipation=_dissipation(problem), friction=CoulombFriction(*_friction(problem)),
        point_stiffness=2.0 * problem.mass * rate**2 / corners,  # two in a row
    )  # fmt: skip
    plant.RegisterCollisionGeometry(plant.world_body(), RigidTransform(), HalfSpace(), "floor", properties)
    for k, at in enumerate(_points(problem)):
        ball = Sphere(problem.sizes[0] if problem.is_ball else _CORNER)
        plant.RegisterCollisionGeometry(body, RigidTransform(at), ball, f"point {k}", properties)
    plant.Finalize()
    plant.set_stiction_tolerance(CREEP)
    return builder.Build(), plant, body


def _ends(world: Any, body: Any) -> tuple[tuple[str, Any], ...]:
    return ("fixed", world), ("moving", body.body_frame())


def _friction(problem: Falling) -> tuple[float, float]:
    mu = 0.0 if problem.place == "line" else MU
    return mu, mu


def _points(problem: Falling) -> list[Floats]:
    """Return the centres of the balls that touch, in the body [m]."""
    if problem.is_ball:
        return [np.zeros(3)]
    reach = np.array(problem.sizes) / 2 - _CORNER
    return [reach * signs for signs in itertools.product((1, -1), repeat=3)]


def _dissipation(problem: Falling) -> float:
    """Return the factor c of the law of Hunt and Crossley: ln((1 + a)/(1 - a e)) = a (1 + e), a = c v."""
    e = problem.restitution
    a = brentq(lambda a: np.log((1 + a) / (1 - a * e)) - a * (1 + e), 1e-6, (1 - 1e-12) / e)
    return float(a / problem.speed)


def _start(problem: Falling, plant: Any, body: Any, context: Any) -> None:
    """Set the first place and velocity."""
    if problem.place == "line":
        plant.SetPositions(context, [problem.height])
    elif problem.place == "plane":
        plant.SetPositions(context, [problem.height, 0.0, problem.angles[1]])
        plant.SetVelocities(context, [0.0, problem.velocity[0], problem.rates[1]])
    else:
        rotation = RotationMatrix(Quaternion(problem.quaternion))
        plant.SetFreeBodyPose(context, body, RigidTransform(rotation, [0, 0, problem.height]))
        velocity = SpatialVelocity(rotation @ np.array(problem.rates), np.array(problem.velocity))
        plant.SetFreeBodySpatialVelocity(context, body, velocity)
