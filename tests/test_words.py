"""Texts for users use the words of docs/glossary.md."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# What users read. Texts of messages in src are to join as soon as they follow.
TEXTS = ("README.md", "CONTRIBUTING.md", "docs/**/*.md", "examples/**/*.md")
# Written from the source by docs/list_messages.py, or by the build of the site.
GENERATED = ("docs/messages.md", "docs/reference/model_file_entries.md", "docs/reference/command_line.md")
HEADING = "## Words in texts"
CODE = re.compile(r"^```.*?^```|^<!--.*?-->|`[^`\n]*`|\]\([^)]*\)", re.MULTILINE | re.DOTALL)


def rows() -> dict[str, str]:
    """The words to avoid, each with what to write instead."""
    _, _, table = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").partition(HEADING)
    pairs = re.findall(r"^\| (?!not \||---)(.+?) \| (.+?) \|$", table, re.MULTILINE)
    return {word: better for words, better in pairs for word in words.split(", ")}


def found(text: str, words: dict[str, str]) -> Iterator[str]:
    """Yield a line for each word of a text that has a better one."""
    prose = CODE.sub(lambda code: re.sub(r"[^\n]", " ", code[0]), text)
    for word, better in words.items():
        pattern = r"\b" + r"\s+".join(map(re.escape, word.split())) + r"\b"
        for match in re.finditer(pattern, prose, re.IGNORECASE):
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
