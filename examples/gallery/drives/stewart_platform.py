"""Stewart platform.

Six legs that change their lengths carry a plate and move it in all six degrees of freedom: flight
simulators, machine tools, antennas. The lengths for a given path of the plate are easy to compute; the
position of the plate for given lengths is the hard problem, which the motion solves here.

Check: legs with the lengths for the path `x(t)`, `R(t)`, `|x + R b - a|` with feet `a` and joints `b`,
move the plate along that path; and the forces of the legs are those of six linear equations,
`sum f u = m (x'' + g)`, `sum (R b) cross f u = I w'`, for a plate that turns about an axis of its own
with `w'`, `u` the directions of the legs. D. Stewart, A platform with six degrees of freedom, Proc. Inst.
Mech. Eng. 180 (1965), 371-386.
"""

import numpy as np

import symbody as sb

BASE, PLATE, MASS, TURN = 0.6, 0.35, 80.0, 3.0  # m, m, kg, kg m^2
FEET = [(BASE, k * np.pi / 3 + (-1) ** k * 0.35) for k in range(6)]
JOINTS = [(PLATE, k * np.pi / 3 - (-1) ** k * 0.35) for k in range(6)]
TOLERANCE = 1e-8  # m, rad, kN
LOOK = {"times": (0.15, 0.65), "view": (0.8, -1.2, 0.45)}
WAY = {"x": "0.12*cos(2*pi*t)", "y": "0.12*sin(2*pi*t)", "z": "0.75 + 0.05*sin(4*pi*t)"}
ROLL = "0.25*sin(2*pi*t)"  # about x


def place(size, angle):
    """Return a corner of base or plate."""
    return float(size * np.cos(angle)), float(size * np.sin(angle)), 0.0


def length(foot, joint):
    """Return the formula of a leg's length."""
    (a, b, _), (c, d, _) = place(*foot), place(*joint)
    turned = (f"{c}", f"{d}*cos({ROLL})", f"{d}*sin({ROLL})")
    ways = zip(WAY.values(), turned, (a, b, 0.0), strict=True)
    return "sqrt(" + " + ".join(f"({way} + {to} - {at})^2" for way, to, at in ways) + ")"


def model():
    """Return the mechanism."""
    feet = {f"a{k}": sb.Frame(place(*foot)) for k, foot in enumerate(FEET)}
    joints = {f"b{k}": sb.Frame(place(*joint)) for k, joint in enumerate(JOINTS)}
    shapes = [sb.Cylinder(PLATE + 0.02, 0.03, at=(0, 0, 0.015), color="steelblue"),
              sb.Box((0.3, 0.22, 0.2), at=(0, 0, 0.13), color="orange")]  # fmt: skip
    plate = sb.Body("Plate", MASS, (TURN, TURN, 2 * TURN), frames=joints, shapes=shapes)
    names = ["x", "y", "z", "roll", "pitch", "yaw"]
    flight = sb.Free("flight", "ground", plate, angles="xyz", coordinates=names)
    legs = [
        sb.Distance(f"leg{k}", f"ground.a{k}", f"Plate.b{k}", length(foot, joint))
        for k, (foot, joint) in enumerate(zip(FEET, JOINTS, strict=True))
    ]
    floor = [sb.Cylinder(BASE + 0.15, 0.02, at=(0, 0, -0.07), color="lightgray")]
    return sb.Model("Stewart platform", [flight, *legs], gravity=(0, 0, -9.81), ground=feet,
                    ground_shapes=floor, initial={"x": 0.12, "z": 0.75})  # fmt: skip


def motion():
    """Return one round of the plate."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def leg_forces(x, roll, force, moment):
    """Return what the legs push with, for the force and the moment that the plate needs."""
    c, s = np.cos(roll), np.sin(roll)
    arms = np.array([place(*joint) for joint in JOINTS]) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    legs = x + arms - np.array([place(*foot) for foot in FEET])
    along = legs / np.linalg.norm(legs, axis=1, keepdims=True)
    return np.linalg.solve(np.hstack([along, np.cross(arms, along)]).T, [*force, *moment])


def comparison(run):
    """Return the six coordinates and the six forces in kN, and the formulas."""
    t, w = run.t, 2 * np.pi
    c, s, fast = np.cos(w * t), np.sin(w * t), np.sin(2 * w * t)
    x = np.array([0.12 * c, 0.12 * s, 0.75 + 0.05 * fast])
    force = MASS * np.array([-0.12 * w**2 * c, -0.12 * w**2 * s, 9.81 - 0.2 * w**2 * fast])
    moment = np.outer([-0.25 * w**2 * TURN, 0, 0], s)
    forces = [leg_forces(*each) for each in zip(x.T, 0.25 * s, force.T, moment.T, strict=True)]
    names = ("x", "y", "z", "roll", "pitch", "yaw")
    computed = [*(run[name] for name in names), *(run[f"lambda_leg{k}_1"] / 1000 for k in range(6))]
    return np.array(computed), np.vstack([x, 0.25 * s, 0 * t, 0 * t, np.array(forces).T / 1000])
