"""Every message of the source stands in docs/messages.md."""

from __future__ import annotations

import gc
import runpy
from collections.abc import Iterator
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def listed() -> Iterator[tuple[str, list[str]]]:
    """The table, and the messages without a cure; the syntax trees of the whole source are gone again."""
    gc.disable()  # it would look at a million nodes again and again
    try:
        lister = runpy.run_path(str(DOCS / "list_messages.py"))
        found = lister["table"](), lister["without_cure"]()
    finally:
        gc.enable()
    yield found


def test_the_table_of_messages_is_current(listed: tuple[str, list[str]]) -> None:
    table, _ = listed
    assert table in (DOCS / "messages.md").read_text(encoding="utf-8"), "run: python docs/list_messages.py"
    assert table.count("\n") > 500


def test_every_message_says_what_to_do(listed: tuple[str, list[str]]) -> None:
    _, without_cure = listed
    assert without_cure == []
