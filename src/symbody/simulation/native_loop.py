"""The Runge-Kutta loop, compiled by numba once for every model.

The right-hand side comes in as the address of a function with the signature of all generated code, ::

    int f(const double *t, const double *q, const double *u, const double *r,
          const double *p, const double *c, double *out, double *work)

so the loop is compiled at its first call only, and later processes read it from numba's cache. Everything
compiled stands in this one file, and coefficients arrive as arguments: numba renews a cached function only
when its own file changes. States are ordered x = (u, q); the letters are those of Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, section II.4.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

# What `begin` and `advance` return.
RUNNING, FULL, FINISHED, COLLAPSED, NOT_FINITE, SINGULAR, TOO_MANY, STIFF = range(8)

# Places in Memory.real, all but the vectors: time, next step, step before, its error norm.
TIME, STEP, ERROR = range(3)
# Places in Memory.count.
ACCEPTED, REJECTED, EVALUATIONS, SAMPLES, STEPS, KERNEL, STATE, AFTER_REJECTION, STIFF_VOTES, OTHER_VOTES = range(10)
# Rows of Memory.vectors.
STATE_OLD, STAGE, STATE_NEW, ERROR_1, ERROR_2 = range(5)

EPSILON: Final = 2.220446049250313e-16
SMALLEST_STEP: Final = 1e-290  # absolute, for motions that fail at t = 0
SAFETY: Final = 0.9


class RightHandSide(NamedTuple):
    """A compiled function and what stays the same for a whole run.

    Attributes
    ----------
    address : int
        Where the function lies.
    n_u : int
        Number of speeds, which come first in the state.
    inputs, parameters, constants, work : arrays
        The groups r, p, c and the function's scratch.
    clock : array of one
        Scratch for the time.
    """

    address: int
    n_u: int
    inputs: Floats
    parameters: Floats
    constants: Floats
    work: Floats
    clock: Floats


class Method(NamedTuple):
    """A `runge_kutta.Tableau` as arrays: A (k, k), c (k,), error (2, stages + 1), dense (d, k)."""

    A: Floats
    c: Floats
    error: Floats
    dense: Floats
    order: int
    stages: int
    error_reads_end: bool
    exponent: float
    memory: float
    shrink: float
    growth: float
    stiff_bound: float


class Goal(NamedTuple):
    """What a run is to reach, and how carefully."""

    t_end: float
    direction: float
    rtol: float
    atol: Floats
    max_step: float
    max_trials: int
    stop_when_stiff: bool


class Memory(NamedTuple):
    """What a step leaves for the next.

    Attributes
    ----------
    vectors : (5, n) array
        Old state, state of the last stage, new state, two error estimates.
    K : (k, n) array
        The derivatives of the stages.
    F : (4 + d, n) array
        The dense output of the last step, see `dense_output`.
    real : array
        Time, next step, error norm of the step before.
    count : array of int
        Counters; the places are named at the top of this file.
    """

    vectors: Floats
    K: Floats
    F: Floats
    real: Floats
    count: Integers


class Record(NamedTuple):
    """Where samples and dense outputs go.

    Attributes
    ----------
    wanted : array
        The times to store, in the order of the motion; every step is stored if `every_step`.
    t, x : arrays (capacity,), (capacity, n)
        The samples.
    breaks, pieces : arrays (capacity + 1,), (capacity, 4 + d, n)
        Ends and dense output of each step, if `keep_dense`.
    """

    wanted: Floats
    t: Floats
    x: Floats
    breaks: Floats
    pieces: Floats
    every_step: bool
    keep_dense: bool


def _compiled(function: Callable[..., object]) -> Callable[..., int]:
    """Compile at the first call, without the lock of the interpreter, and keep the result on disk."""
    compiled: Callable[..., int]
    try:
        compiled = njit(cache=True, nogil=True, error_model="numpy")(function)
    except RuntimeError:  # no folder to keep it in: a read-only installation without a home
        compiled = njit(nogil=True, error_model="numpy")(function)
    return compiled


@intrinsic
def _call(typingctx, address, n_u, t, x, r, p, c, work, x_row, out, out_row):  # type: ignore
    raise NotImplementedError
