"""Kernels as MATLAB: arrays are values, so a kernel returns those that it changes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import PREFIX, Arrays, KernelDialect, Names, StatementFormats
from symbody.codegen.kernels.tree import KernelTree, Type

_RESULT: Final = "outcome"


def _literal(value: float, kind: Type) -> str:
    if kind == Type.INTEGER or math.isfinite(value):
        return repr(value)
    return "NaN" if math.isnan(value) else "Inf" if value > 0 else "-Inf"


def _names(tree: KernelTree) -> Names:
    names = (*(p.name for p in tree.parameters), *tree.variables)
    return {name: name.lstrip("_") for name in names if name.startswith("_")}


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    results = [_RESULT] if tree.result is not None else []
    results += [names.get(p.name, p.name) for p in tree.parameters if p.is_changed]
    parameters = ", ".join(names.get(p.name, p.name) for p in tree.parameters)
    yield f"function [{', '.join(results)}] = {PREFIX}{tree.name}({parameters})"
    yield f"% {tree.summary}"


# udot, lambda and the rank of J from M, J, F and gamma, one after the other.
SADDLE_CALL: Final = """\
function solution = symbody_saddle(n, m, values)
    values = values(:);
    M = values(1:n * n);
    J = values(n * n + (1:m * n));
    F = values(n * n + m * n + (1:n));
    gamma = values(n * n + m * n + n + (1:m));
    work = zeros(6 * n + 4 * m + n * (m + n), 1);
    [~, solution] = symbody_solve_saddle(n, m, M, J, F, gamma, zeros(n + m + 1, 1), work);
end
"""

MATLAB: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"and": "&&", "or": "||", "neg": "-", "!=": "~="},
    words={
        "not": "~({0})", "abs": "abs({0})", "sqrt": "symbody_sqrt({0})", "min": "symbody_smaller({0}, {1})",
        "max": "symbody_larger({0}, {1})", "is_finite": "isfinite({0})", "exponent": "symbody_exponent({0})",
        "power_of_two": "pow2({0})", "half": "floor(({0}) / 2)", "real": "{0}", "integer": "fix({0})",
    },
    arrays=Arrays.COPIES,
    entry="{array}({next})",
    part="{array}({next}:{last})",
    statements=StatementFormats(
        assign="{name} = {value};",
        store="{array}({next}) = {value};",
        perform="{value};",
        returns=f"{_RESULT} = {{value}}; return",
        returns_nothing="return",
        leave="break",
        count="for {name} = {start}:{last}",
        count_down="for {name} = {start}:-1:{last}",
        repeat="while {condition}",
        choose="if {condition}",
        choose_next="elseif {condition}",
        otherwise="else",
        close="end",
        end="end",
    ),
    continuation=" ...",
    result=_RESULT,
    helpers={
        "sqrt": "function y = symbody_sqrt(x)\ny = NaN;\nif x >= 0\n    y = sqrt(x);\nend\nend\n",
        "min": "function c = symbody_smaller(a, b)\nc = a;\nif b < a\n    c = b;\nend\nend\n",
        "max": "function c = symbody_larger(a, b)\nc = a;\nif b > a\n    c = b;\nend\nend\n",
        "exponent": """\
function e = symbody_exponent(x)
e = 0;
if x > 0 && x < Inf
    [~, e] = log2(x);
    e = min(max(e, -1022), 1022);
end
end
""",
    },
    rename=_names,
)  # fmt: skip
