"""What the palette offers: every element that the schema of the model file describes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from symbody.formats.schema import ModelFile
from symbody.model.model import KINDS

# Kinds whose entries have types of their own, and what the palette calls the groups.
_GROUPS: Final[Mapping[str, str]] = {
    "body": "Bodies",
    "joint": "Joints",
    "constraint": "Constraints",
    "spring": "Springs and dampers",
    "torsion_spring": "Springs and dampers",
    "force": "Forces and torques",
    "torque": "Forces and torques",
}


def model_schema() -> dict[str, Any]:
    """Return the JSON schema of the model file."""
    return ModelFile.model_json_schema()


def palette() -> list[dict[str, str]]:
    """Return all elements: section, type, title, group, a sentence, and the name of their definition."""
    schema = model_schema()
    return [entry for kind in KINDS for entry in _entries(kind, schema)]


def _entries(kind: str, schema: Mapping[str, Any]) -> Iterator[dict[str, str]]:
    items = schema["properties"][kind]["items"]
    references: Mapping[str, str] = items.get("discriminator", {}).get("mapping") or {"": items["$ref"]}
    for word, reference in references.items():
        definition = reference.rpartition("/")[2]
        yield {
            "section": kind,
            "type": word,
            "title": (word or kind).replace("_", " ").capitalize(),
            "group": _GROUPS.get(kind, kind.capitalize()),
            "summary": schema["$defs"][definition].get("description", ""),
            "definition": definition,
        }
