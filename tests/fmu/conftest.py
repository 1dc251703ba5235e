"""FMUs of the fast tier are compiled without the optimizer, which takes most of the time; the numbers are the same."""

from __future__ import annotations

import pytest

from symbody.fmu import binaries


@pytest.fixture(autouse=True)
def _light_code(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """The exhaustive tier and the crank, whose bytes are compared, keep the optimizer."""
    if request.node.get_closest_marker("exhaustive") is None and "crank" not in request.fixturenames:
        monkeypatch.setattr(binaries, "FLAGS", (*binaries.FLAGS, "-O0"))
