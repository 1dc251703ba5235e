"""Write pages as notebooks: ``python docs/write_notebooks.py docs/course/*.md -o lessons``.

Text becomes Markdown cells and blocks in Python become cells of code; what pages show as printed is left to
the notebook, and pictures are shown from the files that its code writes. What pages fold is folded. Pages
without code in Python are left out.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

# A block of code, the first or last line of what is folded, or a picture.
PART = re.compile(
    r"^```(?P<language>[^\n]*)\n(?P<code>.*?)^```\n"
    r"|^:::\{dropdown\} (?P<title>[^\n]*)\n"
    r"|^(?P<end>:::)\n"
    r"|^!\[(?P<caption>[^\]]*)\]\([^)\n]*/(?P<picture>[^/)\n]+)\)\n",
    re.MULTILINE | re.DOTALL,
)
LINK = re.compile(r"\[(?P<text>[^\]]+)\]\((?P<page>[^)#\s]+)\.md(?P<place>#[^)]*)?\)")
# Pictures are files, shown from there.
HEAD = 'import matplotlib\n\nmatplotlib.use("agg")\nfrom IPython.display import SVG'


def cells(page: str) -> Iterator[Any]:
    """Yield the cells of a page in their order."""
    yield _code(HEAD, 0, folded=True)
    title, end, count = "", 0, 0
    for part in [*PART.finditer(page), None]:
        text = _linked(page[end : part.start() if part else None]).strip()
        end = part.end() if part else end
        if text:
            count += 1
            yield _markdown(text, title, count)
        if part is None:
            return
        if part["language"] == "python":
            count += 1
            yield _code(part["code"], count, folded=bool(title))
        elif part["language"] == "sh":
            count += 1
            yield _markdown(part[0], "", count)
        elif part["picture"]:
            count += 1
            yield _code(f'SVG("{part["picture"]}")  # {part["caption"]}', count, folded=bool(title))
        elif part["title"] or part["end"]:
            title = part["title"] or ""


def _markdown(text: str, title: str, count: int) -> Any:
    shown = f"<details><summary>{title}</summary>\n\n{text}\n\n</details>" if title else text
    return new_markdown_cell(shown, id=f"cell-{count}")


def _code(text: str, count: int, *, folded: bool) -> Any:
    metadata = {"jupyter": {"source_hidden": True, "outputs_hidden": True}} if folded else {}
    return new_code_cell(text.strip(), id=f"cell-{count}", metadata=metadata)


def _linked(text: str) -> str:
    """Let links between lessons lead to notebooks; those to other pages become their text."""

    def replaced(link: re.Match[str]) -> str:
        lesson = "/" not in link["page"] and link["page"][0].isdigit()
        return f"[{link['text']}]({link['page']}.ipynb)" if lesson else link["text"]

    return LINK.sub(replaced, text)


def notebook(page: str) -> Any:
    """Return the notebook of a page, without outputs."""
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    return new_notebook(cells=list(cells(page)), metadata=kernel)


def write(pages: list[Path], folder: Path) -> list[Path]:
    """Write the notebooks of all pages with code in Python into a folder; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for page in pages:
        text = page.read_text(encoding="utf-8")
        if "```python\n" in text:
            paths.append(folder / f"{page.stem}.ipynb")
            nbformat.write(notebook(text), paths[-1])
    return paths


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write pages as notebooks.")
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=Path("lessons"))
    arguments = parser.parse_args()
    for path in write(arguments.pages, arguments.out):
        print(path)
