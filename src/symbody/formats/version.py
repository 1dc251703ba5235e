"""The version of model files, and what each version brought."""

from __future__ import annotations

from typing import Final

VERSION: Final = 2
# What version 2 brought; a file without any of them is written without a version, as those of version 1.
NEWER_SECTIONS: Final = ("table", "signal", "block", "include")
