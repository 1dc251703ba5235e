"""Texts for users use the words of docs/glossary.md."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# What users read, beside the strings and public docstrings of src and the strings of frontend/src.
TEXTS = ("README.md", "CONTRIBUTING.md", "docs/**/*.md", "examples/**/*.md")
# Written from the source by docs/list_messages.py, or by the build of the site.
GENERATED = ("docs/messages.md", "docs/reference/model_file_entries.md", "docs/reference/command_line.md")
SOURCES = ROOT / "src" / "symbody"
PAGES = ROOT / "frontend" / "src"
# A literal or a comment of TypeScript; what follows "//" inside a literal belongs to it.
LITERAL = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:[^"\\\n]|\\.)*"|`(?:[^`\\]|\\.)*`|>[^<>{}=;]+<', re.DOTALL)
HEADING = "## Words in texts"
CODE = re.compile(r"^```.*?^```|^<!--.*?-->|`[^`\n]*`|\]\([^)]*\)", re.MULTILINE | re.DOTALL)


def rows() -> dict[str, str]:
    """The words to avoid, each with what to write instead."""
    _, _, table = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").partition(HEADING)
    pairs = re.findall(r"^\| (?!not \||---)(.+?) \| (.+?) \|$", table, re.MULTILINE)
    return {word: better for words, better in pairs for word in words.split(", ")}


@cache
def any_of(words: tuple[str, ...]) -> re.Pattern[str]:
    """Return the pattern that finds one of some words, with any space between their parts."""
    spaced = (r"\s+".join(map(re.escape, word.split())) for word in words)
    return re.compile(rf"\b(?:{'|'.join(spaced)})\b", re.IGNORECASE)


def found(text: str, words: dict[str, str]) -> Iterator[str]:
    """Yield a line for each word of a text that has a better one."""
    if not any_of(tuple(words)).search(text):
        return
    prose = CODE.sub(lambda code: re.sub(r"[^\n]", " ", code[0]), text)
    for word, better in words.items():
        for match in any_of((word,)).finditer(prose):
            line = prose.count("\n", 0, match.start()) + 1
            yield f"line {line}: {word!r}, better: {better}"


def texts() -> list[Path]:
    paths = {path for pattern in TEXTS for path in ROOT.glob(pattern)}
    return sorted(path for path in paths if path.relative_to(ROOT).as_posix() not in GENERATED)


def test_texts_use_the_common_words() -> None:
    words, faults = rows(), []
    for path in texts():
        text = path.read_text(encoding="utf-8").partition(HEADING)[0]
        faults += [f"{path.relative_to(ROOT)}, {each}" for each in found(text, words)]
    assert not faults, "\n".join(faults)


def strings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield line and text of the strings with more than a word; what an f-string puts in is left out."""
    nodes = [node for node in ast.walk(tree) if isinstance(node, ast.Expr | ast.Constant | ast.JoinedStr)]
    parts = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    inner = parts | docs
    for node in nodes:
        if id(node) in inner or isinstance(node, ast.Expr):
            continue
        pieces = node.values if isinstance(node, ast.JoinedStr) else [node]
        text = "…".join(str(piece.value) for piece in pieces if isinstance(piece, ast.Constant))
        if " " in text.strip():
            yield node.lineno, text


def public_names() -> set[str]:
    stub = ast.parse((SOURCES / "__init__.pyi").read_text(encoding="utf-8"))
    return {name.name for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names}


def docstrings(tree: ast.Module, names: set[str]) -> Iterator[tuple[int, str]]:
    """Yield line and text of the docstrings of public functions and classes, and of public methods of these."""
    kinds = ast.ClassDef | ast.FunctionDef
    for top in tree.body:
        if isinstance(top, kinds) and top.name in names:
            inner = top.body if isinstance(top, ast.ClassDef) else []
            for node in (top, *(each for each in inner if isinstance(each, kinds))):
                if node is top or not node.name.startswith("_"):
                    yield node.lineno, ast.get_docstring(node) or ""


def page_strings(text: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of the literals and the text between tags in a file of TypeScript."""
    for match in LITERAL.finditer(text):
        if not match[0].startswith(("//", "/*")):
            yield text.count("\n", 0, match.start()) + 1, re.sub(r"\$\{[^}]*\}", "…", match[0].strip('`"<>'))


def faults_in(path: Path, pieces: Iterable[tuple[int, str]], words: dict[str, str]) -> list[str]:
    place = path.relative_to(ROOT)
    return [f"{place}, {line}: {each}" for line, text in pieces for each in found(text, words)]


def test_messages_and_docstrings_use_the_common_words() -> None:
    words, names, faults, count = rows(), public_names(), [], 0
    for path in sorted(SOURCES.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        pieces = [*strings(tree), *docstrings(tree, names)]
        count += len(pieces)
        faults += faults_in(path, pieces, words)
    assert not faults, "\n".join(faults)
    assert count > 4000


def test_pages_use_the_common_words() -> None:
    words, faults, count = rows(), [], 0
    for path in sorted(PAGES.rglob("*.ts*")):
        pieces = list(page_strings(path.read_text(encoding="utf-8")))
        count += len(pieces)
        faults += faults_in(path, pieces, words)
    assert not faults, "\n".join(faults)
    assert count > 1000


def test_strings_and_docstrings_are_read() -> None:
    code = ast.parse('def f():\n    """It goes on."""\n    return f"{goes} on, {x} is refused"  # anew\n')
    assert [text for _, text in strings(code)] == [" on, … is refused"]
    assert list(docstrings(code, {"f"})) == [(1, "It goes on.")] and not list(docstrings(code, set()))
    page = list(page_strings('/* is refused */ say("a loop", `of ${k} bodies`); <p>goes on</p> // anew'))
    assert [text for _, text in page] == ["a loop", "of … bodies", "goes on"]


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("A loop is refused.", 1),
        ("It goes\non.", 1),
        ("Four bars have one freedom,\nnot two freedoms.", 2),
        ("One degree of freedom; `it is refused`.\n```text\nanew\n```\n", 0),
    ],
)
def test_words_are_found_outside_of_code(text: str, count: int) -> None:
    assert len(list(found(text, rows()))) == count


def test_many_texts_are_read() -> None:
    assert len(rows()) > 40 and len(texts()) > 100
