"""The values of a model file as pydantic types: formulas, angles, axes; and `Entry`, a table."""

from __future__ import annotations

from decimal import Decimal
from typing import Annotated, Any, ClassVar, Final

from pydantic import BaseModel, ConfigDict, Field, Strict, WithJsonSchema
from pydantic.functional_validators import PlainValidator
from pydantic_core import PydanticCustomError


def _expression(value: object) -> str | int | float | Decimal:
    if isinstance(value, bool) or not isinstance(value, str | int | float | Decimal):
        raise PydanticCustomError("expression", "a number or an expression")
    if not isinstance(value, str) and not Decimal(value).is_finite():
        raise PydanticCustomError("not_finite", "a finite number")
    return value


def _factors(value: object) -> object:
    if isinstance(value, list) and len(value) == 3:
        return [_expression(item) for item in value]
    if isinstance(value, list | dict):
        raise PydanticCustomError("factors", "a number, or three")
    return _expression(value)


def _axis(value: object) -> object:
    if isinstance(value, str):
        return value
    if isinstance(value, list) and len(value) == 3:
        return [_expression(item) for item in value]
    raise PydanticCustomError("axis", '"x", "y", "z", or three components')


def _trees(value: object) -> object:
    if isinstance(value, bool):
        return value
    if isinstance(value, dict) and set(value) <= {"rotation", "translation"}:
        if all(isinstance(flag, bool) for flag in value.values()):
            return value
    raise PydanticCustomError("trees", "true, false, or { rotation = true, translation = false }")


def _law(value: object) -> object:
    return value if isinstance(value, dict) else _expression(value)


def _first_value(value: object) -> object:
    if not isinstance(value, dict):
        return _expression(value)
    if "value" not in value or not set(value) <= {"value", "priority"}:
        raise PydanticCustomError("first_value", 'a value, or { value = .., priority = "hold" }')
    if value.get("priority", "guess") not in ("guess", "hold"):
        raise PydanticCustomError("priority", 'priority "hold" or "guess"')
    return {**value, "value": _expression(value["value"])}


def _six(value: object) -> object:
    if not isinstance(value, list) or len(value) != 6:
        raise PydanticCustomError("six", "six numbers or expressions, or six rows of six")
    for row in value:
        if isinstance(row, list) and len(row) != 6:
            raise PydanticCustomError("six", "rows of six numbers or expressions")
        for item in row if isinstance(row, list) else [row]:
            _expression(item)
    return value


_TEXT_OR_NUMBER: Final = {"type": ["string", "number"]}
Expression = Annotated[
    Any,
    PlainValidator(_expression),
    WithJsonSchema({**_TEXT_OR_NUMBER, "description": "A number, or a formula in the names allowed there."}),
]
Angle = Annotated[
    Any,
    PlainValidator(_expression),
    WithJsonSchema({**_TEXT_OR_NUMBER, "description": 'An angle in rad, or a text such as "30 deg".'}),
]
FirstValue = Annotated[
    Any,
    PlainValidator(_first_value),
    WithJsonSchema(
        {
            "anyOf": [
                _TEXT_OR_NUMBER,
                {
                    "type": "object",
                    "properties": {
                        "value": _TEXT_OR_NUMBER,
                        "priority": {"enum": ["guess", "hold"], "default": "guess"},
                    },
                    "required": ["value"],
                    "additionalProperties": False,
                },
            ],
            "description": 'A value, or { value = .., priority = "hold" } if closing the loops must not '
            "change it.",
        }
    ),
]
Triple = Annotated[list[Expression], Field(min_length=3, max_length=3)]
Factors = Annotated[
    Any,
    PlainValidator(_factors),
    WithJsonSchema(
        {
            "anyOf": [
                _TEXT_OR_NUMBER,
                {"type": "array", "items": _TEXT_OR_NUMBER, "minItems": 3, "maxItems": 3},
            ]
        }
    ),
]
Axis = Annotated[
    Any,
    PlainValidator(_axis),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": ["x", "y", "z"]},
                {"type": "array", "items": _TEXT_OR_NUMBER, "minItems": 3, "maxItems": 3},
            ],
            "description": "A letter, or components of a vector of any length.",
        }
    ),
]
Law = Annotated[
    Any,
    PlainValidator(_law),
    WithJsonSchema(
        {
            "anyOf": [
                _TEXT_OR_NUMBER,
                {
                    "type": "object",
                    "properties": {
                        "x": {"type": "array", "items": _TEXT_OR_NUMBER, "minItems": 2},
                        "y": {"type": "array", "items": _TEXT_OR_NUMBER, "minItems": 2},
                        "kind": {"enum": ["linear", "pchip"]},
                        "outside": {"enum": ["hold", "slope"]},
                    },
                    "required": ["x", "y"],
                    "additionalProperties": False,
                },
            ],
            "description": "A formula, or a curve through points.",
        }
    ),
]
_SIX: Final = {"type": "array", "minItems": 6, "maxItems": 6}
Six = Annotated[
    Any,
    PlainValidator(_six),
    WithJsonSchema(
        {
            "anyOf": [
                {**_SIX, "items": _TEXT_OR_NUMBER},
                {**_SIX, "items": {**_SIX, "items": _TEXT_OR_NUMBER}},
            ],
            "description": "Six values along and about x, y, z, or a 6 x 6 matrix.",
        }
    ),
]
Trees = Annotated[
    Any,
    PlainValidator(_trees),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "boolean"},
                {
                    "type": "object",
                    "properties": {"rotation": {"type": "boolean"}, "translation": {"type": "boolean"}},
                    "additionalProperties": False,
                },
            ],
            "description": "Whether the joint is in the rotation tree and the translation tree; leave it "
            "out for automatic.",
        }
    ),
]
Turn = Annotated[tuple[Axis, Angle], Strict(False)]
Between = Annotated[list[str], Field(min_length=2, max_length=2, description="Start and end frame.")]


class FileEntry(BaseModel):
    """A table of the file: only the keys listed, no conversion of types."""

    model_config: ClassVar[ConfigDict] = ConfigDict(extra="forbid", strict=True, frozen=True)
