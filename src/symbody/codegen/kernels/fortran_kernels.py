"""Kernels as Fortran 2003: arrays are passed by the entry at which they begin."""

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
    offset_name,
)
from symbody.codegen.kernels.tree import KernelTree, Parameter, Type

_TYPES: Final = {Type.REAL: "real(dp)", Type.INTEGER: "integer"}
_RESULT: Final = "outcome"


def _literal(value: float, kind: Type) -> str:
    if kind == Type.INTEGER:
        return str(value)
    if math.isfinite(value):
        return f"{value!r}_dp"
    name = "quiet_nan" if math.isnan(value) else "positive_inf" if value > 0 else "negative_inf"
    return f"ieee_value(1.0_dp, ieee_{name})"


def _names(tree: KernelTree) -> Names:
    """Return names for those that differ from earlier ones by capital letters alone, or begin with a bar."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for name in (*(p.name for p in tree.parameters), *tree.variables):
        free = name.strip("_")
        while free.lower() in taken:
            free += "_"
        taken.add(free.lower())
        names[name] = free
    return names


def _declaration(parameter: Parameter, names: Names) -> str:
    name = names[parameter.name]
    if parameter.type == Type.ARRAY:
        return f"    real(dp), intent({'inout' if parameter.is_changed else 'in'}) :: {name}(*)"
    return f"    {_TYPES[parameter.type]}, intent(in) :: {name}"


def _head(tree: KernelTree, names: Names) -> Iterator[str]:
    parameters = ", ".join(names[p.name] for p in tree.parameters)
    yield f"! {tree.summary}"
    if tree.result is None:
        yield f"subroutine {PREFIX}{tree.name}({parameters})"
    else:
        yield f"function {PREFIX}{tree.name}({parameters}) result({_RESULT})"
        yield f"    {_TYPES[tree.result]} :: {_RESULT}"
    yield from (_declaration(parameter, names) for parameter in tree.parameters)
    for kind, text in _TYPES.items():
        variables = [names[name] for name, its_kind in tree.variables.items() if its_kind == kind]
        if kind == Type.INTEGER:
            arrays = (name for name, its_kind in tree.variables.items() if its_kind == Type.ARRAY)
            variables += [offset_name(names[name]) for name in arrays]
        if variables:
            yield f"    {text} :: {', '.join(variables)}"


# Kernels by address, with scratch of their own.
SADDLE_CALL: Final = """\
subroutine symbody_saddle(n, m, mass, jacobian, F, gamma, solution)
    integer, intent(in) :: n, m
    real(dp), intent(in) :: mass(*), jacobian(*), F(*), gamma(*)
    real(dp), intent(inout) :: solution(*)
    real(dp) :: work(6 * n + 4 * m + n * (m + n))
    integer :: status
    status = symbody_solve_saddle(n, m, mass, jacobian, F, gamma, solution, work)
end
"""

FORTRAN: Final = KernelDialect(
    literal=_literal,
    head=_head,
    operators={"and": ".and.", "or": ".or.", "neg": "-", "==": "==", "!=": "/="},
    words={
        "not": ".not. ({0})", "abs": "abs({0})", "sqrt": "sqrt({0})", "min": "merge({1}, {0}, {1} < {0})",
        "max": "merge({1}, {0}, {1} > {0})", "is_finite": "ieee_is_finite({0})",
        "exponent": "symbody_exponent({0})", "power_of_two": "scale(1.0_dp, {0})", "half": "shifta({0}, 1)",
        "real": "real({0}, dp)", "integer": "int({0})",
    },
    arrays=Arrays.ADDRESSES,
    entry="{array}({next})",
    part="{array}({next})",
    statements=StatementFormats(
        assign="{name} = {value}",
        store="{array}({next}) = {value}",
        perform="call {value}",
        returns=f"{_RESULT} = {{value}}; return",
        returns_nothing="return",
        leave="exit",
        count="do {name} = {start}, {last}",
        count_down="do {name} = {start}, {last}, -1",
        repeat="do while ({condition})",
        choose="if ({condition}) then",
        choose_next="else if ({condition}) then",
        otherwise="else",
        close="end if",
        close_loop="end do",
        end="end",
    ),
    continuation=" &",
    helpers={
        "exponent": """\
integer function symbody_exponent(x)
    real(dp), intent(in) :: x
    symbody_exponent = 0
    if (x > 0.0_dp .and. x <= huge(x)) symbody_exponent = max(exponent(x), -1022)
end function
""",
    },
    rename=_names,
)  # fmt: skip
