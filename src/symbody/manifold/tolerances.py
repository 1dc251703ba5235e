"""The tolerances of the numeric core, each in units of the mechanism (lengths) or of a radian (angles)."""

from __future__ import annotations

from typing import Final

# Constraints are closed to this: Newton's method on doubles ends some digits below.
CLOSED: Final = 1e-10
# Positions on a path are closed to this: beyond a limit positions that are almost closed go on for a while.
TRACED: Final = 1e-12
# Loops count as assembled at this: closer than any is built.
ASSEMBLED: Final = 1e-9
# Newton's method goes on to this while it still gains.
EXACT: Final = 1e-15
# The rounding of a coordinate this many of its sizes from zero: residuals of such are known no better.
FAR: Final = 1e-14
# Singular values below this share of the largest stand for directions in which nothing changes.
NEGLIGIBLE: Final = 1e-10
# Singular values of unit rows below this share of the largest count as 0: between the rounding that closing
# leaves and what a configuration a twentieth of a radian beside a singular one has, to third order.
RANK: Final = 1e-6
# The same where loops are closed to rounding, and nearness to singular positions is to be seen.
SHARP_RANK: Final = 1e-8
# Rows of a Jacobian shorter than this share of the longest, or of 1, are zeros up to rounding.
VANISHING: Final = 1e-10
# Cosines of axes that coincide in a closed joint are 1; its equations, products of axes, hold for -1, some
# for 0 as well.
ALIGNED: Final = 0.5
