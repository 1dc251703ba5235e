"""Joints: their laws, and what follows for all of them."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from symbody.errors import ModelError
from symbody.model import Body, Drive, Force, Frame, Prismatic, Revolute, SpringDamper, Torque, Weld
from symbody.model.element import Element
from symbody.model.joint import InTrees, Joint
from symbody.model.numbers import as_float, formula_value

LINK = Body("Link", frames={"tip": Frame()})
JOINTS = [
    (Weld("w", "ground", LINK), (), (), 6),
    (Revolute("r", "ground", LINK["tip"], coordinate="theta"), ("theta",), (), 5),
    (Prismatic("p", "ground", (LINK, "tip"), coordinate="s"), (), ("s",), 5),
]
ELEMENTS: list[Element] = [
    LINK,
    *(joint for joint, *_ in JOINTS),
    Force("f", LINK, (1, "F", 0)),
    Torque("m", "Link", (0, 0, "T")),
    SpringDamper("s", "ground", "Link.tip", stiffness="k", free=0.1),
]


@pytest.mark.parametrize(("joint", "rotations", "translations", "locked"), JOINTS)
def test_freedoms(
    joint: Joint, rotations: tuple[str, ...], translations: tuple[str, ...], locked: int
) -> None:
    assert joint.rotation_coordinates == rotations
    assert joint.translation_coordinates == translations
    assert joint.locked_directions == locked == 6 - len(joint.coordinates)
    assert (joint.locked_rotations, joint.locked_translations) == (3 - len(rotations), 3 - len(translations))
    assert joint.has_named_coordinates


def test_revolute_law() -> None:
    (turn,) = Revolute("r", "ground", "Link", axis=(0, 0, -2), coordinate="q").turns()
    assert [str(component.constant()) for component in turn.axis] == ["0", "0", "-1"]
    assert turn.angle.text == "q"


@pytest.mark.parametrize(
    ("axis", "shift"),
    [
        ("x", (2, 0, 0)),
        ("z", (0, 0, 2)),
        ((0, -3, 0), (0, -2, 0)),
        ((3, 0, 4), (1.2, 0, 1.6)),
        (("a", 0, 0), (2, 0, 0)),
    ],
)
def test_prismatic_law(axis: str | tuple[float, float, float], shift: tuple[float, float, float]) -> None:
    components = Prismatic("p", "ground", "Link", axis=axis, coordinate="s").shift()
    values = [formula_value(component, {"s": 2, "a": 5}) for component in components]
    # rounding of 3/5*2 to the nearest double at most
    assert [as_float(value) for value in values if value is not None] == pytest.approx(shift, rel=2.3e-16)


def test_coordinates_without_name_are_named_after_the_joint() -> None:
    joint = Revolute("upper arm", "ground", "Link")
    assert joint.coordinates == ("upper_arm",)
    assert not joint.has_named_coordinates


def test_drives_and_motions_by_coordinate() -> None:
    drive = Drive(applied="F", stiffness=3, free="30 deg")
    assert Prismatic("p", "ground", "A", coordinate="s", force=drive).drives == {"s": drive}
    joint = Revolute("r", "ground", "A", torque=drive, motion="90 deg")
    assert joint.drives == {"r": drive}
    assert joint.motions["r"].text == "90 deg"
    assert [use.path for use in joint.formula_sites()] == [
        "torque.applied",
        "torque.stiffness",
        "torque.damping",
        "torque.free",
        "torque.law",
        "motion",
    ]


@pytest.mark.parametrize(
    ("given", "stored"),
    [
        (None, InTrees(None, None)),
        (True, InTrees(True, True)),
        (False, InTrees(False, False)),
        ({"rotation": True}, InTrees(True, None)),
        ({"rotation": True, "translation": False}, InTrees(True, False)),
    ],
)
def test_choice_of_trees(given: object, stored: InTrees) -> None:
    assert Weld("w", "ground", "A", tree=given).tree == stored


@pytest.mark.parametrize("tree", ["yes", 1, {"rotate": True}, {"rotation": 1}])
def test_bad_choice_of_trees(tree: object) -> None:
    with pytest.raises(ModelError, match="model.bad_tree"):
        Weld("w", "ground", "A", tree=tree)


@pytest.mark.parametrize(
    ("place", "frame"),
    [
        (LINK, "Link"),
        ("Link", "Link"),
        ("Link.CoM", "Link"),
        (LINK["CoM"], "Link"),
        (LINK["tip"], "Link.tip"),
        ((LINK, "tip"), "Link.tip"),
        (("Link", "tip"), "Link.tip"),
        ("Link.tip", "Link.tip"),
        (" Link . tip ", "Link.tip"),
        ("Ground", "ground"),
        ("ground.CoM", "ground"),
        ("Ground.post", "ground.post"),
    ],
)
def test_ways_to_name_a_place(place: object, frame: str) -> None:
    assert Weld("w", place, "X").start.full_name == frame


@pytest.mark.parametrize(
    "place", [Frame(), None, 3, "", "a..b", "a.", ".b", "a.b.c", ("a",), ("a", 3), (3, "a")]
)
def test_what_is_no_place(place: object) -> None:
    with pytest.raises(ModelError) as caught:
        Weld("w", place, "X")
    (problem,) = caught.value.problems
    assert problem.code in ("model.bad_address", "model.not_a_place")
    assert problem.where == "joint w, between[0]" and problem.fix


def test_an_axis_with_a_minus_is_answered_by_its_components() -> None:
    with pytest.raises(ModelError) as caught:
        Prismatic("p", "ground", "A", axis="-Y")
    assert caught.value.problems[0].fix.endswith('["0", "-1", "0"]')


def test_every_fault_of_a_joint_is_told() -> None:
    with pytest.raises(ModelError) as caught:
        Prismatic("a.b", 3, "A..", axis="u", coordinate="pi", force="F", motion="1+", tree=2)
    assert [problem.code for problem in caught.value.problems] == [
        "names.mark",
        "model.not_a_place",
        "model.bad_address",
        "model.axis_letter",
        "names.reserved",
        "model.bad_tree",
        "model.not_a_drive",
        "expression.missing_operand",
    ]
    assert all(problem.where.startswith("joint a.b, ") for problem in caught.value.problems)


@pytest.mark.parametrize("element", ELEMENTS, ids=lambda element: element.kind + element.name)
def test_elements_pickle_and_replace(element: Element) -> None:
    assert pickle.loads(pickle.dumps(element)) == element
    assert replace(element, name="other").name == "other"
