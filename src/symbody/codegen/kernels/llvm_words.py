"""Types and instructions of LLVM for kernels."""

from __future__ import annotations

from typing import Final

REAL: Final = {"+": "fadd", "-": "fsub", "*": "fmul", "/": "fdiv"}
INTEGER: Final = {"+": "add nsw", "-": "sub nsw", "*": "mul nsw"}
# Comparisons with NaN are false, but "not equal" is true.
REAL_TESTS: Final = {"<": "olt", "<=": "ole", ">": "ogt", ">=": "oge", "==": "oeq", "!=": "une"}
INTEGER_TESTS: Final = {"<": "slt", "<=": "sle", ">": "sgt", ">=": "sge", "==": "eq", "!=": "ne"}


def real_type(width: int) -> str:
    """Return the type of a real, or of several side by side."""
    return "double" if width == 1 else f"<{width} x double>"


def intrinsic_name(word: str, real: str) -> str:
    """Return the name of a function of LLVM for a type of reals."""
    return f"llvm.{word}.f64" if real == "double" else f"llvm.{word}.v{width_of(real)}f64"


def width_of(kind: str) -> int:
    """Return how many entries a value of a type has."""
    return int(kind[1:].partition(" ")[0]) if kind.startswith("<") else 1
