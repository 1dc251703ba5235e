"""Draw the gallery: `python docs/draw_gallery.py` runs the examples, the course notes and five robots as pages.

Each motion is written as a page by `animate`, opened in Chromium, and shown at three times, the last one dark.
The sheets are docs/pictures/gallery_*.webp; `--keep DIR` keeps pages and pictures in full size.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import runpy
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import symbody as sb

HERE: Final = Path(__file__).resolve().parent
PICTURES: Final = HERE / "pictures"
EXAMPLES: Final = HERE.parent / "examples"
WINDOW: Final = (900, 560)
CELL: Final = (420, 262)
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


def robot(name: str, path: str, sway: float = 0.5) -> Exhibit:
    """Return a robot whose joints are let go from a raised posture, with damping and soft springs."""

    def run() -> sb.Trajectory:
        folder = robots_folder()
        if folder is None:
            raise FileNotFoundError("example-robot-data is not installed: pip install example-robot-data")
        model = sb.load_urdf(folder / path)
        eqs = sb.form_equations(model)
        efforts = {}
        for k, (effort, joint) in enumerate(joints_of(eqs)):
            aim = f"{sway * (-1) ** k}*(1 - cos(2*pi*t/2))/2"
            efforts[effort] = f"40*({aim} - {joint}) - 6*{joint}_dot"
        return sb.simulate(eqs, 4.0, inputs=efforts, rtol=1e-5, atol=1e-6)

    return Exhibit("robots", name, run)


def joints_of(eqs: sb.EquationSet) -> list[tuple[str, str]]:
    """Return the efforts of a robot with the coordinates that they act on."""
    return [(name, name.removeprefix("tau_")) for name in eqs.input_names]


EXHIBITS: Final = (
    example("four_bar", "run", traces=["Coupler.P"]),
    example("slider_crank", "run", vectors="all"),
    example("spring_mass_damper", "fast"),
    example("rr_robot", "run", traces=["Link2.P"]),
    example("projectile", "run", traces=["Body"]),
    example("spatial_four_bar", "run", traces=["Crank.pin", "Rocker.pin"]),
    example("spinning_top", "run", traces=["Top"]),
    example("spinning_top_omega", "run"),
    example("stewart_platform", "run"),
    example("robot_arm", "fall"),
    example("bicycle", "run"),
    note("dynamics", lambda found: found["run"]),
    note("index_reduction", lambda found: found["kept"]),
    note("simulation", lambda found: found["run"]),
    note("position_velocity", lambda found: found["turning"]),
    note("equilibrium", lambda found: found["swing"]),
    note("friction", lambda found: found["stick_slip"]),
    note("inverse_dynamics", lambda found: found["back"]),
    note("linearization", lambda found: found["real"]),
    note("slider_crank_four_ways", lambda found: found["runs"]["drawn"]),
    note("quick_return", lambda found: found["run"]),
    note("four_bar_spring", lambda found: found["large"]),
    note("inverted_pendulum", lambda found: found["drawn"]),
    robot("ur5", "ur_description/urdf/ur5_robot.urdf"),
    robot("panda", "panda_description/urdf/panda.urdf"),
    robot("kinova", "kinova_description/robots/kinova.urdf"),
    robot("anymal", "anymal_b_simple_description/robots/anymal.urdf"),
    robot("talos_arm", "talos_data/robots/talos_left_arm.urdf"),
)
