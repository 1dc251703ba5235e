"""Kernels as JavaScript: arrays are Float64Arrays, each with the index at which it begins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import (
    BRACES,
    PREFIX,
    Arrays,
    KernelDialect,
    Names,
    library_words,
    offset_name,
)
from symbody.codegen.kernels.tree import KernelTree, Type

# Powers of 1, and of -1 with an infinite exponent, are 1 as in C; here they would be nan.
POWER: Final = """\
function symbody_pow(base, exponent) {
    if (base === 1 || (base === -1 && Math.abs(exponent) === Infinity)) return 1;
    return Math.pow(base, exponent);
}
"""

_HELPERS: Final = {
    "pow": POWER,
    "exponent": """\
const symbody_number = new Float64Array(1), symbody_words = new Uint32Array(symbody_number.buffer);
function symbody_exponent(x) {
    if (!(x > 0 && x < Infinity)) return 0;
    symbody_number[0] = x;
    return Math.max((symbody_words[1] >>> 20) - 1022, -1022);  // from the upper half of the bits
}
""",
}


def literal(value: float, kind: Type) -> str:
    """Return a number: with a point if it is real, though the language has one type only."""
    if kind == Type.INTEGER:
        return str(value)
    if math.isfinite(value):
        return repr(float(value))
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    parameters = ", ".join(
        f"{p.name}, {offset_name(p.name)}" if p.type == Type.ARRAY else p.name for p in tree.parameters
    )
    yield f"// {tree.summary}"
    yield f"function {PREFIX}{tree.name}({parameters}) {{"
    variables = [offset_name(name) if kind == Type.ARRAY else name for name, kind in tree.variables.items()]
    if variables:
        yield f"    let {', '.join(variables)};"


# The arguments one after the other, the solution and scratch, all in one array.
SADDLE_CALL: Final = """\
function symbody_saddle(work, n, m, first, results, scratch) {
    const jacobian = first + n * n, force = jacobian + m * n, gamma = force + n;
    return symbody_solve_saddle(
        n, m, work, first, work, jacobian, work, force, work, gamma, work, results, work, scratch);
}
"""

JAVASCRIPT: Final = KernelDialect(
    literal=literal,
    head=_head,
    operators={"and": "&&", "or": "||", "neg": "-", "==": "===", "!=": "!=="},
    words=library_words("Math.") | {
        "pow": "symbody_pow({0}, {1})", "not": "!({0})", "abs": "Math.abs({0})", "sqrt": "Math.sqrt({0})",
        "is_finite": "Number.isFinite({0})", "exponent": "symbody_exponent({0})",
        "min": "({1} < {0} ? {1} : {0})", "max": "({1} > {0} ? {1} : {0})",
        "power_of_two": "2 ** ({0})", "half": "Math.floor(({0}) / 2)", "real": "{0}",
        "integer": "Math.trunc({0})",
    },
    arrays=Arrays.OFFSETS,
    entry="{array}[{index}]",
    part="{array}, {index}",
    statements=BRACES,
    helpers=_HELPERS,
)  # fmt: skip
