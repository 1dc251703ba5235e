"""The role of each joint: its place in the trees, and the coordinates that formulas and springs read."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

from symbody.equations.kinematics.variables import JointRole
from symbody.errors import FormulationError, Problem
from symbody.graph.topology import Topology
from symbody.model.declarations.formula_site import Scope
from symbody.model.joint import Joint
from symbody.model.loads.forces import TorsionSpring
from symbody.model.model import Model


def joint_roles(topology: Topology) -> tuple[JointRole, ...]:
    """Return every joint with the parts of its law in use.

    Raises
    ------
    FormulationError
        If a formula reads an Euler parameter of a joint outside the rotation tree.
    """
    read = names_read(topology.model) | _spring_angles(topology)
    roles = []
    problems = []
    for joint in topology.joints:
        turning, sliding = (
            joint.name in topology.rotation_branches,
            joint.name in topology.translation_branches,
        )
        tied = bool(joint.coupled_coordinates)
        turns = turning or tied or _needs_angles(joint, read)
        slides = sliding or tied or not set(joint.motions).isdisjoint(joint.translation_coordinates)
        roles.append(JointRole(joint, turning, sliding, turns, slides))
        if turns and not turning and joint.quaternion is not None:
            problems.append(_quaternion_problem(joint))
    if problems:
        raise FormulationError(*problems)
    return tuple(roles)


def names_read(model: Model) -> set[str]:
    """Return the names that the formulas of forces, springs and constraints contain."""
    elements = (*model.elements, *model.constraints)  # those that joints and gears stand for too
    roles = (role for element in elements for role in element.formula_sites())
    reading = (Scope.LOAD, Scope.MOTION, Scope.COORDINATE)
    return {name for role in roles if role.scope in reading for name in role.formula.names}


def _spring_angles(topology: Topology) -> set[str]:
    """Return the angles that torsion springs count: of joints with one, between the bodies of a spring."""
    springs = [element for element in topology.model.elements if isinstance(element, TorsionSpring)]
    pairs = {frozenset((spring.start.body, spring.end.body)) for spring in springs}
    return {
        joint.rotation_coordinates[0]
        for joint in topology.joints
        if len(joint.rotation_coordinates) == 1 and {joint.start.body, joint.end.body} in pairs
    }


def is_read(role: JointRole, read: AbstractSet[str]) -> bool:
    """Return whether forces need a measured coordinate of a joint, or its rate."""
    measured = set(role.joint.coordinates).difference(role.coordinates)
    if role.joint.friction is not None or not measured.isdisjoint(
        {*role.joint.loaded_coordinates, *role.joint.armature}
    ):
        return bool(measured)
    return any(name in read or f"{name}_dot" in read for name in measured)


def _needs_angles(joint: Joint, read: AbstractSet[str]) -> bool:
    """Return whether a joint outside the rotation tree must still have its angles as variables.

    Displacements, their rates and the rate of a single angle are measured on the bodies. An angle is not,
    because a spring or a formula may count its turns.
    """
    angles = joint.rotation_coordinates
    driven = [joint.drives[name] for name in angles if name in joint.drives]
    if any(name in joint.motions or name in joint.limits or name in read for name in angles):
        return True
    if len(angles) == 1:
        return any(drive.reads_coordinate for drive in driven)
    rates = {f"{name}_dot" for name in angles}
    return bool(driven) or not read.isdisjoint(rates) or not set(joint.armature).isdisjoint(angles)


def _quaternion_problem(joint: Joint) -> Problem:
    return Problem(
        "equations.cut_quaternion", f"joint {joint.name}", "its quaternion is needed, but the joint is cut",
        "a formula or a motion uses it, and the sign of a measured quaternion is ambiguous",
        "put the joint into the rotation tree, or give it angles",
    )  # fmt: skip
