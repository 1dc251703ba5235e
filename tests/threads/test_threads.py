"""The package in many threads at once, from cold, and in processes forked among them; each in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from symbody.single_flight import SingleFlight, once

ROOT = Path(__file__).parents[2]


def run(module: str, *arguments: int, cache: Path, **environment: str) -> None:
    command = [sys.executable, "-X", "dev", "-m", f"tests.threads.{module}", *map(str, arguments)]
    # Nothing that another test left: LLVM's code is compiled anew.
    places = {"SYMBODY_CACHE": str(cache), "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT)])}
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | places | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.exhaustive
def test_first_calls_of_a_process_in_16_threads(tmp_path: Path) -> None:
    run("every_call", 16, 2, cache=tmp_path)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_processes_forked_among_threads(tmp_path: Path) -> None:
    run("fork_among_threads", 2, cache=tmp_path)


@pytest.mark.exhaustive
@pytest.mark.parametrize("time", range(30))
def test_all_calls_in_16_threads_again_and_again(time: int, tmp_path: Path) -> None:
    run("every_call", 16, 4, cache=tmp_path)


@pytest.mark.exhaustive
def test_all_calls_in_16_threads_with_no_loop_compiled(tmp_path: Path) -> None:
    run("every_call", 16, 19, cache=tmp_path)


@pytest.mark.exhaustive
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
def test_many_processes_forked_among_threads(tmp_path: Path) -> None:
    run("fork_among_threads", 60, cache=tmp_path)


def test_a_value_is_made_once_and_the_others_wait() -> None:
    made: list[int] = []
    begin = threading.Barrier(8)
    hurry = threading.Event()

    @once
    def value() -> object:
        made.append(threading.get_ident())
        hurry.wait(0.05)  # long enough for the others to come
        return object()

    found: list[object] = []

    def work() -> None:
        begin.wait()
        found.append(value())

    threads = [threading.Thread(target=work) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and len(found) == 8 and len(set(map(id, found))) == 1


def test_what_raises_is_tried_again_and_the_oldest_go() -> None:
    values: SingleFlight[int, str] = SingleFlight(2)
    with pytest.raises(ZeroDivisionError):
        values.get(0, lambda: str(1 // 0))
    assert values.get(0, lambda: "zero") == "zero" and values.get(0, lambda: "again") == "zero"
    assert [values.get(k, lambda k=k: str(k)) for k in (1, 2)] == ["1", "2"]  # type: ignore[misc]
    assert values.peek(0) is None and len(values) == 2
