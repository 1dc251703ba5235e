"""Sticking and slipping: the equations of a mechanism for each way in which its dry joints hold or slide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symbody.equations.dynamics.balance import NO_WRENCH
from symbody.equations.dynamics.reactions import drive_wrench
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.loads.friction import FrictionLaw
from symbody.expr.expression import number

STICKS = 0  # other modes are the signs of slipping, 1 and -1


def switching_joints(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the joints that stick and slip by events."""
    return tuple(law.joint.name for law in formed.friction if law.switches)


def set_modes(formed: EquationsOfMotion, modes: Mapping[str, int]) -> EquationsOfMotion:
    """Return the equations with each joint named sticking, or slipping in the direction of its sign.

    A joint that sticks is held by one more row, whose multiplier is the effort that holds it.
    """
    laws, rows = [], list(formed.rows)
    for law in formed.friction:
        mode = modes.get(law.joint.name)
        if mode is None:
            laws.append(law)
            continue
        laws.append(replace(law, slip=number(formed.graph, mode), switches=False, sticks=mode == STICKS))
        if mode == STICKS:
            rows.append(holding_row(formed, law))
    return replace(formed.with_rows(tuple(rows)), friction=tuple(laws))


def holding_row(formed: EquationsOfMotion, law: FrictionLaw) -> ConstraintEquation:
    """Return the row that keeps the rate of a joint zero."""
    kinematics, joint = formed.kinematics, law.joint
    role = next(role for role in formed.joint_roles if role.joint.name == joint.name)
    wrench = NO_WRENCH
    if law.coordinate not in role.coordinates:
        one = number(formed.graph, 1)
        wrench = drive_wrench(formed.names, kinematics, joint, law.coordinate, one)
    return ConstraintEquation(
        name=law.holding_effort,
        element=joint.name,
        value=number(formed.graph, 0),
        jacobian=kinematics.speed_partials(law.rate),
        drift=kinematics.at_zero_speeds(law.rate),
        gamma=-kinematics.bias(law.rate),
        force=wrench.force,
        moment=wrench.moment,
        is_holonomic=False,
    )
