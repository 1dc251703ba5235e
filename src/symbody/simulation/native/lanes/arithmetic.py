"""Several doubles at once, a register of them, for functions that numba compiles.

numba vectorizes only what it sees through, and sums kept in arrays cost a load and a store for every term.
These are LLVM's vectors themselves: one instruction for all lanes, each rounded as for one number alone. What
the functions say holds in compiled code; none can be called from Python.

The cache of the compiled loop does not see a change of this file: renew `cases.SOURCES` after one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

from symbody.codegen.llvm.machine import lanes

# The processor has so many in a register; numba keeps what it compiled for each kind of processor apart.
WIDTH: Final = lanes()
_VECTOR: Final = ir.VectorType(ir.DoubleType(), WIDTH)
_NUMBER: Final = 8  # bytes


# A register of doubles, as numba sees it.
_Register: Final = type("Register", (types.Type,), {})
_LANES: Final = _Register(f"Register{WIDTH}")
register_model(_Register)(lambda manager, kind: models.PrimitiveModel(manager, kind, _VECTOR))


def _place(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    first = builder.gep(context.make_array(kind)(context, builder, array).data, [place])
    return builder.bitcast(first, _VECTOR.as_pointer())


@intrinsic
def take(typing: Any, array: Any, place: Any) -> Any:  # numba has no types
    """Return the lanes that lie at a place of an array, in doubles."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = _place(context, builder, array, *arguments)
        return builder.load(pointer, align=_NUMBER, typ=_VECTOR)

    return _LANES(array, place), generate


@intrinsic
def put(typing: Any, array: Any, place: Any, value: Any) -> Any:
    """Write lanes to a place of an array, in doubles."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = _place(context, builder, array, *arguments[:2])
        builder.store(arguments[2], pointer, align=_NUMBER)
        return context.get_dummy_value()

    return types.void(array, place, value), generate


@intrinsic
def spread(typing: Any, number: Any) -> Any:
    """Return one number in all lanes."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), arguments[0], ir.IntType(32)(0))
        everywhere = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return builder.shuffle_vector(first, first, everywhere)

    return _LANES(types.float64), generate


def _operation(instruction: Callable[[Any, Any, Any], Any]) -> Callable[..., Any]:
    def typed(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return instruction(builder, *arguments)

        return _LANES(a, b), generate

    return typed


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", b, a), b, a)  # as Python's max


plus: Final = intrinsic(_operation(lambda builder, a, b: builder.fadd(a, b)))
times: Final = intrinsic(_operation(lambda builder, a, b: builder.fmul(a, b)))
over: Final = intrinsic(_operation(lambda builder, a, b: builder.fdiv(a, b)))
minus: Final = intrinsic(_operation(lambda builder, a, b: builder.fsub(a, b)))
larger: Final = intrinsic(_operation(_larger))


@intrinsic
def absolute(typing: Any, a: Any) -> Any:
    """Return the lanes without their signs."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = ir.VectorType(ir.IntType(64), WIDTH)
        all_but_signs = ir.Constant(bits, [2**63 - 1] * WIDTH)
        return builder.bitcast(builder.and_(builder.bitcast(arguments[0], bits), all_but_signs), _VECTOR)

    return _LANES(a), generate


@intrinsic
def chosen(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """Return the lanes of a where the mask is not 0, and those of b elsewhere."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        nothing = ir.Constant(_VECTOR, [0.0] * WIDTH)
        return builder.select(builder.fcmp_unordered("!=", arguments[0], nothing), *arguments[1:])

    return _LANES(mask, a, b), generate
