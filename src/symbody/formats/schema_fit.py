"""Whether data have the structure of a model file, by the published schema.

Nearly all data do. What is wrong with others, if anything is, pydantic finds out: it takes longer to load
than most models take to be read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from decimal import Decimal
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, cast

import jsonschema_rs

from symbody.formats.places import Locate


def check_structure(data: object, locate: Locate) -> Mapping[str, Any]:
    """Return `data`, which has only known keys, all that are needed, and values of the right types.

    Raises
    ------
    FormatError
        With every key and value that does not fit.
    """
    if not fits_schema(data):
        judge: Callable[[object, Locate], None] = import_module("symbody.formats.checking").refuse_misfits
        judge(data, locate)
    return cast("Mapping[str, Any]", data)


def fits_schema(data: object) -> bool:
    """Return whether data fit the JSON Schema beside this file; False where that is in doubt."""
    try:
        return _validator().is_valid(_json_data(data))
    except (ValueError, RecursionError):  # a date, NaN, half a character, a key that is no text
        return False


@cache
def _validator() -> jsonschema_rs.Draft202012Validator:
    text = Path(__file__).with_name("schema.json").read_text(encoding="utf-8")
    return jsonschema_rs.Draft202012Validator(text)


def _json_data(data: object) -> object:
    """Return data whose floats are no integers: JSON Schema takes 2.0 for one, a model file does not."""
    if isinstance(data, dict):
        return {_json_data(key): _json_data(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_json_data(value) for value in data]
    if isinstance(data, float | Decimal):
        return math.nextafter(_finite(data), math.inf)
    if isinstance(data, str):
        data.encode()  # refuses half a character
    return data


def _finite(number: float | Decimal) -> float:
    if math.isfinite(number):
        return float(number)
    raise ValueError(number)
