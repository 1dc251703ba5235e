"""The documentation site in a browser, from its folder: what people look for is found, and all can read it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from .conftest import REPOSITORY, wait_until

pytestmark = pytest.mark.exhaustive  # building the site takes a minute
# What users ask for, and the page that should be the first or second that is found.
WORDS = {
    "install": "installation.html",
    "units": "how_to/units.html",
    "gravity": "tutorial/1_spring_mass_damper.html",
    "spring": "forces.html",
    "spring stiffness": "forces.html",
    "damper": "tutorial/1_spring_mass_damper.html",
    "friction": "friction.html",
    "stick": "friction.html",
    "rope": "ropes.html",
    "gear": "constraints.html",
    "rolling": "constraints.html",
    "quaternion": "joints.html",
    "revolute": "joints.html",
    "closed loop": "how_to/closed_loops.html",
    "baumgarte": "how_to/keep_loops_closed.html",
    "redundant": "how_to/redundant_constraints.html",
    "singular": "kinematic_analysis.html",
    "reaction": "how_to/reactions.html",
    "eigenvalues": "linearization.html",
    "bode": "how_to/linear_models.html",
    "linearize": "linearization.html",
    "inverse dynamics": "inverse_dynamics.html",
    "events": "simulate.html",
    "bounce": "how_to/events_and_friction.html",
    "stiff": "how_to/stiff_systems.html",
    "controller": "tutorial/10_controller.html",
    "PID": "signals.html",
    "motor": "signals.html",
    "urdf": "urdf.html",
    "matlab": "code_generation.html",
    "simulink": "fmu.html",
    "modelica": "code_generation.html",
    "animation": "animation.html",
    "sweep": "sweeps.html",
    "parameter fit": "how_to/fit_parameters.html",
    "jacobian": "notation.html",
    "report": "report.html",
    "course": "course/index.html",
    "virtual work": "course/9_virtual_work.html",
}
# Of the checks only that of colours can end otherwise in the dark.
CHECKS: dict[str, dict[str, Any] | None] = {"light": None, "dark": {"runOnly": ["color-contrast"]}}
MOVES = """window.symbodyPlayer !== undefined
    || (window.symbodyLive !== undefined && symbodyLive.simulation.time > 0.1)"""
# How far the window, and the column of text in it, can be scrolled sideways [pixels].
SIDEWAYS = """() => [document.documentElement, document.querySelector('.content')].map(
    (element) => element ? element.scrollWidth - element.clientWidth : 0)"""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="pip install -e '.[docs]'")
    out = tmp_path_factory.mktemp("site")
    command = [
        "sphinx",
        "-q",
        "-b",
        "html",
        "-c",
        "docs/site",
        "-d",
        str(out / "trees"),
        "docs",
        str(out / "html"),
    ]
    subprocess.run([sys.executable, "-m", *command], cwd=REPOSITORY, check=True)
    return out / "html"


def results(page: Any, site: Path, words: str) -> list[str]:
    page.goto(f"{(site / 'search.html').as_uri()}?q={words.replace(' ', '+')}")
    wait_until(page, "document.querySelectorAll('#search-results p.search-summary').length > 0")
    wait_until(
        page,
        "document.querySelector('#search-results p.search-summary').innerText.match(/found|did not match/i)",
    )
    links = page.locator("#search-results ul.search li a")
    listed = [(str(link.get_attribute("href")).partition("#")[0], link.inner_text()) for link in links.all()]
    assert len(listed) == len(set(listed)), f"{words}: a page is listed twice"
    return [str(link.get_attribute("href")).partition("?")[0].partition("#")[0] for link in links.all()]


def test_search_finds_what_people_ask_for(chromium: Any, site: Path) -> None:
    page = (
        chromium.new_page()
    )  # browsers read no summaries from a folder, and say so; titles and links are there
    missed = {}
    for words, target in WORDS.items():
        first = list(dict.fromkeys(results(page, site, words)))[:2]
        if target not in first:
            missed[words] = first
    assert not missed


def pages(site: Path) -> list[Path]:
    every = sorted(site.rglob("*.html"))
    return [path for path in every if not path.relative_to(site).parts[0].startswith("_")]


def test_all_can_read_it(chromium: Any, site: Path) -> None:
    from axe_playwright_python.sync_playwright import Axe

    axe, faults = Axe(), []
    for scheme, options in CHECKS.items():
        page = chromium.new_page(color_scheme=scheme)
        for path in pages(site):
            page.goto(path.as_uri())
            for each in axe.run(page, options=options).response["violations"]:
                if each["impact"] in ("serious", "critical"):
                    html = each["nodes"][0]["html"][:160]
                    faults.append(f"{path.relative_to(site)}, {scheme}, {each['id']}: {html}")
    assert not faults


@pytest.mark.parametrize("name", ["index", "live_pages", "gallery/watt", "gallery/stick_slip"])
def test_pictures_of_mechanisms_move(name: str, chromium: Any, site: Path) -> None:
    page = chromium.new_page()
    page.goto((site / f"{name}.html").as_uri())
    page.locator("iframe.moving").scroll_into_view_if_needed()
    (frame,) = page.frames[1:]
    wait_until(frame, MOVES, 60.0)
    assert frame.evaluate("document.querySelector('canvas').width") > 200


def test_no_page_scrolls_sideways(chromium: Any, site: Path) -> None:
    names, wide = pages(site), []
    for width in (1350, 1100, 800, 390):
        page = chromium.new_page(viewport={"width": width, "height": 900})
        for path in names:
            page.goto(path.as_uri())
            window, column = page.evaluate(SIDEWAYS)
            if window > 0 or column > 1:
                wide.append(f"{path.relative_to(site)} at {width}: {max(window, column)}")
        page.close()
    assert len(names) > 100 and not wide
