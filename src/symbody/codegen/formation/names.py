"""Names of parameters and inputs as callers give them, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as Items
from dataclasses import replace
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.errors import CompileError, Problem, nearest
from symbody.expr.language.formula import Formula

Value = int | float | str | Formula

_DECLARATIONS: Final = {
    "input": 'inputs=["{0}"] in Python, inputs = ["{0}"] in a file',
    "parameter": 'parameters={{"{0}": ..}} in Python, [parameters] {0} = .. in a file',
}


def check_names(eqs: EquationSet, given: Mapping[str, Value], free: Items[str]) -> None:
    """Refuse names that are not parameters.

    Raises
    ------
    CompileError
        Naming each, with the nearest ones.
    """
    known = eqs.parameter_names
    problems = [unknown_name("parameter", name, known) for name in (*given, *free) if name not in known]
    if problems:
        raise CompileError(*problems)


def unknown_name(kind: str, name: str, known: Items[str]) -> Problem:
    """Return what to say about a name that the model does not have."""
    cure = nearest(name, known) if known else f"declare it in the model: {_DECLARATIONS[kind].format(name)}"
    return Problem(f"compile.unknown_{kind}", name, f"the model has no {kind} {name!r}", "", cure)


def offer_argument(problem: Problem) -> Problem:
    """Return a problem; that of a missing value with the argument that a function can have for it."""
    if problem.code != "compile.missing_value":
        return problem
    return replace(problem, fix=f"{problem.fix}, or free=[..] with the names that are arguments")


def missing_value(names: Items[str]) -> Problem:
    """Return what to say about parameters without a value."""
    listed = ", ".join(names)
    entries = ", ".join(f"{name!r}: .." for name in names)
    return Problem(
        "compile.missing_value", "parameters", f"no value is given for {listed}",
        "the computation needs a number",
        f"give parameters={{{entries}}}",
    )  # fmt: skip
