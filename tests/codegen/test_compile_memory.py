"""Compiled functions go when nobody holds them: machine code, linkers, and the nodes of their values."""

from __future__ import annotations

import gc
import sys
from pathlib import Path

import pytest

import symbody as sb
from symbody.storage import VARIABLE
from tests.equations.test_derivation import chain


def resident() -> int:
    """Memory of this process [kB], machine code included."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * 4


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read where Linux tells it")
@pytest.mark.parametrize(
    ("times", "lanes"),
    [
        (40, False),
        pytest.param(1000, False, marks=pytest.mark.exhaustive),
        pytest.param(1000, True, marks=pytest.mark.exhaustive),
    ],
)
def test_compilations_leave_memory_constant(times: int, lanes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "off")
    eqs = sb.form_equations(chain(2))
    batch = [[0.1, 0.2]] * 16

    def compiled(mass: float) -> sb.CompiledFunction:
        function = sb.compile(eqs, "udot", {"m": mass}, quick=True, lanes=lanes, specialize=True)
        function(0.0, batch, batch)
        return function

    def repeat(first: int, count: int) -> int:
        for k in range(first, first + count):
            compiled(k / 1024)
        gc.collect()
        return resident()

    before = repeat(1, 30)
    held = [compiled(k) for k in range(1, 31)]
    each = (resident() - before) / len(held)
    assert each > 4  # one takes a page at least, else nothing is measured here
    del held
    before = repeat(100, 30)
    # If each left a tenth behind this would fail; what is left is the number 1/1024, 2/1024, ... itself.
    assert repeat(200, times) - before < max(0.1 * times * each, 200)


def test_values_of_a_call_do_not_stay_in_the_equations() -> None:
    eqs = sb.form_equations(chain(3))
    sb.compile(eqs, "udot", {"m": 2})
    before = len(eqs.formed.graph.ops)
    for k in range(10):
        sb.compile(eqs, "udot", {"m": 3 + k})
    assert len(eqs.formed.graph.ops) <= before + 10  # the numbers themselves
