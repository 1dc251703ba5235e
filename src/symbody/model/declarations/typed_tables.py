"""Lists of tables of several types, each of which says by its key `type` what its other keys are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from symbody.errors import nearest
from symbody.model.declarations.field import FileTable
from symbody.model.declarations.misfits import Misfit, Path, Schema, wrong_type

# What other programs, and books, call our types.
OTHER_NAMES: Final = MappingProxyType(
    {
        other: ours
        for ours, others in (
            ("revolute", "hinge pin pivot rotational continuous"),
            ("prismatic", "slider slide translational linear"),
            ("spherical", "ball"),
            ("weld", "fixed rigid"),
            ("free", "floating"),
            ("universal", "cardan hooke"),
            ("constant_velocity", "rzeppa"),
            ("screw", "helical"),
            ("pin_slot", "slot"),
            ("distance", "rod link"),
            ("point_on_curve", "cam"),
            ("rolling", "wheel disc"),
            ("knife_edge", "skate blade"),
        )
        for other in others.split()
    }
)
_USUAL_TYPES: Final = MappingProxyType(
    {"block": "pid", "constraint": "distance", "joint": "revolute", "shape": "box"}
)


def typed_list_schema(tables: Mapping[str, FileTable]) -> Schema:
    """Return the schema of a list of tables, by type where there are several."""
    if len(tables) == 1:
        return {"type": "array", "items": next(iter(tables.values())).reference}
    references = {word: table.reference for word, table in tables.items()}
    mapping = {word: reference["$ref"] for word, reference in references.items()}
    discriminator = {"mapping": mapping, "propertyName": "type"}
    items = {"discriminator": discriminator, "oneOf": list(references.values())}
    return {"type": "array", "items": items}


def typed_misfits(entry: object, path: Path, kind: str, tables: Mapping[str, FileTable]) -> Iterable[Misfit]:
    """Return the misfits of an entry by the table of its type, where there are several."""
    if "" in tables:
        return tables[""].misfits(entry, path)
    if not isinstance(entry, dict):
        return wrong_type(entry, path, "a table")
    if "type" not in entry:
        cure = f'add type = "{_USUAL_TYPES[kind]}", for instance'
        return (Misfit(path, "missing_key", "'type' is missing", "", cure),)
    word = entry["type"]
    table = tables.get(word) if isinstance(word, str) else None
    if table is not None:
        return table.misfits(entry, path)
    meant = OTHER_NAMES.get(str(word).lower(), "")
    cure = f"the key is called {meant!r}" if meant in tables else nearest(str(word), tables)
    return (Misfit(path, "unknown_type", f"there is no {kind} type {str(word)!r}", "", cure),)
