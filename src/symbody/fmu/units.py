"""Units of variables as exponents of base units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from symbody.equations.outputs.dimensions import read_unit

DEGREES: Final = 180.0 / math.pi
# Shown in degrees; the values stay in radians.
DISPLAYED: Final[Mapping[str, str]] = {"rad": "deg", "rad/s": "deg/s"}


def unit_exponents(unit: str) -> Mapping[str, int] | None:
    """Return the exponents of kg, m, s, rad in a unit; None where it is not a product of whole powers.

    >>> dict(unit_exponents("N m"))
    {'kg': 1, 'm': 2, 's': -2}
    """
    dimension = read_unit(unit)
    if dimension is None:
        return None
    if dimension.kg or dimension.m:  # radians count in pure angles and their rates only
        dimension = dimension.without_angle
    powers = {"kg": dimension.kg, "m": dimension.m, "s": dimension.s, "rad": dimension.rad}
    if any(power.denominator != 1 for power in powers.values()):
        return None
    return {name: int(power) for name, power in powers.items() if power}


def known_units(units: Iterable[str]) -> dict[str, Mapping[str, int]]:
    """Return the exponents of each unit that has them, in the order of the names."""
    made = {unit: unit_exponents(unit) for unit in sorted(set(units)) if unit}
    return {unit: powers for unit, powers in made.items() if powers is not None}
