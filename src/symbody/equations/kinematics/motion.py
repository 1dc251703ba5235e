"""Kinematics as a value: placement and motion of every frame relative to ground, from two trees of steps.

Names: ``w`` angular velocity, ``v`` velocity; ``partials`` are the coefficients of the speeds (Kane &
Levinson 1985, section 2.14), ``rest`` what does not depend on them, ``bias`` the acceleration with u' = 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from symbody.equations.kinematics.velocity import AT_REST, Velocity
from symbody.equations.kinematics.waiting import Waiting
from symbody.expr.calculus import gradient, time_derivative
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph, Kind
from symbody.expr.opcodes import SYMBOL
from symbody.expr.rewrite import substitute, symbols_of
from symbody.vectors.euler_parameters import EulerParameters
from symbody.vectors.frame import FrameTree
from symbody.vectors.matrix import Matrix
from symbody.vectors.rotation import DirectionCosines, Rotation, Turn, rotation_of
from symbody.vectors.vector import NULL, Vector, cross, drawn_near, lifted, vector


@dataclass(frozen=True, slots=True)
class Turning:
    """How one frame is turned in another.

    Attributes
    ----------
    steps : tuple of Turn or EulerParameters
        From the parent's axes to the child's.
    angular_velocity : Vector or None
        Of the child relative to the parent, in speeds, with components in frames that are entered by this
        step or stood before; None: that of the turns.
    """

    child: str
    parent: str
    steps: tuple[Turn | EulerParameters, ...]
    angular_velocity: Vector | None = None


@dataclass(frozen=True, slots=True)
class Shifting:
    """Where one origin stands from another.

    Attributes
    ----------
    axes : str
        The frame in which terms far away are expressed.
    shift : Vector
        From the parent's origin to the child's.
    velocity : (frame, Vector) or None
        The rate of the shift as seen from a frame, in speeds; None: that of its components.
    """

    child: str
    parent: str
    axes: str
    shift: Vector
    velocity: tuple[str, Vector] | None = None


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
    spread : bool
        Whether vectors stay sums of terms in their own frames, however far away: products then read as in a
        book, but their number grows with the square of the length of a chain.
    shifts : mapping of frame to (frame, Vector)
        From the origin of a frame nearer to ground to each frame's origin.
    steered : set of frame
        Frames whose angular velocity is given in speeds: those before them turn at less simple rates.
    depths : mapping of frame to int
        Number of shifts from ground.
    arms : mapping of (frame, frame) to Vector
        What `arm` found; it follows from the shifts.
    velocities, angular_velocities : mapping of frame
        Of each frame's origin, and of the frame.
    """

    tree: FrameTree
    rates: Mapping[int, int]
    speeds: tuple[int, ...]
    spread: bool
    shifts: dict[str, tuple[str, Vector]]
    steered: set[str]
    depths: dict[str, int]
    arms: dict[tuple[str, str], Vector]
    velocities: dict[str, Velocity]
    angular_velocities: dict[str, Velocity]

    @property
    def graph(self) -> Graph:
        """The graph of all expressions."""
        return self.tree.graph

    def arm(self, start: str, end: str) -> Vector:
        """Return the vector from the origin of one frame to that of another."""
        found = self.arms.get((start, end))
        if found is None:
            outward, inward = self._apart(end, start)
            found = NULL
            for frame in reversed(outward):
                found = found + self.shifts[frame][1]
            for frame in inward:
                found = found - self.shifts[frame][1]
            self.arms[(start, end)] = found
        return found

    def _apart(self, a: str, b: str) -> tuple[list[str], list[str]]:
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
        total = NULL
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
        return self.resting(self.rate(x))

    def resting(self, x: Expr) -> Expr:
        """Return a scalar with all u' = 0."""
        graph = self.graph
        zero = {node: 0 for node in symbols_of(graph, [x.index]) if _is_acceleration(graph, node)}
        return Expr(graph, substitute(graph, [x.index], zero)[0]) if zero else x

    def slopes(self, x: Expr) -> dict[int, Expr]:
        """Return the coefficient of each speed in a scalar, zeros left out."""
        by = [u for u in self.speeds if u <= x.index]
        found = gradient(self.graph, x.index, by) if by else []
        return {u: Expr(self.graph, slope) for u, slope in zip(by, found, strict=True) if slope}

    def affine(self, value: Vector, bias: Vector) -> Velocity:
        """Return a velocity from its value in speeds and its bias."""
        partials: dict[int, Vector] = {}
        for home, parts in value.terms.items():
            for k, part in enumerate(parts):
                for u, slope in self.slopes(part).items():
                    partials[u] = partials.get(u, NULL) + vector(home, _unit(self.graph, k, slope))
        return Velocity(partials, value.map(self.without_speeds), value, bias)

    def without_speeds(self, x: Expr) -> Expr:
        """Return a scalar with all speeds zero."""
        return Expr(self.graph, substitute(self.graph, [x.index], dict.fromkeys(self.speeds, 0))[0])


def form_kinematics(
    graph: Graph,
    turnings: Iterable[Turning],
    shiftings: Iterable[Shifting],
    rates: Mapping[int, int],
    speeds: Sequence[int],
    *,
    spread: bool,
    waiting: bool = False,
) -> Kinematics:
    """Return the kinematics of frames given outward from ground, each by a step from an earlier one.

    All turnings come before all shiftings, because the two trees need not be the same.

    Parameters
    ----------
    waiting : bool
        Whether velocities are formed only when they are asked for: along a chain they are many.
    """
    parents: dict[str, tuple[str, Rotation]] = {}
    tree = FrameTree(graph, parents)
    kinematics = Kinematics(
        tree=tree,
        rates=rates,
        speeds=tuple(speeds),
        spread=spread,
        shifts={},
        steered=set(),
        depths={"ground": 0},
        arms={},
        velocities=Waiting({"ground": AT_REST}) if waiting else {"ground": AT_REST},
        angular_velocities=Waiting({"ground": AT_REST}) if waiting else {"ground": AT_REST},
    )
    for turning in turnings:
        enter_turning(kinematics, turning)
    for shifting in shiftings:
        enter_origin(kinematics, shifting)
    return kinematics


def enter_axes(
    kinematics: Kinematics, child: str, parent: str, cosines: Matrix, angular_velocity: Vector
) -> None:
    """Enter a frame by its rotation matrix, child components to parent components.

    Parameters
    ----------
    angular_velocity : Vector
        Of the child relative to the parent, in coordinates and speeds.
    """
    near = kinematics.angular_velocities[parent]
    kinematics.tree.parents[child] = (parent, Rotation((DirectionCosines(cosines),)))
    bias = kinematics.derivative(angular_velocity).map(kinematics.resting)
    kinematics.angular_velocities[child] = near.combined(kinematics.affine(angular_velocity, bias))


def enter_turning(kinematics: Kinematics, turning: Turning) -> None:
    """Enter the frames of a step, one more for each turn, with their angular velocities."""
    parents, frame = kinematics.tree.parents, turning.parent
    for following, step in _frames(turning):
        parents[following] = (frame, rotation_of((step,)))
        frame = following
    if not turning.steps:
        parents[turning.child] = (frame, Rotation())
    if turning.angular_velocity is not None:
        kinematics.steered.add(kinematics.tree.home(turning.child))
    if isinstance(kinematics.angular_velocities, Waiting):
        find = partial(_enter_spins, kinematics, turning)
        for child in {turning.child, *(name for name, _ in _frames(turning))}:
            kinematics.angular_velocities.wait(child, turning.parent, find)
    else:
        _enter_spins(kinematics, turning)


def _frames(turning: Turning) -> Iterator[tuple[str, Turn | EulerParameters]]:
    """Return the frame that each step leads to."""
    last = len(turning.steps) - 1
    for k, step in enumerate(turning.steps):
        yield turning.child if k == last else f"{turning.child}#{k + 1}", step


def _enter_spins(kinematics: Kinematics, turning: Turning) -> None:
    angular, frame = kinematics.angular_velocities, turning.parent
    for following, step in _frames(turning):
        if isinstance(step, Turn):
            angular[following] = _turned(kinematics, angular[frame], following, step)
        frame = following
    if not turning.steps:
        angular[turning.child] = angular[frame]
    if turning.angular_velocity is not None:
        near = angular[turning.parent]
        swing = cross(kinematics.tree, near.value, turning.angular_velocity)
        relative = kinematics.affine(turning.angular_velocity, swing)
        angular[turning.child] = near.combined(relative)
    angular[turning.child] = _short(kinematics, angular[turning.child], turning.child)


def _turned(kinematics: Kinematics, near: Velocity, frame: str, turn: Turn) -> Velocity:
    """Return the angular velocity of a frame turned about an axis that is fixed in both."""
    speed = kinematics.rate(turn.angle)
    if speed.is_zero:
        return near
    axis = vector(kinematics.tree.home(frame), turn.axis)
    spin = axis * speed
    bias = axis * kinematics.bias(speed) + cross(kinematics.tree, near.value, spin)
    return near.combined(kinematics.affine(spin, bias))


def enter_origin(kinematics: Kinematics, shifting: Shifting) -> None:
    """Enter the origin of a frame."""
    parent, child = shifting.parent, shifting.child
    # Frames that are not turned share one set of components, so that terms can add up.
    shift = lifted(kinematics.tree, shifting.shift, kinematics.steered)
    kinematics.shifts[child] = (parent, shift)
    kinematics.depths[child] = kinematics.depths[parent] + 1
    if isinstance(kinematics.velocities, Waiting):
        kinematics.velocities.wait(child, parent, partial(_enter_velocity, kinematics, shifting))
    else:
        _enter_velocity(kinematics, shifting)


def _enter_velocity(kinematics: Kinematics, shifting: Shifting) -> None:
    tree, parent, child = kinematics.tree, shifting.parent, shifting.child
    shift = kinematics.shifts[child][1]
    if shifting.velocity is None:
        moved = kinematics.velocities[parent]
        for frame, parts in shift.terms.items():
            term = Vector({frame: parts})
            slide = term.map(kinematics.rate)
            moved = moved.combined(_carried(kinematics, frame, term, slide, slide.map(kinematics.bias)))
    else:
        frame, slide = shifting.velocity
        homes = kinematics.angular_velocities
        seen = NULL
        for home, parts in slide.terms.items():
            term = Vector({home: parts})
            seen = seen + cross(tree, homes[home].value - homes[frame].value, term)
        moved = kinematics.velocities[parent].combined(_carried(kinematics, frame, shift, slide, seen))
    kinematics.velocities[child] = _short(kinematics, moved, shifting.axes)


def _carried(kinematics: Kinematics, frame: str, arm: Vector, slide: Vector, change: Vector) -> Velocity:
    """Return the velocity of an arm's end relative to its origin, the arm carried by a turning frame.

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
    turning = {u: cross(tree, partial, arm) for u, partial in w.partials.items()}
    swinging = Velocity(_nonzero(turning), cross(tree, w.rest, arm), swing, NULL)
    return swinging.combined(sliding)


def _short(kinematics: Kinematics, a: Velocity, frame: str) -> Velocity:
    """Return the velocity with what is far away expressed in a frame, unless vectors are spread."""
    if kinematics.spread:
        return a

    def short(x: Vector) -> Vector:
        return drawn_near(kinematics.tree, x, kinematics.tree.home(frame))

    return Velocity(
        {u: short(x) for u, x in a.partials.items()}, short(a.rest), short(a.value), short(a.bias)
    )


def _nonzero(partials: Mapping[int, Vector]) -> dict[int, Vector]:
    return {u: partial for u, partial in partials.items() if not partial.is_zero}


def _unit(graph: Graph, k: int, x: Expr) -> tuple[Expr, Expr, Expr]:
    zero = Expr(graph, 0)
    return (x if k == 0 else zero, x if k == 1 else zero, x if k == 2 else zero)


def _is_acceleration(graph: Graph, node: int) -> bool:
    if graph.ops[node] != SYMBOL:
        return False
    symbol = graph.symbols[graph.left[node]]
    return (
        symbol.kind == Kind.COORDINATE
        and symbol.order == 2
        or symbol.kind == Kind.SPEED
        and symbol.order == 1
    )
