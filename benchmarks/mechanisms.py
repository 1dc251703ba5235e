"""Mechanisms written twice: as a model, and with sympy.physics.mechanics, in the same names.

Coordinates have the same names on both sides; SymPy's speeds, the rates, are u0 of q0 or u_theta of theta.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import sympy
import sympy.physics.mechanics as me
from sympy.physics.mechanics.models import n_link_pendulum_on_cart

import symbody as sb

Kane = Any  # a KanesMethod whose equations are formed

EXAMPLES: Final = Path(__file__).parents[1] / "examples"

_AXES: Final = "xyz"


@dataclass(frozen=True, slots=True)
class Mechanism:
    """One size of a mechanism, to be derived by both; another process has to find what it calls."""

    name: str
    model: Callable[[], sb.Model]
    kane: Callable[[], Kane]


def pendulum_on_cart(links: int) -> Mechanism:
    """Return a planar pendulum of point masses on a cart, in angles against the vertical.

    Rotations lead from ground to each link, translations from link to link. SymPy's side is the model
    that comes with SymPy.
    """
    return Mechanism(
        f"{links} links",
        partial(_pendulum, links),
        partial(n_link_pendulum_on_cart, links),
    )


def _pendulum(links: int) -> sb.Model:
    elements: list[Any] = [
        sb.Body("C0", mass="m0"),
        sb.Prismatic("slide", "ground", "C0", axis="x", coordinate="q0", force=sb.Drive(applied="F")),
    ]
    for k in range(1, links + 1):
        elements += [
            sb.Body(f"C{k}", mass=f"m{k}", frames={"hinge": sb.Frame(at=(0, f"-l{k - 1}", 0))}),
            sb.Revolute(
                f"hinge{k}", f"C{k - 1}", f"C{k}.hinge", tree={"rotation": False, "translation": True}
            ),
            sb.Planar(
                f"angle{k}",
                "ground",
                f"C{k}",
                coordinates=(f"x{k}", f"y{k}", f"q{k}"),
                tree={"rotation": True, "translation": False},
            ),
        ]
    parameters = [f"m{k}" for k in range(links + 1)] + [f"l{k}" for k in range(links)]
    return sb.Model(
        "pendulum",
        elements,
        gravity=(0, "-g", 0),
        parameters=dict.fromkeys(parameters, 1.0) | {"g": 9.81},
        inputs=["F"],
    )


def spatial_chain(links: int) -> Mechanism:
    """Return a chain of rigid bodies, hinged in turn about y, z and x of the link before."""
    return Mechanism(f"{links} bodies", partial(_chain, links), partial(_kane_chain, links))


def _chain(links: int) -> sb.Model:
    elements: list[Any] = []
    before = "ground"
    for k in range(links):
        ends = {"P": sb.Frame(at=(0, 0, f"-l{k}/2")), "Q": sb.Frame(at=(0, 0, f"l{k}/2"))}
        inertia = (f"a{k}", f"b{k}", f"c{k}")
        elements += [
            sb.Body(f"B{k}", mass=f"m{k}", inertia=inertia, frames=ends),
            sb.Revolute(f"J{k}", before, f"B{k}.P", axis=_AXES[(k + 1) % 3], coordinate=f"q{k}"),
        ]
        before = f"B{k}.Q"
    parameters = {f"{letter}{k}": 1.0 for k in range(links) for letter in "mabcl"}
    return sb.Model("chain", elements, gravity=(0, 0, "-g"), parameters=parameters | {"g": 9.81})


def _kane_chain(links: int) -> Kane:
    q, u = me.dynamicsymbols(f"q:{links}"), me.dynamicsymbols(f"u:{links}")
    space, hinge = me.ReferenceFrame("N"), me.Point("O")
    hinge.set_vel(space, 0)
    before, bodies, loads = space, [], []
    for k in range(links):
        m, a, b, c, length = sympy.symbols(f"m{k} a{k} b{k} c{k} l{k}")
        axis = (before.x, before.y, before.z)[(k + 1) % 3]
        frame = me.ReferenceFrame(f"B{k}")
        frame.orient_axis(before, axis, q[k])
        frame.set_ang_vel(before, u[k] * axis)
        center = hinge.locatenew(f"C{k}", length / 2 * frame.z)
        center.v2pt_theory(hinge, space, frame)
        after = hinge.locatenew(f"Q{k}", length * frame.z)
        after.v2pt_theory(hinge, space, frame)
        inertia = (me.inertia(frame, a, b, c), center)
        bodies.append(me.RigidBody(f"B{k}", center, frame, m, inertia))
        loads.append((center, -m * sympy.Symbol("g") * space.z))
        before, hinge = frame, after
    return _formed(space, list(q), list(u), bodies, loads)


def example(name: str, kane: Callable[[], Kane]) -> Mechanism:
    """Return an example by its file, beside `kane`."""
    return Mechanism(name, partial(sb.load_model, EXAMPLES / name / f"{name}.toml"), kane)


def robot() -> Kane:
    """Return the two hinged links of rr_robot."""
    space, hinge = me.ReferenceFrame("N"), me.Point("O")
    hinge.set_vel(space, 0)
    lengths = (sympy.symbols("L3 L4"), sympy.symbols("L5 L6"))
    q, u = _moving("beta_1", "beta_2")
    torques = me.dynamicsymbols("T1 T2")
    before, bodies, loads = space, [], []
    for k, (near, far) in enumerate(lengths):
        m, inertia = sympy.symbols(f"m{k + 1} I{k + 1}")
        frame = me.ReferenceFrame(f"B{k}")
        frame.orient_axis(before, before.z, q[k])
        frame.set_ang_vel(before, u[k] * before.z)
        center = hinge.locatenew(f"C{k}", near * frame.x)
        center.v2pt_theory(hinge, space, frame)
        after = center.locatenew(f"Q{k}", far * frame.x)
        after.v2pt_theory(center, space, frame)
        bodies.append(me.RigidBody(f"B{k}", center, frame, m, (me.inertia(frame, 0, 0, inertia), center)))
        loads += [(center, -m * sympy.Symbol("G") * space.y), (frame, torques[k] * space.z)]
        if k:
            loads.append((before, -torques[k] * space.z))
        before, hinge = frame, after
    return _formed(space, q, u, bodies, loads)


def top() -> Kane:
    """Return the top of spinning_top, in rates of its Euler angles."""
    m, length, across, along, g = sympy.symbols("m L A C G")
    space, frame, point = me.ReferenceFrame("N"), me.ReferenceFrame("B"), me.Point("O")
    point.set_vel(space, 0)
    q, u = _moving("zeta", "eta", "xi")
    frame.orient_body_fixed(space, q, "313")
    rates = {angle.diff(me.dynamicsymbols._t): speed for angle, speed in zip(q, u, strict=True)}
    frame.set_ang_vel(space, frame.ang_vel_in(space).subs(rates))
    center = point.locatenew("C", length * frame.z)
    center.v2pt_theory(point, space, frame)
    moment = across - m * length**2
    body = me.RigidBody("B", center, frame, m, (me.inertia(frame, moment, moment, along), center))
    return _formed(space, q, u, [body], [(center, -m * g * space.z)])


def _moving(*names: str) -> tuple[list[Any], list[Any]]:
    """Return coordinates of these names, and speeds in the way of this file."""
    return [me.dynamicsymbols(name) for name in names], [me.dynamicsymbols(f"u_{name}") for name in names]


def _formed(space: Any, q: list[Any], u: list[Any], bodies: list[Any], loads: list[Any]) -> Kane:
    rates = [speed - x.diff(me.dynamicsymbols._t) for x, speed in zip(q, u, strict=True)]
    kane = me.KanesMethod(space, q_ind=q, u_ind=u, kd_eqs=rates)
    kane.kanes_equations(bodies, loads)
    return kane
