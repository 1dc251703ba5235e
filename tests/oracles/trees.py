"""Random trees for comparisons with other programs, as plain data, and the `Model` made of them.

Every number is a multiple of 1/8 or 1/16 of order one, so that it is the same in binary floating point, in
rational arithmetic and as text; nothing but the arithmetic of the two sides can differ.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import symbody as sb

Triple = tuple[Fraction, Fraction, Fraction]
Value = float | str

KINDS = ("weld", "revolute", "prismatic", "planar", "spherical")
COUNTS = {"weld": 0, "revolute": 1, "prismatic": 1, "planar": 3, "spherical": 3}
SEQUENCES = ("xyz", "zyx", "zxz", "xzx", "yzx", "zyz")


@dataclass(frozen=True, slots=True)
class Place:
    """A frame on a body: origin, then turns about its own axes by angles [rad]."""

    at: Triple
    turns: tuple[tuple[str, Fraction], ...] = ()


@dataclass(frozen=True, slots=True)
class Drive:
    """``applied - stiffness*(x - free) - damping*x_dot`` along a coordinate."""

    applied: Fraction
    stiffness: Fraction
    damping: Fraction
    free: Fraction


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint from `start` on the parent (-1: ground) to `end` on the body of the same number."""

    kind: str
    parent: int
    start: Place
    end: Place
    axis: Triple
    sequence: str
    speeds: str
    drives: tuple[Drive, ...]


@dataclass(frozen=True, slots=True)
class Body:
    """Mass, moments and products (xy, xz, yz) of inertia, and one more frame where forces act."""

    mass: Fraction
    moments: Triple
    products: Triple
    tip: Place


@dataclass(frozen=True, slots=True)
class Spring:
    """Spring and damper between the tips of two bodies (-1: a post on ground)."""

    start: int
    end: int
    stiffness: Fraction
    damping: Fraction
    free: Fraction
    applied: Fraction


@dataclass(frozen=True, slots=True)
class Load:
    """A force in the tip of `on`, or a torque, in axes of the tip of `axes`, its reaction on `reaction`."""

    kind: str
    on: int
    reaction: int
    axes: int
    vector: Triple


@dataclass(frozen=True, slots=True)
class Tree:
    """Body k hangs on joint k; `literal` numbers stand in the model themselves, others as parameters."""

    seed: int
    literal: bool
    gravity: Triple
    post: Place
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    springs: tuple[Spring, ...] = ()
    loads: tuple[Load, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(f"q{k}_{i}" for k, joint in enumerate(self.joints) for i in range(COUNTS[joint.kind]))

    @property
    def speeds(self) -> tuple[str, ...]:
        """Speeds in the order of `coordinates`: rates, or components of the angular velocity."""
        return tuple(
            f"q{k}_{i}_dot" if joint.speeds == "rates" else f"w{k}_{i}"
            for k, joint in enumerate(self.joints)
            for i in range(COUNTS[joint.kind])
        )

    def state(self, number: int) -> tuple[dict[str, float], dict[str, float]]:
        """Coordinates and speeds of a random state, multiples of 1/16; angles off the Euler singularities."""
        rng = random.Random(f"state {number} of {self.seed}")
        q: dict[str, float] = {}
        for k, joint in enumerate(self.joints):
            for i in range(COUNTS[joint.kind]):
                q[f"q{k}_{i}"] = rng.randrange(-24, 25) / 16
            if joint.kind == "spherical":  # the middle angle: cos for three axes, sin for two
                least, most = (-16, 16) if len(set(joint.sequence)) == 3 else (8, 42)
                q[f"q{k}_1"] = rng.randrange(least, most) / 16
        return q, {name: rng.randrange(-32, 33) / 16 for name in self.speeds}


def random_tree(seed: int, most: int = 4, kinds: Sequence[str] = KINDS, bare: bool = False) -> Tree:
    """The tree of a seed, of 1 to `most` bodies; a `bare` one has joints of `kinds`, and nothing but gravity."""
    rng = random.Random(seed)
    bodies = rng.randint(1, most)
    chosen = [rng.choice(kinds) for _ in range(bodies)]
    if all(kind == "weld" for kind in chosen):
        chosen[-1] = "revolute"
    tree = Tree(
        seed,
        literal=rng.random() < 0.5,
        gravity=_triple(rng),
        post=_place(rng),
        bodies=tuple(_body(rng) for _ in range(bodies)),
        joints=tuple(_joint(rng, kind, k, bare) for k, kind in enumerate(chosen)),
    )
    if bare:
        return tree
    others = range(-1, bodies)
    springs = [_spring(rng, *rng.sample(others, 2)) for _ in range(rng.choice([0, 1, 1]))]
    loads = [
        Load(
            rng.choice(["force", "torque"]),
            rng.randrange(bodies),
            rng.choice(others),
            rng.choice(others),
            _triple(rng),
        )
        for _ in range(rng.choice([0, 1, 2]))
    ]
    return Tree(
        seed, tree.literal, tree.gravity, tree.post, tree.bodies, tree.joints, tuple(springs),
        tuple(load for load in loads if load.on != load.reaction),
    )  # fmt: skip


def _number(rng: random.Random, least: int = -12, most: int = 12) -> Fraction:
    return Fraction(rng.choice([k for k in range(least, most + 1) if k]), 8)


def _triple(rng: random.Random) -> Triple:
    parts = [_number(rng) if rng.random() < 0.8 else Fraction(0) for _ in range(2)]
    return parts[0], parts[1], _number(rng)


def _place(rng: random.Random) -> Place:
    return Place(
        _triple(rng), tuple((rng.choice("xyz"), _number(rng)) for _ in range(rng.choice([0, 0, 1, 2])))
    )


def _body(rng: random.Random) -> Body:
    """A tensor that a body can have: that of a rod along a vector, added to that of a block."""
    mass = _number(rng, 4, 16)
    x, y, z = _triple(rng)
    a, b, c = (_number(rng, 1, 4) for _ in range(3))
    moments = (b + c + y * y + z * z, a + c + x * x + z * z, a + b + x * x + y * y)
    return Body(mass, moments, (-x * y, -x * z, -y * z), _place(rng))


def _drive(rng: random.Random) -> Drive:
    return Drive(_number(rng), _number(rng, 1), _number(rng, 1), _number(rng))


def _joint(rng: random.Random, kind: str, number: int, bare: bool) -> Joint:
    axis = _triple(rng)
    if kind == "planar" or rng.random() < 0.5:
        k = rng.randrange(3)
        axis = (Fraction(k == 0), Fraction(k == 1), Fraction(k == 2))
    driven = not bare and kind != "spherical" and rng.random() < 0.4
    drives = tuple(_drive(rng) for _ in range(COUNTS[kind])) if driven else ()
    speeds = rng.choice(["rates", "start", "end"]) if kind == "spherical" else "rates"
    parent = number - 1 if rng.random() < 0.7 else rng.randrange(-1, number)
    return Joint(kind, parent, _place(rng), _place(rng), axis, rng.choice(SEQUENCES), speeds, drives)


def _spring(rng: random.Random, start: int, end: int) -> Spring:
    return Spring(start, end, _number(rng, 1), _number(rng, 1), abs(_number(rng)), _number(rng))


@dataclass(slots=True)
class _Numbers:
    """Numbers that become parameters unless the tree is literal."""

    literal: bool
    parameters: dict[str, float] = field(default_factory=dict)

    def __call__(self, name: str, value: Fraction) -> Value:
        if self.literal or not value:
            return float(value)
        self.parameters[name] = float(value)
        return name

    def triple(self, name: str, values: Triple) -> list[Value]:
        return [self(f"{name}_{letter}", value) for letter, value in zip("xyz", values, strict=True)]

    def frame(self, name: str, place: Place) -> sb.Frame:
        turns = [(axis, self(f"{name}_turn{k}", angle)) for k, (axis, angle) in enumerate(place.turns)]
        return sb.Frame(at=self.triple(name, place.at), rotate=turns)

    def drive(self, name: str, drive: Drive) -> sb.Drive:
        words = ("applied", "stiffness", "damping", "free")
        return sb.Drive(**{word: self(f"{word}_{name}", getattr(drive, word)) for word in words})


def tip(number: int) -> str:
    """The address of a body's tip, or of the post on ground."""
    return "ground.post" if number < 0 else f"B{number}.tip"


def build_model(tree: Tree) -> sb.Model:
    """The tree as a model."""
    number = _Numbers(tree.literal)
    elements: list[Any] = [_built_body(number, tree, k) for k in range(len(tree.bodies))]
    elements += [_built_joint(number, k, joint) for k, joint in enumerate(tree.joints)]
    for k, spring in enumerate(tree.springs):
        words = {
            word: number(f"{word}_S{k}", getattr(spring, word))
            for word in ("stiffness", "damping", "free", "applied")
        }
        elements.append(sb.SpringDamper(f"S{k}", tip(spring.start), tip(spring.end), **words))
    for k, load in enumerate(tree.loads):
        make = sb.Force if load.kind == "force" else sb.Torque
        vector = number.triple(f"load{k}", load.vector)
        elements.append(
            make(f"L{k}", tip(load.on), vector, resolved_in=tip(load.axes), reaction_on=tip(load.reaction))
        )
    ground = {"post": number.frame("post", tree.post)} | dict(_starts(number, tree, -1))
    return sb.Model(
        f"tree {tree.seed}",
        elements,
        gravity=number.triple("g", tree.gravity),
        parameters=number.parameters,
        ground=ground,
    )


def _starts(number: _Numbers, tree: Tree, body: int) -> Iterator[tuple[str, sb.Frame]]:
    for k, joint in enumerate(tree.joints):
        if joint.parent == body:
            yield f"start{k}", number.frame(f"start{k}", joint.start)


def _built_body(number: _Numbers, tree: Tree, k: int) -> sb.Body:
    body = tree.bodies[k]
    frames = {"tip": number.frame(f"tip{k}", body.tip), "end": number.frame(f"end{k}", tree.joints[k].end)}
    products = [number(f"J{k}_{word}", x) for word, x in zip(("xy", "xz", "yz"), body.products, strict=True)]
    return sb.Body(
        f"B{k}",
        mass=number(f"m{k}", body.mass),
        inertia=number.triple(f"I{k}", body.moments),
        products=products,
        frames=frames | dict(_starts(number, tree, k)),
    )


def _built_joint(number: _Numbers, k: int, joint: Joint) -> Any:
    parent = "ground" if joint.parent < 0 else f"B{joint.parent}"
    names = [f"q{k}_{i}" for i in range(COUNTS[joint.kind])]
    drives = {name: number.drive(name, drive) for name, drive in zip(names, joint.drives, strict=False)}
    words: dict[str, Any] = dict(name=f"J{k}", start=f"{parent}.start{k}", end=f"B{k}.end")
    if joint.kind == "weld":
        return sb.Weld(**words)
    if joint.kind == "planar":
        normal = "xyz"[joint.axis.index(Fraction(1))]
        force = {name: drives[name] for name in names[:2] if drives}
        torque = {name: drives[name] for name in names[2:] if drives}
        return sb.Planar(**words, axis=normal, coordinates=names, force=force, torque=torque)
    if joint.kind == "spherical":
        speed_names = [f"w{k}_{i}" for i in range(3)] if joint.speeds != "rates" else None
        return sb.Spherical(
            **words, angles=joint.sequence, coordinates=names, speeds=joint.speeds, speed_names=speed_names
        )
    axis = number.triple(f"axis{k}", joint.axis)
    drive = drives.get(names[0])
    if joint.kind == "revolute":
        return sb.Revolute(**words, axis=axis, coordinate=names[0], torque=drive)
    return sb.Prismatic(**words, axis=axis, coordinate=names[0], force=drive)
