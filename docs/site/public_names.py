"""Pages of the reference, written from the stub that lists the public names in the order of their use."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import symbody
from sphinx.application import Sphinx

STUB = Path(symbody.__file__).with_suffix(".pyi")
SECTION = re.compile(r"^# (?P<title>.+)$")
NAME = re.compile(r"^from \.\w+ import (\w+) as (?P<name>\w+)$")


def sections() -> dict[str, list[str]]:
    """Return the public names under the headings of the stub."""
    found: dict[str, list[str]] = {}
    title = ""
    for line in STUB.read_text(encoding="utf-8").splitlines():
        if heading := SECTION.match(line):
            title = heading["title"]
        elif name := NAME.match(line):
            found.setdefault(title, []).append(name["name"])
    return found


def page(title: str, names: list[str]) -> str:
    """Return one page of the reference as reStructuredText."""
    return "\n".join([title, "=" * len(title), "", *(line for name in names for line in _entry(name))])


def _entry(name: str) -> Iterator[str]:
    kind = "class" if inspect.isclass(getattr(symbody, name)) else "function"
    yield f".. auto{kind}:: symbody.{name}"
    if kind == "class":
        yield "   :members:"
    yield ""


def write_pages(app: Sphinx) -> None:
    """Write the pages of the reference beside the sources, where they changed."""
    folder = Path(app.srcdir) / "reference" / "names"
    folder.mkdir(parents=True, exist_ok=True)
    for title, names in sections().items():
        file = folder / (re.sub(r"\W+", "_", title.lower()) + ".rst")
        text = page(title[0].upper() + title[1:], names)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def _keep_sentence(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Keep the first sentence of an attribute whole, which would else be cut at a colon into type and text."""
    if what in ("attribute", "property"):
        lines.insert(0, "")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the pages with Sphinx."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", _keep_sentence, priority=400)  # before napoleon, which has 500
    return {"parallel_read_safe": True, "parallel_write_safe": True}
