"""The operations of a formula, made of the operations of the graph."""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType
from typing import Final

from symbody.expr import canonical
from symbody.expr.graph import Graph
from symbody.expr.opcodes import (
    ABS,
    ACOS,
    AND,
    ASIN,
    ATAN,
    ATAN2,
    COS,
    COSH,
    EQ,
    EXP,
    FLOOR,
    LE,
    LOG,
    LT,
    MAX,
    MIN,
    NOT,
    OR,
    SIGN,
    SIN,
    SINH,
    SQRT,
    TAN,
    TANH,
)

_OPCODES: Final = MappingProxyType(
    {
        "sin": SIN, "cos": COS, "tan": TAN, "asin": ASIN, "acos": ACOS, "atan": ATAN, "atan2": ATAN2,
        "sinh": SINH, "cosh": COSH, "tanh": TANH, "exp": EXP, "log": LOG, "sqrt": SQRT, "abs": ABS,
        "sign": SIGN, "floor": FLOOR, "min": MIN, "max": MAX, "lt": LT, "le": LE, "eq": EQ,
        "and": AND, "or": OR, "not": NOT,
    }
)  # fmt: skip


def applied_node(g: Graph, name: str, operands: list[int]) -> int:
    """Return the node of the operation `name` of a formula."""
    opcode = _OPCODES.get(name)
    if opcode is not None:
        return canonical.apply(g, opcode, *operands)
    return _RULES[name](g, *operands)


def modulo(g: Graph, a: int, b: int) -> int:
    """Return ``a - b*floor(a/b)``, which has the sign of `b`."""
    return canonical.sub(g, a, canonical.mul(g, b, canonical.apply(g, FLOOR, canonical.div(g, a, b))))


def smooth_step(g: Graph, x: int, start: int, end: int) -> int:
    """Return the cubic that rises from 0 at `start` to 1 at `end`, constant beyond, slope continuous."""
    share = canonical.div(g, canonical.sub(g, x, start), canonical.sub(g, end, start))
    s = canonical.apply(g, MIN, canonical.apply(g, MAX, share, canonical.ZERO), canonical.ONE)
    rest = canonical.sub(g, g.constant(3), canonical.mul(g, canonical.TWO, s))
    return canonical.mul(g, canonical.mul(g, s, s), rest)


def interpolation(g: Graph, x: int, *knots: int) -> int:
    """Return the polygon through the points ``x1, y1, x2, y2, ...``, constant beyond its ends.

    The places must increase; the parser checks those that are numbers.
    """
    places, values = knots[::2], knots[1::2]
    # The innermost choice is a segment, not an end value: a NaN fails every comparison and has to
    # come out as NaN.
    result = _segment(g, x, places[-2:], values[-2:])
    for k in range(len(places) - 3, -1, -1):
        inside = canonical.apply(g, LT, x, places[k + 1])
        result = canonical.select(g, inside, _segment(g, x, places[k : k + 2], values[k : k + 2]), result)
    result = canonical.select(g, canonical.apply(g, LE, places[-1], x), values[-1], result)
    return canonical.select(g, canonical.apply(g, LT, x, places[0]), values[0], result)


def _segment(g: Graph, x: int, places: tuple[int, ...], values: tuple[int, ...]) -> int:
    rise = canonical.sub(g, values[1], values[0])
    slope = canonical.div(g, rise, canonical.sub(g, places[1], places[0]))
    return canonical.add(g, values[0], canonical.mul(g, slope, canonical.sub(g, x, places[0])))


def _greater(g: Graph, a: int, b: int) -> int:
    return canonical.apply(g, LT, b, a)


def _not_less(g: Graph, a: int, b: int) -> int:
    return canonical.apply(g, LE, b, a)


def _unequal(g: Graph, a: int, b: int) -> int:
    return canonical.apply(g, NOT, canonical.apply(g, EQ, a, b))


_RULES: Final = MappingProxyType[str, Callable[..., int]](
    {
        "add": canonical.add, "sub": canonical.sub, "mul": canonical.mul, "div": canonical.div,
        "neg": canonical.neg, "power": canonical.power, "if": canonical.select, "mod": modulo,
        "smoothstep": smooth_step, "interp1": interpolation, "gt": _greater, "ge": _not_less, "ne": _unequal,
    }
)  # fmt: skip
