"""Constraints in files: every type read, written and read again; faults with their line."""

from __future__ import annotations

import pytest

from symbody.errors import SymbodyError
from symbody.formats import model_from_toml, model_to_toml
from symbody.formats.native import from_data, to_data
from symbody.model.constraints import Angle, Gear, Rolling
from symbody.model.registry import element_types

HEAD = """
name = "constrained"
[parameters]
L = 2
[[body]]
name = "A"
mass = 1
inertia = [1, 1, 1]
[[body]]
name = "B"
mass = 1
inertia = [1, 1, 1]
[[body]]
name = "C"
mass = 1
[[joint]]
name = "j1"
type = "gimbal"
between = ["ground", "A"]
coordinates = ["a1", "a2", "a3"]
[[joint]]
name = "j2"
type = "free"
between = ["ground", "B"]
angles = "xyz"
[[joint]]
name = "j3"
type = "prismatic"
between = ["ground", "C"]
coordinate = "s"
"""
# Type and own words, once with all of them and once with none that has a default.
WORDS = {
    "distance": ["value = 'L + sin(t)'\nrope = true", "value = 1"],
    "point_on_line": ["axis = [1, 'L', 0]", "axis = 'y'", ""],
    "point_on_plane": ["axis = [1, 'L', 0]", "axis = 'y'", ""],
    "point_on_curve": ["curve = ['p', 'p^2/L', 't']\nparameter = 'p'"],
    "point_on_surface": ["equations = 'x^2 - L*y'", "equations = ['x - t', 'y*z']"],
    "parallel": ["axes = ['x', [0, 1, 'L']]", ""],
    "perpendicular": ["axes = ['x', [0, 1, 1]]"],
    "angle": ["axes = ['x', 'z']\nvalue = '30 deg'", "axes = ['x', 'z']\nvalue = 'L/3 + t'"],
    "knife_edge": ["axis = [0, 1, 'L']", ""],
    "rolling": ["radius = 'L'\nnormal = 'y'\naxis = [0, 0, 1]", "radius = 1"],
    "gear": ["coupled = ['a1', 'a2']\nratio = '-L'\noffset = '10 deg'", "coupled = ['a1', 'a3']\nratio = 2"],
    "rack_pinion": ["coupled = ['s', 'a2']\nradius = '-L'\noffset = 't'", "coupled = ['s', 'a1']\nradius = 1"],
    "belt": ["coupled = ['a1', 'a2']\nradii = ['L', 1]\ncrossed = true\noffset = 1",
             "coupled = ['a1', 'a2']\nradii = [1, 2]"],
    "differential": ["coupled = ['a1', 'a2', 'a3']\noffset = '20 deg'", "coupled = ['a1', 'a2', 'a3']"],
    "stop": ["gap = 'L - s'\nrestitution = 0.5", "gap = 's - sin(t)'"],
    "equation": ["equations = 'a1 - a2*L'", "equations = ['a1_dot - a2_dot*s', 'a3']"],
}  # fmt: skip
WITHOUT_FRAMES = ("gear", "rack_pinion", "belt", "differential", "equation", "stop")


def text(word: str, own: str) -> str:
    between = "" if word in WITHOUT_FRAMES else "between = ['A', 'B']\n"
    return f"{HEAD}[[constraint]]\nname = 'c'\ntype = '{word}'\n{between}{own}\n"


def test_every_type_is_here() -> None:
    assert set(WORDS) == set(element_types("constraint"))


@pytest.mark.parametrize("word", element_types("constraint"))
def test_what_is_written_is_read_again(word: str) -> None:
    for own in WORDS[word]:
        model = model_from_toml(text(word, own))
        (condition,) = model.constraints
        assert type(condition) is element_types("constraint")[word]
        written = model_to_toml(model)
        assert model_from_toml(written) == model
        assert from_data(to_data(model)) == model
        # Onto the file it came from nothing changes.
        assert model_to_toml(model, onto=text(word, own)) == text(word, own)


def test_values_arrive_in_the_model() -> None:
    rolling = model_from_toml(text("rolling", WORDS["rolling"][0])).constraints[0]
    assert rolling == Rolling("c", "A", "B", "L", "y", (0, 0, 1))
    angle = model_from_toml(text("angle", WORDS["angle"][0])).constraints[0]
    assert angle == Angle("c", "A", "B", ["x", "z"], "30 deg")
    gear = model_from_toml(text("gear", WORDS["gear"][0])).constraints[0]
    assert gear == Gear("c", ["a1", "a2"], "-L", "10 deg")


FAULTS = [
    ("distance", "value = 0", "model.no_length", "value = 0"),
    ("distance", "value = 1\nrop = true", "file.unknown_key", "rop = true"),
    ("distance", "", "file.missing_key", "[[constraint]]"),
    ("distance", "value = 1\nrope = 'yes'", "file.wrong_type", "rope = 'yes'"),
    ("point_on_line", "axis = [0, 0, 0]", "model.zero_axis", "axis = [0"),
    ("point_on_line", "axis = [1, 2]", "file.wrong_type", "axis = [1"),
    ("point_on_curve", "curve = ['p', 'a1', 0]\nparameter = 'p'", "names.not_here", "curve = "),
    ("point_on_surface", "equations = ['x', 'w']", "names.unknown", "equations = "),
    ("parallel", "axes = ['x']", "file.wrong_length", "axes = "),
    ("gear", "coupled = ['a1', 'a4']\nratio = 1", "names.unknown", "coupled = "),
    ("gear", "coupled = ['a1', 's']\nratio = 1", "model.not_an_angle", "coupled = "),
    ("belt", "coupled = ['a1', 'a2']\nradii = [1, -2]", "model.no_length", "radii = "),
    ("rolling", "radius = 1\naxle = 'x'", "file.unknown_key", "axle = "),
    ("equation", "equations = []", "model.empty", "equations = "),
    ("rope", "value = 1", "file.unknown_type", "[[constraint]]"),
]


@pytest.mark.parametrize(
    ("word", "own", "code", "line"), FAULTS, ids=[f"{k}-{case[2]}" for k, case in enumerate(FAULTS)]
)
def test_faults_are_told_with_their_line(word: str, own: str, code: str, line: str) -> None:
    source = text(word, own)
    with pytest.raises(SymbodyError) as caught:
        model_from_toml(source)
    numbers = [k for k, found in enumerate(source.split("\n"), 1) if line in found]
    found = [(problem.code, problem.where) for problem in caught.value.problems]
    assert all(problem.fix for problem in caught.value.problems)
    assert "joint" not in str(caught.value) or code.startswith(("names", "model"))
    assert any(told == code and f":{number}" in where for told, where in found for number in numbers), found
