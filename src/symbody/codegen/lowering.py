"""What every compiled language does alike: constants, whole powers, and what it refuses."""

from __future__ import annotations

import math
import struct

from symbody.errors import CompileError, Problem
from symbody.expr.graph import Constant
from symbody.expr.opcodes import CALL, FLOAT, PI, RATIONAL
from symbody.expr.sequences.sequence import Sequence


def round_to_double(constant: Constant) -> float:
    """Return the double nearest to `constant`.

    Raises
    ------
    CompileError
        If it lies beyond the largest double.
    """
    try:
        return float(constant)
    except OverflowError:
        digits = len(str(abs(int(constant))))
        raise CompileError(
            Problem("compile.large_constant", "", f"a constant of {digits} digits is too large for a double",
                    "an integer power or a product of exact numbers grew beyond 1e308",
                    "write one of its factors as a decimal number, or change the units")
        ) from None  # fmt: skip


def double_bits(value: float) -> int:
    """Return the 64 bits of `value`."""
    (bits,) = struct.unpack("<Q", struct.pack("<d", value))
    return int(bits)


def constant_values(sequence: Sequence) -> dict[int, float]:
    """Return the values that are constants, pi included, as doubles."""
    values: dict[int, float] = {}
    for k, operation in enumerate(sequence.operations):
        if operation.op in (RATIONAL, FLOAT):
            values[k] = round_to_double(sequence.constants[operation.datum])
        elif operation.op == PI:
            values[k] = math.pi
    return values


def integer_exponent(sequence: Sequence, value: int) -> int | None:
    """Return the exponent of a POW if it is a constant integer >= 1, else None.

    Other exponents go to the library's pow.
    """
    exponent = sequence.constant_value(value)
    return exponent if isinstance(exponent, int) and exponent >= 1 else None


def power_products(exponent: int) -> list[tuple[int, int]]:
    """Return the products of square-and-multiply, from the lowest bit of `exponent` up.

    Product k multiplies two earlier ones, counted from 1; 0 is the base. The last one is the power.
    All languages multiply in this order, so all give the same bits.

    >>> power_products(5)
    [(0, 0), (1, 1), (0, 2)]
    """
    products: list[tuple[int, int]] = []
    result: int | None = None
    square = 0
    while True:
        if exponent & 1:
            if result is None:
                result = square
            else:
                products.append((result, square))
                result = len(products)
        exponent >>= 1
        if not exponent:
            return products
        products.append((square, square))
        square = len(products)


def refuse_user_functions(sequence: Sequence) -> None:
    """Raise CompileError if `sequence` calls functions the user supplied, naming all of them."""
    called = {operation.datum for operation in sequence.operations if operation.op == CALL}
    names = sorted(sequence.functions[k].name for k in called)
    if names:
        raise CompileError(
            Problem("compile.user_function", "", f"compiled code cannot call {', '.join(names)}",
                    "tables and Python functions have no compiled form",
                    "replace each by a formula, or give its value as an input")
        )  # fmt: skip
