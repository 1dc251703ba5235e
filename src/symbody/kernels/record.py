"""Records: arrays of reals whose entries have names.

A record is a class whose annotations are its fields, in the order of the array:

==================  ==============================================================================
``x: float``        a real
``k: int``          a whole number, kept as a real below 2^53
``m: Method``       another record, in line
``v: Reals``        ``= stored("count")``: so many reals elsewhere in the array; the field holds where
``p: Numbers``      ``= stored()``: a record elsewhere in the array, or nothing where the field is 0
``e: Rows[Event]``  ``= stored("events")``: so many records elsewhere, one after the other
==================  ==============================================================================

Places are counted from where the record begins. Files of records do not postpone annotations: Python, and the
reader of kernels, ask the class for its fields.
"""

import inspect
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar, get_args, get_origin

from symbody.kernels.language import Reals

R = TypeVar("R", bound="Record")


class Stored(NamedTuple):
    """The size of what lies elsewhere in an array: the product of fields, by name, and numbers."""

    factors: tuple[str | int, ...]


def stored(*factors: str | int) -> Any:
    """Declare that a field holds where its reals or records begin; the factors of their number."""
    return Stored(factors)


class Field:
    """One field of a record.

    Attributes
    ----------
    kind : type
        ``float``, ``int``, ``Reals`` or a class of records.
    place : int
        Where it lies, counted from the beginning of the record.
    stored : Stored or None
        How much is stored where the field says; None for what lies in line.
    is_row : bool
        Whether it is one of several records.
    """

    __slots__ = ("is_row", "kind", "name", "place", "stored")

    def __init__(self, name: str, annotation: Any, place: int, size: Stored | None) -> None:
        self.name, self.place, self.stored = name, place, size
        self.is_row = get_origin(annotation) is Rows
        self.kind: Any = get_args(annotation)[0] if self.is_row else annotation

    @property
    def size(self) -> int:
        """How many entries the field takes in line."""
        size: int = self.kind.size if issubclass(self.kind, Record) and self.stored is None else 1
        return size

    def __get__(self, record: "Record | None", owner: type) -> Any:
        """Return the value of the field in a record; the field itself for the class."""
        if record is None:
            return self
        value = record.entries[record.offset + self.place]
        if self.stored is None:
            if issubclass(self.kind, Record):
                return self.kind(record.entries, record.offset + self.place)
            return self.kind(value)
        begin = record.offset + int(value)
        if self.is_row:
            return Rows(record.entries, begin, self.kind)
        if issubclass(self.kind, Record):
            return self.kind(record.entries, begin)
        if isinstance(record.entries, list):
            return Reals(record.entries, begin)
        return record.entries[begin : begin + self.count(record)]

    def __set__(self, record: "Record", value: float) -> None:
        """Change a number."""
        record.entries[record.offset + self.place] = float(value)

    def count(self, record: "Record") -> int:
        """Return how many reals or records are stored where the field says."""
        count = 1
        for factor in () if self.stored is None else self.stored.factors:
            count *= getattr(record, factor) if isinstance(factor, str) else factor
        return count


class Record:
    """An array of reals whose entries have names.

    Attributes
    ----------
    entries : list or NumPy array
        All of the array.
    offset : int
        Where the record begins in it.
    fields : mapping of name to Field
    size : int
        How many entries the fields take.
    """

    __slots__ = ("entries", "offset")
    fields: ClassVar[Mapping[str, Field]] = MappingProxyType({})
    size: ClassVar[int] = 0

    def __init__(self, entries: Any, offset: int = 0) -> None:
        self.entries, self.offset = entries, offset

    def __init_subclass__(cls) -> None:
        """Lay out the fields."""
        fields: dict[str, Field] = {}
        for name, annotation in inspect.get_annotations(cls).items():
            fields[name] = field = Field(name, annotation, cls.size, cls.__dict__.get(name))
            cls.size += field.size
            setattr(cls, name, field)
        cls.fields = MappingProxyType(fields)

    def shift(self, offset: int) -> Reals:
        """Return the entries from a place of the record on."""
        return Reals(self.entries, self.offset + offset)


class Rows(Generic[R]):
    """Records one after the other."""

    __slots__ = ("_begin", "_entries", "_kind")

    def __init__(self, entries: Any, begin: int, kind: type[R]) -> None:
        self._entries, self._begin, self._kind = entries, begin, kind

    def __getitem__(self, k: int) -> R:
        return self._kind(self._entries, self._begin + self._kind.size * k)


def exists(record: Record) -> bool:
    """Return whether a record that is stored elsewhere is there: it never begins at place 0 of the array."""
    return record.offset != 0
