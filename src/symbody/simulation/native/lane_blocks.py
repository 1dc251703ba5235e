"""The block of motions side by side, one in each lane of a register; see `kernels.lanes.lane_block`."""

from __future__ import annotations

import numpy as np

from symbody.codegen.llvm.machine import lanes
from symbody.kernels.block import Run
from symbody.kernels.lanes.lane_block import WIDEST, LaneGroup, LaneNumbers
from symbody.kernels.pack import pack
from symbody.kernels.record_layout import exists
from symbody.simulation.native.blocks import method_numbers
from symbody.simulation.native.description import Floats, RightHandSide
from symbody.simulation.native.runge_kutta import Tableau


def make_lane_block(single: Floats, rhs: RightHandSide, work_size: int, tableau: Tableau) -> Floats:
    """Return the block for lanes that each go on like the block `single`, in which no case has begun.

    `work_size` is that of the function in lanes.
    """
    width, run = lanes(), Run(single)
    state = np.zeros(run.states * width)
    runs = np.zeros((width, LaneGroup.round_up(single.size)))
    runs[:, : single.size] = single
    runs[:, Run.layout["cases.current"]] = -1.0
    numbers = pack(
        LaneNumbers, inputs=np.zeros(rhs.inputs.size * width),
        parameters=np.zeros(rhs.parameters.size * width), constants=np.zeros(rhs.constants.size * width),
        work=np.zeros(work_size), tables=rhs.tables,
    )  # fmt: skip
    packed = pack(
        LaneGroup, states=run.states, speeds=run.speeds, rtol=run.goal.rtol, projects=exists(run.projection),
        run_size=runs.shape[1], method=method_numbers(tableau, state.size), ones=np.ones(WIDEST),
        state_old=state, stage=state, state_new=state, error_1=state, error_2=state, zero_state=state,
        tolerances=np.ones(state.size), slopes=np.zeros(len(tableau.A) * state.size),
        dense=np.zeros((4 + len(tableau.dense)) * state.size), scratch=state, scratch_slope=state,
        numbers=numbers, runs=runs,
    )  # fmt: skip
    block = aligned_zeros(packed.size)
    block[:] = packed
    return block


def aligned_zeros(size: int) -> Floats:
    """Return zeros that begin at a line."""
    room = np.zeros(size + WIDEST)
    first = -(room.ctypes.data // 8) % WIDEST
    return room[first : first + size]
