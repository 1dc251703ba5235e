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

# Whether all steps have one length, but those that end at a jump or at the end.
ONE_LENGTH: Final = 7

# Where things begin. Algorithmic rates at the last step's end, the same for the length of the step that is
# tried, and at its end; the correction; slopes one step before; how slopes change at a start; a state inside
# the step, and the rates of coordinates there; derivatives of all rates by all states; those of v by u
# through q; factors, and rows that they exchange; numbers of the functions of rates and derivatives; slopes
# of v at the start of the step.
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
SLOPES_USED: Final = 22

# How long the last step was [s], 0 at a start; for which length the factors are, 0 without any; whether there
# are derivatives; how fast corrections shrink.
LENGTH_BEFORE: Final = 23
FACTORED_FOR: Final = 24
HAS_DERIVATIVES: Final = 25
CONTRACTION: Final = 26

# Counters.
DERIVATIVES_MADE: Final = 27
FACTORS_MADE: Final = 28
ROUNDS: Final = 29

HEADER: Final = 32
