"""Delta robot.

Three motors on the ceiling move a plate by arms and pairs of rods, which keep the plate parallel to the
ceiling; nothing heavy moves, so it is fast enough to pick several objects a second.

Check: the arms' angles for a position of the plate are roots of `E cos(q) + F sin(q) + G = 0`, from the
length of the rods alone: R. Clavel, Device for the movement and positioning of an element in space, US
patent 4,976,582 (1990); formula in R. L. Williams II, The Delta Parallel Robot: Kinematics Solutions,
Ohio University 2015.
"""

import numpy as np

import symbody as sb

BASE, PLATE, ARM, ROD = 0.2, 0.05, 0.3, 0.7  # m
TOLERANCE = 1e-8
LOOK = {"times": (0.1, 0.4), "traces": ["Plate"], "view": (1.0, -1.4, 0.5)}
WAY = ("0.2*cos(2*pi*t)", "0.15*sin(2*pi*t)", "-0.6 + 0.08*cos(4*pi*t)")  # of the plate


def model():
    """Return the mechanism."""
    joints = {f"j{k}": sb.Frame(rotate=[("z", f"2*pi*{k}/3")]) for k in range(3)}
    mounts = {
        f"m{k}": sb.Frame((f"{PLATE}*cos(2*pi*{k}/3)", f"{PLATE}*sin(2*pi*{k}/3)", 0)) for k in range(3)
    }
    shapes = [sb.Cylinder(PLATE, 0.02, color="orange")]
    parts = [
        sb.Body("Plate", 0.5, (0.001, 0.001, 0.001), frames=mounts, shapes=shapes),
        sb.Cartesian(
            "way", "ground", "Plate", coordinates=["x", "y", "z"], motion=dict(zip("xyz", WAY, strict=True))
        ),
    ]
    posts = dict(joints)
    for k in range(3):
        place = (f"{BASE}*cos(2*pi*{k}/3)", f"{BASE}*sin(2*pi*{k}/3)", 0)
        posts[f"j{k}"] = sb.Frame(place, rotate=[("z", f"2*pi*{k}/3")])
        ends = {"hip": sb.Frame((-ARM / 2, 0, 0)), "elbow": sb.Frame((ARM / 2, 0, 0))}
        parts += [
            sb.Body(f"Arm{k}", 0.3, (0.0001, 0.002, 0.002), frames=ends),
            sb.Revolute(f"motor{k}", f"ground.j{k}", f"Arm{k}.hip", "y", f"q{k}"),
            sb.Distance(f"rod{k}", f"Arm{k}.elbow", f"Plate.m{k}", ROD),
        ]
    box = sb.Cylinder(BASE, 0.02, at=(0, 0, 0.02), opacity=0.4)
    return sb.Model(
        "delta robot", parts, gravity=(0, 0, -9.81), ground=posts, ground_shapes=[box],
        initial={"q0": 0.3, "q1": 0.3, "q2": 0.3},
    )  # fmt: skip


def motion():
    """Return the arms while the plate goes around."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the arms' angles, and those of the inverse kinematics."""
    formula = []
    for k in range(3):
        angle = 2 * np.pi * k / 3
        # The plate's mount as the arm's plane sees it: outwards, across, upwards.
        out = run["x"] * np.cos(angle) + run["y"] * np.sin(angle) + PLATE - BASE
        across, up = run["y"] * np.cos(angle) - run["x"] * np.sin(angle), run["z"]
        E, F = -2 * ARM * out, 2 * ARM * up
        G = out**2 + across**2 + up**2 + ARM**2 - ROD**2
        formula.append(2 * np.arctan((-F - np.sqrt(E**2 + F**2 - G**2)) / (G - E)))
    return np.array([run[f"q{k}"] for k in range(3)]), np.array(formula)
