"""Where the compiled loop keeps things, and the codes it returns."""

from __future__ import annotations

# What `begin` and `advance` return.
RUNNING, FULL, FINISHED, COLLAPSED, NOT_FINITE, SINGULAR, TOO_MANY, STIFF = range(8)

# Places in Memory.real: time, next step, error norm of the step before; and how many there are.
TIME, STEP, ERROR, REALS = range(4)
# Places in Memory.counts.
ACCEPTED, REJECTED, EVALUATIONS, SAMPLES, STEPS, KERNEL, STATE = range(7)
AFTER_REJECTION, STIFF_VOTES, OTHER_VOTES = range(7, 10)
# The breakpoint that comes next, the first one of this motion; and how many places there are.
NEXT_BREAK, FIRST_BREAK, COUNTS = range(10, 13)
# Rows of Memory.vectors.
STATE_OLD, STAGE, STATE_NEW, ERROR_1, ERROR_2, NOTHING, VECTORS = range(7)
