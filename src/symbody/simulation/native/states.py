"""Four states at once, in a register, for functions that numba compiles: each is rounded as if alone.

numba does not put neighbouring numbers of an array into one register by itself. What the functions say holds
in compiled code; none can be called from Python.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

WIDTH: Final = 4
_VECTOR: Final = ir.VectorType(ir.DoubleType(), WIDTH)
_NUMBER: Final = 8  # bytes

# Four doubles, as numba sees them.
_States: Final = type("States", (types.Type,), {})
_FOUR: Final = _States("States")
register_model(_States)(lambda manager, kind: models.PrimitiveModel(manager, kind, _VECTOR))


def _place(context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
    first = builder.gep(context.make_array(kind)(context, builder, array).data, [place])
    return builder.bitcast(first, _VECTOR.as_pointer())


@intrinsic
def four(typing: Any, array: Any, place: Any) -> Any:  # numba has no types
    """Return what lies at a place of an array, in doubles."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(_place(context, builder, array, *arguments), align=_NUMBER, typ=_VECTOR)

    return _FOUR(array, place), generate


@intrinsic
def put(typing: Any, array: Any, place: Any, value: Any) -> Any:
    """Write four states to a place of an array, in doubles."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store(arguments[2], _place(context, builder, array, *arguments[:2]), align=_NUMBER)
        return context.get_dummy_value()

    return types.void(array, place, value), generate


@intrinsic
def everywhere(typing: Any, number: Any) -> Any:
    """Return one number four times."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        first = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), arguments[0], ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return builder.shuffle_vector(first, first, zeros)

    return _FOUR(types.float64), generate


def _operation(instruction: Callable[[Any, Any, Any], Any]) -> Callable[..., Any]:
    def typed(typing: Any, a: Any, b: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return instruction(builder, *arguments)

        return _FOUR(a, b), generate

    return typed


plus: Final = intrinsic(_operation(lambda builder, a, b: builder.fadd(a, b)))
times: Final = intrinsic(_operation(lambda builder, a, b: builder.fmul(a, b)))
