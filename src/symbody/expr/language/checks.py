"""Checks of an operation's operands that need the text alone.

Conditions and numbers must not be mixed, whole exponents stay small, and arithmetic on plain
numbers must have a finite real result.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

from symbody.errors import Problem
from symbody.expr.graph import Constant
from symbody.expr.language.caret import Source
from symbody.expr.language.instructions import COMPARISONS, CONNECTIVES
from symbody.expr.language.literals import MAX_EXPONENT, fold

_SIGNS: Final = {"div": "the division", "power": "the power", "add": "the sum", "mul": "the product"}


class Value(NamedTuple):
    """What is known of a part of the expression: where it begins, and its value if it has one yet.

    Attributes
    ----------
    constant : number or bool, optional
        A bool if it is a condition.
    faults : tuple of Problem
        Where numbers in it have no value; they count unless no condition ever chooses them.
    """

    column: int
    is_condition: bool = False
    constant: Constant | None = None
    faults: tuple[Problem, ...] = ()


def check_operation(
    source: Source, name: str, column: int, operands: list[Value]
) -> tuple[Value, Problem | None]:
    """Return the value of the operation `name`, written at `column`, if known, and its problem."""
    start = min(column, operands[0].column)
    is_condition = name in COMPARISONS or name in CONNECTIVES
    faults = tuple(fault for operand in operands for fault in operand.faults)
    result = Value(start, is_condition, faults=faults)
    problem = _type_problem(source, name, operands)
    if problem is None and name == "if":
        return _decide_branch(start, *operands), None
    if problem is None and not is_condition:
        problem = _operand_problem(source, operands, name)
    constants = [value.constant for value in operands if value.constant is not None]
    if problem is not None:
        return result, problem
    try:
        if name in ("div", "mod") and operands[-1].constant == 0:
            raise ZeroDivisionError
        known = fold(name, *constants) if len(constants) == len(operands) else None
        return result._replace(constant=known), None
    except (ArithmeticError, ValueError) as fault:
        return result._replace(faults=(*faults, _undefined_problem(source, name, column, fault))), None


def _decide_branch(start: int, condition: Value, then: Value, otherwise: Value) -> Value:
    """Return what is known of a choice; where its condition has numbers alone, the other branch is out."""
    if condition.constant is None:
        return Value(start, faults=(*condition.faults, *then.faults, *otherwise.faults))
    taken = then if condition.constant else otherwise
    return Value(start, False, taken.constant, (*condition.faults, *taken.faults))


def condition_problem(source: Source, column: int) -> Problem:
    """Return the problem of a condition at `column` that stands where a number is needed."""
    return source.problem(
        "expression.condition",
        column,
        "a condition was found where a number is needed",
        "comparisons, and, or, not are true or false, which only if(...) can use",
        "write if(condition, 1, 0) for a number that is 1 where the condition holds",
    )


def _type_problem(source: Source, name: str, operands: list[Value]) -> Problem | None:
    for place, value in enumerate(operands):
        wants_condition = name in CONNECTIVES or (name == "if" and place == 0)
        if value.is_condition == wants_condition:
            continue
        if wants_condition:
            return source.problem(
                "expression.not_condition",
                value.column,
                f"a number was found where '{name}' needs a condition",
                "numbers are neither true nor false here",
                "compare it: x != 0, or x > 0",
            )
        if name in COMPARISONS:
            return source.problem(
                "expression.chained_comparison",
                value.column,
                "the result of a comparison is compared again",
                "comparisons cannot be chained",
                "write a < b and b < c for a < b < c",
            )
        return condition_problem(source, value.column)
    return None


def _operand_problem(source: Source, operands: list[Value], name: str) -> Problem | None:
    if name == "power":
        return _exponent_problem(source, operands[-1])
    if name == "smoothstep":
        return _knot_problem(source, operands[1:])
    if name == "interp1":
        return _knot_problem(source, operands[1::2])
    return None


def _exponent_problem(source: Source, exponent: Value) -> Problem | None:
    value = exponent.constant
    if value is None or value != int(value) or -MAX_EXPONENT <= value <= MAX_EXPONENT:
        return None
    size = str(int(value)) if -(10**12) < value < 10**12 else f"{float(value):.3e}"
    return source.problem(
        "expression.exponent",
        exponent.column,
        f"the exponent is {size}; whole exponents are limited to {MAX_EXPONENT}",
        "higher powers of numbers grow without bounds, and higher powers of lengths or angles are hardly "
        "intended",
        "make the exponent a parameter, or write exp(n*log(x))",
    )


def _knot_problem(source: Source, knots: list[Value]) -> Problem | None:
    for low, high in pairwise(knots):
        if low.constant is not None and high.constant is not None and not low.constant < high.constant:
            return source.problem(
                "expression.knots",
                high.column,
                "the points do not increase",
                "interp1(x, x1, y1, x2, y2, ...) and smoothstep(x, x1, x2) need x1 < x2 < ...",
                "put the points in increasing order, each only once",
            )
    return None


def _undefined_problem(source: Source, name: str, column: int, fault: Exception) -> Problem:
    branches = (
        "; a branch of if(...) is checked unless its condition contains only numbers"
        if "if(" in source.text
        else ""
    )
    if isinstance(fault, ZeroDivisionError):
        return source.problem(
            "expression.division_by_zero",
            column,
            "a number is divided by 0",
            "the divisor is written as zero" + branches,
            "remove the division, or correct the divisor",
        )
    if isinstance(fault, OverflowError):
        return source.problem(
            "expression.constant_range",
            column,
            f"{_SIGNS.get(name, name)} exceeds 1.797e308, the largest number that can be represented",
            "the numbers in it are too large",
            "correct the numbers, or choose other units",
        )
    return source.problem(
        "expression.undefined",
        column,
        f"{_SIGNS.get(name, name)} has no real value for the number given",
        "roots, logarithms and powers of negative numbers are not real, nor asin and acos beyond 1"
        + branches,
        "correct the number, or the sign before it",
    )
