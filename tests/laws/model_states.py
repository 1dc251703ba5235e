"""States of a model as its file gives it, and the same states in the variables of other equations."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

import symbody as sb
from symbody.model import resolve_parameters
from symbody.model.joint import Joint
from tests.laws.evaluation import evaluator
from tests.laws.rotations import Array, quaternion

Group = list[float]
# A state is said in the variables of other equations by what these are measured on.
_MOTIONS = {"R": "R {e} {s}", "r": "r {e} {s} {s}", "v start": "v {e} {s} {s}", "v end": "v {e} {s} {e}",
            "w start": "w {e} {s} {s}", "w end": "w {e} {s} {e}"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Point:
    """A state by name, at a time."""

    t: float
    known: Mapping[str, float]

    def of(self, eqs: sb.EquationSet) -> tuple[float, Group, Group, Group]:
        """t, q, u, r for some equations; inputs are 0."""
        q, u = ([self.known[n] for n in names] for names in (eqs.coordinate_names, eqs.speed_names))
        return self.t, q, u, [0.0] * len(eqs.input_names)


def equations_of(eqs: sb.EquationSet) -> sb.EquationSet:
    """The equations without rows that are only rounding at the model's parameters."""
    values = {name: float(value) for name, value in resolve_parameters(eqs.model).items()}
    return eqs.for_values(values) if eqs.multiplier_names else eqs


def points(eqs: sb.EquationSet, number: int) -> Iterator[Point]:
    """The state assembled from the initial values, then from guesses about it; those that do not close left out."""
    first = sb.assemble(eqs)
    yield _point(first)
    rng = random.Random(7)  # the same for every model: files are compared with nothing but themselves
    angles = {name for joint in eqs.formed.topology.joints for name in joint.angle_coordinates}
    whole = {name for names in eqs.quaternions for name in names}
    length = size(eqs, _point(first))
    rate = max((abs(x) for x in first.u.values()), default=0.0) or 1.0
    for _ in range(number - 1):
        guess: dict[str, sb.codegen.compile.Value] = {}
        for name, value in first.q.items():
            guess[name] = value + 0.2 * rng.uniform(-1, 1) * (1.0 if name in angles | whole else length)
        for names in eqs.quaternions:
            norm = float(np.linalg.norm([float(str(guess[name])) for name in names]))
            guess |= {name: float(str(guess[name])) / norm for name in names}
        for name, value in first.u.items():
            guess[name] = value * (1 + 0.3 * rng.uniform(-1, 1)) if value else 0.3 * rate * rng.uniform(-1, 1)
        try:
            yield _point(sb.assemble(eqs, guess=guess))
        except sb.AssemblyError:
            continue


def _point(state: sb.State) -> Point:
    return Point(state.t, {"t": state.t, **state.q, **state.u})


def size(eqs: sb.EquationSet, point: Point) -> float:
    """The largest distance of a joint's frame from a centre of mass it is fixed to, or of bodies; 1 if all is 0."""
    words = [f"frame r {body.name} ground ground" for body in eqs.model.bodies]
    words += [
        f"frame r {place.full_name} {place.body} ground"
        for joint in eqs.model.joints
        for place in (joint.start, joint.end)
        if place.frame
    ]
    found = evaluator(eqs, list(dict.fromkeys(words)))(*point.of(eqs))
    return max((float(np.abs(r).max()) for r in found.values()), default=0.0) or 1.0


def carried_over(eqs: sb.EquationSet, point: Point, other: sb.EquationSet) -> Point:
    """The same state in the variables of other equations, from outputs of the first.

    Positions close in the first to rounding, so there is nothing left to assemble.

    Raises
    ------
    FormulationError
        If the first equations do not say what a variable of the others is.
    """
    known = dict(point.known)
    wanted = [n for n in (*other.coordinate_names, *other.speed_names) if n not in known]
    for joint in other.formed.topology.joints:
        own = {n for n in _own_names(joint) if n in wanted}
        if own:
            found = _of_frames(eqs, point, joint)
            known |= {name: found[name] for name in own & set(found)}
    rest = [name for name in wanted if name not in known]
    if rest:
        # In parentheses: "gamma" is an output too.
        values = evaluator(eqs, [f"({name})" for name in rest])(*point.of(eqs))
        known |= {name: float(values[f"({name})"]) for name in rest}
    return Point(point.t, known)


def _own_names(joint: Joint) -> tuple[str, ...]:
    return (*joint.coordinates, *(f"{n}_dot" for n in joint.coordinates), *joint.quasi_speed_names)


def _of_frames(eqs: sb.EquationSet, point: Point, joint: Joint) -> dict[str, float]:
    """Quaternions, positions and velocity components of a joint: what has no name where it is cut."""
    ends = {"s": joint.start.full_name, "e": joint.end.full_name}
    words = {key: f"frame {word.format(**ends)}" for key, word in _MOTIONS.items()}
    found = evaluator(eqs, list(words.values()))(*point.of(eqs))
    at: dict[str, Array] = {key: found[word] for key, word in words.items()}
    known: dict[str, float] = {}
    if joint.quaternion is not None:
        known |= _named(joint.quaternion, quaternion(at["R"]))
    if joint.rotation_speeds is not None:
        known |= _named(joint.rotation_speeds.names, at[f"w {joint.rotation_speeds.resolved_in}"])
    if joint.translation_speeds is not None:
        known |= _named(joint.translation_speeds.names, at[f"v {joint.translation_speeds.resolved_in}"])
    if isinstance(joint, sb.Free):
        known |= _named(joint.coordinates[:3], at["r"])
        known |= _named([f"{name}_dot" for name in joint.coordinates[:3]], at["v start"])
    return known


def _named(names: tuple[str, ...] | list[str], values: Array) -> dict[str, float]:
    return dict(zip(names, (float(x) for x in values), strict=True))
