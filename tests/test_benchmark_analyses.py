"""The analyses that are timed beside SymPy give the same numbers."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import analyses


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", analyses.LOOPS)
@pytest.mark.parametrize("task", analyses.TASKS)
def test_both_ways_agree(name: str, task: str) -> None:
    loop = analyses.LOOPS[name]()
    ours, by_hand = analyses.ours(loop, task), getattr(analyses.ByHand(loop), task)()
    assert np.abs(ours - by_hand).max() < 1e-8 * np.abs(by_hand).max()
