"""Python's search for cyclic garbage: off while many values are made that stay, and then as it was."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path

import pytest

import symbody as sb
from benchmarks.large_mechanisms import chain
from symbody.collection import without_collection


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    yield
    gc.enable()


def test_it_is_off_inside_and_on_again_behind_an_error() -> None:
    with pytest.raises(ZeroDivisionError), without_collection():
        assert not gc.isenabled()
        1 / 0  # noqa: B018
    assert gc.isenabled()


def test_who_has_it_off_keeps_it_off() -> None:
    gc.disable()
    with without_collection():
        pass
    assert not gc.isenabled()


@pytest.mark.exhaustive
def test_reading_forming_and_compiling_leave_it_be(tmp_path: Path) -> None:
    path = tmp_path / "chain.toml"
    sb.save_model(chain(3), path)
    sb.compile(sb.form_equations(sb.load_model(path)), "udot", quick=True)  # imports what it needs
    sb.save_model(chain(40), path)
    phases: list[str] = []

    def note(phase: str, _: dict[str, int]) -> None:
        phases.append(phase)

    gc.collect()
    gc.callbacks.append(note)
    try:
        function = sb.compile(sb.form_equations(sb.load_model(path)), "udot", quick=True)
    finally:
        gc.callbacks.remove(note)
    assert gc.isenabled() and function.operations > 1000
    assert phases.count("start") < 60  # twice as often otherwise
