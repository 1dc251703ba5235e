"""Several doubles in a register, for functions that numba compiles: each is rounded as if alone.

numba puts neighbouring numbers of an array into one register only where it sees through, and sums kept in
arrays cost a load and a store for every term. These are LLVM's vectors themselves. What the functions say
holds in compiled code; none can be called from Python.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.extending import intrinsic, models, register_model

_NUMBER: Final = 8  # bytes


class Vectors:
    """What can be done with so many doubles at once; numba has no types for it.

    Attributes
    ----------
    kind : numba type
    vector : llvmlite type
    take, put, spread : functions
        ``take(array, place)`` returns what lies at a place, in doubles, ``put(array, place, value)`` writes
        it, ``spread(number)`` returns one number everywhere.
    """

    def __init__(self, name: str, width: int) -> None:
        known = type(name, (types.Type,), {})
        self.kind: Any = known(f"{name}{width}")
        self.vector = ir.VectorType(ir.DoubleType(), width)
        self.width = width
        register_model(known)(lambda manager, kind: models.PrimitiveModel(manager, kind, self.vector))
        self.take = intrinsic(self._take())
        self.put = intrinsic(self._put())
        self.spread = intrinsic(self._spread())

    def operation(self, instruction: Callable[[Any, Any, Any], Any]) -> Any:
        """Return the function of two vectors that an instruction of LLVM's builder gives."""

        def infer(typing: Any, a: Any, b: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                return instruction(builder, *arguments)

            return self.kind(a, b), generate

        return intrinsic(infer)

    def _place(self, context: Any, builder: Any, kind: Any, array: Any, place: Any) -> Any:
        first = builder.gep(context.make_array(kind)(context, builder, array).data, [place])
        return builder.bitcast(first, self.vector.as_pointer())

    def _take(self) -> Callable[..., Any]:
        def take(typing: Any, array: Any, place: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                pointer = self._place(context, builder, array, *arguments)
                return builder.load(pointer, align=_NUMBER, typ=self.vector)

            return self.kind(array, place), generate

        return take

    def _put(self) -> Callable[..., Any]:
        def put(typing: Any, array: Any, place: Any, value: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                pointer = self._place(context, builder, array, *arguments[:2])
                builder.store(arguments[2], pointer, align=_NUMBER)
                return context.get_dummy_value()

            return types.void(array, place, value), generate

        return put

    def _spread(self) -> Callable[..., Any]:
        def spread(typing: Any, number: Any) -> Any:
            def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
                nothing, first = ir.Constant(self.vector, ir.Undefined), ir.IntType(32)(0)
                put = builder.insert_element(nothing, arguments[0], first)
                zeros = ir.Constant(ir.VectorType(ir.IntType(32), self.width), [0] * self.width)
                return builder.shuffle_vector(put, put, zeros)

            return self.kind(types.float64), generate

        return spread
