"""Slider-crank with clearance.

The slider of an engine has a millimetre of play in its guide: it flies from wall to wall, strikes with one
corner or with two, tilts, slides along a wall and leaves it again. Four rigid contacts, a corner each, with
little friction. Nothing drives the crank; each impact takes some of its speed. The slider begins with a
slight tilt, without which two corners would always strike together.

Check: at each impact the angular velocities jump by `M^-1 (W_n - mu s W_t) P`, with `M` the inertia of the
three angles, `W_n` and `W_t` how gap and slip of the corners depend on them, and `s` the sign of the slip;
the impulses `P` end the approach, and grow by their restitution (Poisson). Matrices by hand here; between
impacts the energy falls by friction alone. Sizes of P. Flores, R. Leine, C. Glocker, Modeling and analysis
of planar rigid multibody systems with translational clearance joints based on the non-smooth dynamics
approach, Multibody Syst. Dyn. 23 (2010) 165.
"""

from itertools import combinations

import numpy as np

import symbody as sb

CRANK, ROD = 0.153, 0.306  # m
HALF, PLAY = (0.05, 0.025), 0.001  # m, of the slider; on each side of it
MASSES, TURNS = (0.038, 0.038, 0.076), (7.4e-5, 5.9e-4, 2.7e-6)  # kg, kg m^2: crank, rod, slider
E, MU, G = 0.4, 0.01, 9.81
SPEEDS, TILT = (150.0, -75.0), 0.005  # rad/s, of crank and rod at the start; rad, of the slider
CORNERS = {"upper rear": (-1, 1), "upper front": (1, 1), "lower rear": (-1, -1), "lower front": (1, -1)}
TOLERANCE = 1e-8  # rad/s
LOOK = {"view": "front", "vectors": list(CORNERS)}


def bar(name, k, length, color):
    """Return a uniform bar along x, its ends the frames near and far."""
    ends = {"near": sb.Frame((-length / 2, 0, 0)), "far": sb.Frame((length / 2, 0, 0))}
    shape = sb.Box((length, 0.012, 0.008), color=color)
    return sb.Body(name, MASSES[k], (0, 0, TURNS[k]), frames=ends, shapes=[shape])


def model():
    """Return the mechanism; its guide is along x."""
    (a, b), wall = HALF, HALF[1] + PLAY
    corners = {name.replace(" ", "_"): sb.Frame((x * a, y * b, 0)) for name, (x, y) in CORNERS.items()}
    ground = {
        "upper": sb.Frame((0, wall, 0), rotate=[("x", "pi/2")]),
        "lower": sb.Frame((0, -wall, 0), rotate=[("x", "-pi/2")]),
    }
    parts = [
        bar("Crank", 0, CRANK, "orange"), bar("Rod", 1, ROD, "steelblue"),
        sb.Body("Slider", MASSES[2], (0, 0, TURNS[2]), frames=corners,
                shapes=[sb.Box((2 * a, 2 * b, 0.03), color="silver", opacity=0.7)]),
        sb.Revolute("shaft", "ground", "Crank.near", axis="z", coordinate="phi"),
        sb.Revolute("crank pin", "Crank.far", "Rod.near", axis="z", coordinate="rod"),
        sb.Revolute("wrist pin", "Rod.far", "Slider", axis="z", coordinate="tilt"),
    ]  # fmt: skip
    parts += [
        sb.Contact(name, f"ground.{name[:5]}", f"Slider.{name.replace(' ', '_')}", ["plane", "point"],
                   normal="rigid", restitution=E, friction=sb.Friction(mu=MU))
        for name in CORNERS
    ]  # fmt: skip
    walls = [sb.Box((0.46, 0.01, 0.04), at=(0.31, y * (wall + 0.005), 0), opacity=0.5) for y in (-1, 1)]
    first = {"tilt": TILT, "phi_dot": SPEEDS[0], "rod_dot": SPEEDS[1] - SPEEDS[0], "tilt_dot": -SPEEDS[1]}
    return sb.Model("clearance", parts, gravity=(0, -G, 0), ground=ground, ground_shapes=walls, initial=first)


def motion():
    """Return two turns of the crank or so."""
    return sb.simulate(sb.form_equations(model()), 0.2, rtol=1e-10)


def matrices(angles):
    """Return M, and for each corner its gap and the slopes of gap and slip, by hand; angles from x."""
    (s1, s2, s3), (c1, c2, c3) = np.sin(angles), np.cos(angles)
    (m1, m2, m3), (J1, J2, J3), (a, b) = MASSES, TURNS, HALF
    coupled = (m2 / 2 + m3) * CRANK * ROD * np.cos(angles[0] - angles[1])
    inertia = [
        [J1 + (m1 / 4 + m2 + m3) * CRANK**2, coupled, 0],
        [coupled, J2 + (m2 / 4 + m3) * ROD**2, 0],
        [0, 0, J3],
    ]
    gaps, normal, tangential = [], [], []
    for x, y in CORNERS.values():
        height = CRANK * s1 + ROD * s2 + x * a * s3 + y * b * c3
        gaps.append(b + PLAY - y * height)
        normal.append([-y * CRANK * c1, -y * ROD * c2, -y * (x * a * c3 - y * b * s3)])
        tangential.append([-CRANK * s1, -ROD * s2, -x * a * s3 - y * b * c3])
    return np.array(inertia), np.array(gaps), np.array(normal), np.array(tangential)


def impulses(G, rates):
    """Return the least impulses, never negative, that leave no rate negative: all sets are tried."""
    for count in range(len(rates) + 1):
        for active in map(list, combinations(range(len(rates)), count)):
            P = np.zeros(len(rates))
            P[active] = np.linalg.solve(G[np.ix_(active, active)], -rates[active])
            if (P >= 0).all() and (rates + G @ P >= -1e-9 * np.abs(rates).max()).all():
                return P
    raise ValueError("no impulses")


def comparison(run):
    """Return the angular velocities behind impacts in which nothing stops sliding, and those by hand."""
    strikes = {(each.name, each.t) for each in run.events if each.name.endswith("impact")}
    places = np.searchsorted(run.t, sorted({t for _, t in strikes}))
    angles = np.cumsum([run["phi"], run["rod"], run["tilt"]], axis=0)
    rates = np.cumsum([run["phi_dot"], run["rod_dot"], run["tilt_dot"]], axis=0)
    found, formula = [], []
    for k in places:
        inertia, gaps, W, slips = matrices(angles[:, k])
        struck = [(f"{name} impact", run.t[k]) in strikes for name in CORNERS]
        touch = struck | (gaps < 1e-10)
        W, slips = W[touch], slips[touch]
        if (W @ rates[:, k]).min() > -0.002:  # m/s: the last one of a series, which closes the gap
            continue
        sides = np.sign(slips @ rates[:, k])
        push = np.linalg.solve(inertia, (W - MU * sides[:, None] * slips).T)
        P = impulses(W @ push, W @ rates[:, k])
        P = P + E * P
        behind = rates[:, k] + push @ P
        P = P + impulses(W @ push, W @ behind)
        behind = rates[:, k] + push @ P
        if (np.sign(slips @ behind) == sides).all():
            found.append(rates[:, k + 1])
            formula.append(behind)
    return np.array(found), np.array(formula)


def draw(run, ax):
    """Draw the height of the middle of the slider over the turns of the crank, and the impacts."""
    at = run.at(np.linspace(0.0, 0.155, 4001))
    ax.plot(at["phi"] / (2 * np.pi), 1e3 * at["frame r Slider ground ground y"], color="steelblue", lw=1)
    for edges in ((PLAY, 1.3e-3), (-1.3e-3, -PLAY)):
        ax.axhspan(*np.multiply(edges, 1e3), color="0.85")
    for color, name in zip(("C1", "C3", "C2", "C4"), CORNERS, strict=True):
        strikes = run.at([each.t for each in run.events if each.name == f"{name} impact" and each.t < 0.155])
        ax.plot(strikes["phi"] / (2 * np.pi), 1e3 * strikes["frame r Slider ground ground y"], "o",
                ms=4, color=color, label=name)  # fmt: skip
    ax.set(
        xlabel="turns of the crank", ylabel="height of the slider [mm]", xlim=(-0.05, 2.3), ylim=(-1.3, 2.0)
    )
    ax.legend(loc="upper center", ncols=4, fontsize=8, columnspacing=1, title="strikes with its corner")
    ax.set_title("A slider between two walls")
