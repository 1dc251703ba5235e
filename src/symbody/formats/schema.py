"""The structure of the model file as pydantic classes; `schema.json` beside this file is made from them.

They check keys and types. What the values mean is checked by the Model.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any, Final

from pydantic import Field, WithJsonSchema, create_model
from pydantic.functional_validators import PlainValidator
from pydantic_core import PydanticCustomError

from symbody.formats.schema_entries import TYPES, entry_list_type
from symbody.formats.schema_types import Angle, Expression, FileEntry, FirstValue, Triple
from symbody.formats.version import VERSION
from symbody.model.body import Frames
from symbody.model.model import KINDS
from symbody.model.shapes.shape import Shapes


def _version(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise PydanticCustomError("version", "a whole number")
    if value > VERSION:
        raise PydanticCustomError("newer", "a version this symbody knows")
    return value


# Ground has no name: it is the same in every model.
GroundEntry: Final = create_model(
    "GroundEntry",
    __base__=FileEntry,
    __doc__="What is fixed.",
    frames=(TYPES[Frames], Field(default={}, description="Frames fixed on the ground.")),
    shape=(TYPES[Shapes], Field(default=[], description="What is seen of it.")),
)
Version = Annotated[
    Any, PlainValidator(_version), WithJsonSchema({"type": "integer", "minimum": 1, "maximum": VERSION})
]
IncludeEntry: Final = create_model(
    "IncludeEntry",
    __base__=FileEntry,
    __doc__="A model file as a part: its elements and symbols under names with a prefix.",
    file=(str, Field(description="Model file in the folder of this one or below it, by its relative path.")),
    prefix=(str, Field(description='"FL" makes FL_knee of the joint or parameter knee.')),
    at=(str, Field(default="ground", description="Frame that is the ground of the part.")),
    connect=(
        dict[str, Expression],
        Field(
            default={},
            description="Inputs of the part to symbols or formulas here; its signals to the names they get.",
        ),
    ),
    share=(
        list[str],
        Field(default=[], description="Parameters and inputs of the part that keep their names."),
    ),
    parameters=(
        dict[str, Angle],
        Field(default={}, description="In place of the part's values, in symbols of this model."),
    ),
)
_ENTRY: Final[Any] = IncludeEntry
_LISTS: Final[Mapping[str, Any]] = {kind: (entry_list_type(kind), []) for kind in KINDS}
ModelFile: Final = create_model(
    "ModelFile",
    __base__=FileEntry,
    __doc__="A mechanism. SI units, radians.",
    version=(Version, Field(default=1, description="Version of the file format.")),
    name=(str, Field(description="Title.")),
    gravity=(
        Triple,
        Field(default=[0, 0, 0], description="Acceleration of free fall in ground axes [m/s^2]."),
    ),
    inputs=(
        list[str],
        Field(default=[], description="Quantities given from outside while it moves."),
    ),
    parameters=(
        dict[str, Angle],
        Field(
            default={}, description='Values, or formulas of other parameters; "" where there is no value yet.'
        ),
    ),
    ground=(GroundEntry, Field(default_factory=GroundEntry)),
    **_LISTS,
    include=(
        list[_ENTRY],
        Field(default=[], description="Parts: model files, once or several times, under prefixes."),
    ),
    initial=(
        dict[str, FirstValue],
        Field(default={}, description="Initial values of coordinates and speeds."),
    ),
    layout=(
        dict[str, Any],
        Field(default={}, description="The diagram; of no meaning to the mechanism."),
    ),
)


def schema_text() -> str:
    """Return the JSON Schema of the model file, as it stands in `schema.json`."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ModelFile.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"
