"""Versions of the standard: which files each needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

Version = Literal["2.0", "3.0"]

# The file of C that includes all others.
MAIN: Final[Mapping[str, str]] = {"2.0": "fmi2.c", "3.0": "fmi3.c"}
CORE: Final = (
    "motion.h",
    "conditions.h",
    "results.h",
    "modes.h",
    "events.h",
    "samples.h",
    "steps.h",
    "instance.h",
)
HEADERS: Final[Mapping[str, tuple[str, ...]]] = {
    "2.0": ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
