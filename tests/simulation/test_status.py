"""Verdicts that advise."""

from __future__ import annotations

import pytest

from symbody.simulation.status import Status
from symbody.simulation.sweeps.records import CODES


@pytest.mark.parametrize("status", Status)
def test_a_verdict_is_a_sentence_and_a_failure_says_what_to_try(status: Status) -> None:
    assert len(status.value) > 25
    assert status.success == (status in (Status.SUCCESS, Status.STOPPED))
    if not status.success and status is not Status.INTERRUPTED:
        assert any(
            word in status.value
            for word in ("look for", "set fewer", "use ", "end the run", "pass", "lower its", "name other")
        )


def test_stored_codes_belong_to_one_status_for_ever() -> None:
    # Codes were places in the class: a status put between two others made those behind it read as others.
    assert CODES.keys() == set(Status)
    assert len(set(CODES.values())) == len(CODES)
    kept = {
        "SUCCESS": 100, "STOPPED": 101, "STEP_COLLAPSE": 102, "NOT_FINITE": 103, "SINGULAR": 104, "FRICTION": 105,
        "DEPENDENT_SPEEDS": 106, "TOO_MANY_STEPS": 107, "STIFF": 108, "CHATTERING": 109, "NOT_STARTED": 110,
        "WORKER_LOST": 111, "INTERRUPTED": 112, "OUT_OF_MEMORY": 113, "UNMET_ACTION": 114,
    }  # fmt: skip
    assert {status.name: code for status, code in CODES.items() if status.name in kept} == kept
