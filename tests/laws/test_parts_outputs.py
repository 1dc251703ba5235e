"""The law of parts: with every kind of output inside, a part is the same model written out by hand.

One function writes a mechanism under any names: under its own it is the part, under those with the prefix what the
part must become. The whole has a mechanism of the same names besides, and elements and symbols that begin like
those of the part, so that an output renamed in part measures something else, or nothing.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

import pytest

import symbody as sb
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.output_roots import OUTPUTS, OUTPUTS_BY_NAME, raw_output
from symbody.model.output_names import DERIVATIVE_GROUPS, ELEMENT_OUTPUTS, FRAME_OUTPUT, WHOLE_OUTPUTS

# Names that mean something else where they stand alone, or begin an output.
SYMBOLS = ("d", "energy", "power", "frame", "friction", "x", "q", "u", "lambda_0", "sin", "angle", "A", "J_1")
PREFIXES = ("P", "frame", "lambda", "kinetic", "d", "FL")
WHOLE = ("energy", "kinetic_energy", "potential_energy", "power")
COUNT = 34  # outputs of one mechanism


@dataclass(frozen=True)
class Names:
    """How a mechanism is named: the prefix, the frame in place of its ground, and the names of its symbols."""

    prefix: str
    ground: str
    mass: str
    angle: str
    shared: str

    def __call__(self, name: str) -> str:
        return f"{self.prefix}_{name}" if self.prefix else name

    def symbol(self, name: str) -> str:
        """A symbol, which is not shared."""
        return name if name == self.shared else self(name)


def elements_of(n: Names, outputs: list[str]) -> list[object]:
    """A crank with friction on a cart of three freedoms, a rope, a rod, and springs of all kinds."""
    frames = {"tip": sb.Frame(at=(1, 0, 0)), "own": sb.Frame(at=(0, 1, 0))}
    signals = [sb.Signal(n(f"signal_{k}"), output=text) for k, text in enumerate(outputs)]
    ground = n.ground
    post = f"{ground.partition('.')[0]}.{n('post')}"
    return [
        sb.Body(n("Arm"), mass=n.symbol(n.mass), inertia=(1, 2, 3), frames=frames),
        sb.Body(n("Big slider"), mass=2, inertia=(1, 1, 1), frames={"tip": sb.Frame(at=(0, 0.5, 0))}),
        sb.Planar(n("cart"), ground, n("Big slider"), coordinates=[n("cx"), n("cy"), n("turn")],
                  force={n("cx"): sb.Drive(stiffness=3)}, torque={n("turn"): sb.Drive(damping=0.5)}),
        sb.Revolute(n("knee"), f"{n('Big slider')}.tip", n("Arm"), axis="z", coordinate=n(n.angle),
                    friction=sb.Friction(force=0.3, v0=0.1), torque=sb.Drive(applied=f"-{n(n.angle)}_dot")),
        sb.Distance(n("line"), post, f"{n('Arm')}.tip", 4, rope=True),
        sb.Distance(n("rod one"), ground, f"{n('Arm')}.own", 2),
        sb.SpringDamper(n("S"), post, f"{n('Arm')}.own", stiffness=5, free=1),
        sb.Bushing(n("B"), ground, n("Arm"), stiffness=[1, 2, 3, 4, 5, 6]),
        sb.TorsionSpring(n("TS"), n("Big slider"), n("Arm"), axis="z", stiffness=2),
        *signals,
    ]  # fmt: skip


def scalar(rng: random.Random) -> Callable[[Names], str]:
    """An output that is a number, as it reads under any names; in full where these are not the part's own."""
    letter, entry = rng.choice("xyz"), rng.choice(("Fx", "Fy", "Fz", "Mx", "My", "Mz"))
    kind, end = (
        rng.choice(("r", "v", "w", "vdot", "wdot")),
        rng.choice(("Arm.tip", "own", "Big slider", "post")),
    )
    word = rng.choice(("x", "y", "z", "rx", "ry", "rz"))
    draw = rng.randrange(14)

    def element(n: Names, name: str) -> str:
        return f'"{n(name)}"' if n.prefix else name

    def place(n: Names, frame: str) -> str:
        if not n.prefix:
            return frame
        if frame == "post":
            return f'"{n.ground.partition(".")[0]}.{n("post")}"'
        return f'"{n("Arm")}.own"' if frame == "own" else f'"{n(frame)}"'

    def name(n: Names, symbol: str) -> str:
        return f"({n.symbol(symbol)})"

    def frame(n: Names) -> str:
        named = draw == 1
        rest = "ground ground" if named and not n.prefix else f'"{n.ground}" "{n.ground}"' if n.prefix else ""
        return " ".join(f"frame {kind} {place(n, end)} {rest} {letter}".split())

    def rotation(n: Names) -> str:
        rest = f'"{n.ground}"' if n.prefix else ""
        return " ".join(f"frame R {place(n, end)} {rest} x{letter}".split())

    ways: list[Callable[[Names], str]] = [
        frame,
        frame,
        rotation,
        lambda n: f"reaction {element(n, rng_choice)} {entry}",
        lambda n: (
            f"friction_normal {element(n, 'knee')}" if entry == "Fx" else f"friction {element(n, 'knee')}"
        ),
        lambda n: f"{ropes} {element(n, 'line')}",
        lambda n: f"effort {n('cart')} {n('cx')}" if entry < "M" else f"effort {n('B')} {word}",
        lambda n: f"length {n('S')}" if entry < "M" else f"angle {n('TS')}",
        lambda n: f"{'length' if len(word) == 1 else 'angle'} {n('B')} {word}",
        lambda n: f"lambda_{n('rod one')}_1",
        lambda n: f"d {whole}/d({n.mass if n.mass in DERIVATIVE_GROUPS else n.symbol(n.mass)})",
        lambda n: f"2*{name(n, n.mass)} - sin({name(n, n.angle)})*lambda_{n('line')}_1*{n('turn')}_dot",
        lambda n: f"{n('cx')}_ddot + 0.5*'{rotation(n)}' + 30 deg*'effort {n('B')} {word}'",
        lambda n: whole,
    ]
    rng_choice, whole = rng.choice(("knee", "rod one", "line")), rng.choice(WHOLE)
    ropes = rng.choice(("rope_tension", "rope_length", "rope_slack", "rope_slack_dot"))
    if draw == 10 and entry >= "M":  # of one symbol, which adds no axis
        return lambda n: f"d {whole}/d {n.symbol('cy')}"
    return ways[draw]


def instance(seed: int) -> tuple[sb.Model, sb.Model]:
    """The whole with the part in it, and all of it written out."""
    rng = random.Random(seed)
    mass, angle = rng.sample(SYMBOLS, 2)
    prefix, at = rng.choice(PREFIXES), rng.choice(("Base.mount", "ground"))
    shared = mass if rng.random() < 0.3 else ""
    own, inside = Names("", "ground", mass, angle, shared), Names(prefix, at, mass, angle, shared)
    draws = [scalar(rng) for _ in range(COUNT)]
    post = {"post": sb.Frame(at=(0, 2, 0))}
    part = sb.Model(
        "part", elements_of(own, [draw(own) for draw in draws]), parameters={mass: 1.5}, ground=post
    )
    include = sb.Include(part, prefix, at=at, share=[shared] if shared else [])
    mount = {"mount": sb.Frame(at=(0.5, 0, 0), rotate=[("z", "0.3")])}
    again = Names("", "ground", mass, angle, "")
    beside = [
        sb.Body("Base", mass=1, inertia=(1, 1, 1), frames=mount),
        sb.Revolute("hinge", "ground", "Base", axis="z", coordinate="base"),
        *elements_of(again, ["energy"]),
        sb.Body(f"{prefix}_knee Fx", mass=1),  # begins like an output of the part
        sb.Body(f"{prefix}_Arm tip", mass=1),
    ]

    def whole(elements: list[object], frames: dict[str, sb.Frame], values: dict[str, float]) -> sb.Model:
        return sb.Model("whole", elements, parameters=values, ground=frames)

    included = whole([*beside, include], post, {mass: 2.5})
    values = {mass: 2.5} | ({} if shared else {inside(mass): 1.5})
    placed = {inside("post"): sb.Frame(at=(0, 2, 0))}
    if at == "ground":
        return included, whole(
            [*beside, *elements_of(inside, [d(inside) for d in draws])], post | placed, values
        )
    # R(0.3) (0, 2) + (0.5, 0) on the base
    placed = {inside("post"): sb.Frame(at=("0.5 - sin(0.3)*2", "cos(0.3)*2", 0), rotate=[("z", "0.3")])}
    beside[0] = sb.Body("Base", mass=1, inertia=(1, 1, 1), frames=mount | placed)
    return included, whole([*beside, *elements_of(inside, [d(inside) for d in draws])], post, values)


def check(seed: int) -> None:
    included, written = (sb.form_equations(model).formed for model in instance(seed))
    assert included.topology.model.parameters == written.topology.model.parameters
    signals = [formed.topology.model.signals for formed in (included, written)]
    for signal, by_hand in zip(*signals, strict=True):
        found = value(included, signal)
        assert signal.name == by_hand.name
        assert found == value(written, by_hand), f"seed {seed}: {signal.output!r}, not {by_hand.output!r}"


def value(formed: EquationsOfMotion, signal: sb.Signal) -> tuple[tuple[int, ...], list[int]]:
    """What a signal stands for, as shape and the structural hashes of its nodes: equal for equal formulas."""
    shape, entries = raw_output(formed, str(signal.output))
    return shape, [formed.graph.hashes[entry.index] for entry in entries]


@pytest.mark.parametrize("seed", range(6))
def test_outputs_of_a_part_are_those_written_by_hand(seed: int) -> None:
    check(seed)


@pytest.mark.exhaustive
def test_outputs_of_many_parts() -> None:
    for seed in range(6, 66):
        check(seed)


def test_one_table_has_all_outputs() -> None:
    """What is parsed is what is renamed; measures of springs have words that no function of their own makes."""
    assert {*OUTPUTS} == WHOLE_OUTPUTS
    assert {*OUTPUTS_BY_NAME} == {*ELEMENT_OUTPUTS, FRAME_OUTPUT} - {"length", "angle"}
