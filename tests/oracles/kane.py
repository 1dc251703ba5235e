"""The trees of `trees.py` by SymPy's KanesMethod, and its matrices to any number of digits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

import mpmath
import sympy as sp
import sympy.physics.mechanics as me

from tests.oracles.trees import COUNTS, Joint, Place, Tree, Triple

SPACE = me.ReferenceFrame("N")
_AXES = {"x": 0, "y": 1, "z": 2}
Load = tuple[object, object]


@dataclass(frozen=True, slots=True)
class _Spot:
    """A frame with a point as its origin."""

    frame: me.ReferenceFrame
    point: me.Point


@dataclass(slots=True)
class _Build:
    tree: Tree
    masses: list[_Spot] = field(default_factory=list)
    equations: list[sp.Expr] = field(default_factory=list)
    loads: list[Load] = field(default_factory=list)
    ground: _Spot = field(default_factory=lambda: _Spot(SPACE, me.Point("O")))

    def __post_init__(self) -> None:
        self.ground.point.set_vel(SPACE, 0)

    def body(self, number: int) -> _Spot:
        return self.ground if number < 0 else self.masses[number]

    def tip(self, number: int) -> _Spot:
        return _placed(self.body(number), self.tree.post if number < 0 else self.tree.bodies[number].tip)


def _rational(value: Fraction) -> sp.Rational:
    return sp.Rational(value.numerator, value.denominator)


def _vector(frame: me.ReferenceFrame, values: Triple) -> me.Vector:
    x, y, z = map(_rational, values)
    return x * frame.x + y * frame.y + z * frame.z


def _axis(frame: me.ReferenceFrame, letter: str) -> me.Vector:
    return (frame.x, frame.y, frame.z)[_AXES[letter]]


def _turned(frame: me.ReferenceFrame, turns: Iterable[tuple[str, Fraction]]) -> me.ReferenceFrame:
    for axis, angle in turns:
        found = me.ReferenceFrame(f"{frame.name}T")
        found.orient_axis(frame, _axis(frame, axis), _rational(angle))
        found.set_ang_vel(frame, 0)
        frame = found
    return frame


def _moved(start: me.Point, arm: me.Vector, frame: me.ReferenceFrame) -> me.Point:
    """The point at `arm` from `start`, fixed in `frame`."""
    point = start.locatenew("P", arm)
    point.set_vel(SPACE, start.vel(SPACE) + frame.ang_vel_in(SPACE).cross(arm))
    return point


def _placed(body: _Spot, place: Place) -> _Spot:
    frame = _turned(body.frame, place.turns)
    return _Spot(frame, _moved(body.point, _vector(body.frame, place.at), body.frame))


def _joined(build: _Build, number: int, joint: Joint) -> None:
    """Append the body that hangs on a joint, and what drives the joint."""
    q = me.dynamicsymbols([f"q{number}_{i}" for i in range(COUNTS[joint.kind])])
    u = me.dynamicsymbols([f"u{number}_{i}" for i in range(COUNTS[joint.kind])])
    parent = build.body(joint.parent)
    start = _placed(parent, joint.start)
    end = _moving(build, start, joint, q, u)
    frame = _turned(end.frame, [(axis, -angle) for axis, angle in reversed(joint.end.turns)])
    mass = _Spot(frame, _moved(end.point, -_vector(frame, joint.end.at), frame))
    for k, drive in enumerate(joint.drives):
        applied, stiffness, damping, free = (
            _rational(x) for x in (drive.applied, drive.stiffness, drive.damping, drive.free)
        )
        effort = (applied - stiffness * (q[k] - free) - damping * u[k]) * _directions(start.frame, joint)[k]
        if joint.kind == "revolute" or k == 2:
            build.loads += [(frame, effort), (parent.frame, -effort)]
        else:
            # the slide carries the reaction where it is now: both act in the same point of space
            here = _moved(parent.point, end.point.pos_from(parent.point), parent.frame)
            build.loads += [(end.point, effort), (here, -effort)]
    build.masses.append(mass)


def _directions(frame: me.ReferenceFrame, joint: Joint) -> list[me.Vector]:
    """Directions of the coordinates of a joint that may be driven, along the axes of its start."""
    if joint.kind == "planar":
        normal = "xyz"[joint.axis.index(Fraction(1))]
        return [_axis(frame, letter) for letter in {"x": "yzx", "y": "zxy", "z": "xyz"}[normal]]
    return [_vector(frame, joint.axis).normalize()] if COUNTS[joint.kind] == 1 else []


def _moving(build: _Build, start: _Spot, joint: Joint, q: list[sp.Expr], u: list[sp.Expr]) -> _Spot:
    if joint.kind == "spherical":
        return _Spot(_oriented(build, start.frame, joint, q, u), start.point)
    t = me.dynamicsymbols._t
    build.equations += [speed - x.diff(t) for x, speed in zip(q, u, strict=True)]
    directions = _directions(start.frame, joint)
    frame, point = start.frame, start.point
    turning = joint.kind in ("revolute", "planar")
    slides = list(zip(q, u, directions, strict=True))[: len(q) - turning]
    if slides:
        arm = sum((x * e for x, _, e in slides), me.Vector(0))
        rate = sum((v * e for _, v, e in slides), me.Vector(0))
        point = start.point.locatenew("P", arm)
        turn = start.frame.ang_vel_in(SPACE).cross(arm)
        point.set_vel(SPACE, start.point.vel(SPACE) + turn + rate)
    if turning:
        frame = me.ReferenceFrame(f"{start.frame.name}J")
        frame.orient_axis(start.frame, directions[-1], q[-1])
        frame.set_ang_vel(start.frame, u[-1] * directions[-1])
    return _Spot(frame, point)


def _oriented(
    build: _Build, start: me.ReferenceFrame, joint: Joint, q: list[sp.Expr], u: list[sp.Expr]
) -> me.ReferenceFrame:
    """A frame turned by three angles, whose speeds are rates or components along start or end."""
    t = me.dynamicsymbols._t
    rates = [x.diff(t) for x in q]
    frame, spin = start, me.Vector(0)
    for letter, x, rate in zip(joint.sequence, q, u if joint.speeds == "rates" else rates, strict=True):
        found = me.ReferenceFrame(f"{frame.name}{letter}")
        axis = _axis(frame, letter)
        found.orient_axis(frame, axis, x)
        spin += rate * axis
        frame = found
    if joint.speeds == "rates":
        build.equations += [speed - rate for speed, rate in zip(u, rates, strict=True)]
        frame.set_ang_vel(start, spin)
        return frame
    axes = start if joint.speeds == "start" else frame
    build.equations += [u[k] - spin.dot(_axis(axes, "xyz"[k])) for k in range(3)]
    frame.set_ang_vel(start, u[0] * axes.x + u[1] * axes.y + u[2] * axes.z)
    return frame


def _rigid_body(build: _Build, number: int) -> me.RigidBody:
    part, mass = build.tree.bodies[number], build.masses[number]
    xx, yy, zz, xy, xz, yz = map(_rational, (*part.moments, *part.products))
    tensor = me.inertia(mass.frame, xx, yy, zz, ixy=xy, iyz=yz, izx=xz)
    return me.RigidBody(f"B{number}", mass.point, mass.frame, _rational(part.mass), (tensor, mass.point))


def _applied(build: _Build) -> None:
    tree = build.tree
    for part, mass in zip(tree.bodies, build.masses, strict=True):
        build.loads.append((mass.point, _rational(part.mass) * _vector(SPACE, tree.gravity)))
    for spring in tree.springs:
        start, end = build.tip(spring.start).point, build.tip(spring.end).point
        arm = end.pos_from(start)
        length = sp.sqrt(arm.dot(arm))
        rate = (end.vel(SPACE) - start.vel(SPACE)).dot(arm) / length
        applied, stiffness, damping, free = map(
            _rational, (spring.applied, spring.stiffness, spring.damping, spring.free)
        )
        force = (applied - stiffness * (length - free) - damping * rate) / length * arm
        build.loads += [(end, force), (start, -force)]
    for load in tree.loads:
        on, body = build.tip(load.on), build.body(load.reaction)
        vector = _vector(build.tip(load.axes).frame, load.vector)
        if load.kind == "torque":
            build.loads += [(on.frame, vector), (body.frame, -vector)]
        else:
            there = _moved(body.point, on.point.pos_from(body.point), body.frame)
            build.loads += [(on.point, vector), (there, -vector)]


def kanes_method(tree: Tree) -> me.KanesMethod:
    """The tree by Kane's method; its speeds u stand for `tree.speeds`."""
    build = _Build(tree)
    for number, joint in enumerate(tree.joints):
        _joined(build, number, joint)
    _applied(build)
    bodies = [_rigid_body(build, number) for number in range(len(tree.bodies))]
    names = tree.coordinates
    method = me.KanesMethod(
        SPACE,
        q_ind=me.dynamicsymbols(list(names)),
        u_ind=me.dynamicsymbols([name.replace("q", "u", 1) for name in names]),
        kd_eqs=build.equations,
    )
    loads = [(place, force) for place, force in build.loads if place is not SPACE and force != 0]
    method.kanes_equations(bodies, loads)
    return method


Known = Mapping[sp.Expr, float]


def accelerations(
    method: me.KanesMethod, known: Known, digits: int = 40
) -> tuple[mpmath.matrix, mpmath.matrix, mpmath.matrix]:
    """M, F and the solution u' of M u' = F at a state, to `digits`."""
    n = method.mass_matrix.rows
    with mpmath.workdps(digits):
        values = evaluate([*method.mass_matrix, *method.forcing], known)
        M = mpmath.matrix(n, n)
        for k in range(n * n):
            M[k // n, k % n] = values[k]
        F = mpmath.matrix(values[n * n :])
        return M, F, mpmath.lu_solve(M, F)


def evaluate(roots: Iterable[sp.Expr], known: Known) -> list[mpmath.mpf]:
    """Values of expressions, each equal subexpression computed once."""
    values = {expression: mpmath.mpf(value) for expression, value in known.items()}
    listed = [sp.S(root) for root in roots]
    stack = list(listed)
    while stack:
        expression = stack[-1]
        if expression in values:
            stack.pop()
            continue
        missing = [child for child in expression.args if child not in values]
        if missing:
            stack.extend(missing)
            continue
        values[stack.pop()] = _value(expression, [values[child] for child in expression.args])
    return [values[root] for root in listed]


def _value(expression: sp.Expr, operands: list[mpmath.mpf]) -> mpmath.mpf:
    if expression.is_Rational:
        return mpmath.mpf(int(expression.p)) / int(expression.q)
    if expression.is_Add:
        return mpmath.fsum(operands)
    if expression.is_Mul:
        return mpmath.fprod(operands)
    if expression.is_Pow:
        exponent = expression.args[1]
        return operands[0] ** (int(exponent) if exponent.is_Integer else operands[1])
    functions = {sp.sin: mpmath.sin, sp.cos: mpmath.cos, sp.tan: mpmath.tan}
    return functions[expression.func](operands[0])
