"""The row of a constraint between two frames, from the wrench it transmits.

A multiplier of 1 gives a force and a moment on end; the rate of the constraint is their power on the motion
of end relative to start. One formula serves all: rods, planes, directions, blades and wheels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.velocity import Velocity
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr
from symbody.expr.graph import TIME
from symbody.model.constraint import FrameConstraint
from symbody.spatial.vector import ZERO, Vector, cross, dot


@dataclass(frozen=True, slots=True)
class _Motion:
    """The motion of end relative to start, as a force at end's origin and a moment work on it."""

    kinematics: Kinematics
    start: str
    end: str

    def power(self, force: Vector, moment: Vector, part: Callable[[Velocity], Vector]) -> Expr:
        """Return the work of a wrench on one part of the velocities: a partial, or the rest."""
        tree = self.kinematics.tree
        v, w = self.kinematics.velocities, self.kinematics.angular_velocities
        lever = cross(tree, self.kinematics.position(self.start, self.end), force)
        return (
            dot(tree, force, part(v[self.end]) - part(v[self.start]))
            + dot(tree, moment, part(w[self.end]) - part(w[self.start]))
            - dot(tree, part(w[self.start]), lever)
        )

    def change(self, force: Vector, moment: Vector, force_rate: Vector | None) -> Expr:
        """Return the time derivative of the power with all u' = 0."""
        kinematics, tree = self.kinematics, self.kinematics.tree
        v, v_end = kinematics.velocities[self.start], kinematics.velocities[self.end]
        w, w_end = kinematics.angular_velocities[self.start], kinematics.angular_velocities[self.end]
        closing = v_end.value - v.value
        seen = closing - cross(tree, w.value, kinematics.position(self.start, self.end))
        force_rate = kinematics.derivative(force) if force_rate is None else force_rate
        return (
            self.power(force, moment, lambda velocity: velocity.bias)
            - dot(tree, force, cross(tree, w.value, closing))
            + dot(tree, force_rate, seen)
            + dot(tree, kinematics.derivative(moment), w_end.value - w.value)
        )


def pair_equation(
    kinematics: Kinematics,
    contact: FrameConstraint,
    *,
    value: Expr | None,
    force: Vector = ZERO,
    moment: Vector = ZERO,
    force_rate: Vector | None = None,
    target: Expr | None = None,
) -> ConstraintEquation:
    """Return the row ``value - target = 0``, or its rate alone.

    Parameters
    ----------
    value : Expr or None
        What the power belongs to; None: there is no such thing, only the rate vanishes.
    force, moment : Vector
        On end at its origin for a multiplier of 1, functions of the coordinates.
    force_rate : Vector, optional
        Time derivative of the force as seen from ground, where it has a short form.
    target : Expr, optional
        A function of further coordinates and time.
    """
    zero = Expr(kinematics.graph, 0)
    target = zero if target is None else target
    slide = kinematics.rate(target)
    target_partials = kinematics.speed_partials(slide)
    motion = _Motion(kinematics, contact.start.full_name, contact.end.full_name)
    slopes = {
        u: motion.power(force, moment, partial(_partial, u)) - target_partials.get(u, zero)
        for u in kinematics.speeds
    }
    drift = motion.power(force, moment, lambda velocity: velocity.drift)
    return ConstraintEquation(
        name="",
        element=contact.name,
        value=zero if value is None else value - target,
        jacobian={u: slope for u, slope in slopes.items() if not slope.is_zero},
        drift=drift - kinematics.at_zero_speeds(slide),
        gamma=kinematics.bias(slide) - motion.change(force, moment, force_rate),
        force=force,
        moment=moment,
        is_holonomic=value is not None,
        driven=time_partial(target),
    )


def time_partial(value: Expr) -> Expr:
    """Return the partial derivative of a formula by time, as it is written."""
    graph = value.graph
    return Expr(graph, gradient(graph, value.index, [graph.symbol(TIME)])[0])


def _partial(u: int, velocity: Velocity) -> Vector:
    return velocity.partial(u)
