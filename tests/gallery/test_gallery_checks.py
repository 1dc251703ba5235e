"""The mechanisms of examples/gallery: each moves as its closed form says, and its check notices a wrong size."""

from __future__ import annotations

import importlib.util
import runpy
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import symbody as sb
from docs import draw_mechanisms
from docs.typeset import typeset, with_formulas

FOLDER = Path(__file__).parents[2] / "examples" / "gallery"
# A size in each closed form.
SIZES = {
    "bennett": "BETA",
    "bricard": "TWIST",
    "chebyshev_lambda": "ROCKER",
    "crank_rocker": "COUPLER",
    "double_wishbone": "UPPER",
    "geneva": "CRANK",
    "pantograph": "RATIO",
    "peaucellier": "SIDE",
    "quick_return": "RADIUS",
    "sarrus": "LENGTH",
    "scissor_lift": "STAGES",
    "stephenson": "REACH",
    "toggle": "LENGTH",
    "watt": "ARM",
    "block_and_tackle": "INERTIA",
    "cardan_gears": "INNER",
    "cycloid_drive": "OFFSET",
    "delta_robot": "ROD",
    "differential": "SHAFT",
    "double_cardan": "BEND",
    "oldham": "OFFSET",
    "planetary_gear": "RING",
    "scara_robot": "POLE",
    "stewart_platform": "MASS",
    "swash_plate": "TILT",
    "universal_joint": "BEND",
    "backspin": "MU",
    "bicycle": "SPEED",
    "coin": "RADIUS",
    "cradle": "LENGTH",
    "foucault": "LATITUDE",
    "governor": "SLEEVE",
    "gyroscope": "SPIN",
    "heavy_top": "SPIN",
    "hill_muscle": "A",
    "huygens": "RADIUS",
    "quarter_car": "DAMPER",
    "rattleback": "SKEW",
    "rimless_wheel": "SLOPE",
    "single_track": "YAW",
    "stick_slip": "STATIC",
    "tumbling": "OFF",
    "walker": "ANGLE",
    "cam_lift_off": "OFF",
    "clearance": "E",
    "dropped_chair": "DEPTH",
    "gripper": "MU",
    "hopper": "STIFFNESS",
    "tippe_top": "SPIN",
}
FAST = {"crank_rocker", "planetary_gear", "stick_slip", "cam_lift_off"}
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
    assert {path.parent.name for path in draw_mechanisms.MECHANISMS} == draw_mechanisms.HEADINGS.keys()
    assert draw_mechanisms.PLAYED.keys() < SIZES.keys()


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sorted(SIZES))
def test_model_file_is_the_mechanism_of_the_script(name: str) -> None:
    """Run: python docs/draw_mechanisms.py."""
    (path,) = FOLDER.glob(f"*/{name}.toml")
    assert sb.load_model(path) == module_of(name).model()


DOCS = FOLDER.parents[1] / "docs"
RENEW = "run: python docs/draw_mechanisms.py --pages"


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("r^2 = b^2 -+ sqrt(c^2 - a^(n + 1))", r"r^{2}=b^{2}\mp\sqrt{c^{2}-a^{n+1}}"),
        ("q_d'' + 2 p cos(phi1)", r"\ddot{q}_{d}+2p\cos(\phi_{1})"),
        ("2 crank w_sun", r"2\,\mathrm{crank}w_{\mathrm{sun}}"),
        ("n' = n cross w", r"\dot{n}=n\times w"),
    ],
)
def test_formulas_are_typeset(text: str, latex: str) -> None:
    assert typeset(text) == latex
    assert with_formulas(f"so `{text}`, by hand").startswith("so $" if len(text) < 40 else "so\n\n```math\n")


def test_a_sign_that_cannot_be_typeset_is_rejected() -> None:
    with pytest.raises(ValueError, match="sign"):
        typeset("a & b")


def test_gallery_shows_every_mechanism() -> None:
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert page == draw_mechanisms.gallery_page(), RENEW
    assert {path.stem for path in (DOCS / "gallery").glob("*.md")} == SIZES.keys()
    for name in SIZES:
        assert page.count(f"pictures/gallery/{name}.png") == page.count(f"(gallery/{name}.md)") == 1
        assert 2_000 < (draw_mechanisms.PICTURES / f"{name}.png").stat().st_size < 100_000


@pytest.mark.parametrize("name", NAMES)
def test_page_is_what_the_script_gives(name: str) -> None:
    page = (DOCS / "gallery" / f"{name}.md").read_text(encoding="utf-8")
    assert page == draw_mechanisms.mechanism_page(draw_mechanisms.path_of(name)), RENEW


@pytest.mark.exhaustive
@pytest.mark.parametrize("words", [["huygens"], ["huygens", "--live"]])
def test_one_command_shows_a_mechanism(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["show.py", *words])
    runpy.run_path(str(FOLDER / "show.py"), run_name="__main__")
    assert "from the closed form" in capsys.readouterr().out
    assert "</html>" in (tmp_path / "huygens.html").read_text(encoding="utf-8")
