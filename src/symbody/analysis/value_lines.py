"""Values of results as lines of plain text: names with tidy numbers and units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

_ROUNDING: Final = 1e-12  # of an angle [rad]
_MOST_NAMES: Final = 12  # in one line


def values_line(values: Mapping[str, float], units: Mapping[str, str]) -> str:
    """Return names with their values to six digits and their units; names beyond the twelfth are counted.

    >>> values_line({"theta": 0.5, "phi": 1e-17, "s": 1e-17}, {"theta": "rad", "phi": "rad", "s": "m"})
    'theta = 0.5 rad, phi = 0 rad, s = 1e-17 m'
    """
    shown = [
        f"{name} = {without_rounding(value, units.get(name, '')):.6g} {units.get(name, '')}".rstrip()
        for name, value in values.items()
    ]
    if len(shown) > _MOST_NAMES:
        shown[_MOST_NAMES:] = [f"... ({len(shown)} in all)"]
    return ", ".join(shown)


def without_rounding(value: float, unit: str) -> float:
    """Return a value, or 0 for an angle that is rounding; of other units nobody can see what is small."""
    return 0.0 if unit == "rad" and abs(value) < _ROUNDING else value
