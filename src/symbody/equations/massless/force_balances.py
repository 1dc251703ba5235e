"""What determines motions that move no mass: along each the forces are in balance, ``v . F(q, u, t) = 0``.

Forces of inertia do no work along them, so the balance holds loads alone. Combined so that as few as possible
contain speeds, a balance of first degree in the speeds is a constraint on velocities, one without speeds a
constraint on positions. Both are rows of the equations of motion whose multipliers are zero in every motion;
the derivation stands in ``docs/derivations/massless.md``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import Dynamics, ProjectedDynamics
from symbody.equations.formulations.projection import generalized_force
from symbody.equations.kinematics.constraint_equation import ConstraintEquation, scalar_equation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.placements import fold_zeros
from symbody.equations.loads.loads import form_loads
from symbody.equations.massless.null_motions import Motion, is_light, null_motions, rank, zero_pivots
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr, number
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.rewrite import dependence

_MASS: Final = "give mass or inertia to the bodies that move with it, or weld its joint"
_SPRING: Final = f"put a spring or a damper along it, or {_MASS}"


@dataclass(frozen=True, slots=True)
class ForceBalances:
    """The balances of forces along the motions that move no mass.

    Attributes
    ----------
    positions : tuple of ConstraintEquation
        Balances without speeds.
    velocities : tuple of ConstraintEquation
        Balances of first degree in the speeds.
    dependent : tuple of Symbol
        For each of these a speed that follows from it.
    idle : tuple of int
        Places of the speeds that move no mass by themselves: along them the forcing is a balance.
    """

    positions: tuple[ConstraintEquation, ...]
    velocities: tuple[ConstraintEquation, ...]
    dependent: tuple[Symbol, ...]
    idle: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class UndeterminedMotion:
    """Why forces do not determine a motion that moves no mass, and what to do.

    Attributes
    ----------
    speed : Symbol
        One that takes part in it.
    """

    speed: Symbol
    why: str
    fix: str = _MASS


@dataclass(frozen=True, slots=True)
class _Balance:
    """One balance, or a combination of several: its left-hand side and its coefficients of speeds.

    Attributes
    ----------
    place : int
        Of the speed whose coefficient is 1 in the motion it was taken along.
    """

    place: int
    value: Expr
    slopes: dict[int, Expr]

    def minus(self, factor: Expr, other: _Balance) -> _Balance:
        """Return this one less a multiple of another, slopes that vanish left out."""
        zero = number(self.value.graph, 0)
        speeds = {**self.slopes, **other.slopes}
        slopes = [self.slopes.get(u, zero) - factor * other.slopes.get(u, zero) for u in speeds]
        folded = fold_zeros(self.value.graph, slopes)
        kept = {u: slope for u, slope in zip(speeds, folded, strict=True) if not slope.is_zero}
        return _Balance(self.place, self.value - factor * other.value, kept)


def find_balances(formed: EquationsOfMotion) -> ForceBalances | UndeterminedMotion | None:
    """Return what determines the motions that move no mass; None if there are no such motions.

    Motions that constraints hold do not count: the constraints determine them.
    """
    if not any(map(is_light, formed.bodies)):
        return None
    if not (formed.rows or zero_pivots(formed, formed.dynamics.solve(formed, formed.dynamics.forcing))):
        return None
    motions = [motion for motion in null_motions(formed) if _is_free(formed, motion)]
    if not motions:
        return None
    balances = _take_balances(formed, motions)
    if isinstance(balances, UndeterminedMotion):
        return balances
    pivots, statics = _separate(formed, balances)
    reason = _obstacle(formed, motions, pivots, statics)
    if reason is not None:
        return reason
    kinematics, graph = formed.kinematics, formed.graph
    return ForceBalances(
        positions=tuple(_position_row(formed, motions, balance) for balance in statics),
        velocities=tuple(_velocity_row(formed, balance) for balance, _ in pivots),
        dependent=tuple(graph.symbols[graph.left[u]] for _, u in pivots),
        idle=tuple(
            k
            for k, u in enumerate(kinematics.speeds)
            if any(set(motion) == {k} for motion in motions) and u in {u for _, u in pivots}
        ),
    )


def position_notes(balances: ForceBalances) -> tuple[str, ...]:
    """Return which coordinates are positions of equilibrium."""
    names = [row.name.removeprefix("balance_") for row in balances.positions]
    return tuple(
        f"the motion of {name} has no mass and no damper: its position follows from the balance of forces, "
        f"the constraint balance_{name}, which transmits no reaction"
        for name in names
    )


def idle_dynamics(dynamics: Dynamics, idle: Sequence[int]) -> Dynamics:
    """Return the same dynamics, the forcing of speeds that move no mass by themselves as the 0 that it is."""
    forcing = list(dynamics.forcing)
    for k in idle:
        forcing[k] = number(forcing[k].graph, 0)
    return ProjectedDynamics(
        dynamics.mass_matrix, tuple(forcing), dynamics.kinetic_energy, dynamics.potential_energy
    )


def _is_free(formed: EquationsOfMotion, motion: Motion) -> bool:
    """Return whether no constraint holds a motion."""
    graph, speeds = formed.graph, formed.kinematics.speeds
    zero = number(graph, 0)
    rates = [
        sum((row.jacobian.get(speeds[k], zero) * share for k, share in motion.items()), zero).index
        for row in formed.rows
    ]
    return all(find_zeros(graph, rates))


def _take_balances(
    formed: EquationsOfMotion, motions: Sequence[Motion]
) -> list[_Balance] | UndeterminedMotion:
    """Return the balance along each motion, or why one of them is of no use."""
    kinematics, graph = formed.kinematics, formed.graph
    zero = number(graph, 0)
    model = formed.topology.model
    loads = form_loads(
        model, formed.names, kinematics, formed.bodies, formed.joint_roles, formed.friction, weights=False
    )
    forces = dict.fromkeys(kinematics.speeds, zero)
    for load in loads.loads:
        for u, force in generalized_force(kinematics, load).items():
            forces[u] = forces[u] + force
    balances = []
    for motion in motions:
        value = sum((share * forces[kinematics.speeds[k]] for k, share in motion.items()), zero)
        place = _main_speed(motion)
        slopes = kinematics.speed_partials(value)
        folded = fold_zeros(graph, list(slopes.values()))
        kept = {u: slope for u, slope in zip(slopes, folded, strict=True) if not slope.is_zero}
        why = _misfit(kinematics, value, kept)
        if why:
            return UndeterminedMotion(formed.u[place], why)
        balances.append(_Balance(place, value, kept))
    return balances


def _main_speed(motion: Motion) -> int:
    """Return the place of the first speed whose coefficient is 1."""
    return next(k for k in sorted(motion) if motion[k].number == 1)


def _misfit(kinematics: Kinematics, value: Expr, slopes: dict[int, Expr]) -> str:
    """Return why a balance is not a constraint, empty if it is one."""
    graph = kinematics.graph
    if SymbolKind.MULTIPLIER in dependence(graph, [value.index])[value.index]:
        return "dry friction acts along it, and its sign depends on the motion to be determined"
    for slope in slopes.values():
        by = [u for u in kinematics.speeds if u <= slope.index]
        if not all(find_zeros(graph, gradient(graph, slope.index, by))):
            return "the forces along it are not linear in the rates"
    return ""


def _separate(
    formed: EquationsOfMotion, balances: Sequence[_Balance]
) -> tuple[list[tuple[_Balance, int]], list[_Balance]]:
    """Return balances with a speed that follows from each, and combinations without speeds."""
    left, pivots = list(balances), []
    while any(balance.slopes for balance in left):
        choices = [(balance, u) for balance in left for u in balance.slopes]
        balance, u = min(choices, key=lambda pair: _cost(formed, *pair))
        left.remove(balance)
        pivots.append((balance, u))
        pivot = balance.slopes[u]
        left = [
            other.minus(other.slopes[u] / pivot, balance) if u in other.slopes else other for other in left
        ]
    at_rest = formed.kinematics.at_zero_speeds
    return pivots, [_Balance(balance.place, at_rest(balance.value), {}) for balance in left]


def _cost(formed: EquationsOfMotion, balance: _Balance, u: int) -> tuple[bool, int, bool, int]:
    """Return what makes a speed worse to solve a balance for: mass that moves with it above all."""
    place = formed.kinematics.speeds.index(u)
    slope = balance.slopes[u]
    kinds = dependence(slope.graph, [slope.index])[slope.index]
    moves_mass = not formed.dynamics.mass_matrix[place][place].is_zero
    return moves_mass, len(balance.slopes), not kinds <= {SymbolKind.PARAMETER}, place


def _obstacle(
    formed: EquationsOfMotion,
    motions: Sequence[Motion],
    pivots: Sequence[tuple[_Balance, int]],
    statics: Sequence[_Balance],
) -> UndeterminedMotion | None:
    """Return why balances do not determine the motions, None if they do."""
    graph, mass = formed.graph, formed.dynamics.mass_matrix
    outer = {SymbolKind.INPUT, SymbolKind.SIGNAL}
    for balance in statics:
        if outer & dependence(graph, [balance.value.index])[balance.value.index]:
            return UndeterminedMotion(
                formed.u[balance.place],
                "it follows directly from inputs or states of signals, so its acceleration needs their "
                "second derivatives",
                f"put a damper beside the spring, or {_MASS}",
            )
    for balance, u in pivots:
        moves = not all(row[formed.kinematics.speeds.index(u)].is_zero for row in mass)
        if moves and outer & dependence(graph, [balance.value.index])[balance.value.index]:
            return UndeterminedMotion(
                formed.u[balance.place],
                "a force on it follows from inputs or states of signals, and masses are placed relative "
                "to it",
                "start the joint of the body with mass at the ground or at a body with mass, and write the "
                "force as a formula in both coordinates",
            )
    rates = [_slopes_by_speed(formed, balance) for balance in (*(b for b, _ in pivots), *statics)]
    zero = number(graph, 0)
    along = [
        [sum((row.get(formed.kinematics.speeds[k], zero) * x for k, x in v.items()), zero) for v in motions]
        for row in rates
    ]
    if rank(graph, along) == len(motions):
        return None
    idle = [balance for balance, row in zip([*(b for b, _ in pivots), *statics], along, strict=True)
            if all(find_zeros(graph, [x.index for x in row]))]  # fmt: skip
    named = idle or [*statics, *(b for b, _ in pivots)]
    return UndeterminedMotion(
        formed.u[named[0].place], "no spring or damper that acts along it determines it", _SPRING
    )


def _slopes_by_speed(formed: EquationsOfMotion, balance: _Balance) -> dict[int, Expr]:
    """Return the coefficients of speeds, of the rate of a balance without speeds."""
    if balance.slopes:
        return balance.slopes
    return formed.kinematics.speed_partials(formed.kinematics.rate(balance.value))


def _position_row(
    formed: EquationsOfMotion, motions: Sequence[Motion], balance: _Balance
) -> ConstraintEquation:
    """Return the row of a balance without speeds, a displacement where its stiffness is constant."""
    kinematics = formed.kinematics
    motion = next(motion for motion in motions if _main_speed(motion) == balance.place)
    slopes = _slopes_by_speed(formed, balance)
    zero = number(formed.graph, 0)
    stiffness = sum((slopes.get(kinematics.speeds[k], zero) * x for k, x in motion.items()), zero)
    kinds = dependence(formed.graph, [stiffness.index])[stiffness.index]
    value = balance.value
    if kinds <= {SymbolKind.PARAMETER} and not find_zeros(formed.graph, [stiffness.index])[0]:
        value = value / stiffness
    return replace(scalar_equation(kinematics, *_names(formed, balance), value), is_balance=True)


def _velocity_row(formed: EquationsOfMotion, balance: _Balance) -> ConstraintEquation:
    kinematics = formed.kinematics
    name, element = _names(formed, balance)
    return ConstraintEquation(
        name=name,
        element=element,
        value=number(formed.graph, 0),
        jacobian=balance.slopes,
        drift=kinematics.at_zero_speeds(balance.value),
        gamma=-kinematics.bias(balance.value),
        is_holonomic=False,
        is_balance=True,
    )


def _names(formed: EquationsOfMotion, balance: _Balance) -> tuple[str, str]:
    """Return the name of the row of a balance, and the joint it belongs to."""
    speed = formed.u[balance.place]
    joint = next((role.joint.name for role in formed.joint_roles if speed in role.speeds), "")
    return f"balance_{speed.label.removesuffix('_dot')}", joint
