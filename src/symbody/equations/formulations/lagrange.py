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
from typing import ClassVar

from symbody.equations.dynamics.load import Load
from symbody.equations.formulations.formulation import Dynamics, Formulation, ProjectedDynamics
from symbody.equations.formulations.projection import generalized_force, projected_dynamics
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.placements import (
    differentiate,
    differentiate_matrix,
    flow,
    ground_placement,
    spin,
)
from symbody.equations.system import MultibodySystem
from symbody.expr.calculus import forward, gradient, jacobian
from symbody.expr.expression import Expr, number
from symbody.expr.graph import TIME
from symbody.expr.rewrite import substitute
from symbody.spatial.dyadic import quadratic
from symbody.spatial.vector import vector


@dataclass(frozen=True, slots=True)
class Lagrange(Formulation):
    """Formulation by energies and multipliers; any trees, any coordinates.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]), sb.Lagrange())
    >>> eqs.mass_matrix
    Matrix([[2]])
    """

    differentiates_placements: ClassVar[bool] = True
    takes_kinetic_energy: ClassVar[bool] = True

    def derive(self, system: MultibodySystem) -> Dynamics:
        """Return the equations of motion from the placements of the bodies."""
        return project_energies(system, _kinetic_energy(system))


def project_energies(system: MultibodySystem, kinetic: Expr) -> ProjectedDynamics:
    """Return ``N^T E = 0`` as ``M u' = F``.

    Parameters
    ----------
    kinetic : Expr
        T in q, t and the symbols q', also where the speeds are not rates [J].
    """
    kinematics = system.kinematics
    graph, speeds = kinematics.graph, kinematics.speeds
    q, rates = tuple(kinematics.rates), _rate_symbols(kinematics)
    in_speeds = {rate: kinematics.rates[node] for node, rate in zip(q, rates, strict=True)}
    # q'' with u' = 0, for the derivative of dT/dq' by time.
    bias = forward(graph, [kinematics.rates[node] for node in q], flow(kinematics))
    tangents = _tangents(kinematics) | dict(zip(rates, bias, strict=True))
    momenta = gradient(graph, kinetic.index, rates)
    changes = forward(graph, momenta, tangents)
    slopes = gradient(graph, kinetic.index, q)
    pulls = gradient(graph, system.loads.potential_energy.index, q)
    left = [
        (Expr(graph, p) - Expr(graph, t) + Expr(graph, v)).index
        for p, t, v in zip(changes, slopes, pulls, strict=True)
    ]
    left = substitute(graph, left, in_speeds)
    inertia = jacobian(graph, momenta, rates)
    flat = substitute(graph, [entry for row in inertia for entry in row], in_speeds)
    N = [_exprs(kinematics, row) for row in jacobian(graph, [kinematics.rates[k] for k in q], speeds)]
    H = [_exprs(kinematics, flat[i * len(q) : (i + 1) * len(q)]) for i in range(len(q))]
    forcing = [-force for force in _project(kinematics, N, _exprs(kinematics, left))]
    _add_loads(kinematics, system.loads.without_potential, forcing)
    return projected_dynamics(system, _congruent(kinematics, N, H), forcing)


def _kinetic_energy(system: MultibodySystem) -> Expr:
    """Return the kinetic energy in q, t and the symbols q', from the placements of bodies and rotors [J]."""
    kinematics = system.kinematics
    graph, tangents = kinematics.graph, _tangents(kinematics)
    total = number(graph, 0)
    for body in system.bodies:
        place = ground_placement(kinematics, body.frame)
        x, y, z = differentiate(graph, place.r, tangents)
        w = vector(body.frame, spin(place.R, differentiate_matrix(graph, place.R, tangents)))
        total = total + body.mass * (x * x + y * y + z * z)
        total = total + quadratic(kinematics.tree, w, body.tensor, w)
    for coordinate, rotor in system.rotors.items():
        (rate,) = differentiate(graph, [system.names.value(coordinate)], tangents)
        total = total + rotor.inertia * rate**2
    return total / 2


def _rate_symbols(kinematics: Kinematics) -> tuple[int, ...]:
    """Return the nodes of the symbols q'."""
    graph = kinematics.graph
    return tuple(graph.symbol(graph.symbols[graph.left[node]].derivative) for node in kinematics.rates)


def _tangents(kinematics: Kinematics) -> dict[int, int]:
    """Return the time derivatives of q and t, in the symbols q'."""
    graph = kinematics.graph
    rates = dict(zip(kinematics.rates, _rate_symbols(kinematics), strict=True))
    return {**rates, graph.symbol(TIME): graph.constant(1)}


def _add_loads(kinematics: Kinematics, loads: Sequence[Load], forcing: list[Expr]) -> None:
    """Add the generalized forces Q, by the virtual displacements of the points where loads act."""
    place = {u: j for j, u in enumerate(kinematics.speeds)}
    for load in loads:
        for u, work in generalized_force(kinematics, load).items():
            forcing[place[u]] = forcing[place[u]] + work


def _congruent(
    kinematics: Kinematics, N: Sequence[Sequence[Expr]], H: Sequence[Sequence[Expr]]
) -> list[list[Expr]]:
    """Return ``N^T H N``, symmetric."""
    n = len(kinematics.speeds)
    columns = [_project(kinematics, N, row) for row in H]  # H N, one row a coordinate
    zero = number(kinematics.graph, 0)
    mass = [[zero] * n for _ in range(n)]
    for j in range(n):
        column = _project(kinematics, N, [row[j] for row in columns])
        for i in range(j + 1):
            mass[i][j] = mass[j][i] = column[i]
    return mass


def _project(kinematics: Kinematics, N: Sequence[Sequence[Expr]], values: Sequence[Expr]) -> list[Expr]:
    """Return ``N^T values``."""
    products = [number(kinematics.graph, 0)] * len(kinematics.speeds)
    for row, value in zip(N, values, strict=True):
        for j, entry in enumerate(row):
            if not entry.is_zero:
                products[j] = products[j] + entry * value
    return products


def _exprs(kinematics: Kinematics, nodes: Sequence[int]) -> list[Expr]:
    return [Expr(kinematics.graph, node) for node in nodes]
