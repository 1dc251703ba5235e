"""The library of joints and constraints: how many equations each is, in space and in a plane, and where it stands."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import symbody as sb
from symbody.model.constraint import ConstraintElement
from symbody.model.joint import Joint
from symbody.model.registry import type_word
from tests.joint_library import joint_types, straight_joints

DOCS = Path(__file__).parents[2] / "docs"
ENDS = ("ground.P", "B.Q")
GROUND = {"P": sb.Frame(at=(0.5, 0, 0), rotate=[("z", "0.3")])}
BODY = sb.Body("B", mass=1, inertia=(0.2, 0.3, 0.4), frames={"Q": sb.Frame(at=(0.3, 0.2, 0))})
# Freedoms n of each joint, and rows of one that is cut: in space, and in the plane where it can be there.
JOINTS: list[tuple[Joint, int, int, int | None]] = [
    (sb.Weld("j", *ENDS), 0, 6, 3),
    (sb.Revolute("j", *ENDS), 1, 5, 2),
    (sb.Prismatic("j", *ENDS, axis="x"), 1, 5, 2),
    (sb.Screw("j", *ENDS, 0.3), 1, 6, None),  # and its angle joins the coordinates
    (sb.Cylindrical("j", *ENDS), 2, 4, None),
    (sb.Universal("j", *ENDS), 2, 4, None),
    (sb.ConstantVelocity("j", *ENDS), 2, 4, None),
    (sb.PinSlot("j", *ENDS), 2, 4, 1),
    (sb.Planar("j", *ENDS), 3, 3, 0),
    (sb.Spherical("j", *ENDS, "313"), 3, 3, None),
    (sb.Spherical("j", *ENDS), 3, 3, None),
    (sb.Gimbal("j", *ENDS), 3, 3, None),
    (sb.Cartesian("j", *ENDS), 3, 3, None),
    (sb.Rectangular("j", *ENDS), 2, 4, 1),
    (sb.Bearing("j", *ENDS), 4, 2, None),
    (sb.Telescoping("j", *ENDS), 4, 2, None),
    (sb.Free("j", *ENDS), 6, 0, 0),
]
# Joints that are not listed lock in space what they do not leave free.
JOINTS += [
    (joint, len(joint.coordinates), 6 - len(joint.coordinates), None)
    for joint in straight_joints(*ENDS).values()
    if type(joint) not in [type(case[0]) for case in JOINTS]
]
# Freedoms that each takes from a body in space, and in the plane.
CONDITIONS: list[tuple[ConstraintElement, int, int | None]] = [
    (sb.Distance("c", *ENDS, 1), 1, 1),
    (sb.PointOnLine("c", *ENDS), 2, 1),
    (sb.PointOnPlane("c", *ENDS), 1, 0),
    (sb.PointOnPlane("c", *ENDS, axis="x"), 1, 1),
    (sb.PointOnCurve("c", *ENDS, ["s", "s^2", "0"], "s"), 2, 1),
    (sb.PointOnSurface("c", *ENDS, "x^2 + 2*y^2 + 3*z^2 - 1"), 1, 1),
    (sb.Parallel("c", *ENDS), 2, 0),
    (sb.Parallel("c", *ENDS, axes=["x", "x"]), 2, 1),
    (sb.Perpendicular("c", *ENDS, axes=["x", "y"]), 1, 1),
    (sb.Angle("c", *ENDS, ["x", "x"], 1), 1, 1),
    (sb.KnifeEdge("c", *ENDS), 1, 1),
    (sb.Rolling("c", *ENDS, 0.4), 3, None),
    (sb.Rolling("c", *ENDS, 0.4, axis="x"), 3, None),
    (sb.Constraint("c", ["x - 1", "x_dot + y*y_dot"]), 2, 2),
]
SPACE = sb.Free("f", "ground", "B", angles="xyz", coordinates=["x", "y", "z", "a", "b", "c"])
PLANE = sb.Planar("f", "ground", "B", coordinates=["x", "y", "a"])


def equations(float_: Joint, element: Joint | ConstraintElement) -> sb.EquationSet:
    """A body with coordinates of a joint, to which another joint or a constraint is added."""
    model = sb.Model("m", [BODY, float_, element], ground=GROUND, initial={"x": 0.4, "y": 0.3, "a": 0.2})
    return sb.form_equations(model, tree=sb.Trees(["f"], ["f"]))


def names(
    cases: list[tuple[Joint, int, int, int | None]] | list[tuple[ConstraintElement, int, int | None]],
) -> list[str]:
    return [f"{type(case[0]).__name__}-{k}" for k, case in enumerate(cases)]


FLAT = [case for case in JOINTS if case[3] is not None]


@pytest.mark.parametrize("case", JOINTS, ids=names(JOINTS))
def test_rows_of_a_cut_joint_in_space(case: tuple[Joint, int, int, int | None]) -> None:
    joint, n, rows, _ = case
    assert joint.locked_directions == 6 - n
    eqs = equations(SPACE, joint)
    assert len(eqs.multiplier_names) == rows and eqs.degrees_of_freedom == n


@pytest.mark.parametrize("case", FLAT, ids=names(FLAT))
def test_rows_of_a_cut_joint_in_the_plane(case: tuple[Joint, int, int, int]) -> None:
    joint, _, rows, flat = case
    eqs = equations(PLANE, joint)
    assert len(eqs.multiplier_names) == flat and eqs.degrees_of_freedom == 3 - flat
    told = " ".join(note for note in eqs.notes if "hold identically" in note)
    assert all(f"lambda_j_{k}" in (*eqs.multiplier_names, *re.findall(r"lambda_j_\d", told))
               for k in range(1, rows + 1))  # fmt: skip


@pytest.mark.parametrize("case", CONDITIONS, ids=names(CONDITIONS))
def test_what_a_constraint_takes(case: tuple[ConstraintElement, int, int | None]) -> None:
    condition, space, plane = case
    assert equations(SPACE, condition).degrees_of_freedom == 6 - space
    if plane is not None:
        assert equations(PLANE, condition).degrees_of_freedom == 3 - plane


@pytest.mark.parametrize(
    "coupling",
    [
        sb.Gear("c", ["a1", "a2"], 2),
        sb.RackPinion("c", ["s", "a1"], 0.2),
        sb.Belt("c", ["a1", "a2"], [1, 2]),
        sb.Differential("c", ["a1", "a2", "a3"]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_coupling_takes_one_freedom(coupling: ConstraintElement) -> None:
    wheels = [sb.Body(f"W{k}", mass=1, inertia=(0, 0, 1)) for k in (1, 2, 3)]
    hinges = [sb.Revolute(f"r{k}", "ground", f"W{k}", coordinate=f"a{k}") for k in (1, 2, 3)]
    rack = [sb.Body("Rack", mass=1), sb.Prismatic("p", "ground", "Rack", coordinate="s")]
    eqs = sb.form_equations(sb.Model("m", [*wheels, *hinges, *rack, coupling]))
    assert eqs.multiplier_names == ("lambda_c_1",) and eqs.degrees_of_freedom == 3


def listed(page: str) -> dict[str, str]:
    """The rows of the first table of a page by their first cell."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return dict(re.findall(r"(?m)^\| `(\w+)` \| (.*)$", text))


def test_every_joint_has_a_line() -> None:
    rows = listed("joints.md")
    assert set(rows) == set(joint_types()), "run: python docs/list_elements.py"
    for joint, n, *_ in JOINTS:
        assert f" | {n} | {6 - n} | " in f" {rows[type_word(type(joint))]}"


def test_every_picture_of_a_joint_is_there() -> None:
    words = re.findall(r"\(pictures/(\w+)\.svg\)", (DOCS / "joints.md").read_text(encoding="utf-8"))
    assert words and set(words) <= set(joint_types())
    assert all((DOCS / "pictures" / f"{word}.svg").is_file() for word in words)


def test_every_constraint_has_a_line_and_a_picture() -> None:
    kinds = {"gear", "rack_pinion", "belt", "differential"}
    for condition, *_ in CONDITIONS:
        kind = re.sub(r"(?<!^)(?=[A-Z])", "_", type(condition).__name__).lower()
        kinds.add("equation" if kind == "constraint" else kind)
    kinds.add("stop")  # whose row comes and goes
    rows, text = listed("constraints.md"), (DOCS / "constraints.md").read_text(encoding="utf-8")
    assert set(rows) == kinds
    for kind in kinds:
        picture = f"constraint_{kind}.svg"
        assert f"(pictures/{picture})" in text and (DOCS / "pictures" / picture).is_file()
