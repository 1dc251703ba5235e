"""Virtual work body by body: the form in which equations are read.

``sum over bodies of  dv_j . (m a - F) + dw_j . (I alpha + w x I w - T) = 0``  with each product taken
between terms in their own frames. Its cost grows with the cube of a chain's length; what is computed with
comes from `virtual_work`, and a test holds the two together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.load import Effort, Load, Moment, Pull
from symbody.equations.dynamics.projection import Projection, add_rotor
from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.expression import Expr, number
from symbody.vectors.dyadic import apply, gyroscopic, quadratic
from symbody.vectors.vector import cross, dot


def project_directly(
    kinematics: Kinematics,
    bodies: Sequence[Inertia],
    loads: Sequence[Load],
    armatures: Mapping[str, Rotor],
) -> Projection:
    """Return the equations of motion in the speeds; see `virtual_work.project`."""
    speeds = kinematics.speeds
    zero = number(kinematics.graph, 0)
    mass = [[zero] * len(speeds) for _ in speeds]
    forcing = [zero] * len(speeds)
    for body in bodies:
        _add_body(kinematics, body, mass, forcing)
    place = {u: j for j, u in enumerate(speeds)}
    for load in loads:
        for u, work in virtual_work(kinematics, load).items():
            forcing[place[u]] = forcing[place[u]] + work
    for rotor in armatures.values():
        add_rotor(kinematics, rotor, mass, forcing)
    return Projection(tuple(map(tuple, mass)), tuple(forcing))


def _add_body(kinematics: Kinematics, body: Inertia, mass: list[list[Expr]], forcing: list[Expr]) -> None:
    tree = kinematics.tree
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    torque = apply(tree, body.tensor, w.bias) + gyroscopic(tree, w.value, body.tensor)
    moving = [(j, u) for j, u in enumerate(kinematics.speeds) if u in v.partials or u in w.partials]
    for i, u in moving:
        if not body.mass.is_zero:
            forcing[i] = forcing[i] - body.mass * dot(tree, v.partial(u), v.bias)
        forcing[i] = forcing[i] - dot(tree, w.partial(u), torque)
        for j, other in moving:
            if j > i:
                break
            share = quadratic(tree, w.partial(u), body.tensor, w.partial(other))
            if not body.mass.is_zero:
                share = share + body.mass * dot(tree, v.partial(u), v.partial(other))
            mass[i][j] = mass[i][j] + share
            mass[j][i] = mass[i][j]


def virtual_work(kinematics: Kinematics, load: Load) -> Mapping[int, Expr]:
    """Return the generalized force of a load for each speed on which it works."""
    tree = kinematics.tree
    if isinstance(load, Effort):
        return {u: slope * load.effort for u, slope in kinematics.slopes(load.rate).items()}
    if isinstance(load, Moment):
        partials = kinematics.angular_velocities[load.frame].partials
        return {u: dot(tree, partial, load.torque) for u, partial in partials.items()}
    if isinstance(load, Pull):
        closing = kinematics.velocities[load.end] - kinematics.velocities[load.start]
        return {u: load.factor * dot(tree, load.arm, partial) for u, partial in closing.partials.items()}
    v = kinematics.velocities[load.frame]
    work = {u: dot(tree, partial, load.force) for u, partial in v.partials.items()}
    if not load.arm.is_zero:
        moment = cross(tree, load.arm, load.force)
        for u, partial in kinematics.angular_velocities[load.frame].partials.items():
            more = dot(tree, partial, moment)
            work[u] = work[u] + more if u in work else more
    return work
