"""Exercise: one slider-crank in four ways.

Description
    A crank of mass m1, a rod of mass m2 and a slider of mass m3 under gravity, in the global approach
    (nine coordinates), the recursive one (three), with natural coordinates (seven), and drawn with joints
    (three).
Concepts
    The approach is a choice of coordinates: constraints, multipliers and their number differ, motion and
    reactions do not; the same for virtual work, Newton-Euler and Lagrange.
"""

from collections.abc import Sequence

import numpy as np
import sympy as sp
from matplotlib.figure import Figure
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.mbsymba import (
    comp_X,
    comp_Y,
    dot_prod,
    equation_set,
    ground,
    join_points,
    make_BODY,
    make_CONSTRAINT,
    make_POINT,
    make_VECTOR,
    origin,
    project,
    rotate,
    set_gravity,
    translate,
    uvec_X,
    uvec_Y,
)

# Modeling

t = dynamicsymbols._t
data = {"L1": 0.3, "L2": 1.1, "m1": 0.7, "m2": 1.3, "m3": 0.9, "J1": 0.02, "J2": 0.17, "g": 9.81}
L1, L2, m1, m2, m3, J1, J2, g = sp.symbols(list(data))
set_gravity(make_VECTOR(ground, 0, -g, 0))


def revolute(P: object, Q: object) -> list[sp.Expr]:
    """Return what vanishes where two points are one."""
    between = project(join_points(P, Q), ground)
    return [comp_X(between), comp_Y(between)]


def mechanism(crank: object, rod: object, slider: object, Phi: Sequence[sp.Expr]) -> list[object]:
    """Return three bodies at their centres of mass, and their constraints."""
    bodies = [make_BODY(crank, m1, 0, 0, J1), make_BODY(rod, m2, 0, 0, J2), make_BODY(slider, m3, 0, 0, 1)]
    return [*bodies, make_CONSTRAINT(Phi, dynamicsymbols(f"lambda1:{len(Phi) + 1}"))]


def natural(u: sp.Expr, v: sp.Expr, x: sp.Expr, y: sp.Expr) -> sp.Matrix:
    """Return the frame at (x, y) whose X axis is (u, v)."""
    return sp.Matrix([[u, -v, 0, x], [v, u, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])


theta, beta, s = dynamicsymbols("theta beta s")
x1, y1, x2, y2, a2, y3, a3 = dynamicsymbols("x1 y1 x2 y2 a2 y3 a3")
# Global: each body by x, y and an angle; the joint between rod and slider first, as in all four.
RF1, RF2, RF3 = (
    translate(x, y, 0) * rotate("Z", a) for x, y, a in ((x1, y1, theta), (x2, y2, a2), (s, y3, a3))
)
rows = [
    *revolute(origin(RF3), make_POINT(RF2, L2 / 2, 0, 0)),
    *revolute(origin(ground), make_POINT(RF1, -L1 / 2, 0, 0)),
    *revolute(make_POINT(RF1, L1 / 2, 0, 0), make_POINT(RF2, -L2 / 2, 0, 0)),
    *(dot_prod(uvec_Y(ground), uvec_X(RF3)), comp_Y(project(origin(RF3), ground))),
]
of_global = mechanism(RF1, RF2, RF3, rows), [x1, y1, theta, x2, y2, a2, s, y3, a3]
# Recursive: each body from the one before; the loop is closed by two rows.
RF1 = rotate("Z", theta)
RF2 = RF1 * translate(L1, 0, 0) * rotate("Z", beta)
RF3 = translate(s, 0, 0)
closing = revolute(origin(RF3), make_POINT(RF2, L2, 0, 0))
of_recursive = (
    mechanism(make_POINT(RF1, L1 / 2, 0, 0), make_POINT(RF2, L2 / 2, 0, 0), RF3, closing),
    [theta, beta, s],
)
# Natural: a point and a direction of unit length each.
ux, uy, vx, vy = dynamicsymbols("ux uy vx vy")
RF1, RF2 = natural(ux, uy, 0, 0), natural(vx, vy, x2, y2)
rows = [
    *revolute(origin(RF3), make_POINT(RF2, L2, 0, 0)),
    *revolute(make_POINT(RF1, L1, 0, 0), origin(RF2)),
    *(ux**2 + uy**2 - 1, vx**2 + vy**2 - 1),
]
of_natural = (
    mechanism(make_POINT(RF1, L1 / 2, 0, 0), make_POINT(RF2, L2 / 2, 0, 0), RF3, rows),
    [ux, uy, vx, vy, x2, y2, s],
)
# Drawn: bodies with frames, and joints between them.
ends = {
    name: {"base": sb.Frame((f"-{L}/2", 0, 0)), "tip": sb.Frame((f"{L}/2", 0, 0))}
    for name, L in (("crank", "L1"), ("rod", "L2"))
}
parts = [
    sb.Body("crank", "m1", (0, 0, "J1"), frames=ends["crank"]),
    sb.Body("rod", "m2", (0, 0, "J2"), frames=ends["rod"]),
    sb.Body("slider", "m3", (0, 0, 1)),
    sb.Revolute("A", "ground", "crank.base", coordinate="theta"),
    sb.Revolute("B", "crank.tip", "rod.base", coordinate="beta"),
    sb.Prismatic("D", "ground", "slider", axis="x", coordinate="s"),
    sb.Revolute("C", "slider", "rod.tip", tree=False),
]
drawn = sb.Model("slider-crank", parts, gravity=(0, "-g", 0), parameters=data)

# Simulation

formulations = (sb.VirtualWork(), sb.NewtonEuler(), sb.Lagrange())
angle, rate = 0.7, 1.3
lean = -np.arcsin(0.3 * np.sin(angle) / 1.1)
tip = {"x2": 0.3 * np.cos(angle), "y2": 0.3 * np.sin(angle)}
turning = {"theta": angle, "theta_dot": rate}
starts = {
    "global": (turning, {"a2": lean, "s": 1.3, "x1": 0.1, "y1": 0.1, "x2": 0.7, "y2": 0.1}),
    "recursive": (turning, {"beta": lean - angle, "s": 1.3}),
    "natural": (
        {"ux": np.cos(angle), "uy_dot": rate * np.cos(angle)},
        {"uy": np.sin(angle), "vx": np.cos(lean), "vy": np.sin(lean), "s": 1.3, **tip},
    ),
    "drawn": (turning, {"beta": lean - angle, "s": 1.3}),
}  # fmt: skip
mechanisms = {"global": of_global, "recursive": of_recursive, "natural": of_natural}
times = np.linspace(0, 2, 201)
results, runs = {}, {}
for way, (initial, guess) in starts.items():
    for formulation in formulations:
        if way == "drawn":
            eqs = sb.form_equations(drawn, formulation)
            force = ("reaction C Fx", "reaction C Fy")
        else:
            objects, q = mechanisms[way]
            eqs = equation_set(objects, q, formulation, parameters=data)
            force = ("lambda1", "lambda2")
        if formulation == formulations[0]:
            print(f"{way}: {len(eqs.coordinate_names)} coordinates, {len(eqs.multiplier_names)} constraints")
            runs[way] = sb.simulate(eqs, 2.0, initial, guess=guess, times=times, rtol=1e-11, atol=1e-13)
        state = sb.assemble(eqs, initial, guess)
        at_once = sb.simulate(eqs, 1e-9, initial, guess=guess, times=[0])
        results[way, type(formulation).__name__] = [
            state.udot["s_ddot"],
            *(at_once[name][0] for name in force),
        ]

figure = Figure(layout="constrained", figsize=(6.4, 6.4))
above, below = figure.subplots(2, sharex=True)
for (way, run), style in zip(runs.items(), ("-", "--", "-.", ":"), strict=True):
    above.plot(times, run["s"], style, label=way)
    below.plot(times, run["reaction C Fx" if way == "drawn" else "lambda1"], style, label=way)
above.set(ylabel="slider s [m]", title="One mechanism, four choices of coordinates")
below.set(xlabel="time [s]", ylabel="force on the rod, X [N]")
above.legend()
below.legend()
sb.save_plot(above, "slider_crank_four_ways.png")

# Check

wanted = np.array(results["drawn", "VirtualWork"])
print("s'' and the force on the rod by the slider:", wanted)
for found in results.values():
    assert np.abs(found - wanted).max() < 1e-8 * np.abs(wanted).max()
for way, run in runs.items():
    apart = np.abs(run["s"] - runs["drawn"]["s"]).max()
    print(f"{way}: s differs by {apart:.0e} m, energy drifts by {run.energy_drift:.0e} J")
    assert run.success and apart < 1e-8 and run.energy_drift < 1e-8
    # F = m a for the slider: along X nothing but the rod acts on it.
    acceleration, force, _ = results[way, "VirtualWork"]
    assert abs(0.9 * acceleration + force) < 1e-9
set_gravity(None)

# References
#
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course,
# sections 1.2 and 4.
