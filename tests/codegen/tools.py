"""Compilers and interpreters that tests use where they are installed and run."""

from __future__ import annotations

import shutil
import subprocess
from functools import lru_cache


@lru_cache
def runnable(tool: str) -> str | None:
    """Return the path of a program that prints its version, or None: rustup's rustc may have no toolchain."""
    path = shutil.which(tool)
    if path is None:
        return None
    run = subprocess.run([path, "--version"], capture_output=True, check=False)
    return path if run.returncode == 0 else None
