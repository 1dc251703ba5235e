"""Numbers and arrays as JSON says them: what is not finite is null, long arrays are base64."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def finite(value: float) -> float | None:
    """Return a number, None if it is not finite."""
    number = float(value)
    return number if math.isfinite(number) else None


def finite_values(values: Mapping[str, float]) -> dict[str, float | None]:
    """Return numbers by name."""
    return {name: finite(value) for name, value in values.items()}


def encoded(values: ArrayLike, kind: str = "<f4") -> str:
    """Return an array as the page decodes it: base64 of single precision, little-endian."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def curve(name: str, unit: str, values: ArrayLike) -> dict[str, Any]:
    """Return a curve as motions hold it."""
    return {"name": name, "unit": unit, "values": encoded(values)}
