"""Cyclic coordinates of random mechanisms: those that are by construction, and those that something breaks.

A mechanism on a turntable about the direction of gravity does not depend on the turntable's angle, until something
stands on ground beside it. A top spins upright in every parametrization of its rotation: where the equations are the
same at another angle the eigenvalues are those of the closed form, and elsewhere the angle is refused.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from itertools import permutations
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.laws.draws import Draws
from tests.laws.parts import Units
from tests.laws.rotations import Array
from tests.laws.tally import chunks, name_of

BREAKERS = ("", "spring", "cubic", "branch", "wave", "load")
UNITS = Units(1.0, 1.0, 1.0)
SEQUENCES = tuple("".join(letters) for letters in permutations("xyz"))


def turntable(seed: int, rod: bool) -> tuple[sb.Model, str]:
    """One or two bodies on a turntable, with a loop by a rod; and what makes its angle count, if anything."""
    draws = Draws(random.Random(f"turntable {seed}"), UNITS)
    rng = draws.rng
    breaker = BREAKERS[seed % len(BREAKERS)]
    weak = 10 ** rng.uniform(-6, 0)
    torques = {
        "cubic": f"-{weak}*(phi - 0.4)**3",
        "branch": f"if(phi > {rng.uniform(1, 3)}, {weak}, 0)",
        "wave": f"{weak}*sin({rng.randint(1, 4)}*phi)",
    }
    torque = sb.Drive(applied=torques.get(breaker, "0"), damping=0.1)
    table = sb.Body("Table", mass=1, inertia=(1, 1, 2), frames={"a": frame(draws), "b": frame(draws)})
    elements: list[Any] = [
        table, sb.Revolute("axle", "ground", "Table", axis="z", coordinate="phi", torque=torque)
    ]  # fmt: skip
    parent = "Table.a"
    for k in range(rng.choice([1, 2])):
        a, b, c = (draws.number(0.2, 1.0) for _ in range(3))
        frames = {"o": frame(draws), "t": frame(draws)}
        elements.append(
            sb.Body(f"B{k}", mass=draws.number(0.3, 2), inertia=(b + c, a + c, a + b), frames=frames)
        )
        elements.append(joint(draws, f"J{k}", parent, f"B{k}.o"))
        parent = f"B{k}.t"
    elements.append(sb.SpringDamper("inner", "Table.b", parent, stiffness=5, damping=0.2, free=0.3))
    if breaker == "spring":
        elements.append(sb.SpringDamper("outer", "ground.p", parent, stiffness=weak, damping=0.1, free=0.1))
    if breaker == "load":
        elements.append(sb.Force("wind", on=parent, vector=("F", 0, 0), resolved_in="ground"))
    if rod:
        elements.append(sb.Distance("rod", "Table.b", parent, value="L"))
    model = sb.Model(
        f"turntable {seed}", elements, gravity=(0, 0, -9.81), ground={"p": sb.Frame(at=(1.5, 0.2, -0.3))},
        parameters={"L": 1.0}, inputs=["F"] if breaker == "load" else [],
    )  # fmt: skip
    return model, breaker


def frame(draws: Draws) -> sb.Frame:
    return sb.Frame(at=draws.at())


def joint(draws: Draws, name: str, start: str, end: str) -> Any:
    kind = draws.rng.choice(["revolute", "revolute", "prismatic", "universal", "spherical"])
    if kind == "revolute":
        return sb.Revolute(name, start, end, axis=draws.axis())
    if kind == "prismatic":
        drive = sb.Drive(stiffness=8, damping=0.3)
        return sb.Prismatic(name, start, end, axis=draws.axis(), force=drive)
    if kind == "universal":
        return sb.Universal(name, start, end, axes=["x", "y"])
    sequence = draws.rng.choice(["quaternion", *SEQUENCES])
    speeds = draws.rng.choice(["start", "end"] + ["rates"] * (sequence != "quaternion"))
    return sb.Spherical(name, start, end, angles=sequence, speeds=speeds)


def assembled(seed: int) -> tuple[sb.State, str]:
    """A moving state of a turntable; where the rod of every second does not reach, it is left out."""
    rng = random.Random(f"state {seed}")
    for rod in (seed % 2 == 1, False):
        model, breaker = turntable(seed, rod)
        eqs = sb.form_equations(model)
        parts = {name for four in eqs.quaternions for name in four}
        guess = {name: rng.uniform(-0.5, 0.5) for name in eqs.coordinate_names if name not in parts}
        guess |= {name: rng.uniform(-1, 1) for name in eqs.speed_names}
        try:
            return sb.assemble(eqs, {"phi": 0.4}, guess=guess), breaker
        except sb.AssemblyError:
            continue
    raise AssertionError(seed)


def check_turntables(seeds: Iterable[int]) -> None:
    for seed in seeds:
        state, breaker = assembled(seed)
        if breaker:
            with pytest.raises(sb.AssemblyError, match="phi is not cyclic"):
                sb.linearize(state.eqs, state, cyclic=["phi"])
            continue
        lin = sb.linearize(state.eqs, state, cyclic=["phi"])
        turned = sb.linearize(state.eqs, {**state.q, **state.u, "phi": 1.7}, cyclic=["phi"])
        assert "phi" not in lin.state_names
        np.testing.assert_allclose(
            turned.A, lin.A, rtol=0, atol=1e-8 * max(1.0, np.abs(lin.A).max()), err_msg=f"{seed}"
        )


def closed_form(moments: tuple[float, float, float], weight: float, spin: float) -> Array:
    """The equations of (w_x, w_y, r_x, r_y) of a body spinning upright about a principal axis, in its own axes.

    `moments` A, B, C are about the fixed point, `weight` is m g L. Euler's equations with the moment
    weight (r_x, r_y) of gravity, as the vertical is (-r_y, r_x, 1) in the body; r' = d omega - Omega x r.
    """
    A, B, C = moments
    return np.array([
        [0, (B - C) * spin / A, weight / A, 0],
        [(C - A) * spin / B, 0, 0, weight / B],
        [1, 0, 0, spin],
        [0, 1, -spin, 0],
    ])  # fmt: skip


def check_tops(seeds: Iterable[int]) -> None:
    """Whether a spinning angle is cyclic is read off A at two angles; it has to be accepted just where it is."""
    accepted = 0
    for seed in seeds:
        rng = random.Random(f"top {seed}")
        a, b, c = (rng.uniform(0.2, 1.0) for _ in range(3))
        b = rng.choice([a, b])
        body = (b + c, a + c, a + b)
        word = rng.choice(["quaternion", *SEQUENCES])
        speeds = rng.choice(["start", "end"] + ["rates"] * (word != "quaternion"))
        spin, weight = rng.uniform(1, 6), 9.8
        top = sb.Body("Top", mass=1, inertia=body, frames={"o": sb.Frame(at=(0, 0, -1))})
        names = ["e0", "e1", "e2", "e3"] if word == "quaternion" else ["a", "b", "c"]
        pivot = sb.Spherical("pivot", "ground", "Top.o", angles=word, coordinates=names, speeds=speeds)
        eqs = sb.form_equations(sb.Model("top", [top, pivot], gravity=(0, 0, -weight)))
        angle = "pivot_rz" if word == "quaternion" else names[word.index("z")]
        spinning = {f"{angle}_dot" if speeds == "rates" else "pivot_wz": spin}
        half = 0.35
        ahead = {"e0": np.cos(half), "e3": np.sin(half)} if word == "quaternion" else {angle: 2 * half}
        here, there = (sb.linearize(eqs, spinning | at) for at in ({}, ahead))
        if np.abs(there.A - here.A).max() < 1e-9:
            lin = sb.linearize(eqs, spinning, cyclic=[angle])
            wanted = np.linalg.eigvals(closed_form((body[0] + 1, body[1] + 1, body[2]), weight, spin))
            assert lin.is_stationary, seed
            # In axes that do not turn with the body eigenvalues of an equal pair of moments differ by i spin.
            shifted = body[0] == body[1] and (speeds == "start" or word[0] != "z")
            for value in wanted:
                near = [np.abs(lin.eigenvalues - value - k * 1j * spin).min() for k in (-1, 0, 1)]
                assert min(near if shifted else near[1:2]) < 1e-7, (seed, word, speeds)
            accepted += 1
            continue
        with pytest.raises(sb.AssemblyError, match="not cyclic"):
            sb.linearize(eqs, spinning, cyclic=[angle])
    print(f"{accepted} accepted")


def test_the_angle_of_a_turntable_is_cyclic_until_something_breaks_it() -> None:
    # In 147 accelerations do not exist where conditions are compared with those at the state.
    check_turntables((0, 147))


def test_spinning_tops_have_constant_equations_or_are_refused() -> None:
    check_tops(range(4))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_the_angle_of_a_turntable_is_cyclic_until_something_breaks_it_often(seeds: range) -> None:
    check_turntables(seeds)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_spinning_tops_have_constant_equations_or_are_refused_often(seeds: range) -> None:
    check_tops(seeds)
