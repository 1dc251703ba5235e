"""The implicit loop as machine code: the bits of the Python text, factors that stay, a block that is the run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from symbody.codegen.llvm.kernel_library import compile_kernels
from symbody.kernels import block as at
from symbody.kernels.block import Run
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.implicit_machine import advance_implicit, begin_implicit
from symbody.kernels.language import Reals
from symbody.kernels.linear.dense_factors import factor_dense, solve_dense
from symbody.simulation.inputs.breakpoints import NO_BREAKPOINTS
from symbody.simulation.methods.explicit import NO_FUNCTION, NOTHING_TO_PROJECT, make_goal
from symbody.simulation.native.blocks import make_block, state_of
from symbody.simulation.native.implicit import METHOD, ImplicitFunctions, ImplicitPart, make_array
from symbody.simulation.native.run import NativeRun, fresh_record, show_room
from tests.simulation import implicit_kernels

_FILE = Path(implicit_kernels.__file__)
_PLACES = compile_kernels(_FILE.read_text(encoding="utf-8"), _FILE.name)
END = 3.0


def fresh_run(step: float | None = None, rho: float = 0.8) -> NativeRun:
    """A mass on a soft spring for some seconds."""
    names = ("slopes", "turns", "derivatives")
    functions = ImplicitFunctions(
        *(NO_FUNCTION._replace(address=_PLACES[name], n_u=1, work_size=1) for name in names)
    )
    goal = make_goal((0.0, END), 1e-5, np.full(3, 1e-7), step, NO_BREAKPOINTS)
    goal = goal._replace(max_trials=10_000)
    start = np.array([0.3, 1.5, 0.0])
    block = make_block(functions.slopes, NOTHING_TO_PROJECT, METHOD, goal, start, 0.0, step or 0.0)
    array = make_array(functions, 3, 1, rho, one_length=step is not None)
    return NativeRun(functions.slopes.address, 0, block, implicit=ImplicitPart(functions, array))


def array_of(run: NativeRun) -> NDArray[np.float64]:
    """The array of the method."""
    assert run.implicit is not None
    return run.implicit.array


@pytest.mark.parametrize("step", [None, 0.07])
def test_python_runs_the_text_to_the_same_bits(step: float | None) -> None:
    run = fresh_run(step)
    times = np.linspace(0.0, END, 11)
    record = fresh_record(run, times, dense=False)
    show_room(run.block, record)
    block, array = Run(run.block.tolist()), ImplicitStep(array_of(run).tolist())
    t, x = Reals.zeros(11), Reals.zeros(33)
    f, k, d = implicit_kernels.slopes, implicit_kernels.turns, implicit_kernels.derivatives
    nothing, samples = Reals.zeros(1), Reals(times.tolist())
    assert begin_implicit(f, block, array, samples, t, x, nothing) == at.RUNNING
    code = advance_implicit(f, k, d, f, f, block, array, samples, t, x, nothing, nothing, 10_000)
    assert code == at.FINISHED
    assert run.begin(record) == at.RUNNING and run.advance(record, 10_000) == at.FINISHED
    assert record.x.ravel().tolist() == [x[i] for i in range(33)]
    assert run.block.tolist() == block.entries and array_of(run).tolist() == array.entries


def test_copies_of_block_and_array_are_a_copy_of_the_run() -> None:
    whole, other = fresh_run(), fresh_run()
    record = fresh_record(whole, np.array([END]), dense=False)
    assert whole.begin(record) == at.RUNNING and whole.advance(record, 20) == at.RUNNING
    other.block[:], array_of(other)[:] = whole.block, array_of(whole)
    assert whole.advance(record, 10_000) == at.FINISHED
    again = fresh_record(other, np.array([END]), dense=False)
    code = at.RUNNING
    while code == at.RUNNING:
        code = other.advance(again, 1)
    assert code == at.FINISHED
    np.testing.assert_array_equal(state_of(other.block), state_of(whole.block))


def test_factors_are_kept_while_the_method_converges() -> None:
    run = fresh_run(0.01)
    record = fresh_record(run, np.array([END]), dense=False)
    run.begin(record)
    assert run.advance(record, 10_000) == at.FINISHED
    counts, implicit = Run(run.block).counts, ImplicitStep(array_of(run))
    assert counts.accepted == 300
    assert implicit.derivatives_made <= 3
    assert implicit.factors_made <= 3 + implicit.derivatives_made
    assert implicit.rounds <= 3 * counts.accepted


def test_factors_solve_and_singular_ones_are_seen() -> None:
    rng = np.random.default_rng(5)
    for n in (1, 2, 5, 9):
        matrix, right = rng.normal(size=(n, n)), rng.normal(size=n)
        matrix[0, 0] = 0.0 if n > 1 else 1.0  # rows have to be exchanged
        S, pivots, y = Reals(matrix.ravel().tolist()), Reals.zeros(n), Reals(right.tolist())
        assert factor_dense(n, S, pivots) == 1
        solve_dense(n, S, pivots, y)
        left = matrix @ np.array([y[i] for i in range(n)])
        np.testing.assert_allclose(left, right, atol=1e-13 * np.linalg.cond(matrix))
    assert factor_dense(2, Reals([1.0, 2.0, 2.0, 4.0]), Reals.zeros(2)) == 0
