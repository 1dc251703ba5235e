"""Powers as products, constants as doubles."""

from __future__ import annotations

from fractions import Fraction

import pytest

from symbody.codegen.lowering import double_bits, integer_exponent, power_products, round_to_double
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.rewrite import multiplications
from symbody.expr.sequences.evaluate import integer_power
from tests.codegen.sequences import single


@pytest.mark.parametrize("exponent", [1, 2, 3, 4, 5, 6, 7, 11, 64, 100, 1023])
def test_powers_multiply_as_plain_evaluation_does(exponent: int) -> None:
    products = power_products(exponent)
    assert len(products) == multiplications(exponent)
    powers = [1]
    values = [1.1]
    for first, second in products:
        powers.append(powers[first] + powers[second])
        values.append(values[first] * values[second])
    assert powers[-1] == exponent
    assert values[-1] == integer_power(1.1, exponent)


def test_which_exponents_are_whole() -> None:
    for exponent, expected in ((2, 2), (1, 1), (0, None), (-2, None), (2.0, None), (Fraction(1, 2), None)):
        assert integer_exponent(single(op.POW, 1, exponent), 1) == expected
    assert integer_exponent(single(op.POW, 2), 1) is None


def test_rounding_is_to_the_nearest() -> None:
    assert round_to_double(2**53 + 1) == 2.0**53
    assert round_to_double(Fraction(2**54 + 3, 2)) == 2.0**53 + 2
    assert round_to_double(Fraction(-1, 3)) == -1 / 3
    assert round_to_double(0.1) == 0.1
    with pytest.raises(CompileError, match="309 digits is too large"):
        round_to_double(Fraction(2**1024 * 3 + 1, 3))


def test_bits() -> None:
    assert double_bits(1.0) == 0x3FF0000000000000
    assert double_bits(-0.0) == 1 << 63
