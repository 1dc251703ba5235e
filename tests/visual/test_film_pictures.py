"""What is seen: outlines, what hides what, transparency, the same in samples and in lines."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from itertools import combinations

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.path import Path
from numpy.testing import assert_allclose

from symbody.errors import UsageError
from symbody.visual.film.annotations import round_number, with_unit
from symbody.visual.film.drawing import Caption, Drawing, Stroke
from symbody.visual.film.files.raster import pixels_of
from symbody.visual.film.files.svg import svg_text
from symbody.visual.film.labels import named_points, place_labels
from symbody.visual.film.palette import LIGHT
from symbody.visual.film.pictures import draw_scene, vector_drawing
from symbody.visual.film.stage import pose_at
from symbody.visual.film.studio import Look, Studio, make_studio
from symbody.visual.film.surfaces.item_buffer import rasterize
from symbody.visual.film.surfaces.polylines import join_lines
from symbody.visual.film.surfaces.regions import trace_regions
from symbody.visual.film.text_metrics import text_width
from symbody.visual.scene.scene import Anchor, Connector, MotionVector, Scene, SceneMotion
from tests.visual.film_scenes import ball, box, motion_of, scene_of

FRONT = Look("front", (240, 160))
WHITE = np.array([255, 255, 255])


def studio(scene: Scene, motion: SceneMotion, look: Look = FRONT, per_pixel: float = 3.0) -> Studio:
    return make_studio(scene, motion, look, per_pixel)


def body_strokes(drawing: Drawing, color: str | None = None) -> list[Stroke]:
    """Return the strokes of edges: those of another width or colour are annotations."""
    strokes = [mark for mark in drawing.marks if isinstance(mark, Stroke) and mark.width in (0.9, 0.55)]
    return [each for each in strokes if color is None or each.color == color]


def test_triangles_cover_the_samples_inside_and_the_nearer_wins() -> None:
    corners = np.array([[1.0, 1.0, 5.0], [9.0, 1.0, 5.0], [1.0, 9.0, 5.0]])
    nearer = np.array([[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 7.0]])
    buffer = rasterize(np.concatenate([corners, nearer]), np.array([[0, 1, 2], [3, 5, 4]]), (10, 10))
    items = np.full((10, 10), -1)
    items.reshape(-1)[buffer.places] = buffer.items
    y, x = np.mgrid[0:10, 0:10] + 0.5
    far = (x > 1) & (y > 1) & (x + y < 10)
    near = x + y < 4
    depth = 1.0 + 1.5 * y  # of the second triangle
    wins = near & (~far | (depth < 5.0))
    borders = (np.abs(x + y - 10) < 1e-9) | (np.abs(x + y - 4) < 1e-9)  # samples on a side belong to either
    assert_allclose(items[~borders], np.where(wins, 1, np.where(far, 0, -1))[~borders])
    assert_allclose(buffer.depth[1, 1], depth[1, 1], rtol=1e-6)
    assert np.isinf(buffer.depth[9, 9])


def test_sphere_has_its_radius() -> None:
    scene, motion = scene_of(("ball", ball(0.7))), motion_of(((0.0, 0.0, 0.0),))
    one = studio(scene, motion)
    drawing, _ = one.draw([0])
    covered = (drawing.samples != WHITE).any(axis=2)
    radius = 0.7 * one.backdrop.camera.scale * one.backdrop.grid.per_point
    # A polygon of 64 sides, and the samples along its rim.
    assert_allclose(covered.sum(), np.pi * radius**2, rtol=0.01)
    assert_allclose([covered.any(axis=1).sum(), covered.any(axis=0).sum()], 2 * radius, atol=1.6)
    points = np.concatenate([line for stroke in body_strokes(drawing) for line in stroke.lines])
    middle = one.backdrop.camera.project(np.zeros(3))[:2]
    away = np.hypot(*(points - middle).T)
    assert_allclose(away, 0.7 * one.backdrop.camera.scale, rtol=0.01)  # nothing but its outline
    angles = np.sort(np.arctan2(*(points - middle).T))
    assert np.diff(angles).max() < 0.11  # all around


@pytest.mark.parametrize("look", [FRONT, Look({"direction": "front", "perspective": True}, (240, 160))])
def test_what_is_in_front_hides_what_is_behind(look: Look) -> None:
    wide, small = box(2.0, 0.1, 0.4, color="#40c040"), box(0.5, 0.1, 1.0, color="#c04040")
    scene = scene_of(("wide", wide), ("small", small))
    drawings = [
        studio(scene, motion_of(((0.0, y, 0.0), (0.0, 0.0, 0.0))), look).draw([0])[0] for y in (1.0, -1.0)
    ]
    for drawing, hidden in zip(drawings, (True, False), strict=True):
        middle = drawing.samples[drawing.samples.shape[0] // 2, drawing.samples.shape[1] // 2]
        assert (middle[0] > middle[1]) == hidden  # red is in front of green, or behind it
        edges = np.array([line for each in body_strokes(drawing, "#174517") for line in each.lines])
        crossing = [
            line
            for line in edges
            if abs(np.ptp(line[:, 1])) < 1.0 and line[:, 0].min() < 85 and line[:, 0].max() > 95
        ]
        assert (not crossing) == hidden  # the long edges of the green box, in the middle of the picture


def test_intersecting_boxes_share_the_picture() -> None:
    """Two boxes that pass through each other, each in front on one side: no order of painting is right."""
    turned = np.array([np.cos(0.3), 0.0, 0.0, np.sin(0.3)])
    scene = scene_of(("one", box(2, 0.05, 1, color="#c00000")), ("two", box(2, 0.05, 1, color="#0000c0")))
    motion = SceneMotion(np.zeros(1), np.zeros((1, 2, 3)), np.array([[[1.0, 0, 0, 0], turned]]))
    samples = studio(scene, motion).draw([0])[0].samples
    row = samples[samples.shape[0] // 2].astype(int)
    covered = np.flatnonzero((row != WHITE).any(axis=1))
    quarter = covered[len(covered) // 4], covered[3 * len(covered) // 4]
    assert [bool(row[k, 0] > row[k, 2]) for k in quarter] == [False, True]


def test_transparent_bodies_let_through_their_share() -> None:
    behind, pane = box(1.0, 0.1, 1.0, color="#c04040"), box(2.0, 0.1, 2.0, color="#4040c0", opacity=0.25)
    places = motion_of(((0.0, 1.0, 0.0), (0.0, 0.0, 0.0)))
    clear, solid = (
        studio(scene_of(("behind", behind), ("pane", each)), places).draw([0])[0].samples
        for each in (pane, box(2.0, 0.1, 2.0, color="#4040c0"))
    )
    alone = studio(scene_of(("behind", behind), ("pane", box(2, 0.1, 2, opacity=0.0))), places).draw([0])[0]
    row, column = clear.shape[0] // 2, clear.shape[1] // 2
    mixed = 0.25 * solid[row, column] + 0.75 * alone.samples[row, column]
    assert_allclose(clear[row, column], mixed, atol=1.0)
    width = 150  # samples: beside what is behind, but before the paper
    assert_allclose(clear[row, column + width], 0.25 * solid[row, column + width] + 0.75 * 255, atol=1.0)


def test_earlier_positions_are_fainter_and_below() -> None:
    motion = motion_of(*[((x, 0.0, 0.0),) for x in (0.0, 0.5, 1.0)])
    one = studio(scene_of(("ball", ball(0.4))), motion)
    samples = one.draw([0, 1, 2])[0].samples.astype(int)
    camera, per_point = one.backdrop.camera, one.backdrop.grid.per_point
    first, second, last = (
        samples[tuple((camera.project(np.array([x, 0, 0]))[1::-1] * per_point).astype(int))].sum()
        for x in (-0.1, 0.4, 1.0)
    )
    assert last < second < first < 3 * 255
    assert_allclose(one.draw([2])[0].samples[:, -250:], samples[:, -250:], atol=0)  # the last is as if alone


def test_regions_cover_what_the_samples_do() -> None:
    """Filled by matplotlib, the traced polygons give back the samples that they came from."""
    scene = scene_of(("box", box(1.0, 0.5, 0.7)), ("ball", ball(0.5)), ground=box(3.0, 2.0, 0.1))
    motion = motion_of(((0.0, 0.0, 0.6), (0.8, 0.3, 0.9)))
    drawing = vector_drawing(scene, motion, [0], Look(None, (100, 75)))
    height, width = drawing.samples.shape[:2]
    y, x = np.mgrid[0:height, 0:width] + 0.5
    places = np.column_stack([x.ravel(), y.ravel()])
    painted = np.full((height * width, 3), 255)
    for region in trace_regions(drawing.samples, drawing.background):
        inside = np.zeros(len(places), dtype=bool)
        for ring in region.rings:
            inside ^= Path(ring).contains_points(places)
        painted[inside] = [int(region.color[k : k + 2], 16) for k in (1, 3, 5)]
    differs = (painted.reshape(drawing.samples.shape) != drawing.samples).any(axis=2)
    assert differs.mean() < 0.01  # along borders: they are straight where samples are steps
    # Nowhere thicker than two samples.
    assert not (
        differs[:-2, :-2] & differs[1:-1, 1:-1] & differs[2:, 2:] & differs[:-2, 2:] & differs[2:, :-2]
    ).any()


def test_svg_is_small_and_fit_for_print() -> None:
    scene = scene_of(("box", box(1.0, 0.5, 0.7)), ("ball", ball(0.5)), ground=box(3.0, 2.0, 0.1))
    motion = motion_of(((0.0, 0.0, 0.6), (0.8, 0.3, 0.9)))
    text = svg_text(vector_drawing(scene, motion, [0], Look(None, (240, 160), labels=True)), "a <test>")
    root = ET.fromstring(text)
    assert root.get("width") == "63.5mm" and root.get("viewBox") == "0 0 180 120"
    assert root.findtext("{http://www.w3.org/2000/svg}title") == "a <test>"
    words = [each.text for each in root.iter("{http://www.w3.org/2000/svg}text")]
    assert {"box", "ball", "x", "y", "z", "g", "t = 0.00 s"} <= set(words)
    assert len(text) < 20_000
    assert not re.search("nan|inf", text, re.IGNORECASE)


def test_flat_faces_are_one_region_each() -> None:
    motion = motion_of(((0.0, 0.0, 0.0),))
    drawing = vector_drawing(scene_of(("box", box(1.0, 1.0, 1.0))), motion, [0], Look(None, (240, 160)))
    regions = trace_regions(drawing.samples, drawing.background)
    assert len(regions) == 3 and all(len(each.rings) == 1 for each in regions)
    for region in regions:
        assert len(region.rings[0]) <= 8  # four corners, some of them cut off by half a sample
    joined = [line for each in body_strokes(drawing) for line in join_lines(each.lines)]
    assert len(joined) == 4  # the outline as one ring, and three edges inside
    assert sorted(len(line) for line in joined) == [2, 2, 2, 7]


def test_lines_are_joined_where_two_meet() -> None:
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    sides = [np.array([square[k], square[(k + 1) % 4]], dtype=float) for k in (2, 0, 3, 1)]
    (ring,) = join_lines([*sides, sides[0][::-1]])
    assert len(ring) == 5 and (ring[0] == ring[-1]).all()
    straight = join_lines([np.array([[0.0, 0], [1, 0]]), np.array([[2.0, 0], [1, 0]])])
    assert [line.tolist() for line in straight] in ([[[0, 0], [2, 0]]], [[[2, 0], [0, 0]]])


def test_pixels_have_marks_and_size() -> None:
    scene, motion = scene_of(("ball", ball(0.7))), motion_of(((0.0, 0.0, 0.0),))
    one = studio(scene, motion, Look("front", (241, 161), title="Cost: $5 and $6"), 2.0)
    pixels = pixels_of(one.draw([0])[0], (241, 161))
    assert pixels.shape == (161, 241, 3)
    assert (pixels[5:25, 10:120] < 100).any()  # the title
    dark = studio(scene, motion, Look("front", (240, 160), dark=True), 2.0)
    assert dark.draw([0])[0].samples[0, 0].max() < 40


def test_labels_do_not_overlap() -> None:
    names = [f"body number {k}" for k in range(12)]
    scene = scene_of(*[(name, ball(0.1)) for name in names])
    rows = tuple((0.25 * np.cos(k), 0.0, 0.2 * np.sin(k)) for k in range(12))
    one = studio(scene, motion_of(rows), Look("front", (600, 400)), 1.0)
    drawing, offsets = one.draw([0])
    marks, offsets = place_labels(
        named_points(scene, pose_at(one.motion, 0)),
        one.backdrop.camera,
        drawing.samples,
        drawing.size,
        LIGHT,
    )
    captions = [mark for mark in marks if isinstance(mark, Caption)]
    assert len(captions) == len(offsets) >= 10
    for a, b in combinations(captions, 2):
        apart = abs(a.at[0] - b.at[0]) >= (text_width(a.text, a.size) + text_width(b.text, b.size)) / 2
        assert apart or abs(a.at[1] - b.at[1]) >= a.size


def test_forces_are_drawn_to_scale_with_a_legend() -> None:
    values = np.array([[0.0, 0.0, 10.0], [0.0, 0.0, 5.0]])
    plain = motion_of(((0.0, 0.0, 0.0),), ((0.0, 0.0, 0.0),))
    vector = MotionVector("force", "force", Anchor(1, (0.0, 0.0, 0.0)), values)
    motion = SceneMotion(plain.times, plain.positions, plain.quaternions, (), (vector,))
    one = studio(scene_of(("ball", ball(0.3))), motion)
    ends = [
        max(
            float(np.ptp(stroke.lines[0][:, 1]))
            for stroke in one.draw([k])[0].marks
            if isinstance(stroke, Stroke) and stroke.color == "#c62f3b"
        )
        for k in (0, 1)
    ]
    # Of both 0.8 of the head, 4.6 widths of 1.8 points, lies beyond the shaft.
    assert_allclose((ends[0] + 0.8 * 8.28) / (ends[1] + 0.8 * 8.28), 2.0)
    texts = [mark.text for mark in one.draw([0])[0].marks if isinstance(mark, Caption)]
    assert any(text.endswith(" N") for text in texts)
    assert [round_number(x) for x in (0.99, 1.0, 3.0, 70.0)] == [0.5, 1.0, 2.0, 50.0]
    assert with_unit(0.002, "m") == "2 mm"


def test_traces_end_with_the_film() -> None:
    motion = motion_of(*[((0.1 * k, 0.0, 0.0),) for k in range(6)])
    one = studio(scene_of(("ball", ball(0.3))), motion, Look("front", (240, 160), traces=("ball.tip",)))
    lengths = []
    for until in (0.2, None):
        marks = one.draw([5], until)[0].marks
        (trace,) = [mark for mark in marks if isinstance(mark, Stroke) and mark.color == "#4f8fc4"]
        lengths.append(float(np.ptp(trace.lines[0][:, 0])) / one.backdrop.camera.scale)
    assert_allclose(lengths, [0.2, 0.5])
    with pytest.raises(UsageError, match=r"\[film.trace\].*\n.*ball.tip"):
        studio(scene_of(("ball", ball(0.3))), motion, Look(traces=("ball.tp",)))


def test_connectors_follow_their_ends() -> None:
    ends = Anchor(0, (0.0, 0.0, 0.0)), Anchor(1, (0.0, 0.0, 0.0))
    connectors = tuple(
        Connector(kind, kind, *ends, 0.1, 1.5, 8)  # type: ignore[arg-type]
        for kind in ("spring", "damper", "rope", "actuator", "line")
    )
    scene = scene_of(("ball", ball(0.1)), connectors=connectors)
    motion = motion_of(((1.0, 0.0, 0.0),), ((2.0, 0.0, 0.0),), ((0.0, 0.0, 0.0),))
    one = studio(scene, motion)
    widths = []
    for k in range(3):  # at the last both ends coincide
        covered = (one.draw([k])[0].samples != WHITE).any(axis=(0, 2))
        widths.append(covered.sum() / (one.backdrop.camera.scale * one.backdrop.grid.per_point))
    assert_allclose(widths[:2], [1.2, 2.2], atol=0.15)  # half the width of a wire beyond the start
    assert_allclose(widths[2], 0.2, atol=0.05)


def test_scenes_are_drawn_on_axes() -> None:
    axes = Figure().add_subplot()
    motion = motion_of(((0.0, 0.0, 0.0),), ((0.5, 0.0, 0.0),))
    draw_scene(axes, scene_of(("ball", ball(0.3))), motion, [0, 1], Look("front", (120, 80)))
    assert axes.get_xlim() == (0.0, 90.0) and len(axes.patches) > 2
