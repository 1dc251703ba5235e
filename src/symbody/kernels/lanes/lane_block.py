"""Where motions side by side keep what they need, one in each lane of a register: places in their block.

Every lane has a block of its own, as `block` describes. What is computed in all lanes at once lies in a
common block: entry k of each of its arrays begins at k times `LANES`. Header and method are at the same
places as in the block of one motion.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import VECTORS

# Header: where the blocks of the lanes begin, the size of each, places for two vectors.
LANE_BLOCKS: Final = 1
LANE_SIZE: Final = 2
SCRATCH: Final = 3

# The steps that are tried, one row for each quantity: beginning, length and error, the evaluations they
# took, numbers on the way, which lanes are meant, ones.
TRIAL: Final = VECTORS
T_ROW: Final = 0
H_ROW: Final = 1
ERROR_ROW: Final = 2
CALLS_ROW: Final = 3
FIRST_ROW: Final = 4
SECOND_ROW: Final = 5
MASK_ROW: Final = 6
ONE_ROW: Final = 7
TRIAL_ROWS: Final = 16

# Vectors, derivatives and dense output, as in the block of one motion; registers have at most 8 lanes.
WIDEST: Final = 8
LANE_VECTORS: Final = TRIAL + TRIAL_ROWS * WIDEST
# The numbers of the function in lanes: its clock, behind the places, then r.
LANE_CLOCK: Final = 8
LANE_R: Final = LANE_CLOCK + WIDEST
