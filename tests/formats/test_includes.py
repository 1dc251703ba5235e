"""Parts of models: the same equations as those written out by hand, files, and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.errors import SymbodyError
from symbody.formats.native import from_data, model_from_toml, model_to_toml, to_data

ARM = """\
name = "arm"
inputs = ["T"]
[parameters]
g = 9.81
m = 1.0
L = 0.5
c = 0.1
k = 3.0
[ground.frames]
post = { at = ["0", "h", "0"] }
[[body]]
name = "Link"
mass = "m"
inertia = ["0", "0", "m*L^2/12"]
[body.frames]
base = { at = ["-L/2", "0", "0"] }
tip = { at = ["L/2", "0", "0"] }
[[joint]]
name = "hip"
type = "revolute"
between = ["ground", "Link.base"]
coordinate = "q"
torque = { applied = "T - c*q_dot - height" }
[[spring]]
name = "stay"
between = ["ground.post", "Link.tip"]
stiffness = "k"
[[force]]
name = "weight"
on = "Link"
vector = ["0", "-m*g", "0"]
[[signal]]
name = "height"
output = "frame r Link.tip ground ground y"
[[signal]]
name = "lag"
rate = "(q - lag)/0.1"
[initial]
q = 0.3
""".replace('"h"', '"0.4"')
CAR = """\
name = "car"
inputs = ["u"]
[parameters]
w = 0.6
g = 9.0
[[body]]
name = "Chassis"
mass = 5.0
inertia = ["0", "0", "1"]
[body.frames]
front = { at = ["w", "0", "0"] }
rear = { at = ["-w", "0.1", "0"], rotate = [["z", "pi/6"]] }
[[joint]]
name = "slide"
type = "prismatic"
between = ["ground", "Chassis"]
axis = "x"
coordinate = "x"
"""
INCLUDES = """\
[[include]]   # at the front
file = "parts/arm.toml"
prefix = "F"
at = "Chassis.front"
share = ["g"]
connect = { T = "u" }

[[include]]
file = "parts/arm.toml"
prefix = "R"
at = "Chassis.rear"
share = ["g"]
connect = { T = "2*u - x", height = "tip_height" }
parameters = { L = "0.4*w", m = 2.0 }
"""


def write(folder: Path, includes: str = INCLUDES, arm: str = ARM) -> Path:
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "arm.toml").write_text(arm, encoding="utf-8")
    path = folder / "car.toml"
    path.write_text(CAR + includes, encoding="utf-8")
    return path


def by_hand(names: dict[str, tuple[str, float]]) -> sb.Model:
    """The car with arms on its frames, every element written out; values are torque and length."""
    elements: list[object] = []
    chassis = sb.Body(
        "Chassis", mass=5, inertia=(0, 0, 1),
        frames={**{f"f{p}": sb.Frame(at=(f"{x}*w", 0, 0)) for p, (_, x) in names.items()},
                **{f"{p}_post": sb.Frame(at=(f"{x}*w", "0.4", 0)) for p, (_, x) in names.items()}},
    )  # fmt: skip
    links, joints, springs, forces, signals = [], [], [], [], []
    values: dict[str, object] = {"w": 0.6, "g": 9.0}
    for p, (torque, _) in names.items():
        values |= {f"{p}_m": "1.0", f"{p}_L": "0.5", f"{p}_c": "0.1", f"{p}_k": "3.0"}
        links.append(
            sb.Body(f"{p}_Link", mass=f"{p}_m", inertia=(0, 0, f"{p}_m*{p}_L^2/12"),
                    frames={"base": sb.Frame(at=(f"-{p}_L/2", 0, 0)), "tip": sb.Frame(at=(f"{p}_L/2", 0, 0))})
        )  # fmt: skip
        drive = sb.Drive(f"{torque} - {p}_c*{p}_q_dot - {p}_height")
        base = f"Chassis.f{p}"
        joints.append(sb.Revolute(f"{p}_hip", base, f"{p}_Link.base", coordinate=f"{p}_q", torque=drive))
        springs.append(sb.SpringDamper(f"{p}_stay", f"Chassis.{p}_post", f"{p}_Link.tip", stiffness=f"{p}_k"))
        vector = (0, f"-{p}_m*g", 0)
        forces.append(sb.Force(f"{p}_weight", f"{p}_Link", vector=vector, reaction_on=base, resolved_in=base))
        signals += [
            sb.Signal(f"{p}_height", output=f"frame r {p}_Link.tip {base} {base} y"),
            sb.Signal(f"{p}_lag", rate=f"({p}_q - {p}_lag)/0.1"),
        ]
    slide = sb.Prismatic("slide", "ground", chassis, axis="x", coordinate="x")
    elements = [chassis, *links, slide, *joints, *springs, *forces, *signals]
    initial = {f"{p}_q": 0.3 for p in names}
    return sb.Model("car", elements, parameters=values, inputs=["u"], initial=initial)


def test_an_arm_four_times_is_the_model_written_out() -> None:
    arm = model_from_toml(ARM)
    names = {"A": ("u", 1.0), "B": ("u", -1.0), "C": ("u", 0.5), "D": ("u", -0.5)}
    frames = {f"f{p}": sb.Frame(at=(f"{x}*w", 0, 0)) for p, (_, x) in names.items()}
    chassis = sb.Body("Chassis", mass=5, inertia=(0, 0, 1), frames=frames)
    parts = [sb.Include(arm, p, at=f"Chassis.f{p}", connect={"T": "u"}, share=["g"]) for p in names]
    slide = sb.Prismatic("slide", "ground", chassis, axis="x", coordinate="x")
    model = sb.Model("car", [chassis, slide, *parts], parameters={"w": 0.6, "g": 9.0}, inputs=["u"])
    written = by_hand(names)
    assert model.elements == written.elements
    assert model.parameters == written.parameters and model.initial == written.initial
    included, plain = sb.form_equations(model), sb.form_equations(written)
    assert included.text() == plain.text()
    assert included.state_names == plain.state_names
    texts = [sb.generate_code(eqs, "xdot", "c") for eqs in (included, plain)]
    assert texts[0] == texts[1]
    laws = {"u": "sin(3*t)"}
    runs = [sb.simulate(eqs, 0.5, inputs=laws) for eqs in (included, plain)]
    np.testing.assert_array_equal(runs[0].q, runs[1].q)


def test_a_file_includes_a_part_twice(tmp_path: Path) -> None:
    model = sb.load_model(write(tmp_path))
    assert [body.name for body in model.bodies] == ["Chassis", "F_Link", "R_Link"]
    assert model.inputs == ("u",)
    values = {name: formula.text for name, formula in model.parameters.items() if formula is not None}
    assert values["g"] == "9.0" and values["R_L"] == "0.4*w" and values["R_m"] == "2.0"
    assert values["F_m"] == "1.0" and "F_g" not in values
    assert {signal.name for signal in model.signals} == {"F_height", "F_lag", "tip_height", "R_lag", "R_T"}
    eqs = sb.form_equations(model)
    run = sb.simulate(eqs, 0.3, inputs={"u": "sin(t)"})
    np.testing.assert_allclose(run["R_T"], 2 * np.sin(run.t) - run["x"], atol=1e-12)
    # the post of the part stands above the turned frame: (-w, 0.1) + R(30 deg) (0, 0.4)
    post = run["frame r Chassis.R_post Chassis Chassis"][:, 0]
    np.testing.assert_allclose(post, [-0.6 - 0.4 * 0.5, 0.1 + 0.4 * np.cos(np.pi / 6), 0.0], atol=1e-15)
    height = run["frame r R_Link.tip Chassis.rear Chassis.rear y"]
    np.testing.assert_allclose(run["tip_height"], height, atol=1e-14)
    assert abs(run.energy_drift) < 1e-6


def test_saving_keeps_the_include(tmp_path: Path) -> None:
    path = write(tmp_path)
    model = sb.load_model(path)
    before = path.read_text(encoding="utf-8")
    sb.save_model(model, path)
    assert path.read_text(encoding="utf-8") == before
    sb.save_model(model, tmp_path / "copy.toml")
    text = (tmp_path / "copy.toml").read_text(encoding="utf-8")
    assert text.count("[[include]]") == 2 and "F_Link" not in text and "version = 2" in text
    assert sb.load_model(tmp_path / "copy.toml") == model
    assert from_data(to_data(model), folder=str(tmp_path)) == model
    assert len(to_data(model)["include"]) == 2
    alone = model_to_toml(model, is_alone=True)
    assert "[[include]]" not in alone and model_from_toml(alone).elements == model.elements
    changed = sb.Model("car", [*model.elements[:1], *model.elements[1:]], model.gravity, model.parameters,
                       model.inputs, model.initial)  # fmt: skip
    assert "[[include]]" not in model_to_toml(changed)
    (tmp_path / "elsewhere").mkdir()
    with pytest.raises(SymbodyError, match="outside the folder"):
        sb.save_model(model, tmp_path / "elsewhere" / "car.toml")
    sb.simulate(sb.form_equations(model), 0.1, inputs={"u": "0"}).save(tmp_path / "run.npz")
    (tmp_path / "parts" / "arm.toml").unlink()
    assert sb.Trajectory.load(tmp_path / "run.npz")["tip_height"].size > 1


def test_a_file_of_version_1_is_written_without_a_version(tmp_path: Path) -> None:
    (tmp_path / "car.toml").write_text(CAR, encoding="utf-8")
    assert "version" not in model_to_toml(sb.load_model(tmp_path / "car.toml"))
    path = write(tmp_path)
    path.write_text("version = 3\n" + path.read_text())
    with pytest.raises(SymbodyError, match="file.newer_version"):
        sb.load_model(path)


def test_parts_of_parts(tmp_path: Path) -> None:
    axle = """\
name = "axle"
[[body]]
name = "Beam"
mass = 2.0
inertia = ["0", "0", "0.1"]
[body.frames]
left = { at = ["0", "0", "0.5"] }
[[joint]]
name = "mount"
type = "weld"
between = ["ground", "Beam"]
[[include]]
file = "arm.toml"
prefix = "L"
at = "Beam.left"
share = ["g"]
"""
    include = '[[include]]\nfile = "parts/axle.toml"\nprefix = "front"\nat = "Chassis.front"\nshare = ["g"]\n'
    path = write(tmp_path, include)
    (tmp_path / "parts" / "axle.toml").write_text(axle, encoding="utf-8")
    model = sb.load_model(path)
    assert [body.name for body in model.bodies] == ["Chassis", "front_Beam", "front_L_Link"]
    assert model.inputs == ("u", "front_L_T") and "L_post" in model.body("front_Beam").frames
    assert str(model.joint("front_L_hip").start) == "front_Beam.left"
    assert sb.simulate(sb.form_equations(model), 0.1).success
    sb.save_model(model, tmp_path / "copy.toml")
    assert sb.load_model(tmp_path / "copy.toml") == model


def test_drives_of_several_coordinates_and_blocks_keep_their_meaning() -> None:
    slide = sb.Rectangular("slide", "ground", sb.Body("B", mass="d"), coordinates=["x", "y"],
                           force={"x": sb.Drive("servo"), "y": sb.Drive("-d*y_dot")}, motion=None)  # fmt: skip
    servo = sb.PID("servo", "r - x", gains={"p": "d", "d": 0.5, "filter": 0.1})
    part = sb.Model("part", [slide, servo], parameters={"d": 2}, inputs=["r"], initial={"x": 1})
    model = sb.Model(
        "whole", [sb.Include(part, "A", connect={"r": 0}), sb.Include(part, "B", connect={"r": 0})]
    )
    run = sb.simulate(sb.form_equations(model), 1.0)
    alone = sb.simulate(sb.form_equations(part), 1.0, inputs={"r": 0})
    np.testing.assert_allclose(run["A_x"], run["B_x"], atol=1e-14)
    assert run["A_x"][-1] == pytest.approx(alone["x"][-1], rel=1e-6)


def test_parts_in_a_circle(tmp_path: Path) -> None:
    include = '[[include]]\nfile = "leg.toml"\nprefix = "leg"\n'
    path = write(tmp_path, arm=ARM.replace("[initial]", f"{include}\n[initial]"))
    (tmp_path / "parts" / "leg.toml").write_text(ARM + include.replace("leg", "arm"), encoding="utf-8")
    with pytest.raises(SymbodyError, match=r"(?s)include.circle.*arm.toml -> leg.toml -> arm.toml"):
        sb.load_model(path)


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ('"parts/arm.toml"', '"parts/leg.toml"', "file.missing", "car.toml:20"),
        ('"parts/arm.toml"', '"../arm.toml"', "file.outside", "car.toml:20"),
        ('"parts/arm.toml"', '"/etc/hosts"', "file.outside", "car.toml:20"),
        ('"parts/arm.toml"', '"car.toml"', "include.circle", "car.toml:20"),
        ('at = "Chassis.front"', 'at = "Chassis.fornt"', "model.unknown_place", "car.toml:22"),
        ('{ T = "u" }', '{ P = "u" }', "include.connect", "car.toml:24"),
        ('{ T = "u" }', '{ height = "2*u" }', "include.connect", "car.toml:24"),
        ('{ T = "u" }', '{ T = "nothing" }', "names.unknown", "arm.toml:23"),
        ('share = ["g"]', 'share = ["G"]', "include.share", "car.toml:23"),
        ("L = ", "l = ", "include.parameters", "car.toml:32"),
        ('prefix = "R"', 'prefix = "F"', "include.collision", "car.toml:"),
        ('prefix = "F"', 'prefix = "1F"', "names.not_a_symbol", "car.toml:"),
        ("m = 2.0", "m = -2.0", "", "arm.toml:"),
        ('prefix = "F"\n', "", "file.missing_key", "car.toml:"),
        ('prefix = "F"\n', 'prefix = "F"\nevent = 1\n', "file.unknown_key", "car.toml:22"),
    ],
)
def test_faults_name_the_table(tmp_path: Path, old: str, new: str, code: str, place: str) -> None:
    assert old in INCLUDES
    with pytest.raises(SymbodyError) as caught:
        sb.load_model(write(tmp_path, INCLUDES.replace(old, new, 1)))
    problem = caught.value.problems[0]
    assert problem.code == code or not code
    assert place in problem.where, problem
    assert problem.fix


@pytest.mark.parametrize(
    ("old", "new", "code", "line"),
    [
        ('mass = "m"', 'mass = "mm"', "names.unknown", 13),
        ('type = "revolute"', 'type = "hinge"', "file.unknown_type", 18),
        ('name = "arm"', "name = arm", "file.syntax", 1),
        ('mass = "m"', "mass = \"__import__('os').system('x')\"", "expression.attribute", 13),
    ],
)
def test_faults_of_the_part_name_its_file_and_line(
    tmp_path: Path, old: str, new: str, code: str, line: int
) -> None:
    with pytest.raises(SymbodyError) as caught:
        sb.load_model(write(tmp_path, arm=ARM.replace(old, new, 1)))
    found = {problem.code: problem.where for problem in caught.value.problems}
    assert code in found
    assert re.search(rf"parts.arm\.toml:{line}\b", found[code])


def test_what_cannot_be_included() -> None:
    arm = model_from_toml(ARM)
    oblique = sb.Frame(rotate=[((1, 1, 0), "a")])
    body = sb.Body("B", mass=1, inertia=(1, 1, 1), frames={"f": oblique})
    with pytest.raises(SymbodyError, match=r"(?s)include.ground.*oblique axis"):
        sb.Model("m", [body, sb.Include(arm, "A", at="B.f")], parameters={"a": 1})
    with pytest.raises(SymbodyError, match=r"(?s)include.share.*shared and also has"):
        sb.Include(arm, "A", share=["g"], parameters={"g": 1})
    with pytest.raises(SymbodyError, match="did you mean 'T'"):
        sb.Include(arm, "A", connect={"t": "u"})


def test_an_exponent_in_an_output_is_no_symbol() -> None:
    pin = sb.Revolute("pin", "ground", sb.Body("B", 1, (0, 0, 1)), coordinate="e3")
    part = sb.Model("part", [pin, sb.Signal("s", output="2e3*e3 + e3_dot")])
    assert sb.Model("whole", [sb.Include(part, "P")]).signals[0].output == "2e3*P_e3 + P_e3_dot"


def test_a_free_body_of_a_part_that_stands_on_a_frame_needs_a_joint() -> None:
    ground = {"m": sb.Frame(at=(10, 0, 0))}
    spring = sb.SpringDamper("s", "ground", "C", stiffness=10)
    part = sb.Model("part", [sb.Body("C", 1, (1, 1, 1)), spring], initial={"C_x": 1})
    with pytest.raises(SymbodyError, match=r"(?s)include.free.*P_C has no joint.*is at ground.m"):
        sb.Model("whole", [sb.Include(part, "P", at="ground.m")], ground=ground)
    assert sb.Model("whole", [sb.Include(part, "P")], ground=ground).free_joints[0].name == "P_C"
    weld, loose = sb.Weld("w", "ground.m", "P_C"), sb.Model("part", part.elements)
    assert not sb.Model("whole", [weld, sb.Include(loose, "P", at="ground.m")], ground=ground).free_joints


def test_outputs_of_a_part_follow_its_names() -> None:
    """Each is one that the grammar of outputs, not a look at its words, says how to rename."""
    parts = [
        sb.Body("Block", mass="d", frames={"eye": sb.Frame(at=(0, 1, 0))}),
        sb.Prismatic("slider", "ground", "Block", axis="x", friction=sb.Friction(mu=0.2, v0=0.1)),
        sb.Distance("line", "ground", "Block.eye", 3, rope=True),
        sb.Signal("slow", rate="slider - slow"),
    ]
    texts = {
        "friction_normal slider": "friction_normal P_slider",
        "rope_length line": "rope_length P_line",
        "2*lambda_line_1": "2*lambda_P_line_1",
        "d energy/d slider_dot": "d energy/d P_slider_dot",
        "energy": "energy",
        "slow_dot": "lag_dot",
        "sin(d)": "sin(P_d)",
        "frame r eye y": "frame r P_Block.eye Base.mount Base.mount y",
        "frame R eye xy": "frame R P_Block.eye Base.mount xy",
        "slider": "P_slider",  # a coordinate that is named after its joint
    }
    signals = [sb.Signal(f"out_{k}", output=text) for k, text in enumerate(texts)]
    part = sb.Model("part", [*parts, *signals], parameters={"d": 2, "sin": 3})
    base = sb.Body("Base", mass=1, frames={"mount": sb.Frame(at=(1, 0, 0))})
    include = sb.Include(part, "P", at="Base.mount", connect={"slow": "lag"})
    whole = sb.Model("whole", [base, sb.Prismatic("rail", "ground", base, axis="x", coordinate="x"), include])
    outputs = {signal.name: signal.output for signal in whole.signals if signal.output}
    assert outputs == {f"P_out_{k}": text for k, text in enumerate(texts.values())}
    formed = sb.form_equations(whole)
    for text in texts.values():
        assert formed.roots(text).nodes
