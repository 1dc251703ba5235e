"""Double wishbone suspension.

Two arms guide the upright of a front wheel up and down, a rod holds it against steering. As the wheel
rises it leans (camber) and steers a little by itself (bump steer); the lengths are chosen for just that.

Check: both ball joints stay in planes across the hinges of the arms, so that seen along these the upright
is the coupler of a four-bar, whose positions follow from where two circles meet. The end of the steering
arm then goes round the axis through both ball joints, and a rod's length from the rack:
`E cos(h) + F sin(h) + G = 0` for its angle. Derived here.
"""

import numpy as np

import symbody as sb

# Places in the middle position [m]: x forward, y to the left, z up; the hinges are along x.
LOW, HIGH = np.array([0.0, 0.35, 0.2]), np.array([-0.02, 0.42, 0.45])  # hinges
BALL, TOP = np.array([0.0, 0.72, 0.19]), np.array([-0.02, 0.68, 0.47])  # ball joints of the upright
STEER, RACK = np.array([-0.12, 0.69, 0.23]), np.array([-0.12, 0.36, 0.24])  # ends of the rod
WHEEL = np.array([0.0, 0.78, 0.31])
SWING = 0.22  # rad, of the lower arm
LOWER, UPPER, ROD = (float(np.linalg.norm(p - q)) for p, q in ((BALL, LOW), (TOP, HIGH), (STEER, RACK)))
TOLERANCE = 1e-8
LOOK = {"times": (0.75, 0.25), "view": (0.8, -0.9, 0.35)}


def frame(place):
    """Return a frame at a place."""
    return sb.Frame([float(each) for each in place])


def arm(name, hinge, end):
    """Return an arm from a hinge to a ball joint; its axes are those of the ground in the middle."""
    half = (end - hinge) / 2
    front, back = (frame(np.array([x, 0, 0]) - half) for x in (0.1, -0.1))
    return sb.Body(
        name,
        3.0,
        (0.02, 0.02, 0.02),
        frames={"hinge": frame(-half), "ball": frame(half), "front": front, "back": back},
    )


def model():
    """Return the mechanism."""
    ends = {"ball": BALL, "top": TOP, "steer": STEER}
    wheel = [
        sb.Cylinder(0.31, 0.19, rotate=[("x", "pi/2")], color="black", opacity=0.25),
        sb.Cylinder(0.2, 0.12, rotate=[("x", "pi/2")], color="lightgray", opacity=0.4),
        sb.Sphere(0.022, at=[float(each) for each in STEER - WHEEL], color="crimson"),
        rod(TOP - WHEEL, BALL - WHEEL),
        *(rod(end - WHEEL, (TOP + BALL) / 2 - WHEEL) for end in (STEER, WHEEL)),
    ]
    frames = {name: frame(place - WHEEL) for name, place in ends.items()}
    parts = [
        arm("Lower", LOW, BALL),
        arm("Upper", HIGH, TOP),
        sb.Body("Upright", 30.0, (0.8, 1.2, 0.8), frames=frames, shapes=wheel),
        sb.Revolute("lower hinge", "ground.low", "Lower.hinge", "x", "phi", motion=f"{SWING}*sin(2*pi*t)"),
        sb.Revolute("upper hinge", "ground.high", "Upper.hinge", "x", "psi"),
        sb.Spherical(
            "lower ball", "Lower.ball", "Upright.ball", angles="321", coordinates=["steer", "roll", "pitch"]
        ),
        sb.Spherical("upper ball", "Upper.ball", "Upright.top"),
        sb.Distance("rod", "ground.rack", "Upright.steer", ROD),
    ]
    ground = {"low": frame(LOW), "high": frame(HIGH), "rack": frame(RACK)}
    return sb.Model("double wishbone", parts, ground=ground)


def rod(p, q):
    """Return a bar between two places."""
    way = q - p
    length = float(np.linalg.norm(way))
    turns = [("z", float(np.arctan2(way[1], way[0]))), ("y", float(np.arccos(way[2] / length)))]
    return sb.Capsule(0.014, length, at=[float(each) for each in (p + q) / 2], rotate=turns, color="dimgray")


def motion():
    """Return one swing of the lower arm."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 101))


def turned(point, p, q, k, angle):
    """Return a point turned by an angle about an axis through p along k, moved along with p to q."""
    arm = point - p
    return q + arm * np.cos(angle) + np.cross(k, arm) * np.sin(angle) + k * (k @ arm) * (1 - np.cos(angle))


def places(phi):
    """Return ball joints and steering arm's end for an angle of the lower arm."""
    low, high, ball = (complex(*each[1:]) for each in (LOW, HIGH, BALL))
    first = low + (ball - low) * np.exp(1j * phi)
    d, gap = abs(first - high), np.linalg.norm((TOP - BALL)[1:])
    along = (d**2 + UPPER**2 - gap**2) / (2 * d)
    second = high + (first - high) / d * (along + 1j * np.sqrt(UPPER**2 - along**2))
    P, Q = (np.array([x, z.real, z.imag]) for x, z in ((BALL[0], first), (TOP[0], second)))
    # Any turn that brings the line of the ball joints to its place, then one about that line.
    old, new = (each / np.linalg.norm(each) for each in (TOP - BALL, Q - P))
    axis = np.cross(old, new)
    lean = float(np.arctan2(np.linalg.norm(axis), old @ new))
    axis = axis / np.linalg.norm(axis) if lean > 0 else np.array([1.0, 0, 0])
    S = turned(STEER, BALL, P, axis, lean)
    arm, base = S - P, P + new * (new @ (S - P))
    out = arm - new * (new @ arm)
    E, F = 2 * out @ (base - RACK), 2 * np.cross(new, out) @ (base - RACK)
    G = out @ out + (base - RACK) @ (base - RACK) - ROD**2
    angles = np.arctan2(F, E) + np.array([-1, 1]) * np.arccos(-G / np.hypot(E, F))
    angle = min((angles + np.pi) % (2 * np.pi) - np.pi, key=abs)
    return Q, base + out * np.cos(angle) + np.cross(new, out) * np.sin(angle)


def comparison(run):
    """Return the places of the upper ball joint and of the steering arm's end, and the formulas."""
    formula = np.array([np.concatenate(places(phi)) for phi in run["phi"]]).T
    return np.vstack([run[f"frame r Upright.{name} ground ground"] for name in ("top", "steer")]), formula
