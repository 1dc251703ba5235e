"""Verdicts that advise."""

from __future__ import annotations

import pytest

from symbody.simulation.status import Status


@pytest.mark.parametrize("status", Status)
def test_a_verdict_is_a_sentence_and_a_failure_says_what_to_try(status: Status) -> None:
    assert len(status.value) > 25
    assert status.success == (status in (Status.SUCCESS, Status.STOPPED))
    if not status.success and status is not Status.INTERRUPTED:
        assert any(
            word in status.value
            for word in ("look for", "raise", "use ", "end the run", "pass", "lower its", "name other")
        )
