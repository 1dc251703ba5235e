"""Sine and cosine as LLVM code, the same instructions for one number and for lanes.

``llvm.sin`` of a vector becomes one library call per lane, and results then depend on the library.
Here: reduction by pi/2 held in three parts, two polynomials, a swap and a sign. Errors stay below
1.5 ulp (largest seen: 0.78) for |x| <= 1e5, the doubles next to multiples of pi/2 included. Beyond that,
and for inf and nan, the scalar function calls the C library.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

from llvmlite import ir

SINCOS_NAME: Final = "symbody_sincos"

RANGE: Final = 1e5  # k = x / (pi/2) has then at most 16 bits

# pi/2 = HIGH + MIDDLE + LOW + 2e-44. HIGH has 53 bits: x - k HIGH is a multiple of 2**-53 below 1,
# hence exact with one fma. MIDDLE has 36 bits: k MIDDLE (16 + 36 bits) is exact.
HIGH: Final = float.fromhex("0x1.921fb54442d18p+0")
MIDDLE: Final = float.fromhex("0x1.1a62633140000p-54")
LOW: Final = float.fromhex("0x1.701b839a25205p-92")
TWO_OVER_PI: Final = float.fromhex("0x1.45f306dc9c883p-1")
# Adding 1.5 * 2**52 rounds to the nearest integer and leaves it in the low bits of the mantissa.
ROUNDER: Final = 1.5 * 2.0**52

# Minimax fits in z = r**2 on |r| <= pi/4 (1 + 1e-9): weighted Remez exchange in 240-bit arithmetic,
# rounding one coefficient at a time, lowest order first, and refitting those that remain.
# sin r = r + r**3 P(z), relative error 2**-57.9 of sin r.
SIN_COEFFICIENTS: Final = tuple(
    float.fromhex(text)
    for text in (
        "-0x1.5555555555548p-3",
        "0x1.111111110f730p-7",
        "-0x1.a01a019be9217p-13",
        "0x1.71de35552b4c6p-19",
        "-0x1.ae5e4b83d705ap-26",
        "0x1.5d8b558def5bcp-33",
    )
)
# cos r = 1 - z/2 + z**2 Q(z), relative error 2**-63.9 of cos r.
COS_COEFFICIENTS: Final = tuple(
    float.fromhex(text)
    for text in (
        "0x1.555555555554bp-5",
        "-0x1.6c16c16c15015p-10",
        "0x1.a01a019c8f255p-16",
        "-0x1.27e4f7f191631p-22",
        "0x1.1ee9dbcf185d1p-29",
        "-0x1.8fa6849b94c82p-37",
    )
)


class Reduced(NamedTuple):
    """x = k pi/2 + (rest + tail), |rest| <= pi/4, `tail` below one ulp of `rest`."""

    rest: ir.Value
    tail: ir.Value
    quadrant: ir.Value  # integers whose two lowest bits are those of k


def define_sincos(module: ir.Module) -> ir.Function:
    """Define ``{double, double} symbody_sincos(double)`` in `module`, once.

    There is no function for one of the two alone: choosing the polynomial by quadrant without a
    branch takes both anyway.
    """
    pair = ir.LiteralStructType((ir.DoubleType(), ir.DoubleType()))
    known = module.globals.get(SINCOS_NAME)
    if known is not None:
        return known
    function = ir.Function(module, ir.FunctionType(pair, (ir.DoubleType(),)), SINCOS_NAME)
    x = function.args[0]
    builder, outside = _branch_on_range(function)
    _return_pair(builder, *sine_cosine(builder, x))
    _return_pair(
        outside, *(outside.call(_function(module, name, x.type, 1), (x,)) for name in ("sin", "cos"))
    )
    return function


def define_lane_sincos(module: ir.Module, name: str, width: int) -> ir.Function:
    """Define ``{v, v} name(v)`` where v is a vector of `width` doubles: the bits of `define_sincos`."""
    scalar = define_sincos(module)
    vector = ir.VectorType(ir.DoubleType(), width)
    function = ir.Function(module, ir.FunctionType(ir.LiteralStructType((vector, vector)), (vector,)), name)
    x = function.args[0]
    builder, outside = _branch_on_range(function)
    _return_pair(builder, *sine_cosine(builder, x))
    sines = cosines = ir.Constant(vector, ir.Undefined)
    for lane in range(width):
        place = ir.Constant(ir.IntType(32), lane)
        pair = outside.call(scalar, (outside.extract_element(x, place),))
        sines = outside.insert_element(sines, outside.extract_value(pair, 0), place)
        cosines = outside.insert_element(cosines, outside.extract_value(pair, 1), place)
    _return_pair(outside, sines, cosines)
    return function


def sine_cosine(builder: ir.IRBuilder, x: ir.Value) -> tuple[ir.Value, ir.Value]:
    """Emit sin and cos of `x`, a double or a vector of doubles with |x| <= RANGE in every lane."""
    parts = _reduce(builder, x)
    sine, cosine = _sine_polynomial(builder, parts), _cosine_polynomial(builder, parts)
    one = constant(parts.quadrant.type, 1)
    odd = builder.trunc(parts.quadrant, integers_like(x.type, 1))
    sine_x = _flip_sign(builder, builder.select(odd, cosine, sine), parts.quadrant)
    cosine_x = _flip_sign(builder, builder.select(odd, sine, cosine), builder.add(parts.quadrant, one))
    # sin(-0.0) is -0.0: adding the tail, +0.0, has lost the sign.
    is_zero = builder.fcmp_ordered("==", x, constant(x.type, 0.0))
    return builder.select(is_zero, x, sine_x), cosine_x


def fma(builder: ir.IRBuilder, a: ir.Value, b: ir.Value, c: ir.Value) -> ir.Value:
    """Emit a * b + c rounded once; a library call where the processor has no such instruction."""
    lanes = f"v{a.type.count}" if isinstance(a.type, ir.VectorType) else ""
    return builder.call(_function(builder.module, f"llvm.fma.{lanes}f64", a.type, 3), (a, b, c))


def constant(kind: ir.Type, value: float) -> ir.Constant:
    """Return `value` as a constant of a scalar type, or in every lane of a vector type."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [value] * kind.count)
    return ir.Constant(kind, value)


def integers_like(kind: ir.Type, bits: int = 64) -> ir.Type:
    """Return the integer type of `bits` bits with as many lanes as `kind`."""
    if isinstance(kind, ir.VectorType):
        return ir.VectorType(ir.IntType(bits), kind.count)
    return ir.IntType(bits)


def _branch_on_range(function: ir.Function) -> tuple[ir.IRBuilder, ir.IRBuilder]:
    """Branch on |x| <= RANGE in every lane, false for nan; return builders of the inner and outer block."""
    entry = ir.IRBuilder(function.append_basic_block("entry"))
    inside, outside = function.append_basic_block("inside"), function.append_basic_block("outside")
    x = function.args[0]
    lanes = x.type.count if isinstance(x.type, ir.VectorType) else 0
    size = entry.call(
        _function(function.module, f"llvm.fabs.{f'v{lanes}' if lanes else ''}f64", x.type, 1), (x,)
    )
    is_small = entry.fcmp_ordered("<=", size, constant(x.type, RANGE))
    if lanes:
        mask = entry.bitcast(is_small, ir.IntType(lanes))
        is_small = entry.icmp_unsigned("==", mask, ir.Constant(mask.type, 2**lanes - 1))
    entry.cbranch(is_small, inside, outside)
    return ir.IRBuilder(inside), ir.IRBuilder(outside)


def _function(module: ir.Module, name: str, kind: ir.Type, count: int) -> ir.Function:
    """Return the function `name` of `count` arguments of type `kind`, declaring it once."""
    known = module.globals.get(name)
    return known or ir.Function(module, ir.FunctionType(kind, (kind,) * count), name)


def _return_pair(builder: ir.IRBuilder, first: ir.Value, second: ir.Value) -> None:
    pair = ir.Constant(builder.function.return_value.type, ir.Undefined)
    builder.ret(builder.insert_value(builder.insert_value(pair, first, 0), second, 1))


def _reduce(builder: ir.IRBuilder, x: ir.Value) -> Reduced:
    shifted = fma(builder, x, constant(x.type, TWO_OVER_PI), constant(x.type, ROUNDER))
    minus_k = builder.fsub(constant(x.type, ROUNDER), shifted)
    first = fma(builder, minus_k, constant(x.type, HIGH), x)
    middle = builder.fmul(minus_k, constant(x.type, MIDDLE))
    rest = builder.fadd(first, middle)
    # Fast two-sum is exact: either |first| >= |middle|, or both are multiples of 2**-89 below 2**-37
    # and nothing was rounded.
    lost = builder.fadd(builder.fsub(first, rest), middle)
    tail = fma(builder, minus_k, constant(x.type, LOW), lost)
    return Reduced(rest, tail, builder.bitcast(shifted, integers_like(x.type)))


def _sine_polynomial(builder: ir.IRBuilder, parts: Reduced) -> ir.Value:
    r, tail = parts.rest, parts.tail
    z = builder.fmul(r, r)
    # sin(r + tail) = sin r + tail cos r, with cos r = 1 - z/2 to the accuracy a tail needs.
    correction = fma(builder, builder.fmul(z, constant(r.type, -0.5)), tail, tail)
    cubic = fma(builder, builder.fmul(z, r), _horner(builder, z, SIN_COEFFICIENTS), correction)
    return builder.fadd(r, cubic)


def _cosine_polynomial(builder: ir.IRBuilder, parts: Reduced) -> ir.Value:
    r, tail = parts.rest, parts.tail
    one = constant(r.type, 1.0)
    z = builder.fmul(r, r)
    half = builder.fmul(z, constant(r.type, 0.5))
    start = builder.fsub(one, half)
    lost = builder.fsub(builder.fsub(one, start), half)  # what rounding took from 1 - z/2, exactly
    # cos(r + tail) = cos r - tail sin r, with sin r = r.
    correction = fma(builder, builder.fneg(r), tail, lost)
    quartic = fma(builder, builder.fmul(z, z), _horner(builder, z, COS_COEFFICIENTS), correction)
    return builder.fadd(start, quartic)


def _horner(builder: ir.IRBuilder, z: ir.Value, coefficients: Sequence[float]) -> ir.Value:
    value = constant(z.type, coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        value = fma(builder, value, z, constant(z.type, coefficient))
    return value


def _flip_sign(builder: ir.IRBuilder, value: ir.Value, quadrant: ir.Value) -> ir.Value:
    """Change the sign where bit 1 of `quadrant` is set."""
    second_bit = builder.and_(quadrant, constant(quadrant.type, 2))
    sign = builder.shl(second_bit, constant(quadrant.type, 62))
    return builder.bitcast(builder.xor(builder.bitcast(value, sign.type), sign), value.type)
