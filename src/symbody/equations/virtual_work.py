"""Virtual work: Newton-Euler projected on the partial velocities of a tree.

``sum over bodies of  dv_j . (m a - F) + dw_j . (I alpha + w x I w - T) = 0``  for every speed u_j, with
partial velocities dv_j, dw_j (Kane & Levinson 1985, section 6.1; Roberson & Schwertassek 1988, chapter 8).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from symbody.equations.kinematics import Kinematics
from symbody.expr.calculus import derivative
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Graph
from symbody.expr.rewrite import substitute
from symbody.vectors.rotation import Triple
from symbody.vectors.vector import NULL, Vector, cross, dot, express, vector

Tensor = tuple[Triple, Triple, Triple]


@dataclass(frozen=True, slots=True)
class VirtualWork:
    """Formulation by virtual work; any trees, any coordinates."""


@dataclass(frozen=True, slots=True)
class Inertia:
    """Mass and inertia of a body about its centre of mass, in the body's axes.

    Attributes
    ----------
    frame : str
        The body's frame, origin at the centre of mass.
    tensor : (3, 3) Expr
        Products are tensor entries.
    """

    frame: str
    mass: Expr
    tensor: Tensor


@dataclass(frozen=True, slots=True)
class PointForce:
    """A force on a body.

    Attributes
    ----------
    frame : str
        A frame of the body.
    arm : Vector
        From the frame's origin to the point the force acts in.
    """

    frame: str
    force: Vector
    arm: Vector = NULL


@dataclass(frozen=True, slots=True)
class Moment:
    """A torque on a frame."""

    frame: str
    torque: Vector


@dataclass(frozen=True, slots=True)
class Effort:
    """A force or torque along a scalar rate, for instance that of a driven joint coordinate."""

    rate: Expr
    effort: Expr


Load = PointForce | Moment | Effort


@dataclass(frozen=True, slots=True)
class Projection:
    """``mass_matrix u' = forcing``, one row a speed."""

    mass_matrix: tuple[tuple[Expr, ...], ...]
    forcing: tuple[Expr, ...]


def project(
    kinematics: Kinematics, speeds: Sequence[int], bodies: Sequence[Inertia], loads: Sequence[Load]
) -> Projection:
    """Return the equations of motion in the speeds (nodes of u)."""
    graph = kinematics.tree.graph
    zero = number(graph, 0)
    n = len(speeds)
    mass = [[zero] * n for _ in range(n)]
    forcing = [zero] * n
    for body in bodies:
        _add_body(kinematics, speeds, body, mass, forcing)
    for load in loads:
        for j, work in enumerate(_virtual_work(kinematics, speeds, load)):
            forcing[j] = forcing[j] + work
    for i in range(n):
        for j in range(i + 1, n):
            mass[i][j] = mass[j][i]
    return Projection(tuple(map(tuple, mass)), tuple(forcing))


def kinetic_energy(kinematics: Kinematics, bodies: Sequence[Inertia]) -> Expr:
    """Return the kinetic energy of the bodies relative to ground [J]."""
    tree = kinematics.tree
    total = number(tree.graph, 0)
    for body in bodies:
        v = kinematics.velocities[body.frame]
        w = kinematics.angular_velocities[body.frame]
        total = total + body.mass * dot(tree, v, v) + dot(tree, w, _times(kinematics, body, w))
    return total / 2


def _add_body(
    kinematics: Kinematics,
    speeds: Sequence[int],
    body: Inertia,
    mass: list[list[Expr]],
    forcing: list[Expr],
) -> None:
    """Add one body's share to the lower triangle of the mass matrix and to the forcing."""
    tree = kinematics.tree
    v, w = kinematics.velocities[body.frame], kinematics.angular_velocities[body.frame]
    dv, dw = _partials(v, speeds), _partials(w, speeds)
    momenta = [_times(kinematics, body, partial) for partial in dw]
    a0 = _without_accelerations(kinematics.derivative(v), kinematics, speeds)
    alpha0 = _without_accelerations(kinematics.derivative(w), kinematics, speeds)
    torque0 = _times(kinematics, body, alpha0) + cross(tree, w, _times(kinematics, body, w))
    for i in range(len(speeds)):
        forcing[i] = forcing[i] - body.mass * dot(tree, dv[i], a0) - dot(tree, dw[i], torque0)
        for j in range(i + 1):
            share = body.mass * dot(tree, dv[i], dv[j]) + dot(tree, dw[i], momenta[j])
            mass[i][j] = mass[i][j] + share


def _virtual_work(kinematics: Kinematics, speeds: Sequence[int], load: Load) -> list[Expr]:
    graph, tree = kinematics.tree.graph, kinematics.tree
    if isinstance(load, Effort):
        return [Expr(graph, derivative(graph, [load.rate.index], u)[0]) * load.effort for u in speeds]
    if isinstance(load, PointForce):
        w = kinematics.angular_velocities[load.frame]
        v = kinematics.velocities[load.frame] + cross(tree, w, load.arm)
        return [dot(tree, p, load.force) for p in _partials(v, speeds)]
    return [dot(tree, p, load.torque) for p in _partials(kinematics.angular_velocities[load.frame], speeds)]


def _times(kinematics: Kinematics, body: Inertia, w: Vector) -> Vector:
    """Return the inertia tensor applied to a vector."""
    tree = kinematics.tree
    x, y, z = express(tree, w, body.frame).terms.get(body.frame, (number(tree.graph, 0),) * 3)
    rows = [row[0] * x + row[1] * y + row[2] * z for row in body.tensor]
    return vector(body.frame, (rows[0], rows[1], rows[2]))


def _partials(a: Vector, speeds: Sequence[int]) -> list[Vector]:
    return [a.map(partial(_slope, u)) for u in speeds]


def _slope(u: int, x: Expr) -> Expr:
    return Expr(x.graph, derivative(x.graph, [x.index], u)[0])


def _without_accelerations(a: Vector, kinematics: Kinematics, speeds: Sequence[int]) -> Vector:
    """Return an acceleration with all u' = 0."""
    graph: Graph = kinematics.tree.graph
    zero = {graph.symbol(graph.symbols[graph.left[u]].derivative): 0 for u in speeds}
    return a.map(lambda x: Expr(graph, substitute(graph, [x.index], zero)[0]))
