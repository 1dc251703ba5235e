"""`Lookup`: a name for a function of one variable given by points, of a file or in the model."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from numbers import Integral
from typing import Any, ClassVar, Final, Literal, final

from symbody.errors import ModelError
from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import ListOf, list_of
from symbody.model.declarations.element_fields import element
from symbody.model.declarations.field import FileTarget, Node, PlainField
from symbody.model.declarations.fields import Folder, Quantity, SymbolElementName, Text, WordChoice
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import Misfit, Path, Schema, list_misfits, wrong_type
from symbody.model.element import Element
from symbody.model.loads.curve import KINDS, OUTSIDE, segment_pieces
from symbody.model.tables.csv_columns import Column, Point, order_problems, read_points
from symbody.model.tables.inner_path import inner_path, saved_path


class ColumnChoice(PlainField[Iterable[str | int], tuple[Column, ...]]):
    """Two columns of a file, by name or number."""

    role: ClassVar[str] = "columns"
    takes: ClassVar[str] = "(2,) str or int"
    annotation: ClassVar[str] = "Iterable[str | int]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Column, ...]:
        """Return two names or numbers."""
        items = arguments.items(value, path)
        kept = tuple(
            x if isinstance(x, str) else int(x)
            for x in items
            if isinstance(x, str | Integral) and not isinstance(x, bool)
        )
        if len(items) == 2 == len(kept):
            return kept
        arguments.add("table.columns", path, f"{value!r} does not name two columns", "",
                      'write for instance columns = ["t", "z"], or columns = [1, 3]')  # fmt: skip
        return (1, 2)

    def schema(self) -> Schema:
        """Return two texts or integers."""
        column = {"anyOf": [{"type": "integer"}, {"type": "string"}]}
        return {"type": "array", "items": column, "minItems": 2, "maxItems": 2}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being two texts or integers."""
        return list_misfits(entry, path, _column_misfits, 2)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return a list of both."""
        return list(value)


def _column_misfits(entry: object, path: Path) -> Iterable[Misfit]:
    if isinstance(entry, str) or (isinstance(entry, int) and not isinstance(entry, bool)):
        return ()
    return wrong_type(entry, path, "the name or the number of a column")


@dataclass(frozen=True, eq=False, repr=False)
class UnitPair(ListOf[Iterable[str], tuple[str, ...]]):
    """Units of two columns."""

    role: ClassVar[str] = "units"
    takes: ClassVar[str] = "(2,) str"
    annotation: ClassVar[str] = "Iterable[str]"

    _: KW_ONLY
    item: Any = field(default_factory=Text)
    count: int | None = 2

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[str, ...]:
        """Return two units; whether they are known is seen where the file is read."""
        items = arguments.items(value, path)
        texts = tuple(x.strip() for x in items if isinstance(x, str))
        if len(items) == 2 == len(texts):
            return texts
        fix = 'write for instance units = ["s", "mm"]; "" is SI'
        arguments.add("table.units", path, f"{value!r} are not two units", "", fix)
        return ("", "")


@dataclass(frozen=True, eq=False, repr=False)
class TableFile(Text):
    """The CSV file of a table, in the folder of the model file or below it."""

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the path from the folder of the file that is written; a FormatError if it lies outside."""
        if target.folder is None:
            return Text.to_file(self, owner, value, target)
        where = f"table {owner.name}, file"
        return saved_path(value, owner.folder, target.folder, where, "file", "the file")


class TablePoints(PlainField[Iterable[Iterable[float]] | None, tuple[Point, ...]]):
    """Points, given or read from the file of the owner."""

    role: ClassVar[str] = "points"
    takes: ClassVar[str] = "(N, 2) numbers"
    annotation: ClassVar[str] = "Iterable[Iterable[float]] | None"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> tuple[Point, ...]:
        """Return the points, those of the file where none are given."""
        assert isinstance(owner, Lookup)
        if value is None:
            return _points_of_file(owner, arguments)
        points = []
        for k, item in enumerate(arguments.items(value, path)):
            point = _point(item)
            if point is None:
                fix = "write points = [[x1, y1], [x2, y2], ..], all of them finite numbers"
                arguments.add("table.point", f"{path}[{k}]", f"{item!r} is not a point", "", fix)
                return ()
            points.append(point)
        if len(points) < 2:
            what = f"there are {len(points)} points"
            arguments.add("table.short", path, what, "a line needs two", "give more")
        arguments.problems += order_problems(
            points, [arguments.where(f"{path}[{k}]") for k in range(len(points))]
        )
        return tuple(points)

    def schema(self) -> Schema:
        """Return a list of pairs."""
        return _PAIRS.schema()

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of a list of pairs."""
        return _PAIRS.misfits(entry, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return a list of pairs."""
        return [[Formula.from_value(x) for x in point] for point in value]

    def default_value(self, owner: object, name: str) -> object:
        """Return what the file has, so that points of a file are not shown as an argument."""
        return getattr(owner, name) if getattr(owner, "file", "") else None


_PAIRS: Final = list_of(list_of(Quantity(), 2))


@final
@element
class Lookup(Element):
    """A name for a function of one variable given by points: two columns of a CSV file, or points given here.

    Formulas contain the name. A place given twice is a jump: the later value holds from there on.

    Examples
    --------
    >>> bump = Lookup("road", points=[[0, 0], [1, 0.05], [2, 0]], argument="0.5*t")
    >>> bump.is_of_time
    True
    """

    kind: ClassVar[str] = "table"
    group: ClassVar[str] = "Signals"

    name: SymbolElementName = SymbolElementName("Unique among the symbols of the model.")
    file: TableFile = TableFile(
        "CSV file in the folder of the model file or below it, by its relative path.", default=""
    )
    columns: ColumnChoice = ColumnChoice(
        "Columns of the argument and of the value: names from the first row, or numbers from 1.",
        default=(1, 2),
    )
    units: UnitPair = UnitPair('Units of the columns, such as "mm"; "" is SI.', default=("", ""))
    interpolation: WordChoice[Literal["linear", "pchip"]] = WordChoice(
        'Straight lines between points, "linear"; or cubics with continuous slope, "pchip".',
        words=KINDS, default="linear",
    )  # fmt: skip
    outside: WordChoice[Literal["hold", "slope"]] = WordChoice(
        'Before the first and after the last point: the end value, "hold", or the end slope, "slope".',
        words=OUTSIDE, default="hold",
    )  # fmt: skip
    argument: Quantity = Quantity(
        "Argument of the function, in SI units: the time, or a formula.", default="t", scope=Scope.ARGUMENT
    )
    folder: Folder = Folder(
        'Directory that the path is relative to: that of the model file; "" is the working directory.'
    )
    points: TablePoints = TablePoints(
        "Arguments and values [[x, y], ..], instead of a file.", default=None, is_nullable=True
    )

    def check(self, arguments: Arguments) -> None:
        """Note a table without points and without a file."""
        if not self.file and not self.points and not arguments.problems:
            why = "a table is a function defined by points"
            arguments.add("table.one_of", "", "neither file nor points are given", why,
                          'write file = "road.csv", or points = [[0, 0], [1, 0.1]]')  # fmt: skip

    def to_entry(self, target: FileTarget) -> dict[str, Node]:
        """Return the entry of a model file; one that is read alone has the points of the file."""
        if target.is_alone and self.file:
            plain = replace(self, file="", columns=(1, 2), units=("", ""))
            return plain.to_entry(target)
        return Element.to_entry(self, target)

    @property
    def is_of_time(self) -> bool:
        """Whether its argument has no names but parameters and the time, as far as one can see here."""
        return set(self.argument.names) <= {"t", "pi"}

    def pieces(self) -> list[tuple[float, ...]]:
        """Return the pieces from left to right, those outside included; see `Curve.pieces`."""
        x, y = zip(*self.points, strict=True)
        return segment_pieces(x, y, self.interpolation, self.outside)


def _points_of_file(owner: Lookup, arguments: Arguments) -> tuple[Point, ...]:
    if not owner.file or arguments.problems:
        return ()
    where = arguments.where("file")
    try:
        place = inner_path(owner.file, owner.folder, where)
        return read_points(place, f"{where}, {owner.file}", owner.columns, owner.units)
    except ModelError as error:
        arguments.problems.extend(error.problems)
        return ()


def _point(item: object) -> Point | None:
    if isinstance(item, str | Mapping) or not isinstance(item, Iterable):
        return None
    try:
        values = [float(x) for x in item]
    except (TypeError, ValueError, OverflowError):
        return None
    return (values[0], values[1]) if len(values) == 2 and all(map(math.isfinite, values)) else None
