"""Contacts wherever mechanisms are used: files, parts, equilibria, linear equations, sweeps, steps, code."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.formats.native import from_data, model_from_toml, model_to_toml, to_data
from symbody.formats.python_script import model_to_script
from tests.codegen.test_portable import check_bits, random_points
from tests.contacts.pairs import NAMES, ORDERED, scene
from tests.tiers import cases

FILE = """
version = 2
name = "foot"
gravity = [0, 0, -9.81]

[parameters]
r = 0.05
k = 1e6
v0 = 1

[ground.frames]
floor = { at = [0, 0, 0.1] }

[[body]]
name = "Foot"
mass = 2
inertia = [0.01, 0.01, 0.01]
frames = { heel = { at = [-0.1, 0, 0] }, toe = { at = [0.1, 0, 0] } }

[[contact]]
name = "heel"
between = ["ground.floor", "Foot.heel"]
shapes = ["plane", { sphere = "r" }]
normal = { stiffness = "k", exponent = 1.5, restitution = 0.5, speed = "v0" }
friction = { mu = 0.6, mu_static = 0.8, stribeck = 0.01, v0 = 1e-3 }

[[contact]]
name = "toe"
between = ["Foot.toe", "ground.floor"]
shapes = [{ box = [0.01, "r", 0.02] }, "plane"]
normal = { law = "k*(-gap) - 10*gap_rate" }
friction = { mu = 0.6, mu_y = 0.3, v0 = 1e-3 }
"""


def test_files_keep_contacts() -> None:
    model = model_from_toml(FILE)
    assert model_to_toml(model, FILE) == FILE
    again = model_from_toml(model_to_toml(model))
    assert again.elements == model.elements and from_data(to_data(model)).elements == model.elements
    heel = next(each for each in model.elements if each.name == "heel")
    assert heel == sb.Contact(
        "heel", "ground.floor", "Foot.heel", ["plane", {"sphere": "r"}],
        normal=sb.NormalForce(stiffness="k", restitution=0.5, speed="v0"),
        friction=sb.Friction(mu=0.6, mu_static=0.8, stribeck=0.01, v0=1e-3),
    )  # fmt: skip
    assert "sb.Contact(" in model_to_script(model) and "sb.NormalForce(" in model_to_script(model)


@pytest.mark.parametrize("words", ORDERED, ids=NAMES)
def test_all_shapes_are_written_and_read(words: tuple[str, str]) -> None:
    model = scene(words)
    assert model_from_toml(model_to_toml(model)).elements == model.elements


def test_parts_rename_contacts() -> None:
    """A part has a coordinate x of its own: the x of a height is none."""
    ground = {"floor": sb.Frame()}
    foot = sb.Body("Foot", mass=1)
    shapes = [{"height": "a*sin(x)"}, {"sphere": "a"}]
    contact = sb.Contact(
        "touch", "ground.floor", foot, shapes, normal=sb.NormalForce(stiffness="k", law=None)
    )
    joint = sb.Cartesian("J", "ground", foot, coordinates=["x", "y", "z"])
    part = sb.Model("foot", [joint, contact], parameters={"a": 0.1, "k": 1e4}, ground=ground)
    whole = sb.Model("two", [sb.Include(part, "L"), sb.Include(part, "R")])
    renamed = next(each for each in whole.elements if each.name == "L_touch")
    assert isinstance(renamed, sb.Contact)
    assert renamed.shapes[0].sizes[0].text == "L_a*sin(x)" and renamed.normal.stiffness is not None
    eqs = sb.form_equations(whole)
    values = sb.compile(eqs, ["gap L_touch", "frame r L_touch"])(0.0, [0.3, 0, 0.5, 0, 0, 0], np.zeros(6))
    assert 0.3 < values[0] < 0.5 and values[1].shape == (3,)


FAULTS = [
    ({"shapes": ["plane", "plane"]}, "contact.pair", "there is no formula for a plane that touches a plane"),
    ({"shapes": ["half_space", "point"]}, "contact.shape", "'half_space' is not a shape"),
    ({"shapes": ["plane", {"sphere": ["r", 1]}]}, "contact.sizes", "a sphere has radius, not 2 sizes"),
    ({"shapes": ["plane"]}, "model.wrong_number", "1 shape instead of 2"),
    ({"normal": "stiff"}, "contact.normal", "'stiff' is not a normal force"),
    ({"friction": 0.5}, "contact.friction", "0.5 is not Friction"),
    ({"friction": sb.Friction(mu=0.5)}, "contact.friction", "v0 is missing"),
    ({"friction": sb.Friction(mu=0.5, radius=1, v0=1)}, "contact.friction", "radius is for joints"),
    ({"friction": sb.Friction(mu=0.5, v0=1, mu_static=1)}, "contact.friction", "belong together"),
    ({"friction": sb.Friction(mu=0.5, v0=1, mu_y=1, mu_static=1, stribeck=1)}, "contact.friction", "are given"),
    ({"shapes": ["point", {"sphere": 1}], "friction": sb.Friction(mu=0.5, v0=1, mu_y=1)}, "contact.friction",
     "neither shape is a plane"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "code", "text"), FAULTS)
def test_what_is_no_contact_is_told(change: dict[str, object], code: str, text: str) -> None:
    arguments = {"shapes": ["plane", "point"], "normal": sb.NormalForce(stiffness=1), **change}
    with pytest.raises(sb.ModelError) as caught:
        sb.Contact("C", "ground", "B", **arguments)  # type: ignore[arg-type]
    assert [problem.code for problem in caught.value.problems] == [code]
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("shape", "what"),
    [
        ({"height": "x*z"}, "'z' is a coordinate"),
        ({"height": "0.1*sin(t)"}, "'t' is time"),
        ({"cam": "0.1 + 0.01*sin(angle - t)"}, "'t' is time"),
    ],
)
def test_a_surface_stays_as_it_is_in_its_frame(shape: dict[str, str], what: str) -> None:
    with pytest.raises(sb.ModelError, match=what):
        model_of(contact(shapes=[shape, "point"]))


@pytest.mark.parametrize("name", ["floor 1", "floor friction", "floor friction 2"])
def test_points_of_a_rigid_contact_have_their_names_alone(name: str) -> None:
    model_of(contact(), sb.Stop(name, "z"))
    with pytest.raises(sb.ModelError, match=f"'{name}' is also what a point of contact floor is called"):
        model_of(contact(normal="rigid"), sb.Stop(name, "z"))


@pytest.mark.parametrize("name", ["contact_force flor", "contact_point flor", "contact_force floor q",
                                  "contact_point floor q"])  # fmt: skip
def test_outputs_of_no_rigid_contact_are_told(name: str) -> None:
    eqs = sb.form_equations(model_of(contact(normal="rigid")))
    with pytest.raises(sb.SymbodyError, match="is neither an output nor an expression"):
        sb.compile(eqs, [name])


def contact(**change: object) -> sb.Contact:
    given = {"shapes": ["plane", "point"], "normal": sb.NormalForce(stiffness=1), **change}
    return sb.Contact("floor", "ground", "B", **given)  # type: ignore[arg-type]


def model_of(*elements: object) -> sb.Model:
    """A body on a plane."""
    joint = sb.Cartesian("J", "ground", sb.Body("B", mass=1), coordinates=["x", "y", "z"])
    return sb.Model("m", [joint, *elements])  # type: ignore[list-item]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({}, "the stiffness is missing"),
        ({"law": "gap", "stiffness": 1}, "law and stiffness are given"),
        ({"stiffness": 1, "dissipation": 1, "damping": 1}, "dissipation and damping are given"),
        ({"stiffness": 1, "restitution": 1}, "restitution requires speed, which is missing"),
        ({"stiffness": 1, "depth": 1}, "depth requires damping, which is missing"),
    ],
)
def test_a_law_is_one_law(arguments: dict[str, object], text: str) -> None:
    with pytest.raises(sb.ModelError, match=text) as caught:
        sb.NormalForce(**arguments)  # type: ignore[arg-type]
    assert {problem.code for problem in caught.value.problems} == {"contact.normal"}


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        ({"stiffness": -1}, "contact.domain", "the stiffness is -1"),
        ({"stiffness": 1, "exponent": 0.5}, "contact.domain", "the exponent 0.5 is 0.5"),
        ({"stiffness": 1, "restitution": "e", "speed": 1}, "contact.domain", "the restitution e is 0"),
        ({"stiffness": 1, "restitution": 1, "speed": "e"}, "contact.domain", "e is 0"),
        ({"stiffness": 1, "dissipation": -2}, "contact.domain", "-2 is -2"),
    ],
)
def test_numbers_that_cannot_be(arguments: dict[str, object], code: str, text: str) -> None:
    ball = sb.Body("B", mass=1)
    contact = sb.Contact("C", "ground", ball, ["plane", "point"], normal=sb.NormalForce(**arguments))  # type: ignore[arg-type]
    with pytest.raises(sb.ModelError, match=text) as caught:
        sb.Model("m", [ball, contact], parameters={"e": 0})
    assert code in {problem.code for problem in caught.value.problems}
    flat = sb.Contact("C", "ground", ball, ["plane", {"sphere": "e"}], normal=sb.NormalForce(stiffness=1))
    with pytest.raises(sb.ModelError, match="e is 0 m") as caught:
        sb.Model("m", [ball, flat], parameters={"e": 0})
    assert {problem.code for problem in caught.value.problems} == {"contact.size"}
    within = sb.Contact("C", "B.f", ball, ["point", {"sphere": 1}], normal=sb.NormalForce(stiffness=1))
    body = sb.Body("B", mass=1, frames={"f": sb.Frame(at=(2, 0, 0))})
    with pytest.raises(sb.ModelError, match="both shapes are on B"):
        sb.Model("m", [body, within])


GOOD = {
    "m": 1.0, "stiffness": 1e6, "e": 0.5, "mu": 0.3, "mu_static": 0.4, "deflection": 1e-4, "damping_time": 0.01,
    "breakaway": 0.7, "e_stop": 0.5, "r": 0.1, "play": 0.1,
}  # fmt: skip
# A value given in a call, and the code of the fault that it is in a file, too.
GIVEN = [
    ("stiffness", -1.0, "contact.domain"),
    ("e", 1.5, "contact.domain"),
    ("mu", -0.1, "model.negative_friction"),
    ("mu_static", 0.2, "model.static_friction"),
    ("deflection", -1.0, "model.friction_scale"),
    ("deflection", 0.0, "model.friction_scale"),
    ("damping_time", 0.0, "model.friction_scale"),
    ("breakaway", 1.0, "model.friction_scale"),
    ("e_stop", -0.1, "model.restitution"),
    ("r", -0.1, "contact.size"),
    ("play", -1.0, "model.backlash"),
    ("m", -1.0, "model.negative_mass"),
]


@pytest.fixture(scope="module")
def many_laws() -> sb.EquationSet:
    """A ball on the ground, a stop above it and a gear with play, with all their numbers as parameters."""
    ball = sb.Body("Ball", mass="m", inertia=(0.01, 0.01, 0.01))
    wheel = sb.Body("Wheel", inertia=(0, 0, 0.01))
    rough = sb.Friction(mu="mu", mu_static="mu_static", stribeck=0.01, deflection="deflection",
                        damping_time="damping_time", breakaway="breakaway")  # fmt: skip
    law = sb.NormalForce(stiffness="stiffness", restitution="e", speed=1)
    parts = [
        sb.Planar("J", "ground", ball, axis="y", coordinates=["z", "x", "th"]),
        sb.Revolute("pin", "ground", wheel, axis="z", coordinate="a"),
        sb.Contact("floor", "ground", ball, ["plane", {"sphere": "r"}], normal=law, friction=rough),
        sb.Stop("ceiling", gap="2 - z", restitution="e_stop"),
        sb.Gear("mesh", ["a", "th"], ratio=2, backlash=sb.Backlash(angle="play", stiffness=100)),
    ]
    model = sb.Model("laws", parts, gravity=(0, 0, -9.81), parameters=GOOD, initial={"z": 0.2})
    return sb.form_equations(model)


@pytest.mark.parametrize(("name", "value", "code"), GIVEN)
def test_numbers_given_in_a_call_are_judged_as_in_a_file(
    name: str, value: float, code: str, many_laws: sb.EquationSet
) -> None:
    """By whatever computes a motion; in a sweep the other cases go on."""
    with pytest.raises(sb.SymbodyError) as fault:
        sb.simulate(many_laws, 0.01, parameters={name: value})
    problem = fault.value.problems[0]
    assert (problem.code, bool(problem.what and problem.fix)) == (code, True)
    stepper = sb.Stepper(many_laws, 0.01)
    with pytest.raises(sb.SymbodyError) as again:
        stepper.set(**{name: value})
    assert again.value.problems[0] == problem
    with pytest.raises(sb.SymbodyError):
        sb.LaneStepper(
            many_laws, 0.01, 2, parameters={name: [float(many_laws.model.parameters[name].text), value]}
        )
    good = GOOD[name]
    cases = sb.sweep(many_laws, 0.01, {name: [good, value, good]}, times=[0, 0.01])
    assert [status is sb.Status.NOT_STARTED for status in cases.status] == [False, True, False]
    assert list(cases.case_notes) == [1] and f"[{code}]" in cases.case_notes[1]


def test_joints_have_no_friction_of_contacts() -> None:
    with pytest.raises(sb.ModelError, match="mu_y is for contacts"):
        sb.Prismatic("J", "ground", "B", friction=sb.Friction(mu=0.1, v0=1, mu_y=0.2))


def test_a_group_is_a_contact_of_each_pair() -> None:
    """On frames of bodies and on ground; among bodies each pair once."""
    law = sb.NormalForce(stiffness=1e4)
    legs = [
        sb.Body(f"Leg{k}", mass=1, inertia=(1, 1, 1), frames={"toe": sb.Frame(), "heel": sb.Frame()})
        for k in range(3)
    ]
    feet = sb.Contact("feet", "ground", "Leg*.*e*", ["plane", {"sphere": 0.1}], normal=law)
    knees = sb.Contact("knees", "Leg*", "Leg*", [{"sphere": 0.1}, {"sphere": 0.1}], normal=law)
    model = sb.Model("walker", [*legs, feet, knees], gravity=(0, 0, -1))
    names = [each.name for each in model.elements if isinstance(each, sb.Contact)]
    assert names == [
        *(f"feet_Leg{k}_{frame}" for k in range(3) for frame in ("toe", "heel")),
        "knees_Leg0_Leg1", "knees_Leg0_Leg2", "knees_Leg1_Leg2",
    ]  # fmt: skip
    assert "contact knees stands for 3 contacts" in "\n".join(model.notes)
    run = sb.simulate(sb.form_equations(model), 0.01, {"Leg0_z": 0.05})
    assert run["contact_force feet_Leg0_toe z"][0] > 0
    with pytest.raises(sb.ModelError, match="fit no two bodies") as caught:
        sb.Model("none", [*legs, sb.Contact("C", "ground", "Arm*", ["plane", "point"], normal=law)])
    assert {problem.code for problem in caught.value.problems} == {"contact.group"}


def ball_on_floor() -> sb.EquationSet:
    ball = sb.Body("Ball", mass=2)
    rail = sb.Prismatic("rail", "ground", ball, axis="z", coordinate="z")
    floor = sb.Contact("floor", "ground", ball, ["plane", {"sphere": "r"}],
                       normal=sb.NormalForce(stiffness="k", restitution="e", speed=2))  # fmt: skip
    values = {"r": 0.1, "k": 1e6, "e": 0.6}
    return sb.form_equations(
        sb.Model("ball", [rail, floor], gravity=(0, 0, -9.81), parameters=values, initial={"z": 0.2})
    )


def test_equilibrium_and_linear_equations_of_a_closed_contact() -> None:
    """k d^1.5 = m g; stiffness 1.5 k sqrt(d), damping c m g."""
    eqs = ball_on_floor()
    rest = sb.find_equilibrium(eqs, guess={"z": 0.0999})
    depth = (2 * 9.81 / 1e6) ** (2 / 3)
    assert rest.stable and rest["z"] == pytest.approx(0.1 - depth, abs=1e-12)
    assert rest["contact_force floor z"] == pytest.approx(2 * 9.81) and rest["slip floor x"] == 0
    linear = sb.linearize(eqs, at=rest.q)
    stiffness = 1.5e6 * math.sqrt(depth)
    a = 2 * -linear.A[0, 0] / (2 * 9.81) * 2  # c v0, from -c m g/m
    assert math.log((1 + a) / (1 - a * 0.6)) == pytest.approx(a * 1.6)
    assert -linear.A[0, 1] == pytest.approx(stiffness / 2)


def test_a_table_on_uneven_ground() -> None:
    """Four legs on springs: the forces bear the weight without a moment, each by the depth of its leg."""
    k, heights, tops = 1e4, (0, 0.002, 0.001, -0.003), ((0.4, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.4, -0.3))
    legs = {f"L{i}": sb.Frame(at=(x, y, -0.5)) for i, (x, y) in enumerate(tops)}
    table = sb.Body("T", mass=10, inertia=(1, 1, 1.5), frames=legs)
    column = sb.Body("Column")
    joints = [
        sb.Prismatic("lift", "ground", column, axis="z", coordinate="z"),
        sb.Universal("tilt", column, table, axes=("x", "y"), coordinates=["a", "b"]),
    ]
    law = sb.NormalForce(stiffness=k, exponent=1, dissipation=0.1)
    contacts = [
        sb.Contact(f"C{i}", f"ground.g{i}", f"T.L{i}", ["plane", "point"], normal=law,
                   friction=sb.Friction(mu=0.5, v0=1e-3))
        for i in range(4)
    ]  # fmt: skip
    ground = {f"g{i}": sb.Frame(at=(0, 0, h)) for i, h in enumerate(heights)}
    eqs = sb.form_equations(sb.Model("table", [*joints, *contacts], gravity=(0, 0, -9.81), ground=ground))
    rest = sb.find_equilibrium(eqs, guess={"z": 0.497})
    forces = np.array([rest[f"contact_force C{i} z"] for i in range(4)])
    places = np.array([rest[f"frame r T.L{i}"] for i in range(4)])
    np.testing.assert_allclose(forces, k * np.maximum(0, heights - places[:, 2]), rtol=1e-9)
    assert forces.sum() == pytest.approx(98.1) and (forces > 10).all()
    np.testing.assert_allclose(forces @ places[:, :2], 0, atol=1e-6)
    assert rest.stable


def test_sweeps_and_steps_have_the_motion() -> None:
    eqs = ball_on_floor()
    runs = sb.sweep(eqs, 0.5, {"e": [0.3, 0.6, 0.9]}, times=[0, 0.5], rtol=1e-10)
    alone = sb.simulate(eqs, 0.5, parameters={"e": 0.6}, times=[0, 0.5], rtol=1e-10)
    assert runs["z"][1, -1] == pytest.approx(
        alone["z"][-1], abs=1e-6
    )  # an impact amplifies what its steps leave
    assert runs["z"][0, -1] < runs["z"][1, -1] < runs["z"][2, -1]
    stepper = sb.Stepper(eqs, 0.01)
    for _ in range(50):
        stepper.step()
    assert stepper.state()["z"] == pytest.approx(alone["z"][-1], abs=1e-5)


@pytest.mark.parametrize(
    "words",
    cases([("box", "capsule"), ("height", "sphere"), ("plane", "cylinder")], fast=[("height", "sphere")]),
)
def test_code_has_the_same_bits_in_all_languages(words: tuple[str, str], tmp_path: Path) -> None:
    model = scene(words, sb.NormalForce(stiffness="k", restitution=0.5, speed=1))
    outputs = ["gap touch", "contact_force touch", "slip touch"]
    f = sb.compile(sb.form_equations(model), outputs, portable=True)
    check_bits(f, random_points(f, 20, 1), tmp_path)


def test_signals_and_loads_read_contacts() -> None:
    """A thruster that lifts in proportion to the gap's lack: an output in a load, by a signal."""
    ball = sb.Body("Ball", mass=2)
    parts = [
        sb.Prismatic("rail", "ground", ball, axis="z", coordinate="z"),
        sb.Contact("floor", "ground", ball, ["plane", {"sphere": 0.1}], normal=sb.NormalForce(stiffness=1e6)),
        sb.Signal("height", output="gap floor"),
        sb.Force("lift", ball, (0, 0, "100*(0.05 - height)")),
    ]
    eqs = sb.form_equations(sb.Model("hover", parts, gravity=(0, 0, -1)))
    assert sb.compile(eqs, "udot")(0.0, [0.13], [0])[0] == pytest.approx(-1 + 100 * 0.02 / 2)
