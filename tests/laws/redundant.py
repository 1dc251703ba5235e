"""Mechanisms with redundant constraints by construction, and their reactions by the equations of free bodies.

Every mechanism is made in a pose in which it is closed: joint frames of two bodies coincide and all
coordinates are 0, or where bodies are free their places. The reactions of least norm follow from the poses
and accelerations of the bodies alone, by `numpy.linalg.lstsq` on the force and moment balance of each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import symbody as sb
from tests.laws.evaluation import evaluator
from tests.laws.rotations import Array

ENTRIES = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# What a joint locks along x, y, z of its frame, and about them; its axis, or the normal of a plane, is z.
LOCKED = {
    "Revolute": (0, 1, 2, 3, 4),
    "Cylindrical": (0, 1, 3, 4),
    "Prismatic": (0, 1, 3, 4, 5),
    "Spherical": (0, 1, 2),
    "Weld": (0, 1, 2, 3, 4, 5),
    "PointOnPlane": (2,),
}


@dataclass(frozen=True, slots=True)
class Link:
    """A joint or a point on a plane: the bodies it connects, its place, and the rotation of its frames."""

    kind: str
    bodies: tuple[str, str]
    place: Array
    axes: Array


@dataclass(frozen=True, slots=True)
class Build:
    """A mechanism in its pose; axes of bodies are those of ground."""

    masses: dict[str, float]
    centres: dict[str, Array]
    inertias: dict[str, Array]
    links: dict[str, Link]
    gravity: Array

    @property
    def length(self) -> float:
        """The largest distance between two frames on one body or on ground; 1 where there is none."""
        places: dict[str, list[Array]] = {}
        for link in self.links.values():
            for body in link.bodies:
                places.setdefault(body, []).append(link.place)
        found = [float(np.linalg.norm(a - b)) for own in places.values() for a in own for b in own]
        return max(found) or 1.0


def random_build(seed: int) -> Build:
    """A mechanism of one of the families, turned as a whole; names and order are drawn too."""
    random = np.random.default_rng(seed)
    family = (_hinges, _guides, _wheels, _polygon, _cranks, _chain, _door_on_drawer, _welds)[seed % 8]
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    links = [(kind, bodies, turn @ place, turn @ axes) for kind, bodies, place, axes in family(random)]
    bodies = sorted({body for _, pair, *_ in links for body in pair} - {"ground"})
    near = {b: np.mean([place for _, pair, place, _ in links if b in pair], axis=0) for b in bodies}
    names = dict(zip(bodies, _words(random, "B", len(bodies)), strict=True)) | {"ground": "ground"}
    joints = _words(random, "J", len(links))
    order = random.permutation(len(links))
    return Build(
        {names[b]: float(random.uniform(0.5, 5.0)) for b in random.permutation(bodies)},
        {names[b]: near[b] + random.normal(size=3) * 0.2 for b in bodies},
        {names[b]: random.uniform(0.4, 0.6, 3) for b in bodies},
        {joints[k]: Link(links[k][0], (names[links[k][1][0]], names[links[k][1][1]]), *links[k][2:])
         for k in order},
        random.normal(size=3) * 10.0,
    )  # fmt: skip


def model_of(build: Build) -> sb.Model:
    """The mechanism as a model."""
    frames: dict[str, dict[str, sb.Frame]] = {body: {} for body in ("ground", *build.masses)}
    elements: list[object] = []
    for name, link in build.links.items():
        for body in link.bodies:
            at = link.place - build.centres.get(body, np.zeros(3))
            frames[body][f"at_{name}"] = sb.Frame(at=at.tolist(), matrix=link.axes.tolist())
        ends = [f"{body}.at_{name}" for body in link.bodies]
        along = {"axis": "z"} if link.kind in ("Revolute", "Prismatic", "Cylindrical") else {}
        elements.append(getattr(sb, link.kind)(name, *ends, **along))
    bodies = [
        sb.Body(name, mass=mass, inertia=build.inertias[name].tolist(), frames=frames[name])
        for name, mass in build.masses.items()
    ]
    return sb.Model(
        "redundant", [*bodies, *elements], gravity=build.gravity.tolist(), ground=frames["ground"]
    )


def values_of(build: Build, eqs: sb.EquationSet, seed: int) -> tuple[list[float], dict[str, Array]]:
    """Coordinates of the pose, and reactions and motions of the bodies with random speeds."""
    random = np.random.default_rng(seed)
    q = []
    for name in eqs.coordinate_names:
        body, _, word = name.rpartition("_")
        free = body in build.centres and body not in build.links
        places = dict(zip("xyz", build.centres[body], strict=True)) if free else {}
        q.append(float(places.get(word, word == "qw" or name == f"{body}_1" and _is_spherical(build, body))))
    inside = evaluator(eqs, ["jacobian"]) if eqs.multiplier_names else None
    n = len(eqs.speed_names)
    speeds = random.normal(size=n)
    if inside is not None:
        rows = inside(0.0, q, [0.0] * n, [])["jacobian"].reshape(-1, n)
        speeds = speeds - np.linalg.pinv(rows, rcond=1e-9) @ (rows @ speeds)
    outputs = [f"reaction {name}" for name in build.links]
    outputs += [
        f"frame {kind} {body} ground ground" for body in build.masses for kind in ("vdot", "w", "wdot")
    ]
    return q, evaluator(eqs, outputs)(0.0, q, speeds.tolist(), [])


def statics(build: Build) -> tuple[Array, list[tuple[str, int]]]:
    """The balance matrix (6 bodies, locked directions), and the (link, entry) of each column.

    A column is what a unit force, or a moment of 1 N times the length L, does to the bodies in axes of ground
    about their centres of mass: reactions act on the second body at the link's place.
    """
    places = {body: 6 * k for k, body in enumerate(build.masses)}
    columns, names = [], []
    for name, link in build.links.items():
        for entry in LOCKED[link.kind]:
            column = np.zeros(6 * len(places))
            force, moment = np.zeros(3), np.zeros(3)
            if entry < 3:
                force = link.axes[:, entry]
            else:
                moment = link.axes[:, entry - 3] * build.length
            for body, sign in zip(link.bodies, (-1.0, 1.0), strict=True):
                if body in places:
                    at = places[body]
                    arm = link.place - build.centres[body]
                    column[at : at + 3] += sign * force
                    column[at + 3 : at + 6] += sign * (moment + np.cross(arm, force))
            columns.append(column)
            names.append((name, entry))
    return np.array(columns).T, names


def demands(build: Build, found: dict[str, Array]) -> Array:
    """What the links together must give the bodies: inertia less weight."""
    parts = []
    for body, mass in build.masses.items():
        a, w, alpha = (found[f"frame {kind} {body} ground ground"] for kind in ("vdot", "w", "wdot"))
        inertia = np.diag(build.inertias[body])
        parts += [mass * (a - build.gravity), inertia @ alpha + np.cross(w, inertia @ w)]
    return np.concatenate(parts)


def _words(random: np.random.Generator, letter: str, count: int) -> list[str]:
    return [f"{letter}{k}" for k in random.permutation(90)[:count]]


def _is_spherical(build: Build, name: str) -> bool:
    return name in build.links and build.links[name].kind == "Spherical"


Family = list[tuple[str, tuple[str, str], Array, Array]]
_E = np.eye(3)


def _hinges(random: np.random.Generator) -> Family:
    """A door on two to four hinges on one line, some of which leave more free."""
    count = int(random.integers(2, 5))
    kinds = ["Revolute", *random.choice(["Revolute", "Cylindrical", "Spherical"], count - 1)]
    heights = np.cumsum(random.uniform(0.3, 1.0, count))
    return [(str(k), ("ground", "a"), np.array([0, 0, z]), _E) for k, z in zip(kinds, heights, strict=True)]


def _guides(random: np.random.Generator) -> Family:
    count = int(random.integers(2, 4))
    kinds = ["Prismatic", *random.choice(["Prismatic", "Cylindrical"], count - 1)]
    return [(str(kind), ("ground", "a"), random.normal(size=3), _E) for kind in kinds]


def _wheels(random: np.random.Generator) -> Family:
    """A cart on three to six points on one plane; three determine everything."""
    count = int(random.integers(3, 7))
    places = [np.array([*random.uniform(-1, 1, 2), 0.0]) for _ in range(count)]
    return [("PointOnPlane", ("ground", "a"), place, _E) for place in places]


def _polygon(random: np.random.Generator) -> Family:
    """A planar loop of four to six bodies, ground among them; one joint may leave more free."""
    count = int(random.integers(4, 7))
    angles = np.sort(random.uniform(0, 2 * np.pi, count))
    angles = angles + np.linspace(0, 2 * np.pi, count, endpoint=False)
    radii = random.uniform(0.5, 1.5, count)
    corners = [np.array([r * np.cos(a / 2), r * np.sin(a / 2), z]) for r, a, z in
               zip(radii, angles, random.normal(size=count) * 0.1, strict=True)]  # fmt: skip
    kinds = ["Revolute"] * count
    if random.integers(2):
        kinds[int(random.integers(count))] = str(random.choice(["Cylindrical", "Spherical"]))
    bodies = ["ground", *"abcdef"[: count - 1], "ground"]
    return [(kinds[k], (bodies[k], bodies[k + 1]), corners[k], _E) for k in range(count)]


def _cranks(random: np.random.Generator) -> Family:
    """Three or four parallel cranks of one length on a coupler: values decide that it moves."""
    crank, count = random.uniform(-1, 1, 2) + np.array([0.0, 1.5]), int(random.integers(3, 5))
    found: Family = []
    for k in range(count):
        foot = np.array([k + random.uniform(0, 0.5), random.uniform(-0.3, 0.3), 0.0])
        found.append(("Revolute", ("ground", f"c{k}"), foot, _E))
        found.append(("Revolute", (f"c{k}", "rod"), foot + np.array([*crank, 0.0]), _E))
    return found


def _chain(random: np.random.Generator) -> Family:
    """A tree: nothing is redundant."""
    bodies = ["ground", *"abcd"[: int(random.integers(1, 5))]]
    kinds = ["Revolute", "Prismatic", "Cylindrical", "Spherical", "Weld"]
    found: Family = []
    for k, body in enumerate(bodies[1:]):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        axes *= np.sign(np.linalg.det(axes))
        inward = bodies[int(random.integers(k + 1))]
        found.append((str(random.choice(kinds)), (inward, body), random.normal(size=3), axes))
    return found


def _door_on_drawer(random: np.random.Generator) -> Family:
    guides = [(kind, bodies, place, np.roll(_E, 1, axis=1)) for kind, bodies, place, _ in _guides(random)]
    hinges = [(kind, ("a", "b"), place, axes) for kind, _, place, axes in _hinges(random)]
    return [*guides, *hinges]


def _welds(random: np.random.Generator) -> Family:
    """A body welded to another in several places; that one turns."""
    welds = [("Weld", ("a", "b"), random.normal(size=3), _E) for _ in range(int(random.integers(2, 4)))]
    return [("Revolute", ("ground", "a"), random.normal(size=3), _E), *welds]


TREES = (None, "joints", "absolute")
