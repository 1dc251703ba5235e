"""Laws on any model, as its file says it: whatever way its equations are formed, it moves the same way.

Nothing is known of the mechanism but its equations: states are assembled, and what one derivation says of them
is held against what another says.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from functools import partial

import numpy as np

import symbody as sb
from symbody.expr.calculus import gradient
from symbody.expr.graph import TIME
from symbody.expr.sequences.sequence import Roots
from tests.formulations import FORMULATIONS, name_of
from tests.laws.agreement import SYSTEM
from tests.laws.evaluation import EPS, Condition, condition, evaluator
from tests.laws.formulations import multiplier_condition
from tests.laws.model_states import Point, carried_over, equations_of, points, size
from tests.laws.reversed_joints import with_reversed_joints
from tests.laws.rotations import Array

# In units of eps cond, as for random mechanisms; what assembly leaves, some eps of positions and speeds, is less.
BOUND = 100.0
# Without a condition, where friction or singular matrices leave none: three digits above what assembly leaves.
RELATIVE = 1e-7
# Coordinates read from frames elsewhere come back to this, unless they are other ones (an angle turned twice).
SAME = 1e-6
_MOTION = ("vdot", "wdot")


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Equations of the model, or of one that moves the same way, and their outputs by plain evaluation."""

    eqs: sb.EquationSet
    generated: bool = False

    def values(self, point: Point, outputs: list[str | Roots]) -> dict[str, Array]:
        """Outputs at a state."""
        if not self.generated:
            return evaluator(self.eqs, outputs)(*point.of(self.eqs))
        words = [str(word) for word in outputs]
        return dict(zip(words, sb.compile(self.eqs, words)(*point.of(self.eqs)), strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """What one way says of a state: accelerations (6,) of bodies in ground axes, wrenches (6,) of joints.

    Attributes
    ----------
    forcing : float
        The largest entry of the forcing, speeds weighted by the root of diag(M): terms that may cancel.
    condition : Condition or None
    multipliers : float
        The condition of the multipliers.
    """

    accelerations: dict[str, Array]
    reactions: dict[str, Array]
    forcing: float
    condition: Condition | None
    multipliers: float


@dataclass(slots=True)
class Found:
    """Errors of all laws in parts of what is allowed; above 1 a law is broken."""

    errors: dict[str, float] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)

    def enter(self, law: str, error: float) -> None:
        """Enter an error, the largest of all states; NaN breaks the law."""
        self.errors[law] = max(self.errors.get(law, 0.0), error if error == error else np.inf)

    @property
    def broken(self) -> dict[str, float]:
        """Laws that do not hold."""
        return {law: error for law, error in self.errors.items() if error > 1}


def _other_trees(model: sb.Model) -> sb.EquationSet:
    """The equations with forests of joints drawn by lot, one for rotation and one for translation."""
    rng = random.Random(11)
    both = [_forest(model, rng), _forest(model, rng)]
    # A joint whose translation depends on its rotation is in both trees or in neither.
    tied = {
        j.name for j in model.joints if j.coupled_coordinates or j.shift_in == "end" or j.speeds == "twist"
    }
    parted = tied & (set(both[0]) ^ set(both[1]))
    rotation, translation = ([name for name in names if name not in parted] for names in both)
    return sb.form_equations(model, tree=sb.Trees(rotation, translation))


def _forest(model: sb.Model, rng: random.Random) -> list[str]:
    group = {"ground": "ground"} | {body.name: body.name for body in model.bodies}
    chosen = []
    for joint in rng.sample(model.joints, len(model.joints)):
        a, b = group[joint.start.body], group[joint.end.body]
        if a != b and rng.random() < 0.8:
            chosen.append(joint.name)
            group = {name: a if root == b else root for name, root in group.items()}
    return chosen


def _reversed_joints(model: sb.Model) -> sb.EquationSet | None:
    other = with_reversed_joints(model)
    return None if other is None else sb.form_equations(other)


def _independent(model: sb.Model) -> sb.EquationSet | None:
    tied = (sb.Rolling, sb.KnifeEdge, sb.Constraint)
    if not any(isinstance(condition, tied) for condition in model.constraints):
        return None
    return sb.form_equations(model, dependent_speeds="auto")


WAYS: dict[str, Callable[[sb.Model], sb.EquationSet | None]] = {
    "joints": lambda model: sb.form_equations(model, tree="joints"),
    "absolute": lambda model: sb.form_equations(model, tree="absolute"),
    "other trees": _other_trees,
    **{name_of(each): partial(sb.form_equations, formulation=each) for each in FORMULATIONS},
    "reversed joints": _reversed_joints,
    "independent speeds": _independent,
    "generated code": sb.form_equations,
}
POWER, ASSEMBLED = "power balance", "assembled speeds"
# What assembly promises of speeds, relative to the largest sum of a row's terms.
CLOSED = 1e-9


def errors_of(model: sb.Model, only: Collection[str] = (), states: int = 2) -> Found:
    """All laws on a model, or those of some ways (`POWER` and `ASSEMBLED` too), at some states.

    Raises
    ------
    SymbodyError
        If the model's equations cannot be formed, or it cannot be assembled.
    """
    found = Found()
    first = Way(equations_of(sb.form_equations(model)))
    ways = dict(_ways(model, only, found))
    for point in points(first.eqs, states):
        if not only or ASSEMBLED in only:
            found.enter(ASSEMBLED, _speed_error(first, point))
        if not only or POWER in only:
            found.enter(POWER, _power_error(first, point))
        if ways:
            _compare(first, point, ways, found)
    return found


def _ways(model: sb.Model, only: Collection[str], found: Found) -> Iterator[tuple[str, Way]]:
    """All ways that exist for a model; "absolute" tells the size of terms, so it is always there."""
    for name, make in WAYS.items():
        is_asked = not only or name in only or (name == "absolute" and set(only) - {POWER, ASSEMBLED})
        if not is_asked:
            continue
        try:
            eqs = make(model)
        except sb.SymbodyError as error:
            found.left_out[name] = error.problems[0].code
            continue
        if eqs is None:
            found.left_out[name] = "nothing to change"
            continue
        yield name, Way(eqs if name == "generated code" else equations_of(eqs), name == "generated code")


def _compare(first: Way, point: Point, ways: dict[str, Way], found: Found) -> None:
    """Enter the differences of all ways from the first at a state."""
    one = _said(first, point, first.eqs.model)
    said = {}
    for name, way in ways.items():
        try:
            there = carried_over(first.eqs, point, way.eqs)
            if _reads_others(first, point, way, there):
                found.left_out[name] = "coordinates turned farther than they are read"
                continue
        except sb.SymbodyError as error:
            found.left_out[name] = error.problems[0].code
            continue
        said[name] = _said(way, there, first.eqs.model)
    scale = _Scale.of(first, point, [one, *said.values()])
    unique = "absolute" in said and _is_full(said["absolute"])
    for name, two in said.items():
        found.enter(f"{name}: accelerations", scale.acceleration_error(one, two))
        if unique:
            found.enter(f"{name}: reactions", scale.reaction_error(one, two))


def _is_full(said: Said) -> bool:
    return said.condition is not None and said.condition.rank == said.condition.rows


def _reads_others(first: Way, point: Point, way: Way, there: Point) -> bool:
    """Whether named coordinates that loads may read have other values where they are measured."""
    names = [n for n in first.eqs.coordinate_names if n not in way.eqs.coordinate_names]
    read = set(way.eqs.measured_angles)
    measured = [n for n in names if n in read]
    if not measured or not _reads_coordinates(first.eqs.model):
        return False
    # In parentheses: "gamma" is an output too.
    values = Way(way.eqs).values(there, [f"({n})" for n in measured])
    return any(abs(float(values[f"({n})"]) - point.known[n]) > SAME for n in measured)


def _reads_coordinates(model: sb.Model) -> bool:
    known = set(model.coordinates)
    if any(joint.drives for joint in model.joints):
        return True
    return any(
        known & set(site.formula.names) for element in model.elements for site in element.formula_sites()
    )


def _said(way: Way, point: Point, model: sb.Model) -> Said:
    bodies, joints = [body.name for body in model.bodies], [joint.name for joint in model.joints]
    words = {(b, kind): f"frame {kind} {b} ground ground" for b in bodies for kind in _MOTION}
    forces = {joint: f"reaction {joint}" for joint in joints}
    places = {j.name: (j.start.full_name, j.end.full_name) for j in model.joints}
    turned = {name: f"frame R {start} ground" for name, (start, _) in places.items()}
    arms = {name: f"frame r {end} {start} ground" for name, (start, end) in places.items()}
    listed = [*SYSTEM, *words.values(), *forces.values(), *turned.values(), *arms.values()]
    found = way.values(point, list(dict.fromkeys(listed)))
    own = {joint.name: joint.start.full_name for joint in way.eqs.model.joints}
    wrenches = {}
    for name, output in forces.items():
        force, moment = np.split(found[output], 2)
        if own[name] != places[name][0]:  # on the other body, about the other point, in the other axes
            axes = found.get(f"frame R {own[name]} ground", _axes(way, point, own[name]))
            force, moment = -(axes @ force), -(axes @ moment)
            moment = moment - np.cross(found[arms[name]], force)
        else:
            force, moment = found[turned[name]] @ force, found[turned[name]] @ moment
        wrenches[name] = np.concatenate([force, moment])
    accelerations = {b: np.concatenate([found[words[b, kind]] for kind in _MOTION]) for b in bodies}
    return Said(accelerations, wrenches, *_conditions(way, found))


def _axes(way: Way, point: Point, frame: str) -> Array:
    word = f"frame R {frame} ground"
    return Way(way.eqs).values(point, [word])[word]


def _conditions(way: Way, found: dict[str, Array]) -> tuple[float, Condition | None, float]:
    """The size of the forcing and both conditions, without those that friction or singular matrices leave."""
    mass = np.diag(found["mass_matrix"])
    d = np.where(mass > 0, 1 / np.sqrt(np.where(mass > 0, mass, 1.0)), 0.0)
    forcing = float(np.abs(found["forcing"] * d).max(initial=0.0))
    if way.eqs.formed.friction:
        return forcing, None, np.inf
    try:
        return forcing, condition(found), multiplier_condition(found)
    except np.linalg.LinAlgError:
        return forcing, None, np.inf


@dataclass(frozen=True, slots=True, eq=False)
class _Scale:
    """The sizes of what is compared: by masses and tensors, and by what cancels in the forcing.

    Attributes
    ----------
    roots : mapping of body to (6, 6)
        What takes an acceleration to components whose squares add up to twice the kinetic energy of such speeds.
    acceleration : float
        In units of such components.
    """

    roots: dict[str, Array]
    acceleration: float
    force: float
    length: float

    @classmethod
    def of(cls, first: Way, point: Point, said: list[Said]) -> _Scale:
        roots = dict(_roots(first, point))
        heaviest = max((float(root[0, 0]) for root in roots.values()), default=0.0)
        top = max(_norm(roots, one.accelerations) for one in said)
        acceleration = max(top, *(one.forcing for one in said))
        # Where nothing acts and nothing turns, all is exactly zero but for the rounding of numbers of order one.
        acceleration = acceleration or heaviest or 1.0
        length = size(first.eqs, point)
        forces = [np.abs(_by_length(w, length)).max() for one in said for w in one.reactions.values()]
        return cls(roots, acceleration, max([acceleration * heaviest, *forces]), length)

    def acceleration_error(self, one: Said, two: Said) -> float:
        gap = {b: one.accelerations[b] - two.accelerations[b] for b in one.accelerations}
        return _norm(self.roots, gap) / (self.acceleration * self._allowed(one, two))

    def reaction_error(self, one: Said, two: Said) -> float:
        gaps = [
            np.abs(_by_length(one.reactions[j] - two.reactions[j], self.length)).max() for j in one.reactions
        ]
        own = max(one.multipliers, two.multipliers)
        allowed = max(self._allowed(one, two), BOUND * EPS * own if np.isfinite(own) else 0.0)
        return float(max(gaps, default=0.0)) / (max(self.force, 1e-300) * allowed)

    def _allowed(self, one: Said, two: Said) -> float:
        if one.condition is None or two.condition is None:
            return RELATIVE
        return BOUND * EPS * max(one.condition.number, two.condition.number)


def _by_length(wrench: Array, length: float) -> Array:
    return wrench / np.array([1.0] * 3 + [length] * 3)


def _norm(roots: dict[str, Array], accelerations: dict[str, Array]) -> float:
    return float(np.sqrt(sum(float(np.sum((roots[b] @ a) ** 2)) for b, a in accelerations.items())))


def _roots(way: Way, point: Point) -> Iterator[tuple[str, Array]]:
    for body in way.eqs.model.bodies:
        texts = [f"({formula})" for formula in (body.mass, *body.inertia, *body.products)]
        values = way.values(point, list(dict.fromkeys(texts)))
        mass, xx, yy, zz, xy, xz, yz = (float(values[text]) for text in texts)
        sizes, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
        root = np.zeros((6, 6))
        root[:3, :3] = np.sqrt(mass) * np.eye(3)
        root[3:, 3:] = np.sqrt(np.maximum(sizes, 0.0))[:, None] * axes.T @ _axes(way, point, body.name).T
        yield body.name, root


def _power_error(way: Way, point: Point) -> float:
    """The rate of T + V along q' and u' and the power, in parts of what is allowed.

    Partial derivatives come from the graph; the scale is the sum of the terms' sizes, at least that of the
    forcing and of the constraints' forces times the speeds.
    """
    eqs = way.eqs
    graph, names = eqs.formed.graph, eqs.formed.names
    by = [names.value(name).index for name in (*eqs.coordinate_names, *eqs.speed_names)]
    by.append(graph.symbol(TIME))
    slopes = gradient(graph, eqs.roots("energy").nodes[0], by)
    roots = Roots("slopes", (len(by),), tuple(slopes))
    found = way.values(point, [*SYSTEM, "qdot", "power", "kinetic_energy", "lambda", roots])
    terms = found["slopes"] * np.concatenate([found["qdot"], found["udot"], [1.0]])
    forcing, conditioned, _ = _conditions(way, found)
    motion = np.sqrt(max(2 * float(found["kinetic_energy"]), 0.0))
    u = np.array([point.known[name] for name in eqs.speed_names])
    scale = max(float(np.abs(terms).sum()), abs(float(found["power"])), forcing * motion)
    held = np.abs(found["jacobian"]).T @ np.abs(found["lambda"]) if len(found["lambda"]) else 0.0
    scale = max(scale, float(((np.abs(found["forcing"]) + held) * np.abs(u)).sum()))
    allowed = RELATIVE if conditioned is None else BOUND * EPS * conditioned.number
    return float(abs(terms.sum() - found["power"]) / max(allowed * scale, 1e-300))


def _speed_error(way: Way, point: Point) -> float:
    """How far the speeds are from what the constraints demand, in parts of what is allowed."""
    found = way.values(point, ["jacobian", "velocity_constraints"])
    if not found["velocity_constraints"].size:
        return 0.0
    u = np.abs([point.known[name] for name in way.eqs.speed_names])
    slopes = np.abs(found["jacobian"])
    # Speeds that constraints hold at zero leave a row with nothing but rounding.
    size = max(float((slopes @ u).max()), float(slopes.max(initial=0.0) * u.max(initial=0.0)) / 1000)
    return float(np.abs(found["velocity_constraints"]).max() / max(CLOSED * size, np.finfo(float).tiny))


def worst(found: Found) -> tuple[str, float]:
    """The law that comes nearest to being broken, or is broken most."""
    return max(found.errors.items(), key=lambda item: item[1], default=("nothing", 0.0))
