"""Springs between two frames: along a line, about an axis, and the laws and curves they may have."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.dynamics.load import Law, PointForce, PointToPointForce, couple, is_constant, load_law
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole, joint_steps
from symbody.equations.loads.curves import curve_value
from symbody.expr import canonical
from symbody.expr.expression import Expr, atan2, cos, number, sin, sqrt
from symbody.expr.opcodes import LE
from symbody.model.loads.curve import Curve
from symbody.model.loads.curve import Law as LawValue
from symbody.model.loads.forces import SpringDamper, TorsionSpring
from symbody.model.simple_rotation import unit_axis
from symbody.spatial.matrix import Triple
from symbody.spatial.rotation import angle_about, compose_steps
from symbody.spatial.vector import dot, vector


@load_law.register(SpringDamper)
def _spring_law(
    spring: SpringDamper, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]
) -> Law:
    law = _isotropic_law if spring.isotropic else _point_spring_law
    return law(names, kinematics, spring)


def _isotropic_law(names: Names, kinematics: Kinematics, spring: SpringDamper) -> Law:
    """Return the law of a spring and damper in all directions alike; its effort is the share along the line.

    Velocities are differences of those seen from ground, so that its power is never positive: the forces act
    in the two points, and what they turn is a couple.
    """
    tree, where = kinematics.tree, f"spring {spring.name}"
    start, end = spring.start.full_name, spring.end.full_name
    arm = kinematics.position(start, end)
    velocity = kinematics.velocities[end].value - kinematics.velocities[start].value
    stiffness, damping = (names.expression(x, where) for x in (spring.stiffness, spring.damping))
    square, closing = dot(tree, arm, arm), dot(tree, arm, velocity)
    length = sqrt(square)
    friction = velocity * -damping
    dampers = () if friction.is_zero else (PointForce(end, friction), PointForce(start, -friction))
    loads = (PointToPointForce(start, end, arm, -stiffness), *dampers)
    # At length 0 the line has no direction: the rate along it counts as 0 there.
    rate = closing / _positive(length)
    efforts = {spring.name: -(stiffness * length) - damping * rate}
    measures = {f"length {spring.name}": length}
    lost = -(damping * dot(tree, velocity, velocity))
    if is_constant(stiffness):
        return Law(loads, stiffness * square / 2, lost, dampers, efforts, measures)
    return Law(loads, number(names.graph, 0), lost - stiffness * closing, None, efforts, measures)


def _positive(length: Expr) -> Expr:
    """Return a length, 1 in the place of 0."""
    graph = length.graph
    is_zero = canonical.apply(graph, LE, length.index, graph.constant(0))
    return Expr(graph, canonical.select(graph, is_zero, graph.constant(1), length.index))


def law_value(names: Names, law: LawValue, x: Expr, where: str) -> Expr:
    """Return the value of a law; a curve is one over `x`."""
    return curve_value(law, x) if isinstance(law, Curve) else names.expression(law, where)


def _point_spring_law(names: Names, kinematics: Kinematics, spring: SpringDamper) -> Law:
    """Return the law of a spring between two points, positive pushing them apart.

    With free length exactly 0 the spring is the vector law ``-k d``, which is smooth at length 0.
    """
    tree, where = kinematics.tree, f"spring {spring.name}"
    start, end = spring.start.full_name, spring.end.full_name
    arm = kinematics.position(start, end)
    closing = dot(tree, arm, kinematics.velocities[end].value - kinematics.velocities[start].value)
    square = dot(tree, arm, arm)
    stiffness, free = names.expression(spring.stiffness, where), names.expression(spring.free, where)
    applied, damping = names.expression(spring.applied, where), names.expression(spring.damping, where)
    zero = number(names.graph, 0)
    length = sqrt(square)
    rate = zero if closing.is_zero else closing / length
    inside = names.with_values({"length": length, "length_rate": rate})
    along = applied - damping * rate + law_value(inside, spring.law, length, where)
    factor = -stiffness if along.is_zero else along / length - stiffness
    energy = stiffness * square / 2
    if not free.is_zero:
        factor = (along - stiffness * (length - free)) / length
        energy = stiffness * (length - free) ** 2 / 2
    load = PointToPointForce(start, end, arm, factor)
    efforts = {spring.name: along - stiffness * (length - free)}
    measures = {f"length {spring.name}": length}
    if is_constant(stiffness) and is_constant(free):
        without_potential = () if along.is_zero else (PointToPointForce(start, end, arm, along / length),)
        return Law((load,), energy, along * rate, without_potential, efforts, measures)
    return Law((load,), zero, factor * closing, None, efforts, measures)


@load_law.register(TorsionSpring)
def _torsion_law(
    spring: TorsionSpring, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]
) -> Law:
    """Return the law of a torsion spring.

    It has a potential where its angle is one of joints. Measured on frames that tilt, the angle's rate is not
    the component of the angular velocity on which the torque works.
    """
    tree, where = kinematics.tree, f"torsion_spring {spring.name}"
    direction = names.triple(unit_axis(spring.axis), where)
    axis = vector(tree.orientation_frame(spring.start.full_name), direction)
    w_end, w_start = (kinematics.angular_velocities[p.body].value for p in (spring.end, spring.start))
    stiffness, free = names.expression(spring.stiffness, where), names.expression(spring.free, where)
    applied, damping = names.expression(spring.applied, where), names.expression(spring.damping, where)
    angle = _joint_angle(names, kinematics, roles, spring, direction)
    notes: tuple[str, ...] = ()
    if angle is None:
        rate = dot(tree, axis, w_end - w_start)
        measured = _angle_between_axes(kinematics, spring, direction, free)
        notes = (f"{where}: no joints about its axis connect its ends; its angle is measured within half a "
                 f"turn of {spring.free}",)  # fmt: skip
    else:
        rate, measured = kinematics.rate(angle), angle
    inside = names.with_values({"angle": measured, "angle_rate": rate})
    other = applied - damping * rate + law_value(inside, spring.law, measured, where)
    effort = other - stiffness * (measured - free)
    efforts, measures = {spring.name: effort}, {f"angle {spring.name}": measured}
    loads = couple(spring.start.body, spring.end.body, axis * effort)
    if angle is not None and is_constant(stiffness) and is_constant(free):
        energy = stiffness * (angle - free) ** 2 / 2
        return Law(
            loads,
            energy,
            other * rate,
            couple(spring.start.body, spring.end.body, axis * other),
            efforts,
            measures,
        )
    return Law(loads, number(names.graph, 0), effort * rate, None, efforts, measures, notes)


def _joint_angle(
    names: Names, kinematics: Kinematics, roles: Sequence[JointRole], spring: TorsionSpring, axis: Triple
) -> Expr | None:
    """Return the angle as that of a joint between the two bodies, or of turns in the tree; else None.

    A cut joint whose angle is a variable comes first: it counts its turns whatever the trees.
    """
    tree = kinematics.tree
    ways = [tree.rotation(spring.start.full_name, spring.end.full_name)]
    for role in roles:
        if (
            role.has_angles
            and not role.in_rotation
            and connects_bodies(role.joint.start.body, role.joint.end.body, spring)
        ):
            rotation = compose_steps(joint_steps(names, role.joint))
            forward = role.joint.start.body == spring.start.body
            ends = (role.joint.start.full_name, role.joint.end.full_name)
            near, far = ends if forward else reversed(ends)
            before, after = (
                tree.rotation(spring.start.full_name, near),
                tree.rotation(far, spring.end.full_name),
            )
            ways.insert(0, before.then(rotation if forward else rotation.inverse).then(after))
    for way in ways:
        angle = angle_about(kinematics.graph, way, axis)
        if angle is not None:
            return angle
    return None


def connects_bodies(start: str, end: str, spring: TorsionSpring) -> bool:
    """Return whether a spring connects two bodies, in whichever order."""
    return {start, end} == {spring.start.body, spring.end.body}


def _angle_between_axes(kinematics: Kinematics, spring: TorsionSpring, axis: Triple, free: Expr) -> Expr:
    """Return the angle between axes of the two frames, in (free - pi, free + pi]."""
    tree = kinematics.tree
    first, second = perpendiculars(tree.graph, axis)
    start, end = tree.orientation_frame(spring.start.full_name), tree.orientation_frame(spring.end.full_name)
    seen = vector(end, first)
    sine, cosine = dot(tree, vector(start, second), seen), dot(tree, vector(start, first), seen)
    if free.is_zero:
        return atan2(sine, cosine)
    s, c = sin(free), cos(free)
    return free + atan2(sine * c - cosine * s, cosine * c + sine * s)
