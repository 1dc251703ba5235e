"""`Curve`: a law given by points; and laws of springs, which are formulas or curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from itertools import pairwise
from typing import Any, ClassVar, Final, Literal, TypeAlias, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.field import Field, FileTarget, NewNames, Node
from symbody.model.declarations.fields import Numbers, WordChoice, part
from symbody.model.declarations.formula_site import FormulaSite, Scope
from symbody.model.declarations.misfits import FORMULA_SCHEMA, Misfit, Path, Schema, formula_misfits
from symbody.model.numbers import as_float, formula_value

KINDS: Final[tuple[Literal["linear", "pchip"], ...]] = ("linear", "pchip")
OUTSIDE: Final[tuple[Literal["hold", "slope"], ...]] = ("hold", "slope")


@final
@part
class Curve(Declared):
    """A function of one variable through given points; values are numbers, not formulas.

    Cubics of kind "pchip" have a continuous slope and do not overshoot: they are monotone where the points
    are (Fritsch & Butland 1984, the slopes of SciPy's ``PchipInterpolator``).

    Examples
    --------
    >>> import symbody as sb
    >>> stop = sb.Curve(x=(0, 0.1, 0.12), y=(0, -50, -400), outside="slope")
    >>> bumper = sb.Prismatic("bumper", "ground", "Cart", axis="x", force=sb.Drive(law=stop))
    """

    x: Numbers = Numbers("Increasing arguments; at least two.")
    y: Numbers = Numbers("Values at these arguments.")
    kind: WordChoice[Literal["linear", "pchip"]] = WordChoice(
        'Straight lines between points, "linear"; or cubics, "pchip".', words=KINDS, default="linear"
    )
    outside: WordChoice[Literal["hold", "slope"]] = WordChoice(
        'Before the first and after the last point: the end value, "hold", or the end slope, "slope".',
        words=OUTSIDE,
        default="hold",
    )

    def check(self, arguments: Arguments) -> None:
        """Note places that do not increase, and lists of different lengths."""
        if not arguments.problems:
            _check_points(arguments, self.places, self.values)

    @property
    def places(self) -> tuple[float, ...]:
        """The places as numbers."""
        return _numbers(self.x)

    @property
    def values(self) -> tuple[float, ...]:
        """The values as numbers."""
        return _numbers(self.y)

    def pieces(self) -> list[tuple[float, ...]]:
        """Return the pieces from left to right, those outside included.

        Each is ``(start, x0, c0, c1, ..)``: from `start` on, the value is ``c0 + c1 (x - x0) + ..``. The
        first starts at minus infinity.
        """
        return segment_pieces(self.places, self.values, self.kind, self.outside)


def segment_pieces(
    x: Sequence[float], y: Sequence[float], kind: str, outside: str
) -> list[tuple[float, ...]]:
    """Return the pieces of a function through points, as `Curve.pieces`; a place twice is a jump there."""
    ends = [0, *(k for k in range(1, len(x)) if x[k] == x[k - 1]), len(x)]
    parts = [(x[first:end], y[first:end]) for first, end in pairwise(ends)]
    inner = [piece for part in parts for piece in _part_pieces(*part, kind)]
    size = max(map(len, inner))
    inner = [(*piece, *(0.0,) * (size - len(piece))) for piece in inner]
    slope = outside == "slope"
    last_x, last_y = parts[-1]
    first_slope = inner[0][3] if slope and len(parts[0][0]) > 1 else 0.0
    width = last_x[-1] - inner[-1][1]
    terms = enumerate(inner[-1][2:] if slope and len(last_x) > 1 else ())
    last_slope = sum((k * c * width ** (k - 1) for k, c in terms if k), 0.0)
    rest = (0.0,) * (size - 4)
    before = (-math.inf, x[0], y[0], first_slope, *rest)
    return [before, *inner, (last_x[-1], last_x[-1], last_y[-1], last_slope, *rest)]


def _part_pieces(x: Sequence[float], y: Sequence[float], kind: str) -> list[tuple[float, ...]]:
    """Return the pieces ``(start, x0, c0, c1, ..)`` between the points of a part without jumps."""
    if len(x) == 1:
        return [(x[0], x[0], y[0], 0.0)]
    found = _lines(x, y) if kind == "linear" else _cubics(x, y)
    return [(start, start, *coefficients) for start, *coefficients in found]


Law: TypeAlias = Formula | Curve
LawValue: TypeAlias = Value | Curve | Mapping[str, object]


@dataclass(frozen=True, eq=False, repr=False)
class SpringLaw(Field[LawValue, Law]):
    """A formula or curve of a force or torque.

    Attributes
    ----------
    own : tuple of str
        Names that mean something in this formula alone.
    """

    role: ClassVar[str] = "law"
    takes: ClassVar[str] = "number, formula or Curve"
    annotation: ClassVar[str] = "LawValue"

    _: KW_ONLY
    own: tuple[str, ...] = ()

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Law:
        """Return the formula or curve."""
        return read_law(arguments, value, path)

    def schema(self) -> Schema:
        """Return a formula or the table of a curve."""
        numbers = {"type": "array", "items": FORMULA_SCHEMA, "minItems": 2}
        curve = {
            "type": "object",
            "properties": {
                "x": numbers,
                "y": numbers,
                "kind": {"enum": [*KINDS]},
                "outside": {"enum": [*OUTSIDE]},
            },
            "required": ["x", "y"],
            "additionalProperties": False,
        }
        return {"anyOf": [FORMULA_SCHEMA, curve], "description": "A formula, or a curve through points."}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a formula or a table, which `read` explains."""
        return () if isinstance(entry, dict) else formula_misfits(entry, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the formula, or the table of the curve."""
        return target.part(value) if isinstance(value, Curve) else value

    def rename(self, value: Any, names: NewNames) -> Law:
        """Return the formula in the new names; a curve has none."""
        return value if isinstance(value, Curve) else names.formula(value)

    def formula_sites(self, owner: object, value: Law, path: str) -> Iterator[FormulaSite]:
        """Return where the formula stands; a curve has none."""
        if not isinstance(value, Curve):
            yield FormulaSite(path, value, Scope.LOAD, self.own, self.unit)


def read_law(arguments: Arguments, value: object, path: str) -> Law:
    """Return a law from a formula, a curve, or the table of one as it stands in a file."""
    if isinstance(value, Curve):
        return value
    if not isinstance(value, Mapping):
        return arguments.formula(value, path)
    words = set(map(str, value))
    wrong = words - {"x", "y", "kind", "outside"} or {"x", "y"} - words
    if wrong:
        fault = "is missing" if wrong <= {"x", "y"} else "is not a valid choice"
        fix = "write { x = [..], y = [..] }, with kind and outside if needed"
        arguments.add("model.curve_words", path, f"{', '.join(sorted(wrong))} {fault} in a curve", "", fix)
        return ZERO
    table: dict[str, Any] = {str(word): item for word, item in value.items()}
    made = arguments.attempt(lambda: Curve(**table), path)
    return ZERO if made is None else made


def _check_points(arguments: Arguments, x: Sequence[float], y: Sequence[float]) -> None:
    if len(x) != len(y) or len(x) < 2:
        why = "every argument needs one value, and a line needs two points"
        fix = "give two lists of the same length, with two points or more"
        arguments.add("model.curve_length", "", f"there are {len(x)} arguments and {len(y)} values", why, fix)
        return
    for k, (left, right) in enumerate(pairwise(x)):
        if not left < right:
            why = "arguments must increase; for a jump use two that differ slightly"
            fix = "sort the points, with each argument only once"
            arguments.add("model.curve_order", f"x[{k + 1}]", f"{right:g} follows {left:g}", why, fix)
            return


def _numbers(formulas: Iterable[Formula]) -> tuple[float, ...]:
    values = (formula_value(formula) for formula in formulas)
    return tuple(math.nan if value is None else as_float(value) for value in values)


def _lines(x: Sequence[float], y: Sequence[float]) -> list[tuple[float, ...]]:
    return [
        (x0, y0, (y1 - y0) / (x1 - x0)) for (x0, x1), (y0, y1) in zip(pairwise(x), pairwise(y), strict=True)
    ]


def _cubics(x: Sequence[float], y: Sequence[float]) -> list[tuple[float, ...]]:
    slopes = _monotone_slopes(x, y)
    found: list[tuple[float, ...]] = []
    for k in range(len(x) - 1):
        h, rise = x[k + 1] - x[k], (y[k + 1] - y[k]) / (x[k + 1] - x[k])
        a, b = slopes[k], slopes[k + 1]
        found.append((x[k], y[k], a, (3 * rise - 2 * a - b) / h, (a + b - 2 * rise) / h**2))
    return found


def _monotone_slopes(x: Sequence[float], y: Sequence[float]) -> list[float]:
    """Return the slope at each place: a weighted harmonic mean of those beside it, 0 at extrema."""
    widths = [right - left for left, right in pairwise(x)]
    rises = [(y[k + 1] - y[k]) / width for k, width in enumerate(widths)]
    if len(rises) == 1:
        return [rises[0], rises[0]]
    inner = [
        _inner_slope(h0, h1, d0, d1)
        for (h0, h1), (d0, d1) in zip(pairwise(widths), pairwise(rises), strict=True)
    ]
    first = _end_slope(widths[0], widths[1], rises[0], rises[1])
    return [first, *inner, _end_slope(widths[-1], widths[-2], rises[-1], rises[-2])]


def _inner_slope(h0: float, h1: float, d0: float, d1: float) -> float:
    if d0 * d1 <= 0:
        return 0.0
    first, second = 2 * h1 + h0, h1 + 2 * h0
    return (first + second) / (first / d0 + second / d1)


def _end_slope(h0: float, h1: float, d0: float, d1: float) -> float:
    """Return the slope of the parabola through three points, kept from turning the curve round."""
    slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
    if slope * d0 <= 0:
        return 0.0
    return 3 * d0 if d0 * d1 <= 0 and abs(slope) > 3 * abs(d0) else slope
