"""The integrator as machine code: compiled once on a computer, resumable, its state a block of numbers."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS
from symbody.simulation.methods.explicit import NO_FUNCTION, NOTHING_TO_PROJECT, make_goal
from symbody.simulation.native.blocks import make_block, state_of
from symbody.simulation.native.run import NativeRun, fresh_record
from symbody.simulation.native.runge_kutta import DORMAND_PRINCE_8
from tests.simulation.right_hand_sides import pendulum, run

# Counts the texts that are compiled while a motion is computed.
FRESH_PROCESS = """
from symbody.codegen.llvm import kernel_library
from tests.simulation.right_hand_sides import pendulum, run
usual, texts = kernel_library.light_code, []
kernel_library.light_code = lambda text: texts.append(text) or usual(text)
print(run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0)).x[:, -1].tolist())
print(len(texts))
"""


def test_a_second_process_compiles_nothing_and_import_compiles_nothing(tmp_path: Path) -> None:
    environment = os.environ | {"SYMBODY_CACHE": str(tmp_path)}
    lines = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", FRESH_PROCESS],
            capture_output=True,
            text=True,
            timeout=120,
            env=environment,
        )
        assert done.returncode == 0, done.stderr
        lines.append(done.stdout.split("\n"))
    assert [line[1] for line in lines] == ["1", "0"]
    assert lines[0][0] == lines[1][0]


def test_dense_output_rows_match_the_tableau() -> None:
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0))
    assert result.dense_output is not None
    assert result.dense_output.pieces.shape[1] == DORMAND_PRINCE_8.dense_degree + 1
    assert np.isfinite(result.dense_output.pieces).all()


def fresh_run() -> NativeRun:
    """A pendulum for 30 s."""
    goal = make_goal((0.0, 30.0), 1e-9, np.full(2, 1e-9), None, NO_BREAKPOINTS)
    goal = goal._replace(max_trials=1000)
    rhs = NO_FUNCTION._replace(address=pendulum.address, n_u=1)
    start = np.array([0.0, 2.0])
    block = make_block(rhs, NOTHING_TO_PROJECT, DORMAND_PRINCE_8, goal, start, 0.0)
    return NativeRun(rhs.address, 0, block)


def test_a_copy_of_the_block_is_a_copy_of_the_run() -> None:
    whole, other = fresh_run(), fresh_run()
    record = fresh_record(whole, np.array([30.0]), dense=False)
    assert whole.begin(record) == at.RUNNING
    assert whole.advance(record, 10) == at.RUNNING
    saved = whole.block.copy()
    assert whole.advance(record, 1000) == at.FINISHED
    other.block[:] = saved
    again = fresh_record(other, np.array([30.0]), dense=False)
    for _ in range(1000):  # one step at a call
        code = other.advance(again, 1)
        if code != at.RUNNING:
            break
    assert code == at.FINISHED
    np.testing.assert_array_equal(state_of(other.block), state_of(whole.block))
    np.testing.assert_array_equal(other.block[: Run.size], whole.block[: Run.size])
    assert Run(whole.block).counts.accepted > 20


def test_a_motion_goes_on_beyond_its_first_end() -> None:
    there = fresh_run()
    record = fresh_record(there, np.zeros(0), dense=False)
    own = Run(there.block)
    own.t_end = 10.0
    assert there.begin(record) == at.RUNNING
    assert there.advance(record, 1000) == at.FINISHED and own.time == 10.0
    own.t_end = 30.0
    assert there.advance(record, 1000) == at.FINISHED
    expected = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 30.0), rtol=1e-12, atol=1e-12).x[:, -1]
    np.testing.assert_allclose(state_of(there.block), expected, atol=1e-6)
