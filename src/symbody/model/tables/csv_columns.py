"""Two columns of a file of values separated by commas, semicolons or tabs, as numbers in SI units."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from itertools import chain, pairwise
from types import MappingProxyType
from typing import Final

from symbody.errors import ModelError, Problem, nearest, number_in_words

Column = str | int
Point = tuple[float, float]

MAX_BYTES: Final = 500_000_000
_MOST_PROBLEMS: Final = 10
_SEPARATORS: Final = (";", "\t", ",")
# What one of a unit is in SI units.
_UNITS: Final = MappingProxyType(
    {
        "": 1.0, "1": 1.0, "%": 0.01,
        "s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0,
        "m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3, "in": 0.0254, "ft": 0.3048,
        "rad": 1.0, "deg": math.pi / 180.0, "rev": 2.0 * math.pi,
        "m/s": 1.0, "mm/s": 1e-3, "km/h": 1.0 / 3.6, "rad/s": 1.0, "deg/s": math.pi / 180.0,
        "rpm": math.pi / 30.0, "m/s^2": 1.0, "g0": 9.80665,
        "kg": 1.0, "N": 1.0, "kN": 1e3, "N m": 1.0, "kN m": 1e3, "N mm": 1e-3, "J": 1.0, "W": 1.0, "kW": 1e3,
        "V": 1.0, "A": 1.0, "Pa": 1.0, "bar": 1e5, "MPa": 1e6,
    }
)  # fmt: skip


def unit_factor(unit: str, where: str) -> float:
    """Return what one of a unit is in SI units; a ModelError lists the known ones."""
    if unit in _UNITS:
        return _UNITS[unit]
    cure = f"write one of {', '.join(filter(None, _UNITS))}, or convert the column"
    raise ModelError(Problem("table.unit", where, f"the unit {unit!r} is not known", "", cure))


def read_points(place: str, where: str, columns: Sequence[Column], units: Sequence[str]) -> tuple[Point, ...]:
    """Return the rows of two columns in SI units.

    The separator is the first of semicolon, tab and comma that the first row has; empty lines and lines that
    begin with ``#`` are passed over.
    Raises ModelError, with lines, if the file cannot be read, columns are missing, or values are none; also
    where the first column falls, or has a value three times.

    Parameters
    ----------
    place : str
        Path of the file.
    where : str
        What messages call it; the line follows.
    columns : (2,) str or int
        Names in the first row, or numbers counted from 1.
    units : (2,) str
        Units of the columns; "" is SI.
    """
    factors = [unit_factor(unit, where) for unit in units]
    rows = _rows(place, where)
    line, first = next(rows, (1, []))
    if not first:
        raise ModelError(Problem("table.empty", where, "the file has no rows", "", "restore the file"))
    chosen, has_header = _places(first, columns, f"{where}:{line}")
    problems: list[Problem] = []
    points: list[Point] = []
    lines: list[int] = []
    for number, row in rows if has_header else chain([(line, first)], rows):
        values = [_number(row, k, f"{where}:{number}", problems) for k in chosen]
        if len(problems) >= _MOST_PROBLEMS:
            break
        points.append((values[0] * factors[0], values[1] * factors[1]))
        lines.append(number)
    problems = problems or order_problems(points, [f"{where}:{number}" for number in lines])
    if not problems and len(points) < 2:
        what = f"there are {number_in_words(len(points), 'row')} of values"
        why = "a line needs two points"
        problems.append(Problem("table.short", where, what, why, "give two rows or more"))
    if problems:
        raise ModelError(*problems[:_MOST_PROBLEMS])
    return tuple(points)


def order_problems(points: Sequence[Point], places: Sequence[str]) -> list[Problem]:
    """Return what is wrong with the order of points, the first that falls or stands there three times."""
    for k, ((x, _), (following, _)) in enumerate(pairwise(points), 1):
        if following < x:
            what = f"{following:g} follows {x:g}"
            why = "the first column must increase"
            return [Problem("table.order", places[k], what, why, "sort the rows")]
        if k > 1 and following == x == points[k - 2][0]:
            what = f"{x:g} is listed three times"
            fix = "give it once, or twice for a jump: the second value applies from there on"
            return [Problem("table.order", places[k], what, "", fix)]
    if points and points[0][0] == points[-1][0] and len(points) > 1:
        what = f"all points have the argument {points[0][0]:g}"
        return [Problem("table.order", places[0], what, "", "give two different arguments")]
    return []


def _rows(place: str, where: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the rows that are not empty, with their lines."""
    try:
        with open(place, encoding="utf-8-sig", newline="") as file:
            if file.seek(0, 2) > MAX_BYTES:
                what = f"the file is larger than {MAX_BYTES // 1_000_000} MB"
                cure = "use fewer rows, or split the file"
                raise ModelError(Problem("table.too_large", where, what, "", cure))
            file.seek(0)
            separator = _separator(file)
            file.seek(0)
            reader = csv.reader(file, delimiter=separator, strict=True)
            for row in reader:
                if any(cell.strip() for cell in row) and not row[0].lstrip().startswith("#"):
                    yield reader.line_num, [cell.strip() for cell in row]
    except UnicodeDecodeError:
        why, fix = "it was saved in another encoding, or is not text", "save it as UTF-8 text"
        raise ModelError(Problem("table.encoding", where, "the file is not UTF-8 text", why, fix)) from None
    except csv.Error as error:
        fix = "close the quotes, and separate values by commas"
        raise ModelError(Problem("table.csv", where, f"the rows cannot be split: {error}", "", fix)) from None
    except OSError as error:
        what = f"the file cannot be read: {error.strerror}"
        raise ModelError(Problem("table.unreadable", where, what, "", "check its permissions")) from error


def _separator(lines: Iterator[str]) -> str:
    first = next((line for line in lines if line.strip() and not line.lstrip().startswith("#")), "")
    return next((mark for mark in _SEPARATORS if mark in first), ",")


def _places(first: list[str], columns: Sequence[Column], where: str) -> tuple[list[int], bool]:
    """Return the places of columns, from 0, and whether the first row is a header."""
    places = []
    for column in columns:
        if isinstance(column, int):
            if not 1 <= column <= len(first):
                what = f"there is no column {column}"
                why = f"the first row has {number_in_words(len(first), 'column')}, counted from 1"
                cure = f"give 1 to {len(first)}, or names"
                raise ModelError(Problem("table.column", where, what, why, cure))
            places.append(column - 1)
        elif first.count(column) == 1:
            places.append(first.index(column))
        elif column in first:
            what = f"the column {column!r} appears {first.count(column)} times"
            raise ModelError(Problem("table.column", where, what, "", "give its number, counted from 1"))
        else:
            what = f"there is no column {column!r}"
            fix = f"{nearest(column, first)} Or give its number, counted from 1."
            raise ModelError(Problem("table.column", where, what, "column names are in the first row", fix))
    by_name = any(isinstance(column, str) for column in columns)
    return places, by_name or not any(_is_number(first[k]) for k in places)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _number(row: list[str], column: int, where: str, problems: list[Problem]) -> float:
    cell = row[column] if column < len(row) else ""
    try:
        value = float(cell) if "_" not in cell else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        what = f"{cell!r} is not a finite number" if cell else f"column {column + 1} is empty"
        why = "use a decimal point, not a comma" if "," in cell else ""
        fix = "replace the comma by a point" if "," in cell else "correct the value, or remove the row"
        problems.append(Problem("table.value", where, what, why, fix))
    return value
