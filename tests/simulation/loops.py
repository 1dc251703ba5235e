"""Mechanisms for tests of integrators: a pendulum in x, y and angle held by a pin, and damped sliders."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import symbody as sb
from symbody.formats import model_from_toml

EXAMPLES = Path(__file__).parents[2] / "examples"

_BOB = """
name = "pendulum"
gravity = ["0", "-9.81", "0"]
inputs = ["T"]
[[body]]
name = "Bob"
mass = 2.0
inertia = ["0", "0", "0.5"]
[body.frames]
pivot = { at = ["0", "1", "0"] }
"""
_PIN = """
[[joint]]
name = "pin"
type = "revolute"
between = ["ground", "Bob.pivot"]
axis = "z"
"""
_FLIGHT = """
[[joint]]
name = "flight"
type = "planar"
between = ["ground", "Bob"]
coordinates = ["x", "y", "theta"]
[initial]
x = 1.0
y = 0.0
theta = "90 deg"
"""
_SLIDER = """
name = "slider"
gravity = ["0", "0", "0"]
inputs = ["F"]
[parameters]
m = 1.0
d = 1e6
k = 1e6
[[body]]
name = "Mass"
mass = "m"
[[joint]]
name = "slider"
type = "prismatic"
between = ["ground", "Mass"]
axis = "x"
coordinate = "x"
force = { stiffness = "k", damping = "d", applied = "F" }
[initial]
x = 1.0
"""


def pushed_mass(law: str, x: float, x_dot: float) -> sb.EquationSet:
    """A mass of 1 kg on a slide, pushed by a law in t, x and x_dot; released at a given state."""
    body, push = sb.Body("Mass", mass=1), sb.Drive(applied=law)
    slider = sb.Prismatic("slider", "ground", body, axis="x", coordinate="x", force=push)
    return sb.form_equations(sb.Model("pushed", [body, slider], initial={"x": x, "x_dot": x_dot}))


@cache
def held_pendulum() -> sb.EquationSet:
    """Three coordinates, two constraints; released where it hangs sideways."""
    return _flying(_BOB + _PIN + _FLIGHT)


@cache
def twice_held_pendulum() -> sb.EquationSet:
    """The same with a second pin on the axis of the first, which adds nothing."""
    second = _PIN.replace('"pin"', '"pin2"').replace('"ground"', '"ground.post"').replace("pivot", "far")
    far = 'far = { at = ["0", "1", "0.5"] }\n[ground.frames]\npost = { at = ["0", "0", "0.5"] }\n'
    return _flying(_BOB + far + _PIN + second + _FLIGHT)


def _flying(text: str) -> sb.EquationSet:
    return sb.form_equations(
        model_from_toml(text), tree=sb.Trees(rotation=["flight"], translation=["flight"])
    )


@cache
def turning_pendulum() -> sb.EquationSet:
    """The same pendulum with its angle as the one coordinate."""
    return sb.form_equations(
        model_from_toml(f'{_BOB}{_PIN}coordinate = "theta"\n[initial]\ntheta = "90 deg"\n')
    )


@cache
def damped_slider() -> sb.EquationSet:
    """``m x'' + d x' + k x = F`` with time constants of 1 us and 1 s."""
    return sb.form_equations(model_from_toml(_SLIDER))


@cache
def overstretched() -> sb.EquationSet:
    """Crank and rod of 0.1 mm are straight at 0.5 s, and their slider is drawn on; beside them hangs a pendulum.

    In metres the constraints of the pendulum change 1e4 times as much with x and y as others with angles.
    """
    bodies = [
        sb.Body("Crank", mass=1, inertia=(0, 0, 1e-8), frames={"B": sb.Frame(at=(1e-4, 0, 0))}),
        sb.Body("Rod", mass=1, inertia=(0, 0, 1e-8), frames={"C": sb.Frame(at=(1e-4, 0, 0))}),
        sb.Body("Slider", mass=1),
        sb.Body("Bob", mass=1, inertia=(0, 0, 1e-8), frames={"pivot": sb.Frame(at=(0, 1e-4, 0))}),
    ]
    joints = [
        sb.Revolute("A", "ground", "Crank", coordinate="theta"),
        sb.Revolute("B", "Crank.B", "Rod", coordinate="beta"),
        sb.Prismatic("D", "ground", "Slider", coordinate="s", motion="1e-4*(1.5 + t)"),
        sb.Revolute("C", "Rod.C", "Slider", tree=False),
        sb.Planar("flight", "ground", "Bob", coordinates=["x", "y", "phi"]),
        sb.Revolute("pin", "ground", "Bob.pivot", tree=False),
    ]
    return sb.form_equations(sb.Model("overstretched", [*bodies, *joints]))


@cache
def example(name: str) -> sb.EquationSet:
    """The equations of an example."""
    return sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))
