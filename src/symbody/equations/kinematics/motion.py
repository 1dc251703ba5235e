"""Kinematics as a value: placement and motion of every frame relative to ground, from two trees of steps.

Names: ``w`` angular velocity, ``v`` velocity; ``partials`` are the coefficients of the speeds (Kane &
Levinson 1985, section 2.14), ``drift`` the part without speeds, ``bias`` the acceleration with u' = 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.lazy_mapping import LazyMapping, Rule
from symbody.equations.kinematics.velocity import AT_REST, Velocity
from symbody.expr.calculus import gradient, time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.opcodes import SYMBOL
from symbody.expr.rewrite import substitute, symbols_of
from symbody.spatial.frame import FrameTree
from symbody.spatial.rotation import AxisRotation, DirectionCosines, Rotation, compose_steps
from symbody.spatial.vector import ZERO, Vector, cross, express_near, in_simplest_frame, vector


@dataclass(frozen=True, slots=True)
class Kinematics:
    """Placement and motion of all frames relative to ground.

    Attributes
    ----------
    tree : FrameTree
        Orientations.
    rates : mapping of node to node
        q' in terms of u, as `time_derivative` takes it.
    speeds : tuple of int
        Nodes of u.
    shifts : mapping of frame to (frame, Vector)
        From the origin of a frame nearer to ground to each frame's origin.
    depths : mapping of frame to int
        Number of shifts from ground.
    velocities, angular_velocities : mapping of frame
        Of each frame's origin, and of the frame.
    driven_frames : set of frame
        Frames whose angular velocity is given in speeds: those before them turn at less simple rates.
    """

    tree: FrameTree
    rates: Mapping[int, int]
    speeds: tuple[int, ...]
    shifts: Mapping[str, tuple[str, Vector]]
    depths: Mapping[str, int]
    velocities: Mapping[str, Velocity]
    angular_velocities: Mapping[str, Velocity]
    driven_frames: frozenset[str] = frozenset()
    # Results of `position`, kept for the next call; they follow from the shifts.
    _positions: dict[tuple[str, str], Vector] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    @property
    def graph(self) -> Graph:
        """The graph of all expressions."""
        return self.tree.graph

    def position(self, start: str, end: str) -> Vector:
        """Return the vector from the origin of one frame to that of another."""
        arm = self._positions.get((start, end))
        if arm is None:
            outward, inward = self._paths(end, start)
            arm = ZERO
            for frame in reversed(outward):
                arm = arm + self.shifts[frame][1]
            for frame in inward:
                arm = arm - self.shifts[frame][1]
            self._positions[(start, end)] = arm
        return arm

    def _paths(self, a: str, b: str) -> tuple[list[str], list[str]]:
        """Return the frames from each of two frames to the last that both stand on, which is left out."""
        from_a, from_b = [], []
        while a != b:
            if self.depths[a] >= self.depths[b]:
                from_a.append(a)
                a = self.shifts[a][0]
            else:
                from_b.append(b)
                b = self.shifts[b][0]
        return from_a, from_b

    def derivative(self, a: Vector, frame: str = "ground") -> Vector:
        """Return the time derivative of a vector as seen from `frame`, with u' as symbols of its own."""
        total = ZERO
        w_frame = self.angular_velocities[frame].value
        for home, components in a.terms.items():
            term = Vector({home: components})
            relative = self.angular_velocities[home].value - w_frame
            total = total + term.map(self.rate) + cross(self.tree, relative, term)
        return total

    def rate(self, x: Expr) -> Expr:
        """Return the time derivative of a scalar, with q' in terms of u."""
        return Expr(self.graph, time_derivative(self.graph, [x.index], self.rates)[0])

    def bias(self, x: Expr) -> Expr:
        """Return the time derivative of a scalar in q, u, t with all u' = 0."""
        return self.at_zero_acceleration(self.rate(x))

    def at_zero_acceleration(self, x: Expr) -> Expr:
        """Return a scalar with all u' = 0."""
        graph = self.graph
        zero = {node: 0 for node in symbols_of(graph, [x.index]) if _is_acceleration(graph, node)}
        return Expr(graph, substitute(graph, [x.index], zero)[0]) if zero else x

    def speed_partials(self, x: Expr) -> dict[int, Expr]:
        """Return the coefficient of each speed in a scalar, zeros left out."""
        by = [u for u in self.speeds if u <= x.index]
        partials = gradient(self.graph, x.index, by) if by else []
        return {u: Expr(self.graph, partial) for u, partial in zip(by, partials, strict=True) if partial}

    def affine(self, value: Vector, bias: Vector) -> Velocity:
        """Return a velocity from its value in speeds and its bias."""
        partials: dict[int, Vector] = {}
        for home, parts in value.terms.items():
            for k, part in enumerate(parts):
                for u, slope in self.speed_partials(part).items():
                    partials[u] = partials.get(u, ZERO) + vector(home, _unit(self.graph, k, slope))
        return Velocity(partials, value.map(self.at_zero_speeds), value, bias)

    def at_zero_speeds(self, x: Expr) -> Expr:
        """Return a scalar with all speeds zero."""
        return Expr(self.graph, substitute(self.graph, [x.index], dict.fromkeys(self.speeds, 0))[0])


def form_kinematics(
    graph: Graph,
    rotations: Iterable[RotationStep],
    translations: Iterable[TranslationStep],
    rates: Mapping[int, int],
    speeds: Sequence[int],
    *,
    lazy: bool = False,
) -> Kinematics:
    """Return the kinematics of frames given outward from ground, each by a step from an earlier one.

    All rotations come before all translations, because the two trees need not be the same.

    Parameters
    ----------
    lazy : bool
        Whether velocities are computed only when they are read: along a chain they are many.
    """
    ground = {"ground": AT_REST}
    empty = Kinematics(FrameTree(graph, {}), rates, tuple(speeds), {}, {"ground": 0}, ground, ground)
    return add_frames(empty, rotations, translations, lazy=lazy)


def add_frames(
    kinematics: Kinematics,
    rotations: Iterable[RotationStep],
    translations: Iterable[TranslationStep],
    *,
    lazy: bool = False,
) -> Kinematics:
    """Return the kinematics with further frames; arguments as of `form_kinematics`."""
    rotations, translations = tuple(rotations), tuple(translations)
    tree = FrameTree(kinematics.graph, {**kinematics.tree.parents, **_orientations(rotations)})
    given = {
        tree.orientation_frame(rotation.child)
        for rotation in rotations
        if rotation.angular_velocity is not None
    }
    kinematics = replace(kinematics, tree=tree, driven_frames=kinematics.driven_frames | given)
    rules = _angular_rules(kinematics, rotations)
    angular = LazyMapping(kinematics.angular_velocities, rules)
    kinematics = replace(kinematics, angular_velocities=angular if lazy else dict(angular))
    return _add_origins(kinematics, translations, lazy)


def _add_origins(kinematics: Kinematics, translations: Sequence[TranslationStep], lazy: bool) -> Kinematics:
    shifts, depths = dict(kinematics.shifts), dict(kinematics.depths)
    rules: dict[str, Rule[Velocity]] = {}
    for step in translations:
        # Frames that are not turned share one set of components, so that terms can add up.
        shift = in_simplest_frame(kinematics.tree, step.shift, kinematics.driven_frames)
        shifts[step.child] = (step.parent, shift)
        depths[step.child] = depths[step.parent] + 1
        rules[step.child] = (step.parent, partial(_origin_velocity, kinematics, step, shift))
    velocities = LazyMapping(kinematics.velocities, rules)
    return replace(
        kinematics, shifts=shifts, depths=depths, velocities=velocities if lazy else dict(velocities)
    )


def _orientations(rotations: Iterable[RotationStep]) -> dict[str, tuple[str, Rotation]]:
    """Return each frame's parent and rotation, one frame more for each step of several."""
    parents: dict[str, tuple[str, Rotation]] = {}
    for rotation in rotations:
        frame = rotation.parent
        for following, step in rotation.frames:
            parents[following] = (frame, compose_steps((step,)))
            frame = following
        if not rotation.steps:
            parents[rotation.child] = (frame, Rotation())
    return parents


def _angular_rules(kinematics: Kinematics, rotations: Iterable[RotationStep]) -> dict[str, Rule[Velocity]]:
    """Return how the angular velocity of each frame follows from that of the frame before it."""
    rules: dict[str, Rule[Velocity]] = {}
    for rotation in rotations:
        frame, child = rotation.parent, rotation.child
        for following, step in rotation.frames:
            if isinstance(step, AxisRotation):
                rules[following] = (
                    frame,
                    partial(_add_turn, kinematics, following, step, following == child),
                )
            frame = following
        if rotation.angular_velocity is not None:
            rules[child] = (
                rotation.parent,
                partial(_add_angular_velocity, kinematics, rotation, rotation.angular_velocity),
            )
        elif not rotation.steps:
            rules[child] = (rotation.parent, partial(_express_near, kinematics, child))
    return rules


def _add_turn(
    kinematics: Kinematics, frame: str, turn: AxisRotation, is_last: bool, near: Velocity
) -> Velocity:
    """Return the angular velocity of a frame turned about an axis that is fixed in both frames."""
    speed = kinematics.rate(turn.angle)
    if not speed.is_zero:
        axis = vector(kinematics.tree.orientation_frame(frame), turn.axis)
        spin = axis * speed
        bias = axis * kinematics.bias(speed) + cross(kinematics.tree, near.value, spin)
        near = near + kinematics.affine(spin, bias)
    return _express_near(kinematics, frame, near) if is_last else near


def _add_angular_velocity(
    kinematics: Kinematics, rotation: RotationStep, relative: Vector, near: Velocity
) -> Velocity:
    """Return the angular velocity of a frame from that relative to the frame before it."""
    bias = relative.map(kinematics.bias) + cross(kinematics.tree, near.value, relative)
    total = near + kinematics.affine(relative, bias)
    if isinstance(rotation.steps[0], DirectionCosines):
        return total  # products with a matrix of formulas cost more than terms far away
    return _express_near(kinematics, rotation.child, total)


def _origin_velocity(
    kinematics: Kinematics, step: TranslationStep, shift: Vector, near: Velocity
) -> Velocity:
    """Return the velocity of an origin from that of the origin it is shifted from."""
    tree, angular = kinematics.tree, kinematics.angular_velocities
    if step.velocity is None:
        for frame, parts in shift.terms.items():
            term = Vector({frame: parts})
            slide = term.map(kinematics.rate)
            near = near + _relative_velocity(kinematics, frame, term, slide, slide.map(kinematics.bias))
        return _express_near(kinematics, step.axes, near)
    frame, slide = step.velocity
    change = ZERO
    for home, parts in slide.terms.items():
        spin = angular[home].value - angular[frame].value
        change = change + cross(tree, spin, Vector({home: parts}))
    relative = _relative_velocity(kinematics, frame, shift, slide, change)
    return _express_near(kinematics, step.axes, near + relative)


def _relative_velocity(
    kinematics: Kinematics, frame: str, arm: Vector, slide: Vector, change: Vector
) -> Velocity:
    """Return the velocity of an arm's end relative to its origin, the arm in a turning frame.

    Parameters
    ----------
    slide, change : Vector
        First and second rate of the arm as seen from the frame, the second with all u' = 0.
    """
    tree = kinematics.tree
    w = kinematics.angular_velocities[frame]
    swing = cross(tree, w.value, arm)
    centripetal = cross(tree, w.value, swing + slide * 2)
    sliding = kinematics.affine(slide, change + cross(tree, w.bias, arm) + centripetal)
    swings = {u: cross(tree, partial, arm) for u, partial in w.partials.items()}
    nonzero = {u: partial for u, partial in swings.items() if not partial.is_zero}
    return Velocity(nonzero, cross(tree, w.drift, arm), swing, ZERO) + sliding


def _express_near(kinematics: Kinematics, frame: str, velocity: Velocity) -> Velocity:
    """Return the velocity with terms in frames far away expressed in a frame."""
    tree, axes = kinematics.tree, kinematics.tree.orientation_frame(frame)
    return Velocity(
        {u: express_near(tree, partial, axes) for u, partial in velocity.partials.items()},
        express_near(tree, velocity.drift, axes),
        express_near(tree, velocity.value, axes),
        express_near(tree, velocity.bias, axes),
    )


def _unit(graph: Graph, k: int, x: Expr) -> tuple[Expr, Expr, Expr]:
    zero = Expr(graph, 0)
    return (x if k == 0 else zero, x if k == 1 else zero, x if k == 2 else zero)


def _is_acceleration(graph: Graph, node: int) -> bool:
    if graph.ops[node] != SYMBOL:
        return False
    symbol = graph.symbols[graph.left[node]]
    return (
        symbol.kind == SymbolKind.COORDINATE
        and symbol.order == 2
        or symbol.kind == SymbolKind.SPEED
        and symbol.order == 1
    )
