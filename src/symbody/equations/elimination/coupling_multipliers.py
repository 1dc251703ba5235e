"""Multipliers of couplings that are substituted, from the equations of the coordinates that they give.

Along a substituted coordinate the wrench of its joint, less drives, friction and other constraints, is what
the couplings add: ``C^T lambda = residual``, C their factors of the substituted coordinates. Its inverse is
at hand, because the rows of ``C^-1`` are the combinations of couplings that give each coordinate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symbody.equations.dynamics.balance import Wrench
from symbody.equations.dynamics.load import GeneralizedForce
from symbody.equations.dynamics.reactions import effort_on_coordinate
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.system import MultibodySystem
from symbody.expr.expression import Expr, number
from symbody.model.joint import Joint


def coupling_multipliers(
    system: MultibodySystem,
    totals: Mapping[str, Wrench],
    rows: Sequence[tuple[ConstraintEquation, Expr]],
) -> dict[str, Expr]:
    """Return the multipliers of substituted couplings, in u' and other multipliers.

    Parameters
    ----------
    totals : mapping of joint to Wrench
        The total wrenches.
    rows : sequence of (ConstraintEquation, Expr)
        The constraints that are left, with their multipliers.
    """
    multipliers = {row.name: number(system.graph, 0) for row in system.coupled.rows}
    for role in system.joint_roles:
        for coordinate in role.substituted:
            residual = _residual(system, role.joint, coordinate, totals[role.joint.name], rows)
            for name, share in system.coupled.combinations[coordinate].items():
                multipliers[name] = multipliers[name] + share * residual
    return multipliers


def _residual(
    system: MultibodySystem,
    joint: Joint,
    coordinate: str,
    total: Wrench,
    rows: Sequence[tuple[ConstraintEquation, Expr]],
) -> Expr:
    """Return the effort along a coordinate that its joint needs beside all that is not substituted."""
    names = system.names
    effort = effort_on_coordinate(names, system.kinematics, joint, coordinate, total)
    if coordinate in system.rotors:
        effort = effort + system.rotors[coordinate].inertia * names.value(f"{coordinate}_ddot")
    for load in system.loads.loads:
        if isinstance(load, GeneralizedForce) and load.coordinate == coordinate:
            effort = effort - load.effort
    held = {law.holding_effort for law in system.friction if law.coordinate == coordinate}
    for row, multiplier in rows:
        if coordinate in row.shares:
            effort = effort - row.shares[coordinate] * multiplier
        if row.name in held:
            effort = effort - multiplier
    return effort
