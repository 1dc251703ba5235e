"""Cycloid drive.

An eccentric pushes a lobed disc around inside a ring of pins; the disc has one lobe less than there are
pins, so with each turn of the eccentric it turns back by one lobe. Pins in larger holes transmit its
rotation. Joints of robots have such gears: a large ratio, many teeth in contact, hardly any play.

Check: a pin at `R`, seen from a disc with its centre at `e exp(i phi)` and turned by `-phi/(N - 1)`, goes
along `R exp(i s) - e exp(i N s)`, `s = phi/(N - 1)`: an epitrochoid of `N - 1` lobes, with which the disc
is cut. The motion holds two pins on that curve; the rotation of the disc and the positions of all other
pins are the check.
"""

import numpy as np

import symbody as sb

PINS, RADIUS, OFFSET = 11, 0.1, 0.005  # number, m, m
HELD = (0, 3)  # pins; one alone leaves the disc free where it stands on the top of a lobe
TOLERANCE = 1e-8
LOOK = {"times": (0.0,), "view": (0.1, -0.35, 1.0)}


def outline(s):
    """Return the curve of the disc as complex numbers."""
    return RADIUS * np.exp(1j * s) - OFFSET * np.exp(1j * PINS * s)


def curve(s):
    """Return the same curve in the parameter s for the model."""
    return (f"R*cos({s}) - e*cos({PINS}*{s})", f"R*sin({s}) - e*sin({PINS}*{s})", 0)


def model():
    """Return the mechanism."""
    holes = 0.055 * np.exp(2j * np.pi * np.arange(6) / 6)
    disc = [sb.Cylinder(0.025, 0.014, color="steelblue")]
    studs = [sb.Cylinder(0.008, 0.03, at=(float(z.real), float(z.imag), 0), color="crimson") for z in holes]
    pins = [
        sb.Cylinder(0.005, 0.02, at=(float(z.real), float(z.imag), 0), color="gray")
        for z in RADIUS * np.exp(2j * np.pi * np.arange(PINS) / PINS)
    ]
    parts = [
        sb.Body("Eccentric", 0.1, (0, 0, 1e-5), frames={"centre": sb.Frame(("e", 0, 0))},
                shapes=[sb.Cylinder(0.01, 0.02, color="black")]),
        sb.Body("Disc", 0.5, (0, 0, 2e-3), shapes=disc),
        sb.Body("Output", 0.3, (0, 0, 1e-3), shapes=studs),
        sb.Revolute("input", "ground", "Eccentric", coordinate="phi", motion="2*pi*t"),
        sb.Revolute("bearing", "Eccentric.centre", "Disc", coordinate="turn"),
        sb.Revolute("output", "ground", "Output", coordinate="psi"),
        *(
            sb.PointOnCurve(f"pin{k}", "Disc", f"ground.pin{k}", parameter=f"s{k}", curve=curve(f"s{k}"))
            for k in HELD
        ),
        sb.Constraint("studs", "psi - phi - turn"),  # pins in holes keep both parallel
    ]  # fmt: skip
    angles = {k: 2 * np.pi * k / PINS for k in HELD}
    ground = {
        f"pin{k}": sb.Frame((float(RADIUS * np.cos(a)), float(RADIUS * np.sin(a)), 0))
        for k, a in angles.items()
    }
    sizes = {"R": RADIUS, "e": OFFSET}
    first = {f"s{k}": a for k, a in angles.items()}
    return sb.Model(
        "cycloid drive", parts, ground=ground, ground_shapes=pins, initial=first, parameters=sizes
    )


def motion():
    """Return a turn of the output."""
    end = PINS - 1.0
    return sb.simulate(
        sb.form_equations(model()), end, times=np.linspace(0, end, 401), constraints=sb.Partition()
    )


def comparison(run):
    """Return the angle of the output and where all pins are for the disc, and the formulas."""
    place = run["frame r Disc ground ground"]
    centre, angle = place[0] + 1j * place[1], run["phi"] + run["turn"]
    k = np.arange(PINS)[:, None]
    pins = (RADIUS * np.exp(2j * np.pi * k / PINS) - centre) * np.exp(-1j * angle)
    curve = outline(run["phi"] / (PINS - 1) + 2 * np.pi * k / PINS)
    formula = [-run["phi"][None] / (PINS - 1), curve.real, curve.imag]
    return np.vstack([run["psi"][None], pins.real, pins.imag]), np.vstack(formula)
