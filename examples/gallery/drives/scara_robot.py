"""SCARA robot with computed torques.

Two links turn about vertical axes, a quill moves up and down at the end and turns the gripper: stiff
against the weight, soft against pushes from the side, fast. Its motors apply the torques that the
equations of motion give for the path, plus a feedback of the deviation.

Check: with torques `M(q) (q_d'' + 2 p (q_d' - q') + p^2 (q_d - q)) + h(q, q')` each deviation decays as
`e_0 (1 + p t) exp(-p t)`, regardless of the motion of the arm, if and only if `M` and `h`, written out by
hand here, are those of the arm: the method of computed torque, R. P. Paul, Modelling, trajectory
calculation and servoing of a computer controlled arm, AIM-177, Stanford 1972.
"""

import numpy as np

import symbody as sb

UPPER, FORE = 0.35, 0.25  # m
MASSES, TURNS, TOOL = (6.0, 3.0, 1.5), (0.07, 0.02), 0.002  # kg, kg m^2, kg m^2
POLE = 8.0  # 1/s
AIM = {"a": "0.9*sin(2*t)", "b": "1.3 + 0.6*cos(2*t)", "z": "-0.09 + 0.07*cos(4*t)", "c": "t - sin(t)"}
SPEED = {"a": "1.8*cos(2*t)", "b": "-1.2*sin(2*t)", "z": "-0.28*sin(4*t)", "c": "1 - cos(t)"}
RATE = {"a": "-3.6*sin(2*t)", "b": "-2.4*cos(2*t)", "z": "-1.12*cos(4*t)", "c": "sin(t)"}
TOLERANCE = 1e-9  # rad, m
LOOK = {"times": (0.9, 2.4), "traces": ["Quill.tip"], "view": (0.9, -1.1, 0.7)}


def efforts():
    """Return the signals of the controller, and the efforts of the motors."""
    yield from (
        sb.Signal(f"v{q}", f"{RATE[q]} + 2*p*({SPEED[q]} - {q}_dot) + p^2*({AIM[q]} - {q})") for q in AIM
    )
    yield sb.Signal(
        "Ta", "(J1 + J2 + 2*k*cos(b))*va + (J2 + k*cos(b))*vb + It*vc - k*sin(b)*(2*a_dot + b_dot)*b_dot"
    )
    yield sb.Signal("Tb", "(J2 + k*cos(b))*va + J2*vb + It*vc + k*sin(b)*a_dot^2")
    yield sb.Signal("Tc", "It*(va + vb + vc)")
    yield sb.Signal("Fz", "m3*(vz + g)")


def link(name, mass, turn, length, rise, color):
    """Return a link along x, its centre of mass in the middle."""
    ends = {"near": sb.Frame((-length / 2, 0, -rise)), "far": sb.Frame((length / 2, 0, 0))}
    drum = [sb.Cylinder(0.055, 0.09, at=(x, 0, 0), color=color) for x in (-length / 2, length / 2)]
    bar = sb.Box((length, 0.075, 0.06), color=color)
    return sb.Body(name, mass, (0.02, turn, turn), frames=ends, shapes=[bar, *drum])


def model():
    """Return the mechanism."""
    m1, m2, m3 = MASSES
    quill = [
        sb.Cylinder(0.016, 0.42, at=(0, 0, 0.1), color="silver"),
        sb.Box((0.07, 0.02, 0.04), at=(0, 0, -0.12)),
    ]
    parts = [
        link("Upper", "m1", "I1", UPPER, 0, "orange"), link("Fore", "m2", "I2", FORE, 0.09, "steelblue"),
        sb.Body("Quill", "m3", (0.02, 0.02, "It"), shapes=quill, frames={"tip": sb.Frame((0, 0, -0.14))}),
        sb.Body("Slide"),
        sb.Revolute("shoulder", "ground.top", "Upper.near", coordinate="a", torque=sb.Drive("Ta")),
        sb.Revolute("elbow", "Upper.far", "Fore.near", coordinate="b", torque=sb.Drive("Tb")),
        sb.Prismatic("lift", "Fore.far", "Slide", axis="z", coordinate="z", force=sb.Drive("Fz")),
        sb.Revolute("wrist", "Slide", "Quill", coordinate="c", torque=sb.Drive("Tc")),
        *efforts(),
    ]  # fmt: skip
    sizes = {
        "m1": m1, "m2": m2, "m3": m3, "I1": TURNS[0], "I2": TURNS[1], "It": TOOL, "l": UPPER, "f": FORE,
        "J1": "I1 + m1*l^2/4 + (m2 + m3)*l^2", "J2": "I2 + m2*f^2/4 + m3*f^2 + It", "k": "l*(m2*f/2 + m3*f)",
        "p": POLE, "g": 9.81,
    }  # fmt: skip
    post = [sb.Cylinder(0.07, 0.24, at=(0, 0, 0.12), color="gray")]
    first = {"a": 0.5, "a_dot": 1.8, "b": 1.5, "b_dot": 0, "z": 0.03, "z_dot": 0, "c": 0.3, "c_dot": 0}
    return sb.Model("SCARA robot", parts, gravity=(0, 0, "-g"), parameters=sizes, ground_shapes=post,
                    ground={"top": sb.Frame((0, 0, 0.3))}, initial=first)  # fmt: skip


def motion():
    """Return a turn of the path, from rest beside it."""
    return sb.simulate(sb.form_equations(model()), 3.0, times=np.linspace(0, 3, 301), rtol=1e-10, atol=1e-12)


def comparison(run):
    """Return the four coordinates, and path and deviation by the formulas."""
    t = run.t
    aim = np.array(
        [0.9 * np.sin(2 * t), 1.3 + 0.6 * np.cos(2 * t), -0.09 + 0.07 * np.cos(4 * t), t - np.sin(t)]
    )
    first = np.array([0.5, -0.4, 0.05, 0.3])  # deviations; all rates are those of the path
    return np.array([run[q] for q in "abzc"]), aim + np.outer(first, (1 + POLE * t) * np.exp(-POLE * t))
