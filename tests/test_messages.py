"""Every message of the source stands in docs/messages.md."""

from __future__ import annotations

import runpy
from functools import cache
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"


@cache
def lister() -> dict[str, Any]:
    return runpy.run_path(str(DOCS / "list_messages.py"))


def test_the_table_of_messages_is_current() -> None:
    table = lister()["table"]()
    assert table in (DOCS / "messages.md").read_text(encoding="utf-8"), "run: python docs/list_messages.py"
    assert table.count("\n") > 500


def test_every_message_says_what_to_do() -> None:
    assert lister()["without_cure"]() == []
