"""The mechanisms of `benchmarks.mechanisms` written with sympy.physics.mechanics.

A file of its own, loaded when something is formed: first motions are timed in processes without SymPy.
"""

from __future__ import annotations

from typing import Any

import sympy
import sympy.physics.mechanics as me
from sympy.physics.mechanics.models import n_link_pendulum_on_cart

Kane = Any  # a KanesMethod whose equations are formed


def pendulum(links: int) -> Kane:
    """Return the pendulum on a cart that comes with SymPy."""
    return n_link_pendulum_on_cart(links)


def chain(links: int) -> Kane:
    """Return a chain of rigid bodies, hinged in turn about y, z and x of the link before."""
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
