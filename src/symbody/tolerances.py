"""Tolerances that more than one room uses: each with its name, its value and its reason.

All are shares of sizes that follow from the mechanism (docs/notation.md, scales and tolerances): of its
length, or 1 rad, for positions; of its speeds, forces and energy for the others; or of the largest of what is
compared. What a single algorithm needs for itself stands at the top of its file.
"""

from __future__ import annotations

from typing import Final

# --- Closed constraints, the tightest first.
# Newton's method goes on to this while it still gains: some roundings of constraints of order one.
EXACT: Final = 1e-15
# The rounding of a coordinate this many of its sizes from zero: residuals of such are known no better.
FAR: Final = 1e-14
# Positions along a path: beyond a limit positions that are almost closed go on for a while.
TRACED: Final = 1e-12
# Along a motion, where no atol is given; the error of a step, too.
CLOSED: Final = 1e-10
# Where loops count as assembled: closer than any is built. Whatever is computed from such positions is known
# no better.
ASSEMBLED: Final = 1e-9
# Closed forms: a root of a squared equation is open by far more.
ROOT: Final = 1e-7
# Positions that differ by less are the same.
SAME_POSITION: Final = 1e-5
# Cosines of axes that coincide in a closed joint are 1; its equations, products of axes, hold for -1, some
# for 0 as well.
ALIGNED: Final = 0.5

# --- Singular values, as shares of the largest, that count as 0.
# In steps and in linear systems: directions in which nothing changes.
NEGLIGIBLE: Final = 1e-10
# Of loads: less bears nothing.
BEARING: Final = 1e-9
# Ranks where loops are closed to rounding, and nearness to singular positions is to be seen.
SHARP_RANK: Final = 1e-8
# Ranks elsewhere: between the rounding that closing leaves and what a configuration a twentieth of a radian
# beside a singular one has, to third order.
RANK: Final = 1e-6
# Ranks at singular positions that were searched for: their places are known to 1e-7 or better.
SINGULAR: Final = 1e-5
# Rows of a Jacobian shorter than this share of the longest, or of 1, are zeros up to rounding.
VANISHING: Final = 1e-10

# --- Rest and balance.
# Speeds and rates below this share of the largest, or of the mechanism's own, are rounding of what rests.
AT_REST: Final = 1e-9
# Forces, impulses and accelerations below this share of the largest are rounding of what balances.
BALANCED: Final = 1e-9
# The same where the terms cancel altogether: rounding of their sum.
CANCELLED: Final = 1e-12
# Equations of friction with larger residuals, of their terms, are not solved.
UNSOLVED: Final = 1e-9

# --- Numbers as they are given, and as they are computed.
# Axes, angles and lengths typed with ten digits still count as what they mean; no mechanism works in a
# direction of a thousand-millionth.
TYPED: Final = 1e-9
# Steps of finite differences, for what has no formula.
DIFFERENCE: Final = 1e-6
# Events of one kind within this share of a motion happen at one instant.
INSTANT: Final = 1e-7
# Below all numbers that stand for something: keeps a quotient of zeros finite.
TINY: Final = 1e-300
