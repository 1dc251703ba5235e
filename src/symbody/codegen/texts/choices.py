"""Which values of a sequence only one branch of a choice reads."""

from __future__ import annotations

from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Sequence

Path = tuple[tuple[int, bool], ...]  # choices on the way to a value, and whether their condition holds


def find_choices(sequence: Sequence) -> tuple[list[Path], list[int]]:
    """Return for each value the choices that all its readers share, and how often it is read."""
    count = len(sequence.operations)
    paths: list[Path | None] = [None] * count
    reads = [0] * count
    for output in sequence.outputs:
        for value in output.values:
            paths[value] = ()
            reads[value] += 1
    for k in range(count - 1, -1, -1):
        path, operation = paths[k], sequence.operations[k]
        if path is None:
            continue
        for place, value in enumerate(operation.operands):
            here = (*path, (k, place == 1)) if operation.op == op.SELECT and place > 0 else path
            before = paths[value]
            paths[value] = here if before is None else _common_part(before, here)
            reads[value] += 1
    return [path or () for path in paths], reads


def _common_part(first: Path, second: Path) -> Path:
    pairs = zip(first, second, strict=False)
    count = next((k for k, (a, b) in enumerate(pairs) if a != b), min(len(first), len(second)))
    return first[:count]
