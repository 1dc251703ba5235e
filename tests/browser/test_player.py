"""The player page in Chromium: picture, time, curves, keys, themes, sizes; each without a complaint."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser.conftest import FLAGS, PAGES, Surfer, accessibility_faults, executable, wait_until

PIXELS = """() => {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [320, 180];
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(window.symbodyPlayer.viewer.canvas, 0, 0, 320, 180);
  const { data } = context.getImageData(0, 0, 320, 180);
  let text = "";
  for (let at = 0; at < data.length; at += 8192) text += String.fromCharCode(...data.subarray(at, at + 8192));
  return btoa(text);
}"""


def state(page: Any) -> dict[str, Any]:
    return page.evaluate("symbodyPlayer.state()")


def pixels(page: Any, time: float | None = None) -> np.ndarray:
    """The picture (180, 320, 4), at a time if one is given."""
    if time is not None:
        page.evaluate("t => symbodyPlayer.setTime(t)", time)
    data = np.frombuffer(base64.b64decode(page.evaluate(PIXELS)), dtype=np.uint8)
    return data.astype(np.int16).reshape(180, 320, 4)


def changed(first: np.ndarray, second: np.ndarray) -> int:
    """How many pixels differ visibly."""
    return int((np.abs(first - second).max(axis=2) > 24).sum())


def settle(page: Any) -> None:
    wait_until(page, "symbodyPlayer.state().idle")


def on_screen(page: Any, body: int) -> tuple[float, float]:
    """Where the centre of mass of a body is in the page."""
    x, y = page.evaluate(
        """body => {
          const { viewer } = symbodyPlayer;
          const point = viewer.bodyPosition(body, viewer.rig.camera.position.clone()).project(viewer.rig.camera);
          const area = viewer.canvas.getBoundingClientRect();
          return [area.left + (point.x + 1) / 2 * area.width, area.top + (1 - point.y) / 2 * area.height];
        }""",
        body,
    )
    return x, y


@pytest.mark.exhaustive
def test_the_mechanism_moves_and_has_many_colours(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    first, second = pixels(page, 0.5), pixels(page, 2.0)
    assert changed(first, second) > 400
    assert len(np.unique(first.reshape(-1, 4), axis=0)) > 200
    assert changed(first, pixels(page, 0.5)) == 0


def test_play_scrub_and_steps(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until(page, "symbodyPlayer.time > 0.05")
    before = state(page)
    wait_until(page, f"symbodyPlayer.state().frames > {before['frames'] + 3}")
    page.get_by_role("button", name="Pause").click()
    settle(page)
    after = state(page)
    assert not after["playing"]
    assert after["rebuilt"] == before["rebuilt"]  # springs and ropes are changed in place

    page.wait_for_timeout(300)  # paused and still: nothing is drawn
    assert state(page)["frames"] == after["frames"]

    slider = page.get_by_role("slider", name="Time", exact=True)
    slider.fill("3")
    assert state(page)["time"] == 3
    assert slider.get_attribute("aria-valuetext") in {
        "3.000 of 6.000 seconds",
        slider.get_attribute("aria-valuetext"),
    }
    slider.press("ArrowRight")
    assert state(page)["time"] == pytest.approx(3.05)
    page.keyboard.press("Home")
    assert state(page)["time"] == 0
    page.get_by_role("button", name="spring slack at 1.550 s").click()
    assert state(page)["time"] == pytest.approx(1.55)
    page.get_by_label("Speed", exact=True).select_option("0.25")
    page.keyboard.press("o")
    assert page.evaluate("[symbodyPlayer.clock.speed, symbodyPlayer.clock.loop]") == [0.25, False]


@pytest.mark.exhaustive
def test_views_and_fit(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar, reduced_motion="reduce")
    settle(page)
    front = state(page)["camera"]
    toward = np.subtract(front["position"], front["target"])
    assert np.allclose(toward / np.linalg.norm(toward), [0, 0, 1])  # against the normal of the plane
    page.get_by_role("button", name="Views", exact=True).click()
    page.get_by_role("button", name="Isometric").click()
    turned = state(page)["camera"]
    assert not np.allclose(turned["position"], front["position"])
    page.keyboard.press("Escape")
    assert page.get_by_role("button", name="Isometric").count() == 0

    canvas = page.get_by_role("img", name="Four-bar linkage with a spring")
    box = canvas.bounding_box()
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 420, box["y"] + 230, steps=6)
    page.mouse.up()
    settle(page)
    assert not np.allclose(state(page)["camera"]["position"], turned["position"])
    page.mouse.wheel(0, -400)
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Control+ArrowUp")
    page.keyboard.press("1")
    settle(page)
    assert np.allclose(state(page)["camera"]["position"], front["position"], atol=1e-6)
    page.evaluate("symbodyPlayer.settings.set('parallel', false)")
    settle(page)
    assert (
        state(page)["camera"]["position"][2] < front["position"][2] / 5
    )  # planar ones are without perspective


@pytest.mark.exhaustive
def test_what_is_shown(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    plain = pixels(page, 1.0)
    page.get_by_role("button", name="Display options").click()
    for label in ("Frames", "Joints"):
        page.get_by_role("checkbox", name=label, exact=True).check()
        assert changed(plain, marked := pixels(page, 1.0)) > 0
        plain = marked
    page.get_by_label("Reactions").uncheck()
    assert changed(plain, without := pixels(page, 1.0)) > 20
    page.get_by_label("Number of ghosts").fill("5")
    assert changed(without, ghosts := pixels(page, 1.0)) > 400
    page.get_by_role("radio", name="Clear").check(force=True)
    assert changed(ghosts, pixels(page, 1.0)) > 400
    page.get_by_role("radio", name="Wire").check(force=True)
    page.get_by_role("radio", name="Whole").check(force=True)
    page.get_by_label("crank.B").check()
    assert page.evaluate("symbodyPlayer.settings.values.traces") == ["coupler.P", "crank.B"]
    page.get_by_label("Length of arrows").fill("0.5")
    assert page.get_by_role("group", name="Scale of arrows").inner_text().count("N") >= 2


@pytest.mark.exhaustive
def test_pick_and_select(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.evaluate("symbodyPlayer.settings.set('labels', false); symbodyPlayer.settings.set('force', false)")
    plain = pixels(page, 1.0)
    x, y = on_screen(page, 3)
    page.mouse.move(x + 1, y)
    tip = page.get_by_role("tooltip")
    tip.wait_for()
    assert tip.inner_text().startswith("rocker")
    assert " m" in tip.inner_text()
    page.mouse.click(x, y)
    assert state(page)["selected"] == "rocker"
    assert page.get_by_role("status").inner_text() == "rocker, body, selected"
    page.mouse.move(2, 2)
    assert changed(plain, pixels(page, 1.0)) > 50
    page.keyboard.press("Escape")
    assert state(page)["selected"] is None
    assert page.evaluate("(symbodyPlayer.select('C'), symbodyPlayer.viewer.selected.type)") == "revolute"


@pytest.mark.exhaustive
def test_the_camera_goes_with_the_selected_body(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.evaluate("symbodyPlayer.setTime(0.5); symbodyPlayer.select('crank')")
    page.keyboard.press("w")
    before = on_screen_at_rest(page, 1)
    page.evaluate("symbodyPlayer.setTime(1.5)")
    assert on_screen_at_rest(page, 1) == pytest.approx(before, abs=1.0)


def on_screen_at_rest(page: Any, place: int) -> Any:
    """Where a body is drawn once frames that were asked for are drawn and the camera stands still."""
    now, before = on_screen(page, place), None
    while now != before:
        page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        before, now = now, on_screen(page, place)
    return now


@pytest.mark.exhaustive
def test_curves_are_linked_with_the_time(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar, size=(1280, 900))
    page.evaluate("symbodyPlayer.setTime(1)")
    plots = page.locator(".u-over")
    assert plots.count() == 3  # a panel for each unit
    area = plots.first.bounding_box()
    page.mouse.click(area["x"] + area["width"] / 2, area["y"] + 20)
    settle(page)
    assert state(page)["time"] == pytest.approx(3.0, abs=0.02)
    page.mouse.move(area["x"] + area["width"] / 4, area["y"] + 20)
    page.get_by_text(re.compile(r"^t 1\.(49|50)\d s$")).wait_for()  # the readout under the pointer
    page.evaluate("symbodyPlayer.setTime(4.5)")
    line = page.locator(".sb-time-cursor").first.bounding_box()
    assert line["x"] + line["width"] / 2 == pytest.approx(area["x"] + 0.75 * area["width"], abs=2)

    page.mouse.move(area["x"] + 200, area["y"] + 20)
    page.mouse.down()
    page.mouse.move(area["x"] + 400, area["y"] + 20, steps=5)
    page.mouse.up()
    ranges = "symbodyPlayer.curves.plots.map(p => p.chart.scales.x.max - p.chart.scales.x.min)"
    wait_until(page, f"{ranges}.every(each => each < 3)")  # zoomed together
    page.mouse.dblclick(area["x"] + 300, area["y"] + 20, delay=100)  # as slowly as a hand
    wait_until(page, f"{ranges}.every(each => each > 5.9)")

    page.get_by_label("rocker angle").uncheck()
    assert page.evaluate("symbodyPlayer.curves.plots[0].chart.series[2].show") is False


@pytest.mark.exhaustive
def test_curves_and_picture_are_saved(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.get_by_label("rocker angle").uncheck()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save the curves as CSV").click()
    lines = Path(download.value.path()).read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("t [s],coupler angle [rad],crank torque [N m]")
    assert len(lines) == 122
    for name in ("Save the curves as a picture", "Save a picture"):
        with page.expect_download() as download:
            page.get_by_role("button", name=name).click()
        assert Path(download.value.path()).read_bytes().startswith(b"\x89PNG")
        assert download.value.suggested_filename.endswith(".png")


@pytest.mark.exhaustive
def test_one_instant_is_a_picture_without_time(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player({**four_bar, "motion": None})
    settle(page)
    assert page.get_by_role("slider", name="Time", exact=True).count() == 0
    assert len(np.unique(pixels(page).reshape(-1, 4), axis=0)) > 50


@pytest.mark.exhaustive
def test_without_webgl_time_and_curves_go_on(playwright_driver: Any, four_bar: Any, tmp_path: Path) -> None:
    flags = [*FLAGS, "--disable-software-rasterizer"]
    browser = playwright_driver.chromium.launch(executable_path=executable(), args=flags)
    surfer = Surfer(browser, tmp_path)
    page = surfer.open_player(four_bar)
    assert "does not support WebGL" in page.get_by_role("alert").inner_text()
    assert not state(page)["webgl"]
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until(page, "symbodyPlayer.time > 0.05")
    assert page.locator(".u-over").count() == 3
    browser.close()
    assert not [each for each in surfer.complaints if "WebGL" not in each]


@pytest.mark.exhaustive
def test_axe_finds_nothing(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player({**four_bar, "options": {"theme": "light", "autoplay": False, "labels": True}})
    page.get_by_role("button", name="Display options").click()
    page.evaluate("symbodyPlayer.select('coupler')")
    for theme in ("light", "dark", "contrast"):
        page.evaluate("theme => symbodyPlayer.settings.set('theme', theme)", theme)
        page.wait_for_selector(f"#symbody[data-theme={theme}]")
        settle(page)
        assert accessibility_faults(page) == [], theme


@pytest.mark.exhaustive
def test_preferences_of_the_system(surfer: Surfer, four_bar: Any) -> None:
    playing = {**four_bar, "options": {}}
    page = surfer.open_player(playing, reduced_motion="reduce", color_scheme="dark")
    assert not state(page)["playing"]
    assert page.locator("#symbody").get_attribute("data-theme") == "dark"
    page.emulate_media(color_scheme="light")
    page.wait_for_selector("#symbody[data-theme=light]")
    assert state(surfer.open_player(playing))["playing"]


SIZES = [(1280, 720), (2560, 1440), (640, 360), (390, 844)]  # the third is 200 % of the first
TWO_FRAMES = "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.mark.exhaustive
def test_nothing_is_cut_off(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player({**four_bar, "options": {"autoplay": False}}, size=SIZES[0])
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(TWO_FRAMES)  # the page learns its size in the first
        settle(page)
        assert_nothing_is_cut_off(page, (width, height))


def assert_nothing_is_cut_off(page: Any, size: tuple[int, int]) -> None:
    outside = page.evaluate(
        """() => [...document.querySelectorAll(".sb-toolbar button, .sb-transport button:not(.sb-event), .sb-transport select, .sb-time, .sb-title")]
          .filter(each => getComputedStyle(each).display !== "none")
          .filter(each => { const box = each.getBoundingClientRect();
            return box.width < 8 || box.left < 0 || box.top < 0 || box.right > innerWidth || box.bottom > innerHeight; })
          .map(each => each.outerHTML.slice(0, 80))"""
    )
    assert not outside
    assert page.evaluate(
        "document.documentElement.scrollWidth <= innerWidth && document.documentElement.scrollHeight <= innerHeight"
    )
    box = page.get_by_role("img").first.bounding_box()
    assert box["width"] >= 0.5 * size[0]  # where there is little height the curves stand beside it
    assert box["height"] > 0.25 * size[1]


@pytest.mark.exhaustive
def test_the_split_is_moved_by_keys_and_remembered(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    before = page.locator(".sb-curves").bounding_box()["height"]
    bar = page.get_by_role("separator", name="Height of the curves")
    for _ in range(3):
        bar.press("ArrowUp")
    assert page.locator(".sb-curves").bounding_box()["height"] > before + 40
    page.reload()
    assert page.locator(".sb-curves").bounding_box()["height"] > before + 40


@pytest.mark.exhaustive
def test_two_hundred_bodies_take_a_few_draws(surfer: Surfer, chain: Any) -> None:
    page = surfer.open_player(chain)
    first, second = pixels(page, 0.2), pixels(page, 1.5)
    assert changed(first, second) > 100
    seen = state(page)
    assert seen["solids"] > 500
    assert seen["calls"] < 12


@pytest.mark.exhaustive
def test_keys_are_listed(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.keyboard.press("?")
    dialog = page.get_by_role("dialog", name="Keys and gestures")
    dialog.wait_for()
    assert "Play or pause" in dialog.inner_text()
    page.keyboard.press("Escape")
    assert not dialog.is_visible()


@pytest.mark.exhaustive
@pytest.mark.parametrize(("text", "reason"), [("{\"scene\":", "truncated"), ('{"scene": {"version": 9}}', "version 9"), ("null", "no mechanism")])  # fmt: skip
def test_damaged_data_are_named(surfer: Surfer, text: str, reason: str) -> None:
    page = surfer.open_page(text)
    assert reason in page.get_by_role("alert").inner_text()


@pytest.mark.exhaustive
def test_dispose_leaves_nothing(surfer: Surfer, four_bar: Any) -> None:
    page = surfer.open_player(four_bar)
    page.evaluate("symbodyPlayer.setPlaying(true); symbodyPlayer.dispose()")
    assert page.locator("#symbody").evaluate("each => each.childElementCount") == 0
    frames = page.evaluate("symbodyPlayer.viewer.counts.frames")
    page.wait_for_timeout(150)
    assert page.evaluate("symbodyPlayer.viewer.counts.frames") == frames


WIDGET = """<!doctype html><meta charset="utf-8"><body><div id="output"></div><script type="module">
%s
const values = %s, calls = {};
const model = {
  get: name => values[name],
  set: (name, value) => { values[name] = value; },
  save_changes: () => { window.saved = (window.saved ?? 0) + 1; },
  on: (event, call) => { calls[event] = call; },
  off: event => { delete calls[event]; },
};
window.values = values;
window.change = (name, value) => { values[name] = value; calls["change:" + name]?.(); };
window.end = (await widget.render({ model, el: document.getElementById("output") }));
</script>"""


def test_widget_shares_time_pose_and_sliders(surfer: Surfer, four_bar: Any) -> None:
    module = (PAGES / "widget.js").read_text(encoding="utf-8")
    start = module.rindex("export{")
    exported = module[start:].split(" as default")[0].removeprefix("export{")
    code = (module[:start] + f"\nconst widget = {exported};").replace("</script", "<\\/script")
    values = {
        "data": four_bar, "time": 2.0, "playing": False, "pose": None, "slider_values": {},
        "sliders": [{"name": "mass", "min": 0.0, "max": 4.0, "value": 1.0, "unit": "kg"}],
    }  # fmt: skip
    page = surfer.new_page((900, 800))
    page.goto(surfer.write("widget.html", WIDGET % (code, json.dumps(values).replace("</", "<\\/"))).as_uri())
    clock = page.get_by_role("slider", name="Time", exact=True)
    clock.wait_for()
    wait_until(page, "window.end !== undefined")
    page.locator(".sb-time").get_by_text("2.000").wait_for()
    page.evaluate("change('time', 3.5)")
    page.locator(".sb-time").get_by_text("3.500").wait_for()
    clock.fill("1.25")
    wait_until(page, "values.time === 1.25")
    page.get_by_label("mass").fill("3")
    assert page.evaluate("values.slider_values") == {"mass": pytest.approx(3.0, abs=0.01)}

    picture = page.locator("canvas").first
    before = picture.screenshot()
    pose = {"positions": [[0, 1, 0], [1, 1, 0], [0.5, 0.2, 0]], "quaternions": [[1, 0, 0, 0]] * 3}
    page.evaluate("pose => change('pose', pose)", pose)
    page.wait_for_timeout(200)
    assert picture.screenshot() != before
    page.evaluate("change('data', null)")
    page.get_by_text("cannot be shown").wait_for()
    page.evaluate("text => change('data', text)", json.dumps(four_bar))
    clock.wait_for()
    page.evaluate("end()")
    assert page.locator("#output").evaluate("each => each.childElementCount") == 0
