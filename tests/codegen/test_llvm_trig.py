"""Accuracy of our sine and cosine against 40 digits, and the cases a formula forgets."""

from __future__ import annotations

import ctypes
import math
import platform
import random
from collections.abc import Iterable, Iterator
from fractions import Fraction

import llvmlite.binding as binding
import mpmath
import pytest
from llvmlite import ir

from symbody.codegen.llvm.loops import INTEGER, POINTER, REAL, count, integer
from symbody.codegen.llvm.trig import (
    COS_COEFFICIENTS,
    HIGH,
    LOW,
    MIDDLE,
    RANGE,
    SIN_COEFFICIENTS,
    define_sincos,
    sine_cosine,
)

LAST_MULTIPLE = 63662  # of pi/2 below 1e5
BOUND = 1.5  # ulp, promised

Pair = tuple[list[float], list[float]]


class Circle:
    """Calls ``void circle(count, x, sin, cos)`` of a module."""

    def __init__(self, module: ir.Module, cpu: str = "", features: str = "") -> None:
        binding.initialize_native_target()
        binding.initialize_native_asmprinter()
        machine = binding.Target.from_default_triple().create_target_machine(
            cpu or binding.get_host_cpu_name(),
            features or binding.get_host_cpu_features().flatten(),
            opt=1,
            jit=True,
        )
        parsed = binding.parse_assembly(str(module))
        parsed.verify()
        self.assembly = machine.emit_assembly(parsed)
        self.engine = binding.create_mcjit_compiler(parsed, machine)
        self.engine.finalize_object()
        signature = ctypes.CFUNCTYPE(None, ctypes.c_int64, *[ctypes.c_void_p] * 3)
        self.function = signature(self.engine.get_function_address("circle"))

    def __call__(self, points: list[float]) -> Pair:
        kind = ctypes.c_double * len(points)
        x, sines, cosines = kind(*points), kind(), kind()
        self.function(len(points), x, sines, cosines)
        return list(sines), list(cosines)


def circle_module(element: ir.Type) -> ir.Module:
    """Return a module whose `circle` walks over numbers, or over groups of lanes without the guard."""
    module = ir.Module()
    void = ir.FunctionType(ir.VoidType(), [INTEGER, POINTER, POINTER, POINTER])
    scalar = define_sincos(module)
    function = ir.Function(module, void, "circle")
    b = ir.IRBuilder(function.append_basic_block())
    size, x, sines, cosines = function.args
    lanes = 1 if element is REAL else element.count
    with count(b, integer(0), b.sdiv(size, integer(lanes))) as k:
        place = b.mul(k, integer(lanes))
        source, *targets = (b.gep(array, [place], source_etype=REAL) for array in (x, sines, cosines))
        value = b.load(source, align=8, typ=element)
        if element is REAL:
            pair = b.call(scalar, [value])
            results = (b.extract_value(pair, 0), b.extract_value(pair, 1))
        else:
            results = sine_cosine(b, value)
        for target, result in zip(targets, results, strict=True):
            b.store(result, target, align=8)
    b.ret_void()
    return module


@pytest.fixture(scope="module")
def circle() -> Circle:
    return Circle(circle_module(REAL))


def worst_errors(circle: Circle, points: list[float]) -> tuple[float, float]:
    """Return the largest errors of sin and cos in units of the last place of the exact value."""
    worst = [0.0, 0.0]
    with mpmath.workprec(140):  # 53 digits of the result survive the 2**-61 of the nearest multiple
        for x, *ours in zip(points, *circle(points), strict=True):
            exact = mpmath.mpf(x)
            for k, function in enumerate((mpmath.sin, mpmath.cos)):
                value = function(exact)
                error = abs(mpmath.mpf(ours[k]) - value) / math.ulp(float(value))
                worst[k] = max(worst[k], float(error))
    return worst[0], worst[1]


def neighbours_of_multiples(step: int) -> Iterator[float]:
    """Yield the doubles around k pi/2."""
    with mpmath.workprec(120):
        quarter = mpmath.pi / 2
        for k in range(1, LAST_MULTIPLE + 1, step):
            nearest = float(k * quarter)
            yield from (math.nextafter(nearest, 0.0), nearest, -math.nextafter(nearest, math.inf))


def samples(size: int) -> Iterable[float]:
    source = random.Random(20)
    for _ in range(size):
        yield source.uniform(-RANGE, RANGE)
        yield source.uniform(-7.0, 7.0)
        yield source.choice((-1.0, 1.0)) * 10.0 ** source.uniform(-9.0, 5.0)
    for _ in range(size // 4):
        yield 10.0 ** source.uniform(-320.0, -8.0)


def test_errors_stay_below_the_promise(circle: Circle) -> None:
    points = [*samples(4000), *neighbours_of_multiples(13), RANGE, -RANGE]
    assert len(points) > 20_000
    assert max(worst_errors(circle, points)) < BOUND


@pytest.mark.exhaustive
def test_errors_stay_below_the_promise_at_a_million_points(circle: Circle) -> None:
    points = [*samples(260_000), *neighbours_of_multiples(1)]
    assert len(points) > 1_000_000
    errors = worst_errors(circle, points)
    print("largest errors of sin and cos [ulp]:", *errors)
    assert max(errors) < BOUND


def test_parts_of_half_pi() -> None:
    with mpmath.workprec(300):
        parts = mpmath.mpf(HIGH) + mpmath.mpf(MIDDLE) + mpmath.mpf(LOW)
        # k of 16 bits times the remainder must not reach 2**-53 of 2**-61, the nearest any double comes.
        assert abs(parts - mpmath.pi / 2) * LAST_MULTIPLE < mpmath.mpf(2) ** -114
    middle = Fraction(MIDDLE)
    for k in range(1, LAST_MULTIPLE + 1):
        assert Fraction(k * MIDDLE) == k * middle  # exact


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_polynomials_are_as_near_as_their_comments_say(name: str) -> None:
    with mpmath.workprec(200):
        worst = mpmath.mpf(0)
        for k in range(1, 400):
            r = mpmath.pi / 4 * k / 399
            z = r * r
            if name == "sin":
                fit = r + r * z * mpmath.polyval(SIN_COEFFICIENTS[::-1], z)
            else:
                fit = 1 - z / 2 + z * z * mpmath.polyval(COS_COEFFICIENTS[::-1], z)
            worst = max(worst, abs(fit / getattr(mpmath, name)(r) - 1))
        assert worst < mpmath.mpf(2) ** (-57.8 if name == "sin" else -63.9)


def test_symmetry_and_signed_zero(circle: Circle) -> None:
    points = list(samples(500))
    sines, cosines = circle(points)
    mirrored_sines, mirrored_cosines = circle([-x for x in points])
    assert mirrored_sines == [-y for y in sines]
    assert mirrored_cosines == cosines
    zeros, ones = circle([0.0, -0.0])
    assert [math.copysign(1.0, y) for y in zeros] == [1.0, -1.0]
    assert zeros == [0.0, 0.0]
    assert ones == [1.0, 1.0]


def test_tiny_arguments(circle: Circle) -> None:
    points = [5e-324, 2.0**-1022, 1e-300, 2.0**-27]
    sines, cosines = circle(points)
    # x - x**3/6 with x**2/6 below a quarter of eps rounds to x, 1 - x**2/2 to 1.
    assert sines == points
    assert cosines == [1.0] * 4


def test_no_number_gives_no_number(circle: Circle) -> None:
    for values in circle([math.inf, -math.inf, math.nan]):
        assert all(math.isnan(y) for y in values)


def test_large_arguments_go_to_the_library(circle: Circle) -> None:
    points = [math.nextafter(RANGE, math.inf), 1e6, -1e22, 1.7e308]
    sines, cosines = circle(points)
    assert sines == [math.sin(x) for x in points]
    assert cosines == [math.cos(x) for x in points]


@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_lanes_give_the_bits_of_the_scalar(circle: Circle, lanes: int) -> None:
    points = [*samples(400), *neighbours_of_multiples(977), 0.0, -0.0]
    points = points[: len(points) // 8 * 8]
    assert Circle(circle_module(ir.VectorType(REAL, lanes)))(points) == circle(points)


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="the processor named is x86")
def test_same_bits_without_the_fma_instruction(circle: Circle) -> None:
    plain = Circle(circle_module(REAL), cpu="x86-64", features="-fma,-avx")
    assert "fmadd" not in plain.assembly
    points = [*samples(200), *neighbours_of_multiples(977)]
    assert plain(points) == circle(points)
