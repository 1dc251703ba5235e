"""Numbers and arrays as JSON says them: what is not finite is null, long arrays are base64."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from numpy.typing import ArrayLike

from symbody.visual.scene.json_form import encode_array


def finite(value: float) -> float | None:
    """Return a number, None if it is not finite."""
    number = float(value)
    return number if math.isfinite(number) else None


def finite_values(values: Mapping[str, float]) -> dict[str, float | None]:
    """Return numbers by name."""
    return {name: finite(value) for name, value in values.items()}


def curve(name: str, unit: str, values: ArrayLike) -> dict[str, Any]:
    """Return a curve as motions hold it."""
    return {"name": name, "unit": unit, "values": encode_array(values)}
