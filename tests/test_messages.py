"""Every message of the source stands in docs/messages.md."""

from __future__ import annotations

import runpy
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def test_the_table_of_messages_is_current() -> None:
    table = runpy.run_path(str(DOCS / "list_messages.py"))["table"]()
    assert table in (DOCS / "messages.md").read_text(encoding="utf-8"), "run: python docs/list_messages.py"
    assert table.count("\n") > 50
