"""Where the generalized-alpha method keeps what it needs beside the block of a motion: places in its array.

Behind the `HEADER` follow vectors, matrices and the numbers of two functions, where the header says. With n
states x = (u, q, s) and the work behind them, v = (u, s) are those whose rates the method solves for.
"""

from __future__ import annotations

from typing import Final

# The method: weights of rates, of velocities and of displacements; by what share of a step the algorithmic
# rates lag behind.
ALPHA_M: Final = 0
ALPHA_F: Final = 1
GAMMA: Final = 2
BETA: Final = 3
LAG: Final = 4

# Sizes.
COORDINATES: Final = 5  # how many there are in q
UNKNOWNS: Final = 6  # how many there are in v

# Where things begin: algorithmic rates at the last step's end, the same for the length of the step that is
# tried, and at its end; the slopes of v at its start; the correction; the slopes one step before; how the slopes change at a start; a state
# inside the step and the rates of coordinates there; the derivatives of all rates by all states, those of v by
# u through q, factors and the order of their rows; the numbers of the functions of rates and derivatives.
RATES: Final = 8
RATES_USED: Final = 9
RATES_NEW: Final = 10
CORRECTION: Final = 11
SLOPES_BEFORE: Final = 12
SLOPES_CHANGE: Final = 13
MIDDLE: Final = 14
TURN: Final = 15
DERIVATIVES: Final = 16
THROUGH_Q: Final = 17
FACTORS: Final = 18
PIVOTS: Final = 19
RATE_FUNCTION: Final = 20
DERIVATIVE_FUNCTION: Final = 21
SLOPES_USED: Final = 29

# What is known: of which length [s] the last step was, 0 at a start; for which the factors are, 0 without any;
# whether there are derivatives; how fast corrections shrink.
LENGTH_BEFORE: Final = 22
FACTORED_FOR: Final = 23
HAS_DERIVATIVES: Final = 24
CONTRACTION: Final = 25

# Counters.
DERIVATIVES_MADE: Final = 26
FACTORS_MADE: Final = 27
ROUNDS: Final = 28

HEADER: Final = 32
