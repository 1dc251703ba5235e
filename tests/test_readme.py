"""The README: its file and scripts run, its equations are those of the script, its commands exist."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import symbody
from benchmarks.__main__ import BENCHMARKS

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
SCRIPT = "\n".join(re.findall(r"```python\n(.*?)```", README, re.DOTALL))
LIVE_PAGE = Path(symbody.__file__).parent / "visual" / "pages" / "live.html"


def test_the_file_shown_is_the_example() -> None:
    (shown,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    example = ROOT / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"
    assert tomllib.loads(shown) == tomllib.loads(example.read_text(encoding="utf-8"))


@pytest.mark.skipif(not LIVE_PAGE.is_file(), reason="the pages that show motions are not built")
def test_scripts_run_and_give_the_equations_shown(tmp_path: Path) -> None:
    (equations,) = re.findall(r"```math\n(.*?)```", README, re.DOTALL)
    script = f"{SCRIPT}\nprint('LATEX:', eqs.latex())"
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.partition("LATEX:")[2].split() == equations.split()
    assert {path.name for path in tmp_path.iterdir()} == {"cart_pole.png", "cart_pole.html"}


def test_one_line_runs_the_tests() -> None:
    """CI takes its command from this line."""
    assert len(re.findall(r"-m pytest$", README, re.MULTILINE)) == 1


@pytest.mark.parametrize("repository", ["https://forge.example/symbody", ""])
def test_links_lead_somewhere_from_a_package_index(repository: str) -> None:
    """Whole ones where the address of the repository is known; words alone where it is not."""
    pytest.importorskip("hatchling")
    sys.path.insert(0, str(ROOT))
    try:
        text = import_module("hatch_build").readme_for_index(README, repository)
    finally:
        sys.path.remove(str(ROOT))
    places = re.findall(r"\]\(([^)]*)\)", text) + re.findall(r'src(?:set)?="([^"]*)"', text)
    assert all(place.startswith("https://") for place in places)
    assert text.count("```") == README.count("```")
    if repository:
        named = [place.removeprefix(f"{repository}/").split("/", 2) for place in places]
        files = {name.partition("#")[0] for kind, _, name in named if kind in ("blob", "raw")}
        assert len(files) > 40 and all((ROOT / name).exists() for name in files)


def test_commands_that_repeat_figures_exist() -> None:
    named = re.findall(r"python -m benchmarks (\w+)", README)
    assert named and set(named) <= BENCHMARKS.keys() | {"record"}


def test_first_picture_moves_and_is_small() -> None:
    """One for light and one for dark pages."""
    films = re.findall(r'src(?:set)?="([^"]+)"', README)[:2]
    assert [name.endswith("_dark.gif") for name in films] == [True, False]
    for name in films:
        film = (ROOT / name).read_bytes()
        assert film.count(b"\x21\xf9\x04") > 20  # a graphic control block a frame
        assert len(film) < 1_000_000
        assert README.index(name) < 400


def test_every_file_it_links_to_exists() -> None:
    links = {link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", README)}
    assert [link for link in sorted(links) if not (ROOT / link).exists()] == []
