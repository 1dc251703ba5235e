"""Licences travel with what is written and shipped: the whole notices in each page, all of them in the wheel."""

from __future__ import annotations

import re
import tomllib
import zipfile
from html import escape
from importlib.resources import files
from pathlib import Path

import pytest

import symbody as sb
from symbody.display.html import Markup, page
from tests.test_pages_build import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
LICENSES = (ROOT / "frontend" / "LICENSES.txt").read_text("utf-8")
FONT = files("symbody.display").joinpath("maths_font_license.txt").read_text("utf-8").strip()
OWN = (ROOT / "LICENSE").read_text("utf-8").strip()
HEADING = re.compile(r"^(\S+) [0-9.]+ \((\S+)\)$", re.MULTILINE)
BUILT = files("symbody.visual").joinpath("pages")

needs_pages = pytest.mark.skipif(
    not BUILT.joinpath("player.html").is_file(), reason="the pages are not built: pip install -e . with Node"
)


def notice(package: str) -> str:
    """The text of one package in the file of all."""
    return next(part for part in LICENSES.split("-" * 78) if part.strip().startswith(f"{package} ")).strip()


def pendulum() -> sb.Model:
    bob = sb.Body("Bob", mass=1.0, frames={"pivot": sb.Frame(at=(0, 1, 0))})
    hinge = sb.Revolute("hinge", "ground", "Bob.pivot", axis="z", coordinate="theta")
    return sb.Model("pendulum", [bob, hinge], gravity=(0, "-9.81", 0))


def test_the_expression_names_the_licence_of_each_part() -> None:
    parts = {"BSD-3-Clause", "BSD-2-Clause", "OFL-1.1"} | {name for _, name in HEADING.findall(LICENSES)}
    assert set(PROJECT["license"].split(" AND ")) == parts


def test_each_licence_in_the_package_is_one_of_the_metadata() -> None:
    shipped = {
        path.relative_to(ROOT).as_posix()
        for path in (ROOT / "src").rglob("*")
        if path.is_file()
        and re.search("licen[cs]e", path.name, re.IGNORECASE)
        and path.suffix in ("", ".txt")
    }
    assert shipped <= set(PROJECT["license-files"])
    assert all((ROOT / name).is_file() for name in PROJECT["license-files"])


def test_types_alone_are_in_no_page_and_not_listed() -> None:
    names = [name for name, _ in HEADING.findall(LICENSES)]
    assert {"three", "uplot", "react", "@xyflow/react", "@dagrejs/graphlib"} <= set(names)
    assert names == sorted(set(names)) and not any(name.startswith("@types/") for name in names)


@needs_pages
@pytest.mark.parametrize(
    ("folder", "name", "packages"),
    [("visual", "player.html", ("three", "uplot")), ("visual", "live.html", ("three", "uplot")),
     ("visual", "widget.js", ("three", "uplot")),
     ("builder", "index.html", ("three", "uplot", "react", "react-dom", "@xyflow/react", "d3-zoom"))],
)  # fmt: skip
def test_each_page_holds_the_notices_of_what_is_in_it(
    folder: str, name: str, packages: tuple[str, ...]
) -> None:
    text = files(f"symbody.{folder}").joinpath("pages", name).read_text("utf-8")
    assert OWN in text and all(notice(each) in text for each in packages)
    holds_font = name in ("live.html", "index.html")
    assert (FONT in text) == holds_font
    listed = {each for each, _ in HEADING.findall(text.split("<style>")[0])}
    assert name == "index.html" or listed == set(packages)


@needs_pages
def test_pages_that_are_written_hold_them_too(tmp_path: Path) -> None:
    eqs = sb.form_equations(pendulum())
    sb.animate(sb.simulate(eqs, 0.1), tmp_path / "motion.html")
    sb.animate(eqs, tmp_path / "live.html", live=True)
    for name in ("motion.html", "live.html"):
        text = (tmp_path / name).read_text("utf-8")
        assert OWN in text and notice("three") in text and notice("uplot") in text
    assert FONT in (tmp_path / "live.html").read_text("utf-8")


def test_reports_and_notebooks_hold_the_licence_of_the_font_that_they_hold(tmp_path: Path) -> None:
    sb.save_report(sb.form_equations(pendulum()), tmp_path / "report.html")
    report = (tmp_path / "report.html").read_text("utf-8")
    assert "font/woff2" in report and escape(FONT, quote=False) in report
    shown = page("speed", Markup("<math><mover><mi>x</mi><mo>.</mo></mover></math>"))
    assert "font/woff2" in shown and escape(FONT, quote=False) in shown
    assert "OPEN FONT LICENSE" not in page("length", Markup("<math><mi>x</mi></math>"))


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_fmu_with_sources_holds_the_licence_of_the_headers(tmp_path: Path, version: str) -> None:
    sb.save_fmu(sb.form_equations(pendulum()), tmp_path / "a.fmu", version=version, platforms=())
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        kept = archive.read("documentation/licenses/fmi-headers.txt")
        core = [
            name for name in archive.namelist() if name.startswith("sources/") and name.endswith("instance.h")
        ]
        assert kept == files("symbody.fmu").joinpath("headers", "LICENSE.txt").read_bytes()
        assert all(b"SPDX-License-Identifier: BSD-3-Clause" in archive.read(name) for name in core) and core
