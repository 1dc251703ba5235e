"""Forces of compliant contacts: along the normal from the gap and its rate, across it from the slip."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from symbody.equations.contacts.contact_geometry import choose, is_less
from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.curves import curve_value
from symbody.expr.expression import Expr, maximum, minimum, number, sqrt
from symbody.expr.opcodes import EXP
from symbody.model.contacts.normal_force import NormalForce
from symbody.model.loads.curve import Curve
from symbody.model.loads.friction import Friction

# Steps of Newton, and levels of a fraction, that reach rounding.
_STEPS: Final = 4
_LEVELS: Final = 12
_SERIES_UP_TO: Final = 2


class NormalLawValue(NamedTuple):
    """The force along the normal in one point.

    Attributes
    ----------
    force : Expr
        Positive pushes apart [N].
    elastic : Expr
        The part with a potential [N].
    energy : Expr
        The potential [J].
    """

    force: Expr
    elastic: Expr
    energy: Expr


def normal_force(names: Names, law: NormalForce, gap: Expr, rate: Expr, where: str) -> NormalLawValue:
    """Return the force along the normal.

    Roots and powers have an argument of 1 where nothing touches, so that all slopes are finite there.

    Parameters
    ----------
    gap, rate : Expr
        Of the point [m, m/s].
    """
    graph = names.graph
    zero, one = number(graph, 0), number(graph, 1)
    touching = is_less(gap, zero)
    depth = choose(touching, -gap, one)
    if law.law is not None:
        inside = names.with_values({"gap": -depth, "gap_rate": rate})
        value = (
            curve_value(law.law, depth) if isinstance(law.law, Curve) else inside.expression(law.law, where)
        )
        return NormalLawValue(choose(touching, maximum(value, zero), zero), zero, zero)
    assert law.stiffness is not None
    stiffness, exponent = names.expression(law.stiffness, where), names.expression(law.exponent, where)
    spring = stiffness * _power(depth, exponent)
    loss = dissipation(names, law, where)
    if law.damping is not None:
        damper = names.expression(law.damping, where) * rate
        if law.depth is not None:
            damper = damper * minimum(depth / names.expression(law.depth, where), one)
        total = maximum(spring - damper, zero)
    else:
        total = spring if loss.is_zero else spring * maximum(1 - loss * rate, zero)
    elastic = choose(touching, spring, zero)
    energy = choose(touching, spring * depth / (exponent + 1), zero)
    return NormalLawValue(elastic if total == spring else choose(touching, total, zero), elastic, energy)


def _power(depth: Expr, exponent: Expr) -> Expr:
    """Return a power; of half a whole number with a root, which is faster."""
    value = exponent.number
    if value is None or isinstance(value, float) or (2 * value) % 2 != 1:
        return depth**exponent
    return depth ** int(value - value % 1) * sqrt(depth)


def dissipation(names: Names, law: NormalForce, where: str) -> Expr:
    """Return the factor of the rate in Hunt and Crossley's law [s/m]."""
    if law.dissipation is not None:
        return names.expression(law.dissipation, where)
    if law.restitution is None or law.speed is None:
        return number(names.graph, 0)
    restitution = names.expression(law.restitution, where)
    return dissipation_number(restitution) / names.expression(law.speed, where)


def dissipation_number(e: Expr) -> Expr:
    """Return the dissipation times the speed of the impact, a = c v, that makes a restitution e.

    The motion of a mass against Hunt and Crossley's force keeps ``c v - ln(1 + c v)`` and the energy of the
    spring together, whatever stiffness and exponent: so ``a - ln(1 + a) = -a e - ln(1 - a e)``. With
    ``x = a (1 + e)/2`` this is ``coth x - 1/x = (1 - e)/(1 + e)``, whose left side is Langevin's function. It
    is inverted by the fraction of Kroger, J. Non-Newtonian Fluid Mech. 223 (2015) 77, right to 3e-3, and by
    steps of Newton.
    """
    if e.number is not None:
        e = number(e.graph, float(e.number))  # exact numbers would grow beyond all bounds
    y = (1 - e) / (1 + e)
    y2 = y * y
    x = y * (3 - y2 * (6 + y2 - 2 * y2 * y2) / 5) / (1 - y2)
    for _ in range(_STEPS):
        share = _langevin_share(x)
        x = x - (x * share - y) / (1 - 2 * share - x * x * share * share)
    return 2 * x / (1 + e)


def _langevin_share(x: Expr) -> Expr:
    """Return ``(coth x - 1/x)/x`` of an x that is not negative; by a continued fraction where it is small."""
    graph = x.graph
    limit = number(graph, _SERIES_UP_TO)
    is_small = is_less(x, limit)
    small, large = choose(is_small, x, limit), choose(is_small, limit, x)
    square = small * small
    fraction = number(graph, 2 * _LEVELS + 1)
    for level in range(_LEVELS - 1, 0, -1):
        fraction = (2 * level + 1) + square / fraction
    decay = (large * -2).apply(EXP)
    return choose(is_small, 1 / fraction, ((1 + decay) / (1 - decay) - 1 / large) / large)


def friction_force(
    names: Names, friction: Friction, normal: Expr, slip: Sequence[Expr], where: str
) -> list[Expr]:
    """Return the force on end across the normal, against the slip, along the axes of its components.

    Parameters
    ----------
    normal : Expr
        The force along the normal [N].
    slip : sequence of Expr
        Along perpendicular axes; along x and y of the contact where the coefficients differ.
    """
    assert friction.v0 is not None
    square = number(names.graph, 0)
    for component in slip:
        square = square + component * component
    factor = normal / sqrt(square + names.expression(friction.v0, where) ** 2)
    mu = names.expression(friction.mu, where)
    if friction.mu_y is not None:
        across = names.expression(friction.mu_y, where)
        return [-(mu * factor * slip[0]), -(across * factor * slip[1])]
    if friction.mu_static is not None and friction.stribeck is not None:
        decay = (-(square / names.expression(friction.stribeck, where) ** 2)).apply(EXP)
        mu = mu + (names.expression(friction.mu_static, where) - mu) * decay
    return [-(mu * factor * component) for component in slip]
