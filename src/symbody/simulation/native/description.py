"""What a run of the integrator takes: functions, a goal, and where the results go."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Places = NDArray[np.uintp]
Flags = NDArray[np.bool_]


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


class Projector(NamedTuple):
    """A function that brings states back onto the constraints; the first fields as in `RightHandSide`.

    It writes position residuals, position moves, velocity residuals, velocity moves.

    Attributes
    ----------
    address : int
        0 where there is nothing to project.
    n_q : int
        Number of coordinates.
    scales : array (n,)
        The largest position residuals that count as closed; velocity residuals have none, being linear.
    limit : float
        Moves above so many tolerated errors, or what the old state asks for, reject the step.
    sizes : array (n_q,)
        What counts as a large coordinate: 1 rad, or the size of the mechanism [m].
    rounding : float
        How exactly residuals are known at coordinates that are not large, over what counts as closed.
    out : array (1, size)
        What the function writes.
    """

    address: int
    n_u: int
    inputs: Floats
    parameters: Floats
    constants: Floats
    work: Floats
    clock: Floats
    n_q: int
    scales: Floats
    limit: float
    sizes: Floats
    rounding: float
    out: Floats


class Method(NamedTuple):
    """A `runge_kutta.Tableau` as arrays.

    Attributes
    ----------
    first : (k + 2 + d + 1,) array of int
        Where each row of A, of the two error estimates and of the dense output begins in the next two.
    columns, weights : arrays
        The coefficients that are not zero, and which stages they belong to.
    c : (k,) array
        The nodes.
    split : bool
        Whether coordinates wait for the new speeds, see `runge_kutta.SEMI_IMPLICIT`.
    """

    first: Integers
    columns: Places
    weights: Floats
    c: Floats
    order: int
    stages: int
    error_reads_end: bool
    exponent: float
    memory: float
    shrink: float
    growth: float
    stiff_bound: float
    split: bool


class Goal(NamedTuple):
    """What a run is to reach, how carefully, and what bounds its steps.

    Attributes
    ----------
    breaks : (m,) array
        Times where the pieces of `inputs.breakpoints` meet, in the order of the motion; those of every motion
        end with an infinite one [s].
    longest : (m,) array
        How long a step may be that enters the piece before each [s].
    jumps : (m,) array of bool
        Whether what depends on time jumps there, so that a step has to end before and another begin behind.
    margins : (m,) array
        A jump happens within so much of its time [s].
    """

    t_end: float
    direction: float
    rtol: float
    atol: Floats
    max_step: float
    max_trials: int
    stop_when_stiff: bool
    breaks: Floats
    longest: Floats
    jumps: Flags
    margins: Floats


class Memory(NamedTuple):
    """What a step leaves for the next.

    Attributes
    ----------
    vectors : (6, n) array
        Old state, state of the last stage, new state, two error estimates, zeros.
    K : (k, n) array
        The derivatives of the stages.
    F : (1, 4 + d, n) array
        The dense output of the last step, see `dense_output`, where it is not kept.
    real : array
        Time, next step, error norm of the step before.
    counts : array of int
        Counters; the places are named at the top of this file.
    """

    vectors: Floats
    K: Floats
    F: Floats
    real: Floats
    counts: Integers


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
