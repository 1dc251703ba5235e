"""The mechanisms of examples/gallery: each moves as its publication says, and its check notices a wrong size."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import symbody as sb
from docs import draw_gallery

FOLDER = Path(__file__).parents[2] / "examples" / "gallery"
# A size in each closed form.
SIZES = {
    "bennett": "BETA",
    "chebyshev_lambda": "ROCKER",
    "crank_rocker": "COUPLER",
    "pantograph": "RATIO",
    "peaucellier": "SIDE",
    "quick_return": "RADIUS",
    "sarrus": "LENGTH",
    "scissor_lift": "STAGES",
    "toggle": "LENGTH",
    "watt": "ARM",
    "delta_robot": "ROD",
    "differential": "SHAFT",
    "planetary_gear": "RING",
    "swash_plate": "TILT",
    "universal_joint": "BEND",
    "foucault": "LATITUDE",
    "gyroscope": "SPIN",
    "rimless_wheel": "SLOPE",
    "single_track": "YAW",
    "stick_slip": "STATIC",
}
FAST = {"crank_rocker", "planetary_gear", "stick_slip"}
NAMES = [name if name in FAST else pytest.param(name, marks=pytest.mark.exhaustive) for name in sorted(SIZES)]


def module_of(name: str) -> ModuleType:
    (path,) = FOLDER.glob(f"*/{name}.py")
    spec = importlib.util.spec_from_file_location(f"gallery_{name}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def motion_of(name: str) -> sb.Trajectory:
    return module_of(name).motion()


def difference(name: str, **sizes: float) -> float:
    """The greatest difference between motion and closed form, over the tolerance; sizes change the latter."""
    module = module_of(name)
    for size, value in sizes.items():
        setattr(module, size, value)
    computed, formula = (np.asarray(each) for each in module.comparison(motion_of(name)))
    assert computed.shape == formula.shape and computed.size > 10
    return float(np.abs(computed - formula).max() / module.TOLERANCE)


@pytest.mark.parametrize("name", NAMES)
def test_motion_is_that_of_the_closed_form(name: str) -> None:
    run = motion_of(name)
    assert run.success
    assert np.ptp([run[coordinate] for coordinate in run.coordinate_names], axis=1).max() > 0.03
    assert difference(name) < 1


@pytest.mark.parametrize("name", NAMES)
def test_check_notices_a_size_that_is_one_percent_off(name: str) -> None:
    value = getattr(module_of(name), SIZES[name])
    assert difference(name, **{SIZES[name]: 1.01 * value}) > 2


def test_nothing_is_left_out() -> None:
    assert {path.stem for path in FOLDER.glob("*/*.py")} == SIZES.keys()
    assert {path.parent.name for path in draw_gallery.MECHANISMS} == draw_gallery.HEADINGS.keys()


def test_page_says_what_the_scripts_say() -> None:
    """Run: python docs/draw_gallery.py mechanisms."""
    page = (FOLDER.parents[1] / "docs" / "mechanisms.md").read_text(encoding="utf-8")
    assert page == draw_gallery.mechanisms_page()
    for name in SIZES:
        picture = draw_gallery.PICTURES / "gallery" / f"{name}.png"
        assert f"(pictures/gallery/{name}.png)" in page
        assert 2_000 < picture.stat().st_size < 100_000
