"""JavaScript text of a sequence as one of the functions that kernels call: arrays with offsets, a status."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

from symbody.codegen.kernels.javascript_kernels import SADDLE_CALL
from symbody.codegen.pieces import PIECE_SIZE, Piece
from symbody.codegen.texts.javascript import DIALECT, FUNCTIONS, LANGUAGE
from symbody.codegen.texts.layout import TextLayout
from symbody.codegen.texts.statements import Statements
from symbody.expr.sequence import Sequence

GROUPS: Final = ("q", "u", "r", "p", "c", "out", "work")

_TAKEN: Final = frozenset({"status", "clock", "clock_0", "c", "c_0", *(f"{group}_0" for group in GROUPS)})
_RAW_LANGUAGE: Final = replace(LANGUAGE, words=LANGUAGE.words | _TAKEN)


_DIALECT: Final = replace(
    DIALECT,
    entry="{array}[{array}_0 + {k}]",
    kernel_call="    status = Math.max(status, symbody_saddle(work, {n}, {m}, work_0 + {arguments}, "
    "work_0 + {results}, work_0 + {scratch}));",
)
# What such functions call beside `solve_saddle`.
HELPERS: Final = "".join([*FUNCTIONS.values(), SADDLE_CALL])


def function_text(sequence: Sequence, name: str, *, piece_size: int = PIECE_SIZE) -> tuple[str, int]:
    """Return a function that kernels call, and how many numbers of scratch it needs.

    Its arguments are those of `symbody.kernels.language.Function`, each an array and where it begins; it
    returns 0, or 1 if a linear system has no solution.

    Raises
    ------
    CompileError
        If the sequence calls functions the user supplied, or a constant is beyond the doubles.
    """
    layout = TextLayout.for_sequence(sequence, name, _RAW_LANGUAGE, piece_size=piece_size)
    plan = layout.plan
    lines = [line for k, piece in enumerate(plan.pieces) for line in _piece(layout, k, piece)]
    given = ", ".join(["clock, clock_0", *(f"{array}, {array}_0" for array in GROUPS)])
    lines += [f"function {name}({given}) {{", "    let status = 0;"]
    lines += [f"    status = Math.max(status, {name}_{k}({given}));" for k in range(len(plan.pieces))]
    return "\n".join([*lines, "    return status;", "}"]) + "\n", plan.work_size


def _piece(layout: TextLayout, k: int, piece: Piece) -> Iterator[str]:
    targets = {place: _DIALECT.entry_text("out", place) for place in range(layout.sequence.output_size)}
    writer = Statements(layout, piece, _DIALECT, targets)
    body = writer.lines()
    given = ", ".join(["clock, clock_0", *(f"{array}, {array}_0" for array in GROUPS)])
    yield f"function {layout.name}_{k}({given}) {{"
    yield "    const t = clock[clock_0];"
    yield "    let status = 0;"
    yield from body
    yield "    return status;"
    yield "}"
