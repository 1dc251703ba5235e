"""The role of an argument that is a part of its own: a frame, a drive, friction."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.declaration import ElementPart, file_table
from symbody.model.declarations.field import Field, FileTable, FileTarget, NewNames, Node
from symbody.model.declarations.formula_site import FormulaSite
from symbody.model.declarations.misfits import Misfit, Path, Schema
from symbody.model.numeric_checks import NumericChecks

P = TypeVar("P", bound=ElementPart)


class Refusal(NamedTuple):
    """A fault; `what` contains ``{value}`` where the value is shown."""

    code: str
    what: str = ""
    fix: str = ""


@dataclass(frozen=True, eq=False, repr=False)
class DeclaredPart(Field[P, P], Generic[P]):
    """A part of an element, which is a table of its own in a file.

    Attributes
    ----------
    kind : type
        Its class.
    refusal : Refusal
        The fault of something else in its place.
    """

    role: ClassVar[str] = "part"
    takes: ClassVar[str]
    annotation: ClassVar[str]

    _: KW_ONLY
    kind: Any = None
    refusal: Refusal = Refusal("")

    def __post_init__(self) -> None:
        """Take over the name of the class."""
        for word in ("takes", "annotation"):
            object.__setattr__(self, word, self.kind.__name__)

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> P:
        """Return the part; an empty one stands for something else."""
        if not isinstance(value, self.kind):
            code, what, fix = self.refusal
            arguments.add(code, path, what.format(value=repr(value)), "", fix)
        part: P = value if isinstance(value, self.kind) else self.kind()
        return part

    def schema(self) -> Schema:
        """Return the name of its table."""
        return self._table.reference

    def tables(self) -> Iterable[FileTable]:
        """Return its table."""
        return (self._table,)

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the table."""
        return self._table.misfits(entry, path)

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the part that a table describes; an empty one for a table with faults."""
        return read_part(self.kind, entry, arguments, path, folder) or self.kind()

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return its table."""
        entry: dict[str, Node] = value.to_entry(target)
        return entry

    def rename(self, value: Any, names: NewNames) -> P:
        """Return the part in the new names."""
        part: P = value.rename(names)
        return part

    def formula_sites(self, owner: Any, value: Any, path: str) -> Iterator[FormulaSite]:
        """Return where its formulas stand."""
        sites: Iterator[FormulaSite] = value.formula_sites(path)
        return sites

    def check_numbers(self, check: NumericChecks, owner: Any, value: Any, where: str) -> None:
        """Note its numbers that cannot be."""
        value.check_numbers(check, where)

    @property
    def _table(self) -> FileTable:
        return file_table(self.kind, f"{self.kind.__name__}Entry")


def read_part(kind: type[P], entry: object, arguments: Arguments, path: str, folder: str) -> P | None:
    """Return the part that a table describes; its faults are placed below `path`, with None for them."""
    if not isinstance(entry, Mapping):
        return None
    inner = Arguments("")
    made = inner.attempt(lambda: kind.from_entry(entry, "", folder))
    for problem in inner.problems:
        rest = problem.where.partition(", ")[2]
        place = f"{path}.{rest}" if rest else path
        arguments.add(problem.code, place, problem.what, problem.why, problem.fix)
    return made
