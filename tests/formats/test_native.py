"""The model file: read, written, the same again."""

from __future__ import annotations

import json
import string
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.errors import FormatError, ModelError, SymbodyError
from symbody.formats import (
    from_data,
    load_model,
    model_from_toml,
    model_to_toml,
    read_layout,
    save_model,
    to_data,
)
from symbody.model import (
    Bearing,
    Body,
    Cartesian,
    ConstantVelocity,
    Cylindrical,
    Drive,
    Force,
    Frame,
    Free,
    Gimbal,
    Model,
    PinSlot,
    Planar,
    Prismatic,
    Rectangular,
    Revolute,
    Screw,
    Spherical,
    SpringDamper,
    Telescoping,
    Torque,
    Universal,
    Weld,
)
from symbody.model.joint import Joint
from tests.effort import limited

EXAMPLE = Path(__file__).parents[2] / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"


def spring_mass_damper() -> Model:
    mass = Body("Mass", mass="m")
    drive = Drive(applied="F", stiffness="k", damping="d")
    return Model(
        "spring-mass-damper",
        [Prismatic("slider", "ground", mass, axis="x", coordinate="x", force=drive)],
        parameters={"m": 1.0, "d": 0.5, "k": 1.0},
        inputs=["F"],
        initial={"x": 1.0},
    )


def everything() -> Model:
    """Every class and every field away from its default."""
    frames = {
        "tip": Frame(at=("L", 0.25, "-1e-3"), rotate=[("z", "30 deg"), (("a", 0, 1), "phi")]),
        "flat end": Frame(matrix=[[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
        "plain": Frame(),
    }
    link = Body("upper arm", mass="m", inertia=(1, "2*m", 1.50), products=("0.1", 0, -0.2), frames=frames)
    wheel = Body("🙂 wheel", mass=1e-30)
    drive = Drive(applied="T*sin(t) - q_dot", stiffness=1e22, damping="if(q < 0, d, 2*d)", free="-90 deg")
    return Model(
        "everything, \"quoted\" 'twice'\n∅",
        [
            link,
            wheel,
            Revolute(
                "pin", "ground.post", link["tip"], axis=("a", 0, -2), coordinate="q", torque=drive, tree=True
            ),
            Prismatic(
                "rail",
                "upper arm.flat end",
                wheel,
                motion="0.1*t",
                tree={"rotation": False},
                as_constraint=True,
            ),
            Weld("seam", link["plain"], "🙂 wheel", tree={"rotation": True, "translation": False}),
            SpringDamper("s", "post", "tip", stiffness="k", damping=0.5, free="l0", applied="T"),
            Force("push", link, (0, "-T", 1.5), resolved_in="tip", reaction_on="🙂 wheel"),
            Torque("twist", "🙂 wheel", ("T", 0, 0)),
        ],
        gravity=(0, "-g", "1/3"),
        parameters={
            "g": 9.81,
            "m": "2*k",
            "k": None,
            "L": "0.50",
            "a": 1,
            "phi": "15 deg",
            "d": 10**20,
            "l0": "1e-3",
        },
        inputs=["T", "λ"],
        initial={"q": "pi/2", "q_dot": "k", "rail": 0.3},
        ground={"post": Frame(at=(1, 2, 3))},
    )


def joints() -> Model:
    """Every joint, with every word away from its default, and with defaults only."""
    bodies = [Body(name, mass=1) for name in "ABCDEFGH"]
    drive = Drive(stiffness="k", free="30 deg")
    return Model(
        "joints",
        [
            *bodies,
            Revolute("r", "ground", "A", coordinate="q", motion="30 deg", as_constraint=True, armature="J/2"),
            Prismatic("p", "A", "B", armature=1.5),
            Planar("p1", "ground", "C"),
            Planar(
                "p2",
                "ground",
                "C",
                axis="y",
                coordinates=["X", "Y", "theta"],
                tree=False,
                force={"X": Drive(applied="F"), "Y": Drive()},
                torque={"theta": drive},
                motion={"Y": "2*t", "theta": "10 deg"},
                as_constraint=True,
            ),
            Spherical("s1", "C", "D"),
            Spherical("s2", "D", "E", angles="313", torque={"s2_1": drive}, motion={"s2_3": "t"}),
            Spherical(
                "s3",
                "E",
                "F",
                angles="space xyz",
                coordinates=["a", "b", "c"],
                speeds="start",
                speed_names=["wa", "wb", "wc"],
                tree={"translation": True},
            ),
            Free("f1", "ground", "G"),
            Free(
                "f2", "ground", "H", angles="zyx", force={"f2_x": Drive(applied="F")}, torque={"f2_1": drive}
            ),
            Free("f3", "G", "H", speeds="twist", speed_names=["v1", "v2", "v3", "w1", "w2", "w3"]),
        ],
        parameters={"k": 1, "J": 0.5},
        inputs=["F"],
        initial={"q": 0.5, "wa": "k", "a_dot": 1, "f1_qw": 1, "w3": 2, "s2_1": "5 deg"},
    )


def more_joints() -> Model:
    """The joints of the library, with every word away from its default, and with defaults only."""
    drive = Drive(stiffness="k", free=0.5)
    lines = ((1, 2, 2), ("2", "-2", 1))

    def words(k: int, *parts: str) -> dict[str, object]:
        """A motion of the first coordinate, a drive of the last; `parts` say which of them are lengths."""
        names = [f"{letter}{k}" for letter in "abcd"[: len(parts)]]
        drives = {"force" if parts[-1] == "m" else "torque": {names[-1]: drive}}
        return {
            "coordinates": names,
            "tree": False,
            "motion": {names[0]: "t"},
            "as_constraint": True,
            **drives,
        }

    joints = [
        Screw("j0", "ground", "B", "p", (0, 3, 4), "q", False, drive, "t", True),
        Cylindrical("j1", "ground", "B", "x", **words(1, "rad", "m")),
        Universal("j2", "ground", "B", lines, **words(2, "rad", "rad")),
        ConstantVelocity("j3", "ground", "B", "y", **words(3, "rad", "rad")),
        PinSlot("j4", "ground", "B", lines, **words(4, "rad", "m")),
        Rectangular("j5", "ground", "B", "y", **words(5, "m", "m")),
        Cartesian("j6", "ground", "B", **words(6, "m", "m", "m")),
        Gimbal("j7", "ground", "B", "space zxz", **words(7, "rad", "rad", "rad")),
        Bearing("j8", "ground", "B", "x", "313", **words(8, "m", "rad", "rad", "rad")),
        Telescoping("j9", "ground", "B", "x", "313", **words(9, "rad", "rad", "rad", "m")),
    ]
    plain = [Screw("p0", "B", "C", 2), *(type(j)(f"p{k}", "B", "C") for k, j in enumerate(joints) if k)]
    bodies = [Body("B", mass=1), Body("C", mass=1)]
    return Model("more", [*bodies, *joints, *plain], parameters={"k": 1, "p": 0.1})


MODELS = {
    "example": spring_mass_damper,
    "everything": everything,
    "joints": joints,
    "more joints": more_joints,
    "empty": lambda: Model(""),
}


def test_script_and_file_are_the_same_model() -> None:
    assert load_model(EXAMPLE) == spring_mass_damper()


@pytest.mark.parametrize("name", MODELS)
def test_model_to_file_to_model(name: str, tmp_path: Path) -> None:
    model = MODELS[name]()
    path = tmp_path / "model.toml"
    save_model(model, path)
    assert load_model(path) == model
    assert list(load_model(path).parameters) == list(model.parameters)
    assert model_to_toml(load_model(path)) == path.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", MODELS)
def test_model_to_json_to_model(name: str) -> None:
    model = MODELS[name]()
    assert from_data(json.loads(json.dumps(to_data(model)))) == model


@pytest.mark.parametrize("name", MODELS)
def test_file_and_json_have_one_structure(name: str) -> None:
    model = MODELS[name]()

    def texts(value: object) -> object:
        if isinstance(value, dict):
            return {key: texts(item) for key, item in value.items()}
        if isinstance(value, list):
            return [texts(item) for item in value]
        return value if isinstance(value, bool) else str(value)

    assert texts(tomllib.loads(model_to_toml(model), parse_float=str)) == to_data(model)


def test_text_of_a_new_file() -> None:
    assert (
        model_to_toml(spring_mass_damper())
        == """name = "spring-mass-damper"
gravity = [0, 0, 0]
inputs = ["F"]

[parameters]
m = 1.0
d = 0.5
k = 1.0

[[body]]
name = "Mass"
mass = "m"

[[joint]]
name = "slider"
type = "prismatic"
between = ["ground", "Mass"]
axis = "x"
coordinate = "x"
force = {applied = "F", stiffness = "k", damping = "d"}

[initial]
x = 1.0
"""
    )


NAMES = st.text(string.ascii_letters + "äλ _-", min_size=1, max_size=8).filter(
    lambda name: name == name.strip()
)
NUMBERS = st.one_of(
    st.integers(0, 10**20),
    st.floats(0, 1e300, allow_nan=False),
    st.decimals(0, 1000, places=3),
    st.sampled_from(["k", "2*k", " k", "1.", ".5", "1e3", "1E-3", "0.10", "+1", "--1", "007", "30*pi/180"]),
)


@given(st.lists(st.tuples(NAMES, NUMBERS, NUMBERS), max_size=4, unique_by=lambda body: body[0].lower()))
def test_any_numbers_survive(bodies: list[tuple[str, object, object]]) -> None:
    elements = [
        Body(name, mass=mass, frames={"f": Frame(at=(length, 0, 0))})
        for name, mass, length in bodies
        if name != "-"
    ]
    model = Model("any", elements, parameters={"k": 1})
    assert model_from_toml(model_to_toml(model)) == model
    assert from_data(json.loads(json.dumps(to_data(model)))) == model


# --- saving on top of a file -----------------------------------------------------------------------------


def test_saving_unchanged_keeps_every_byte(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_bytes(EXAMPLE.read_bytes())
    save_model(load_model(path), path)
    assert path.read_bytes() == EXAMPLE.read_bytes()


@pytest.mark.parametrize(
    ("joint", "text"),
    [
        (Weld("j", "ground", "A"), 'type = "weld"\n'),
        (Revolute("j", "ground", "A"), 'type = "revolute"\naxis = "z"\n'),
        (Planar("j", "ground", "A"), 'type = "planar"\naxis = "z"\n'),
        (Spherical("j", "ground", "A"), 'type = "spherical"\nangles = "quaternion"\n'),
        (Spherical("j", "ground", "A", "zxz"), 'type = "spherical"\nangles = "313"\n'),
        (
            Spherical("j", "ground", "A", "zxz", speeds="end"),
            'type = "spherical"\nangles = "313"\nspeeds = "end"\n',
        ),
        (Free("j", "ground", "A", speeds="end"), 'type = "free"\nangles = "quaternion"\n'),
        (
            Free("j", "ground", "A", "123", motion={"j_x": "t", "j_1": 1}),
            'type = "free"\nangles = "123"\nmotion = {j_x = "t", j_1 = 1}\n',
        ),
        (
            Revolute("j", "ground", "A", torque=Drive(damping="d"), armature="J"),
            'type = "revolute"\naxis = "z"\ntorque = {damping = "d"}\narmature = "J"\n',
        ),
    ],
)
def test_defaults_are_left_out(joint: Joint, text: str) -> None:
    model = Model("a", [Body("A"), joint], parameters={"d": 1, "J": 1})
    written = model_to_toml(model).partition('[[joint]]\nname = "j"\n')[2]
    head, _, rest = written.partition('between = ["ground", "A"]\n')
    assert head + rest == text
    assert model_from_toml(model_to_toml(model)) == model


DRIVES = st.builds(
    Drive, applied=st.sampled_from([0, "F"]), stiffness=st.integers(0, 3), free=st.just("1 deg")
)
MOTIONS = st.sampled_from(["t", 0.5, "sin(t)", "30 deg"])


@st.composite
def spatial_joints(draw: st.DrawFn) -> Joint:
    """A planar, spherical or free joint with any words that go together."""
    kind = draw(st.sampled_from([Planar, Spherical, Free]))
    angles = draw(st.sampled_from(["quaternion", "313", "xyz", "space 231"]))
    plain = kind("j", "ground", "A", **({} if kind is Planar else {"angles": angles}))
    words: dict[str, object] = {"tree": draw(st.sampled_from([None, True, {"rotation": False}]))}
    if kind is Planar:
        words["axis"] = draw(st.sampled_from("xyz"))
    else:
        rates = [] if angles == "quaternion" else ["rates"]
        twist = ["twist"] if kind is Free else []
        words |= {"angles": angles, "speeds": draw(st.sampled_from([None, "start", "end", *rates, *twist]))}
    if draw(st.booleans()):
        words["coordinates"] = [f"x{k}" for k in range(len(plain.coordinates))]
    joint = kind("j", "ground", "A", **words)
    if joint.quasi_speed_names and draw(st.booleans()):
        words["speed_names"] = [f"u{k}" for k in range(len(joint.quasi_speed_names))]
    words["torque"] = (
        draw(st.dictionaries(st.sampled_from(joint.angle_coordinates), DRIVES))
        if joint.angle_coordinates
        else None
    )
    if kind is not Spherical:
        drives = DRIVES.map(lambda drive: replace(drive, free=0))
        words["force"] = draw(st.dictionaries(st.sampled_from(joint.translation_coordinates), drives))
    if joint.angle_coordinates:
        words["motion"] = draw(st.dictionaries(st.sampled_from(joint.angle_coordinates), MOTIONS))
        words["as_constraint"] = bool(joint.quasi_speed_names) or draw(st.booleans())
    return kind("j", "ground", "A", **words)


@given(spatial_joints())
def test_any_spatial_joint_comes_back(joint: Joint) -> None:
    model = Model("a", [Body("A"), joint], inputs=["F"])
    text = model_to_toml(model)
    assert model_from_toml(text) == model
    assert model_to_toml(model_from_toml(text)) == text
    assert from_data(json.loads(json.dumps(to_data(model)))) == model


COMMENTED = """# head
name = "arm"    # title
gravity = [0, 0, 0]
[parameters]
m = 1.0         # kg
k = "2*m"       # N/m
[[body]]        # first
name = "A"
mass = "m"      # mass of A
[body.frames]
tip = { at = [1, 0, 0] }   # tip of A
# second
[[body]]
name = "B"
[[joint]]
name = "j"      # hinge
type = "revolute"
axis = "z"
between = ["ground", "A"]
torque = { stiffness = "k", damping = 1 }   # drive
[layout]
A = { x = 10, y = 20.5 }
shapes = [ { name = "A", at = 1979-05-27 } ]
"""

CHANGES: dict[str, tuple[Callable[[Model], Model], list[str]]] = {
    "mass": (lambda m: replace(m, elements=[replace(m.body("A"), mass=3), *m.elements[1:]]), ["# mass of A"]),
    "parameter": (lambda m: replace(m, parameters={"m": 2, "k": "2*m", "d": 1}), []),
    "frame": (
        lambda m: replace(
            m,
            elements=[
                replace(m.body("A"), frames={"tip": Frame(at=(2, 0, 0)), "new": Frame()}),
                *m.elements[1:],
            ],
        ),
        [],
    ),
    "drive": (
        lambda m: replace(m, elements=[*m.bodies, replace(m.joint("j"), torque=Drive(stiffness="m"))]),
        ["# drive"],
    ),
    "renamed": (lambda m: replace(m, elements=[m.body("A"), Body("C"), *m.joints]), []),
    "added": (lambda m: replace(m, elements=[*m.elements, Body("C"), Weld("w", "A", "C")]), []),
    "removed": (lambda m: replace(m, elements=[m.body("A"), *m.joints]), []),
    "new tables": (
        lambda m: replace(m, inputs=["F"], initial={"j": "F_0"}, parameters={**m.parameters, "F_0": 1}),
        [],
    ),
    "ground": (lambda m: replace(m, ground={"post": Frame(at=(1, 0, 0))}, name="other"), ["# title"]),
}


@pytest.mark.parametrize("change", CHANGES)
def test_comments_and_layout_are_kept(change: str, tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_text(COMMENTED)
    model = CHANGES[change][0](load_model(path))
    save_model(model, path)
    text = path.read_text()
    assert load_model(path) == model
    kept = ["# head", "# first", "# hinge", "# kg", *CHANGES[change][1]]
    assert [comment for comment in kept if comment not in text] == []
    assert tomllib.loads(text)["layout"] == tomllib.loads(COMMENTED)["layout"]
    assert path.with_name("model.toml.bak").read_text() == COMMENTED


def test_saving_on_something_else_writes_anew_and_keeps_it_aside(tmp_path: Path) -> None:
    for old in (b"no model", b'name = "a"\nunknown = 1\n', b""):
        path = tmp_path / "model.toml"
        path.write_bytes(old)
        save_model(spring_mass_damper(), path)
        assert load_model(path) == spring_mass_damper()
        assert path.with_name("model.toml.bak").read_bytes() == old


def test_line_ends_of_windows(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_bytes(b"\xef\xbb\xbf" + COMMENTED.replace("\n", "\r\n").encode())
    assert load_model(path) == model_from_toml(COMMENTED)
    with pytest.raises(ModelError, match="model.toml:9, body A, mass"):
        path.write_bytes(COMMENTED.replace('mass = "m"', 'mass = "M"').replace("\n", "\r\n").encode())
        load_model(path)


def test_layout_is_replaced_on_request() -> None:
    text = model_to_toml(
        model_from_toml(COMMENTED), onto=COMMENTED, layout={"B": {"x": 1, "path": [[0, 1], [2, 3]]}}
    )
    assert read_layout(text) == {"B": {"x": 1, "path": [[0, 1], [2, 3]]}}
    assert "# mass of A" in text
    assert read_layout(model_to_toml(spring_mass_damper(), layout={})) == {}
    assert to_data(spring_mass_damper(), layout={"a": 1})["layout"] == {"a": 1}


def test_layout_that_toml_cannot_say() -> None:
    deep: dict[str, object] = {}
    for _ in range(5000):
        deep = {"a": deep}
    for layout in ({"x": None}, {"x": object()}, deep):
        with pytest.raises(FormatError, match="file.layout"):
            model_to_toml(spring_mass_damper(), layout=layout)


# --- data ------------------------------------------------------------------------------------------------


def test_null_is_left_out_and_numbers_are_numbers() -> None:
    data = {
        "name": "a",
        "gravity": None,
        "body": [{"name": "A", "mass": 1.5, "inertia": [1, 1.0, "m"], "frames": None}],
        "joint": [{"name": "j", "type": "weld", "between": ["ground", "A"], "tree": None}],
        "parameters": {"m": None, "k": 9.81},
    }
    model = from_data(data)
    assert model.body("A").mass.text == "1.5" and model.parameters["m"] is None
    assert model == Model(
        "a", [Body("A", 1.5, (1, 1.0, "m")), Weld("j", "ground", "A")], parameters={"m": None, "k": 9.81}
    )


@pytest.mark.parametrize(
    ("data", "where"),
    [
        ({"name": "a", "body": [{"name": "A", "mas": 1}]}, "#/body/0/mas, body A, mas"),
        ({"name": "a", "body": [{"name": "A", "mass": "1+"}]}, "#/body/0/mass, body A, mass, column 3"),
        ({"name": "a", "gravity": [0, "G", 0]}, "#/gravity/1, gravity[1], column 1"),
        ({"name": "a", "parameters": {"m": float("inf")}}, "#/parameters/m, parameters.m"),
        ({}, "#/name, name"),
        ([], "#"),
        (None, "#"),
        ("name", "#"),
    ],
)
def test_faults_of_data_have_pointers(data: object, where: str) -> None:
    with pytest.raises(SymbodyError) as caught:
        from_data(data)
    assert caught.value.problems[0].where == where


# --- texts that are too much -----------------------------------------------------------------------------


TOO_MUCH = {
    "deep list": "x = " + "[" * 100_000,
    "deep closed list": "x = " + "[" * 20_000 + "]" * 20_000,
    "deep tables": "x = " + "{a = " * 20_000 + "1" + "}" * 20_000,
    "deep layout": "name = 'a'\nlayout.x = " + "[" * 20_000 + "]" * 20_000,
    "long key": "name = 'a'\n" + "a." * 3_000 + "b = 1",
    "long header": "[" + "a." * 3_000 + "b]",
    "digits": "name = 'a'\n[parameters]\nm = " + "9" * 5_000,
    "decimal digits": "name = 'a'\n[parameters]\nm = 1." + "9" * 5_000,
    "huge exponent": "name = 'a'\n[parameters]\nm = 1e400",
    "monstrous exponent": "name = 'a'\n[parameters]\nm = 1e99999999999999999999",
    "deep formula": "name = 'a'\n[parameters]\nm = '" + "(" * 3_000 + "1" + ")" * 3_000 + "'",
    "long formula": "name = 'a'\n[parameters]\nm = '1" + "+1" * 20_000 + "'",
    "power tower": "name = 'a'\n[parameters]\nm = '9**9**9'",
    "unclosed string": "name = 'a'\nx = \"" + "a" * 1_000_000,
    "unclosed long string": "name = 'a'\nx = '''" + "\\n" * 500_000,
    "carriage returns": "name = 'a'\rx = 1",
    "many unknown keys": "name = 'a'\n" + "".join(f"k{k} = 1\n" for k in range(5_000)),
    "many bad bodies": "name = 'a'\n" + "[[body]]\n" * 5_000,
}


@pytest.mark.parametrize("kind", TOO_MUCH)
def test_too_much_is_refused_quickly(kind: str) -> None:
    with limited(2), pytest.raises(SymbodyError) as caught:  # promised for any input
        model_from_toml(TOO_MUCH[kind], where="model.toml")
    assert len(str(caught.value)) < 100_000
