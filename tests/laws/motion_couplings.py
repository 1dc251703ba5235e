"""Mechanisms in which two or three things happen to the same coordinate, each with values of its own derivation.

Many are one body of 1 kg on a line under forces that are constant between known times: `Line` adds its parabolas.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb
from tests.laws.motion_fragments import (
    END,
    Array,
    Fragment,
    G,
    Values,
    closed_loop,
    crank_slope,
    hops,
    measured_angle,
    slide,
)

KINETIC, STATIC = 0.2 * G, 0.3 * G
DRY = sb.Friction(0.2, mu_static=0.3)


@dataclass(frozen=True)
class Line:
    """A body on a line: its force at a time, place and rate is held until the next of `times`.

    Dry friction has a sliding and a static strength; at a wall below the rate turns, times a share; at a rope above it
    is lost.
    """

    force: Callable[[float, float, float], float]
    times: tuple[float, ...]
    x: float = 0.0
    v: float = 0.0
    friction: tuple[float, float] = (0.0, 0.0)
    wall: tuple[float, float] = (-math.inf, 1.0)
    rope: float = math.inf

    def acceleration(self, F: float, x: float, v: float) -> float:
        kinetic, static = self.friction
        if x >= self.rope and v == 0.0 and F > 0.0:
            return 0.0
        if v == 0.0:
            return 0.0 if abs(F) <= static else F - math.copysign(kinetic, F)
        return F - math.copysign(kinetic, v)

    def next_change(self, x: float, v: float, a: float) -> tuple[float, float, float]:
        """How long it goes on like this, and place and rate then; endless without a change."""
        found = [(math.inf, x, v)]
        if self.friction[0] and v * a < 0.0:
            found.append((-v / a, x - v * v / (2 * a), 0.0))
        for place, sign, share in ((self.wall[0], -1.0, -self.wall[1]), (self.rope, 1.0, 0.0)):
            square = v * v + 2 * a * (place - x)
            if math.isfinite(place) and square >= 0.0:
                rate = sign * math.sqrt(square)  # there, in this direction
                s = (rate - v) / a if abs(a) > 1e-9 else (place - x) / v if v else math.inf
                if s > 1e-12 and rate:
                    found.append((s, place, share * rate))
        return min(found)

    def pieces(self) -> Array:
        """Rows t, x, x', x'' from which on parabolas hold."""
        x, v, rows = self.x, self.v, []
        for t, end in zip(self.times, (*self.times[1:], math.inf), strict=True):
            F = self.force(t, x, v)
            while t < min(end, END):
                a = self.acceleration(F, x, v)
                rows.append((t, x, v, a))
                s, place, rate = self.next_change(x, v, a)
                if t + s < end:
                    t, x, v = t + s, place, rate
                    continue
                s = end - t
                t, x, v = end, x + v * s + a * s * s / 2, v + a * s
        return np.array(rows)

    def values(self, name: str) -> Callable[[Array], Values]:
        rows = self.pieces()

        def reference(t: Array) -> Values:
            start, x, v, a = rows[np.maximum(np.searchsorted(rows[:, 0], t + 1e-9, "right") - 1, 0)].T
            s = t - start
            return {name: x + v * s + a * s**2 / 2, f"{name}_dot": v + a * s}

        return reference

    def strikes(self) -> tuple[float, ...]:
        """When its rate jumps."""
        rows = self.pieces()
        s = np.diff(rows[:, 0])
        jumps = np.abs(rows[1:, 2] - rows[:-1, 2] - rows[:-1, 3] * s) > 1e-9
        return tuple(rows[1:, 0][jumps].tolist())


def every(step: float) -> tuple[float, ...]:
    return tuple(step * k for k in range(round(END / step) + 1))


def on_line(name: str, line: Line, *more: Any, axis: str = "x", **given: Any) -> Fragment:
    """A body of 1 kg as on the line, its drive and what else there is."""
    joint = {key: given.pop(key) for key in ("force", "friction") if key in given}
    return Fragment(
        name, (*slide("way", "x", axis, **joint), *more), line.values("x"), {"x": 1.0, "x_dot": 3.0},
        {"x": line.x, "x_dot": line.v}, line.strikes(), **given,
    )  # fmt: skip


def fmu_law(coordinate: str) -> Callable[[sb.EquationSet, Path | None], dict[str, Any]]:
    return lambda eqs, path: {
        "F_fmu": sb.FmuInput(str(path), "F", {"x": coordinate, "v": f"{coordinate}_dot"}, 0.05)
    }


def feedback(t: float, x: float, v: float) -> float:
    return -16 * x - 4 * v


def rope_of(length: float) -> sb.Distance:
    return sb.Distance("rope", "ground", "way body", length, rope=True)


ELASTIC = {"x_dot": "-0.8*x_dot"}


def held() -> list[Fragment]:
    """Sampled forces, FMUs, tables and functions where something else happens to the coordinate."""
    drive, fmu = sb.Drive(applied="hold"), sb.Drive(applied="F_fmu")
    ramp = sb.Signal("hold", "8*t", sample=0.1)
    thrust = sb.Signal("hold", "3 - 2*x_dot", sample=0.1)
    push = sb.Lookup("push", points=[[0, 1], [0.35, 1], [0.35, 4], [2, 4]])
    from_fmu: dict[str, Any] = {"inputs": ("F_fmu",), "laws": fmu_law("x"), "force": fmu}
    return [
        on_line("sampled force on a joint that sticks",
                Line(lambda t, x, v: 8 * t, every(0.1), friction=(KINETIC, STATIC)), ramp, force=drive, friction=DRY),
        on_line("sampled thrust of a ball that bounces",
                Line(lambda t, x, v: 3 - 2 * v - G, every(0.1), 0.1, wall=(0.0, 0.8)), thrust, force=drive, axis="y",
                events=(sb.Event("x", -1, ELASTIC),)),
        on_line("sampled force through a rope",
                Line(lambda t, x, v: 8 * t, every(0.1), 0.1, 0.5, rope=0.3), ramp, rope_of(0.3), force=drive),
        on_line("FMU force through a rope", Line(feedback, every(0.05), 0.1, 3.0, rope=0.3), rope_of(0.3), **from_fmu),
        on_line("FMU force on a joint that sticks",
                Line(feedback, every(0.05), 0.5, friction=(KINETIC, STATIC)), friction=DRY, **from_fmu),
        on_line("FMU force on a body that bounces", Line(feedback, every(0.05), 0.5, wall=(0.2, 0.8)),
                events=(sb.Event("x - 0.2", -1, ELASTIC),), **from_fmu),
        on_line("table that jumps on a joint that sticks",
                Line(lambda t, x, v: 1.0 if t < 0.35 else 4.0, (0.0, 0.35), friction=(KINETIC, STATIC)), push,
                force=sb.Drive(applied="push"), friction=DRY),
        on_line("table that jumps through a rope",
                Line(lambda t, x, v: 1.0 if t < 0.35 else 4.0, (0.0, 0.35), 0.05, rope=0.2), push, rope_of(0.2),
                force=sb.Drive(applied="push")),
        on_line("Python force on a joint that sticks",
                Line(lambda t, x, v: 2.0 if t < 0.5 else 5.0, (0.0, 0.5), friction=(KINETIC, STATIC)),
                inputs=("F_python",), force=sb.Drive(applied="F_python"), friction=DRY, force_jump=3.0,
                laws=lambda eqs, path: {"F_python": lambda t, q, u: 2.0 if t < 0.5 else 5.0}),
    ]  # fmt: skip


def struck() -> list[Fragment]:
    """Events that set values, ropes and jumps of rates where a joint sticks, and each other."""
    none = (0.0,)
    dry = {"friction": DRY}
    carrier = (
        sb.Body("Carrier", mass=1), sb.Body("Rider", mass=1),
        sb.Prismatic("carried", "ground", "Carrier", axis="x", coordinate="p", motion="if(t < 0.4, t, 2*t - 0.4)"),
    )  # fmt: skip
    slip, spring = sb.Friction(force=0.5, static=0.6), sb.Drive(stiffness=36)
    return [
        on_line("action on a joint that sticks",
                Line(lambda t, x, v: 0.0, none, 0.3, -1.5, (KINETIC, STATIC), (0.0, 0.8)),
                events=(sb.Event("x", -1, ELASTIC),), **dry),
        on_line("rope at a joint that sticks", Line(lambda t, x, v: 0.0, none, 0.1, 1.5, (KINETIC, STATIC), rope=0.3),
                rope_of(0.3), **dry),
        on_line("action on a ball on a rope",
                Line(lambda t, x, v: -G, none, 0.05, -2.0, wall=(0.0, 0.8), rope=0.1), rope_of(0.1), axis="y",
                events=(sb.Event("x", -1, ELASTIC),)),
        # Friction is finite: the rider goes on at 1 m/s in space, and the carrier takes it along by 0.5 N.
        Fragment("rate that jumps under a joint that sticks",
                 (*carrier, sb.Prismatic("ridden", "Carrier", "Rider", axis="x", coordinate="r", friction=slip)),
                 lambda t: {"r": np.where(t < 0.4, 0.0, -(t - 0.4) + (t - 0.4) ** 2 / 4),
                            "r_dot": np.where(t < 0.4, 0.0, -1 + (t - 0.4) / 2)},
                 {"r": 1.0, "r_dot": 1.0}, {"r": 0.0, "r_dot": 0.0}, (0.4,)),
        Fragment("rate that jumps at a spring",
                 (*carrier, sb.Prismatic("ridden", "Carrier", "Rider", axis="x", coordinate="r", force=spring)),
                 lambda t: {"r": np.where(t < 0.4, 0.0, -np.sin(6 * (t - 0.4)) / 6)},
                 {"r": 1.0}, {"r": 0.0, "r_dot": 0.0}, (0.4,)),
        # the sum of both rates, 2 - 1, passes no zero; that of the rider passes -0.5 in the jump and is set to 3
        Fragment("action in a rate that jumps",
                 (*carrier, sb.Prismatic("ridden", "Carrier", "Rider", axis="x", coordinate="r")),
                 lambda t: {"r": np.where(t < 0.4, 0.0, 3 * (t - 0.4))}, {"r": 1.0}, {"r": 0.0, "r_dot": 0.0}, (0.4,),
                 events=(sb.Event("r_dot + 0.5", -1, {"r_dot": "3"}),)),
    ]  # fmt: skip


def parallelogram(*given: Any, torque: float | str, friction: sb.Friction | None = None) -> tuple[Any, ...]:
    """A parallelogram that lies flat: crank and rocker of 0.5 m, 0.42 kg m^2 about the crank, a joint in each corner."""
    dry = {"friction": friction} if friction else {}
    tip = {"tip": sb.Frame(at=(0.5, 0, 0))}
    return (
        sb.Body("Post", mass=1, frames={"pin": sb.Frame(at=(1.2, 0, 0))}), sb.Weld("post", "ground", "Post"),
        sb.Body("Left", mass=1, inertia=(0, 0.1, 0), frames=tip), sb.Body("Right", mass=1, inertia=(0, 0.12, 0), frames=tip),
        sb.Body("Bar", mass=0.8, inertia=(0, 0.05, 0),
                frames={"left": sb.Frame(at=(-0.6, 0, 0)), "right": sb.Frame(at=(0.6, 0, 0))}),
        sb.Revolute("A", "ground", "Left", axis="y", coordinate="x", torque=sb.Drive(applied=torque), **dry),
        sb.Revolute("B", "Left.tip", "Bar.left", axis="y", coordinate="xb", **dry),
        sb.Revolute("C", "Bar.right", "Right.tip", axis="y", coordinate="xc", tree=False, **dry),
        sb.Revolute("D", "Post.pin", "Right", axis="y", coordinate="xd", **dry), *given,
    )  # fmt: skip


PARALLELOGRAM = 0.1 + 0.12 + 0.8 * 0.5**2  # kg m^2
DRY_PIN = sb.Friction(force=0.5, static=1.1)


def shared() -> list[Fragment]:
    """Four pins of one degree of freedom share what holds them: they break away together, at the sum of their strengths.

    How they share the load follows from no law of rigid bodies, and when they break away does not depend on it.
    """
    steps, still = every(0.1), {"x": 0.7, "xb": -0.7, "xd": 0.7, "x_dot": 0.0}
    strength = {"friction": (4 * 0.5 / PARALLELOGRAM, 4 * 1.1 / PARALLELOGRAM)}
    pulse = sb.Signal("hold", "if(t < 0.95, 6*sin(9*t), 0)", sample=0.1)
    sampled = Line(
        lambda t, x, v: (6 * math.sin(9 * t) if t < 0.95 else 0.0) / PARALLELOGRAM, steps, 0.7, **strength
    )  # fmt: skip
    # 20 t is 4.4 at t = 0.22, and from then on the rate is 10 s^2 + 2.4 s over the inertia
    start, end = 0.22, 0.4

    def ramp(t: Array) -> Values:
        s = np.clip(t - start, 0.0, end - start)
        x = (10 * s**3 / 3 + 1.2 * s**2) / PARALLELOGRAM
        rate = (10 * s**2 + 2.4 * s) / PARALLELOGRAM
        r, brake = np.maximum(t - end, 0.0), 2.0 / PARALLELOGRAM
        r = np.minimum(r, rate / brake)
        return {"x": 0.7 + x + rate * r - brake * r**2 / 2}

    return [
        Fragment("sampled torque on four pins that share", parallelogram(pulse, torque="hold", friction=DRY_PIN),
                 sampled.values("x"), {"x": 1.0, "x_dot": 5.0}, still),
        Fragment("ramp on four pins that share",
                 parallelogram(torque=f"if(t < {end}, 20*t, 0)", friction=DRY_PIN), ramp, {"x": 1.0}, still,
                 force_jump=20.0),
    ]  # fmt: skip


def action_at_a_sample() -> Fragment:
    """x'' = -9 x - 3 x' of every tenth of a second; at the sample at 0.4 an event that comes first sets x' = -1."""
    x, v, rows = 0.5, 0.0, []
    for k in range(11):
        v = -1.0 if k == 4 else v
        force = -9 * x - 3 * v
        rows.append((x, v, force))
        x, v = x + v / 10 + force / 200, v + force / 10
    table = np.array(rows)

    def reference(t: Array) -> Values:
        k = np.minimum(np.floor(10 * t + 1e-9).astype(int), 10)
        x, v, force = table[k].T
        s = t - k / 10
        return {"x": x + v * s + force * s**2 / 2, "x_dot": v + force * s}

    return Fragment(
        "action at a sample",
        (*slide("way", "x", force=sb.Drive(applied="hold")), sb.Signal("hold", "-9*x - 3*x_dot", sample=0.1)),
        reference, {"x": 1.0, "x_dot": 3.0}, {"x": 0.5, "x_dot": 0.0}, (0.4,),
        events=(sb.Event("t - 0.4", 1, {"x_dot": "-1"}),),
    )  # fmt: skip


def lag_on_friction() -> Fragment:
    """A pull 4 (1 - exp(-t/0.3)) breaks a joint away where it is 0.3 g."""
    start = -0.3 * math.log(1 - STATIC / 4)

    def reference(t: Array) -> Values:
        s = np.maximum(t - start, 0.0)
        gone = math.exp(-start / 0.3) * (1 - np.exp(-s / 0.3))
        rate = (4 - KINETIC) * s - 1.2 * gone
        return {
            "x": (4 - KINETIC) * s**2 / 2 - 1.2 * (math.exp(-start / 0.3) * s - 0.3 * gone),
            "x_dot": rate,
        }

    parts = (
        *slide("way", "x", force=sb.Drive(applied="late"), friction=DRY),
        sb.FirstOrder("late", "4", 0.3),
    )
    return Fragment("lag on a joint that sticks", parts, reference, {"x": 1.0, "x_dot": 3.0}, {"x": 0.0})


def geared() -> list[Fragment]:
    """An action, a stop and a function at coordinates of gears: e = 2 g, and e'' = 4 by a torque of 0.9."""

    def parts(torque: str) -> tuple[Any, ...]:
        return (
            sb.Body("Pinion", mass=1, inertia=(0, 0, 0.2)), sb.Body("Wheel", mass=1, inertia=(0, 0, 0.1)),
            sb.Revolute("pinion pin", "ground", "Pinion", coordinate="e", torque=sb.Drive(applied=torque)),
            sb.Revolute("wheel pin", "ground", "Wheel", coordinate="g"), sb.Gear("mesh", ["e", "g"], 2),
        )  # fmt: skip

    still = {"e": 0.0, "e_dot": 0.0}
    sizes = {"e": 2.0, "e_dot": 4.0}
    back = np.array([0.5, -2.0])  # e and e' behind t = 0.5

    def turned(t: Array) -> Values:
        s = t - 0.5
        return {"e": np.where(t < 0.5, 2 * t**2, back[0] + back[1] * s + 2 * s**2)}

    return [
        Fragment("action on a geared rate", parts("0.9"), turned, {"e": 2.0}, still, (0.5,),
                 events=(sb.Event("e - 0.5", 1, {"g_dot": "-g_dot"}),)),
        Fragment("stop at a geared angle", parts("0.9"), lambda t: {"e": 2 * t**2, "e_dot": 4 * t}, sizes, still,
                 events=(sb.Event("g - 0.4", 1, "stop"),), end=math.sqrt(0.4)),
        Fragment("Python torque on a geared angle", parts("F_python"), lambda t: {"e": 0.4 * np.cos(4 * t)},
                 {"e": 0.4}, {"e": 0.4, "e_dot": 0.0}, inputs=("F_python",),
                 laws=lambda eqs, path: {"F_python": python_torque(eqs)}),
    ]  # fmt: skip


def python_torque(eqs: sb.EquationSet) -> Callable[[float, Array, Array], float]:
    """-16 e times the inertia 0.225, from e or from g = e/2."""
    k, factor = (eqs.coordinate_names.index("e"), 1.0) if "e" in eqs.coordinate_names else (0, 2.0)
    return lambda t, q, u: -3.6 * factor * float(q[k])


def turning() -> list[Fragment]:
    """What reads or sets angles that are more than half a turn, and orientations."""
    disc = measured_angle()
    wheel = Line(lambda t, x, v: -4 * x, every(0.1), 0.0, 8.0)
    spin = {"qw": 1.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "ox": 0.0, "oy": 0.0}
    ball = (
        sb.Body("Ball", mass=1, inertia=(1, 1, 1)),
        sb.Spherical("joint", "ground", "Ball", coordinates=["qw", "qx", "qy", "qz"], speeds="end",
                     speed_names=["ox", "oy", "oz"]),
    )  # fmt: skip
    sizes = {"qw": 3.0, "qz": 3.0}

    def of_angle(angle: Callable[[Array], Array]) -> Callable[[Array], Values]:
        return lambda t: {"qw": np.cos(angle(t) / 2), "qz": np.sin(angle(t) / 2)}

    turn = math.asin(0.5) / 1.5  # where sin(3 t/2) = 0.5
    torque = sb.Lookup("push", points=[[0, 1], [0.35, 1], [0.35, -4], [2, -4]])
    return [
        Fragment("action at the measured angle of a cut joint", disc.parts,
                 lambda t: {"mt": np.where(t < 0.625, 8 * t, 5 + 2 * (t - 0.625))}, {"mt": 8.0}, disc.initial, (0.625,),
                 events=(sb.Event("m - 5", 1, {"mt_dot": "2"}),)),
        Fragment("sampled torque by the measured angle of a cut joint",
                 (*disc.parts, sb.Signal("hold", "-4*m", sample=0.1), sb.Torque("push", "Disc", (0, 0, "hold"))),
                 wheel.values("mt"), {"mt": 8.0, "mt_dot": 8.0}, disc.initial),
        Fragment("table that jumps on a quaternion", (*ball, torque, sb.Torque("turn", "Ball", (0, 0, "push"))),
                 of_angle(lambda t: t + t**2 / 2 - 5 * np.maximum(t - 0.35, 0) ** 2 / 2), sizes, {**spin, "oz": 1.0},
                 force_jump=5.0),
        Fragment("action at a quaternion", ball,
                 of_angle(lambda t: np.where(t < turn, 3 * t, 3 * turn - 3 * (t - turn))), sizes, {**spin, "oz": 3.0},
                 (turn,), events=(sb.Event("qz - 0.5", 1, {"oz": "-oz"}),)),
    ]  # fmt: skip


def action_in_a_loop() -> Fragment:
    """The slider-crank of the fragment, whose crank turns back where its angle is 1.5."""

    def rate(t: float, y: Array) -> list[float]:
        A, V = crank_slope(y[0] + 1e-30j)
        return [y[1], -(A.imag * 1e30 * y[1] ** 2 / 2 + V.imag * 1e30) / A.real]

    def at_turn(t: float, y: Array) -> float:
        return float(y[0] - 1.5)

    at_turn.terminal = True  # type: ignore[attr-defined]
    more: dict[str, Any] = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-13, "dense_output": True}
    first = solve_ivp(rate, (0, END), [0.4, 5.0], events=at_turn, **more)
    turn = float(first.t[-1])
    second = solve_ivp(rate, (turn, END), [1.5, -first.y[1, -1]], **more)

    def reference(t: Array) -> Values:
        return {
            "z": np.where(t < turn, first.sol(np.minimum(t, turn))[0], second.sol(np.maximum(t, turn))[0])
        }

    loop = closed_loop()
    return Fragment(
        "action in a loop", loop.parts, reference, {"z": 5.0}, loop.initial, (turn,),
        events=(sb.Event("z - 1.5", 1, {"z_dot": "-z_dot"}),),
    )  # fmt: skip


def stop_behind_a_bounce() -> Fragment:
    """A ball that bounces stops where it comes down through 0.05 behind its second bounce."""
    (t, v), low = hops(0.2, 0.8)[1], 0.05
    end = t + (v + math.sqrt(v * v - 2 * G * low)) / G
    line = Line(lambda t, x, v: -G, (0.0,), 0.2, wall=(0.0, 0.8))
    return on_line(
        "stop of a ball that bounces", line, axis="y", end=end,
        events=(sb.Event("x", -1, ELASTIC), sb.Event(f"if(t > {t}, x - {low}, -1)", -1, "stop")),
    )  # fmt: skip


COUPLINGS = {
    coupling.name: coupling
    for coupling in (
        *held(), *struck(), lag_on_friction(), *geared(), *turning(), action_in_a_loop(), stop_behind_a_bounce(),
        *shared(), action_at_a_sample(),
    )
}  # fmt: skip
