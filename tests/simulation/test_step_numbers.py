"""Numbers of a block that steppers carry: all that change from step to step, none that follow from the goal."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.kernels.block import Run
from symbody.simulation.stepper.compiled_steps import KEPT
from tests.simulation.loops import example

# What searches begin with is found again from any place.
FOUND_AGAIN = {"breaks.next"}
CASES: dict[str, dict[str, Any]] = {
    "plain": {}, "fixed": {"integrator": sb.FixedStep(0.003)},
    "jump": {"inputs": {"F": "if(t < 0.05, 1, -2)"}},
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_every_number_that_changes_is_kept(case: str) -> None:
    options = CASES[case]
    stepper = sb.Stepper(example("cart_pole"), 0.01, **options)
    changed: set[str] = set()
    before = stepper._steps.block.copy()  # type: ignore[attr-defined]
    for k in range(30):
        stepper.step(**({} if "inputs" in options else {"F": 20.0 * np.sin(k)}))
        block = stepper._steps.block  # type: ignore[attr-defined]
        changed |= {name for name, place in Run.layout.items() if block[place] != before[place]}
    kept = {name for name, place in Run.layout.items() if place in KEPT}
    assert changed - FOUND_AGAIN <= kept
    assert {"time", "step", "error", "t_end", "counts.evaluations"} <= changed


def test_numbers_of_a_run_and_its_counts_are_kept() -> None:
    names = {name for name, place in Run.layout.items() if place in KEPT}
    assert {name.partition(".")[0] for name in names if "." in name} == {"counts"}
    assert not names & {field.name for field in Run.pointers}
    assert {"time", "after_rejection", "unjudged", "counts.accepted", "counts.blamed_state"} <= names
