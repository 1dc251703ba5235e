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
        raise PydanticCustomError("newer", "a version known to this symbody")
    return value


# Ground has no name: it is the same in every model.
GroundEntry: Final = create_model(
    "GroundEntry",
    __base__=FileEntry,
    __doc__="The fixed frame.",
    frames=(TYPES[Frames], Field(default={}, description="Frames fixed to the ground.")),
    shape=(TYPES[Shapes], Field(default=[], description="Shapes to draw.")),
)
Version = Annotated[
    Any, PlainValidator(_version), WithJsonSchema({"type": "integer", "minimum": 1, "maximum": VERSION})
]
IncludeEntry: Final = create_model(
    "IncludeEntry",
    __base__=FileEntry,
    __doc__="A model file included as a part: its elements and symbols get names with a prefix.",
    file=(str, Field(description="Relative path of a model file in the folder of this file or below it.")),
    prefix=(str, Field(description='With "FL" the joint or parameter knee becomes FL_knee.')),
    at=(str, Field(default="ground", description="Frame that becomes the ground of the part.")),
    connect=(
        dict[str, Expression],
        Field(
            default={},
            description="Connects inputs of the part to symbols or formulas here, and its signals to new "
            "names.",
        ),
    ),
    share=(
        list[str],
        Field(default=[], description="Parameters and inputs of the part that keep their names."),
    ),
    parameters=(
        dict[str, Angle],
        Field(
            default={},
            description="New values for parameters of the part, as formulas in symbols of this model.",
        ),
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
        Field(default=[0, 0, 0], description="Acceleration of gravity in ground axes [m/s^2]."),
    ),
    inputs=(
        list[str],
        Field(default=[], description="Quantities given from outside during the motion."),
    ),
    parameters=(
        dict[str, Angle],
        Field(
            default={}, description='Values, or formulas in other parameters; "" where there is no value yet.'
        ),
    ),
    ground=(GroundEntry, Field(default_factory=GroundEntry)),
    **_LISTS,
    include=(
        list[_ENTRY],
        Field(default=[], description="Parts: included model files, each with its own prefix."),
    ),
    initial=(
        dict[str, FirstValue],
        Field(default={}, description="Initial values of coordinates and speeds."),
    ),
    layout=(
        dict[str, Any],
        Field(default={}, description="Layout of the diagram; it does not affect the mechanism."),
    ),
)


def schema_text() -> str:
    """Return the JSON Schema of the model file, as it stands in `schema.json`."""
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", **ModelFile.model_json_schema()}
    return json.dumps(schema, indent=2) + "\n"
