"""The lessons of the course as notebooks, and the table from the lines of the notes to them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

COURSE = Path(__file__).parents[1] / "docs" / "course"
LESSONS = sorted(
    path for path in COURSE.glob("[0-9]*.md") if "```python\n" in path.read_text(encoding="utf-8")
)
BEYOND = {"15_contact"}  # lessons on what the notes leave out
# Sections of the notes.
SECTIONS = (
    "1 1.1 1.2 1.2.1 1.2.2 1.2.3 1.3 1.3.1 1.3.2 1.3.3 1.4 1.4.1 1.4.2 2 2.1 2.1.1 2.1.2 2.1.3 2.1.3.4 2.1.5 2.2 2.3 "
    "2.3.1 2.4 3 3.1 3.1.1 3.1.2 3.2 3.2.1 3.2.2 3.3 4 4.1.1 4.1.2 4.1.3 4.2 4.3 4.3.1 4.4.1 4.4.2 4.5 4.5.1 4.5.1.1 "
    "4.5.1.2 4.5.2 4.5.3 4.6 4.7 4.8 4.9 4.10"
).split()


def test_each_section_of_the_notes_leads_to_a_lesson() -> None:
    rows = re.findall(
        r"^\| ([^|]+) \| [^\n]+ \| ([^|\n]+) \|$", (COURSE / "notes.md").read_text(encoding="utf-8"), re.M
    )
    taught = {re.split(r"[ ,]", place)[0] for place, _ in rows}
    assert set(SECTIONS) <= taught
    linked = {name for _, lessons in rows for name in re.findall(r"\((\w+)\.md", lessons)}
    assert linked == {path.stem for path in LESSONS} - BEYOND


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lessons_have_tasks_with_solutions(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert [
        part for part in ("**Aim.**", "\n## Theory\n", "\n## Example\n", "\n## Tasks\n") if part not in text
    ] == []
    tasks = re.findall(r"^(\d)\. ", text.partition("\n## Tasks\n")[2], re.M)
    assert len(tasks) >= 2 and tasks == re.findall(r"^:::\{dropdown\} Solution of task (\d)$", text, re.M)


@pytest.mark.exhaustive
@pytest.mark.filterwarnings("ignore")  # of other packages, in a kernel of their own
@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lessons_run_as_notebooks(path: Path, tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    from docs.write_notebooks import notebook

    page = path.read_text(encoding="utf-8")
    lesson = notebook(page)
    where = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(lesson, timeout=300, kernel_name="python3", resources=where).execute()
    code = [cell for cell in lesson.cells if cell.cell_type == "code"]
    assert sum("SVG(" in cell.source for cell in code) == page.count("](../pictures/course/")
    for cell in code[1:]:
        shows = "print(" in cell.source or "SVG(" in cell.source
        assert bool(cell.outputs) == shows or "Describe(" in cell.source, cell.source
