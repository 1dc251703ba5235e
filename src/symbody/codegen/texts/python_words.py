"""What the texts for CasADi and JAX have in common: both are Python."""

from __future__ import annotations

from collections.abc import Sequence as Items

from symbody.codegen.texts.lists import fill_lines


def number(value: float) -> str:
    """Return a double as it is written."""
    text = repr(value)  # the shortest that reads back as the same double
    return f"({text})" if text.startswith("-") else text


def entry(array: str, k: int) -> str:
    """Return an entry of an argument."""
    return "t" if array == "t" else f"{array}[{k}]"


def kernel(name: str, n: int, m: int, operands: Items[str]) -> list[str]:
    """Return the lines that call the kernel for n accelerations and m rows."""
    return [f"    {name} = _solve_saddle({n}, {m}, [", *fill_lines(operands, "        "), "    ])"]
