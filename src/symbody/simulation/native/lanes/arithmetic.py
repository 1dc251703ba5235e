"""A register of doubles, one for each lane, for functions that numba compiles; see `vectors`.

The cache of the compiled loop does not see a change of this file: renew `lane_cases.SOURCES` after one.
"""

from __future__ import annotations

from typing import Any, Final

from llvmlite import ir
from numba.extending import intrinsic

from symbody.codegen.llvm.machine import lanes
from symbody.simulation.native.vectors import Vectors

# The processor has so many in a register; numba keeps what it compiled for each kind of processor apart.
WIDTH: Final = lanes()
_LANES: Final = Vectors("Register", WIDTH)

take: Final = _LANES.take
put: Final = _LANES.put
spread: Final = _LANES.spread


def _larger(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", b, a), b, a)  # as Python's max


plus: Final = _LANES.operation(lambda builder, a, b: builder.fadd(a, b))
times: Final = _LANES.operation(lambda builder, a, b: builder.fmul(a, b))
over: Final = _LANES.operation(lambda builder, a, b: builder.fdiv(a, b))
minus: Final = _LANES.operation(lambda builder, a, b: builder.fsub(a, b))
larger: Final = _LANES.operation(_larger)


@intrinsic
def absolute(typing: Any, a: Any) -> Any:
    """Return the lanes without their signs."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        bits = ir.VectorType(ir.IntType(64), WIDTH)
        all_but_signs = ir.Constant(bits, [2**63 - 1] * WIDTH)
        return builder.bitcast(
            builder.and_(builder.bitcast(arguments[0], bits), all_but_signs), _LANES.vector
        )

    return _LANES.kind(a), generate


@intrinsic
def choose(typing: Any, mask: Any, a: Any, b: Any) -> Any:
    """Return the lanes of a where the mask is not 0, and those of b elsewhere."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        nothing = ir.Constant(_LANES.vector, [0.0] * WIDTH)
        return builder.select(builder.fcmp_unordered("!=", arguments[0], nothing), *arguments[1:])

    return _LANES.kind(mask, a, b), generate
