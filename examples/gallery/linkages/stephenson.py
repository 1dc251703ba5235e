"""Stephenson's six-bar linkage as a walking leg.

A crank drives a coupler, whose far end carries the knee of a leg that a second rocker holds at the hip:
the chain of six bars that bears Stephenson's name, third kind. The foot is on the ground for half of a
turn and steps during the other half; J. Klann's walking machines have such legs (US patent 6,260,862).

Check: the whole path of the foot, from the lengths alone: each of the three bodies behind the crank has
two points on known circles, so its position follows from where two circles meet,
`p + (a u +- sqrt(r^2 - a^2) v)` with `u` the unit vector from `p` to `q`, `v` across it,
`a = (d^2 + r^2 - s^2)/(2 d)`. Derived here.
"""

import numpy as np

import symbody as sb

CRANK, LOWER, UPPER = 0.18, 0.24, 0.34  # m: crank, rocker of the coupler, rocker of the leg
NEAR, FAR, KNEE = 0.39, 0.35, 0.735  # coupler: crank pin to rocker pin, rocker pin to knee, crank pin to knee
THIGH, SHANK, REACH = 0.58, 0.59, 1.12  # leg: hip to knee, knee to foot, hip to foot
POSTS = {"B": (-0.39, -0.12), "D": (-0.15, 0.42)}
TOLERANCE = 1e-8
LOOK = {"times": (0.0, 0.25, 0.5, 0.75), "traces": ["Leg.foot"]}


def meet(p, q, r, s, side=-1):
    """Return where circles about p and q, of radii r and s, meet; side 1 is left of the way from p to q."""
    way = q - p
    d = abs(way)
    along = (d**2 + r**2 - s**2) / (2 * d)
    return p + way / d * (along + 1j * side * np.sqrt(r**2 - along**2))


def places(theta):
    """Return crank pin, rocker pin, knee, hip and foot as complex numbers."""
    B, D = (complex(*POSTS[name]) for name in "BD")
    C = CRANK * np.exp(1j * theta)
    H = meet(B, C, LOWER, NEAR, side=1)
    F = meet(H, C, FAR, KNEE)
    E = meet(D, F, UPPER, THIGH)
    return C, H, F, E, meet(F, E, SHANK, REACH)


def body(name, places):
    """Return a body with points at given places, its axes those of the ground in the first position."""
    middle = sum(places.values()) / len(places)
    frames = {
        key: sb.Frame((float((z - middle).real), float((z - middle).imag), 0)) for key, z in places.items()
    }
    return sb.Body(name, 1.0, (0, 0, 0.02), frames=frames)


def model():
    """Return the mechanism; all angles are 0 in the first position."""
    C, H, F, E, G = places(0.0)
    B, D = (complex(*POSTS[name]) for name in "BD")
    parts = [
        body("Crank", {"A": 0j, "C": C}),
        body("Coupler", {"C": C, "H": H, "F": F}),
        body("Rocker", {"B": B, "H": H}),
        body("Arm", {"D": D, "E": E}),
        body("Leg", {"F": F, "E": E, "foot": G}),
        sb.Revolute("A", "ground", "Crank.A", coordinate="theta", motion="2*pi*t"),
        sb.Revolute("C", "Crank.C", "Coupler.C", coordinate="coupler"),
        sb.Revolute("B", "ground.B", "Rocker.B", coordinate="rocker"),
        sb.Revolute("H", "Coupler.H", "Rocker.H"),
        sb.Revolute("F", "Coupler.F", "Leg.F", coordinate="knee"),
        sb.Revolute("D", "ground.D", "Arm.D", coordinate="hip"),
        sb.Revolute("E", "Leg.E", "Arm.E"),
    ]
    ground = {name: sb.Frame((*place, 0)) for name, place in POSTS.items()}
    return sb.Model("Stephenson linkage", parts, gravity=(0, -9.81, 0), ground=ground)


def motion():
    """Return one turn of the crank."""
    return sb.simulate(sb.form_equations(model()), 1.0, times=np.linspace(0, 1, 201))


def comparison(run):
    """Return the place of the foot, and the formula."""
    foot = places(2 * np.pi * run.t)[-1]
    return run["frame r Leg.foot ground ground"][:2], np.array([foot.real, foot.imag])
