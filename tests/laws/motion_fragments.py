"""Sixteen mechanisms that do not touch each other, each with one thing that may happen to a motion.

Any of them stand together in one model, under one gravity, and each has values that are known without symbody: a
closed form, or a solution of equations that are written by hand. A scale is the size of what is added up in a value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb

Array = NDArray[np.float64]
Values = dict[str, Array]
G = 9.81
END = 1.0
TIMES = np.linspace(0.0, END, 21)


@dataclass(frozen=True, eq=False)
class Fragment:
    """A mechanism with one thing that happens to it.

    Attributes
    ----------
    parts : tuple of elements
        With names that no other fragment has.
    reference : callable
        Values at times, by name; not of speeds alone, since these need not be compared.
    scales : mapping
        Size of each value.
    jumps : callable
        Times at which speeds jump, where either side is right.
    laws : callable
        Laws of its inputs, from the equations and the path of the controller.
    freely : str
        A coordinate to which any number may be added, and no other value changes.
    end : float
        When it ends the motion.
    force_jump : float
        By how much an acceleration jumps inside of a step of fixed length.
    """

    name: str
    parts: tuple[Any, ...]
    reference: Callable[[Array], Values]
    scales: Mapping[str, float]
    initial: Mapping[str, float] = field(default_factory=dict)
    jumps: tuple[float, ...] = ()
    inputs: tuple[str, ...] = ()
    laws: Callable[[sb.EquationSet, Path | None], dict[str, Any]] = lambda eqs, path: {}
    events: tuple[sb.Event, ...] = ()
    freely: str = ""
    end: float = math.inf
    force_jump: float = 0.0


def slide(name: str, coordinate: str, axis: str = "x", **more: Any) -> tuple[Any, ...]:
    """A body of 1 kg that slides on the ground."""
    return (
        sb.Body(f"{name} body", mass=1),
        sb.Prismatic(name, "ground", f"{name} body", axis=axis, coordinate=coordinate, **more),
    )


def oscillator() -> Fragment:
    """a'' = -36 a."""
    return Fragment(
        "oscillator", slide("spring", "a", force=sb.Drive(stiffness=36)),
        lambda t: {"a": 0.3 * np.cos(6 * t), "a_dot": -1.8 * np.sin(6 * t)},
        {"a": 0.3, "a_dot": 1.8}, {"a": 0.3},
    )  # fmt: skip


def dry_block() -> Fragment:
    """b'' = 4 t - 0.2 g until it stops; it breaks away where the pull 4 t is 0.3 g.

    b' = 0.3 - 0.2 g t + 2 t^2 passes zero at t_1; behind t_2 = 0.075 g it is 2 (t^2 - t_2^2) - 0.2 g (t - t_2).
    """
    mu = 0.2 * G
    stops = (mu - math.sqrt(mu * mu - 8 * 0.3)) / 4
    breaks = 0.3 * G / 4

    def reference(t: Array) -> Values:
        first, after = np.minimum(t, stops), np.maximum(t, breaks)
        slid = 0.3 * first - mu * first**2 / 2 + 2 * first**3 / 3
        s = after - breaks
        # 2 (t^2 - t_2^2) = 2 s^2 + 4 t_2 s
        slid += 2 * s**3 / 3 + (4 * breaks - mu) * s**2 / 2
        rate = 0.3 - mu * first + 2 * first**2
        return {"b": slid, "b_dot": np.where(t < stops, rate, 2 * s**2 + (4 * breaks - mu) * s)}

    friction = sb.Friction(0.2, mu_static=0.3)
    return Fragment(
        "dry block", slide("dry", "b", friction=friction, force=sb.Drive(applied="4*t")),
        reference, {"b": 0.3, "b_dot": 1.0}, {"b": 0.0, "b_dot": 0.3}, freely="b",
    )  # fmt: skip


@cache
def swing(t_taut: float) -> Any:
    """The ball on its taut rope of 0.8 m: its angle from below, from the time at which it is caught."""
    angle = math.asin(0.6 / 0.8)
    rate = -G * t_taut * math.sin(angle) / 0.8  # the part of the speed along the circle stays
    return solve_ivp(
        lambda t, y: [y[1], -G / 0.8 * math.sin(y[0])], (t_taut, END), [angle, rate], "DOP853",
        rtol=1e-13, atol=1e-13, dense_output=True,
    ).sol  # fmt: skip


def ball_on_rope() -> Fragment:
    """A ball that falls from (0.6, -0.2) until its rope of 0.8 m catches it, and then swings.

    Its angle stays below that at which it was caught, so that the rope pulls: v^2/0.8 + g cos(angle) > 0.
    """
    low = math.sqrt(0.8**2 - 0.6**2)
    taut = math.sqrt(2 * (low - 0.2) / G)

    def reference(t: Array) -> Values:
        angle, rate = swing(taut)(np.maximum(t, taut))
        flies = t < taut
        return {
            "rx": np.where(flies, 0.6, 0.8 * np.sin(angle)),
            "ry": np.where(flies, -0.2 - G * t**2 / 2, -0.8 * np.cos(angle)),
            "rx_dot": np.where(flies, 0.0, 0.8 * np.cos(angle) * rate),
            "ry_dot": np.where(flies, -G * t, 0.8 * np.sin(angle) * rate),
        }

    parts = (
        sb.Body("Ball", mass=0.7),
        sb.Rectangular("flight", "ground", "Ball", coordinates=["rx", "ry"]),
        sb.Distance("rope", "ground", "Ball", 0.8, rope=True),
    )
    return Fragment(
        "ball on a rope", parts, reference, {"rx": 0.8, "ry": 0.8, "rx_dot": 3.0, "ry_dot": 3.0},
        {"rx": 0.6, "ry": -0.2, "rx_dot": 0.0, "ry_dot": 0.0}, (taut,),
    )  # fmt: skip


def hops(height: float, share: float) -> list[tuple[float, float]]:
    """Time and speed after each bounce of a ball that falls from rest, until the end."""
    t, v = math.sqrt(2 * height / G), share * math.sqrt(2 * G * height)
    found = []
    while t < END:
        found.append((t, v))
        t, v = t + 2 * v / G, share * v
    return found


def bounce() -> Fragment:
    """h falls from 0.3, and each time that it passes 0 its rate turns and loses a fifth."""
    known = hops(0.3, 0.8)

    def reference(t: Array) -> Values:
        h, rate = 0.3 - G * t**2 / 2, -G * t
        for start, v in known:
            s, after = t - start, t >= start
            h, rate = np.where(after, v * s - G * s**2 / 2, h), np.where(after, v - G * s, rate)
        return {"h": h, "h_dot": rate}

    return Fragment(
        "bounce", slide("hop", "h", "y"), reference, {"h": 0.3, "h_dot": 3.0}, {"h": 0.3},
        tuple(t for t, _ in known), events=(sb.Event("h", -1, {"h_dot": "-0.8*h_dot"}, "floor"),),
    )  # fmt: skip


def ball_on_stop() -> Fragment:
    """As `bounce` from 0.25, by a stop with a restitution of 0.7."""
    known = hops(0.25, 0.7)

    def reference(t: Array) -> Values:
        h, rate = 0.25 - G * t**2 / 2, -G * t
        for start, v in known:
            s, after = t - start, t >= start
            h, rate = np.where(after, v * s - G * s**2 / 2, h), np.where(after, v - G * s, rate)
        return {"fall": h, "fall_dot": rate}

    parts = (*slide("drop", "fall", "y"), sb.Stop("ground plate", "fall", restitution=0.7))
    return Fragment(
        "ball on a stop",
        parts,
        reference,
        {"fall": 0.25, "fall_dot": 3.0},
        {"fall": 0.25},
        tuple(t for t, _ in known),
    )


@cache
def puck_path() -> Any:
    """A puck pressed against an upright wall, thrown up and to the left: its velocity turns by more than 90 degrees."""

    def rates(_: float, y: Array) -> Array:
        speed = math.hypot(y[2], y[3])
        return np.array([y[2], y[3], -3.0 * y[2] / speed, -G - 3.0 * y[3] / speed])

    return solve_ivp(
        rates, (0.0, END), [0.0, 0.0, -2.0, 3.0], "DOP853", rtol=1e-13, atol=1e-13, dense_output=True
    ).sol


def puck_on_wall() -> Fragment:
    """A puck of 0.5 kg pressed by 6 N against a rigid wall with mu = 0.25."""

    def reference(t: Array) -> Values:
        px, py, vx, vy = puck_path()(t)
        return {"px": px, "py": py, "px_dot": vx, "py_dot": vy}

    parts = (
        sb.Body("Puck carrier"),
        sb.Body("Puck", mass=0.5),
        sb.Prismatic(
            "press", "ground", "Puck carrier", axis="z", coordinate="pz", force=sb.Drive(applied=-6)
        ),
        sb.Rectangular("glide", "Puck carrier", "Puck", coordinates=["px", "py"]),
        sb.Contact(
            "wall", "ground", "Puck", ["plane", "point"], normal="rigid", friction=sb.Friction(mu=0.25)
        ),
    )
    return Fragment(
        "puck on a wall", parts, reference, {"px": 1.0, "py": 5.0, "px_dot": 2.0, "py_dot": 10.0},
        {"px": 0.0, "py": 0.0, "px_dot": -2.0, "py_dot": 3.0, "pz": 0.0},
    )  # fmt: skip


def rate_that_jumps() -> Fragment:
    """A slide whose rate jumps from 1 to 2 at t = 0.4, and on it a free one, which stays as fast as it was in space."""
    law = "if(t < 0.4, t, 2*t - 0.4)"
    parts = (
        sb.Body("Carrier", mass=1), sb.Body("Rider", mass=1),
        sb.Prismatic("carried", "ground", "Carrier", axis="z", coordinate="p", motion=law),
        sb.Prismatic("ridden", "Carrier", "Rider", axis="z", coordinate="r"),
    )  # fmt: skip
    return Fragment(
        "rate that jumps", parts,
        lambda t: {"r": -np.maximum(t - 0.4, 0.0), "r_dot": np.where(t < 0.4, 0.0, -1.0)},
        {"r": 1.0, "r_dot": 1.0}, {"r": 0.0, "r_dot": 0.0}, (0.4,), freely="r",
    )  # fmt: skip


def held_feedback(coordinate: str, step: float, gains: tuple[float, float]) -> Callable[[Array], Values]:
    """x'' = F with F = -gain x - damping x' of the last sample; x = 0.5, x' = 0 at first."""

    def reference(t: Array) -> Values:
        count = round(END / step)
        x, v, states = 0.5, 0.0, []
        for _ in range(count + 1):
            F = -gains[0] * x - gains[1] * v
            states.append((x, v, F))
            x, v = x + v * step + F * step**2 / 2, v + F * step
        # a sample at its own time, which may be rounded to before it
        k = np.minimum(np.floor(t / step + 1e-9).astype(int), count)
        x, v, F = np.array(states)[k].T
        s = t - k * step
        return {coordinate: x + v * s + F * s**2 / 2, f"{coordinate}_dot": v + F * s}

    return reference


def sampled_controller() -> Fragment:
    """c'' = -9 c - 3 c' of every tenth of a second."""
    parts = (
        *slide("servo", "c", force=sb.Drive(applied="hold")), sb.Signal("hold", "-9*c - 3*c_dot", sample=0.1),
    )  # fmt: skip
    return Fragment(
        "sampled controller", parts, held_feedback("c", 0.1, (9, 3)), {"c": 0.5, "c_dot": 1.5}, {"c": 0.5}
    )


def save_controller(path: Path) -> Path:
    """Write an FMU whose output is F = -16 x - 4 v."""
    model = sb.Model("controller", [sb.Signal("F", "-16*x - 4*v")], inputs=["x", "v"])
    return sb.save_fmu(sb.form_equations(model), path, outputs=["F"], sources=False).path


def fmu_input() -> Fragment:
    """f'' = -16 f - 4 f', computed by an FMU every twentieth of a second."""

    def laws(eqs: sb.EquationSet, path: Path | None) -> dict[str, Any]:
        return {"F_fmu": sb.FmuInput(str(path), "F", {"x": "f", "v": "f_dot"}, 0.05)}

    return Fragment(
        "FMU input", slide("controlled", "f", "z", force=sb.Drive(applied="F_fmu")),
        held_feedback("f", 0.05, (16, 4)), {"f": 0.5, "f_dot": 2.0}, {"f": 0.5}, inputs=("F_fmu",), laws=laws,
    )  # fmt: skip


def table_that_jumps() -> Fragment:
    """d'' is 1 before 0.35 and -2 behind."""
    table = sb.Lookup("push", points=[[0, 1], [0.35, 1], [0.35, -2], [2, -2]])

    def reference(t: Array) -> Values:
        s = np.maximum(t - 0.35, 0.0)
        return {"d": t**2 / 2 - 3 * s**2 / 2, "d_dot": t - 3 * s}

    return Fragment(
        "table that jumps", (*slide("pushed", "d", force=sb.Drive(applied="push")), table), reference,
        {"d": 0.5, "d_dot": 1.0}, {"d": 0.0}, freely="d", force_jump=3.0,
    )  # fmt: skip


def python_input() -> Fragment:
    """n'' = -16 n, by a function of q."""

    def laws(eqs: sb.EquationSet, path: Path | None) -> dict[str, Any]:
        k = eqs.coordinate_names.index("n")
        return {"F_python": lambda t, q, u: -16.0 * q[k]}

    return Fragment(
        "Python input", slide("driven", "n", "z", force=sb.Drive(applied="F_python")),
        lambda t: {"n": 0.4 * np.cos(4 * t), "n_dot": -1.6 * np.sin(4 * t)},
        {"n": 0.4, "n_dot": 1.6}, {"n": 0.4}, inputs=("F_python",), laws=laws,
    )  # fmt: skip


def gears() -> Fragment:
    """e = 2 g; a torque 0.9 on e turns 0.2 + 0.1/4 of inertia. The model is formed with the row or without it."""
    parts = (
        sb.Body("Pinion", mass=1, inertia=(0, 0, 0.2)), sb.Body("Wheel", mass=1, inertia=(0, 0, 0.1)),
        sb.Revolute("pinion pin", "ground", "Pinion", coordinate="e", torque=sb.Drive(applied=0.9)),
        sb.Revolute("wheel pin", "ground", "Wheel", coordinate="g"), sb.Gear("mesh", ["e", "g"], 2),
    )  # fmt: skip
    return Fragment(
        "gears", parts, lambda t: {"e": 2 * t**2, "e_dot": 4 * t, "g": t**2, "g_dot": 2 * t},
        {"e": 2.0, "e_dot": 4.0, "g": 1.0, "g_dot": 2.0}, {"e": 0.0, "e_dot": 0.0},
    )  # fmt: skip


def crank_slope(angle: complex) -> tuple[complex, complex]:
    """Twice the kinetic energy at a unit rate, and the potential energy, of the slider-crank at an angle.

    A crank of 0.3 m with 0.05 kg m^2 about its pin, balanced; a rod of 1 m, 0.5 kg, 0.04 kg m^2 about its middle;
    a slider of 1 kg. The rod leans by asin(0.3 sin(angle)).
    """
    lean = 0.3 * np.sin(angle)
    along = np.sqrt(1 - lean * lean)
    lean_rate = 0.3 * np.cos(angle) / along
    slider = -0.3 * np.sin(angle) - lean * lean_rate
    middle_x, middle_y = -0.3 * np.sin(angle) - 0.5 * lean * lean_rate, 0.15 * np.cos(angle)
    inertia = 0.05 + 0.5 * (middle_x**2 + middle_y**2) + 0.04 * lean_rate**2 + slider**2
    return inertia, 0.5 * G * 0.15 * np.sin(angle)


@cache
def crank() -> Any:
    """Its angle: A z'' = -A' z'^2 / 2 - V', with derivatives by complex steps."""

    def rate(t: float, y: Array) -> list[float]:
        A, V = crank_slope(y[0] + 1e-30j)
        return [y[1], -(A.imag * 1e30 * y[1] ** 2 / 2 + V.imag * 1e30) / A.real]

    return solve_ivp(rate, (0, END), [0.4, 5.0], "DOP853", rtol=1e-13, atol=1e-13, dense_output=True).sol


def closed_loop() -> Fragment:
    """A slider-crank that turns."""
    parts = (
        sb.Body("Crank", mass=1, inertia=(0, 0, 0.05), frames={"tip": sb.Frame(at=(0.3, 0, 0))}),
        sb.Body("Rod", mass=0.5, inertia=(0, 0, 0.04),
                frames={"big": sb.Frame(at=(-0.5, 0, 0)), "small": sb.Frame(at=(0.5, 0, 0))}),
        sb.Body("Slider", mass=1),
        sb.Revolute("main pin", "ground", "Crank", coordinate="z"),
        sb.Revolute("crank pin", "Crank.tip", "Rod.big", coordinate="zr"),
        sb.Prismatic("guide", "ground", "Slider", axis="x", coordinate="zs"),
        sb.Revolute("slider pin", "Slider", "Rod.small", coordinate="zp", tree=False),
    )  # fmt: skip

    def reference(t: Array) -> Values:
        angle, rate = crank()(t)
        return {"z": angle, "z_dot": rate, "zs": 0.3 * np.cos(angle) + np.sqrt(1 - 0.09 * np.sin(angle) ** 2)}

    # the angle grows to some 5 rad, and errors of its rate with it
    scales = {"z": 5.0, "z_dot": 10.0, "zs": 1.3}
    closed = {
        "z": 0.4,
        "zr": -0.4 - math.asin(0.3 * math.sin(0.4)),
        "zs": float(reference(np.zeros(1))["zs"][0]),
    }
    return Fragment("closed loop", parts, reference, scales, closed | {"z_dot": 5.0})


def lag() -> Fragment:
    """A lag of 0.3 s follows 1, and its value pushes: l'' = 1 - exp(-t/0.3)."""
    parts = (*slide("lagging", "l", force=sb.Drive(applied="late")), sb.FirstOrder("late", "1", 0.3))

    def reference(t: Array) -> Values:
        gone = 1 - np.exp(-t / 0.3)
        return {"late": gone, "l": t**2 / 2 - 0.3 * t + 0.09 * gone, "l_dot": t - 0.3 * gone}

    return Fragment("lag", parts, reference, {"late": 1.0, "l": 0.5, "l_dot": 1.0}, {"l": 0.0}, freely="l")


def stop_event() -> Fragment:
    """w = 0.3 t, and where it is 0.283 the motion ends."""
    return Fragment(
        "stop event", slide("watched", "w", "z"), lambda t: {"w": 0.3 * t, "w_dot": np.full_like(t, 0.3)},
        {"w": 0.3, "w_dot": 0.3}, {"w": 0.0, "w_dot": 0.3}, events=(sb.Event("w - 0.283", 1, "stop", "arrived"),),
        end=0.283 / 0.3,
    )  # fmt: skip


def measured_angle() -> Fragment:
    """A disc in the plane turns by 8 t, and a cut joint measures its angle, turns included."""
    parts = (
        sb.Body("Disc", mass=1, inertia=(1, 1, 1)),
        sb.Planar("plane", "ground", "Disc", coordinates=["mx", "my", "mt"]),
        sb.Revolute("measure", "ground", "Disc", axis="z", coordinate="m", tree=False),
    )
    return Fragment(
        "measured angle", parts, lambda t: {"mt": 8 * t, "mt_dot": np.full_like(t, 8.0), "m": 8 * t},
        {"mt": 8.0, "mt_dot": 8.0, "m": 8.0}, {"mx": 0.0, "my": 0.0, "mt": 0.0, "mt_dot": 8.0},
    )  # fmt: skip


def product(a: Array, b: Array) -> Array:
    """The product of quaternions (4, ...)."""
    return np.array([
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    ])  # fmt: skip


def quaternion() -> Fragment:
    """A symmetric top on its centre: it turns about its momentum by |L|/A and about itself by c (1 - C/A).

    A = 2, C = 1 kg m^2; at first the axes are those of space and its angular velocity is (3, 0, 4).
    """

    def reference(t: Array) -> Values:
        momentum = np.array([2.0 * 3.0, 0.0, 4.0])
        size = float(np.linalg.norm(momentum))
        half, own, still = size * t / 4, t, np.zeros_like(t)  # half of 4 (1 - 1/2) t
        sine = np.sin(half) / size
        whole = np.array([np.cos(half), momentum[0] * sine, still, momentum[2] * sine])
        q = product(whole, np.array([np.cos(own), still, still, np.sin(own)]))
        return dict(zip(("qw", "qx", "qy", "qz"), q, strict=True))

    parts = (
        sb.Body("Top", mass=1, inertia=(2, 2, 1)),
        sb.Spherical("ball joint", "ground", "Top", coordinates=["qw", "qx", "qy", "qz"], speeds="end",
                     speed_names=["ox", "oy", "oz"]),
    )  # fmt: skip
    # the angle turned is up to 5, which errors of the speeds grow with
    return Fragment(
        "quaternion", parts, reference, dict.fromkeys(("qw", "qx", "qy", "qz"), 5.0),
        {"qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "ox": 3.0, "oy": 0.0, "oz": 4.0},
    )  # fmt: skip


def smooth_contact() -> Fragment:
    """k falls from 0.15 on a spring of 500 N/m: parabolas, and between them k'' = -500 k - g below 0."""
    K = 500.0
    w = math.sqrt(K)
    fall, v = math.sqrt(0.3 / G), math.sqrt(0.3 * G)
    # k = (cos(w s) - 1) g/K - sin(w s) v/w comes back to 0 where tan(w s/2) = -v w/g
    below = 2 * (math.pi - math.atan(v * w / G)) / w

    def reference(t: Array) -> Values:
        s = (t + fall) % (2 * fall + below) - fall  # from the last time at the top
        c = np.maximum(s - fall, 0.0)
        spring = (np.cos(w * c) - 1) * G / K - np.sin(w * c) * v / w
        spring_rate = -np.sin(w * c) * G / w - np.cos(w * c) * v
        flies = s < fall
        return {
            "k": np.where(flies, 0.15 - G * s**2 / 2, spring),
            "k_dot": np.where(flies, -G * s, spring_rate),
        }

    force = sb.Drive(applied=f"if(k < 0, -{K}*k, 0)")
    # A contact turns an error of place into one of speed 22 times as large, and the flight of 0.35 s behind it that into
    # one of place 8 times as large; two contacts begin before the end.
    return Fragment(
        "smooth contact", slide("landing", "k", "y", force=force), reference, {"k": 8.0, "k_dot": 170.0},
        {"k": 0.15},
    )  # fmt: skip


FRAGMENTS = {
    fragment.name: fragment
    for fragment in (
        oscillator(), dry_block(), ball_on_rope(), ball_on_stop(), puck_on_wall(), bounce(), rate_that_jumps(), sampled_controller(), fmu_input(),
        table_that_jumps(), python_input(), gears(), closed_loop(), lag(), stop_event(), measured_angle(),
        quaternion(), smooth_contact(),
    )
}  # fmt: skip


@cache
def equations_of(fragments: tuple[Fragment, ...], substitute: bool = False) -> sb.EquationSet:
    """The equations of fragments beside each other."""
    initial = {key: value for fragment in fragments for key, value in fragment.initial.items()}
    model = sb.Model(
        "combined", [part for fragment in fragments for part in fragment.parts], (0, -G, 0), {},
        [word for fragment in fragments for word in fragment.inputs], initial,
    )  # fmt: skip
    return sb.form_equations(model, substitute=substitute)
