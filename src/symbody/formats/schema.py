"""The structure of the model file: its sections and their roles, from which `schema.json` is made."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from typing import Any, Final, cast

from symbody.errors import FormatError, Problem
from symbody.formats.places import Locate, words
from symbody.model.body import GROUND_FRAMES
from symbody.model.declarations.combinators import ByName, list_of
from symbody.model.declarations.field import REQUIRED, FileRole, FileTable, typed_list_schema, typed_misfits
from symbody.model.declarations.fields import AngleQuantity, Quantity, Text, VectorQuantity
from symbody.model.declarations.misfits import (
    FORMULA_SCHEMA,
    Misfit,
    Path,
    Schema,
    formula_misfits,
    list_misfits,
    mapping_misfits,
    short_text,
    wrong_type,
)
from symbody.model.model import KINDS
from symbody.model.registry import ElementTables
from symbody.model.shapes.shape import GROUND_SHAPES

VERSION: Final = 2
# What version 2 brought; a file without any of them is written without a version, as those of version 1.
NEWER_SECTIONS: Final = ("contact", "table", "signal", "block", "include")


NEWER: Final = "newer_version"
_PRIORITIES: Final = ("guess", "hold")


class Version(FileRole):
    """The version of the file format."""

    def schema(self) -> Schema:
        """Return an integer up to the version of this package."""
        return {"type": "integer", "minimum": 1, "maximum": VERSION}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a version, or from being one that is known."""
        if isinstance(entry, bool) or not isinstance(entry, int) or entry < 1:
            return wrong_type(entry, path, "a whole number")
        if entry <= VERSION:
            return ()
        what = f"the file was made by a newer version of symbody: it has version {short_text(entry)}"
        why = f"this version of symbody reads versions up to {VERSION}"
        return (Misfit(path, NEWER, what, why, "update symbody"),)


class FirstValue(FileRole):
    """A value, or one with its priority."""

    def schema(self) -> Schema:
        """Return a formula or a table."""
        table = {
            "type": "object",
            "properties": {
                "value": FORMULA_SCHEMA,
                "priority": {"enum": [*_PRIORITIES], "default": _PRIORITIES[0]},
            },
            "required": ["value"],
            "additionalProperties": False,
        }
        text = 'A value, or { value = .., priority = "hold" } if closing the loops must not change it.'
        return {"anyOf": [FORMULA_SCHEMA, table], "description": text}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being either."""
        if not isinstance(entry, dict):
            return formula_misfits(entry, path)
        if "value" not in entry or not set(entry) <= {"value", "priority"}:
            return wrong_type(entry, path, 'a value, or { value = .., priority = "hold" }')
        if entry.get("priority", _PRIORITIES[0]) not in _PRIORITIES:
            return wrong_type(entry, path, 'priority "hold" or "guess"')
        return formula_misfits(entry["value"], path)


class DiagramLayout(FileRole):
    """What editors of diagrams write for themselves."""

    def schema(self) -> Schema:
        """Return any table."""
        return {"type": "object", "additionalProperties": True}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return what keeps it from being a table."""
        return mapping_misfits(entry, path, lambda value, place: ())


@dataclass(frozen=True, eq=False, repr=False)
class Section(FileRole):
    """A table of its own."""

    _: KW_ONLY
    default: Any = None
    table: FileTable | None = None

    def schema(self) -> Schema:
        """Return the name of the table."""
        return self._table.reference

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the table."""
        return self._table.misfits(entry, path)

    def tables(self) -> Iterable[FileTable]:
        """Return the table."""
        return (self._table,)

    @property
    def file_default(self) -> object:
        """Nothing: the keys of the table have their defaults."""
        return REQUIRED

    @property
    def _table(self) -> FileTable:
        assert self.table is not None
        return self.table


@dataclass(frozen=True, eq=False, repr=False)
class Entries(FileRole):
    """A list of tables of one kind, by their types where there are several.

    Attributes
    ----------
    choices : mapping of type to FileTable
        Under "" where there is one.
    """

    _: KW_ONLY
    default: Any = ()
    kind: str = ""
    choices: Mapping[str, FileTable] | None = None

    def schema(self) -> Schema:
        """Return a list of tables."""
        return typed_list_schema(self.choices or {})

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of each table."""
        example = f"[[{self.kind}]] instead of [{self.kind}]" if isinstance(entry, Mapping) else ""
        choices = self.choices or {}
        return list_misfits(
            entry, path, lambda item, at: typed_misfits(item, at, self.kind, choices), example=example
        )

    def tables(self) -> Iterable[FileTable]:
        """Return all tables."""
        return (self.choices or {}).values()


_GROUND: Final = FileTable(
    "GroundEntry", "The fixed frame.", {"frames": GROUND_FRAMES, "shape": GROUND_SHAPES}
)
_INCLUDE: Final = FileTable(
    "IncludeEntry",
    "A model file included as a part: its elements and symbols get names with a prefix.",
    {
        "file": Text("Relative path of a model file in the folder of this file or below it."),
        "prefix": Text('With "FL" the joint or parameter knee becomes FL_knee.'),
        "at": Text("Frame that becomes the ground of the part.", default="ground"),
        "connect": ByName(
            "Connects inputs of the part to symbols or formulas here, and its signals to new names.",
            default=None,
            item=Quantity(),
        ),
        "share": list_of(Text("Parameters and inputs of the part that keep their names."), default=()),
        "parameters": ByName(
            "New values for parameters of the part, as formulas in symbols of this model.",
            default=None,
            item=AngleQuantity(),
        ),
    },
)


@cache
def model_table() -> FileTable:
    """Return the table that a whole file is."""
    return FileTable(
        "ModelFile",
        "A mechanism. SI units, radians.",
        {
            "version": Version("Version of the file format.", default=1),
            "name": Text("Title."),
            "gravity": VectorQuantity(
                "Acceleration of gravity in ground axes.", unit="m/s^2", default=(0, 0, 0),
                example='gravity = ["0", "-9.81", "0"]',
            ),
            "inputs": list_of(
                Text("Quantities given from outside during the motion.", example='inputs = ["F"]'), default=()
            ),
            "parameters": ByName(
                'Values, or formulas in other parameters; "" where there is no value yet.', default=None,
                item=AngleQuantity(),
            ),
            "ground": Section(table=_GROUND),
            **{kind: Entries(kind=kind, choices=ElementTables(kind)) for kind in KINDS},
            "include": Entries(
                "Parts: included model files, each with its own prefix.",
                kind="include",
                choices={"": _INCLUDE},
            ),
            "initial": ByName("Initial values of coordinates and speeds.", default=None, item=FirstValue()),
            "layout": DiagramLayout("Layout of the diagram; it does not affect the mechanism.", default={}),
        },
    )  # fmt: skip


def file_schema() -> dict[str, Any]:
    """Return the JSON Schema of the model file."""
    whole = model_table()
    tables = {table.title: table for table in _tables_below(whole)}
    schema = {"$defs": {title: tables[title].schema() for title in sorted(tables)}, **whole.schema()}
    own = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:symbody:model-file:{VERSION}",
    }
    return {**own, **_sort_keys(schema)}


def schema_text() -> str:
    """Return the JSON Schema of the model file, as it stands in `schema.json`."""
    return json.dumps(file_schema(), indent=2) + "\n"


def _tables_below(table: FileTable) -> Iterable[FileTable]:
    for role in table.fields.values():
        for inner in role.tables():
            yield inner
            yield from _tables_below(inner)


def _sort_keys(node: Any, is_sorted: bool = True) -> Any:
    """Return a schema with its keys in order, those of the properties in the order of the constructors."""
    if isinstance(node, list):
        return [_sort_keys(item) for item in node]
    if not isinstance(node, Mapping):
        return node
    keys = sorted(node) if is_sorted else list(node)
    return {key: _sort_keys(node[key], key not in ("properties", "default")) for key in keys}


_MAX_PROBLEMS: Final = 50


def check_structure(data: object, locate: Locate) -> Mapping[str, Any]:
    """Return `data` if its keys and types are those of the roles; a FormatError has all that do not fit."""
    misfits = list(model_table().misfits(data, ()))
    if not misfits:
        return cast("Mapping[str, Any]", data)
    newer = [misfit for misfit in misfits if misfit.code == NEWER]
    problems = [_problem(misfit, data, locate) for misfit in (newer or misfits)[:_MAX_PROBLEMS]]
    if len(misfits) > len(problems) and not newer:
        rest = f"{len(misfits) - len(problems)} more problems are not shown"
        problems.append(Problem("file.more", locate(()), rest, "", "fix the ones above first"))
    raise FormatError(*problems)


def _problem(misfit: Misfit, data: object, locate: Locate) -> Problem:
    path = misfit.path
    inner = words(path[2:] if _is_inside(path) else path)
    shown = ", ".join(part for part in (locate(path), _element(path, data), inner) if part)
    return Problem(f"file.{misfit.code}", shown, misfit.what, misfit.why, misfit.fix)


def _element(path: Path, data: object) -> str:
    """Return the label of the element in which a path lies, as the model writes it."""
    if not _is_inside(path):
        return ""
    entries = data.get(path[0]) if isinstance(data, Mapping) else None
    entry = entries[int(path[1])] if isinstance(entries, list) else None
    name = entry.get("name") if isinstance(entry, Mapping) else None
    return f"{path[0]} {name}" if isinstance(name, str) else f"{path[0]} {int(path[1]) + 1}"


def _is_inside(path: Path) -> bool:
    return len(path) >= 2 and isinstance(path[1], int) and path[0] in KINDS
