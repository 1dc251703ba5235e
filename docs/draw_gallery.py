"""Draw the gallery: `python docs/draw_gallery.py` shows examples, course notes and robots.

Each motion is written as a page by `animate`, opened in Chromium, and shown at three times, light and dark.
The sheets are docs/pictures/gallery_GROUP.webp, the third time dark; `--keep DIR` keeps pages and pictures.
The mechanisms of examples/gallery are drawn by docs/draw_mechanisms.py.
Chromium and the packages playwright, pillow, symbody[meshes] and example-robot-data are needed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import runpy
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from PIL import Image

import symbody as sb

HERE: Final = Path(__file__).resolve().parent
PICTURES: Final = HERE / "pictures"
EXAMPLES: Final = HERE.parent / "examples"
WINDOW: Final = (960, 640)
CELL: Final = (390, 260)
SHARES: Final = (0.0, 0.37, 0.9)  # of a motion, when it is shown
COLUMNS: Final = 1  # of exhibits in a sheet
FLAGS: Final = ("--headless", "--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader")
GROUPS: Final = ("examples", "notes", "robots")

# Notes that have nothing to show.
STILL: Final[Mapping[str, str]] = {
    "basics": "frames and vectors, no mechanism",
    "constraints": "position analysis: no motion over time",
    "virtual_work": "statics: no motion over time",
}


@dataclass(frozen=True, slots=True)
class Exhibit:
    """A motion of the gallery.

    Attributes
    ----------
    group, name : str
        One of `GROUPS`; a name within it.
    run : callable
        Returns the motion.
    options : mapping
        Of `animate`.
    """

    group: str
    name: str
    run: Callable[[], sb.Trajectory]
    options: Mapping[str, Any] = field(default_factory=dict)


def of_script(path: str, pick: Callable[[dict[str, Any]], sb.Trajectory]) -> Callable[[], sb.Trajectory]:
    """Return what runs a script of the examples and picks one of its motions."""

    def run() -> sb.Trajectory:
        with in_empty_folder(), contextlib.redirect_stdout(io.StringIO()):
            return pick(runpy.run_path(str(EXAMPLES / path)))

    return run


@contextlib.contextmanager
def in_empty_folder() -> Iterator[None]:
    """Work where scripts may leave their pictures."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def example(name: str, variable: str, **options: Any) -> Exhibit:
    """Return a motion that an example keeps under a name."""
    return Exhibit("examples", name, of_script(f"{name}/{name}.py", lambda found: found[variable]), options)


def note(name: str, pick: Callable[[dict[str, Any]], sb.Trajectory], **options: Any) -> Exhibit:
    """Return a motion of the course notes."""
    return Exhibit("notes", name, of_script(f"notes/{name}/{name}.py", pick), options)


def robots_folder() -> Path | None:
    """Return where the package example-robot-data keeps its robots, None if it is not installed."""
    for folder in map(Path, sys.path):
        robots = folder / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
        if robots.is_dir():
            return robots
    return None


def robot(name: str, path: str, gain: float = 40.0, sway: float = 0.5) -> Exhibit:
    """Return a robot whose joints are led to and fro by springs and dampers, against its weight."""

    def run() -> sb.Trajectory:
        folder = robots_folder()
        if folder is None:
            raise FileNotFoundError("example-robot-data is not installed: pip install example-robot-data")
        model = sb.load_urdf(folder / path)
        turning = {joint.coordinates[0] for joint in model.joints if isinstance(joint, sb.Revolute)}
        efforts = {}
        for k, effort in enumerate(model.inputs):
            joint = effort.removeprefix("tau_")
            aim = f"{sway * (-1) ** k if joint in turning else 0}*(1 - cos(pi*t))/2"
            efforts[effort] = f"{gain}*({aim} - {joint}) - {0.15 * gain}*{joint}_dot"
        return sb.simulate(sb.form_equations(model), 4.0, inputs=efforts, rtol=1e-5, atol=1e-6)

    return Exhibit("robots", name, run)


EXHIBITS: Final = (
    example("four_bar", "run", traces=["Coupler.P"]),
    example("slider_crank", "run", vectors="all"),
    example("spring_mass_damper", "fast"),
    example("cart_pole", "motion"),
    example("cart_pole_pid", "run"),
    example("parameter_fit", "run"),
    example("rr_robot", "run", traces=["Link2.P"]),
    example("projectile", "run", traces=["Body"]),
    example("spatial_four_bar", "run", traces=["Crank.pin", "Rocker.pin"]),
    example("spinning_top", "run", traces=["Top"]),
    example("spinning_top_omega", "run"),
    example("stewart_platform", "run"),
    example("robot_arm", "fall"),
    example("bicycle", "run"),
    example("dc_motor_arm", "step"),
    example("quarter_car", "run"),
    example("four_legs", "run"),
    example("quadruped", "run"),
    note("dynamics", lambda found: found["run"]),
    note("index_reduction", lambda found: found["kept"]),
    note("simulation", lambda found: found["run"]),
    note("position_velocity", lambda found: found["turning"]),
    note("equilibrium", lambda found: found["swing"]),
    note("friction", lambda found: found["stick_slip"]),
    note("inverse_dynamics", lambda found: found["back"]),
    note("linearization", lambda found: found["real"]),
    note("slider_crank_four_ways", lambda found: found["runs"]["drawn"]),
    note("quick_return", lambda found: found["runs"]["pin in a slot"]),
    note("four_bar_spring", lambda found: found["large"]),
    note("inverted_pendulum", lambda found: found["held"]["drawn"]),
    robot("ur5", "ur_description/urdf/ur5_robot.urdf"),
    robot("panda", "panda_description/urdf/panda.urdf"),
    robot("kinova", "kinova_description/robots/kinova.urdf"),
    robot("anymal", "anymal_b_simple_description/robots/anymal.urdf"),
    robot("solo12", "solo_description/robots/solo12.urdf", gain=5.0),
)


def photograph(page: Any) -> dict[str, list[Image.Image]]:
    """Return pictures of an open page at three times, of each theme."""
    pictures: dict[str, list[Image.Image]] = {"light": [], "dark": []}
    start, end = page.evaluate("[symbodyPlayer.clock.start, symbodyPlayer.clock.end]")
    for theme, shown in pictures.items():
        page.evaluate("name => symbodyPlayer.settings.set('theme', name)", theme)
        for share in SHARES:
            page.evaluate("t => symbodyPlayer.setTime(t)", start + share * (end - start))
            page.wait_for_timeout(80)
            shown.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
    return pictures


def contact_sheet(rows: list[list[Image.Image]]) -> Image.Image:
    """Return small pictures of exhibits, three each, in columns."""
    width, height = CELL
    lines = -(-len(rows) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * 3 * width, lines * height), "white")
    for k, row in enumerate(rows):
        line, column = divmod(k, COLUMNS)
        for j, picture in enumerate(row):
            small = picture.resize(CELL, Image.Resampling.LANCZOS)
            sheet.paste(small, ((3 * column + j) * width, line * height))
    return sheet


def draw_group(browser: Any, group: str, folder: Path) -> None:
    """Write the sheet of a group, and its pages and pictures to a folder."""
    rows = []
    for each in (each for each in EXHIBITS if each.group == group):
        path = folder / f"{group}_{each.name}.html"
        sb.animate(each.run(), path, title=each.name.replace("_", " "), **each.options)
        context = browser.new_context(viewport={"width": WINDOW[0], "height": WINDOW[1]})
        page = context.new_page()
        page.goto(path.as_uri())
        page.wait_for_selector(".sb-player canvas")
        pictures = photograph(page)
        context.close()
        for theme, shown in pictures.items():
            for k, picture in enumerate(shown):
                picture.save(path.with_name(f"{path.stem}_{theme}_{k}.png"))
        rows.append([*pictures["light"][:2], pictures["dark"][2]])
        print(path.stem, f"{path.stat().st_size / 1e6:.2f} MB", flush=True)
    contact_sheet(rows).save(PICTURES / f"gallery_{group}.webp", quality=52, method=6)


def main() -> None:
    """Draw the groups that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("groups", nargs="*", help=", ".join(GROUPS))
    parser.add_argument("--keep", type=Path, help="folder for pages and pictures in full size")
    words = parser.parse_args()
    draw_sheets(words.groups or list(GROUPS), words.keep)


def draw_sheets(groups: list[str], keep: Path | None) -> None:
    """Write the sheets of groups, which a browser shows."""
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as driver:
        folder = keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        for group in groups:
            draw_group(browser, group, folder.resolve())
        browser.close()


if __name__ == "__main__":
    main()
