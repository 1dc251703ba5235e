"""Rewrite the table of docs/messages.md from the messages in the source: ``python docs/list_messages.py``.

A message is any call whose arguments hold a code such as ``"model.axis_letter"`` followed by where, what,
why and fix; changing parts show as an ellipsis.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
CODE = re.compile(r"[a-z][a-z_]*\.[a-z][a-z0-9_]*")


def messages() -> dict[str, tuple[str, str]]:
    """Return for each code what the message says and how it is mended."""
    found: dict[str, tuple[str, str]] = {}
    for path in sorted((ROOT / "src").rglob("*.py")):
        if path.parent.name == "llvm":  # names of values in machine code look like codes
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                for code, what, fix in _message(node):
                    old = found.get(code, ("", ""))
                    found[code] = (old[0] or what, old[1] or fix)
    return dict(sorted(found.items()))


def _message(call: ast.Call) -> Iterator[tuple[str, str, str]]:
    for k, argument in enumerate(call.args):
        code = _template(argument)
        if isinstance(argument, ast.Constant | ast.JoinedStr) and CODE.fullmatch(code.replace("…", "x")):
            rest = call.args[k + 1 :]
            named = {word.arg: _template(word.value) for word in call.keywords}
            texts = [_template(item) for item in rest]
            what = named.get("what") or next((text for text in texts if " " in text), "")
            fix = named.get("fix") or (texts[-1] if len(texts) > 2 and " " in texts[-1] else "")
            if what:
                yield code, what, fix


def _template(node: ast.expr) -> str:
    if isinstance(node, ast.Constant):
        return re.sub(r"\{[a-z]+\}", "…", node.value) if isinstance(node.value, str) else "…"
    if isinstance(node, ast.JoinedStr):
        return "".join(_template(part) for part in node.values)
    return "…"


def table() -> str:
    """Return the table as Markdown."""
    rows = [f"| `{code}` | {_cell(what)} | {_cell(fix)} |" for code, (what, fix) in messages().items()]
    return "\n".join(["| code | meaning | cure |", "| --- | --- | --- |", *rows]) + "\n"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", r"\|")


if __name__ == "__main__":
    page = ROOT / "docs" / "messages.md"
    head = page.read_text(encoding="utf-8").partition("| code |")[0]
    page.write_text(head + table(), encoding="utf-8")
