"""Bushings: what gives way between two frames in all directions, and prevents nothing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from symbody.equations.dynamics.load import Law, Load, PointForce, couple, is_constant, load_law
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, atan2, number, sqrt
from symbody.model.loads.forces import BUSHING_COORDINATES, Bushing, Row
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import Vector, components, cross, dot, vector


@load_law.register(Bushing)
def _bushing_law(bushing: Bushing, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law:
    """Return the law of a bushing: efforts along the coordinates of a free joint with angles x-y-z.

    Their rates are components of the relative velocity and, of the angles, products of the angular velocity
    with the dual basis of the axes turned about. The same vectors make the wrench of the efforts.
    """
    tree, where = kinematics.tree, f"joint {bushing.name}"
    start, end = bushing.start.full_name, bushing.end.full_name
    home, arm = tree.orientation_frame(start), kinematics.position(start, end)
    w_start = kinematics.angular_velocities[start].value
    moving = kinematics.velocities[end].value - kinematics.velocities[start].value - cross(tree, w_start, arm)
    turning = kinematics.angular_velocities[end].value - w_start
    angles, dual = _cardan(kinematics, home, tree.orientation_frame(end))
    x = (*components(tree, arm, home), *angles)
    rates = [*components(tree, moving, home), *(dot(tree, vector(home, axis), turning) for axis in dual)]
    free = [names.expression(formula, where) for formula in bushing.free]
    K, D = (_matrix(names, rows, where) for rows in (bushing.stiffness_rows, bushing.damping_rows))
    stretch = [place - relaxed for place, relaxed in zip(x, free, strict=True)]
    springs, dampers = _product(K, stretch), _product(D, rates)
    efforts = [-a - b for a, b in zip(springs, dampers, strict=True)]
    loads = _wrench(bushing, arm, home, efforts, dual)
    outputs = [f"{bushing.name} {word}" for word in BUSHING_COORDINATES]
    named = dict(zip(outputs, efforts, strict=True))
    words = [f"{'length' if k < 3 else 'angle'} {name}" for k, name in enumerate(outputs)]
    measures = dict(zip(words, x, strict=True))
    if all(map(is_constant, (*(k for row in K for k in row), *free))) and _is_symmetric(K):
        energy = _inner(springs, stretch) / 2
        without_potential = _wrench(bushing, arm, home, [-damper for damper in dampers], dual)
        return Law(loads, energy, -_inner(dampers, rates), without_potential, named, measures)
    return Law(loads, number(names.graph, 0), _inner(efforts, rates), None, named, measures)


def _cardan(kinematics: Kinematics, start: str, end: str) -> tuple[Triple, tuple[Triple, Triple, Triple]]:
    """Return the angles x-y-z from start to end, and the dual basis of their axes in start.

    The rate of an angle is the product of its dual vector and the angular velocity.
    """
    graph = kinematics.graph
    R = kinematics.tree.matrix(start, end)
    cosine = sqrt(R[1][2] * R[1][2] + R[2][2] * R[2][2])  # of the second angle
    s, c, tangent = -R[1][2] / cosine, R[2][2] / cosine, R[0][2] / cosine
    zero, one = number(graph, 0), number(graph, 1)
    angles = (atan2(-R[1][2], R[2][2]), atan2(R[0][2], cosine), atan2(-R[0][1], R[0][0]))
    return angles, ((one, s * tangent, -c * tangent), (zero, c, s), (zero, -s / cosine, c / cosine))


def _wrench(
    bushing: Bushing, arm: Vector, home: str, efforts: Sequence[Expr], dual: Sequence[Triple]
) -> tuple[Load, ...]:
    """Return opposite wrenches on two bodies, both forces in the origin of end."""
    force = vector(home, (efforts[0], efforts[1], efforts[2]))
    loads: tuple[Load, ...] = ()
    if not force.is_zero:
        loads = (PointForce(bushing.end.full_name, force), PointForce(bushing.start.full_name, -force, arm))
    moment = vector(home, dual[0]) * efforts[3]
    moment = moment + vector(home, dual[1]) * efforts[4] + vector(home, dual[2]) * efforts[5]
    return loads if moment.is_zero else (*loads, *couple(bushing.start.body, bushing.end.body, moment))


def _matrix(names: Names, rows: Iterable[Row], where: str) -> list[list[Expr]]:
    return [[names.expression(entry, where) for entry in row] for row in rows]


def _is_symmetric(matrix: Sequence[Sequence[Expr]]) -> bool:
    return all((matrix[i][j] - matrix[j][i]).is_zero for i in range(len(matrix)) for j in range(i))


def _product(matrix: Sequence[Sequence[Expr]], x: Sequence[Expr]) -> list[Expr]:
    return [_inner(row, x) for row in matrix]


def _inner(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    total = number(b[0].graph, 0)
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total
