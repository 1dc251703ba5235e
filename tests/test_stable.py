"""The page of the declared core names what exists, and the schema, changelog and papers of the project fit."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import symbody as sb

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "src" / "symbody"
PAGE = (ROOT / "docs" / "stable.md").read_text("utf-8")
# What a path in the text may be relative to.
BASES = (ROOT, ROOT / "docs", SOURCES)
PATH = re.compile(r"`([a-z_]+(?:/[\w.]+)+/?)`")


def test_the_core_is_part_of_the_package() -> None:
    table = PAGE.partition("## The declared core")[2].partition("What is promised")[0]
    names = [name for name in re.findall(r"`(\w+)`", table) if name != "problems"]
    assert len(names) > 25 and all(hasattr(sb, name) for name in names)
    others = PAGE.partition("## Experimental")[2].partition("## Read")[0]
    assert not set(names) & set(re.findall(r"`(\w+)`", others))


def test_twenty_files_are_to_be_read() -> None:
    files = re.findall(r"`([a-z_/]+\.py)`", PAGE.partition("## Read these")[2])
    assert len(set(files)) == len(files) == 20
    assert all((SOURCES / name).is_file() for name in files)
    lines = sum(len((SOURCES / name).read_text("utf-8").splitlines()) for name in files)
    said = int(re.sub(r"\D", "", re.search(r"some ([\d,]+) lines", PAGE)[1]))  # type: ignore[index]
    assert abs(lines - said) < 0.2 * said


@pytest.mark.parametrize(
    "page", ["CONTRIBUTING.md", "docs/decisions.md", "docs/releasing.md", "docs/extending.md"]
)
def test_paths_in_papers_of_the_project_exist(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    found = PATH.findall(text)
    missing = [
        name
        for name in found
        if not any((base / name).exists() or (base / f"{name}.py").exists() for base in BASES)
    ]
    assert found and missing == []


def test_the_changelog_is_short_and_leads_to_pages() -> None:
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    assert len(text.splitlines()) < 60
    links = [link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    assert len(links) > 30 and all((ROOT / link).is_file() for link in links)


def test_the_version_is_one() -> None:
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text("utf-8"), re.MULTILINE)
    assert cited is not None and cited[1] == sb.__version__
    assert f"version {sb.__version__}" in (ROOT / "README.md").read_text("utf-8")
    assert f"## {sb.__version__} - " in (ROOT / "CHANGELOG.md").read_text("utf-8")
