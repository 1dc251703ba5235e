"""Lagrange: the equations of motion from energies alone.

``E = d/dt dT/dq' - dT/dq + dV/dq - Q`` in the coordinates, returned as ``N^T E = 0`` in the speeds with
``q' = N u + nu`` substituted (Goldstein, Poole & Safko 2002, section 1.4; Meirovitch 1970, section 4.12, for
quasi-speeds). Euler parameters count as four independent coordinates: T is extended off the unit sphere
by ``w = 2 G(q) q'`` (Nikravesh 1988, chapter 6), and since the columns of N are tangent to the sphere, no
multiplier of the norm and nothing of the way T is extended is left in ``N^T E``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.load import Load
from symbody.equations.dynamics.projection import Projection
from symbody.equations.formulations.direct import virtual_work
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.placements import flow, moved, moved_matrix, placement, spin
from symbody.expr.calculus import forward, gradient, jacobian
from symbody.expr.expression import Expr, number
from symbody.expr.graph import TIME
from symbody.expr.rewrite import substitute
from symbody.vectors.dyadic import quadratic
from symbody.vectors.vector import vector


@dataclass(frozen=True, slots=True)
class Lagrange:
    """Formulation by energies and multipliers; any trees, any coordinates."""


@dataclass(frozen=True, slots=True)
class Energies:
    """What Lagrange's equations are made of.

    Attributes
    ----------
    coordinates, rates : tuple of int
        Nodes of q and of the symbols q', also where the speeds are no rates.
    kinetic : Expr
        T(q, q', t) [J].
    potential : Expr
        V(q, t) [J].
    loads : tuple of Load
        What has no potential.
    """

    coordinates: tuple[int, ...]
    rates: tuple[int, ...]
    kinetic: Expr
    potential: Expr
    loads: tuple[Load, ...]


def form_energies(
    kinematics: Kinematics,
    bodies: Sequence[Inertia],
    potential: Expr,
    loads: Sequence[Load],
    rotors: Sequence[tuple[Expr, Rotor]],
) -> Energies:
    """Return the energies from the placements of the bodies.

    Parameters
    ----------
    rotors : sequence of (Expr, Rotor)
        The coordinate with which each rotor turns, in q and time, before it.
    """
    graph = kinematics.graph
    q = tuple(kinematics.rates)
    rates = tuple(graph.symbol(graph.symbols[graph.left[node]].derivative) for node in q)
    tangents = {**dict(zip(q, rates, strict=True)), graph.symbol(TIME): graph.constant(1)}
    total = number(graph, 0)
    for body in bodies:
        place = placement(kinematics, body.frame)
        x, y, z = moved(graph, place.r, tangents)
        w = vector(body.frame, spin(place.R, moved_matrix(graph, place.R, tangents)))
        total = total + body.mass * (x * x + y * y + z * z)
        total = total + quadratic(kinematics.tree, w, body.tensor, w)
    for coordinate, rotor in rotors:
        (rate,) = moved(graph, [coordinate], tangents)
        total = total + rotor.inertia * rate**2
    return Energies(q, rates, total / 2, potential, tuple(loads))


def project_energies(kinematics: Kinematics, energies: Energies) -> Projection:
    """Return ``N^T E = 0`` as ``M u' = F``."""
    graph, speeds = kinematics.graph, kinematics.speeds
    q, rates = energies.coordinates, energies.rates
    second = flow(kinematics)
    in_speeds = {rate: kinematics.rates[node] for node, rate in zip(q, rates, strict=True)}
    # q'' with u' = 0, for the derivative of dT/dq' by time.
    bias = forward(graph, [kinematics.rates[node] for node in q], second)
    tangents = {**dict(zip(q, rates, strict=True)), graph.symbol(TIME): graph.constant(1)}
    tangents |= dict(zip(rates, bias, strict=True))
    momenta = gradient(graph, energies.kinetic.index, rates)
    changes = forward(graph, momenta, tangents)
    slopes = gradient(graph, energies.kinetic.index, q)
    pulls = gradient(graph, energies.potential.index, q)
    left = [
        (Expr(graph, p) - Expr(graph, t) + Expr(graph, v)).index
        for p, t, v in zip(changes, slopes, pulls, strict=True)
    ]
    left = substitute(graph, left, in_speeds)
    inertia = jacobian(graph, momenta, rates)
    flat = substitute(graph, [entry for row in inertia for entry in row], in_speeds)
    N = [_exprs(kinematics, row) for row in jacobian(graph, [kinematics.rates[k] for k in q], speeds)]
    H = [_exprs(kinematics, flat[i * len(q) : (i + 1) * len(q)]) for i in range(len(q))]
    forcing = [-force for force in _projected(kinematics, N, _exprs(kinematics, left))]
    _add_loads(kinematics, energies.loads, forcing)
    return Projection(_congruent(kinematics, N, H), tuple(forcing))


def _add_loads(kinematics: Kinematics, loads: Sequence[Load], forcing: list[Expr]) -> None:
    """Add the generalized forces Q, by the virtual displacements of the points where loads act."""
    place = {u: j for j, u in enumerate(kinematics.speeds)}
    for load in loads:
        for u, work in virtual_work(kinematics, load).items():
            forcing[place[u]] = forcing[place[u]] + work


def _congruent(
    kinematics: Kinematics, N: Sequence[Sequence[Expr]], H: Sequence[Sequence[Expr]]
) -> tuple[tuple[Expr, ...], ...]:
    """Return ``N^T H N``, symmetric."""
    n = len(kinematics.speeds)
    columns = [_projected(kinematics, N, row) for row in H]  # H N, one row a coordinate
    zero = number(kinematics.graph, 0)
    mass = [[zero] * n for _ in range(n)]
    for j in range(n):
        found = _projected(kinematics, N, [row[j] for row in columns])
        for i in range(j + 1):
            mass[i][j] = mass[j][i] = found[i]
    return tuple(map(tuple, mass))


def _projected(kinematics: Kinematics, N: Sequence[Sequence[Expr]], values: Sequence[Expr]) -> list[Expr]:
    """Return ``N^T values``."""
    found = [number(kinematics.graph, 0)] * len(kinematics.speeds)
    for row, value in zip(N, values, strict=True):
        for j, entry in enumerate(row):
            if not entry.is_zero:
                found[j] = found[j] + entry * value
    return found


def _exprs(kinematics: Kinematics, nodes: Sequence[int]) -> list[Expr]:
    return [Expr(kinematics.graph, node) for node in nodes]
