"""Arithmetic of any precision, in which sequences are evaluated as the reference of the reference."""

from __future__ import annotations

from fractions import Fraction
from typing import Final

import mpmath

from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import LOGIC, NAMED, Arithmetic, sign

MPMATH: Final = Arithmetic(
    constant=lambda value: (
        mpmath.mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mpmath.mpf(value)
    ),
    pi=lambda: +mpmath.pi,
    functions=LOGIC
    | {code: getattr(mpmath, name) for code, name in NAMED.items()}
    | {
        op.DIV: lambda a, b: a / b,
        op.POW: mpmath.power,
        op.SIGN: lambda a: mpmath.mpf(sign(a)),
        op.ATAN2: mpmath.atan2,
        op.FLOOR: mpmath.floor,
        op.FMA: lambda a, b, c: a * b + c,
    },
    sqrt=mpmath.sqrt,
)
