"""Two bodies in space with a shape each, for every pair of shapes, in random poses with a gap that is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Final

import numpy as np

import symbody as sb
from symbody.model.contacts.contact_shapes import PAIRS

Shape = Any
Floats = np.ndarray[Any, np.dtype[np.float64]]
SHAPES: Final[dict[str, Shape]] = {
    "plane": "plane",
    "point": "point",
    "sphere": {"sphere": "r"},
    "capsule": {"capsule": ("r", "L")},
    "cylinder": {"cylinder": ("r", "L")},
    "disc": {"disc": "r"},
    "torus": {"torus": ("r", "b")},
    "box": {"box": (0.3, 0.4, 0.5)},
    "socket": {"socket": "R"},
    "hole": {"hole": "R"},
    "height": {"height": "h*sin(2*x)*cos(y) + h*y^2"},
    "cam": {"cam": "R - h*cos(2*angle)"},
}
SIZES: Final = {"r": 0.2, "b": 0.05, "L": 0.6, "R": 0.9, "h": 0.1}
ORDERED: Final = sorted(PAIRS)
NAMES: Final = ["-".join(pair) for pair in ORDERED]
LAW: Final = sb.NormalForce(stiffness="k", exponent=1.5, dissipation="c")
FRICTION: Final = sb.Friction(mu=0.4, v0=0.05)
OUTPUTS: Final = ("gap touch", "frame R touch", "frame r A.s", "frame R A.s", "frame r B.s")


def scene(
    words: Sequence[str],
    law: sb.NormalForce = LAW,
    friction: sb.Friction | None = FRICTION,
    *,
    turned: bool = False,
) -> sb.Model:
    """Bodies A and B, each with its shape in a frame of its own; `turned` writes the shapes the other way round."""
    frames = {
        "A": sb.Frame(at=(0.1, 0.2, -0.1), rotate=[("x", 0.3), ("z", 1.1)]),
        "B": sb.Frame(at=(-0.05, 0.1, 0.15), rotate=[("y", 0.4)]),
    }
    bodies = [
        sb.Body("A", mass=1.5, inertia=(0.1, 0.12, 0.13), frames={"s": frames["A"]}),
        sb.Body("B", mass=2, inertia=(0.2, 0.22, 0.17), frames={"s": frames["B"]}),
    ]
    joints = [
        sb.Free(f"J{k}", "ground", name, angles=angles,
                coordinates=[f"{letter}{k}" for letter in ("x", "y", "z", "a", "b", "g")])
        for k, name, angles in ((1, "A", "xyz"), (2, "B", "xyz"))
    ]  # fmt: skip
    sides = [("A.s", SHAPES[words[0]]), ("B.s", SHAPES[words[1]])]
    (start, first), (end, second) = sides[::-1] if turned else sides
    contact = sb.Contact("touch", start, end, [first, second], normal=law, friction=friction)
    values = {**SIZES, "k": 2e3, "c": 0.2}
    return sb.Model("touch", [*bodies, *joints, contact], parameters=values)


@cache
def geometry(words: tuple[str, str]) -> Callable[..., Sequence[Floats]]:
    """The function of the geometry of two shapes."""
    function: Callable[..., Sequence[Floats]] = sb.compile(
        sb.form_equations(scene(words)), OUTPUTS, quick=True
    )
    return function


def pose(words: tuple[str, str], seed: int, gap: float) -> tuple[Floats, Floats]:
    """Random coordinates and rates, B moved along the normal until the gap is the one asked for."""
    chance, function = np.random.default_rng(seed), geometry(words)
    q, u = chance.uniform(-0.6, 0.6, 12), chance.uniform(-1, 1, 12)
    q[6:9] = q[:3] + chance.uniform(-0.3, 0.3, 3) * (
        1 if {*words} & {"socket", "hole", "height", "plane"} else 3
    )
    if words == ("box", "point") and gap < 0:  # the nearest face changes inside: stay below one
        _, _, r, R, other = function(0.0, q, u)
        q[6:9] += r + R @ (0.03, -0.05, 0.25 + gap) - other
    for _ in range(40):
        now, R, *_ = function(0.0, q, u)
        if abs(now - gap) < 1e-15:
            break
        q[6:9] += R[:, 2] * (gap - now)
    return q, u
