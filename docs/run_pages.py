"""Run the scripts of pages, renew what they print and draw: ``python docs/run_pages.py docs/tutorial/*.md``.

The Python blocks of a page are one script, run from top to bottom in a folder with nothing but ``examples``,
and so are the commands of symbody in blocks in ``sh``. A block in ``text`` right below one of these is what
it prints. A block in ``toml`` or ``xml`` whose first line is a comment with the name of a file is written to
that file; all in ``toml`` are read. A block in ``math`` right below one in ``python`` holds the LaTeX of the
equations that it prints, which pages show typeset. A picture that the script writes takes the place of the
one in ``docs/pictures/tutorial``, those of the course in ``docs/pictures/course``.

What a block needs and the page does not show stands in a comment right above it, ``<!-- before: ... -->``:
Python, and lines that begin with ``symbody``. A block below ``<!-- not run: reason -->`` is left out.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import shutil
import sys
import tempfile
import tomllib
import unittest.mock
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sympy.physics.vector import vlatex, vprint

from symbody.cli import run as run_command

PICTURES = Path(__file__).parent / "pictures"
BLOCK = re.compile(
    r"^(?:<!-- (?P<mark>before|not run):(?P<comment>(?:(?!-->).)*)-->\n)?"
    r"```(?P<language>[a-z]+)\n(?P<text>.*?)^```\n",
    re.MULTILINE | re.DOTALL,
)
RUN = ("python", "sh", "toml", "xml", "text", "math")
SHOWN = ("text", "math")
WIDTH = 62  # letters of a row of equations, as wide as the text of the site
FILE = re.compile(r"(?:#|<!--) (?P<name>\w+\.(?:toml|urdf|csv))\b")


@dataclass(frozen=True, slots=True)
class Block:
    """One block of code in a page.

    Attributes
    ----------
    language : str
        Its language.
    text : str
        What stands in it.
    start, end : int
        Where ``text`` begins and ends in the page [characters].
    follows : bool
        Whether nothing but blank lines stands between it and the block before.
    before : str
        What is run before it.
    reason : str
        Why it is not run; empty if it is.
    """

    language: str
    text: str
    start: int
    end: int
    follows: bool
    before: str = ""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Output:
    """What one block printed, and the block of the page that shows it, if any."""

    code: Block
    printed: str
    shown: Block | None


def blocks(page: str) -> Iterator[Block]:
    """Yield the blocks of code of a page in their order."""
    end = 0
    for match in BLOCK.finditer(page):
        between = page[end : match.start()]
        yield Block(
            match["language"],
            match["text"],
            match.start("text"),
            match.end("text"),
            end > 0 and not between.strip(),
            match["comment"].strip() if match["mark"] == "before" else "",
            match["comment"].strip() if match["mark"] == "not run" else "",
        )
        end = match.end()


def run_page(page: str, folder: Path) -> list[Output]:
    """Run the script of a page in a folder; return what each of its blocks printed."""
    listed = list(blocks(page))
    outputs: list[Output] = []
    names: dict[str, Any] = {"__name__": "__page__"}
    (folder / "examples").symlink_to(Path(__file__).parents[1] / "examples", target_is_directory=True)
    with contextlib.chdir(folder):
        for block, below in zip(listed, [*listed[1:], None], strict=False):
            if block.reason:
                continue
            if block.language not in RUN:
                raise ValueError(f"a block in {block.language} is not run: say why in a comment above it")
            if block.before:
                _run_before(block.before, names)
            if block.language in ("python", "sh"):
                shown = below if below and below.language in SHOWN and below.follows else None
                run = _typeset if shown and shown.language == "math" else _capture
                outputs.append(Output(block, run(block, names), shown))
            else:
                _write_file(block)
    return outputs


def _capture(block: Block, names: dict[str, Any]) -> str:
    """Run a block; return what it prints."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        _run_block(block, names)
    return printed.getvalue()


def _typeset(block: Block, names: dict[str, Any]) -> str:
    """Run a block; return the equations and SymPy expressions that it prints as LaTeX, each in its row."""
    rows: list[str] = []

    def keep(value: Any) -> None:
        rows.append(value.latex(width=WIDTH) if hasattr(value, "latex") else vlatex(value))

    own = {name: names[name] for name in ("print", "vprint") if name in names}
    names.update(dict.fromkeys(["print", *own], keep))
    with unittest.mock.patch("sympy.physics.vector.vprint", keep):
        _run_block(block, names)
    names["print"] = print
    names.update(vprint=vprint)
    if len(rows) == 1:
        return rows[0] + "\n"
    return "\n".join([r"\begin{aligned}", *(f"& {row} \\\\" for row in rows), r"\end{aligned}", ""])


def _run_before(text: str, names: dict[str, Any]) -> None:
    """Run what a page does not show; what it prints is not shown either."""
    lines = text.splitlines()
    with contextlib.redirect_stdout(io.StringIO()):
        _run_commands(line for line in lines if line.startswith("symbody "))
        exec(
            compile("\n".join(line for line in lines if not line.startswith("symbody ")), "page", "exec"),
            names,
        )


def _run_block(block: Block, names: dict[str, Any]) -> None:
    if block.language == "python":
        exec(compile(block.text, "page", "exec"), names)
    else:
        _run_commands(block.text.splitlines())


def _run_commands(lines: Iterable[str]) -> None:
    for line in lines:
        command, *arguments = shlex.split(line, comments=True)
        if command != "symbody" or run_command(arguments):
            raise ValueError(f"{line} does not run")


def _write_file(block: Block) -> None:
    """Write a block that names its file; blocks in TOML must be TOML."""
    if block.language == "toml":
        tomllib.loads(block.text)
    if named := FILE.match(block.text):
        Path(named["name"]).write_text(block.text, encoding="utf-8")


def renew(path: Path) -> None:
    """Run one page, write what it prints into it, and its pictures beside the others."""
    text = path.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        for output in reversed(run_page(text, Path(folder))):
            if output.shown:
                text = text[: output.shown.start] + output.printed + text[output.shown.end :]
        for picture in [*Path(folder).glob("*.svg"), *Path(folder).glob("*.png")]:
            part = "course" if path.parent.name == "course" else "tutorial"
            shutil.copy(picture, PICTURES / part / picture.name)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    os.environ.setdefault("MPLBACKEND", "agg")
    for argument in sys.argv[1:]:
        renew(Path(argument))
        print(argument)
