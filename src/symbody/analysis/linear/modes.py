"""Natural motions of ``x' = A x``: eigenvalues with what engineers call them, and what they say of stability.

An eigenvalue is known to a few ``eps |A| / s``, with s the cosine between its left and right eigenvector
(Golub & Van Loan 2013, section 7.2.2), of the balanced matrix, times the condition of the equations that A
came from. Whatever is nearer to the imaginary axis is on it.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig, matrix_balance

from symbody.notebook import Displayed

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_EPS: Final = float(np.finfo(float).eps)
_MOST_MODES: Final = 24  # rows of a table
_MOST_COMPONENTS: Final = 6  # of a shape in one line


@dataclass(frozen=True, slots=True, repr=False)
class Mode(Displayed):
    """One natural motion ``Re(shape exp(eigenvalue t))``.

    Attributes
    ----------
    eigenvalue : complex
        [1/s]; of a pair the one with positive imaginary part comes first.
    tolerance : float
        Bound on its rounding error [1/s].
    shape : mapping of name to complex
        The eigenvector by names of states, the largest component 1, each in its own unit.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(stiffness=8))
    >>> linear = sb.linearize(sb.form_equations(sb.Model("oscillator", [rail])))
    >>> [round(mode.eigenvalue.imag, 9) for mode in linear.modes]
    [2.0, -2.0]
    """

    eigenvalue: complex
    tolerance: float
    shape: Mapping[str, complex]

    def __repr__(self) -> str:
        return f"Mode of {_mode_line(self)}"

    @property
    def frequency(self) -> float:
        """Natural frequency ``|eigenvalue|`` [rad/s]."""
        return abs(self.eigenvalue)

    @property
    def damping_ratio(self) -> float:
        """``-Re / |eigenvalue|``: 1 and above does not oscillate, below 0 grows; NaN for eigenvalue 0."""
        if self.frequency <= self.tolerance:
            return math.nan
        return -self.eigenvalue.real / self.frequency if math.isfinite(self.time_constant) else 0.0

    @property
    def time_constant(self) -> float:
        """Time in which it falls to 1/e, negative where it grows, infinite on the imaginary axis [s]."""
        real = self.eigenvalue.real
        return -1.0 / real if abs(real) > self.tolerance else math.inf


class Modes(tuple[Mode, ...], Displayed):
    """All modes of linear equations, the fastest growing first: a tuple that shows itself as a table."""

    __slots__ = ()

    def __repr__(self) -> str:
        return _mode_table(self)


@dataclass(frozen=True, slots=True)
class Spectrum:
    """All modes of a matrix, the fastest growing first, and the verdict."""

    modes: Modes
    verdict: str


def spectrum(A: Floats, names: Sequence[str], coordinates: int, noise: float) -> Spectrum:
    """Return the modes of A.

    Parameters
    ----------
    coordinates : int
        Number of coordinates among the states; they stand last.
    noise : float
        Relative error of A, in units of eps.
    """
    if not A.size:
        return Spectrum(Modes(), "stable")
    with np.errstate(invalid="ignore"):  # SciPy casts scales to integers before it replaces them
        balanced, scaling = matrix_balance(A, permute=False)
    values, left, right = eig(balanced, left=True, right=True)
    cosines = np.abs(np.sum(left.conj() * right, axis=0))
    level = min(len(A) * noise * _EPS, 1.0)  # A may be no more than noise: of a singular mass matrix
    # A double root is known to the square root of the error; s vanishes there.
    tolerances = level * np.linalg.norm(balanced) / np.maximum(cosines, math.sqrt(max(level, _EPS)))
    shapes = scaling @ right
    # On the imaginary axis rounding does not decide the order.
    growth = np.where(np.abs(values.real) <= tolerances, 0.0, values.real)
    ranked = sorted(range(len(values)), key=lambda k: (-growth[k], abs(values[k]), -values[k].imag))
    modes = Modes(Mode(complex(values[k]), float(tolerances[k]), _shape(names, shapes[:, k])) for k in ranked)
    return Spectrum(modes, _verdict(modes, balanced[:, len(A) - coordinates :], level))


def _shape(names: Sequence[str], vector: Complexes) -> dict[str, complex]:
    largest = vector[int(np.argmax(np.abs(vector)))]
    return {name: complex(x) for name, x in zip(names, vector / largest, strict=True)}


def _verdict(modes: Sequence[Mode], slopes: Floats, level: float) -> str:
    """Say whether deviations die out; `slopes` are the columns of the coordinates."""
    if any(mode.eigenvalue.real > mode.tolerance for mode in modes):
        return "unstable"
    singular = np.linalg.svd(slopes, compute_uv=False)
    drifts = slopes.shape[1] > 0 and (
        slopes.shape[1] > slopes.shape[0] or singular[-1] <= level * max(float(singular[0]), 0.0)
    )
    if drifts and any(mode.frequency <= mode.tolerance for mode in modes):
        return "drifting"
    if any(abs(mode.eigenvalue.real) <= mode.tolerance for mode in modes):
        return "marginal"
    return "stable"


def _mode_line(mode: Mode) -> str:
    """Return one mode as a line: eigenvalue, what engineers call it, and its shape."""
    facts = [f"frequency {mode.frequency:.5g} rad/s"] if mode.eigenvalue.imag else []
    if mode.eigenvalue.imag:
        facts.append(f"damping ratio {_plain(mode.damping_ratio)}")
    elif math.isfinite(mode.time_constant):
        facts.append(f"time constant {_plain(mode.time_constant)} s")
    facts.append(f"shape {_shape_line(mode)}")
    return f"eigenvalue {_complex(eigenvalue_on_axes(mode))} 1/s: {', '.join(facts)}"


def _mode_table(modes: Sequence[Mode]) -> str:
    """Return modes as a table, a pair of conjugate eigenvalues in one row."""
    heading = ("eigenvalue [1/s]", "frequency [rad/s]", "damping ratio", "time constant [s]", "shape")
    single = [mode for mode in modes if mode.eigenvalue.imag >= 0.0]
    rows = [
        (_complex(eigenvalue_on_axes(mode), pair=True), *map(_plain, _figures(mode)), _shape_line(mode))
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


def _shape_line(mode: Mode) -> str:
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
