"""The block of motions side by side, one in each lane of a register; see `kernels.lanes.lane_block`."""

from __future__ import annotations

from typing import Final

import numpy as np

from symbody.codegen.llvm.machine import lanes
from symbody.kernels import block as at
from symbody.kernels.lanes import lane_block as beside
from symbody.simulation.native.blocks import method_numbers
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.native.runge_kutta import Tableau

# A register, and a line of the processor's cache, has so many numbers at most: what begins at a multiple
# of it is loaded by one access.
_LINE: Final = 8


def make_lane_block(single: Floats, rhs: RightHandSide, work_size: int, tableau: Tableau) -> Floats:
    """Return the block for lanes that each go on like the block `single`, in which no case has begun.

    `work_size` is that of the function in lanes.
    """
    width, n = lanes(), int(single[at.N])
    rows = at.VECTOR_ROWS + len(tableau.A) + 4 + len(tableau.dense)
    scratch = beside.LANE_VECTORS + rows * n * width
    function = _lines(scratch + 2 * n * width)
    numbers = beside.LANE_R + width * np.cumsum([rhs.inputs.size, rhs.parameters.size, rhs.constants.size])
    tables = function + int(numbers[-1]) + work_size
    first, size = _lines(tables + rhs.tables.size), _lines(single.size)
    block = aligned_zeros(first + width * size)
    block[at.METHOD : at.METHOD + at.METHOD_SIZE] = method_numbers(tableau, n * width)
    block[[at.N, at.N_U, at.RTOL, at.PROJECTOR]] = single[[at.N, at.N_U, at.RTOL, at.PROJECTOR]]
    block[[at.FUNCTION, beside.SCRATCH]] = function, scratch
    block[[beside.LANE_BLOCKS, beside.LANE_SIZE]] = first, size
    block[[function + at.P_PLACE, function + at.C_PLACE, function + at.WORK_PLACE]] = numbers
    block[tables : tables + rhs.tables.size] = rhs.tables
    block[function + at.TABLES_PLACE] = tables - function if rhs.tables.size else 0
    block[beside.TRIAL + beside.ONE_ROW * width :][:width] = 1.0
    block[beside.LANE_VECTORS + at.TOLERANCES * n * width :][: n * width] = 1.0
    own = block[first:].reshape(width, size)
    own[:, : single.size] = single
    own[:, at.CASE] = -1.0
    return block


def _lines(size: int) -> int:
    """Return a size rounded up to whole lines."""
    return -(-size // _LINE) * _LINE


def aligned_zeros(size: int) -> Floats:
    """Return zeros that begin at a line."""
    room = np.zeros(size + _LINE)
    first = -(room.ctypes.data // 8) % _LINE
    return room[first : first + size]
