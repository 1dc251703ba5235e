"""What a motion has: 1 or 0, as the text of its kernels is made, so that what it lacks is left out."""

from typing import Final

EVENTS: Final[int] = 1  # values that are searched for zeros, the ends of modes among them
GAPS: Final[int] = 1  # compliant ones, over which no step may pass
IMPLICIT: Final[int] = 1  # steps by the generalized-alpha method, else by an explicit one
JUMPS: Final[int] = 1  # of prescribed rates
MODES: Final[int] = 1  # of what sticks and slips, and of gaps
SAMPLES: Final[int] = 1  # of values that are held in between
