"""Bodies are dragged in the picture: loops stay closed, one gesture is one step, and the view can still be turned."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symbody.formats.model_files import examples_folder

from .builder_page import BuilderPage

pytestmark = pytest.mark.exhaustive  # the fast tier builds a mechanism with the mouse

POSE = """(() => {
  const { source, player } = symbodyPicture.shown;
  const { bodies, joints } = player.viewer.scene;
  const pose = { positions: new Float64Array(3 * bodies.length), quaternions: new Float64Array(4 * bodies.length) };
  pose.quaternions[0] = 1; // the ground
  source.poseAt(0, pose);
  return { names: bodies.map(b => b.name), at: Array.from(pose.positions), turned: Array.from(pose.quaternions),
           joints: joints.map(j => ({ type: j.type, start: j.start, end: j.end })) };
})()"""


def opened(visit: Any, name: str, **options: Any) -> BuilderPage:
    builder: BuilderPage = visit(**options)
    builder.open_example(name)
    builder.wait("window.symbodyPicture && window.symbodyPicture.shown")
    builder.page.wait_for_timeout(500)  # the camera has come to rest
    return builder


def points(builder: BuilderPage, body: str) -> dict[str, Any]:
    """Return where bodies are seen in the page, by name, and how far joints that hold points are open [m]."""
    pose = builder.page.evaluate(POSE)
    at = np.array(pose["at"]).reshape(-1, 3)
    turned = np.array(pose["turned"]).reshape(-1, 4)
    axes = Rotation.from_quat(np.roll(turned, -1, axis=1)).as_matrix()

    def place(anchor: Any) -> Any:
        return at[anchor["body"]] + axes[anchor["body"]] @ np.array(anchor["at"])

    gaps = [
        float(np.linalg.norm(place(joint["start"]) - place(joint["end"])))
        for joint in pose["joints"]
        if joint["type"] in ("revolute", "spherical", "universal")
    ]
    centre = at[pose["names"].index(body)].tolist()
    seen = builder.page.evaluate(f"symbodyPicture.shown.player.viewer.pagePlace({centre})")
    return {"centre": centre, "seen": tuple(seen), "gaps": gaps}


def hold(builder: BuilderPage, body: str) -> tuple[float, float]:
    """Press on the middle of a body."""
    x, y = points(builder, body)["seen"]
    builder.page.mouse.move(x, y)
    builder.page.mouse.down()
    return float(x), float(y)


def camera(builder: BuilderPage) -> Any:
    return builder.page.evaluate("symbodyPicture.shown.player.viewer.rig.camera.position.toArray()")


def resting_camera(builder: BuilderPage) -> Any:
    """Return where the camera is as soon as no turn and no damping moves it, however slowly frames come."""
    for _ in range(100):
        before = camera(builder)
        builder.page.wait_for_timeout(300)
        if camera(builder) == pytest.approx(before, abs=1e-9):
            return before
    raise AssertionError("the camera does not come to rest")


@pytest.mark.parametrize(("example", "body"), [("slider_crank", "Crank"), ("spatial_four_bar", "Crank")])
def test_a_body_is_dragged_and_the_loop_follows(visit: Any, example: str, body: str) -> None:
    builder = opened(visit, example)
    page, before = builder.page, builder.state("check.values")
    under_way, most, count = set(), 0, 0

    def begin(request: Any) -> None:
        nonlocal most, count
        if request.url.endswith("/api/drag"):
            under_way.add(request)
            most, count = max(most, len(under_way)), count + 1

    page.on("request", begin)
    page.on("requestfinished", lambda request: under_way.discard(request))
    first, view = points(builder, body), camera(builder)
    x, y = hold(builder, body)
    open_gaps = []
    for step in range(1, 13):
        page.mouse.move(x - 5 * step, y - 3 * step)
        page.wait_for_timeout(30)
        open_gaps += points(builder, body)["gaps"]
    builder.wait("s.posed !== null && s.posed.moved")
    page.wait_for_timeout(400)
    last = points(builder, body)
    assert len(last["gaps"]) >= 3 and max(last["gaps"]) < 1e-8
    assert max(open_gaps) < 1e-6  # the start, which is shown until the first answer, is in single precision
    assert np.linalg.norm(np.array(last["centre"]) - first["centre"]) > 0.02
    assert camera(builder) == pytest.approx(view, abs=1e-9)
    assert builder.steps() == 0 and builder.state("selection") == ["body/0"]
    posed = builder.state("posed.values")
    shown = page.get_by_test_id("positions").get_by_label(next(iter(before)), exact=True)
    assert float(shown.input_value()) == pytest.approx(posed[next(iter(before))], abs=1e-6)
    page.mouse.up()
    builder.wait("s.data.initial.theta !== undefined && s.posed !== null && s.posed.of !== s.data")
    builder.wait_checked()
    assert builder.steps() == 1
    page.wait_for_timeout(400)
    assert camera(builder) == pytest.approx(view, abs=1e-9)  # what was held stays under the pointer
    assert builder.state("check.values") == pytest.approx(posed, abs=2e-5)
    assert max(points(builder, body)["gaps"]) < 1e-6  # in single precision, as pictures are sent
    assert (most, under_way) == (1, set()) and count >= 2
    builder.keys("Control+z")
    builder.wait_checked()
    assert builder.state("check.values") == pytest.approx(before, abs=1e-9)


def test_the_point_that_is_held_follows_the_pointer(visit: Any) -> None:
    builder = opened(visit, "stewart_platform")
    x, y = hold(builder, "Platform")
    for step in range(1, 7):
        builder.page.mouse.move(x + 4 * step, y - 2 * step)
        builder.page.wait_for_timeout(60)
    builder.wait("s.posed !== null && s.posed.moved")
    builder.page.wait_for_timeout(900)
    line = builder.page.get_by_test_id("thread").locator("line")
    ends = [float(line.get_attribute(name) or "nan") for name in ("x1", "y1", "x2", "y2")]
    assert np.hypot(ends[0] - ends[2], ends[1] - ends[3]) < 1.5
    assert max(points(builder, "Platform")["gaps"]) < 1e-8
    assert builder.state("pictureNote") == ""
    builder.page.mouse.up()


def test_escape_puts_the_mechanism_back(visit: Any) -> None:
    builder = opened(visit, "slider_crank")
    before, first = builder.state("data"), points(builder, "Crank")
    x, y = hold(builder, "Crank")
    builder.page.mouse.move(x - 40, y - 10, steps=6)
    builder.wait("s.posed !== null && s.posed.moved")
    builder.keys("Escape")
    builder.page.wait_for_timeout(400)
    assert points(builder, "Crank")["centre"] == pytest.approx(first["centre"], abs=1e-6)
    builder.page.mouse.move(x - 60, y - 30, steps=3)
    builder.page.mouse.up()
    builder.page.wait_for_timeout(200)
    assert (builder.steps(), builder.state("data"), builder.state("posed")) == (0, before, None)
    assert builder.state("dragged") is None


def test_the_view_turns_beside_the_bodies_and_with_alt(visit: Any) -> None:
    builder = opened(visit, "spatial_four_bar")
    page = builder.page
    box = page.get_by_test_id("picture").bounding_box()
    views = [camera(builder)]
    page.mouse.move(box["x"] + 20, box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 80, box["y"] + box["height"] / 2 + 10, steps=5)
    page.mouse.up()
    views.append(resting_camera(builder))
    page.keyboard.down("Alt")
    x, y = hold(builder, "Rocker")
    page.mouse.move(x + 30, y, steps=4)
    page.mouse.up()
    page.keyboard.up("Alt")
    views.append(resting_camera(builder))
    assert all(np.linalg.norm(np.subtract(a, b)) > 0.05 for a, b in zip(views, views[1:], strict=False))
    assert (builder.steps(), builder.state("posed")) == (0, None)
    # what the user chose stays when the start changes
    x, y = hold(builder, "Crank")
    page.mouse.move(x + 15, y + 10, steps=4)
    builder.wait("s.posed !== null && s.posed.moved")
    page.mouse.up()
    builder.wait("s.posed !== null && s.posed.of !== s.data")
    builder.wait_checked()
    assert resting_camera(builder) == pytest.approx(views[-1], abs=0.02)  # a frame of damping may be late


def test_the_camera_follows_what_leaves_the_picture(visit: Any) -> None:
    """A rod of three times its length does not fit any more: the view holds it again."""
    builder = opened(visit, "slider_crank")
    view = camera(builder)
    field = builder.page.get_by_test_id("parameters").get_by_label("L2", exact=True)
    field.fill("3")
    field.press("Enter")
    builder.wait(f"symbodyPicture.shown.player.viewer.rig.distance > {2 * view[2]}")
    box = builder.page.get_by_test_id("picture").bounding_box()
    for body in ("Crank", "Rod", "Piston"):
        x, y = points(builder, body)["seen"]
        assert box["x"] < x < box["x"] + box["width"] and box["y"] < y < box["y"] + box["height"]


def test_a_mechanism_stands_beside_the_axes_in_the_corner(visit: Any) -> None:
    """Where there is room, no body lies under the axes and the arrow of gravity."""
    for size in ((1440, 900), (1024, 768)):
        builder = opened(visit, "slider_crank", viewport={"width": size[0], "height": size[1]})
        corner = builder.page.locator(".picture .sb-triad").bounding_box()
        pose = builder.page.evaluate(POSE)
        places = np.array(pose["at"]).reshape(-1, 3)
        for place in places:  # the first is the ground, where the crank turns
            x, y = builder.page.evaluate(f"symbodyPicture.shown.player.viewer.pagePlace({place.tolist()})")
            inside = corner["x"] < x < corner["x"] + corner["width"]
            assert not (inside and corner["y"] < y < corner["y"] + corner["height"])


def test_a_spherical_joint_is_turned_by_angles(visit: Any) -> None:
    """Four components of a quaternion are no sliders: three turns are."""
    builder = opened(visit, "stewart_platform")
    page = builder.page
    joint = page.locator(".free-body", has_text="ball1")
    joint.locator("summary").click()
    assert page.get_by_label("Value of ball1_qw", exact=True).count() == 0
    assert joint.get_by_role("slider").count() == 3
    assert joint.locator("summary").inner_text() == "ball1 turns in all directions"
    field = joint.get_by_label("Value of ball1, turn about z", exact=True)
    before = builder.state("check.values")
    field.fill("12")
    field.press("Enter")
    builder.wait("s.posed !== null && s.posed.moved")
    after = builder.state("posed.values")
    assert field.input_value() == "12"
    assert abs(after["ball1_qz"] - before["ball1_qz"]) > 0.01
    assert max(points(builder, "Platform")["gaps"]) < 1e-8


def test_values_of_positions_fit_their_fields(visit: Any) -> None:
    builder = opened(visit, "slider_crank")
    x, y = hold(builder, "Crank")
    builder.page.mouse.move(x - 48, y + 72, steps=8)
    builder.wait("s.posed !== null && s.posed.moved")
    builder.page.mouse.up()
    fields = builder.page.get_by_test_id("positions").locator("input:not([type=range], [type=checkbox])")
    assert fields.count() == 3
    assert fields.evaluate_all("all => all.filter(e => e.scrollWidth > e.clientWidth)") == []


def test_a_click_selects_and_changes_nothing(visit: Any) -> None:
    builder = opened(visit, "slider_crank")
    hold(builder, "Piston")
    builder.page.mouse.up()
    assert builder.state("selection") == ["body/2"]
    assert (builder.steps(), builder.state("posed")) == (0, None)


def test_what_cannot_be_assembled_stays_at_the_last_pose_and_says_so(visit: Any) -> None:
    builder = opened(visit, "slider_crank", expected=("422",))
    page = builder.page
    x, y = hold(builder, "Crank")
    page.mouse.move(x - 30, y - 10, steps=4)
    builder.wait("s.posed !== null && s.posed.moved")
    page.wait_for_timeout(300)
    good = points(builder, "Crank")["centre"]
    refusal = {"problems": [{"severity": "error", "pointer": "", "element": "", "code": "assembly.open",
               "what": "joint B cannot be closed: a gap of 0.1 m remains", "why": "", "fix": "drag another way", "line": None, "repair": None}]}  # fmt: skip
    page.route("**/api/drag", lambda route: route.fulfill(status=422, json=refusal))
    page.mouse.move(x - 60, y - 40, steps=4)
    builder.wait("s.posed.problem !== ''")
    assert points(builder, "Crank")["centre"] == pytest.approx(good, abs=1e-12)
    assert (
        page.get_by_test_id("picture-note").inner_text()
        == "Joint B cannot be closed: a gap of 0.1 m remains; drag another way."
    )
    page.mouse.up()
    builder.wait("s.data !== s.saved")
    assert builder.steps() == 1
    page.unroute("**/api/drag")


def test_a_body_whose_motion_is_prescribed_says_why_it_stays(visit: Any, settings: Any) -> None:
    text = (examples_folder() / "slider_crank" / "slider_crank.toml").read_text(encoding="utf-8")
    path = settings.roots[0] / "driven.toml"
    driven = text.partition("[initial]")[0].replace(
        'coordinate = "theta"', 'coordinate = "theta"\nmotion = "pi/6"'
    )
    path.write_text(driven, encoding="utf-8")
    builder = visit(expected=("422",))
    page = builder.page
    page.evaluate(f"location.hash = 'open={path}'")
    page.reload()
    page.get_by_test_id("node-Crank").wait_for()
    builder.wait_checked()
    builder.wait("window.symbodyPicture && window.symbodyPicture.shown")
    page.wait_for_timeout(500)
    x, y = hold(builder, "Piston")
    page.mouse.move(x - 30, y - 10, steps=4)
    builder.wait("s.pictureNote !== ''")
    assert page.get_by_test_id("picture-note").inner_text().startswith("Nothing moves this point of Piston")
    page.mouse.up()
    page.wait_for_timeout(300)
    assert (builder.steps(), builder.state("data") == builder.state("saved")) == (0, True)
