"""What the palette offers: every element, and the schema of the model file from which forms are made."""

from __future__ import annotations

from typing import Any

from symbody.formats.schema import ModelFile
from symbody.model import elements


def model_schema() -> dict[str, Any]:
    """Return the JSON schema of the model file."""
    return ModelFile.model_json_schema()


def palette() -> list[dict[str, Any]]:
    """Return all elements as the editor shows them."""
    return elements()
