"""Shapes of bodies: what they keep, what they refuse, and that the motion does not see them."""

from __future__ import annotations

from collections.abc import Callable

import matplotlib.colors
import pytest

import symbody as sb
from symbody.errors import ModelError
from symbody.model.shapes.shape import CSS_COLORS, hex_color


def codes(make: Callable[[], object]) -> list[str]:
    with pytest.raises(ModelError) as caught:
        make()
    return [problem.code for problem in caught.value.problems]


def model(*shapes: object, **more: object) -> sb.Model:
    body = sb.Body("Arm", 1, (1, 1, 1), shapes=shapes)
    return sb.Model("m", [sb.Revolute("j", "ground", body)], parameters={"L": 2}, **more)


def test_shapes_keep_formulas_and_colours() -> None:
    box = sb.Box(("L", 0.1, "L/2"), at=("L", 0, 0), rotate=[("z", "30 deg")], color="Orange", opacity=0.5)
    body = model(box).body("Arm")
    assert body.shapes == (box,)
    assert [formula.text for _, formula in box.lengths] == ["L", "0.1", "L/2"]
    assert (box.color, box.opacity.text, box.frame.at[0].text) == ("orange", "0.5", "L")


def test_one_shape_needs_no_list() -> None:
    assert sb.Body("Arm", shapes=sb.Sphere(1)).shapes == (sb.Sphere(1),)


def test_colours_are_those_of_css() -> None:
    assert dict(CSS_COLORS) == {
        name: hexadecimal.lower() for name, hexadecimal in matplotlib.colors.CSS4_COLORS.items()
    }
    assert hex_color("") == "" and hex_color("#aabbcc") == "#aabbcc"


REFUSED: dict[str, tuple[Callable[[], object], str]] = {
    "two edges": (lambda: sb.Box((1, 2)), "model.not_three"),
    "no such colour": (lambda: sb.Sphere(1, color="orang"), "model.bad_color"),
    "five digits": (lambda: sb.Sphere(1, color="#12345"), "model.bad_color"),
    "two rotations": (
        lambda: sb.Sphere(1, rotate=[("z", 1)], matrix=[[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        "model.two_rotations",
    ),
    "no path": (lambda: sb.Mesh(" "), "model.mesh_path"),
    "a number": (lambda: sb.Body("Arm", shapes=[3]), "model.not_a_shape"),
    "negative radius": (lambda: model(sb.Cylinder(-1, 2)), "model.negative_size"),
    "negative formula": (lambda: model(sb.Cone(1, "L - 3")), "model.negative_size"),
    "opacity": (lambda: model(sb.Capsule(1, 1, opacity=1.5)), "model.opacity"),
    "unknown symbol": (lambda: model(sb.Sphere("K")), "names.unknown"),
    "unknown on ground": (lambda: model(ground_shapes=[sb.Sphere("K")]), "names.unknown"),
    "no axis": (lambda: model(sb.Sphere(1, rotate=[((0, 0, 0), 1)])), "model.zero_axis"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_drawn_is_refused(case: str) -> None:
    make, code = REFUSED[case]
    assert code in codes(make)


def test_a_bad_colour_is_refused_with_one_like_it() -> None:
    with pytest.raises(ModelError, match=r"sphere, color: 'orang' is not a colour\n.*'orange'"):
        sb.Sphere(1, color="orang")


def test_the_motion_does_not_see_shapes() -> None:
    with_shapes = sb.form_equations(model(sb.Sphere("L"), ground_shapes=[sb.Box((1, 1, 1))]))
    plain = sb.form_equations(model())
    assert str(with_shapes.mass_matrix) == str(plain.mass_matrix)
    assert with_shapes.model.body("Arm").shapes


def test_paths_of_meshes_lead_from_folders() -> None:
    mesh = sb.Mesh("parts/arm.stl", folder="/robots")
    assert mesh.place == "/robots/parts/arm.stl"
    assert mesh.path_from("/robots") == "parts/arm.stl"
    assert mesh.path_from("/robots/tables") == "../parts/arm.stl"
    assert sb.Mesh("package://a/b.stl", folder="/robots").path_from("/other") == "package://a/b.stl"
    assert mesh == sb.Mesh("parts/arm.stl")
