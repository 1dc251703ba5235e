"""Powers as products, constants as doubles."""

from __future__ import annotations

from fractions import Fraction

import pytest

from symbody.codegen.lowering import double_bits, power_products, rounded, whole_exponent
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.evaluate import whole_power
from symbody.expr.rewrite import multiplications
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
    assert values[-1] == whole_power(1.1, exponent)


def test_which_exponents_are_whole() -> None:
    for exponent, expected in ((2, 2), (1, 1), (0, None), (-2, None), (2.0, None), (Fraction(1, 2), None)):
        assert whole_exponent(single(op.POW, 1, exponent), 1) == expected
    assert whole_exponent(single(op.POW, 2), 1) is None


def test_rounding_is_to_the_nearest() -> None:
    assert rounded(2**53 + 1) == 2.0**53
    assert rounded(Fraction(2**54 + 3, 2)) == 2.0**53 + 2
    assert rounded(Fraction(-1, 3)) == -1 / 3
    assert rounded(0.1) == 0.1
    with pytest.raises(CompileError, match="309 digits is too large"):
        rounded(Fraction(2**1024 * 3 + 1, 3))


def test_bits() -> None:
    assert double_bits(1.0) == 0x3FF0000000000000
    assert double_bits(-0.0) == 1 << 63
