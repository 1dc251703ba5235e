"""Exercise: quick-return mechanism.

Description
    A crank of length R turns at constant speed; its pin slides in the slot of an arm, which is pivoted D
    below the crank. The arm's end, at La, moves a ram of mass m3 along the horizontal at H by a link of
    length Lr. The ram goes forth slowly and back quickly.
Concepts
    The cam joint, a point on a line: one constraint; by hand, and drawn as a point on a line and as a pin
    in a slot; time ratio of the strokes; the torque that keeps the speed, and the force in the slot.
"""

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
    make_TORQUE,
    make_VECTOR,
    origin,
    project,
    rotate,
    set_gravity,
    translate,
    uvec_Y,
)

# Modeling

data = {
    "R": 0.1,
    "D": 0.25,
    "La": 0.5,
    "Lr": 0.2,
    "H": 0.25,
    "m1": 1,
    "m2": 4,
    "m3": 6,
    "J1": 0.01,
    "J2": 0.1,
    "J4": 0.01,
    "m4": 1,
    "g": 9.81,
}
R, D, La, Lr, H, m1, m2, m3, J1, J2, J4, m4, g = sp.symbols(list(data))
theta, phi, psi, s, T = dynamicsymbols("theta phi psi s T")
q = [theta, phi, psi, s]
RF1 = rotate("Z", theta)
RFa = translate(0, -D, 0) * rotate("Z", phi)  # X along the slot
RF4 = RFa * translate(La, 0, 0) * rotate("Z", psi)
RF3 = translate(s, H, 0)
Pa, Pb = origin(RFa), make_POINT(RF1, R, 0, 0)
cam = dot_prod(uvec_Y(RFa), project(join_points(Pa, Pb), ground))
pin = project(join_points(origin(RF3), make_POINT(RF4, Lr, 0, 0)), ground)
Phi = [cam, comp_X(pin), comp_Y(pin)]
print("point on a line:", cam)
set_gravity(make_VECTOR(ground, 0, -g, 0))
crank = make_BODY(RF1, m1, 0, 0, J1)
bodies = [crank, make_BODY(make_POINT(RFa, La / 2, 0, 0), m2, 0, 0, J2), make_BODY(RF3, m3, 0, 0, 1)]
bodies += [make_BODY(make_POINT(RF4, Lr / 2, 0, 0), m4, 0, 0, J4)]
objects = [*bodies, make_TORQUE(ground, 0, 0, T, crank), make_CONSTRAINT(Phi, dynamicsymbols("lambda1:4"))]
eqs = equation_set(objects, q, parameters=data)


def drawn(slot: object) -> sb.EquationSet:
    """Return the equations with some joint between slot and pin."""
    parts = [
        sb.Body("Crank", "m1", (0, 0, "J1"), frames={"pin": sb.Frame(("R", 0, 0))}),
        sb.Body(
            "Arm",
            "m2",
            (0, 0, "J2"),
            frames={"pivot": sb.Frame(("-La/2", 0, 0)), "end": sb.Frame(("La/2", 0, 0))},
        ),
        sb.Body(
            "Link",
            "m4",
            (0, 0, "J4"),
            frames={"base": sb.Frame(("-Lr/2", 0, 0)), "tip": sb.Frame(("Lr/2", 0, 0))},
        ),
        sb.Body("Ram", "m3", (0, 0, 1)),
        sb.Revolute("motor", "ground", "Crank", coordinate="theta", torque=sb.Drive(applied="T")),
        sb.Revolute("pivot", "ground.below", "Arm.pivot", coordinate="phi"),
        sb.Revolute("knee", "Arm.end", "Link.base", coordinate="psi"),
        sb.Prismatic("guide", "ground.rail", "Ram", axis="x", coordinate="s"),
        sb.Revolute("eye", "Ram", "Link.tip", tree=False),
        slot,
    ]
    places = {"below": sb.Frame((0, "-D", 0)), "rail": sb.Frame((0, "H", 0))}
    return sb.form_equations(
        sb.Model("quick return", parts, gravity=(0, "-g", 0), parameters=data, inputs=["T"], ground=places)
    )


on_line = drawn(sb.PointOnLine("slot", "Arm.pivot", "Crank.pin", axis="x"))
in_slot = drawn(sb.PinSlot("slot", "Arm.pivot", "Crank.pin", axes=("z", "x"), tree=False))

# Simulation

speed = 10.0
times = np.linspace(0, 2 * np.pi / speed, 721)
near = {"phi": np.pi / 3, "psi": 2.0, "s": 0.0}
ways = {"by hand": eqs, "point on a line": on_line, "pin in a slot": in_slot}
runs = {
    name: sb.inverse_dynamics(each, {"theta": "10*t"}, ["T"], times, guess=near)
    for name, each in ways.items()
}
run = runs["by hand"]
figure = Figure(layout="constrained", figsize=(6.4, 7))
ram, torque, force = figure.subplots(3, sharex=True)
ram.plot(times, run["s"])
ram.set(ylabel="ram s [m]", title="Quick return at 10 rad/s")
torque.plot(times, run["T"])
torque.set(ylabel="torque T [N m]")
force.plot(times, run["lambda1"])
force.set(xlabel="time [s]", ylabel="force in the slot [N]")
sb.save_plot(ram, "quick_return.png")
paths = [("R*cos(theta)", "R*sin(theta)"), ("La*cos(phi)", "La*sin(phi) - D"), ("s", "H + 0*s")]
ax = sb.plot(run, *paths, labels=["pin", "end of the arm", "ram"], title="Paths", equal=True)
ax.set(xlabel="x [m]", ylabel="y [m]")
sb.save_plot(ax, "quick_return_paths.png")

# Check

for name, each in runs.items():
    apart = max(np.abs(each[key] - run[key]).max() / np.abs(run[key]).max() for key in ("s", "T"))
    print(f"{name}: ram and torque differ by {apart:.0e}")
    assert apart < 1e-8
assert np.abs(np.abs(runs["point on a line"]["lambda_slot_1"]) - np.abs(run["lambda1"])).max() < 1e-6
# The slot's angle in closed form; the arm turns back where the crank is square to it.
assert (
    np.abs(
        np.tan(run["phi"] - np.pi / 2) + 0.1 * np.cos(10 * times) / (0.25 + 0.1 * np.sin(10 * times))
    ).max()
    < 1e-9
)
slow = np.mean(run["phi_dot"] > 0)
ratio = (np.pi + 2 * np.arcsin(0.1 / 0.25)) / (np.pi - 2 * np.arcsin(0.1 / 0.25))
print(f"time ratio of the strokes {slow / (1 - slow):.3f}, in closed form {ratio:.3f}")
assert abs(slow / (1 - slow) - ratio) < 0.02
assert abs(run.work[-1]) < 1e-3 * np.abs(run.work).max()  # a full turn gives back what it took
set_gravity(None)

# References
#
# R. L. Norton, Design of Machinery, section 3.9: quick-return mechanisms, time ratio.
# F. Biral, E. Bertolazzi, Modelling and Simulation of Mechatronic Systems, notes of the course,
# section 2.1.3.4.
