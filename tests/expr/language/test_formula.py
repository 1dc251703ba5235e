"""Formulas as values, and what they become on the graph."""

from __future__ import annotations

import itertools
import math
import operator
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from symbody.errors import ExpressionError, Problem
from symbody.expr import opcodes
from symbody.expr.graph import Graph, Symbol
from symbody.expr.language.formula import Formula, build
from symbody.expr.parser import parse
from symbody.expr.rewrite import substitute

# --- values -----------------------------------------------------------------------------------

TEXT = "-m*g*sin(theta) + if(x < 0 and v > 1e-3, k*x, 0.12345678901234567)"


def test_frozen_hashable_picklable() -> None:
    formula = parse(TEXT)
    assert formula == parse(TEXT)
    assert hash(formula) == hash(parse(TEXT))
    assert pickle.loads(pickle.dumps(formula)) == formula
    assert {formula: 1}[parse(TEXT)] == 1
    assert formula != parse(TEXT + " ")
    for attribute in ("text", "program"):
        with pytest.raises(FrozenInstanceError):
            setattr(formula, attribute, "x")


def test_names_in_order_of_appearance() -> None:
    assert parse("b + a*b - sin(c)/a").names == ("b", "a", "c")
    assert parse("2").names == ()


def test_columns_point_into_the_text() -> None:
    formula = parse("alpha + 2.5*max(b, sin(gamma))")
    for step in formula.program:
        written = formula.text[step.column - 1 :]
        expected = {"add": "+", "mul": "*"}.get(str(step.payload), str(step.payload))
        assert written.startswith("2.5" if step.kind == "number" else expected)


@pytest.mark.parametrize(
    ("value", "text", "number"),
    [
        (3, "3", 3),
        (-3, "-3", -3),
        (0, "0", 0),
        (10**300, "1" + "0" * 300, 10**300),
        (Fraction(1, 3), "1/3", Fraction(1, 3)),
        (Fraction(-7, 2), "-7/2", Fraction(-7, 2)),
        (9.81, "9.81", Fraction(981, 100)),
        (-0.5, "-0.5", Fraction(-1, 2)),
        (1e-7, "1e-07", Fraction(1, 10**7)),
        (0.1 + 0.2, "0.30000000000000004", 0.1 + 0.2),
        (1.7976931348623157e308, "1.7976931348623157e+308", 1.7976931348623157e308),
        (5e-324, "5e-324", Fraction(5, 10**324)),
        (Decimal("9.810"), "9.810", Fraction(981, 100)),
        (np.float64(0.25), "0.25", Fraction(1, 4)),
        (np.float32(0.1), "0.10000000149011612", 0.10000000149011612),
        (np.int32(-7), "-7", -7),
    ],
    ids=range(16),
)
def test_numbers_become_their_decimal_text(value: float, text: str, number: object) -> None:
    """Row 33. Up to 15 digits a float is the decimal it was written as, beyond that it stays a float."""
    formula = Formula.from_value(value)
    assert formula.text == text
    assert formula.is_number
    assert formula.constant() == number
    assert isinstance(formula.constant(), float) == isinstance(number, float)
    assert formula == parse(text)


def test_formulas_and_text_at_the_door() -> None:
    formula = parse("a + b")
    assert Formula.from_value(formula) is formula
    assert Formula.from_value("a + b") == formula
    assert str(formula) == "a + b"


@pytest.mark.parametrize(
    ("value", "code", "cause"),
    [
        (True, "type", "True of type bool"),
        (np.bool_(True), "type", "of type bool"),
        (1j, "type", "of type complex"),
        (None, "type", "of type NoneType"),
        (b"x", "type", "of type bytes"),
        ([1, 2], "type", "of type list"),
        (np.array([1.0, 2.0]), "type", "of type ndarray"),
        (math.nan, "not_finite", "nan"),
        (-math.inf, "not_finite", "-inf"),
        (Decimal("NaN"), "not_finite", "NaN"),
        (np.float64("inf"), "not_finite", "inf"),
        (10**5000, "number", "digits"),
        (Fraction(1, 10**5000), "number", "digits"),
        (10**350, "number", "exceeds 1.797e308"),
    ],
    ids=range(14),
)
def test_what_is_no_expression(value: float, code: str, cause: str) -> None:
    """Rows 27, 33 and 109."""
    with pytest.raises(ExpressionError) as caught:
        Formula.from_value(value, where="parameter k")
    (problem,) = caught.value.problems
    assert problem.code == f"expression.{code}"
    assert problem.where.startswith("parameter k")
    assert cause in problem.what
    assert problem.why and problem.fix


@pytest.mark.parametrize("text", ["9,81", "1e-3x", "", "nan(1)"])
def test_text_with_a_wrong_number_is_refused(text: str) -> None:
    """Row 29: text is never guessed to be some number."""
    with pytest.raises(ExpressionError, match="fix: "):
        Formula.from_value(text, where="parameter k")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2", 2), ("-2.5", Fraction(-5, 2)), ("+--3", 3), ("(1/3)", Fraction(1, 3)),
        ("-1/-4", Fraction(1, 4)),
        ("1/3.00000000000000001", 1 / 3), ("x", None), ("nan", None), ("neg", None), ("div", None),
        ("-x", None),
        ("1+1", None), ("2*3", None), ("sin(0)", None), ("1/x", None), ("if(1 < 2, 3, 4)", None),
    ],
)  # fmt: skip
def test_constant(text: str, value: object) -> None:
    formula = parse(text)
    assert formula.constant() == value
    assert formula.is_number == (value is not None)


@pytest.mark.parametrize(
    ("text", "mapping", "result"),
    [
        ("a*b + sin(a)", {"a": "alpha"}, "alpha*b + sin(alpha)"),
        ("a - b", {"a": "b", "b": "a"}, "b - a"),  # at once
        ("ab + a + b_a", {"a": "x"}, "ab + x + b_a"),
        ("max(max, a)", {"max": "m", "a": "max"}, "max(m, max)"),
        ("  a **  2", {"a": "sin"}, "  sin **  2"),
        ("a", {"a": "u\N{COMBINING DIAERESIS}"}, "ü"),
    ],
)
def test_renamed(text: str, mapping: dict[str, str], result: str) -> None:
    renamed = parse(text).rename(mapping)
    assert renamed.text == result
    assert renamed == parse(result)


def test_renaming_nothing_changes_nothing() -> None:
    formula = parse("a + 1")
    assert formula.rename({"b": "c"}) is formula
    assert formula.rename({}) is formula


@pytest.mark.parametrize(
    "name", ["", "1x", "a b", "if", "not", "x" * 129, "a.b", "\N{RIGHT-TO-LEFT OVERRIDE}"]
)
def test_new_names_must_be_names(name: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        parse("a + 1").rename({"a": name})
    (problem,) = caught.value.problems
    assert problem.code == "expression.name"
    assert "letters, digits and _" in problem.why
    assert problem.fix


# --- on the graph -----------------------------------------------------------------------------

EXACT: dict[int, Callable[..., Fraction | bool]] = {
    opcodes.NEG: operator.neg, opcodes.ADD: operator.add, opcodes.SUB: operator.sub,
    opcodes.MUL: operator.mul, opcodes.DIV: operator.truediv, opcodes.POW: operator.pow,
    opcodes.ABS: abs, opcodes.MIN: min, opcodes.MAX: max,
    opcodes.SIGN: lambda a: Fraction((a > 0) - (a < 0)), opcodes.FLOOR: lambda a: Fraction(math.floor(a)),
    opcodes.LT: operator.lt, opcodes.LE: operator.le, opcodes.EQ: operator.eq, opcodes.NOT: operator.not_,
    opcodes.AND: lambda a, b: a and b, opcodes.OR: lambda a, b: a or b,
    opcodes.SELECT: lambda c, a, b: a if c else b,
}  # fmt: skip
# math's own functions: one operation on the graph is one call, so they agree to the last bit.
FLOATS: dict[int, Callable[..., float]] = {
    getattr(opcodes, name.upper()): getattr(math, name)
    for name in (
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "sinh",
        "cosh",
        "tanh",
        "exp",
        "log",
        "sqrt",
    )
}


def value_of(graph: Graph, root: int, symbols: dict[str, Fraction]) -> Fraction | float:
    """Evaluate a node: exactly as long as its operations allow it."""
    values: dict[int, Fraction | float] = {}
    for node in graph.reachable([root]):
        op = graph.ops[node]
        if op in (opcodes.RATIONAL, opcodes.FLOAT):
            value = graph.constants[graph.left[node]]
            values[node] = value if isinstance(value, float) else Fraction(value)
        elif op == opcodes.SYMBOL:
            values[node] = symbols[graph.symbols[graph.left[node]].name]
        elif op == opcodes.PI:
            values[node] = math.pi
        else:
            operands = [values[k] for k in graph.operands(node)]
            values[node] = FLOATS[op](*operands) if op in FLOATS else EXACT[op](*operands)
    return values[root]


SYMBOLS = {"x": Fraction(3, 2), "y": Fraction(-2, 3), "z": Fraction(5), "t": Fraction(-7, 4)}


def evaluated(text: str, symbols: dict[str, Fraction] | None = None) -> Fraction | float:
    graph = Graph()
    root = build(
        parse(text), graph, lambda name, _: graph.pi() if name == "pi" else graph.symbol(Symbol(name))
    )
    return value_of(graph, root, SYMBOLS if symbols is None else symbols)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("x + y*z", Fraction(3, 2) - Fraction(10, 3)),
        ("-x^2", Fraction(-9, 4)),
        ("x**-2", Fraction(4, 9)),
        ("max(x, y, z, t) - min(x, y, z, t)", Fraction(27, 4)),
        ("sign(y) + floor(t)", -3),
        ("mod(t, 1)", Fraction(1, 4)),
        ("mod(t, -1)", Fraction(-3, 4)),  # the sign of the divisor, as in Python
        ("if(x > y, 1, 2)", 1),
        ("if(x >= x and not x != x, 1, 2)", 1),
        ("if(x < y or y > z, 1, 2)", 2),
        ("if(x <= 1.5, 1, 2)", 1),
        ("if(x == 1.5, 1, 2)", 1),
        ("0.1 + 0.2", Fraction(3, 10)),
        ("0", 0),
    ],
)
def test_values(text: str, value: Fraction) -> None:
    assert evaluated(text) == value


@pytest.mark.parametrize(
    "name", ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt"]
)
def test_functions_are_those_of_the_same_name(name: str) -> None:
    assert evaluated(f"{name}(a)", {"a": Fraction(1, 3)}) == getattr(math, name)(Fraction(1, 3))


def test_two_argument_arctangent_takes_y_first() -> None:
    assert evaluated("atan2(x, y)") == math.atan2(Fraction(3, 2), Fraction(-2, 3))


def test_degrees() -> None:
    # 30*pi/180 is the product of the exact 1/6 and pi: one rounding of 1/6 * pi.
    assert evaluated("30 deg") == Fraction(1, 6) * math.pi
    assert evaluated("sin(pi/6)") == Fraction(1, 2)


@pytest.mark.parametrize("x", [-1, 0, Fraction(1, 4), 1, Fraction(3, 2), 2, 3])
def test_smooth_step(x: Fraction) -> None:
    s = min(max(Fraction(x) / 2, Fraction(0)), Fraction(1))
    assert evaluated("smoothstep(x, 0, 2)", {"x": Fraction(x)}) == 3 * s**2 - 2 * s**3


@pytest.mark.parametrize(
    ("x", "value"),
    [(-9, 10), (0, 10), (Fraction(1, 2), 15), (1, 20), (2, 10), (Fraction(5, 2), 5), (3, 0), (9, 0)],
)
@pytest.mark.parametrize("knots", ["0, 10, 1, 20, 3, 0", "x1, y1, x2, y2, x3, y3"])
def test_interpolation_is_linear_between_and_constant_beyond(
    x: Fraction, value: Fraction, knots: str
) -> None:
    symbols = {"x": x, "x1": 0, "y1": 10, "x2": 1, "y2": 20, "x3": 3, "y3": 0}
    assert evaluated(f"interp1(x, {knots})", {name: Fraction(v) for name, v in symbols.items()}) == value


def test_interpolation_hands_on_nan() -> None:
    graph = Graph()
    root = build(parse("interp1(x, 0, 10, 1, 20, 3, 0)"), graph, lambda name, _: graph.symbol(Symbol(name)))
    values: dict[int, float] = {}
    for node in graph.reachable([root]):
        op, operands = graph.ops[node], [values[k] for k in graph.operands(node)]
        if op == opcodes.RATIONAL:
            values[node] = float(graph.constants[graph.left[node]])
        else:
            values[node] = math.nan if op == opcodes.SYMBOL else EXACT[op](*operands)
    assert math.isnan(values[root])


Part = tuple[str, Fraction | None]


def apply_part(template: str, rule: Callable[..., Fraction], *parts: Part) -> Part:
    """Join texts by a template and values by a rule; None where there is a division by zero."""
    texts, values = zip(*parts, strict=True)
    try:
        value = None if None in values else rule(*values)
    except ZeroDivisionError:
        value = None
    return template.format(*texts), value


def clamped(x: Fraction, high: int) -> Fraction:
    return min(max(x, Fraction(0)), Fraction(high))


def mixture(parts: st.SearchStrategy[Part]) -> st.SearchStrategy[Part]:
    """Texts of one operation more, with their exact values by Python's own arithmetic."""
    rules: list[tuple[str, Callable[..., Fraction]]] = [
        ("({}+{})", operator.add), ("({}-{})", operator.sub), ("({}*{})", operator.mul),
        ("({}/{})", operator.truediv), ("(-{})", operator.neg), ("({})**3", lambda a: a**3),
        ("({})**-2", lambda a: 1 / (a * a)),
        ("min({},{},{})", min), ("max({},{})", max), ("abs({})", abs),
        ("sign({})", lambda a: Fraction((a > 0) - (a < 0))),
        ("floor({})", lambda a: Fraction(math.floor(a))),
        ("mod({},{})", operator.mod),
        ("if({}<{} and {}!={},{},{})", lambda a, b, c, d, e, f: e if a < b and c != d else f),
        ("if(not {}>={} or {}=={},{},{})", lambda a, b, c, d, e, f: e if not a >= b or c == d else f),
        ("smoothstep({},0,2)", lambda a: 3 * clamped(a / 2, 1) ** 2 - 2 * clamped(a / 2, 1) ** 3),
        ("interp1({},0,{},2,{})", lambda a, b, c: b + (c - b) * clamped(a, 2) / 2),
    ]  # fmt: skip
    return st.one_of(
        *(
            st.builds(apply_part, st.just(template), st.just(rule), *[parts] * template.count("{}"))
            for template, rule in rules
        )
    )


LEAVES = st.one_of(
    st.sampled_from([(name, value) for name, value in SYMBOLS.items()]),
    st.decimals(0, 10, places=2).map(lambda d: (str(d), Fraction(d))),
)


@settings(max_examples=500)  # under a second
@given(st.recursive(LEAVES, mixture, max_leaves=12))
def test_random_programs_have_pythons_values(part: Part) -> None:
    """Rational arithmetic on both sides, so equality is exact."""
    text, value = part
    assume(value is not None)
    try:
        found = evaluated(text)
    except ExpressionError as error:  # an exponent or a divisor that is too large or vanishes as written
        assume("expression.constant_range" not in {p.code for p in error.problems})
        raise
    assert found == value


def test_names_are_looked_up_once_with_their_column() -> None:
    calls: list[tuple[str, int]] = []
    graph = Graph()

    def lookup(name: str, column: int) -> int:
        calls.append((name, column))
        return graph.symbol(Symbol(name))

    build(parse("b*a + a*b"), graph, lookup)
    assert calls == [("b", 1), ("a", 3)]


def test_a_look_up_that_fails_can_point_into_the_text() -> None:
    formula = parse("k*lenght")

    def lookup(name: str, column: int) -> int:
        if name == "k":
            return 1
        raise ExpressionError(
            formula.problem(
                "model.unknown_name", column, f"{name!r} is unknown", "a slip", "k", where="spring S"
            )
        )

    with pytest.raises(ExpressionError) as caught:
        build(formula, Graph(), lookup)
    assert caught.value.problems == (
        Problem(
            "model.unknown_name",
            "spring S, column 3",
            "'lenght' is unknown\n    k*lenght\n      ^",
            "a slip",
            "k",
        ),
    )


def test_a_division_by_what_turns_out_zero_is_placed() -> None:
    graph = Graph()
    with pytest.raises(ExpressionError) as caught:
        build(parse("1 + x/(a - b)"), graph, lambda name, _: graph.constant(2), where="spring S")
    (problem,) = caught.value.problems
    assert problem.code == "expression.division_by_zero"
    assert problem.where == "spring S, column 6"
    assert problem.why and problem.fix


def test_long_and_deep_programs_build_without_recursion() -> None:
    graph = Graph()
    names = itertools.cycle(f"x{k}" for k in range(7))
    text = "+".join(f"{next(names)}*{k}.5" for k in range(3000)) + "+max(" + ",".join(["y", "z"] * 1500) + ")"
    text += "-" + "sin(" * 199 + "y" + ")" * 199
    root = build(parse(text), graph, lambda name, _: graph.symbol(Symbol(name)))
    assert root == len(graph) - 1


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("if(1 > 1, 1/(1 - 1), 0)", 0.0),
        ("if(2 > 1, x, log(0))", 3.0),
        ("if(1 > 2, sqrt(-1), 2)*x", 6.0),
        ("if(not 1 > 2 and 1 != 2, 5, mod(x, 0))", 5.0),
        ("if(2 > 1, x, 1/(y - y))", 3.0),  # seen to be zero in the graph alone
        ("if(1 > 2, if(x > 1, 1/0, 2), 7)", 7.0),
    ],
)
def test_a_branch_that_numbers_never_choose_needs_no_value(text: str, value: float) -> None:
    graph = Graph()
    symbols = {name: graph.symbol(Symbol(name)) for name in "xy"}
    node = build(parse(text), graph, lambda name, column: symbols[name])
    known = {symbols["x"]: graph.constant(3), symbols["y"]: graph.constant(4)}
    assert graph.number(substitute(graph, [node], known)[0]) == value


def test_a_branch_that_may_be_chosen_needs_a_value() -> None:
    graph = Graph()
    symbols = {name: graph.symbol(Symbol(name)) for name in "xy"}
    with pytest.raises(ExpressionError, match=r"part, column 15: an expression is divided by the constant 0"):
        build(parse("if(x > 1, y, 1/(y - y))"), graph, lambda name, column: symbols[name], where="part")
