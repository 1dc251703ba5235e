"""`Projection`: mass matrix and forcing in the speeds, whichever formulation finds them."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.expression import Expr


@dataclass(frozen=True, slots=True)
class Projection:
    """``mass_matrix u' = forcing``, one row a speed, without multipliers."""

    mass_matrix: tuple[tuple[Expr, ...], ...]
    forcing: tuple[Expr, ...]


def add_rotor(kinematics: Kinematics, rotor: Rotor, mass: list[list[Expr]], forcing: list[Expr]) -> None:
    """Add what turns with a rate to the mass matrix and the forcing."""
    slopes = kinematics.slopes(rotor.rate)
    bias = kinematics.bias(rotor.rate)
    for i, u in enumerate(kinematics.speeds):
        if u in slopes:
            forcing[i] = forcing[i] - rotor.inertia * bias * slopes[u]
            for j, other in enumerate(kinematics.speeds):
                if other in slopes:
                    mass[i][j] = mass[i][j] + rotor.inertia * slopes[u] * slopes[other]
