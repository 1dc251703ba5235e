"""Each source that is cited by author and year is in docs/references.bib, whose page is current."""

from __future__ import annotations

import re
import sys
import unicodedata
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NAME = r"[A-Z][\w'-]+"
# "Luh, Walker & Paul (1980)", "Hairer and Wanner 1996", "Featherstone (2008"
CITED = re.compile(rf"\b({NAME})((?:, {NAME})*,? (?:&|and) {NAME})? \(?((?:18|19|20)\d\d)\b")
# Of the paper, in the order of JOSS.
SECTIONS = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
]
REACH = 110  # letters before the year in which its authors stand
# A word before a year that is no author: titles, publishers, standards, languages.
OTHERS = {
    "Fortran",
    "RSS",
    "SIAM",
    "Springer",
    "Press",
    "Stanford",
    "University",
    "Diego",
    "Hall",
    "Allyn",
    "II",
    "In",
}


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> object:
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    sys.modules.pop("list_references", None)
    return import_module("list_references")


def plain(text: str) -> str:
    """Letters without accents, as the source writes names."""
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c)).casefold()


def citations() -> Iterator[tuple[str, str, str]]:
    """Yield the words before each year that stands as one of a source does, the year, and the file."""
    docs = ROOT / "docs"
    for path in [*(ROOT / "src").rglob("*.py"), *docs.glob("*.md"), *(docs / "derivations").glob("*.md")]:
        if path.name in ("references.md", "installation.md", "benchmarks.md"):
            continue
        text = re.sub(r"[\s\"]+", " ", path.read_text("utf-8"))
        for found in CITED.finditer(text):
            if found[1] not in OTHERS:
                yield (
                    text[max(0, found.end() - REACH) : found.end() - 4],
                    found[3],
                    str(path.relative_to(ROOT)),
                )


def test_the_page_is_that_of_the_file(script) -> None:  # type: ignore[no-untyped-def]
    assert (ROOT / "docs" / "references.md").read_text("utf-8") == script.page(), (
        "run: python docs/list_references.py"
    )


def test_entries_are_whole_and_their_addresses_well_formed(script) -> None:  # type: ignore[no-untyped-def]
    entries = script.references()
    text = (ROOT / "docs" / "references.bib").read_text("utf-8")
    assert len(entries) == text.count("\n@") + 1 > 50
    assert len({each.key for each in entries}) == len(entries)
    for each in entries:
        assert {"author", "title", "year"} <= each.fields.keys() and each.line()
        assert each.key.endswith(each.fields["year"]), each.key
        assert re.fullmatch(r"10\.\d{4,5}/\S+", each.fields.get("doi", "10.1000/none")), each.key
        assert each.kind != "article" or {"journal", "volume", "pages"} <= each.fields.keys(), each.key
        assert not re.search(r"\d-+\d", each.fields.get("journal", each.fields.get("booktitle", ""))), (
            each.key
        )
    assert sum("doi" in each.fields for each in entries) > 40


def test_each_source_that_two_authors_or_a_year_name_is_listed(script) -> None:  # type: ignore[no-untyped-def]
    known = {
        (plain(part), each.fields["year"])
        for each in script.references()
        for name in each.surnames
        for part in name.split()
    }
    found = list(citations())
    missing = [
        f"{path}: {words}{year}"
        for words, year, path in found
        if not any(
            then == year and re.search(rf"\b{re.escape(name)}\b", plain(words)) for name, then in known
        )
    ]
    assert len(found) > 60
    assert missing == []


def test_the_paper_cites_what_is_listed_and_shows_what_is_there(script) -> None:  # type: ignore[no-untyped-def]
    text = (ROOT / "paper" / "paper.md").read_text("utf-8")
    body = text.split("---", 2)[2]
    cited = set(re.findall(r"(?<![\w`])@(\w+)", body))
    assert cited and cited <= {each.key for each in script.references()}
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", body)
    assert pictures and all((ROOT / "paper" / name).is_file() for name in pictures)
    sections = re.findall(r"^# (.+)$", body, re.MULTILINE)
    assert sections[: len(SECTIONS)] == SECTIONS and 750 <= len(body.split()) <= 1750  # what JOSS asks for
    assert all((ROOT / name).is_file() for name in re.findall(r"`(docs/[\w./]+)`", body))
