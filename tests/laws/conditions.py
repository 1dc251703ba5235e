"""Constraints beside the joints of a random mechanism, closed at the pose that it has already.

Two frames are drawn on two bodies, then what is free in the constraint (a length, a line, a plane, an angle, the
radius of a ball, an offset) is chosen so that it holds there. Rates are found afterwards, in the null space of
the rows of loops and constraints together. Rows are independent of all others, and freedom remains.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.laws.contact_laws import row_count
from tests.laws.draws import Draws
from tests.laws.joint_laws import letters
from tests.laws.loops import demanded_rank
from tests.laws.motion import body_places, relative_place
from tests.laws.parts import ContactPart, CouplingPart, FramePart, Law, Mechanism, MotionPart, Term
from tests.laws.rotations import Array, unit

SHARE = 0.38  # of mechanisms in which constraints are tried; few bodies and freedoms leave no room for them
TRIES = 6
CONTACTS = (
    "distance", "line", "plane", "surface", "parallel", "perpendicular", "angle", "knife", "sphere", "disc",
)  # fmt: skip
LINEAR = ("gear", "rack", "belt", "differential")
COUPLINGS = ("gear", "rack", "belt", "differential", "equation", "rates")
NEAR = 0.2  # least distance of two points, and cosine of an axle with the ground, where it matters
# Coordinate, its value, "a" for angles or "d" for displacements.
Coordinates = list[tuple[str, float, str]]


def add_conditions(mechanism: Mechanism, draws: Draws) -> Mechanism:
    """The mechanism with up to three constraints, or none where none fits."""
    if not draws.chance(SHARE):
        return mechanism
    count = demanded_rank(mechanism)
    for k in range(draws.rng.choice([1, 1, 2, 3])):
        for _ in range(TRIES if count[1] > 1 else 0):
            found = _with_one(mechanism, draws, f"C{k + 1}", *count)
            if found is not None:
                mechanism, count = found
                break
    return replace(mechanism, freedoms=count[1])


def add_couplings(mechanism: Mechanism, draws: Draws) -> Mechanism:
    """The mechanism with up to three couplings of first degree, before other constraints, or none."""
    count = demanded_rank(mechanism)
    for k in range(draws.rng.choice([1, 1, 2, 3])):
        for _ in range(TRIES if count[1] > 1 else 0):
            found = _with_one(mechanism, draws, f"K{k + 1}", *count, kinds=LINEAR)
            if found is not None and not found[0].couplings[-1].offset.amplitude:
                mechanism, count = found
                break
    return replace(mechanism, freedoms=count[1])


def _with_one(
    mechanism: Mechanism,
    draws: Draws,
    name: str,
    rank: int,
    left: int,
    kinds: tuple[str, ...] = CONTACTS + COUPLINGS,
) -> tuple[Mechanism, tuple[int, int]] | None:
    """The mechanism with one constraint more, and its rank and the freedoms left.

    None if that is impossible, dependent or leaves no freedom.
    """
    kind = draws.rng.choice(kinds)
    if kind in COUPLINGS:
        coupling = _coupling(mechanism, draws, name, kind)
        if coupling is None:
            return None
        found, own = replace(mechanism, couplings=(*mechanism.couplings, coupling)), 1
    else:
        contact = _contact(mechanism, draws, name, kind)
        if contact is None:
            return None
        found, own = replace(mechanism, contacts=(*mechanism.contacts, contact)), row_count(contact)
    count = demanded_rank(found) if left > own else (-1, 0)
    if count[0] != rank + own:
        _without_frames(mechanism, name)
        return None
    return found, count


def _put(mechanism: Mechanism, body: str, name: str, frame: FramePart) -> str:
    (mechanism.ground if body == "ground" else mechanism.body(body).frames)[name] = frame
    return f"{body}.{name}"


def _without_frames(mechanism: Mechanism, name: str) -> None:
    for frames in (mechanism.ground, *(body.frames for body in mechanism.bodies)):
        frames.pop(name, None)


def _contact(mechanism: Mechanism, draws: Draws, name: str, kind: str) -> ContactPart | None:
    """A contact between new frames, called like it, of two bodies."""
    start, end = draws.rng.sample(["ground", *(body.name for body in mechanism.bodies)], 2)
    part = ContactPart(
        name, kind, _put(mechanism, start, name, draws.frame()), _put(mechanism, end, name, draws.frame())
    )
    r, axes = relative_place(mechanism, body_places(mechanism), part)
    found = _CLOSED[kind](part, r, axes, draws, mechanism.t)
    if found is None:
        _without_frames(mechanism, name)
    return found


def _distance(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    length = float(np.linalg.norm(r))
    if length < NEAR * draws.units.length:
        return None
    return replace(part, value=_value(draws, length, draws.units.length, t))


def _line(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    length = np.linalg.norm(r)
    return replace(part, axis=_triple(r / length)) if length > NEAR * draws.units.length else None


def _plane(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    return replace(part, axis=_triple(_perpendicular(r, draws)))


def _surface(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    """One or two surfaces, each a sum of functions of x, y and z."""
    known = dict(zip("xyz", (float(x) for x in r), strict=True))
    laws: list[Law] = []
    for _ in range(draws.rng.choice([1, 1, 2])):
        functions = (draws.rng.choice(["line", "square", "sin", "cos"]) for _ in "xyz")
        terms = tuple(
            Term(draws.number(), word, x, draws.units.length)
            for word, x in zip(functions, "xyz", strict=True)
        )
        laws.append((*terms, Term(-sum(term.value(known) for term in terms))))
    return replace(part, surface=tuple(laws))


def _parallel(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    axis = draws.axis()
    return replace(part, axis=axis, second=_triple(axes.T @ unit(axis)))


def _perpendicular_axes(
    part: ContactPart, r: Array, axes: Array, draws: Draws, t: float
) -> ContactPart | None:
    axis = draws.axis()
    return replace(part, axis=axis, second=_triple(axes.T @ _perpendicular(unit(axis), draws)))


def _angle(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    axis, second = draws.axis(), draws.axis()
    a, b = unit(axis), axes @ unit(second)
    angle = math.atan2(float(np.linalg.norm(np.cross(a, b))), float(a @ b))
    if math.sin(angle) < NEAR:
        return None
    return replace(part, axis=axis, second=second, value=_value(draws, angle, 0.3, t))


def _knife(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    return replace(part, second=draws.axis())


def _sphere(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    normal, height = _ground_below(r, draws)
    if height < NEAR * draws.units.length:
        return None
    return replace(part, axis=_triple(normal), value=MotionPart(height, 0.0, draws.units.time))


def _disc(part: ContactPart, r: Array, axes: Array, draws: Draws, t: float) -> ContactPart | None:
    normal, height = _ground_below(r, draws)
    axle = draws.axis()
    lean = np.linalg.norm(np.cross(normal, axes @ unit(axle)))
    if height < NEAR * draws.units.length or lean < 2 * NEAR:
        return None
    radius = MotionPart(float(height / lean), 0.0, draws.units.time)
    return replace(part, axis=_triple(normal), second=axle, value=radius)


_CLOSED: dict[str, Callable[[ContactPart, Array, Array, Draws, float], ContactPart | None]] = {
    "distance": _distance, "line": _line, "plane": _plane, "surface": _surface, "parallel": _parallel,
    "perpendicular": _perpendicular_axes, "angle": _angle, "knife": _knife, "sphere": _sphere, "disc": _disc,
}  # fmt: skip


def _ground_below(r: Array, draws: Draws) -> tuple[Array, float]:
    """A normal, and the height of r along it."""
    tilt = draws.number(0.1, 1.2)
    normal = np.cos(tilt) * r / np.linalg.norm(r) + np.sin(tilt) * _perpendicular(r, draws)
    normal = normal / np.linalg.norm(normal)
    return normal, float(normal @ r)


def _perpendicular(a: Array, draws: Draws) -> Array:
    """A unit vector across a vector of any length."""
    while True:
        found: Array = np.cross(a / np.linalg.norm(a), unit(draws.axis()))
        if np.linalg.norm(found) > NEAR:
            return found / np.linalg.norm(found)


def _value(draws: Draws, value: float, size: float, t: float) -> MotionPart:
    """Now and then a moving value."""
    return draws.motion(value, size, t) if draws.chance(0.2) else MotionPart(value, 0.0, draws.units.time)


def _coupling(mechanism: Mechanism, draws: Draws, name: str, kind: str) -> CouplingPart | None:
    """A coupling of two or three coordinates, with the offset that it has at the pose."""
    listed = _coordinates(mechanism)
    angles = [entry for entry in listed if entry[2] == "a"]
    lengths = [entry for entry in listed if entry[2] == "d"]
    if kind in ("equation", "rates"):
        chosen = draws.rng.sample(listed, min(len(listed), 2))
    elif kind == "rack":
        chosen = draws.rng.sample(lengths, min(len(lengths), 1)) + draws.rng.sample(
            angles, min(len(angles), 1)
        )
    else:
        number = 3 if kind == "differential" else 2
        chosen = draws.rng.sample(angles, min(len(angles), number))
    if len(chosen) < (3 if kind == "differential" else 2):
        return None
    if kind == "rates":
        return _rates(draws, name, chosen)
    terms = _terms(draws, kind, chosen)
    known = {entry[0]: entry[1] for entry in listed}
    size = draws.units.length if kind in ("rack", "belt") else 1.0
    offset = _value(draws, sum(term.value(known) for term in terms), size, mechanism.t)
    return CouplingPart(name, kind, terms, offset)


def _coordinates(mechanism: Mechanism) -> Coordinates:
    """Coordinates with names that have no quaternion or angles of any orientation among them."""
    return [
        entry
        for joint in mechanism.joints
        if joint.named and joint.kind not in ("spherical", "free")
        for entry in zip(joint.names, joint.values, letters(joint).replace("o", "a"), strict=True)
    ]


def _terms(draws: Draws, kind: str, chosen: Coordinates) -> Law:
    names = [entry[0] for entry in chosen]
    units = draws.units
    if kind == "equation":
        return tuple(
            Term(
                draws.number(), draws.rng.choice(["line", "square", "sin", "cos"]), name, _unit(draws, letter)
            )
            for name, _, letter in chosen
        )
    factors = {
        "gear": (1.0, -draws.number(-2, 2)),
        "rack": (1.0, -draws.number() * units.length),
        "belt": (draws.number(0.2, 1) * units.length, draws.number() * units.length),
        "differential": (2.0, -1.0, -1.0),
    }[kind]
    return tuple(Term(factor, "line", name) for factor, name in zip(factors, names, strict=True))


def _rates(draws: Draws, name: str, chosen: Coordinates) -> CouplingPart:
    """``a f(y / .) x_dot + b y_dot = offset``, with x_dot, y_dot in their own units."""
    (x, _, letter_x), (y, _, letter_y) = chosen
    word = draws.rng.choice(["line", "sin", "cos", "one"])
    first = draws.number() / _unit(draws, letter_x)
    terms = (
        Term(first) if word == "one" else Term(first, word, y, _unit(draws, letter_y)),
        Term(draws.number() / _unit(draws, letter_y)),
    )
    moved = draws.number() / draws.units.time if draws.chance(0.3) else 0.0
    offset = MotionPart(0.0, moved, draws.units.time)
    return CouplingPart(name, "rates", terms, offset, (x, y))


def _unit(draws: Draws, letter: str) -> float:
    return draws.units.length if letter == "d" else 1.0


def _triple(a: Array) -> tuple[float, float, float]:
    return (float(a[0]), float(a[1]), float(a[2]))
