"""Derivatives of accelerations, and inverse dynamics."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import differentiate
from symbody.equations.solving.solution import solve
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol


def acceleration_slopes(
    formed: EquationsOfMotion, by: Sequence[Symbol], *, side_by_side: bool = False
) -> list[list[Expr]]:
    """Return the derivatives of u' by symbols, one row a speed, all other symbols held fixed.

    Parameters
    ----------
    side_by_side : bool
        Whether programs for several columns may be among the nodes: faster as code, but for nothing else.
    """
    udot, _ = solve(formed)
    if formed.rows or formed.friction:
        return differentiate(formed, udot, by)
    return formed.dynamics.acceleration_slopes(formed, udot, by, side_by_side=side_by_side)


def inverse_dynamics(formed: EquationsOfMotion) -> list[Expr]:
    """Return ``M u' - F``, what is missing along each speed for accelerations given as the symbols u'.

    Raises
    ------
    FormulationError
        If there is friction, which follows from the accelerations only together with the unknown forces.
    """
    if formed.friction:
        names = ", ".join(sorted({law.name for law in formed.friction}))
        raise FormulationError(
            Problem("equations.inverse_friction", "inverse_dynamics", f"{names} have friction",
                    "friction depends on the forces to be found",
                    "use inverse_dynamics(eqs, motion, unknowns, times), which solves for both")
        )  # fmt: skip
    return formed.dynamics.inverse_dynamics(formed.expressions([u.derivative for u in formed.u]))
