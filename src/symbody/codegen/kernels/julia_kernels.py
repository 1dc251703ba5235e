"""Kernels as Julia: parts of arrays are views. Pivots are chosen by values, so dual numbers pass through."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import PREFIX, Arrays, KernelDialect, Names, StatementFormats
from symbody.codegen.kernels.tree import KernelTree, Type


def _literal(value: float, kind: Type) -> str:
    if kind == Type.INTEGER or math.isfinite(value):
        return repr(value)
    return "NaN" if math.isnan(value) else "Inf" if value > 0 else "-Inf"


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    yield f"# {tree.summary}"
    yield f"function {PREFIX}{tree.name}({', '.join(p.name for p in tree.parameters)})"


# The arguments lie in work behind `first` numbers, the solution goes behind `place` numbers.
SADDLE_CALL: Final = """\
function symbody_saddle!(work, n, m, first, place)
    M = view(work, first+1:first+n*n)
    J = view(work, first+n*n+1:first+n*n+m*n)
    F = view(work, first+n*n+m*n+1:first+n*n+m*n+n)
    gamma = view(work, first+n*n+m*n+n+1:first+n*n+m*n+n+m)
    solution = view(work, place+1:place+n+m+1)
    scratch = zeros(eltype(work), 6n + 4m + n * (m + n))
    symbody_solve_saddle(n, m, M, J, F, gamma, solution, scratch)
    return nothing
end
"""

JULIA: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"and": "&&", "or": "||", "neg": "-"},
    words={
        "not": "!({0})", "abs": "abs({0})", "sqrt": "symbody_sqrt({0})", "min": "symbody_smaller({0}, {1})",
        "max": "symbody_larger({0}, {1})", "is_finite": "isfinite({0})", "exponent": "symbody_exponent({0})",
        "power_of_two": "ldexp(1.0, {0})", "half": "(({0}) >> 1)", "real": "Float64({0})",
        "integer": "trunc(Int, {0})",
    },
    arrays=Arrays.POINTERS,
    entry="{array}[{next}]",
    part="view({array}, {next}:length({array}))",
    statements=StatementFormats(
        assign="{name} = {value}",
        store="{array}[{next}] = {value}",
        perform="{value}",
        returns="return {value}",
        returns_nothing="return nothing",
        leave="break",
        count="for {name} in {start}:{last}",
        count_down="for {name} in {start}:-1:{last}",
        repeat="while {condition}",
        choose="if {condition}",
        choose_next="elseif {condition}",
        otherwise="else",
        close="end",
        end="end",
    ),
    helpers={
        "sqrt": "symbody_sqrt(x) = x >= 0 ? sqrt(x) : x * NaN\n",
        "min": "symbody_smaller(a, b) = b < a ? b : a\n",
        "max": "symbody_larger(a, b) = b > a ? b : a\n",
        "exponent": "symbody_exponent(x) = 0 < x < Inf ? clamp(exponent(x) + 1, -1022, 1022) : 0\n",
    },
)  # fmt: skip
