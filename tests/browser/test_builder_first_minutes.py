"""What a newcomer meets in the editor: bodies with size, messages at their place, layouts, themes, narrow windows."""

from __future__ import annotations

from typing import Any

import pytest

from .builder_page import BuilderPage, overlaps

RING = (("Ground", "Link1.A"), ("Link1.B", "Link2.A"), ("Link2.B", "Link3.A"), ("Link3.B", "Ground"))
PLACES = ((330, 60), (560, 130), (330, 270))


def errors(builder: BuilderPage) -> list[Any]:
    return [each for each in builder.state("check.problems") if each["severity"] != "note"]


def test_a_ring_of_three_links_moves_at_once(visit: Any) -> None:
    builder = visit()
    builder.new()
    for place in PLACES:
        builder.drop("link", *place)
    builder.wait_checked()
    assert builder.state("data.initial") == {"Link2_x": "1.4", "Link3_x": "2.8"}
    for start, end in RING:
        builder.join(start, end, "revolute")
    builder.wait_checked()
    assert errors(builder) == [] and builder.state("check.summary.freedoms") == 1
    assert builder.state("data.initial") is None
    builder.simulate()
    _, values = builder.curve("J1")
    assert max(values) - min(values) > 1.0  # it swings under gravity


CHAIN = ("link", "revolute", "link", "revolute", "slider", "revolute", "prismatic")


@pytest.mark.exhaustive
def test_a_slider_crank_of_links_is_built_with_few_keys(visit: Any) -> None:
    builder = visit()
    builder.page.locator(".card").first.wait_for()
    builder.go_to("New model")
    builder.keys("Enter")
    builder.page.get_by_test_id("node-Ground").wait_for()
    for (
        element
    ) in CHAIN:  # each joint goes on from the body that is held to the new one, the last one to the ground
        builder.insert(element)
    pairs = [each["between"] for each in builder.state("data.joint")]
    assert pairs == [
        ["ground", "Link1.A"],
        ["Link1.B", "Link2.A"],
        ["Link2.B", "Slider1"],
        ["ground", "Slider1"],
    ]
    builder.keys("F4")
    assert builder.page.evaluate("document.activeElement.dataset.pointer").endswith("/name")
    builder.keys("Escape", "Escape")
    builder.wait("document.activeElement.closest('.react-flow') !== null", 5)  # keys go to the diagram
    builder.wait_checked()
    assert errors(builder) == [] and builder.state("check.summary.freedoms") == 1
    builder.simulate()
    _, values = builder.curve("J4")
    assert max(values) - min(values) > 3.9  # two links of 1 m swing through the whole way


@pytest.mark.exhaustive
def test_a_simulation_does_not_wait_for_equations(visit: Any) -> None:
    builder = visit(viewport={"width": 1024, "height": 768})
    page = builder.page
    builder.page.get_by_test_id("example-four_bar").click()
    builder.wait_checked()
    builder.keys("F6")
    builder.wait("s.runs.equations !== undefined")
    page.get_by_test_id("simulate").click()
    builder.wait("s.runs.computation !== undefined || s.simulated !== null")
    builder.wait("s.simulated !== null", 120)
    builder.wait("s.equations !== null", 120)
    builder.wait("window.symbodyPicture.shown.base.curves.length > 0")
    page.get_by_role("tab", name="Curves").click()
    page.get_by_role("group", name="Curves, rad", exact=True).wait_for()
    page.get_by_role("button", name="Angles in degrees").click()
    page.get_by_role("group", name="Curves, deg", exact=True).wait_for()
    page.reload()  # the choice is remembered
    assert page.evaluate("JSON.parse(localStorage.getItem('symbody-angles'))") == {
        "degrees": True,
        "wrap": False,
    }


@pytest.mark.exhaustive
def test_a_name_that_cannot_be_stays_in_its_field_with_a_reason(visit: Any) -> None:
    builder = visit()
    builder.open_example("slider_crank")
    before = builder.state("data")
    field = builder.page.get_by_label("Name of G", exact=True)
    for name in ("0.4", "m1", "pi", "a b", ""):
        field.fill(name)
        field.press("Enter")
        assert field.input_value() == name and field.get_attribute("aria-invalid") == "true"
        assert builder.page.locator(".name-input [role=alert]").inner_text() != ""
        assert builder.state("data") == before
    field.press("Escape")
    assert field.input_value() == "G" and builder.page.locator(".name-input [role=alert]").count() == 0


@pytest.mark.exhaustive
def test_an_error_leaves_the_picture_and_says_so_in_a_strip(visit: Any) -> None:
    builder = visit()
    builder.open_example("slider_crank")
    builder.page.get_by_test_id("node-Crank").click()
    builder.fill("Mass", "2*(m")
    builder.wait_checked()
    assert builder.state("check.picture") is not None  # half a formula takes nothing away
    assert builder.page.locator(".picture-empty").count() == 0


def colours(page: Any) -> set[str]:
    """The opaque colours of the first plot."""
    script = """() => { const c = document.querySelector('.sb-curves canvas'), g = c.getContext('2d');
        const d = g.getImageData(0, 0, c.width, c.height).data, all = new Set();
        for (let k = 0; k < d.length; k += 4) if (d[k + 3] === 255) all.add(d.slice(k, k + 3).join());
        return [...all]; }"""
    return set(page.evaluate(script))


def variable(page: Any, name: str) -> str:
    script = """name => { const e = document.createElement('i'); e.style.color = `var(${name})`;
        document.querySelector('.sb-curves').append(e); const c = getComputedStyle(e).color; e.remove();
        return c.match(/\\d+/g).slice(0, 3).join(); }"""
    return str(page.evaluate(script, name))


@pytest.mark.exhaustive
def test_plots_follow_the_theme_of_the_system_and_of_the_button(visit: Any) -> None:
    builder = visit(color_scheme="light")
    page = builder.page
    builder.open_example("slider_crank")
    builder.simulate()
    page.get_by_label("Results").locator(".sb-curves canvas").first.wait_for()
    seen: list[str] = []

    def assert_follows() -> None:
        page.wait_for_timeout(400)
        now = variable(page, "--sb-curve-0")
        assert now in colours(page), "the curves have the colour of the theme"
        assert not [each for each in seen if each != now and each in colours(page)]
        seen.append(now)

    assert_follows()
    page.emulate_media(color_scheme="dark")
    assert_follows()
    page.emulate_media(color_scheme="light")
    assert_follows()
    for _ in range(2):  # light, dark
        page.locator(".topbar").get_by_role("button", name="Light, dark, high contrast").click()
        assert_follows()
    assert len(set(seen)) == 2


@pytest.mark.exhaustive
@pytest.mark.parametrize("width", [390, 1024, 1280, 1440])
def test_no_window_is_wider_than_it_is(visit: Any, width: int) -> None:
    builder = visit(viewport={"width": width, "height": 800})
    page = builder.page
    builder.page.get_by_test_id("example-slider_crank").click()
    page.get_by_test_id("live").wait_for()
    builder.wait_checked()
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.locator(".counts b").evaluate("each => each.scrollWidth <= each.clientWidth")
    button = page.locator(".topbar").get_by_role("button", name="Keys and gestures")
    box = button.bounding_box()
    assert box["x"] >= 0 and box["x"] + box["width"] <= width
    assert overlaps(page, ".doc-title, .tools, .layouts, .counts, .state, .topbar > .tool") == []
    if width < 1100:
        page.locator(".panels").get_by_role("button", name="Properties").click()
        assert page.get_by_test_id("properties").bounding_box()["width"] > 250
        page.locator(".panels").get_by_role("button", name="Palette").click()
        page.get_by_test_id("palette-link").click()
        builder.wait("s.data.body.length === 4")
    if width < 700:
        page.locator(".panels").get_by_role("button", name="Results").click()
        assert (
            page.get_by_label("Results").first.is_visible()
            and not page.get_by_test_id("diagram").is_visible()
        )


@pytest.mark.exhaustive
def test_the_keyboard_has_one_stop_for_a_group(visit: Any) -> None:
    builder = visit()
    builder.open_example("slider_crank")
    stops = builder.page.evaluate("document.querySelectorAll('.palette-item[tabindex=\"0\"]').length")
    assert stops == 1
    builder.page.get_by_test_id("palette-link").focus()
    builder.keys("ArrowDown", "End")
    assert builder.page.evaluate("document.activeElement.tabIndex") == 0
    assert builder.page.evaluate("document.activeElement.className") == "palette-item"
