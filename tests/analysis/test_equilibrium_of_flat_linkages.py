"""Equilibria of linkages that can lie flat: none of them is a pose beside a crossing of branches."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

import symbody as sb
from tests.analysis.flat_linkages import LINKAGES, Place, Rest, Values, equations, rests, turned
from tests.tiers import cases

CHUNK = 20
G = 9.81


def parameters(kind: str, values: Values) -> dict[str, float]:
    return {name: values[name] for name in equations(kind).parameter_names}


def apart(state: sb.State, place: Place) -> float:
    """The largest difference of coordinates, angles modulo whole turns, lengths in metres."""
    return max(abs(x - place[q] if q == "s" else turned(x - place[q])) for q, x in state.q.items())


def nearest(state: sb.State, known: list[Rest]) -> Rest:
    return min(known, key=lambda rest: apart(state, rest.q))


def guess_for(kind: str, rng: random.Random, values: Values) -> dict[str, float]:
    """A configuration on a random branch, two in five of them 1e-9 beside a flat one."""
    way = rng.choice(LINKAGES[kind].ways)
    flat = (-math.pi / 2, math.pi / 2) if kind == "slider-crank" else (0.0, math.pi)
    angle = rng.choice(flat) + 1e-9 if rng.random() < 0.4 else rng.uniform(-math.pi, math.pi)
    place = way(angle, values)
    return {name: place[name] for name in equations(kind).coordinate_names}


def check_equilibria(kind: str, seed: int) -> None:
    """Every equilibrium is a zero of the slope of the potential on a branch; it is stable where that rises.

    The slope is found by brentq to 1e-13; differences of five points with a step of 1e-4 leave it wrong by
    1e-12 of the potential, and curvatures below 1e-3 of that are not compared. Places agree to 1e-6.
    """
    rng = random.Random(seed)
    linkage, eqs = LINKAGES[kind], equations(kind)
    values = linkage.draw(rng)
    known = rests(linkage, values)
    found = sb.find_equilibrium(eqs, guess_for(kind, rng, values), parameters(kind, values))
    weight = G * (values["m1"] + 2 * values["m2"] + values["mk"]) + 60.0  # and the spring's largest force
    for state in (found, *found.branches):
        rest = nearest(state, known)
        assert apart(state, rest.q) < 1e-6
        # Beside a flat pose levers are as long as the angle from it, so the multipliers stay below this.
        assert max(map(abs, state.multipliers.values())) < 1e4 * weight
    curvature = nearest(found, known).curvature
    if abs(curvature) > 1e-3 * weight * values["a"]:
        assert found.stable is (curvature > 0.0)


@pytest.mark.parametrize("kind", cases(LINKAGES, fast=["two cranks"]))
def test_equilibria_are_those_of_the_potential(kind: str) -> None:
    for seed in range(2):
        check_equilibria(kind, seed)


def test_an_equilibrium_a_thousandth_of_a_radian_beside_a_crossing() -> None:
    check_equilibria("slider-crank", 1387)


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(34))
@pytest.mark.parametrize("kind", LINKAGES)
def test_equilibria_are_those_of_the_potential_everywhere(kind: str, chunk: int) -> None:
    for seed in range(1000 + CHUNK * chunk, 1000 + CHUNK * (chunk + 1)):
        check_equilibria(kind, seed)


FLAT = {"a": 1.0, "b": 2.0, "m1": 1.0, "m2": 1.0, "mk": 1.0, "c1": 0.5, "c2": 0.5, "kx": 1.0, "ky": 0.0,
        "d": 0.2}  # fmt: skip


def test_weights_across_a_flat_parallelogram_are_not_balanced_by_it() -> None:
    """The cranks lie along the ground link and gravity is across: V = m g a sin q1 rests at +-pi/2 only.

    Flat, J has the rank 1, and off the manifold by 1e-6 a direction in which no work is done: 1e6 N there.
    """
    values = FLAT | {"gx": 0.0, "gy": -G}
    known = rests(LINKAGES["two cranks"], values)
    for angle in (0.0, 0.3, 3.0, -3.1):
        guess = {"q1": angle, "q3": -angle, "p0": angle}
        found = sb.find_equilibrium(equations("two cranks"), guess, values)
        for state in (found, *found.branches):
            assert apart(state, nearest(state, known).q) < 1e-6
            assert max(map(abs, state.multipliers.values())) < 10 * 3 * G
    assert any(abs(abs(math.remainder(rest.q["q1"], 2 * math.pi)) - math.pi / 2) < 1e-9 for rest in known)


def test_weights_along_a_flat_parallelogram_rest_where_branches_cross() -> None:
    """Gravity along the ground link: V = -m g a cos q1 is stationary at q1 = 0 on both branches.

    Linear equations do not tell about it: beside it the linkage has one freedom, at it two.
    """
    guess = {"q1": 0.3, "q3": -0.3, "p0": 0.3}
    found = sb.find_equilibrium(equations("two cranks"), guess, FLAT | {"gx": G, "gy": 0.0})
    assert max(abs(x) for x in found.q.values()) < 1e-7
    assert max(map(abs, found.multipliers.values())) < 3 * G
    assert found.verdict == "undecided" and found.stable is None
    assert any("branches of the motion cross" in note for note in found.notes)


def column(load: float) -> sb.EquationSet:
    """A rigid column of 1 m on a hinge with a spring of 2 N m: it buckles at 2 N (P L = k)."""
    rod = sb.Body("Rod", mass=1, inertia=(0, 0, 1), frames={"T": sb.Frame(at=(0, 1, 0))})
    hinge = sb.Revolute("A", "ground", rod, coordinate="q", torque=sb.Drive(stiffness=2, damping=0.1))
    push = sb.Force("P", "Rod.T", vector=(0, "-P", 0))
    return sb.form_equations(sb.Model("column", [rod, hinge, push], parameters={"P": load}))


@pytest.mark.parametrize(("load", "verdict"), [(1.9, "stable"), (2.0, "critical"), (2.1, "unstable")])
def test_the_buckling_load_is_critical_and_no_continuum(load: float, verdict: str) -> None:
    """The moment P sin q - k q is -P q^3 / 6 at the buckling load: q = 0 is the only equilibrium about."""
    found = sb.find_equilibrium(column(load))
    assert found.q["q"] == pytest.approx(0.0, abs=1e-9) and found.verdict == verdict
    assert not any("continuum" in note for note in found.notes)
    assert any("critical" in note for note in found.notes) is (verdict == "critical")


def test_a_continuum_beside_a_critical_direction() -> None:
    """The column at its buckling load on a cart that rolls: the cart may stand anywhere."""
    cart, rod = sb.Body("C", 1), sb.Body("Rod", 1, (0, 0, 1), frames={"T": sb.Frame(at=(0, 1, 0))})
    parts = [
        cart, rod, sb.Prismatic("s", "ground", cart, axis="x", coordinate="x"),
        sb.Revolute("A", cart, rod, coordinate="q", torque=sb.Drive(stiffness=2, damping=0.1)),
        sb.Force("P", "Rod.T", vector=(0, -2, 0)),
    ]  # fmt: skip
    found = sb.find_equilibrium(sb.form_equations(sb.Model("cart", parts)))
    assert any("continuum of 1 dimension(s) along x;" in note for note in found.notes)
    assert any("stiffness vanishes along q," in note for note in found.notes) and found.verdict == "critical"


def test_a_flat_truss_that_gives_way_bears_nothing() -> None:
    """Two rods in a line between fixed pins, a weight on the joint: the tension has no bound."""
    bars = [sb.Body(name, 1, (0, 0, 0.1), frames={"a": sb.Frame(at=(-0.5, 0, 0)), "b": sb.Frame(at=(0.5, 0, 0))})
            for name in ("One", "Two")]  # fmt: skip
    parts = [*bars, sb.Revolute("A", "ground", "One.a", coordinate="p"),
             sb.Revolute("B", "One.b", "Two.a", coordinate="q"), sb.Revolute("C", "Two.b", "ground.c")]  # fmt: skip
    ground = {"c": sb.Frame(at=(2, 0, 0))}
    eqs = sb.form_equations(sb.Model("truss", parts, gravity=(0, -G, 0), ground=ground))
    with pytest.raises(sb.AssemblyError, match=r"equilibrium\.none"):
        sb.find_equilibrium(eqs)
    assert np.isfinite(list(sb.assemble(eqs).q.values())).all()
