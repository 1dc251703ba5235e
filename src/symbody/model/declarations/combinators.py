"""Roles made of roles: what may be left out, lists, and tables by name or by coordinate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Generic, TypeVar

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.field import (
    REQUIRED,
    Field,
    FileTable,
    FileTarget,
    Given,
    Kept,
    NewNames,
    Node,
)
from symbody.model.declarations.misfits import Misfit, Path, Schema, list_misfits, mapping_misfits
from symbody.model.frozen_mapping import FrozenMapping

G = TypeVar("G")
K = TypeVar("K")


@dataclass(frozen=True, eq=False, repr=False)
class OptionalField(Field[Given | None, Kept | None], Generic[Given, Kept]):
    """A value of another role that may be left out.

    Attributes
    ----------
    inner : Field
        The role.
    """

    role: ClassVar[str]

    _: KW_ONLY
    default: Any = None
    inner: Any = None

    def __post_init__(self) -> None:
        """Take over the words of the role."""
        words = {
            "role": self.inner.role,
            "takes": self.inner.takes,
            "annotation": f"{self.inner.annotation} | None",
            "explanation": self.inner.explanation,
        }
        for name, word in words.items():
            object.__setattr__(self, name, word)

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> Kept | None:
        """Return the value, or None for None."""
        return None if value is None else self._inner().read(owner, arguments, value, path)

    def schema(self) -> Schema:
        """Return the schema of the role."""
        return self._inner().schema()

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of a value."""
        return self._inner().misfits(entry, path)

    def tables(self) -> Iterable[FileTable]:
        """Return the tables of the role."""
        return self._inner().tables()

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the argument, or None."""
        return None if entry is None else self._inner().from_file(entry, arguments, path, folder)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the value as a file has it."""
        return None if value is None else self._inner().to_file(owner, value, target)

    def rename(self, value: Any, names: NewNames) -> Kept | None:
        """Return the value in the new names."""
        return None if value is None else self._inner().rename(value, names)

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the value as one of the role."""
        return () if value is None else ((self.inner, value, path),)

    @property
    def fits(self) -> Any:
        """The check of numbers that the role has, or None."""
        return getattr(self.inner, "fits", None)

    def _inner(self) -> Field[Given, Kept]:
        inner: Field[Given, Kept] = self.inner
        return inner


def optional(role: Field[G, K], *, is_nullable: bool = False) -> OptionalField[G, K]:
    """Return a role whose value may be left out, None in Python."""
    return OptionalField(role.sentence, unit=role.unit, place=role.place, inner=role, is_nullable=is_nullable)


@dataclass(frozen=True, eq=False, repr=False)
class ListOf(Field[Given, Kept]):
    """A list of values of one role.

    Attributes
    ----------
    item : Field
        The role.
    count : int or None
        How many there are; None: any number.
    nouns, why, fix : str
        What a list of another length is told: what its items are, why there are so many, and what helps.
    instead : tuple
        Read in the place of a list of another length.
    """

    _: KW_ONLY
    item: Any = None
    count: int | None = None
    nouns: str = "values"
    why: str = ""
    fix: str = ""
    instead: tuple[object, ...] = ()

    def items(self, arguments: Arguments, value: object, path: str) -> Iterable[object]:
        """Return what is in the list, which is read one by one."""
        if self.count is None:
            return arguments.items(value, path)
        count = len(arguments.problems)
        items = arguments.items(value, path)
        if len(items) == self.count:
            return items
        if len(arguments.problems) == count:
            noun = self.nouns if len(items) != 1 else self.nouns.removesuffix("s")
            what = f"{len(items)} {noun} instead of {self.count}"
            arguments.add("model.wrong_number", path, what, self.why, self.fix)
        return self.instead

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> Kept:
        """Return what is kept of the items."""
        items = enumerate(self.items(arguments, value, path))
        kept: Any = tuple(self.item.read(owner, arguments, item, f"{path}[{k}]") for k, item in items)
        same: Kept = kept
        return same

    def schema(self) -> Schema:
        """Return an array of the items' schema."""
        schema: Schema = {"type": "array", "items": self.item.schema()}
        return schema if self.count is None else {**schema, "minItems": self.count, "maxItems": self.count}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the list, or of its items."""
        return list_misfits(entry, path, self.item.misfits, self.count, self.example)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the list of the items as a file has them."""
        return [self.item.to_file(owner, item, target) for item in value]

    def rename(self, value: Any, names: NewNames) -> Kept:
        """Return the items in the new names."""
        kept: Any = tuple(self.item.rename(item, names) for item in value)
        same: Kept = kept
        return same

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the items."""
        return ((self.item, item, f"{path}[{k}]") for k, item in enumerate(value))


def list_of(
    role: Field[G, K],
    count: int | None = None,
    *,
    default: Any = ...,
    nouns: str = "values",
    why: str = "",
    fix: str = "",
    instead: tuple[object, ...] = (),
) -> ListOf[Iterable[G], tuple[K, ...]]:
    """Return the role of a list of values of a role; `ListOf` says what its arguments are.

    Without a default it takes that of the role.
    """
    made: ListOf[Iterable[G], tuple[K, ...]] = ListOf(
        role.sentence, default=role.default if default is ... else default, unit=role.unit, item=role,
        example=role.example, count=count, nouns=nouns, why=why, fix=fix, instead=instead,
    )  # fmt: skip
    length = "n" if count is None else str(count)
    outer, _, inner = role.takes.rpartition(") ")
    words = {
        "role": f"{role.role}s",
        "takes": f"({length}, {outer[1:].rstrip(',')}) {inner}" if outer else f"({length},) {inner}",
        "annotation": f"Iterable[{role.annotation}]",
    }
    for name, word in words.items():
        object.__setattr__(made, name, word)
    return made


@dataclass(frozen=True, eq=False, repr=False)
class ByName(Field[G, FrozenMapping[K]], Generic[G, K]):
    """Values of one role by names.

    Attributes
    ----------
    item : Field
        The role.
    """

    _: KW_ONLY
    item: Any = None

    @property
    def file_default(self) -> object:
        """An empty table, unless there is no default."""
        return REQUIRED if self.is_required else {}

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> FrozenMapping[K]:
        """Return what is kept of the values."""
        entries = {} if value is None else value
        return arguments.table(entries, path, lambda item, at: self._item().read(owner, arguments, item, at))

    def schema(self) -> Schema:
        """Return an object with the schema of the values."""
        return {"type": "object", "additionalProperties": self._item().schema()}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the table, or of its values."""
        return mapping_misfits(entry, path, self._item().misfits)

    def tables(self) -> Iterable[FileTable]:
        """Return the tables of the role."""
        return self._item().tables()

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the arguments by name."""
        if not isinstance(entry, Mapping):
            return entry
        return {
            name: self._item().from_file(item, arguments, f"{path}.{name}", folder)
            for name, item in entry.items()
        }

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the table of the values as a file has them."""
        return {name: self.item.to_file(owner, item, target) for name, item in value.items()}

    def rename(self, value: Any, names: NewNames) -> FrozenMapping[K]:
        """Return the values in the new names."""
        return FrozenMapping({name: self._item().rename(item, names) for name, item in value.items()})

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the values."""
        return ((self.item, item, f"{path}.{name}") for name, item in value.items())

    def _item(self) -> Field[Any, K]:
        item: Field[Any, K] = self.item
        return item


@dataclass(frozen=True, eq=False, repr=False)
class ByCoordinate(ByName[G, K], Generic[G, K]):
    """Values of one role by the coordinates of a joint."""

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> FrozenMapping[K]:
        """Return the values by coordinate; a joint with one takes its value without name."""
        names = owner.coordinates
        if len(names) == 1:
            if isinstance(value, FrozenMapping):  # of a joint that is copied, perhaps with another coordinate
                value = next(iter(value.values()), None)
            value = {} if value is None else {names[0]: value}
        if value is None:
            return FrozenMapping()
        if not isinstance(value, Mapping):
            what = f"{value!r} needs the coordinate that it belongs to"
            why = f"the joint has {len(names)} coordinates: {', '.join(names)}"
            fix = f"write {{ {names[-1]} = .. }}, in Python {{{names[-1]!r}: ..}}"
            arguments.add("model.not_by_coordinate", path, what, why, fix)
            return FrozenMapping()
        items = {str(key): item for key, item in value.items() if item is not None}
        return FrozenMapping(
            {key: self.item.read(owner, arguments, item, owner.coordinate_path(path, key))
             for key, item in items.items()}
        )  # fmt: skip

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the only value where the joint has one coordinate, else all by coordinate."""
        if len(owner.coordinates) > 1:
            return ByName.to_file(self, owner, value, target)
        alone: Node | None = self.item.to_file(owner, next(iter(value.values())), target)
        return alone

    def rename(self, value: Any, names: NewNames) -> FrozenMapping[K]:
        """Return the values in the new names, under those of the coordinates."""
        return FrozenMapping({names.symbol(k): self.item.rename(item, names) for k, item in value.items()})

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the values."""
        return ((self.item, item, owner.coordinate_path(path, name)) for name, item in value.items())


class AlongCoordinate(ByCoordinate[G, K]):
    """The value of a role for the only coordinate of a joint."""

    @property
    def file_default(self) -> object:
        """The default: a file has the value without the name of the coordinate."""
        return self.default

    def schema(self) -> Schema:
        """Return the schema of the value."""
        return self._item().schema()

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the value."""
        return self._item().misfits(entry, path)

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the value."""
        return self._item().from_file(entry, arguments, path, folder)
