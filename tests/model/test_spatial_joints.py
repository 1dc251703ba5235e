"""Planar, spherical and free joints: their laws, their speeds, what they refuse."""

from __future__ import annotations

import itertools
import math
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import pytest

from symbody.errors import ModelError
from symbody.model import Body, Drive, Force, Free, Model, Planar, Prismatic, Revolute, Spherical, Torque
from symbody.model.declarations.formula_site import Triple
from symbody.model.joint import Joint, QuasiSpeeds
from symbody.model.numbers import as_float, formula_value
from symbody.model.simple_rotation import LETTERS

Matrix = list[list[float]]

JOINTS: list[Joint] = [
    Planar("p", "ground", "A"),
    Planar("p", "ground", "A", "x", ["X", "Y", "q"], True, {"X": Drive(1)}, {"q": Drive(2)}, {"Y": "2*t"}),
    Spherical("s", "ground", "A"),
    Spherical("s", "ground", "A", "space 123", ["a", "b", "c"], "start", ["p", "q", "r"], False),
    Spherical("s", "ground", "A", "313", torque={"s_2": Drive(damping=1)}, motion={"s_1": "30 deg"}),
    Free("f", "ground", "A"),
    Free("f", "ground", "A", "zyx", None, "twist", None, None, {"f_x": Drive(1)}, {"f_3": Drive(2)}),
    Free("f", "ground", "A", "zyx", motion={"f_x": "t", "f_1": "t"}, as_constraint=True, speeds="start"),
]


def values(components: Sequence[object], known: Mapping[str, float]) -> list[float]:
    found = [formula_value(component, known) for component in components]
    return [as_float(value) for value in found if value is not None]


def simple(axis: Triple, angle: float) -> Matrix:
    """Rotation about x, y or z."""
    k = values(axis, {}).index(1.0)
    i, j = (k + 1) % 3, (k + 2) % 3
    r = [[float(row == column) for column in range(3)] for row in range(3)]
    r[i][i] = r[j][j] = math.cos(angle)
    r[j][i], r[i][j] = math.sin(angle), -math.sin(angle)
    return r


def product(a: Matrix, b: Matrix) -> Matrix:
    return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def rotation(joint: Joint, known: Mapping[str, float]) -> Matrix:
    """Rotation matrix from end to start."""
    r = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for turn in joint.turns():
        r = product(r, simple(turn.axis, values([turn.angle], known)[0]))
    return r


def codes(make: Callable[[], object]) -> list[tuple[str, str]]:
    with pytest.raises(ModelError) as caught:
        make()
    assert all(problem.fix for problem in caught.value.problems)
    return [(problem.code, problem.where) for problem in caught.value.problems]


# --- laws -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "shift", "normal"),
    [("x", [0, 2, 3], [1, 0, 0]), ("y", [3, 0, 2], [0, 1, 0]), ("z", [2, 3, 0], [0, 0, 1])],
)
def test_planar_law(axis: str, shift: list[float], normal: list[float]) -> None:
    joint = Planar("p", "ground", "A", axis, coordinates=["a", "b", "q"])
    assert values(joint.shift(), {"a": 2, "b": 3}) == shift
    (turn,) = joint.turns()
    assert values(turn.axis, {}) == normal and turn.angle.text == "q"
    assert (joint.rotation_coordinates, joint.translation_coordinates) == (("q",), ("a", "b"))
    assert (joint.locked_rotations, joint.locked_translations) == (2, 1)


def test_planar_names_without_names() -> None:
    joint = Planar("disc 1", "ground", "A")
    assert joint.coordinates == ("disc_1_1", "disc_1_2", "disc_1_3")
    assert not joint.has_named_coordinates and joint.given_names == (None, None, None)


SEQUENCES = ["".join(s) for s in itertools.product("123", repeat=3) if s[0] != s[1] != s[2]]


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_space_sequence_is_fixed_axes(sequence: str) -> None:
    angles = dict(zip("abc", (0.3, -1.1, 2.0), strict=True))
    body = Spherical("s", "ground", "A", sequence, coordinates="a b c".split())
    space = Spherical("s", "ground", "A", f"space {sequence}", coordinates="a b c".split())
    reverse = Spherical("s", "ground", "A", sequence[::-1], coordinates="c b a".split())
    assert len(SEQUENCES) == 12
    assert [turn.angle.text for turn in body.turns()] == ["a", "b", "c"]
    assert [values(turn.axis, {}).index(1.0) + 1 for turn in body.turns()] == [int(d) for d in sequence]
    assert space.coordinates == ("a", "b", "c") and space.turns() == reverse.turns()
    # About axes fixed in start a later turn multiplies from the left.
    letters = [LETTERS["xyz"[int(digit) - 1]] for digit in sequence]
    first, second, third = (simple(*pair) for pair in zip(letters, angles.values(), strict=True))
    # Two products of matrices with entries up to 1: each entry has at most 6 roundings of 1.2e-16.
    for row, wanted in zip(rotation(space, angles), product(third, product(second, first)), strict=True):
        assert row == pytest.approx(wanted, abs=1e-15)


def test_313_is_precession_nutation_spin() -> None:
    r = rotation(Spherical("s", "ground", "A", "313", ["z", "n", "x"]), {"z": 0.4, "n": 0.7, "x": 1.3})
    # body z in start axes: sin n sin z, -sin n cos z, cos n (Goldstein, section 4.4); errors as above
    wanted = [math.sin(0.7) * math.sin(0.4), -math.sin(0.7) * math.cos(0.4), math.cos(0.7)]
    assert [row[2] for row in r] == pytest.approx(wanted, abs=1e-15)


def test_digits_and_letters_mean_the_same() -> None:
    assert Spherical("s", "ground", "A", "zxz") == Spherical("s", "ground", "A", "313")
    assert Free("s", "ground", "A", "space x2z") == Free("s", "ground", "A", "space 123")


def test_quaternion() -> None:
    ball = Spherical("ball", "ground", "A")
    assert ball.quaternion == ball.coordinates == ("ball_qw", "ball_qx", "ball_qy", "ball_qz")
    assert ball.rotation_coordinates == ball.coordinates and ball.angle_coordinates == ()
    assert ball.turns() == () and ball.translation_coordinates == ()
    assert (ball.locked_rotations, ball.locked_translations) == (0, 3)
    free = Free("f", "ground", "A")
    assert free.coordinates == ("f_x", "f_y", "f_z", "f_qw", "f_qx", "f_qy", "f_qz")
    assert free.quaternion == free.coordinates[3:] and free.translation_coordinates == free.coordinates[:3]
    assert free.locked_directions == 0


def test_free_with_angles() -> None:
    free = Free("f", "ground", "A", "123", coordinates=["x", "y", "z", "a", "b", "c"])
    assert [component.text for component in free.shift()] == ["x", "y", "z"]
    assert [turn.angle.text for turn in free.turns()] == ["a", "b", "c"]
    assert free.quaternion is None and free.locked_directions == 0
    assert Free("f", "ground", "A", "123").coordinates == ("f_x", "f_y", "f_z", "f_1", "f_2", "f_3")


@pytest.mark.parametrize(
    ("joint", "translation", "rotation_in"),
    [
        (Spherical("s", "ground", "A"), None, "end"),
        (Spherical("s", "ground", "A", speeds="start"), None, "start"),
        (Spherical("s", "ground", "A", "313"), None, None),
        (Spherical("s", "ground", "A", "313", speeds="end"), None, "end"),
        (Free("s", "ground", "A"), "start", "end"),
        (Free("s", "ground", "A", speeds="start"), "start", "start"),
        (Free("s", "ground", "A", speeds="twist"), "end", "end"),
        (Free("s", "ground", "A", "123", speeds="rates"), None, None),
        (Planar("s", "ground", "A"), None, None),
        (Revolute("s", "ground", "A"), None, None),
    ],
)
def test_speeds(joint: Joint, translation: str | None, rotation_in: str | None) -> None:
    wanted = [
        where and QuasiSpeeds((f"s_{kind}x", f"s_{kind}y", f"s_{kind}z"), where)
        for kind, where in (("v", translation), ("w", rotation_in))
    ]
    assert [joint.translation_speeds, joint.rotation_speeds] == wanted


def test_names_of_speeds() -> None:
    names = ["a", "b", "c", "p", "q", "r"]
    free = Free("f", "ground", "A", speed_names=names)
    assert free.translation_speeds == QuasiSpeeds(("a", "b", "c"), "start")
    assert free.rotation_speeds == QuasiSpeeds(("p", "q", "r"), "end")
    assert free.quasi_speed_names == tuple(names)
    ball = Spherical("s", "ground", "A", speed_names=["p", "q", "r"])
    assert ball.quasi_speed_names == ("p", "q", "r")


# --- drives, motions, rotors ----------------------------------------------------------------------------


def test_places_by_coordinate() -> None:
    joint = JOINTS[1]
    assert dict(joint.drives) == {"X": Drive(1), "q": Drive(2)}
    assert [use.path for use in joint.formula_sites() if use.formula.constant() != 0] == [
        "force.X.applied",
        "torque.q.applied",
        "motion.Y",
    ]


def test_rotor_and_constraint() -> None:
    hinge = Revolute("r", "ground", "A", coordinate="q", motion="t", as_constraint=True, armature="J")
    assert {name: formula.text for name, formula in hinge.armature.items()} == {"q": "J"}
    assert hinge.as_constraint and not Revolute("r", "ground", "A").as_constraint
    slider = Prismatic("p", "ground", "A", armature=0)
    assert slider.armature == {} and Planar("p", "ground", "A").armature == {}
    assert codes(lambda: Model("m", [hinge, Body("A")])) == [("names.unknown", "joint r, armature, column 1")]
    negative = Model("m", [replace(hinge, coordinate="x"), Body("A")], parameters={"J": 1})
    assert negative.joint("r").armature["x"].text == "J"
    assert codes(lambda: replace(negative, parameters={"J": -1})) == [
        ("model.negative_armature", "joint r, armature")
    ]


def test_constraint_without_motion_is_remarked() -> None:
    notes = Model("m", [Revolute("r", "ground", Body("A"), as_constraint=True)]).notes
    assert any("as_constraint has no effect" in note for note in notes)


@pytest.mark.parametrize("joint", JOINTS)
def test_pickle_and_replace(joint: Joint) -> None:
    assert pickle.loads(pickle.dumps(joint)) == joint
    assert replace(joint, name=joint.name) == joint
    assert (
        replace(joint, tree={"rotation": True}) != joint and Model("m", [joint, Body("A")]).joints[0] == joint
    )


# --- what is refused ------------------------------------------------------------------------------------

REFUSED: dict[str, tuple[Callable[[], object], list[tuple[str, str]]]] = {
    "axis of three": (
        lambda: Planar("j", "ground", "A", axis=(0, 0, 1)),
        [("model.axis_letter", "joint j, axis")],
    ),
    "two names": (
        lambda: Planar("j", "ground", "A", coordinates=["x", "y"]),
        [("model.wrong_number", "joint j, coordinates")],
    ),
    "names as text": (
        lambda: Spherical("j", "ground", "A", coordinates="abc"),
        [("model.not_a_list", "joint j, coordinates"), ("model.wrong_number", "joint j, coordinates")],
    ),
    "bad name": (
        lambda: Free("j", "ground", "A", "123", coordinates=["x", "y", "pi", "a", "b", "c d"]),
        [("names.reserved", "joint j, coordinates[2]"), ("names.not_a_symbol", "joint j, coordinates[5]")],
    ),
    "drive alone": (
        lambda: Planar("j", "ground", "A", torque=Drive(1)),
        [("model.not_by_coordinate", "joint j, torque")],
    ),
    "motion alone": (
        lambda: Spherical("j", "ground", "A", "313", motion="t"),
        [("model.not_by_coordinate", "joint j, motion")],
    ),
    "no drive": (
        lambda: Planar("j", "ground", "A", torque={"j_3": 1}),
        [("model.not_a_drive", "joint j, torque.j_3")],
    ),
    "bad motion": (
        lambda: Planar("j", "ground", "A", motion={"j_1": "1+"}),
        [("expression.missing_operand", "joint j, motion.j_1, column 3")],
    ),
    "unknown coordinate": (
        lambda: Planar("j", "ground", "A", motion={"j_4": "t"}),
        [("model.unknown_coordinate", "joint j, motion.j_4")],
    ),
    "force about": (
        lambda: Planar("j", "ground", "A", force={"j_3": Drive(1)}),
        [("model.wrong_drive", "joint j, force.j_3")],
    ),
    "torque along": (
        lambda: Planar("j", "ground", "A", torque={"j_1": Drive(1)}),
        [("model.wrong_drive", "joint j, torque.j_1")],
    ),
    "torque of quaternion": (
        lambda: Spherical("j", "ground", "A", torque={"j_qx": Drive(1)}),
        [("model.quaternion_component", "joint j, torque.j_qx")],
    ),
    "motion of quaternion": (
        lambda: Free("j", "ground", "A", motion={"j_qw": "t"}),
        [("model.quaternion_component", "joint j, motion.j_qw")],
    ),
    "motion besides speeds": (
        lambda: Spherical("j", "ground", "A", "313", speeds="end", motion={"j_1": "t"}),
        [("model.motion_without_rate", "joint j, motion.j_1")],
    ),
    "motion besides twist": (
        lambda: Free("j", "ground", "A", "123", speeds="twist", motion={"j_x": "t"}),
        [("model.motion_without_rate", "joint j, motion.j_x")],
    ),
    "rates of quaternion": (
        lambda: Free("j", "ground", "A", speeds="rates"),
        [("model.quaternion_rates", "joint j, speeds")],
    ),
    "twist of a ball": (
        lambda: Spherical("j", "ground", "A", speeds="twist"),
        [("model.speeds", "joint j, speeds")],
    ),
    "number as speeds": (
        lambda: Spherical("j", "ground", "A", speeds=3),
        [("model.speeds", "joint j, speeds")],
    ),
    "three names of six": (
        lambda: Free("j", "ground", "A", speed_names=["a", "b", "c"]),
        [("model.wrong_number", "joint j, speed_names")],
    ),
    "names of rates": (
        lambda: Spherical("j", "ground", "A", "313", speed_names=["a", "b", "c"]),
        [("model.names_of_rates", "joint j, speed_names")],
    ),
    "no flag": (
        lambda: Revolute("j", "ground", "A", as_constraint=1),
        [("model.not_a_flag", "joint j, as_constraint")],
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case: str) -> None:
    make, expected = REFUSED[case]
    assert codes(make) == expected


@pytest.mark.parametrize(
    "angles", ["311", "331", "31", "3131", "abc", "", "space", "space313", 313, None, "Quaternion"]
)
def test_what_is_no_sequence(angles: object) -> None:
    assert codes(lambda: Spherical("j", "ground", "A", angles)) == [
        ("model.angle_sequence", "joint j, angles")
    ]


# --- in a model -----------------------------------------------------------------------------------------


def test_speeds_are_symbols() -> None:
    ball = Spherical("ball", "ground", "A", "313", speeds="end")
    torque = Torque("T", "A", ("-d*ball_wx", "ball_2_dot", "ball_3"), resolved_in="A")
    model = Model(
        "m", [ball, torque, Body("A")], parameters={"d": 1}, initial={"ball_wx": 1, "ball_1_dot": 2}
    )
    assert model.initial["ball_wx"].text == "1"
    assert codes(lambda: replace(model, parameters={"d": 1, "ball_wx": 1}, initial={})) == [
        ("names.duplicate", "model, parameters.ball_wx; joint ball, name")
    ]
    assert codes(lambda: replace(model, inputs=["ball_wx_dot"])) == [
        ("names.duplicate", "model, inputs[0]; joint ball, name")
    ]
    wrong = [*model.elements, Force("F", "A", ("ball_wx_dot", 0, 0))]
    assert codes(lambda: replace(model, elements=wrong)) == [
        ("names.not_here", "force F, vector[0], column 1")
    ]


def test_names_of_a_joint_twice() -> None:
    elements = [Planar("p", "ground", "A", coordinates=["x", "x", "q"]), Body("A")]
    assert codes(lambda: Model("m", elements)) == [
        ("names.duplicate", "joint p, coordinates[0]; joint p, coordinates[1]")
    ]
    named = Spherical("p", "ground", "A", speed_names=["a", "p_qw_dot", "b"])
    assert codes(lambda: Model("m", [named, Body("A")])) == [
        ("names.duplicate", "joint p, name; joint p, speed_names[1]")
    ]


def test_initial_values_of_what_is_prescribed() -> None:
    joint = Planar("p", "ground", "A", coordinates=["x", "y", "q"], motion={"q": "t"})
    initial = {"x": 1, "q": 1, "q_dot": 1}
    assert codes(lambda: Model("m", [joint, Body("A")], initial=initial)) == [
        ("initial.prescribed", "model, initial.q"),
        ("initial.prescribed", "model, initial.q_dot"),
    ]
    assert Model("m", [replace(joint, as_constraint=True), Body("A")], initial=initial).initial["q"]


def test_initial_quaternions() -> None:
    elements = [Free("f", "ground", Body("A"))]
    zero = dict.fromkeys(("f_qw", "f_qx", "f_qy", "f_qz"), 0)
    assert codes(lambda: Model("m", elements, initial=zero)) == [
        ("initial.zero_quaternion", "model, initial.f_qw")
    ]
    assert codes(lambda: Model("m", elements, initial={**zero, "f_qw": "a"}, parameters={"a": 0})) == [
        ("initial.zero_quaternion", "model, initial.f_qw")
    ]
    half = Model("m", elements, initial=dict.fromkeys(zero, 0.5))
    double = Model("m", elements, initial=dict.fromkeys(zero, 1))
    some = Model("m", elements, initial={"f_qx": 0})
    free = Model("m", elements, initial={**zero, "f_qw": "a"}, parameters={"a": None})
    remarked = [any("is normalized" in note for note in model.notes) for model in (half, double, some, free)]
    assert remarked == [False, True, False, False]


def test_degrees_belong_to_angles() -> None:
    free = Free("f", "ground", Body("A"), "123", force={"f_y": Drive(free="1 deg")}, motion={"f_z": "1 deg"})
    assert codes(lambda: Model("m", [free], initial={"f_x": "1 deg", "f_1": "1 deg"})) == [
        ("model.not_an_angle", "model, initial.f_x"),
        ("model.not_an_angle", "joint f, force.f_y"),
        ("model.not_an_angle", "joint f, motion.f_z"),
    ]
    ball = Spherical("s", "ground", Body("A"))
    assert codes(lambda: Model("m", [ball], initial={"s_qx": "1 deg", "s_wx": "1 deg"})) == [
        ("model.not_an_angle", "model, initial.s_qx"),
        ("model.not_an_angle", "model, initial.s_wx"),
    ]


def test_a_body_without_joint_has_names() -> None:
    push = Force("F", "upper arm", ("-upper_arm_vx", "upper_arm_y_dot", "upper_arm_z"))
    model = Model("m", [Body("upper arm"), push], initial={"upper_arm_z": 2, "upper_arm_wx": 1})
    (joint,) = model.free_joints
    assert (joint.start.full_name, joint.end.full_name, joint.quaternion) == (
        "ground",
        "upper arm",
        ("upper_arm_qw", "upper_arm_qx", "upper_arm_qy", "upper_arm_qz"),
    )
    assert model.joints == () and "upper_arm_x to upper_arm_qz" in model.notes[0]
    assert codes(lambda: replace(model, parameters={"upper_arm_x": 1})) == [
        ("names.duplicate", "model, parameters.upper_arm_x; body upper arm, name")
    ]
    joined = Model("m", [Body("A", frames={}), Revolute("r", "ground", "A")], parameters={"A_x": 1})
    assert joined.free_joints == ()
