"""The model: what it takes over, what it refuses, what it remarks."""

from __future__ import annotations

import pickle
import subprocess
import sys
from dataclasses import FrozenInstanceError, replace

import pytest

from symbody.errors import ModelError
from symbody.model import Body, Drive, Force, Frame, Model, Prismatic, Revolute, SpringDamper, Torque, Weld
from symbody.model.element import Element

PARAMETERS = {"m": 1, "k": "4*m", "L": 0.5}


def faults(*elements: Element, **rest: object) -> list[tuple[str, str]]:
    with pytest.raises(ModelError) as caught:
        Model("bad", elements, **rest)
    assert all(problem.fix for problem in caught.value.problems)
    return [(problem.code, problem.where) for problem in caught.value.problems]


def arm() -> Model:
    link = Body("Link", mass="m", inertia=(0, 0, "m*L**2/12"), frames={"base": Frame(at=("-L/2", 0, 0))})
    pin = Revolute("pin", "ground.post", link["base"], coordinate="theta", torque=Drive("T", damping=0.1))
    return Model(
        "arm",
        [
            pin,
            Force("push", link, ("F", 0, 0), resolved_in="Link"),
            SpringDamper("s", "ground", link, stiffness="k"),
        ],
        gravity=(0, "-g", 0),
        parameters={**PARAMETERS, "g": 9.81},
        inputs=["T", "F"],
        initial={"theta": "30 deg", "theta_dot": "sqrt(m)"},
        ground={"post": Frame(at=(1, 0, 0))},
    )


def test_bodies_are_taken_from_joints_and_kinds_are_sorted() -> None:
    model = arm()
    assert [element.name for element in model.elements] == ["Link", "pin", "s", "push"]
    assert [body.name for body in model.bodies] == ["Link"]
    assert model.joint("pin").start.full_name == "ground.post"
    assert model.coordinates == ("theta",)
    assert all(joint.start.body_object is None and joint.end.body_object is None for joint in model.joints)


def test_listed_and_carried_bodies_are_one() -> None:
    link = Body("Link")
    twice = Model("twice", [link, Weld("a", "ground", link), Weld("b", "ground", link)])
    assert len(twice.bodies) == 1
    assert twice == Model("twice", [Body("Link"), Weld("a", "ground", "Link"), Weld("b", "ground", "Link")])


def test_changed_elements_need_no_new_joints() -> None:
    model = arm()
    heavier = replace(model, elements=[replace(model.body("Link"), mass=5), *model.elements[1:]])
    assert heavier.body("Link").mass.text == "5" and len(heavier.bodies) == 1


def test_a_bare_word_is_a_body_or_a_unique_frame() -> None:
    body = Body("A", frames={"tip": Frame(), "post": Frame()})
    model = Model("bare", [body, Weld("w", "post2", "tip")], ground={"post2": Frame()})
    assert (model.joints[0].start.full_name, model.joints[0].end.full_name) == ("ground.post2", "A.tip")


def test_frozen_picklable_and_copied() -> None:
    model = arm()
    assert pickle.loads(pickle.dumps(model)) == model
    with pytest.raises(FrozenInstanceError):
        model.name = "other"
    parameters = {"m": 1}
    copied = Model("copied", parameters=parameters)
    parameters["m"] = 2
    assert copied.parameters["m"].text == "1"
    assert replace(model, name="arm") == model and replace(model, name="b") != model


@pytest.mark.parametrize(
    "rest", [{}, {"parameters": {"m": 1}}, {"inputs": ["F"]}, {"ground": {"post": Frame()}}]
)
def test_empty_models_are_legal(rest: dict[str, object]) -> None:
    model = Model("empty", **rest)
    assert (model.bodies, model.joints, model.coordinates) == ((), (), ())


def test_one_free_body_and_a_welded_one() -> None:
    model = Model("two", [Body("Free", mass=1), Body("Fixed"), Weld("w", "ground", "Fixed")])
    assert "body Free has no joint and moves freely, with coordinates Free_x to Free_qz" in model.notes
    assert [joint.name for joint in model.free_joints] == ["Free"]


def test_missing_body_and_joint() -> None:
    with pytest.raises(ModelError, match=r"model\.unknown_element.*\n.*'Link'"):
        arm().body("Lnk")
    with pytest.raises(ModelError, match=r"'pin'"):
        arm().joint("pn")


def test_one_name_for_two_elements() -> None:
    assert faults(Body("A"), Torque("A", "A", (0, 0, 1))) == [
        ("names.duplicate", "body A, name; torque A, name")
    ]
    assert faults(Body("A"), Body("A", mass=2)) == [
        ("names.duplicate", "body A (element 1), name; body A (element 2), name")
    ]
    assert (
        faults(Weld("w", "ground", Body("A")), Weld("v", "ground", Body("A", mass=1)))[0][0]
        == "names.duplicate"
    )


def test_unknown_places() -> None:
    frames = {"tip": Frame()}
    bodies = [Body("A", frames=frames), Body("B", frames=frames)]
    assert faults(*bodies, Weld("w", "ground.post", "C"), Weld("v", "A.tp", "tip")) == [
        ("model.unknown_place", f"joint {name}, between[{k}]") for name in "wv" for k in (0, 1)
    ]
    assert faults(Force("f", "A", (1, 0, 0), reaction_on="B.x", resolved_in="y")) == [
        ("model.unknown_place", f"force f, {word}") for word in ("on", "resolved_in", "reaction_on")
    ]


def test_a_joint_needs_two_bodies() -> None:
    body = Body("A", frames={"tip": Frame()})
    assert faults(body, Weld("w", "A", "A.tip"))[0] == ("model.self_joint", "joint w, between")
    assert faults(Weld("w", "ground", "Ground")) == [("model.self_joint", "joint w, between")]


def test_bodies_joined_to_each_other_only() -> None:
    pair = [Body("A"), Body("B"), Body("C"), Revolute("j", "A", "B"), Weld("k", "ground", "C")]
    assert faults(*pair) == [("model.no_ground", "body A")]
    assert Model("joined", [*pair, Prismatic("rail", "ground", "B")]).coordinates == ("j", "rail")


def test_two_joints_between_the_same_bodies_are_a_loop() -> None:
    assert len(Model("loop", [Body("A"), Revolute("a", "ground", "A"), Weld("b", "A", "ground")]).joints) == 2


def test_symbols_share_one_namespace() -> None:
    body = Body("A")
    slider = Prismatic("x", "ground", body)
    assert faults(slider, parameters={"x": 1}) == [("names.duplicate", "model, parameters.x; joint x, name")]
    assert faults(slider, inputs=["x_dot"]) == [("names.duplicate", "model, inputs[0]; joint x, name")]
    assert faults(slider, parameters={"x_ddot": 1})[0][0] == "names.duplicate"
    assert faults(inputs=["F", "F"]) == [("names.duplicate", "model, inputs[0]; model, inputs[1]")]
    # elements and symbols are two namespaces; names of generated quantities are free
    assert Model("fine", [slider], parameters={"A": 1, "qdd1": 2, "udot": 3}).coordinates == ("x",)


@pytest.mark.parametrize(
    ("element", "where"),
    [
        (Body("A", mass="theta"), "body A, mass, column 1"),
        (Body("A", inertia=(0, "t", 0)), "body A, inertia[1], column 1"),
        (Body("A", frames={"f": Frame(at=(0, 0, "2*F"))}), "body A, frames.f.at[2], column 3"),
        (
            Body("A", frames={"f": Frame(rotate=[("x", "theta_dot")])}),
            "body A, frames.f.rotate[0][1], column 1",
        ),
        (Revolute("A", "ground", "B", axis=("F", 0, 1)), "joint A, axis[0], column 1"),
        (Revolute("A", "ground", "B", motion="sin(t) + theta"), "joint A, motion, column 10"),
        (
            Revolute("A", "ground", "B", torque=Drive(applied="theta_ddot")),
            "joint A, torque.applied, column 1",
        ),
    ],
)
def test_names_where_they_do_not_belong(element: Element, where: str) -> None:
    base = [Body("B"), Revolute("pin", "ground", "B", coordinate="theta")]
    assert faults(*base, element, inputs=["F"]) == [("names.not_here", where)]


def test_names_that_belong() -> None:
    drive = Drive(applied="F*sin(t) - x_dot*abs(x_dot) + pi*m", stiffness="m + x")
    slider = Prismatic("s", "ground", Body("A", mass="m*pi"), coordinate="x", force=drive)
    Model("fine", [slider, Torque("T", "A", ("x", "x_dot", "t"))], parameters={"m": 1}, inputs=["F"])


def test_masses_inertias_axes_rotations() -> None:
    assert faults(Body("A", mass="m - 2"), parameters=PARAMETERS) == [("model.negative_mass", "body A, mass")]
    assert faults(Body("A", inertia=(1, 1, 5))) == [("model.impossible_inertia", "body A, inertia")]
    assert faults(Body("A", mass="1/(m - 1)"), parameters=PARAMETERS) == [
        ("expression.division_by_zero", "body A, mass")
    ]
    assert faults(Body("A", mass="log(m - 2)"), parameters=PARAMETERS) == [
        ("model.not_finite", "body A, mass")
    ]
    assert faults(Body("A"), Revolute("j", "ground", "A", axis=(0, 0, "m - 1")), parameters=PARAMETERS) == [
        ("model.zero_axis", "joint j, axis")
    ]
    wrong = Frame(matrix=[[1, 0, 0], [0, 1, 0], [0, 1e-3, 1]])
    assert faults(Body("A", frames={"f": wrong})) == [("model.not_a_rotation", "body A, frames.f.matrix")]
    mirror = Frame(matrix=[[1, 0, 0], [0, 1, 0], [0, 0, -1]])
    assert faults(ground={"f": mirror}) == [("model.not_a_rotation", "model, ground.frames.f.matrix")]


def test_signs_of_products_are_suspected() -> None:
    with pytest.raises(ModelError, match="opposite signs"):
        Model("signs", [Body("A", inertia=(2, 2, 2), products=(0.9, 0.9, 0.9))])


def test_what_is_legal_stays_legal() -> None:
    planar = Body("A", mass=0, inertia=(0, 0, 3))
    tiny = Body("B", mass=1e-15, inertia=(1e-30, 1e-30, 2e-30))
    noisy = Body("C", frames={"f": Frame(matrix=[[1, 1e-9, 0], [-1e-9, 1, 0], [0, 0, 1]])})
    unknown = Body("D", mass="m0", inertia=("m0", 1, "2*m0"))
    assert len(Model("legal", [planar, tiny, noisy, unknown], parameters={"m0": None}).bodies) == 4


@pytest.mark.parametrize(
    ("element", "words"),
    [
        (Revolute("j", "ground", "B", axis=(0, 0, 2)), "the axis of length 2 is normalized"),
        (Revolute("j", "ground", "B", torque=Drive(stiffness="-m")), "the stiffness -m is negative"),
        (SpringDamper("s", "ground", "B", damping=-1), "the damping -1 is negative"),
        (
            Body("A", frames={"f": Frame(rotate=[("z", 90)])}),
            '90 rad is more than a turn; for degrees write "90 deg"',
        ),
        (
            Body("A", mass=1, inertia=(1e6, 1e6, 1e6), frames={"f": Frame(at=(0.1, 0, 0))}),
            "radius of gyration",
        ),
    ],
)
def test_remarks_on_what_is_unusual(element: Element, words: str) -> None:
    notes = Model("odd", [Body("B"), element], parameters={"m": 1}).notes
    assert any(words in note for note in notes), notes


def test_zero_gravity_is_remarked_and_a_normal_model_is_not() -> None:
    assert "gravity is zero" in Model("a").notes
    assert arm().notes == ()


def test_initial_values() -> None:
    slider = Prismatic("s", "ground", Body("A"), coordinate="x")
    assert Model("a", [slider], initial={"x": "m", "x_dot": 0}, parameters={"m": 1}).initial["x"].text == "m"
    assert faults(slider, initial={"y": 1, "x_ddot": 1}) == [
        ("initial.unknown", "model, initial.y"),
        ("initial.unknown", "model, initial.x_ddot"),
    ]
    assert faults(slider, initial={"x": "30 deg"}) == [("model.not_an_angle", "model, initial.x")]
    assert faults(slider, initial={"x": "x_dot"}) == [("names.not_here", "model, initial.x, column 1")]
    rotated = Prismatic("s", "ground", Body("A"), force=Drive(free="1 deg"))
    assert faults(rotated) == [("model.not_an_angle", "joint s, force")]


def test_all_problems_at_once() -> None:
    codes = [
        code
        for code, _ in faults(
            Body("A", mass=-1),
            Weld("A", "ground", "X"),
            gravity=(0, "G", 0),
            parameters={"a": "b", "b": "a", "t": 1},
            inputs=["in put"],
            initial={"z": 1},
        )
    ]
    assert sorted(codes) == [
        "initial.unknown",
        "model.negative_mass",
        "model.unknown_place",
        "names.duplicate",
        "names.not_a_symbol",
        "names.reserved",
        "names.unknown",
        "parameters.cycle",
    ]


@pytest.mark.parametrize("elements", [5, "abc", [3], [None], {"a": Body("A")}, [Frame()]])
def test_elements_must_be_elements(elements: object) -> None:
    with pytest.raises(ModelError):
        Model("bad", elements)


@pytest.mark.parametrize(
    "rest", [{"parameters": [1]}, {"initial": 3}, {"ground": {"a": 1}}, {"inputs": 5}, {"gravity": 0}]
)
def test_arguments_of_the_wrong_kind(rest: dict[str, object]) -> None:
    assert faults(**rest)


def test_thousand_bodies() -> None:
    joints = [Revolute(f"j{k}", f"b{k - 1}" if k else "ground", f"b{k}") for k in range(1000)]
    assert len(Model("chain", [*joints, *(Body(f"b{k}") for k in range(1000))]).coordinates) == 1000


def test_the_model_needs_no_mathematics() -> None:
    script = (
        "import sys; from symbody.model import *; "
        "Model('a', [Prismatic('s', 'ground', Body('A', mass='m'))], parameters={'m': 'sin(1)'}); "
        "print(*sorted({'numpy', 'pydantic', 'scipy', 'sympy'} & set(sys.modules)))"
    )
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert run.stdout.strip() == ""
