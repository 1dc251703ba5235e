"""How the loop is compiled: not at import, once, and never twice on one computer."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba.core.caching import FunctionCache

from symbody.simulation.native import cases as native_cases
from symbody.simulation.native import interface as native_interface
from symbody.simulation.native import loop as native_loop
from symbody.simulation.native.lanes import lane_cases
from symbody.simulation.native.runge_kutta import DORMAND_PRINCE_8
from tests.simulation.right_hand_sides import nothing, oscillator, pendulum, rational, run

COMPILED_IN = (
    "interface.py",
    "layout.py",
    "projection.py",
    "stages.py",
    "simd.py",
    "step_bounds.py",
    "vectors.py",
)
FRESH_PROCESS = """
from symbody.simulation.native import loop as native_loop
print(len(native_loop.advance.signatures))
from tests.simulation.right_hand_sides import pendulum, run
run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0))
for loop in (native_loop.begin, native_loop.advance):
    print(len(loop.signatures), sum(loop.stats.cache_hits.values()), sum(loop.stats.cache_misses.values()))
"""


def test_one_compilation_serves_every_model_method_and_option() -> None:
    loops: list[Any] = [native_loop.begin, native_loop.advance]
    run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0), 8)
    # Sweeps, if they ran in this process before, have the loop compiled into theirs, in forms of their own.
    compiled = [len(loop.signatures) for loop in loops]
    run(oscillator, 1, 1, [0.0, 2.0], (1.0, 0.0), 5, times=[1.0], dense=False, stop_when_stiff=True)
    run(rational, 1, 0, [1.0], (0.0, 1.0), atol=[1e-9])
    run(rational, 1, 0, [1.0], (0.0, 1.0), atol=1e-9)
    run(nothing, 0, 0, [], (0, 1), 8, parameters=[1.0, 2.0], max_steps=10)
    assert [len(loop.signatures) for loop in loops] == compiled


def test_a_second_process_compiles_nothing_and_import_compiles_nothing() -> None:
    run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0))
    done = subprocess.run([sys.executable, "-c", FRESH_PROCESS], capture_output=True, text=True, timeout=120)
    assert done.stderr == ""
    assert done.stdout.split("\n") == ["0", "1 1 0", "1 1 0", ""]


def test_the_loop_works_where_nothing_can_be_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object) -> None:
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(FunctionCache, "__init__", refuse)

    @native_interface.compile_loop
    def double(x: float) -> float:
        return 2.0 * x

    assert double(2.0) == 4.0


def test_dense_output_rows_match_the_tableau() -> None:
    result = run(pendulum, 1, 1, [0.0, 2.0], (0.0, 1.0))
    assert result.dense_output is not None
    assert result.dense_output.pieces.shape[1] == DORMAND_PRINCE_8.dense_degree + 1
    assert np.isfinite(result.dense_output.pieces).all()


def test_the_cache_is_renewed_with_every_file_compiled_into_the_loop() -> None:
    # numba compares the text of loop.py alone; a new release over an old one would run the old loop.
    folder = Path(native_loop.__file__).parent
    texts = "".join((folder / name).read_text(encoding="utf-8") for name in COMPILED_IN)
    assert hashlib.sha256(texts.encode()).hexdigest()[:16] == native_loop.SOURCES
    texts += (folder / "loop.py").read_text(encoding="utf-8")
    assert hashlib.sha256(texts.encode()).hexdigest()[:16] == native_cases.SOURCES
    more = ("cases.py", "lanes/arithmetic.py", "lanes/lane_steps.py", "lanes/lane_projection.py")
    texts += "".join((folder / name).read_text(encoding="utf-8") for name in more)
    assert hashlib.sha256(texts.encode()).hexdigest()[:16] == lane_cases.SOURCES
