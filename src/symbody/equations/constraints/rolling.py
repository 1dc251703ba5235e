"""Rows of blades, discs and spheres.

A disc of radius R with axle a touches the plane with normal n in ``C = P - R e``, where ``e = (n - (n . a) a)
/ s`` and ``s = |n x a|``: the lowest point of its rim (Neimark & Fufaev 1972, chapter 1). Forward is
``(a x n) / s``, where the centre goes when the disc spins positively about its axle.
"""

from __future__ import annotations

from collections.abc import Iterator

from symbody.equations.constraints.frame_constraints import pair_equation
from symbody.equations.constraints.points import direction
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import sqrt
from symbody.model.constraints import KnifeEdge, Rolling
from symbody.spatial.matrix import matrix3
from symbody.spatial.rotation import DirectionCosines
from symbody.spatial.vector import Vector, components, cross, dot, vector


def blade_equations(names: Names, kinematics: Kinematics, blade: KnifeEdge) -> Iterator[ConstraintEquation]:
    """Return the row of the velocity across the blade."""
    normal = vector(
        kinematics.tree.orientation_frame(blade.end.full_name), direction(names, blade, blade.axis)
    )
    yield pair_equation(kinematics, blade, value=None, force=normal)


def rolling_equations(names: Names, kinematics: Kinematics, wheel: Rolling) -> Iterator[ConstraintEquation]:
    """Return the rows of height, of the velocity forward and of that to the left in the point of contact."""
    tree = kinematics.tree
    arm = kinematics.position(wheel.start.full_name, wheel.end.full_name)
    normal, forward, spoke = contact_axes(names, kinematics, wheel)
    left = cross(tree, normal, forward)
    height = dot(tree, normal, arm) + dot(tree, normal, spoke)
    for value, force in ((height, normal), (None, forward), (None, left)):
        yield pair_equation(kinematics, wheel, value=value, force=force, moment=cross(tree, spoke, force))


def rolling_frame(
    names: Names, kinematics: Kinematics, wheel: Rolling
) -> tuple[RotationStep, TranslationStep]:
    """Return the steps to the frame of a rolling contact: z is the normal, x forward."""
    tree, start = kinematics.tree, wheel.start.full_name
    normal, forward, spoke = contact_axes(names, kinematics, wheel)
    left = cross(tree, normal, forward)
    x, y, z = (components(tree, axis, start) for axis in (forward, left, normal))
    spin = dot(tree, left, kinematics.derivative(forward, start))
    cosines = DirectionCosines(matrix3(x, y, z).T)
    arm = kinematics.position(start, wheel.end.full_name)
    return (
        RotationStep(wheel.name, start, (cosines,), normal * spin),
        TranslationStep(wheel.name, start, start, arm + spoke),
    )


def contact_axes(names: Names, kinematics: Kinematics, wheel: Rolling) -> tuple[Vector, Vector, Vector]:
    """Return normal, forward direction, and the vector from the wheel's centre to the point of contact."""
    tree = kinematics.tree
    home = tree.orientation_frame(wheel.start.full_name)
    upright = direction(names, wheel, wheel.normal)
    normal = vector(home, upright)
    radius = names.expression(wheel.radius, f"constraint {wheel.name}")
    if wheel.axis is None:
        return normal, vector(home, perpendiculars(names.graph, upright)[0]), normal * -radius
    axle = vector(tree.orientation_frame(wheel.end.full_name), direction(names, wheel, wheel.axis))
    lean = dot(tree, normal, axle)
    across = sqrt(1 - lean * lean)
    forward = cross(tree, axle, normal) * (1 / across)
    return normal, forward, (axle * lean - normal) * (radius / across)
