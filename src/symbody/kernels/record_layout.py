"""Records: arrays of reals whose entries have names.

A record is a class whose annotations are its fields, in the order of the array:

==================  ==============================================================================
``x: float``        a real
``k: int``          a whole number, kept as a real below 2^53
``m: Method``       another record, in line
``w: Reals``        ``= inline(20)``: so many reals, in line: the quickest to read
``v: Reals``        ``= pointer("count")``: so many reals elsewhere in the array; the field holds where
``p: Numbers``      ``= pointer()``: a record elsewhere in the array, or nothing where the field is 0
``e: Rows[Event]``  ``= pointer("events")``: so many records elsewhere, one after the other
==================  ==============================================================================

Places are counted from where the record begins. Files of records do not postpone annotations: Python, and the
reader of kernels, ask the class for its fields.
"""

import inspect
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Generic, NamedTuple, Self, TypeVar, get_args, get_origin

from symbody.kernels.language import Reals

R = TypeVar("R", bound="RecordLayout")


class Pointer(NamedTuple):
    """How much lies elsewhere in an array: the product of fields, by name, and numbers."""

    factors: tuple[str | int, ...]


def pointer(*factors: str | int) -> Any:
    """Declare that a field holds where its reals or records begin; its arguments multiply to their number."""
    return Pointer(factors)


class Inline(NamedTuple):
    """How many reals lie in line."""

    reals: int


def inline(reals: int) -> Any:
    """Declare that a field is so many reals."""
    return Inline(reals)


class RecordField:
    """One field of a record.

    Attributes
    ----------
    kind : type
        ``float``, ``int``, ``Reals`` or a class of records.
    place : int
        Where it lies, counted from the beginning of the record.
    pointer : Pointer or None
        None for what lies in line.
    sizes : tuple of str and int
        The factors of how much the field points to.
    inline : int
        How many reals lie in line where the field is an array that does.
    is_record, is_row : bool
        Whether it is a record or points to some, and whether to several.
    size, entry_size : int
        How many entries the field takes in line, and how many a real, or one of the records, takes.
    """

    __slots__ = (
        "entry_size", "inline", "is_record", "is_row", "kind", "name", "place", "pointer", "size", "sizes",
    )  # fmt: skip

    def __init__(self, name: str, annotation: Any, place: int, size: Pointer | Inline | None) -> None:
        self.name, self.place = name, place
        self.inline = size.reals if isinstance(size, Inline) else 0
        self.pointer = size if isinstance(size, Pointer) else None
        self.is_row = get_origin(annotation) is Rows
        self.kind: Any = get_args(annotation)[0] if self.is_row else annotation
        self.is_record = issubclass(self.kind, RecordLayout)
        self.sizes = () if self.pointer is None else self.pointer.factors
        self.entry_size: int = self.kind.size if self.is_record else 1
        self.size = self.inline or (self.entry_size if self.pointer is None else 1)

    def __get__(self, record: "RecordLayout | None", owner: type) -> Any:
        """Return the value of the field in a record; the field itself for the class."""
        if record is None:
            return self
        value = record.entries[record.offset + self.place]
        if self.inline:
            return self._reals(record, record.offset + self.place, self.inline)
        if self.pointer is None:
            if self.is_record:
                return self.kind(record.entries, record.offset + self.place)
            return self.kind(value)
        begin = record.offset + int(value) if value else 0
        if self.is_row:
            return Rows(record.entries, begin, self.kind, self.count(record))
        if self.is_record:
            return self.kind(record.entries, begin)
        return self._reals(record, begin, self.count(record) if self.sizes or value == 0.0 else None)

    def _reals(self, record: "RecordLayout", begin: int, size: int | None) -> Any:
        if isinstance(record.entries, list):
            return Reals(record.entries, begin)
        return record.entries[begin : None if size is None else begin + size]

    def __set__(self, record: "RecordLayout", value: float) -> None:
        """Change a number."""
        record.entries[record.offset + self.place] = float(value)

    def count(self, record: "RecordLayout") -> int:
        """Return how many reals or records the field points to."""
        count = int(bool(self.sizes))
        for factor in self.sizes:
            count *= getattr(record, factor) if isinstance(factor, str) else factor
        return count


class RecordLayout(Reals):
    """An array of reals whose entries have names.

    Attributes
    ----------
    entries : list or array
        All of the array.
    offset : int
        Where the record begins in it.
    fields : mapping of name to RecordField
    pointers : tuple of RecordField
        Those of them that say where something lies.
    layout : mapping of name to int
        Where each number and pointer lies, those of records in line by names such as ``counts.steps``.
    stores : tuple of int
        Places of all pointers, those of records in line among them.
    size : int
        How many entries the fields take.
    alignment : int
        What lies elsewhere begins at a multiple of so many entries.
    """

    __slots__ = ()
    fields: ClassVar[Mapping[str, RecordField]] = MappingProxyType({})
    pointers: ClassVar[tuple[RecordField, ...]] = ()
    layout: ClassVar[Mapping[str, int]] = MappingProxyType({})
    stores: ClassVar[tuple[int, ...]] = ()
    size: ClassVar[int] = 0
    alignment: ClassVar[int] = 1

    def __init__(self, entries: Any, offset: int = 0) -> None:
        self.entries, self.offset = entries, offset  # a NumPy array is seen through, not copied

    @property
    def array(self) -> Any:
        """The array from the beginning of the record on: a view."""
        return self.entries[self.offset :]

    def __array__(self, *_: object, **__: object) -> Any:
        """Refuse a copy where a view was meant."""
        raise TypeError(f"{type(self).__name__} is a record: take its array")

    def __init_subclass__(cls) -> None:
        """Lay out the fields."""
        fields: dict[str, RecordField] = {}
        layout: dict[str, int] = {}
        for name, annotation in inspect.get_annotations(cls).items():
            fields[name] = field = RecordField(name, annotation, cls.size, cls.__dict__.get(name))
            inner = field.kind.layout if field.is_record and field.pointer is None else {"": 0}
            layout |= {f"{name}.{key}".rstrip("."): cls.size + place for key, place in inner.items()}
            if field.pointer is not None:
                cls.stores += (cls.size,)
            elif field.is_record:
                cls.stores += tuple(cls.size + place for place in field.kind.stores)
            cls.size += field.size
            setattr(cls, name, field)
        cls.fields, cls.layout = MappingProxyType(fields), MappingProxyType(layout)
        cls.pointers = tuple(field for field in fields.values() if field.pointer is not None)

    @classmethod
    def round_up(cls, place: int) -> int:
        """Return a place, or the next one where something may begin."""
        return place if cls.alignment == 1 else -(-place // cls.alignment) * cls.alignment

    @classmethod
    def view(cls, array: Reals, place: int) -> Self:
        """Return the record that begins at a place of an array."""
        return cls(array.entries, array.offset + place)


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
    """Return whether a field points to anything: it never points to place 0 of the array."""
    return reals.offset != 0 if isinstance(reals, Reals) else len(reals) > 0
