"""What README and pages say of speed beside others is what the record holds, and nothing else."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from benchmarks import record

ROOT = Path(__file__).parents[1]
HELD = json.loads(record.FILE.read_text("utf-8")) if record.FILE.is_file() else {}


@pytest.mark.parametrize("page", record.PAGES)
def test_blocks_are_those_of_the_record(page: str) -> None:
    text = (ROOT / page).read_text("utf-8")
    assert text.count("<!-- figures: sentence -->") == 1
    assert text == record.rendered(text, HELD), "run: python -m benchmarks render"
    assert list(record.speeds_outside_of_blocks(text)) == []


def test_a_changed_figure_and_a_claim_beside_the_blocks_are_seen() -> None:
    text = (ROOT / "README.md").read_text("utf-8")
    start = text.index("takes", text.index("<!-- figures: sentence -->"))
    changed = text[:start] + re.sub(r"\d", "7", text[start : start + 20]) + text[start + 20 :]
    assert record.rendered(changed, HELD) == text
    claims = ["It is 30 times as fast as others.", "5.5 to 12 times as long", "3x faster"]
    assert list(record.speeds_outside_of_blocks("\n".join(["<!-- -->", *claims]))) == claims


def test_the_record_says_where_and_when_and_keeps_each_sample() -> None:
    assert {"date", "processor", "processors", "load", "python", "versions"} <= HELD.keys()
    assert {"symbody", "numpy", "llvmlite", "mujoco"} <= HELD["versions"].keys()
    figures = HELD["robots"]["figures"]
    assert all(len(each["nanoseconds"]) == HELD["rounds"] for each in figures)
    robots = {each["robot"] for each in figures}
    left_out = {
        name for name in record.MEASURED if f"{name} was not measured" in " ".join(HELD["robots"]["notes"])
    }
    assert "ur5" in robots and robots == set(record.MEASURED) - left_out
    generated = [each for each in figures if each["engine"] in ("symbody's C", "MJX", "Pinocchio by CasADi")]
    assert generated and all(each["prepared"] > 0 for each in generated)
