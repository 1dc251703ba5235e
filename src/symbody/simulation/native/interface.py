"""What the compiled loop takes, how it is compiled, and how it calls a function by address.

The cache of the compiled loop does not see a change of this file: renew `loop.SOURCES` after one.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from symbody.simulation.native import layout
from symbody.simulation.native.compiling import LoopCache
from symbody.simulation.native.description import Flags as Flags
from symbody.simulation.native.description import Floats as Floats
from symbody.simulation.native.description import Goal as Goal
from symbody.simulation.native.description import Integers as Integers
from symbody.simulation.native.description import Memory as Memory
from symbody.simulation.native.description import Method as Method
from symbody.simulation.native.description import Places as Places
from symbody.simulation.native.description import Projector as Projector
from symbody.simulation.native.description import Record as Record
from symbody.simulation.native.description import RightHandSide as RightHandSide
from symbody.simulation.native.runge_kutta import Tableau

Function = TypeVar("Function", bound=Callable[..., object])


def compile_loop(function: Function) -> Function:
    """Compile at the first call, without the lock of the interpreter, and keep the result on disk."""
    result = njit(nogil=True, error_model="numpy")(function)
    with suppress(RuntimeError):  # no folder to keep it in: a read-only installation without a home
        result._cache = LoopCache(function)
    loop: Function = result
    return loop


def inline(function: Function) -> Function:
    """Compile as part of the functions that call this one."""
    result: Function = njit(
        nogil=True, error_model="numpy", forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True
    )(function)
    return result


@intrinsic
def call(typing: Any, rhs: Any, x: Any, at: Any, out: Any, to: Any) -> Any:  # numba has no types
    """Call the right-hand side with the state x[at:], writing to out[to:]; places count doubles."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        fields = {
            name: (kind, builder.extract_value(arguments[0], place))
            for place, (name, kind) in enumerate(zip(rhs.fields, rhs.types, strict=True))
        }

        def pointer(kind: Any, value: Any) -> Any:
            return context.make_array(kind)(context, builder, value).data

        double = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.IntType(32), [double] * 8)
        function = builder.inttoptr(fields["address"][1], kind.as_pointer())
        u = builder.gep(pointer(x, arguments[1]), [arguments[2]])
        q = builder.gep(u, [fields["n_u"][1]])
        target = builder.gep(pointer(out, arguments[3]), [arguments[4]])
        t, r, p, c, work = (
            pointer(*fields[name]) for name in ("clock", "inputs", "parameters", "constants", "work")
        )
        return builder.call(function, [t, q, u, r, p, c, target, work])

    return types.int32(rhs, x, at, out, to), generate


@intrinsic
def borrow(typing: Any, group: Any) -> Any:
    """Return a group whose arrays are not reference counted: counting took 70 % of a run of two states."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        result = arguments[0]
        for place, kind in enumerate(group.types):
            if isinstance(kind, types.Array):
                array = context.make_array(kind)(context, builder, builder.extract_value(result, place))
                array.meminfo = array.meminfo.type(None)
                array.parent = array.parent.type(None)
                result = builder.insert_value(result, array._getvalue(), place)
        return result

    return group(group), generate


def method_arrays(tableau: Tableau) -> Method:
    """Return a tableau as arrays."""
    rows = (*tableau.A, *tableau.error, *tableau.dense)
    columns = [[j for j, weight in enumerate(row) if weight != 0.0] for row in rows]
    return Method(
        np.cumsum([0, *map(len, columns)], dtype=np.int64),
        np.array([j for places in columns for j in places], dtype=np.uintp),
        np.array([weight for row in rows for weight in row if weight != 0.0]),
        np.array(tableau.c, dtype=np.float64),
        tableau.order,
        tableau.stages,
        tableau.error_reads_end,
        tableau.exponent,
        tableau.memory,
        tableau.shrink,
        tableau.growth,
        tableau.stiff_bound,
        tableau.split,
    )


def fresh_memory(tableau: Tableau, x: Floats, t: float) -> Memory:
    """Return the loop's memory at its first time and state."""
    memory = Memory(
        np.zeros((layout.VECTORS, x.size)),
        np.zeros((len(tableau.A), x.size)),
        np.zeros((1, 4 + len(tableau.dense), x.size)),
        np.zeros(layout.REALS),
        np.zeros(layout.COUNTS, dtype=np.int64),
    )
    memory.vectors[layout.STATE_OLD] = x
    memory.real[layout.TIME] = t
    return memory
