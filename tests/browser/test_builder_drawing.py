"""The gestures of drawing: palette, ports, edges, history, clipboard, menus, fields, messages, trees, names."""

from __future__ import annotations

from typing import Any

import pytest

from .builder_page import BuilderPage, overlaps

pytestmark = pytest.mark.exhaustive  # minutes; the fast tier builds and drags a mechanism

GRID = 10
GEARS = """# Two wheels in mesh, and a third that a cam turns.

name = "gears"

[ground.frames]
b = { at = [0.3, 0, 0] }
c = { at = [0.6, 0, 0] }

[[body]]
name = "Wheel1"
mass = 1
inertia = [0.1, 0.1, 0.1]

[[body]]
name = "Wheel2"
mass = 1
inertia = [0.1, 0.1, 0.1]

[[body]]
name = "Follower"
mass = 1
inertia = [0.1, 0.1, 0.1]

[[joint]]
name = "A"
type = "revolute"
between = ["ground", "Wheel1"]
coordinate = "alpha"

[[joint]]
name = "B"
type = "revolute"
between = ["ground.b", "Wheel2"]

[[joint]]
name = "C"
type = "revolute"
between = ["ground.c", "Follower"]
coordinate = "gamma"

[[constraint]]
name = "mesh"
type = "gear"
coupled = ["alpha", "B"]
ratio = "-2"

[[constraint]]
name = "cam"
type = "equation"
equations = ["gamma - sin(alpha)"]
"""


@pytest.fixture
def crank(visit: Any) -> BuilderPage:
    builder: BuilderPage = visit()
    builder.open_example("slider_crank")
    return builder


@pytest.fixture
def faulty_crank(visit: Any) -> BuilderPage:
    """The slider-crank in a page that may send formulas which cannot be read."""
    builder: BuilderPage = visit(expected=("422",))
    builder.open_example("slider_crank")
    return builder


def open_text(builder: BuilderPage, settings: Any, name: str, text: str) -> None:
    path = settings.roots[0] / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    builder.page.evaluate(f"location.hash = 'open={path}'")
    builder.page.reload()
    builder.page.get_by_test_id("node-Ground").wait_for()
    builder.wait_checked()
    builder.page.wait_for_timeout(400)


def empty_place(builder: BuilderPage) -> tuple[float, float]:
    """Return a place of the diagram at which there is nothing."""
    box = builder.page.get_by_test_id("diagram").bounding_box()
    return box["x"] + box["width"] - 40, box["y"] + 25


def drag(builder: BuilderPage, start: tuple[float, float], end: tuple[float, float], steps: int = 8) -> None:
    builder.page.mouse.move(*start)
    builder.page.mouse.down()
    builder.page.mouse.move(*end, steps=steps)
    builder.page.mouse.up()


def field_value(builder: BuilderPage, label: str) -> str:
    return str(builder.page.get_by_test_id("properties").get_by_label(label, exact=True).input_value())


def test_the_start_offers_new_open_and_examples_of_which_one_click_opens_a_working_model(visit: Any) -> None:
    builder = visit()
    page = builder.page
    page.locator(".card").first.wait_for()
    for name in ("New model", "Open…"):
        assert page.get_by_role("button", name=name).is_visible()
    for name in ("spring_mass_damper", "projectile", "rr_robot", "spinning_top", "slider_crank"):
        assert page.get_by_test_id(f"example-{name}").count() == 1
    builder.open_example("spring_mass_damper")
    assert builder.state("check.summary.freedoms") == 1
    assert page.get_by_test_id("live").get_by_role("button").inner_text().strip() == "Ready"


def test_the_palette_is_searched_and_an_element_drops_on_the_grid_at_the_pointer(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.new()
    assert {"Bodies", "Joints", "Forces and torques"} <= set(page.locator(".left h3").all_inner_texts())
    page.get_by_placeholder("Search elements").fill("slides along an axis")
    assert page.get_by_test_id("palette-prismatic").count() == 1
    assert page.get_by_test_id("palette-revolute").count() == 0
    page.get_by_placeholder("Search elements").fill("")
    builder.drop("body", 333, 127)
    box = page.get_by_test_id("node-Body1").bounding_box()
    target = page.get_by_test_id("diagram").bounding_box()
    assert box["x"] < target["x"] + 333 < box["x"] + box["width"]
    assert box["y"] < target["y"] + 127 < box["y"] + box["height"]
    assert [each % GRID for each in builder.state("data.layout.nodes.Body1")] == [0, 0]


def test_elements_are_inserted_by_a_key_a_double_click_and_a_menu(visit: Any) -> None:
    builder = visit()
    page = builder.page
    builder.new()
    builder.insert("bod")
    page.mouse.dblclick(*empty_place(builder))
    page.get_by_test_id("chooser").get_by_role("combobox").fill("body")
    builder.keys("Enter")
    page.mouse.click(*empty_place(builder), button="right")
    page.get_by_role("menuitem", name="Add an element…").click()
    page.keyboard.type("body")
    builder.keys("ArrowDown", "ArrowUp", "Enter")
    assert len({each["name"] for each in builder.state("data.body")}) == 3
    assert builder.steps() == 3


def test_ports_are_named_large_enough_and_say_what_they_take(crank: BuilderPage) -> None:
    page = crank.page
    for name in ("Ground", "Crank.A", "Rod.C", "Piston"):
        box = page.get_by_test_id(f"port-{name}").bounding_box()
        zoom = page.evaluate(
            "new DOMMatrix(getComputedStyle(document.querySelector('.react-flow__viewport')).transform).a"
        )
        assert min(box["width"], box["height"]) / zoom >= 12
    assert "Frame Crank.B" in str(page.get_by_test_id("port-Crank.B").get_attribute("title"))
    assert page.locator(".port-label", has_text="B").count() >= 2
    page.mouse.move(*crank.middle("port-Crank.A"))
    page.mouse.down()
    page.mouse.move(*crank.middle("port-Rod.C"), steps=6)
    assert "valid" in str(page.get_by_test_id("port-Rod.C").get_attribute("class"))
    assert page.locator(".connection-line.valid").count() == 1
    page.mouse.move(*crank.middle("port-Crank.B"), steps=6)
    assert (
        page.locator(".connection-line.invalid text").text_content() == "A body cannot be connected to itself"
    )
    page.mouse.up()
    assert crank.steps() == 0 and page.get_by_test_id("chooser").count() == 0


def test_parallel_edges_lie_apart_and_each_can_be_clicked(crank: BuilderPage) -> None:
    page = crank.page
    for element in ("spring", "torsion_spring", "spring"):
        crank.join("Ground", "Crank.A", element)
        page.wait_for_timeout(100)
    names = [
        "A",
        *(each["name"] for each in [*crank.state("data.spring"), *crank.state("data.torsion_spring")]),
    ]
    paths = {page.get_by_test_id(f"edge-{name}").get_attribute("d") for name in names}
    assert len(paths) == 4
    assert overlaps(page, ".edge-badge") == [] and overlaps(page, ".body-node") == []
    for name in names:
        crank.keys("Escape")
        page.get_by_test_id(f"badge-{name}").click()
        assert len(crank.state("selection")) == 1
        assert page.get_by_test_id("properties").get_by_role("heading", name=name, exact=True).is_visible()


def test_an_edge_takes_another_frame_and_a_drop_on_nothing_changes_nothing(crank: BuilderPage) -> None:
    page = crank.page
    before = crank.state("data")
    end = page.locator('.react-flow__edge[data-id="joint/2"] .react-flow__edgeupdater-target')

    def grip() -> tuple[float, float]:
        box, port = end.bounding_box(), crank.middle("port-Rod.C")
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        return x + 0.4 * (x - port[0]), y + 0.4 * (y - port[1])

    def draw_end(place: tuple[float, float]) -> None:
        """Drag the end of the edge, once it is at rest, and see that the diagram follows the pointer and ends."""
        at, previous = grip(), None
        while at != previous:
            page.wait_for_timeout(50)
            at, previous = grip(), at
        page.mouse.move(*at)
        page.mouse.down()
        page.mouse.move(*place, steps=8)
        page.locator(".react-flow__connection").wait_for(state="attached")
        page.mouse.up()
        page.locator(".react-flow__connection").wait_for(state="detached")

    draw_end(empty_place(crank))
    assert (crank.state("data"), crank.steps()) == (before, 0)
    draw_end(crank.middle("port-Crank.B"))
    crank.wait('s.data.joint[2].between[1] === "Crank.B"')
    assert crank.state("data.joint[2].between") == ["Piston", "Crank.B"]
    assert crank.steps() == 1
    crank.keys("Control+z")
    assert crank.state("data") == before


def test_a_node_snaps_shows_what_it_is_aligned_with_and_moves_freely_with_alt(crank: BuilderPage) -> None:
    page = crank.page
    x, y = crank.middle("node-Crank")
    drag(crank, (x, y), (x + 33, y + 27))
    assert [each % GRID for each in crank.state("data.layout.nodes.Crank")] == [0, 0]
    crank.keys("Control+z")
    target = crank.middle("node-Piston")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(target[0], y + 40, steps=6)
    seen = 0
    for shift in range(-80, 80, 4):
        page.mouse.move(target[0] + shift, y + 40)
        page.wait_for_timeout(40)
        seen += page.locator(".guide.upright").count()
    assert seen > 0
    page.mouse.up()
    assert page.locator(".guide").count() == 0
    crank.keys("Control+z")
    page.keyboard.down("Alt")
    drag(crank, (x, y), (x + 33, y + 27))
    page.keyboard.up("Alt")
    assert any(each % GRID for each in crank.state("data.layout.nodes.Crank"))


def test_undo_and_redo_follow_gestures_and_leave_texts_to_their_fields(faulty_crank: BuilderPage) -> None:
    crank = faulty_crank
    page = crank.page
    page.get_by_test_id("node-Crank").click()
    field = page.get_by_test_id("properties").get_by_label("Mass", exact=True)
    field.click()
    page.keyboard.type("+m2")
    assert (crank.steps(), crank.state("data.body[0].mass")) == (1, "m1+m2")
    crank.keys("Control+z")  # the field's own
    assert page.evaluate("document.activeElement.dataset.pointer") == "/body/0/mass"
    assert crank.steps() >= 1
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    while crank.steps() > 0:
        crank.keys("Control+z")
    page.get_by_test_id("node-Crank").click()
    assert (crank.state("data.body[0].mass"), field_value(crank, "Mass")) == ("m1", "m1")
    x, y = crank.middle("node-Crank")
    drag(crank, (x, y), (x + 40, y + 20))
    moved = crank.state("data.layout.nodes.Crank")
    crank.keys("Control+z", "Control+Shift+z")
    assert crank.state("data.layout.nodes.Crank") == moved
    crank.keys("Control+z", "Control+y")
    assert crank.state("data.layout.nodes.Crank") == moved and crank.steps() == 1


def test_clipboard_keys_arrows_and_escape(crank: BuilderPage) -> None:
    page = crank.page
    page.get_by_test_id("node-Crank").click()
    crank.keys("Control+d")
    assert crank.state("data.body.map(b => b.name)") == ["Crank", "Rod", "Piston", "Crank1"]
    crank.keys("Control+x")
    assert crank.state("data.body.length") == 3
    crank.keys("Control+v", "Control+v")
    names = crank.state("data.body.map(b => b.name)")
    assert len(names) == len(set(names)) == 5
    spots = [tuple(crank.state("data.layout.nodes")[name]) for name in names[3:]]
    assert len(set(spots)) == 2
    crank.keys("Delete", "Control+v", "Backspace")
    assert crank.state("data.body.length") == 4
    page.get_by_test_id("node-Rod").click()
    page.locator('.react-flow__node[data-id="body/1"]').focus()
    left, top = crank.state("data.layout.nodes.Rod")
    crank.keys("ArrowRight", "Shift+ArrowDown", "Alt+ArrowLeft")
    assert crank.state("data.layout.nodes.Rod") == [left + GRID - 1, top + 5 * GRID]
    crank.keys("Control+a")
    assert len(crank.state("selection")) == 10  # with ground and input
    crank.keys("Escape")
    assert crank.state("selection") == []
    page.get_by_test_id("node-Ground").click()
    crank.keys("Delete")
    assert crank.state("spoken") == "The ground stays."


def test_several_are_selected_and_moved_in_one_step(crank: BuilderPage) -> None:
    page = crank.page
    before = crank.state("data.body.length")
    boxes = [page.get_by_test_id(f"node-{name}").bounding_box() for name in ("Crank", "Rod")]
    left = min(each["x"] for each in boxes) - 12
    top = min(each["y"] for each in boxes) - 12
    right = max(each["x"] + each["width"] for each in boxes) - 5
    bottom = max(each["y"] + each["height"] for each in boxes) - 5
    drag(crank, (left, top), (right, bottom))
    assert {"body/0", "body/1"} <= set(crank.state("selection"))
    crank.keys("Escape")
    page.get_by_test_id("node-Crank").click()
    page.get_by_test_id("node-Piston").click(modifiers=["Shift"])
    assert set(crank.state("selection")) == {"body/0", "body/2"}
    x, y = crank.middle("node-Crank")
    drag(crank, (x, y), (x + 30, y + 20))
    assert crank.steps() == 1 and crank.state("data.body.length") == before
    crank.keys("Control+z")
    assert crank.state("data === symbodyBuilder.state().saved") is True


def test_menus_have_the_commands_and_their_keys(crank: BuilderPage) -> None:
    page = crank.page

    def menu() -> dict[str, str]:
        items = page.get_by_role("menu").get_by_role("menuitem").all()
        found = {each.locator("span").inner_text(): each.locator("kbd").all_inner_texts() for each in items}
        crank.keys("Escape")
        assert page.get_by_role("menu").count() == 0
        return {name: keys[0] if keys else "" for name, keys in found.items()}

    page.get_by_test_id("node-Crank").click(button="right")
    on_node = menu()
    assert on_node["Delete"] == "Del" and on_node["Copy"] == "Ctrl+C" and on_node["Rename"] == "F2"
    page.get_by_test_id("badge-A").click(button="right")
    assert menu().keys() == on_node.keys()
    page.mouse.click(*empty_place(crank), button="right")
    assert {"Add an element…", "Undo", "Redo", "Select all"} <= menu().keys()
    page.get_by_role("tab", name="Trees").click()
    page.get_by_test_id("trees").locator(".tree-row").first.click(button="right")
    assert menu().keys() == on_node.keys()
    assert crank.state("selection")[0].startswith("joint/")


def test_fields_have_labels_units_components_and_their_formulas_as_mathematics(crank: BuilderPage) -> None:
    page = crank.page
    page.get_by_test_id("node-Crank").click()
    crank.wait_checked()
    panel = page.get_by_test_id("properties")
    unlabelled = panel.locator("input, select").evaluate_all(
        "all => all.filter(e => !e.labels?.length && !e.getAttribute('aria-label') && !e.getAttribute('aria-labelledby')).length"
    )
    assert unlabelled == 0
    assert "kg" in panel.inner_text() and [
        field_value(crank, f"Inertia {axis}") for axis in ("xx", "yy", "zz")
    ]
    crank.fill("Mass", "2*m1*L1^2/3")
    crank.wait_checked()
    page.wait_for_timeout(300)
    shown = panel.locator('[data-formula="/body/0/mass"] math, math')
    assert shown.count() >= 1 and panel.locator("math mfrac, math msup").count() >= 1


def test_a_fault_stands_at_its_field_its_node_and_in_the_list(faulty_crank: BuilderPage) -> None:
    crank = faulty_crank
    page = crank.page
    page.get_by_test_id("node-Rod").click()
    crank.fill("Mass", "m2 +")
    crank.wait_checked()
    field = page.get_by_test_id("properties").get_by_label("Mass", exact=True)
    assert field.get_attribute("aria-invalid") == "true"
    message = page.get_by_test_id("properties").get_by_role("alert").first
    assert message.inner_text().strip() != ""
    assert page.get_by_test_id("node-Rod").locator(".node-flag.error").count() == 1
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    page.get_by_test_id("live").get_by_role("button").click()
    page.get_by_test_id("problem").first.click()
    page.wait_for_timeout(300)
    assert crank.state("selection") == ["body/1"]
    assert page.evaluate("document.activeElement.dataset.pointer") == "/body/1/mass"
    box, area = page.get_by_test_id("node-Rod").bounding_box(), page.get_by_test_id("diagram").bounding_box()
    assert area["x"] <= box["x"] and box["x"] + box["width"] <= area["x"] + area["width"]


def test_warnings_are_no_errors_and_a_safe_repair_has_a_button(crank: BuilderPage) -> None:
    page = crank.page
    page.get_by_role("tab", name="Trees").click()
    page.get_by_test_id("trees").get_by_role("checkbox", name="B in the rotation tree").click()
    page.get_by_test_id("trees").get_by_role("checkbox", name="B in the translation tree").click()
    crank.wait_checked()
    problems = crank.state("check.problems")
    repairs = [each["repair"]["label"] for each in problems if each["repair"] is not None]
    if repairs:  # the trees that were chosen have a circle
        page.get_by_role("tab", name="Problems").click()
        page.get_by_role("button", name=repairs[0]).first.click()
        crank.wait_checked()
    assert [each for each in crank.state("check.problems") if each["severity"] == "error"] == []
    page.locator(".react-flow__pane").click(position={"x": 20, "y": 20})
    crank.fill("L1", "")
    crank.wait_checked()
    live = page.get_by_test_id("live").get_by_role("button")
    assert "warning" in live.inner_text() and "warning" in str(live.get_attribute("class"))
    assert [each for each in crank.state("check.problems") if each["severity"] == "error"] == []


def test_trees_diagram_picture_and_counts_are_in_step(crank: BuilderPage) -> None:
    page = crank.page
    before = crank.state("check.summary")
    assert page.get_by_test_id("badge-B").locator(".tree-mark").inner_text() == "loop"
    page.get_by_role("tab", name="Trees").click()
    trees = page.get_by_test_id("trees")
    assert "B closes" in trees.inner_text() and "2 constraint equations" in trees.inner_text()
    for tree in ("rotation", "translation"):
        trees.get_by_role("checkbox", name=f"C in the {tree} tree").click()
        crank.wait_checked()
    after = crank.state("check.summary")
    assert after["rotation_tree"] == ["A", "B", "D"] and before["rotation_tree"] == ["A", "C", "D"]
    assert [chord["joint"] for chord in after["chords"]] == ["C"] and after["freedoms"] == 1
    assert after["coordinates"] != before["coordinates"]
    assert page.get_by_test_id("badge-C").locator(".tree-mark").inner_text() == "loop"
    assert page.get_by_test_id("badge-B").locator(".tree-mark").count() == 0
    assert "1 degree of freedom" in page.get_by_test_id("live").inner_text()
    trees.get_by_role("button", name="D ", exact=False).last.click()
    assert crank.state("selection") == ["joint/3"]
    crank.wait("window.symbodyPicture && window.symbodyPicture.shown")
    page.wait_for_timeout(200)
    assert page.evaluate("symbodyPicture.shown.player.viewer.selected.name") == "D"


def test_names_are_changed_in_place(crank: BuilderPage) -> None:
    page = crank.page
    crank.rename("node-Crank", "Arm")
    assert crank.state("data.body[0].name") == "Arm" and crank.steps() == 1
    assert crank.state("data.joint[0].between") == ["ground", "Arm.A"]
    for test_id in ("node-Rod", "badge-B"):
        page.get_by_test_id(test_id).dblclick()
        page.locator(".name-editor").fill("Nonsense")
        crank.keys("Escape")
        assert page.locator(".name-editor").count() == 0
    assert crank.steps() == 1 and crank.state("data.body[1].name") == "Rod"
    page.get_by_test_id("badge-B").dblclick()
    page.locator(".name-editor").fill("Pin")
    crank.keys("Enter")
    assert crank.state("data.joint[1].name") == "Pin"


def test_couplings_lead_to_their_joints_and_back(visit: Any, settings: Any) -> None:
    builder = visit()
    page = builder.page
    open_text(builder, settings, "gears", GEARS)
    assert [each for each in builder.state("check.problems") if each["severity"] == "error"] == []
    links = sorted(each.get_attribute("data-testid") for each in page.locator(".coupling-lines g").all())
    assert links == ["link-cam-A", "link-cam-C", "link-mesh-A", "link-mesh-B"]
    assert overlaps(page, ".body-node") == [] and overlaps(page, ".edge-badge") == []
    assert overlaps(page, ".body-node, .edge-badge") == []
    page.get_by_test_id("mark-A-mesh").click()
    assert builder.state("selection") == ["constraint/0"]
    assert page.locator(".coupling-line.selected").count() == 2
    page.get_by_test_id("node-mesh").get_by_role("button", name="B", exact=True).click()
    assert builder.state("selection") == ["joint/1"]
    page.get_by_test_id("node-cam").get_by_role("button", name="gamma").click()
    assert builder.state("selection") == ["joint/2"]
    lines = page.locator(".coupling-line").evaluate_all("all => all.map(e => e.getAttribute('d'))")
    assert len(set(lines)) == 4
    x, y = builder.middle("node-mesh")
    drag(builder, (x, y - 8), (x - 60, y - 8))  # the lines go along
    moved = page.locator(".coupling-line").evaluate_all("all => all.map(e => e.getAttribute('d'))")
    assert sum(a != b for a, b in zip(lines, moved, strict=True)) >= 2
