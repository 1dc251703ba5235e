"""Model files with parts and tables in the diagram editor: opened with a note, saved with what they name."""

from __future__ import annotations

from pathlib import Path

from symbody.builder.model_text import data_from_text, text_from_data
from tests.formats.test_includes import write


def test_a_file_with_parts_is_opened_and_saved_without_losing_them(tmp_path: Path) -> None:
    path = write(tmp_path)
    text, folder = path.read_text(encoding="utf-8"), str(tmp_path)
    opened = data_from_text(text, path.name, folder)
    assert opened.model is not None and len(opened.data["include"]) == 2
    assert [body["name"] for body in opened.data["body"]] == ["Chassis"]
    assert all(note["severity"] == "note" and "part" in note["what"] for note in opened.problems)
    assert len(opened.problems) == 2
    assert text_from_data(opened.data, text, folder) == text
    changed = {**opened.data, "parameters": {**opened.data["parameters"], "w": "0.7"}}
    saved = text_from_data(changed, text, folder)
    assert saved == text.replace("w = 0.6", "w = 0.7")


def test_a_part_that_is_missing_is_a_problem_and_is_not_lost(tmp_path: Path) -> None:
    path = write(tmp_path)
    (tmp_path / "parts" / "arm.toml").unlink()
    text, folder = path.read_text(encoding="utf-8"), str(tmp_path)
    opened = data_from_text(text, path.name, folder)
    assert opened.model is None
    assert {problem["code"] for problem in opened.problems} == {"file.missing"}
    assert text_from_data(opened.data, text, folder).count("[[include]]") == 2
