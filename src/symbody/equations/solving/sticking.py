"""Sticking and slipping: the equations of a mechanism for each way in which its dry joints hold or slide."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench
from symbody.equations.dynamics.reactions import drive_wrench
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.loads.friction import FrictionLaw
from symbody.expr.expression import number
from symbody.spatial.vector import cross

STICKS = 0  # other modes are the signs of slipping, 1 and -1


def switching_joints(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return what sticks and slips by events: joints, and contacts."""
    return tuple(dict.fromkeys(law.element for law in formed.friction if law.switches))


def set_modes(formed: EquationsOfMotion, modes: Mapping[str, int]) -> EquationsOfMotion:
    """Return the equations with each joint named sticking, or slipping in the direction of its sign.

    What sticks is held by further rows, whose multipliers are the efforts that hold it.
    """
    laws, rows = [], list(formed.rows)
    for law in formed.friction:
        mode = modes.get(law.element)
        if mode is None:
            laws.append(law)
            continue
        slip = law.slip if law.touch is not None and mode != STICKS else number(formed.graph, mode)
        laws.append(replace(law, slip=slip, switches=False, sticks=mode == STICKS))
        if mode == STICKS:
            rows.append(holding_row(formed, law))
    return replace(formed.with_rows(tuple(rows)), friction=tuple(laws))


def holding_row(formed: EquationsOfMotion, law: FrictionLaw) -> ConstraintEquation:
    """Return the row that keeps a rate zero: of a joint, or of the slip in a contact along a direction."""
    kinematics = formed.kinematics
    wrench = NO_WRENCH
    if law.touch is not None:
        lever = law.touch.point - law.touch.reach
        wrench = Wrench(law.touch.direction, cross(kinematics.tree, lever, law.touch.direction))
    elif law.joint is not None:
        role = next(role for role in formed.joint_roles if role.joint.name == law.name)
        if law.coordinate not in role.coordinates:
            one = number(formed.graph, 1)
            wrench = drive_wrench(formed.names, kinematics, law.joint, law.coordinate, one)
    return ConstraintEquation(
        name=law.holding_effort,
        element=law.owner,
        value=number(formed.graph, 0),
        jacobian=kinematics.speed_partials(law.rate),
        drift=kinematics.at_zero_speeds(law.rate),
        gamma=-kinematics.bias(law.rate),
        force=wrench.force,
        moment=wrench.moment,
        is_holonomic=False,
    )
