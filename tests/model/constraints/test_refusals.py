"""What constraints refuse, each with element, place and cure; the constructor's own faults all at once."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import symbody as sb
from symbody.errors import ModelError
from symbody.model.constraint import ConstraintElement
from symbody.model.numbers import formula_value
from tests.faults.refusals import refused, refused_model

A = sb.Body("A", mass=1, inertia=(1, 1, 1), frames={"P": sb.Frame(at=(1, 0, 0))})
B = sb.Body("B", mass=1, inertia=(1, 1, 1))
JOINTS = (
    sb.Revolute("j1", "ground", "A", coordinate="a1"),
    sb.Revolute("j2", "ground", "B", coordinate="a2"),
)
ENDS = ("A.P", "B")
SLIDE = sb.Prismatic("j3", "ground", "C", coordinate="s", axis="x")
NEITHER = "model.not_a_flag"

CONSTRUCTORS: list[tuple[Callable[[], ConstraintElement], str, str]] = [
    (lambda: sb.Distance(3, *ENDS, 1), "names.not_text", "name"),
    (lambda: sb.Distance("c", 3, "B", 1), "model.not_a_place", "between[0]"),
    (lambda: sb.Distance("c", *ENDS, "1+"), "expression.missing_operand", "value"),
    (lambda: sb.Distance("c", *ENDS, "30 deg"), "model.not_an_angle", "value"),
    (lambda: sb.Distance("c", *ENDS, None), "expression.type", "value"),
    (lambda: sb.Distance("c", *ENDS, 1, rope=1), NEITHER, "rope"),
    (lambda: sb.PointOnLine("c", *ENDS, axis="w"), "model.axis_letter", "axis"),
    (lambda: sb.PointOnLine("c", *ENDS, axis=(1, 2)), "model.not_three", "axis"),
    (lambda: sb.PointOnPlane("c", *ENDS, axis=None), "model.not_three", "axis"),
    (lambda: sb.KnifeEdge("c", *ENDS, axis=None), "model.not_three", "axis"),
    (lambda: sb.PointOnCurve("c", *ENDS, ["s", 0], "s"), "model.not_three", "curve"),
    (lambda: sb.PointOnCurve("c", *ENDS, ["s", 0, 0], "t"), "names.reserved", "parameter"),
    (lambda: sb.PointOnSurface("c", *ENDS, []), "model.empty", "equations"),
    (lambda: sb.PointOnSurface("c", *ENDS, ["x", "y^"]), "expression.missing_operand", "equations[1]"),
    (lambda: sb.Parallel("c", *ENDS, axes=["z"]), "model.wrong_number", "axes"),
    (lambda: sb.Parallel("c", *ENDS, axes="zz"), "model.not_a_list", "axes"),
    (lambda: sb.Perpendicular("c", *ENDS, axes=["z", "q"]), "model.axis_letter", "axes[1]"),
    (lambda: sb.Angle("c", *ENDS, ["z", "z"], "40 grad"), "expression.implicit_multiplication", "value"),
    (lambda: sb.Rolling("c", *ENDS, 1, normal=None), "model.not_three", "normal"),
    (lambda: sb.Gear("c", ["a"], 2), "model.wrong_number", "coupled"),
    (lambda: sb.Gear("c", "ab", 2), "model.not_a_list", "coupled"),
    (lambda: sb.Gear("c", ["a", "3"], 2), "names.digits", "coupled[1]"),
    (lambda: sb.Gear("c", ["a", "a"], 2), "model.coupled_twice", "coupled"),
    (lambda: sb.Gear("c", ["a", ""], 2), "model.not_coupled", "coupled[1]"),
    (lambda: sb.RackPinion("c", ["a", "b"], 2, "1 deg"), "model.not_an_angle", "offset"),
    (lambda: sb.Belt("c", ["a", "b"], [2]), "model.wrong_number", "radii"),
    (lambda: sb.Belt("c", ["a", "b"], [2, 1], crossed="no"), NEITHER, "crossed"),
    (lambda: sb.Differential("c", ["a", "b"]), "model.wrong_number", "coupled"),
    (lambda: sb.Constraint("c", []), "model.empty", "equations"),
    (lambda: sb.Constraint("c", {"x": 1}), "expression.type", "equations"),
]


@pytest.mark.parametrize(
    ("make", "code", "place"), CONSTRUCTORS, ids=[f"{k}-{case[1]}" for k, case in enumerate(CONSTRUCTORS)]
)
def test_constructors_refuse_with_place_and_cure(
    make: Callable[[], ConstraintElement], code: str, place: str
) -> None:
    with pytest.raises(ModelError) as caught:
        make()
    problem = caught.value.problems[-1]
    where = problem.where.split(", ")
    assert (problem.code, where[1]) == (code, place) and where[0].startswith("constraint ") and problem.fix


def test_all_faults_of_a_constructor_are_told_at_once() -> None:
    found = refused(lambda: sb.Rolling("c", 3, "B", "1+", normal=(1,), axis="q"), ModelError)
    assert [where.split(", ")[1] for _, where in found] == ["between[0]", "radius", "normal", "axis"]


IN_MODELS: list[tuple[ConstraintElement, str, str, str]] = [
    (sb.Distance("c", "A.Q", "B", 1), "model.unknown_place", "between[0]", "'Q'"),
    (sb.Distance("c", "A.P", "A", 1), "model.self_constraint", "between", "both frames are on A"),
    (sb.Distance("c", "ground", "ground", 1), "model.self_constraint", "between", "ground"),
    (sb.Distance("c", *ENDS, "1 - L"), "model.no_length", "value", "1 - L is -1 m"),
    (sb.Distance("c", *ENDS, 0), "model.no_length", "value", "0 m"),
    (sb.Rolling("c", *ENDS, 0), "model.no_length", "radius", "0 m"),
    (sb.Rolling("c", *ENDS, 1, (0, 0, 0)), "model.zero_axis", "normal", "length zero"),
    (sb.PointOnLine("c", *ENDS, ("L - 2", 0, 0)), "model.zero_axis", "axis", "length zero"),
    (sb.Parallel("c", *ENDS, ["z", (0, 0, 0)]), "model.zero_axis", "axes[1]", "length zero"),
    (sb.Angle("c", *ENDS, ["z", "z"], 0), "model.flat_angle", "value", "parallel"),
    (sb.Angle("c", *ENDS, ["z", "z"], "180 deg"), "model.flat_angle", "value", "parallel"),
    (sb.Gear("c", ["a1", "a2"], "L - 2"), "model.no_ratio", "ratio", "L - 2 is 0"),
    (sb.RackPinion("c", ["s", "a2"], 0), "model.no_ratio", "radius", "0 is 0"),
    (sb.RackPinion("c", ["a1", "s"], 1), "model.not_a_displacement", "coupled[0]", "a1 is not a displacement"),
    (sb.RackPinion("c", ["a1", "s"], 1), "model.not_an_angle", "coupled[1]", "s is not an angle"),
    (sb.Gear("c", ["a1", "s"], 1), "model.not_an_angle", "coupled[1]", "s is not an angle"),
    (sb.Belt("c", ["a1", "a2"], [0, 1]), "model.no_length", "radii[0]", "0 m"),
    (sb.Gear("c", ["a1", "a_2"], 2), "names.unknown", "coupled[1]", "did you mean 'a2'"),
    (sb.Gear("c", ["a1", "a2_dot"], 2), "names.not_here", "coupled[1]", "is a rate"),
    (sb.Gear("c", ["a1", "L"], 2), "names.not_here", "coupled[1]", "is a parameter"),
    (sb.Gear("c", ["a1", "a2"], "M"), "names.unknown", "ratio", "'M'"),
    (sb.Gear("c", ["a1", "a2"], "t"), "names.not_here", "ratio", "time"),
    (sb.Gear("c", ["a1", "a2"], 2, "a1"), "names.not_here", "offset", "a coordinate"),
    (sb.Constraint("c", ["a1", "a1 - a_2"]), "names.unknown", "equations[1]", "did you mean 'a2'"),
    (sb.Constraint("c", "a1_ddot"), "names.not_here", "equations[0]", "an acceleration"),
    (sb.Constraint("c", "a1 - F"), "names.not_here", "equations[0]", "an input"),
    (sb.PointOnSurface("c", *ENDS, "x - a1"), "names.not_here", "equations[0]", "x, y, z of the point"),
    (sb.PointOnSurface("c", *ENDS, "x - yy"), "names.unknown", "equations[0]", "did you mean 'y'"),
    (sb.PointOnCurve("c", *ENDS, ["s2", "a1", 0], "s2"), "names.not_here", "curve[1]", "a coordinate"),
    (sb.PointOnCurve("c", *ENDS, ["s2", "s_2", 0], "s2"), "names.unknown", "curve[1]", "did you mean 's2'"),
    (sb.PointOnCurve("c", *ENDS, [1, "L", 0], "s2"), "model.no_curve", "curve", "s2 does not appear"),
    (sb.PointOnCurve("c", *ENDS, ["a1", 0, 0], "a1"), "names.duplicate", "parameter", "rename"),
    (sb.Distance("A", *ENDS, 1), "names.duplicate", "name", "2 elements are named 'A'"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("condition", "code", "place", "words"),
    IN_MODELS,
    ids=[f"{k}-{case[1]}" for k, case in enumerate(IN_MODELS)],
)
def test_models_refuse_with_place_and_cure(
    condition: ConstraintElement, code: str, place: str, words: str
) -> None:
    found = refused_model(
        A, B, sb.Body("C", mass=1), *JOINTS, SLIDE, condition,
        parameters={"L": 2}, inputs=["F"], words=words,
    )  # fmt: skip
    wheres = [where for told, where in found if told == code]
    assert any(f"constraint {condition.name}, {place}" in where for where in wheres), found


def test_what_is_unusual_is_remarked() -> None:
    conditions = [
        sb.PointOnLine("c", *ENDS, axis=(1, 2, 2)),
        sb.Angle("d", *ENDS, ["z", "z"], 90),
    ]
    notes = sb.Model("m", [A, B, *JOINTS, *conditions]).notes
    assert any("constraint c, axis: the axis of length 3 is normalized" in note for note in notes)
    assert any("constraint d, value: 90 rad is more than a turn" in note for note in notes)


def test_formulas_and_numbers_become_the_same_everywhere() -> None:
    gear = sb.Gear("c", ["a1", "a2"], 2, offset="30 deg")
    assert str(gear.offset) == "30 deg" and formula_value(gear.offset, {}) == pytest.approx(
        0.5235987755982988
    )  # pi/6
    other = sb.Gear("c", ("a1", "a2"), "2", offset="30 deg")
    assert gear == other and hash(gear) == hash(other)
    assert sb.Constraint("c", "a1 - 1") == sb.Constraint("c", ["a1 - 1"])
    assert sb.Constraint("c", 0).equations == sb.Constraint("c", ["0"]).equations
