"""Kernels as Python on `math` alone: arrays are lists, each with the index at which it begins."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import (
    PREFIX,
    Arrays,
    KernelDialect,
    Names,
    StatementFormats,
    library_words,
    offset_name,
)
from symbody.codegen.kernels.tree import KernelTree, Type


def _literal(value: float, kind: Type) -> str:
    if kind == Type.INTEGER or math.isfinite(value):
        return repr(value)
    return f"float('{value}')"


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    parameters = ", ".join(
        f"{p.name}, {offset_name(p.name)}" if p.type == Type.ARRAY else p.name for p in tree.parameters
    )
    yield f"def {PREFIX}{tree.name}({parameters}):"
    yield f'    """{tree.summary}"""'


# At every point of a batch; the results stand along the first axis.
SADDLE_CALL: Final = """\
def symbody_saddle(n, m, values):
    arrays = np.broadcast_arrays(*values)
    points = np.stack([array.ravel() for array in arrays], axis=-1).tolist()
    results = np.array([symbody_saddle_point(n, m, point) for point in points])
    return np.moveaxis(results.reshape(arrays[0].shape + (n + m + 1,)), -1, 0)


def symbody_saddle_point(n, m, values):
    result, work = [0.0] * (n + m + 1), [0.0] * (6 * n + 4 * m + n * (m + n))
    J, F = n * n, n * n + m * n
    symbody_solve_saddle(n, m, values, 0, values, J, values, F, values, F + n, result, 0, work, 0)
    return result
"""

PYTHON: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"neg": "-"},
    words=library_words("math.") | {
        "not": "(not {0})", "abs": "abs({0})", "sqrt": "symbody_sqrt({0})", "min": "min({0}, {1})",
        "max": "max({0}, {1})", "is_finite": "math.isfinite({0})", "exponent": "symbody_exponent({0})",
        "power_of_two": "math.ldexp(1.0, {0})", "half": "(({0}) >> 1)", "real": "float({0})",
        "integer": "int({0})",
    },
    arrays=Arrays.OFFSETS,
    entry="{array}[{index}]",
    part="{array}, {index}",
    statements=StatementFormats(
        assign="{name} = {value}",
        store="{array}[{index}] = {value}",
        perform="{value}",
        returns="return {value}",
        returns_nothing="return",
        leave="break",
        count="for {name} in range({start}, {stop}):",
        count_down="for {name} in range({start}, {stop}, -1):",
        repeat="while {condition}:",
        choose="if {condition}:",
        choose_next="elif {condition}:",
        otherwise="else:",
        close="",
        end="",
    ),
    helpers={
        "sqrt": "def symbody_sqrt(x):\n    return math.sqrt(x) if x >= 0.0 else float('nan')\n\n",
        "exponent": """\
def symbody_exponent(x):
    if not 0.0 < x < float('inf'):
        return 0
    return min(max(math.frexp(x)[1], -1022), 1022)

""",
    },
)  # fmt: skip
