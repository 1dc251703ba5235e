"""Compliant ends of joint coordinates, and of the play of gears: forces along coordinates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.equations.constraints.couplings import coupling_value
from symbody.equations.constraints.frame_constraints import time_partial
from symbody.equations.contacts.contact_laws import normal_force
from symbody.equations.dynamics.load import GeneralizedForce, Law, is_constant, load_law
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, number
from symbody.model.constraints.couplings import Gear
from symbody.model.loads.gap_laws import HIGH, LOW, GapLaw, Limits

# How a gap changes with what is limited.
_SIGNS: Final = MappingProxyType({LOW: 1, HIGH: -1})


class _Gap(NamedTuple):
    """A gap with its rate."""

    value: Expr
    rate: Expr


def limit_law(names: Names, limits: Limits, coordinate: str, where: str) -> Law:
    """Return what compliant limits do along a coordinate."""
    x, rate = names.value(coordinate), names.value(f"{coordinate}_dot")
    gaps: dict[str, _Gap] = {}
    is_fixed = True
    for word, bound in ((LOW, limits.low), (HIGH, limits.high)):
        if bound is not None:
            end, sign = names.expression(bound, where), _SIGNS[word]
            is_fixed = is_fixed and is_constant(end)
            gaps[word] = _Gap(sign * (x - end), sign * (rate - time_partial(end)))
    return _gap_law(names, limits, gaps, {coordinate: number(names.graph, 1)}, is_fixed, where)


@load_law.register(Gear)
def _mesh_law(gear: Gear, names: Names, kinematics: Kinematics, roles: Sequence[JointRole]) -> Law | None:
    """Return what compliant teeth do to the wheels beyond their play; None without."""
    play = gear.backlash
    if play is None or play.rigid:
        return None
    where = f"constraint {gear.name}"
    factors = dict(
        zip(gear.coupled, (names.expression(factor, where) for factor in gear.factors), strict=True)
    )
    lead, offset = coupling_value(names, gear), names.expression(gear.offset, where)
    rate = -time_partial(offset)
    for name, factor in factors.items():
        rate = rate + factor * names.value(f"{name}_dot")
    half = names.expression(play.angle, where) / 2
    gaps = {word: _Gap(half + sign * lead, sign * rate) for word, sign in _SIGNS.items()}
    law = _gap_law(names, play, gaps, factors, is_constant(half) and is_constant(offset), where)
    effort = next(load.effort for load in law.loads if isinstance(load, GeneralizedForce))
    return replace(law, efforts={gear.name: effort})


def _gap_law(
    names: Names,
    law: GapLaw,
    gaps: Mapping[str, _Gap],
    factors: Mapping[str, Expr],
    is_fixed: bool,
    where: str,
) -> Law:
    """Return the forces that open gaps, as efforts along coordinates.

    Parameters
    ----------
    gaps : mapping of end to _Gap
        That at the low end grows with what is limited, that at the high end shrinks with it.
    factors : mapping of coordinate to Expr
        What is limited is the sum of these times the coordinates, less an offset.
    is_fixed : bool
        Whether the ends stay where they are.
    """
    zero = number(names.graph, 0)
    normal = law.normal
    total, elastic, energy = zero, zero, zero
    has_potential = is_fixed and normal.stiffness is not None and is_constant(
        names.expression(normal.stiffness, where)
    )  # fmt: skip
    for end, gap in gaps.items():
        value = normal_force(names, normal, gap.value, gap.rate, where)
        lossless = value.elastic if has_potential else zero
        total, elastic = total + _SIGNS[end] * value.force, elastic + _SIGNS[end] * lossless
        energy = energy + (value.energy if has_potential else zero)
    lossy = _efforts(names, factors, total - elastic)
    power = sum((load.effort * load.rate for load in lossy), zero)  # that of an end which moves among it
    return Law(_efforts(names, factors, total), energy, power, lossy)


def _efforts(names: Names, factors: Mapping[str, Expr], effort: Expr) -> tuple[GeneralizedForce, ...]:
    return tuple(
        GeneralizedForce(names.value(f"{name}_dot"), factor * effort, name)
        for name, factor in factors.items()
    )
