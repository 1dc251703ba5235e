"""Faults in the order of tokens, and the cure for each kind of slip that leads to them."""

from __future__ import annotations

from types import MappingProxyType
from typing import Final

from symbody.errors import Problem, nearest
from symbody.expr.language.caret import Source, printable
from symbody.expr.language.instructions import FUNCTIONS
from symbody.expr.language.tokens import Token

# Functions of other languages -> what to write.
_ELSEWHERE: Final = MappingProxyType(
    {
        "ln": "log(x)", "log10": "log(x)/log(10)", "log2": "log(x)/log(2)", "pow": "x**y", "fabs": "abs(x)",
        "sgn": "sign(x)", "signum": "sign(x)", "arcsin": "asin(x)", "arccos": "acos(x)", "arctan": "atan(x)",
        "arctan2": "atan2(y, x)", "cot": "1/tan(x)", "sec": "1/cos(x)", "csc": "1/sin(x)",
        "ceil": "-floor(-x)", "cbrt": "sign(x)*abs(x)**(1/3)", "hypot": "sqrt(x**2 + y**2)",
        "fmod": "mod(x, y)", "where": "if(c, a, b)", "clip": "min(max(x, low), high)",
        "piecewise": "if(c, a, b)", "Piecewise": "if(c, a, b)",
        "heaviside": "if(x < 0, 0, 1)", "Heaviside": "if(x < 0, 0, 1)", "diff": "x_dot for the rate of x",
        "der": "x_dot for the rate of x", "radians": "x*pi/180", "degrees": "x*180/pi",
    }
)  # fmt: skip
_PYTHON_WORDS: Final = frozenset(
    {"if", "not", "for", "in", "is", "else", "lambda", "import", "async", "await"}
)
_UNITS: Final = frozenset(
    {
        "mm",
        "cm",
        "m",
        "km",
        "g",
        "kg",
        "t",
        "N",
        "kN",
        "Nm",
        "J",
        "W",
        "Pa",
        "MPa",
        "s",
        "ms",
        "Hz",
        "rad",
        "rpm",
    }
)


def adjacent_problem(source: Source, previous: Token, token: Token, following: Token) -> Problem:
    """Return the problem of an operand `token` that follows another with no operator between."""
    column = token.start + 1
    if {token.text, previous.text} & _PYTHON_WORDS and previous.kind != "number":
        word = token.text if token.text in _PYTHON_WORDS else previous.text
        return source.problem(
            "expression.syntax",
            column,
            f"'{word}' is not allowed here: no operator connects it with what precedes it",
            "Python's lambda, comprehensions, 'in' and 'x if c else y' are not part of the language",
            "write a formula, with if(c, x, y) for a choice",
        )
    if previous.kind == "number" and previous.end == token.start:
        problem = _numeral_problem(source, previous, token, following)
        if problem is not None:
            return problem
    if previous.text in FUNCTIONS:
        fix = f"write {previous.text}({printable(token.text)})"
    elif token.text in ("degree", "degrees") and previous.kind == "number":
        fix = f"write {previous.text} deg"
    elif previous.text in (")", "deg") and token.text in ("deg", "degree", "degrees"):
        fix = "degrees follow a number, as in 30 deg; multiply anything else by pi/180"
    elif token.text in ("deg", "degree", "degrees"):
        fix = f"write {previous.text}*pi/180: degrees follow a number, as in 30 deg"
    elif previous.kind == "number" and token.text in _UNITS:
        fix = f"remove the unit and give the value in SI units; with a symbol {token.text}, write "
        fix += f"{printable(previous.text)}*{token.text}"
    else:
        fix = f"write {printable(previous.text)}*{printable(token.text)}"
    return source.problem(
        "expression.implicit_multiplication",
        column,
        f"an operator is missing between '{printable(previous.text)}' and '{printable(token.text)}'",
        "multiplication is not implied by writing side by side",
        fix,
    )


def missing_problem(source: Source, token: Token, function: str) -> Problem:
    """Return the problem of a `token` that stands where an operand must begin.

    `function` is the one whose bracket is open at this place, or ``""``.
    """
    column = token.start + 1
    if not source.text.strip():
        return source.problem(
            "expression.empty",
            column,
            "the expression is empty",
            "the text contains only spaces",
            "write 0 if nothing is meant",
        )
    if token.kind == "end":
        what = "the expression ends where an operand is expected"
    else:
        what = f"an operand is expected before '{token.text}'"
    return source.problem(
        "expression.missing_operand",
        column,
        what,
        f"an argument of {function}(...) is missing" if function else "an operator or bracket has no operand",
        "write a number, a name, a function or a bracketed expression here",
    )


def unknown_function_problem(source: Source, token: Token) -> Problem:
    """Return the problem of a name followed by a bracket that is not one of the functions."""
    known = _ELSEWHERE.get(token.text)
    # One or two letters are rather a quantity than a misspelt function: show the whole list.
    cure = f"write {known}." if known else nearest(token.text if len(token.text) > 2 else "", FUNCTIONS)
    return source.problem(
        "expression.unknown_function",
        token.start + 1,
        f"'{printable(token.text)}' is not a function of the language",
        "it is a function of another language, a typo, or a '*' is missing before the bracket",
        f"{cure} For a product write {printable(token.text)}*(...)",
    )


def arguments_problem(source: Source, name: str, column: int, count: int) -> Problem | None:
    """Return the problem of a function `name` called with `count` arguments, or None."""
    least, most = FUNCTIONS.get(name, (count, count))
    if least <= count <= most and not (name == "interp1" and count % 2 == 0):
        return None
    number = str(least) if least == most else f"{least} or more"
    return source.problem(
        "expression.arguments",
        column,
        f"{name} is given {count} argument{'s' * (count != 1)}, not {number}",
        "separate arguments by commas, and use a decimal point",
        f"write {_FORMS.get(name, f'{name}(x)')}",
    )


_FORMS: Final = MappingProxyType(
    {
        "atan2": "atan2(y, x)", "mod": "mod(x, y)", "smoothstep": "smoothstep(x, x1, x2)",
        "if": "if(condition, a, b)", "min": "min(a, b, ...)", "max": "max(a, b, ...)",
        "interp1": "interp1(x, x1, y1, x2, y2, ...)",
    }
)  # fmt: skip


def is_decimal_comma(previous: Token, comma: Token, following: Token) -> bool:
    """Return whether a comma stands directly between two runs of digits."""
    return (
        previous.text.isdigit()
        and following.text[:1].isdigit()
        and previous.end == comma.start
        and comma.end == following.start
    )


def comma_problem(source: Source, previous: Token, comma: Token, following: Token) -> Problem:
    """Return the problem of a comma that separates no arguments."""
    if is_decimal_comma(previous, comma, following):
        return source.problem(
            "expression.comma_decimal",
            comma.start + 1,
            "there is a comma inside a number",
            "a decimal comma, or a comma between thousands",
            f"write {previous.text}.{following.text}",
        )
    return source.problem(
        "expression.comma",
        comma.start + 1,
        "this comma does not separate arguments",
        "commas are allowed only between the arguments of a function",
        "write one expression, or a function before the bracket",
    )


def _numeral_problem(source: Source, previous: Token, token: Token, following: Token) -> Problem | None:
    """Return the problem of a number with something attached to it, if it looks like a slip in the number."""
    text = previous.text + token.text
    if token.kind == "number":
        what, fix = "a number has two decimal points", "write one point, and no separator between thousands"
    elif token.text in ("e", "E") and following.text in ("+", "-", ""):
        what, fix = (
            "the exponent of a number is incomplete",
            f"write {previous.text}e-3, or {previous.text}*e",
        )
    elif previous.text == "0" and token.text[0] in "xXbBoO":
        what, fix = "only decimal numbers are supported", "write it as a decimal number"
    elif token.text[0] == "_" and token.text.replace("_", "").isdigit():
        what, fix = "a number has separators between its digits", f"write {text.replace('_', '')}"
    else:
        return None
    return source.problem(
        "expression.number", token.start + 1, what, f"{printable(text)} is not a number", fix
    )
