"""Laws are tried on few examples in the fast tier and on many in the slow one."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="session", params=["few", pytest.param("many", marks=pytest.mark.exhaustive)])
def tier(request: pytest.FixtureRequest) -> str:
    """Ask for it by `tests.expr.strategies.both_tiers`: the Hypothesis profile sets how many."""
    return str(request.param)
