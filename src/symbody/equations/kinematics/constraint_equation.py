"""`Row`: one constraint, by its value, its rate, and the wrench it transmits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from symbody.equations.kinematics.motion import Kinematics
from symbody.expr.expression import Expr
from symbody.spatial.vector import ZERO, Vector


@dataclass(frozen=True, slots=True)
class ConstraintEquation:
    """One constraint ``value = 0``, ``jacobian u + drift = 0``, ``jacobian u' = gamma``.

    Attributes
    ----------
    name : str
        Of its multiplier.
    element : str
        The joint or constraint it belongs to.
    value : Expr
        0 where the row is not holonomic.
    jacobian : mapping of node to Expr
        Coefficients of the speeds, zeros left out.
    drift, gamma : Expr
        What explicit time contributes to the rate of the row; the right-hand side of its second derivative.
    force, moment : Vector
        On the end body by the start body for a multiplier of 1, at the origin of the end frame.
    coordinate : str
        The coordinate that a prescribed motion constrains, where the row is that of a motion.
    shares : mapping of coordinate to Expr
        The effort along coordinates of joints for a multiplier of 1, where the row is written in these.
    is_holonomic : bool
        Whether positions are constrained; otherwise only the rate of the row vanishes.
    driven : Expr or None
        Power for a multiplier of 1 of what the row itself says of time, as a length given by a formula in t.
    is_balance : bool
        Whether it is the balance of forces along a motion that moves no mass, which transmits nothing.
    gap : str
        Of a one-sided row what is open or closed: its element, with a number if that has several.
    sense : int
        The sign that value and multiplier may have where the row is one-sided, else 0.
    restitution : Expr or None
        Of a one-sided row, the share of its rate with which it opens after an impact; None for 0.
    """

    name: str
    element: str
    value: Expr
    jacobian: Mapping[int, Expr]
    drift: Expr
    gamma: Expr
    force: Vector = ZERO
    moment: Vector = ZERO
    coordinate: str = ""
    shares: Mapping[str, Expr] = field(default_factory=dict)
    is_holonomic: bool = True
    driven: Expr | None = None
    is_balance: bool = False
    gap: str = ""
    sense: int = 0
    restitution: Expr | None = None


def scalar_equation(kinematics: Kinematics, name: str, element: str, value: Expr) -> ConstraintEquation:
    """Return the row of a constraint given as an expression in coordinates and time."""
    rate = kinematics.rate(value)
    slopes = kinematics.speed_partials(rate)
    drift = kinematics.at_zero_speeds(rate)
    return ConstraintEquation(name, element, value, slopes, drift, -kinematics.bias(rate))
