"""The law of parts: a part with everything inside is the same model written out by hand.

One function writes a mechanism under any names: under its own it is the part, under those with prefixes what the
part must become in the whole, three levels deep. Each level has a mechanism of the same names, and elements and
symbols that begin like those of the parts, so that an output renamed in part measures something else, or nothing.
Outputs are drawn from the registry, two of each kind for each level: a new kind is in this law.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import pytest

import symbody as sb
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.output_roots import raw_output
from symbody.model.joint import Joint
from symbody.model.output_arguments import (
    CoordinateWord,
    ElementWord,
    EntryWord,
    FrameWord,
    OutputArgument,
    OutputScope,
    SpeedWord,
)
from symbody.model.output_names import DERIVATIVE_GROUPS, OUTPUT_KINDS, OutputKind, OutputName, read_output
from tests.tiers import cases

# Names that mean something else where they stand alone, or begin an output.
SYMBOLS = ("d", "energy", "power", "frame", "friction", "x", "q", "u", "lambda_0", "sin", "angle", "A", "J_1")
PREFIXES = ("P", "frame", "lambda", "kinetic", "d", "FL")
WHOLE = ("energy", "kinetic_energy", "potential_energy", "power")
DEPTH = 3
# In ground, and seen from a frame at (0.5, 0, 0) that is turned by 0.3 about z.
POST = sb.Frame(at=(0, 2, 0))
POST_ON_MOUNT = sb.Frame(at=("0.5 - sin(0.3)*2", "cos(0.3)*2", 0), rotate=[("z", "0.3")])
MOUNT = {"mount": sb.Frame(at=(0.5, 0, 0), rotate=[("z", "0.3")])}


@dataclass(frozen=True)
class Level:
    """How a mechanism is named in the model in which it is written.

    `before` stands before the names of elements, `before_post` before those of frames on its ground, which is the
    frame `ground`; symbols in `shared` are those of the model around it.
    """

    before: str = ""
    before_post: str = ""
    ground: str = "ground"
    shared: Mapping[str, str] | None = None

    def __call__(self, name: str) -> str:
        return self.before + name

    def symbol(self, name: str) -> str:
        return (self.shared or {}).get(name, self(name))

    def address(self, word: str) -> str:
        """A full address of the mechanism, "" for its ground."""
        body, _, frame = word.partition(".")
        if body not in ("", "ground"):
            return self(word)
        return f"{self.ground.partition('.')[0]}.{self.before_post}{frame}" if frame else self.ground

    def inside(self, prefix: str, at: str, shared: str) -> Level:
        """The names of a part that is put into this mechanism."""
        own = {shared: self.symbol(shared)} if shared else None
        if at == "ground":
            return Level(f"{self.before}{prefix}_", f"{self.before_post}{prefix}_", self.ground, own)
        return Level(f"{self.before}{prefix}_", f"{prefix}_", self.address(at), own)


def elements_of(n: Level, mass: str, angle: str, frames: Mapping[str, sb.Frame]) -> list[object]:
    """All kinds of loads, friction, limits, contacts, a rope, a rod, a prescribed motion, signals of all kinds."""
    own = {"tip": sb.Frame(at=(1, 0, 0)), "own": sb.Frame(at=(0, 1, 0))}
    ground, post, angle = n.ground, n.address("ground.post"), n(angle)
    return [
        sb.Body(n("Base"), mass=1, inertia=(1, 1, 1), frames={**MOUNT, **frames}),
        sb.Revolute(n("hinge"), ground, n("Base"), axis="z", coordinate=n("base"),
                    limits={"high": 3, "rigid": True}),
        sb.Body(n("Arm"), mass=n.symbol(mass), inertia=(1, 2, 3), frames=own),
        sb.Body(n("Big slider"), mass=2, inertia=(1, 1, 1), frames={"tip": sb.Frame(at=(0, 0.5, 0))}),
        sb.Planar(n("cart"), ground, n("Big slider"), coordinates=[n("cx"), n("cy"), n("turn")],
                  force={n("cx"): sb.Drive(stiffness=3)}, torque={n("turn"): sb.Drive(damping=0.5)},
                  limits={n("cx"): {"low": -9, "rigid": True}, n("cy"): {"high": 0.1, "stiffness": 3}}),
        sb.Revolute(n("knee"), f"{n('Big slider')}.tip", n("Arm"), axis="z", coordinate=angle,
                    friction=sb.Friction(force=0.3, v0=0.1), torque=sb.Drive(applied=f"-{angle}_dot")),
        sb.Body(n("Wheel"), mass=1, inertia=(1, 1, 2)),
        sb.Planar(n("wheel path"), ground, n("Wheel"), coordinates=[n("wx"), n("wy"), n("roll")]),
        sb.Rolling(n("tyre"), ground, n("Wheel"), radius=1, normal="y", axis="z"),
        sb.Contact(n("pad"), ground, n("Wheel"), ["plane", {"sphere": 0.5}], normal=sb.NormalForce(stiffness=9)),
        sb.Prismatic(n("lift"), ground, sb.Body(n("Cage"), mass=1), axis="y", coordinate=n("y"), motion="0.1*t"),
        sb.Distance(n("line"), post, f"{n('Arm')}.tip", 4, rope=True),
        sb.Distance(n("rod one"), ground, f"{n('Arm')}.own", 2),
        sb.SpringDamper(n("S"), post, f"{n('Arm')}.own", stiffness=5, free=1),
        sb.Bushing(n("B"), ground, n("Arm"), stiffness=[1, 2, 3, 4, 5, 6]),
        sb.TorsionSpring(n("TS"), n("Big slider"), n("Arm"), axis="z", stiffness=2),
        sb.Contact(n("heel"), post, f"{n('Arm')}.tip", ["plane", {"sphere": 0.5}],
                   normal=sb.NormalForce(stiffness=50), friction=sb.Friction(mu=0.4, v0=0.1)),
        sb.Force(n("push"), f"{n('Arm')}.tip", [n("F"), 0, f"-{n('slow')}"], resolved_in=ground,
                 reaction_on=ground),
        sb.Torque(n("twist"), n("Wheel"), [0, 0, f"{n('F')}*{n('knee')}"], resolved_in=ground, reaction_on=ground),
        sb.Signal(n("knee"), f"0.5*{angle}"),  # named like a joint
        sb.Signal(n("slow"), rate=f"{angle} - {n('slow')}"),
    ]  # fmt: skip


class Draw:
    """An output of a part, and how it reads in the whole, in full and in quotes."""

    def __init__(self, rng: random.Random, scope: OutputScope, n: Level) -> None:
        self.rng, self.scope, self.n = rng, scope, n

    def of_kind(self, kind: OutputKind) -> tuple[str, str]:
        words: tuple[str, ...] = ()
        shown: list[str] = []  # in the part
        full: list[str] = []  # in the whole
        for argument in kind.arguments:
            choices = [*argument.choices(self.scope, words)]
            if isinstance(argument, FrameWord) and not argument.is_needed:
                choices += [""] * len(choices)
            word = self.rng.choice(choices)
            if isinstance(argument, FrameWord) and (words[-1:] == ("",) or not argument.fits(words)):
                word = ""  # frames are left out from the end
            shown.append(self.shorten(argument, word))
            full.append(self.full(argument, word, words))
            words = (*words, word)
        name = " ".join(filter(None, (kind.word, *shown)))
        if read_output(name, self.scope) != OutputName(kind, words):  # another name begins with a word
            name = " ".join([kind.word, *(f'"{word}"' for word in words if word)])
        return name, " ".join([kind.word, *(f'"{word}"' for word in full if word)])

    def shorten(self, argument: OutputArgument, word: str) -> str:
        """A word as the part writes it: some in quotes, some frames without their body."""
        frame = word.partition(".")[2]
        homes = [names for names in self.scope.frames.frames.values() if frame in names]
        if isinstance(argument, FrameWord) and len(homes) == 1 and self.rng.random() < 0.5:
            return f'"{frame}"'
        return f'"{word}"' if word and self.rng.random() < 0.3 else word

    def full(self, argument: OutputArgument, word: str, before: tuple[str, ...]) -> str:
        if word.endswith("cx low"):  # an end is named after the joint and its coordinate
            joint, coordinate, end = word.split(" ")
            return f"{self.n(joint)} {self.n(coordinate)} {end}"
        if isinstance(argument, ElementWord | SpeedWord):
            return self.n(word) if word else ""
        if isinstance(argument, CoordinateWord):
            return self.n(word) if word and isinstance(self.scope.elements[before[0]], Joint) else word
        if isinstance(argument, FrameWord):
            is_contact = isinstance(self.scope.elements.get(word), sb.Rolling | sb.Contact)
            return self.n(word) if is_contact else self.n.address(word) if argument.fits(before) else ""
        assert isinstance(argument, EntryWord), f"say here how a part renames {argument}"
        return word

    def combined(self, mass: str, angle: str) -> Iterator[tuple[str, str]]:
        """Multipliers, derivatives and expressions, which no kind stands for."""
        n, rng, effort = self.n, self.rng, self.of_kind(OUTPUT_KINDS["effort"])
        own, whole = Level(), rng.choice(WHOLE)
        by = mass if mass in DERIVATIVE_GROUPS else n.symbol(mass)
        texts: list[Callable[[Level, str], str]] = [
            lambda m, _: f"lambda_{m('rod one')}_1",
            lambda m, _: f"d {whole}/d {m('cy')}",
            lambda m, _: f"2*({m.symbol(mass)}) - sin(({m(angle)}))*lambda_{m('line')}_1*{m('turn')}_dot",
            lambda m, output: f"{m('cx')}_ddot + 0.5*{m('slow')}_dot + 30 deg*'{output}' + {m('knee')}",
        ]
        yield from ((text(own, effort[0]), text(n, effort[1])) for text in texts)
        yield f"d {whole}/d({mass})", f"d {whole}/d({by})"


def instance(seed: int) -> tuple[sb.Model, sb.Model]:
    """The whole with parts in parts, and all of it written out."""
    rng = random.Random(seed)
    mass, angle = rng.sample(SYMBOLS, 2)
    values: dict[str, float] = {}
    flat: list[object] = []
    posts: dict[str, dict[str, sb.Frame]] = {}
    # From the outside in: the names; from the inside out: the models.
    levels, includes = [Level()], []
    for _ in range(DEPTH):
        prefix, at = rng.choice(PREFIXES), rng.choice(("Base.mount", "ground"))
        includes.append((prefix, at, mass if rng.random() < 0.3 else ""))
        levels.append(levels[-1].inside(*includes[-1]))
    for n in levels:
        body, _, frame = n.address("ground.post").partition(".")
        posts.setdefault(body, {})[frame] = POST if n.ground == "ground" else POST_ON_MOUNT
    model: sb.Model | None = None
    for depth in reversed(range(DEPTH + 1)):
        n, own = levels[depth], Level()
        values = {n(mass): 1.5 + depth} | values if n.symbol(mass) == n(mass) else values
        inner = [] if model is None else [include_of(model, *includes[depth])]
        ours = elements_of(own, mass, angle, {})
        beside = [sb.Body("P_knee Fx", mass=1), sb.Body("P_Arm tip", mass=1)] if depth == 0 else []
        parameters = {mass: 1.5 + depth}
        bare = sb.Model(
            "part", [*ours, *inner, *beside], (0, "-9.81", 0), parameters, ["F"], ground={"post": POST}
        )
        draw = Draw(rng, bare.output_scope, n)
        texts = [
            draw.of_kind(kind) for kind in OUTPUT_KINDS.values() for _ in range(2 if kind.arguments else 1)
        ]
        texts += draw.combined(mass, angle)
        signals = [sb.Signal(f"signal_{k}", output=text) for k, (text, _) in enumerate(texts)]
        model = sb.Model(
            "part",
            [*ours, *signals, *inner, *beside],
            (0, "-9.81", 0),
            parameters,
            ["F"],
            ground={"post": POST},
        )
        on_base = posts.get(n("Base"), {})
        by_hand = [sb.Signal(n(f"signal_{k}"), output=text) for k, (_, text) in enumerate(texts)]
        flat = [*elements_of(n, mass, angle, on_base), *by_hand, *beside, *flat]
    assert model is not None
    written = sb.Model(
        "part", flat, (0, "-9.81", 0), values, [n("F") for n in levels], ground=posts.get("ground", {})
    )
    return model, written


def include_of(model: sb.Model, prefix: str, at: str, shared: str) -> sb.Include:
    return sb.Include(model, prefix, at=at, share=[shared] if shared else [])


def check(seed: int) -> None:
    included, written = instance(seed)
    assert included.parameters == written.parameters and {*included.inputs} == {*written.inputs}
    formed = [sb.form_equations(model).formed for model in (included, written)]
    by_hand = {signal.name: str(signal.output) for signal in written.signals}
    for signal in included.signals:
        if signal.output is None:
            continue
        text = by_hand.pop(signal.name)
        kind = OUTPUT_KINDS.get(text)
        if kind is not None and not kind.shape == "":
            assert signal.output == text  # of the whole mechanism, so the same wherever it stands
            continue
        found, expected = (
            value(each, name) for each, name in zip(formed, (signal.output, text), strict=True)
        )
        assert found == expected, f"seed {seed}: {signal.name} = {signal.output!r}, not {text!r}"


def value(formed: EquationsOfMotion, name: str) -> tuple[tuple[int, ...], list[int]]:
    """An output as shape and structural hashes of its nodes: equal for equal formulas, which are so in any state."""
    shape, entries = raw_output(formed, name)
    return shape, [formed.graph.hashes[entry.index] for entry in entries]


@pytest.mark.parametrize("seed", cases(range(20), fast=range(4)))
def test_outputs_of_a_part_are_those_written_by_hand(seed: int) -> None:
    check(seed)


@pytest.mark.exhaustive
def test_outputs_of_many_parts() -> None:
    for seed in range(20, 220):
        check(seed)
