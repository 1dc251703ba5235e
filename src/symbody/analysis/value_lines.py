"""Values of results as lines of plain text: names with tidy numbers and units, and tables of modes."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from symbody.analysis.linear.modes import Mode

_ROUNDING: Final = 1e-12  # of an angle [rad]
_MOST_NAMES: Final = 12  # in one line
_MOST_MODES: Final = 24  # rows of a table
_MOST_COMPONENTS: Final = 6  # of a shape in one line


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


def mode_line(mode: Mode) -> str:
    """Return one mode as a line: eigenvalue, what engineers call it, and its shape."""
    facts = [f"frequency {mode.frequency:.5g} rad/s"] if mode.eigenvalue.imag else []
    if mode.eigenvalue.imag:
        facts.append(f"damping ratio {_plain(mode.damping_ratio)}")
    elif math.isfinite(mode.time_constant):
        facts.append(f"time constant {_plain(mode.time_constant)} s")
    return (
        f"eigenvalue {_complex(eigenvalue_on_axes(mode))} 1/s: {', '.join([*facts, f'shape {_shape(mode)}'])}"
    )


def mode_table(modes: Sequence[Mode]) -> str:
    """Return modes as a table, a pair of conjugate eigenvalues in one row."""
    heading = ("eigenvalue [1/s]", "frequency [rad/s]", "damping ratio", "time constant [s]", "shape")
    single = [mode for mode in modes if mode.eigenvalue.imag >= 0.0]
    rows = [
        (_complex(eigenvalue_on_axes(mode), pair=True), *map(_plain, _figures(mode)), _shape(mode))
        for mode in single[:_MOST_MODES]
    ]
    widths = [max(map(len, column)) for column in zip(heading, *rows, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in (heading, *rows)
    ]
    more = len(single) - _MOST_MODES
    return "\n".join([*lines, *([f"... and {more} more"] if more > 0 else [])])


def _figures(mode: Mode) -> tuple[float, float, float]:
    return mode.frequency, mode.damping_ratio, mode.time_constant


def eigenvalue_on_axes(mode: Mode) -> complex:
    """Return the eigenvalue with 0 for a real part that is rounding."""
    value = mode.eigenvalue
    return value if abs(value.real) > mode.tolerance else complex(0.0, value.imag)


def _plain(value: float) -> str:
    return f"{value + 0.0:.5g}" if math.isfinite(value) else "-"  # no minus before 0


def _complex(value: complex, pair: bool = False) -> str:
    if not value.imag:
        return f"{value.real + 0.0:.5g}"
    sign = "+-" if pair else "-" if value.imag < 0.0 else "+"
    return f"{value.real + 0.0:.5g} {sign} {abs(value.imag):.5g}i"


def _shape(mode: Mode) -> str:
    """Return the components, the largest first, with their phases where they are not in line with it."""
    ranked = sorted(mode.shape.items(), key=lambda item: -abs(item[1]))
    texts = [f"{name} {_component(complex(value))}" for name, value in ranked[:_MOST_COMPONENTS]]
    return ", ".join([*texts, *(["..."] if len(ranked) > _MOST_COMPONENTS else [])])


def _component(value: complex) -> str:
    size, phase = abs(value), math.degrees(cmath.phase(value))
    if size < 1e-9:
        return "0"
    if min(abs(phase), 180.0 - abs(phase)) < 0.05:
        return f"{value.real:.3g}"
    return f"{size:.3g} at {phase:.3g} deg"
