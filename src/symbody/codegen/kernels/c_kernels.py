"""Kernels as C99."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

from symbody.codegen.kernels.dialect import BRACES, PREFIX, Arrays, KernelDialect, Names, library_words
from symbody.codegen.kernels.tree import KernelTree, Parameter, Type

_TYPES: Final = {
    Type.REAL: "double ", Type.INTEGER: "int ", Type.ARRAY: "double *", Type.FUNCTION: "symbody_function ",
}  # fmt: skip

# Without contraction: a * b + c is rounded twice, so that all languages give the same bits. GCC does not know
# the standard pragma and warns of it.
PREAMBLE: Final = """\
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif
#include <math.h>
"""
_HELPERS: Final = {
    "Function": """\
typedef int (*symbody_function)(
    const double *t, const double *q, const double *u, const double *r, const double *p, const double *c,
    double *out, double *work);
""",
    "min": "static double symbody_smaller(double a, double b) { return b < a ? b : a; }\n",
    "max": "static double symbody_larger(double a, double b) { return b > a ? b : a; }\n",
    "half": "static int symbody_half(int e) { return (e - (e & 1)) / 2; }\n",
    "exponent": """\
static int symbody_exponent(double x)
{
    int e = 0;
    if (!(x > 0.0 && x < HUGE_VAL)) return 0;
    (void)frexp(x, &e);
    return e < -1022 ? -1022 : e > 1022 ? 1022 : e;
}
""",
}


def _literal(value: float | int, kind: Type) -> str:
    if kind == Type.INTEGER:
        return str(value)
    if math.isnan(value):
        return "NAN"
    return repr(value) if math.isfinite(value) else "HUGE_VAL" if value > 0 else "-HUGE_VAL"


def _parameter(parameter: Parameter) -> str:
    constant = "const " if parameter.type == Type.ARRAY and not parameter.is_changed else ""
    return f"{constant}{_TYPES[parameter.type]}{parameter.name}"


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    result = "void " if tree.result is None else _TYPES[tree.result]
    yield f"/* {tree.summary} */"
    yield f"static {result}{PREFIX}{tree.name}({', '.join(map(_parameter, tree.parameters))})"
    yield "{"
    for kind, text in _TYPES.items():
        separator = ", *" if kind == Type.ARRAY else ", "
        variables = [name for name, its_kind in tree.variables.items() if its_kind == kind]
        changed = [name for name in variables if name not in tree.read_only]
        constant = [name for name in variables if name in tree.read_only]
        if changed:
            yield f"    {text}{separator.join(changed)};"
        if constant:
            yield f"    const {text}{separator.join(constant)};"


C: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"and": "&&", "or": "||", "neg": "-"},
    arrays=Arrays.POINTERS,
    words=library_words("") | {
        "not": "!({0})", "abs": "fabs({0})", "sqrt": "sqrt({0})", "min": "symbody_smaller({0}, {1})",
        "max": "symbody_larger({0}, {1})", "is_finite": "isfinite({0})", "exponent": "symbody_exponent({0})",
        "min int": "(({1}) < ({0}) ? ({1}) : ({0}))", "max int": "(({1}) > ({0}) ? ({1}) : ({0}))",
        "power_of_two": "ldexp(1.0, {0})", "half": "symbody_half({0})", "real": "(double)({0})",
        "integer": "(int)({0})",
    },
    entry="{array}[{index}]",
    part="{array} + {index}",
    statements=BRACES,
    helpers=_HELPERS,
)  # fmt: skip
