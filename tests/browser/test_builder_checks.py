"""What a user may expect of the page, beyond drawing: files, equations, runs, curves, windows of any size, help."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.formats.model_files import examples_folder
from symbody.formats.native import to_data

from .builder_page import BuilderPage
from .builder_plans import errors_of
from .builder_visits import Visit, visits
from .conftest import FLAGS, executable

pytestmark = pytest.mark.exhaustive  # minutes; the fast tier builds and drags a mechanism

CRANK = examples_folder() / "slider_crank" / "slider_crank.toml"
DROP = """(text => {
  const data = new DataTransfer();
  data.items.add(new File([text], "dropped.toml", { type: "text/plain" }));
  for (const type of ["dragover", "drop"])
    document.querySelector(".page").dispatchEvent(new DragEvent(type, { dataTransfer: data, bubbles: true, cancelable: true }));
})"""


DROPPED = 'name = "dropped"\n[[body]]\nname = "Alone"\nmass = 1\n'
ASK = """(async job => {
  const token = document.querySelector("meta[name=symbody-token]").content;
  const headers = { "Content-Type": "application/json", "X-Symbody-Token": token };
  const answer = await fetch("/api/job_state", { method: "POST", headers, body: JSON.stringify({ job, seen: -1 }) });
  return (await answer.json()).state;
})"""


def open_path(builder: BuilderPage, path: Path) -> None:
    builder.page.evaluate(f"location.hash = 'open={path}'")
    builder.page.reload()


def test_gravity_name_and_parameters_need_no_selection(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("slider_crank")
    builder.wait("window.symbodyPicture && window.symbodyPicture.shown")
    arrow = page.locator(".sb-gravity text")
    assert "9.81" in str(arrow.text_content())
    parameters = page.get_by_test_id("parameters")
    parameters.get_by_label("G", exact=True).fill("1.62")
    builder.wait("document.querySelector('.sb-gravity text').textContent.includes('1.62')")
    for axis in "xyz":
        builder.fill(f"Gravity {axis}", "0")
    builder.wait("document.querySelector('.sb-gravity') === null")
    builder.fill("Name", "on the moon")
    assert builder.state("data.name") == "on the moon"


def test_edits_outlive_a_reload_and_a_file_is_dragged_in(visit: Visit, settings: Any) -> None:
    path = settings.roots[0] / "crank.toml"
    path.write_bytes(CRANK.read_bytes())
    builder = visit()
    page = builder.page
    open_path(builder, path)
    page.get_by_test_id("node-Crank").wait_for()
    builder.wait_checked()
    page.get_by_test_id("node-Crank").click()
    builder.fill("Mass", "7*m1")
    assert page.title().startswith("●") and page.get_by_test_id("dirty").count() == 1
    builder.wait("symbodyBuilder.counts.draft > 0")
    page.wait_for_timeout(300)
    page.evaluate("location.hash = ''")
    page.reload()
    page.get_by_role("button", name="crank").first.wait_for()
    page.locator(".drafts").get_by_role("button").first.click()
    page.get_by_test_id("node-Crank").wait_for()
    assert builder.state("data.body[0].mass") == "7*m1"
    assert path.read_bytes() == CRANK.read_bytes()
    builder.keys("Control+s")
    builder.wait("s.data === s.saved && s.spoken.includes('saved')")
    assert path.read_text() == CRANK.read_text().replace('mass = "m1"', 'mass = "7*m1"')
    page.evaluate(f"{DROP}({json.dumps(DROPPED)})")
    page.get_by_test_id("node-Alone").wait_for()


def test_an_edit_outside_takes_nothing_away(visit: Visit, settings: Any) -> None:
    path = settings.roots[0] / "outside.toml"
    path.write_bytes(CRANK.read_bytes())
    builder = visit(expected=("409",))
    page = builder.page
    open_path(builder, path)
    page.get_by_test_id("node-Crank").wait_for()
    builder.wait_checked()
    page.get_by_test_id("node-Crank").click()
    builder.fill("Mass", "5*m1")
    mine = builder.state("data")
    path.write_text(CRANK.read_text() + "\n# by hand\n")
    builder.wait("s.outside", 30)
    builder.keys("Control+s")
    builder.wait("s.notice.length > 0")
    assert path.read_text().endswith("# by hand\n") and builder.state("data") == mine
    page.get_by_role("button", name="Overwrite").click()
    builder.wait("!s.outside && s.data === s.saved")
    assert 'mass = "5*m1"' in path.read_text() and path.read_text().endswith("# by hand\n")
    assert (path.parent / "outside.toml.bak").read_text().endswith("# by hand\n")


def test_a_broken_file_is_shown_with_its_line_and_stays(visit: Visit, settings: Any) -> None:
    path = settings.roots[0] / "broken.toml"
    text = CRANK.read_text().replace('mass = "m1"', 'mass = "m1')
    path.write_text(text)
    builder = visit(expected=("400", "422"))
    open_path(builder, path)
    builder.wait("s.notice.length > 0 || s.openProblems.length > 0")
    problems = builder.state("notice") + builder.state("openProblems")
    line = text.splitlines().index('mass = "m1') + 1
    assert any(each["line"] == line for each in problems)
    assert f"{line}" in builder.page.locator("body").inner_text()
    assert path.read_text() == text


def test_deriving_names_its_stages_and_is_cancelled(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("bicycle")
    builder.keys("F6")
    progress = page.get_by_test_id("progress")
    progress.wait_for()
    builder.wait("s.runs.equations?.state != null && s.runs.equations.state.stages.length >= 3", 60)
    stages = builder.state("runs.equations.state.stages")
    assert "trees" in stages and "kinematics" in stages
    shown = "document.querySelector('[data-testid=progress]').innerText"
    builder.wait(f"s.runs.equations.state.stages.some(stage => {shown}.includes(stage))", 20)
    page.get_by_test_id("node-Ground").click(position={"x": 12, "y": 12})  # the page stays usable
    assert builder.state("selection") == ["ground"]
    job = builder.state("runs.equations.job")
    progress.get_by_role("button", name="Cancel").click()
    assert builder.state("runs") == {} and progress.count() == 0
    assert page.evaluate(f"{ASK}('{job}')") == "cancelled"
    assert builder.state("equations") is None


def lit_up(page: Any) -> float:
    """Return how strongly the picture lights up what a term comes from, from 0 to 1."""
    return float(page.evaluate("Math.max(0, ...symbodyPicture.shown.player.viewer.lights.values())"))


def test_equations_of_motion_come_first_and_the_rest_on_demand(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("four_bar")
    builder.keys("F6")
    builder.wait("s.equations !== null", 120)
    assert builder.state("runs") == {} and builder.state("tab") == "equations"  # nothing waits for the rest
    page.locator(".equation-block").first.wait_for()
    assert page.locator(".equation-block h3").all_inner_texts() == [
        "Equations of motion",
        "Constraints on positions",
    ]
    assert page.locator(".sb-equation").count() == 5  # three accelerations, two multipliers
    chosen = page.get_by_role("tablist", name="Equations").get_by_role("tab", name="Forcing")
    chosen.click()
    page.get_by_role("heading", name="Forcing").wait_for()
    assert chosen.get_attribute("aria-selected") == "true"
    assert len(builder.state("equations.result.names")) == 8
    panel = page.locator(".equation-blocks")
    assert panel.evaluate("each => each.scrollWidth <= each.clientWidth")  # broken to the width there is


def test_closing_a_page_with_changes_is_questioned(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    questions: list[str] = []
    page.on("dialog", lambda dialog: questions.append(dialog.type))
    builder.open_example("spring_mass_damper")
    page.reload()
    page.get_by_test_id("start").wait_for()
    assert questions == []  # nothing was changed
    builder.open_example("spring_mass_damper")
    page.get_by_test_id("parameters").get_by_label("k", exact=True).fill("3")
    assert builder.page.title().startswith("\u25cf")
    with page.expect_event("dialog"):
        page.close(run_before_unload=True)
    assert questions == ["beforeunload"]


def test_equations_have_tabs_and_a_term_lights_up_what_it_comes_from(visit: Visit) -> None:
    builder = visit(permissions=["clipboard-read", "clipboard-write"])
    page = builder.page
    builder.open_example("slider_crank")
    builder.keys("F6")
    builder.wait("s.equations !== null", 120)
    tabs = page.get_by_role("tablist", name="Equations").get_by_role("tab")
    assert {"Equations", "Mass matrix", "Forcing", "Constraints", "Reactions", "Energies"} <= set(
        tabs.all_inner_texts()
    )
    terms = page.locator("[data-span]")
    terms.first.wait_for()
    terms.first.hover()
    glowing = builder.state("glowing")
    assert glowing and page.locator(".glowing").count() == len(glowing)
    assert builder.state("highlighted") == [] and builder.state("spoken") == "Equations finished"
    assert 0 < lit_up(page) < 1
    page.get_by_label("Search elements").hover()
    assert builder.state("glowing") == [] and page.locator(".glowing").count() == 0 and lit_up(page) == 0
    terms.first.click()
    lit = builder.state("highlighted")
    assert lit == glowing and page.locator(".highlighted").count() == len(lit)
    assert lit_up(page) > 0.5
    tabs.get_by_text("Mass matrix", exact=True).click()
    page.locator(".equation-block math").first.wait_for()
    page.get_by_role("button", name="Copy LaTeX").first.click()
    builder.wait("s.spoken.includes('copied')")
    assert "begin{" in page.evaluate("navigator.clipboard.readText()")


def test_a_run_is_marked_stale_and_its_curves_are_written(visit: Visit) -> None:
    builder = visit(accept_downloads=True)
    page = builder.page
    builder.open_example("spring_mass_damper")
    builder.simulate()
    curves = page.get_by_label("Results").locator(".sb-curves")
    box = curves.get_by_role("checkbox").first
    box.wait_for()
    before = box.is_checked()
    box.click()
    assert box.is_checked() is not before
    with page.expect_download() as table:
        curves.get_by_role("button", name="Save the curves as CSV").click()
    lines = Path(table.value.path()).read_text().splitlines()
    assert "t" in lines[0] and "x" in lines[0] and len(lines) > 50
    with page.expect_download() as picture:
        curves.get_by_role("button", name="Save the curves as a picture").click()
    assert Path(picture.value.path()).read_bytes().startswith(b"\x89PNG")
    page.evaluate("symbodyPicture.shown.player.setTime(2)")
    player = "symbodyPicture.shown.player"
    assert page.evaluate(f"{player}.time") == 2
    page.get_by_test_id("parameters").get_by_label("k", exact=True).fill("3")
    builder.wait_checked()
    assert page.locator(".stale").count() >= 1
    assert builder.state("simulated.of.parameters.k") != "3"  # the last result is kept
    builder.wait("document.body.textContent.includes('Before the last edits')")


def test_without_webgl_all_else_goes_on(playwright_driver: Any, settings: Any) -> None:
    browser = playwright_driver.chromium.launch(
        executable_path=executable(), args=[*FLAGS, "--disable-software-rasterizer", "--disable-gpu"]
    )
    try:
        with visits(browser, settings) as visit:
            builder = visit(expected=("WebGL", "webgl"))
            builder.open_example("slider_crank")
            assert builder.page.get_by_test_id("picture").get_by_role("alert").first.is_visible()
            builder.page.get_by_test_id("node-Crank").click()
            builder.fill("Mass", "2*m1")
            builder.wait_checked()
            assert errors_of(builder) == []
    finally:
        browser.close()


def test_motions_wait_where_less_motion_is_wanted(visit: Visit) -> None:
    builder = visit(reduced_motion="reduce")
    builder.open_example("spring_mass_damper")
    builder.simulate()
    assert builder.page.evaluate("symbodyPicture.shown.player.clock.playing") is False


@pytest.mark.parametrize(
    "viewport",
    [(1280, 720), (1920, 1080), (2560, 1440), (640, 360)],
    ids=["small", "usual", "large", "zoomed"],
)
def test_nothing_is_cut_off_at_any_size(visit: Visit, viewport: tuple[int, int]) -> None:
    """The last of the sizes is what a zoom of 200 % leaves of the first."""
    builder = visit(viewport={"width": viewport[0], "height": viewport[1]})
    page = builder.page
    builder.open_example("slider_crank")
    page.get_by_test_id("node-Crank").click()
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    cut = page.evaluate(
        "Array.from(document.querySelectorAll('header button, .tabs [role=tab], .form-head h2, .body-name'))"
        ".filter(e => e.offsetParent !== null && getComputedStyle(e).overflow === 'hidden'"
        " && getComputedStyle(e).textOverflow !== 'ellipsis' && e.scrollWidth > e.clientWidth + 1)"
        ".map(e => e.textContent)"
    )
    assert cut == []
    outside = page.evaluate(
        "Array.from(document.querySelectorAll('header button, [role=tablist] button'))"
        ".filter(e => e.offsetParent !== null).map(e => [e.textContent || e.ariaLabel, e.getBoundingClientRect()])"
        ".filter(([, r]) => r.right > innerWidth + 1 || r.left < -1).map(([name]) => name)"
    )
    assert outside == []


def test_sizes_of_panels_are_kept(visit: Visit) -> None:
    builder = visit()
    page = builder.page
    builder.open_example("slider_crank")
    split = page.get_by_role("separator", name="Width of the left panel")
    box = split.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 90, box["y"] + 200, steps=4)
    page.mouse.up()
    wide = page.locator("aside.left").bounding_box()["width"]
    page.reload()
    builder.open_example("slider_crank")
    assert page.locator("aside.left").bounding_box()["width"] == pytest.approx(wide, abs=2)


def test_help_tips_and_a_script_that_rebuilds_the_model(visit: Visit, tmp_path: Path) -> None:
    builder = visit(accept_downloads=True)
    page = builder.page
    builder.open_example("slider_crank")
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    builder.keys("?")
    listed = page.get_by_role("dialog").inner_text()
    for word in ("Ctrl+Z", "F5", "Simulate", "Drag from port to port"):
        assert word in listed
    builder.keys("Escape")
    page.get_by_test_id("badge-A").click()
    fields = page.get_by_test_id("properties").locator(".field")
    assert fields.count() >= 5
    without = fields.evaluate_all(
        "all => all.filter(e => !e.querySelector('.tip, [title]') && !e.title).map(e => e.textContent)"
    )
    assert without == []
    page.locator(".brand").click()
    with page.expect_download() as script:
        page.get_by_role("menuitem", name="Python script").click()
    path = tmp_path / "rebuilt.py"
    path.write_text(Path(script.value.path()).read_text())
    names: dict[str, Any] = {}
    exec(compile(path.read_text(), str(path), "exec"), names)  # noqa: S102
    (model,) = [each for each in names.values() if isinstance(each, sb.Model)]
    assert to_data(model) == to_data(sb.load_model(CRANK))
