"""The workflows of a forge call what exists, on the versions that the package names.

Their form is checked by `check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml` and
`zizmor --offline .github`, which are too large to be dependencies of the tests.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import textwrap
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
WORKFLOWS = {path.stem: path.read_text("utf-8") for path in (ROOT / ".github" / "workflows").glob("*.yml")}
README = (ROOT / "README.md").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CLASSIFIERS = PROJECT["classifiers"]


def scripts(text: str) -> list[str]:
    """The commands of each step."""
    blocks = re.findall(r"^( +)(?:- )?run: \|\n((?:\1 +.*\n|\n)+)", text, re.MULTILINE)
    return [textwrap.dedent(block) for _, block in blocks] + re.findall(r"run: ([^|\n].*)", text)


def test_there_are_tests_weekly_parts_and_a_site() -> None:
    assert {"tests", "weekly", "site"} <= WORKFLOWS.keys()
    assert all(scripts(text) for text in WORKFLOWS.values())
    assert ".ci/run" in scripts(WORKFLOWS["tests"]) and (ROOT / ".ci" / "run").stat().st_mode & 0o100


def test_the_versions_of_python_are_those_of_the_package() -> None:
    named = {name.rpartition(" ")[2] for name in CLASSIFIERS if re.search(r":: 3\.\d+$", name)}
    matrices = re.findall(r"python: \[(.*)\]", WORKFLOWS["tests"])
    assert len(matrices) == 2
    for matrix in matrices:
        assert set(re.findall(r"[\d.]+", matrix)) == named
    assert PROJECT["requires-python"] == f">={min(named)}"


def test_systems_are_promised_when_the_tests_have_run_there() -> None:
    systems = {name.rpartition(" ")[2] for name in CLASSIFIERS if name.startswith("Operating System")}
    if any("Not yet run" in text for text in WORKFLOWS.values()):
        assert systems == {"Linux"}
        assert "Linux" in README.partition("## Install")[2].partition("##")[0]
    assert re.search(r"system: \[ubuntu-\S+, macos-\S+, windows-\S+\]", WORKFLOWS["tests"])


def test_lines_that_are_taken_from_the_readme_are_there_once() -> None:
    """As `grep` takes them."""
    assert README.count("&& .venv/bin/symbody simulate") == 1
    (line,) = re.findall(r'pip install "\.\[docs\]" && python -m sphinx [^`\n]*', README)
    assert line.endswith("docs docs/_build")
    first = next(each for each in README.splitlines() if "&& .venv/bin/symbody simulate" in each)
    assert first.count("pip install .") == 1 and first.endswith("demo/spring_mass_damper.toml")
    assert all(
        script in README for text in WORKFLOWS.values() for script in re.findall(r"grep -m 1 '([^']*)'", text)
    )


def test_files_and_options_that_are_named_exist() -> None:
    text = "\n".join(script for each in WORKFLOWS.values() for script in scripts(each))
    assert all((ROOT / name).is_file() for name in re.findall(r"python (\S+\.py)", text))
    assert set(re.findall(r"\[([a-z,]+)\]\"", text)) <= {"test", "test,peers"}
    assert '"--part"' in (ROOT / "tests" / "tiers.py").read_text("utf-8") + (
        ROOT / "tests" / "conftest.py"
    ).read_text("utf-8")


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_each_script_is_one_that_bash_reads() -> None:
    text = "\n".join(
        re.sub(r"\$\{\{.*?\}\}", "value", script) for each in WORKFLOWS.values() for script in scripts(each)
    )
    done = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_steps_come_from_the_forge_itself_and_keep_no_right() -> None:
    """Of others each would have to be pinned to a commit."""
    for text in WORKFLOWS.values():
        assert {name.partition("/")[0] for name in re.findall(r"uses: (\S+)", text)} == {"actions"}
        assert "permissions:\n  contents: read\n" in text
        assert text.count("actions/checkout") == text.count("persist-credentials: false")
