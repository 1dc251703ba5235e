"""The operations of the expression graph: small integers, their names, and what each costs.

Constants, signs and powers come first because the folding rules look for exactly those:
``op <= POW`` is one comparison that decides whether a rule can apply.
"""

from __future__ import annotations

from typing import Final

RATIONAL: Final = 0  # exact constant; left = index into Graph.constants
FLOAT: Final = 1  # rounded constant; left = index into Graph.constants
NEG: Final = 2
POW: Final = 3  # left ** right; right is a RATIONAL >= 2 in canonical form, or anything
ADD: Final = 4
SUB: Final = 5
MUL: Final = 6
DIV: Final = 7
SYMBOL: Final = 8  # left = index into Graph.symbols
PI: Final = 9

SIN: Final = 10
COS: Final = 11
TAN: Final = 12
ASIN: Final = 13
ACOS: Final = 14
ATAN: Final = 15
SINH: Final = 16
COSH: Final = 17
TANH: Final = 18
EXP: Final = 19
LOG: Final = 20
SQRT: Final = 21
ABS: Final = 22
SIGN: Final = 23
FLOOR: Final = 24

ATAN2: Final = 25
MIN: Final = 26
MAX: Final = 27
LT: Final = 28  # conditions: only as operands of AND, OR, NOT and of the first place of SELECT
LE: Final = 29
EQ: Final = 30
AND: Final = 31
OR: Final = 32
NOT: Final = 33

# Nodes with a tuple of operands: left = index into Graph.operand_tuples.
SELECT: Final = 34  # (condition, then, otherwise)
FMA: Final = 35  # (a, b, c): a * b + c rounded once
CALL: Final = 36  # user function: right = index into Graph.functions
SADDLE: Final = 37  # right = index into Graph.kernels; see saddle.py
PICK: Final = 38  # left = SADDLE or MAP node, right = which entry of its result
MAP: Final = 39  # right = index into Graph.programs; see program.py

NAMES: Final = (
    "rational", "float", "neg", "pow", "add", "sub", "mul", "div", "symbol", "pi",
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log", "sqrt",
    "abs", "sign", "floor", "atan2", "min", "max", "lt", "le", "eq", "and", "or", "not",
    "select", "fma", "call", "saddle", "pick", "map",
)  # fmt: skip

LEAVES: Final = frozenset({RATIONAL, FLOAT, SYMBOL, PI})
UNARY_FUNCTIONS: Final = frozenset(range(SIN, FLOOR + 1))
CONDITIONS: Final = frozenset({LT, LE, EQ, AND, OR, NOT})
MANY: Final = frozenset({SELECT, FMA, CALL, SADDLE, MAP})

# Operations counted as users count them: negation free, one for each function.
COST: Final = tuple(
    0 if op in LEAVES or op in (NEG, PICK) else 2 if op == FMA else 1 for op in range(len(NAMES))
)

# Number of operands held in left and right; -1: a tuple of operands.
ARITY: Final = tuple(
    0 if op in LEAVES else -1 if op in MANY else 1 if op in UNARY_FUNCTIONS or op in (NEG, NOT, PICK) else 2
    for op in range(len(NAMES))
)

ODD_FUNCTIONS: Final = frozenset({SIN, TAN, ASIN, ATAN, SINH, TANH, SIGN})
EVEN_FUNCTIONS: Final = frozenset({COS, COSH, ABS})
