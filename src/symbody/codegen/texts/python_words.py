"""What the texts in Python have in common: NumPy, JAX and CasADi."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Sequence as Items

from symbody.codegen.texts.layout import TextLayout
from symbody.codegen.texts.lists import fill_lines
from symbody.codegen.texts.text_dialect import operation_formats
from symbody.expr import opcodes as op


def kernel(name: str, n: int, m: int, operands: Items[str]) -> list[str]:
    """Return the lines that call the kernel for n accelerations and m rows."""
    return [f"    {name} = _solve_saddle({n}, {m}, [", *fill_lines(operands, "        "), "    ])"]


def numpy_formats(prefix: str, angle: str) -> dict[int, str]:
    """Return the formats of operations for NumPy and what is called alike, with `angle` for atan2."""
    return operation_formats(
        prefix,
        {
            op.POW: f"{prefix}power({{0}}, {{1}})",
            op.ASIN: f"{prefix}arcsin({{0}})",
            op.ACOS: f"{prefix}arccos({{0}})",
            op.ATAN: f"{prefix}arctan({{0}})",
            op.ATAN2: angle,
            op.MIN: f"{prefix}where(({{0}} < {{1}}) | ({{0}} != {{0}}), {{0}}, {{1}})",  # nan where either is
            op.MAX: f"{prefix}where(({{1}} < {{0}}) | ({{0}} != {{0}}), {{0}}, {{1}})",
            op.AND: f"{prefix}logical_and({{0}}, {{1}})",
            op.OR: f"{prefix}logical_or({{0}}, {{1}})",
            op.NOT: f"{prefix}logical_not({{0}})",
            op.SELECT: f"{prefix}where({{0}}, {{1}}, {{2}})",
        },
    )


def module_head(layout: TextLayout, call: str, *notes: str) -> Iterator[str]:
    """Yield the docstring of a module: the head of all texts, and what the language adds."""
    first, *others = layout.heading(lambda array, k: "t" if array == "t" else f"{array}[{k}]", call)
    yield f'r"""{first}'
    yield ""
    yield from others
    yield from notes
    yield '"""'
    yield ""


def helpers(layout: TextLayout, angle: str, saddle: str) -> list[str]:
    """Return the functions that the statements call: for angles, and for linear systems."""
    has_angles = any(each.op == op.ATAN2 for each in layout.sequence.operations)
    lines = [angle.rstrip("\n"), ""] if has_angles else []
    return [*lines, *([saddle.rstrip("\n"), ""] if layout.plan.results else [])]
