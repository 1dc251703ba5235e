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
from collections.abc import Iterator, Mapping
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

    @property
    def entry_size(self) -> int:
        """How many entries one real or record takes of what the field stores."""
        size: int = self.kind.size if issubclass(self.kind, Record) else 1
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
            return Rows(record.entries, begin, self.kind, self.count(record))
        if issubclass(self.kind, Record):
            return self.kind(record.entries, begin)
        if isinstance(record.entries, list):
            return Reals(record.entries, begin)
        end = begin + self.count(record) if self.stored.factors or value == 0.0 else None
        return record.entries[begin:end]

    def __set__(self, record: "Record", value: float) -> None:
        """Change a number."""
        record.entries[record.offset + self.place] = float(value)

    def count(self, record: "Record") -> int:
        """Return how many reals or records are stored where the field says."""
        factors = () if self.stored is None else self.stored.factors
        count = int(bool(factors))
        for factor in factors:
            count *= getattr(record, factor) if isinstance(factor, str) else factor
        return count


class Record(Reals):
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

    __slots__ = ()
    fields: ClassVar[Mapping[str, Field]] = MappingProxyType({})
    size: ClassVar[int] = 0

    def __init__(self, entries: Any, offset: int = 0) -> None:
        self.entries, self.offset = entries, offset  # a NumPy array is seen through, not copied

    def __init_subclass__(cls) -> None:
        """Lay out the fields."""
        fields: dict[str, Field] = {}
        for name, annotation in inspect.get_annotations(cls).items():
            fields[name] = field = Field(name, annotation, cls.size, cls.__dict__.get(name))
            cls.size += field.size
            setattr(cls, name, field)
        cls.fields = MappingProxyType(fields)


class Rows(Generic[R]):
    """Records one after the other."""

    __slots__ = ("_begin", "_count", "_entries", "_kind")

    def __init__(self, entries: Any, begin: int, kind: type[R], count: int) -> None:
        self._entries, self._begin, self._kind, self._count = entries, begin, kind, count

    def __getitem__(self, k: int) -> R:
        return self._kind(self._entries, self._begin + self._kind.size * k)

    def __iter__(self) -> Iterator[R]:
        return map(self.__getitem__, range(self._count))


def exists(reals: Reals) -> bool:
    """Return whether a field stores anything: nothing that is stored begins at place 0 of the array."""
    return reals.offset != 0 if isinstance(reals, Reals) else len(reals) > 0
