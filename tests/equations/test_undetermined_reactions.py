"""Reactions of redundant joints: shares of least norm in closed form, and the names of what is undetermined."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy as sp

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from tests.formulations import FORMULATIONS
from tests.tiers import cases, rows

G = 9.81
# Closed forms of a few operations; poses are given exactly or assembled to 1e-9 of the size.
CLOSE = 1e-8


def cart(
    places: Sequence[tuple[float, float]], names: Sequence[str], centre: tuple[float, float] = (0.0, 0.0)
) -> sb.Model:
    """A cart of 120 kg on points that stay on the ground."""
    frames = {
        f"at{n}": sb.Frame(at=(x - centre[0], y - centre[1], -0.2))
        for n, (x, y) in zip(names, places, strict=True)
    }
    body = sb.Body("Cart", mass=120, inertia=(5, 6, 7), frames=frames)
    points = [sb.PointOnPlane(name, "ground", f"Cart.at{name}") for name in names]
    return sb.Model("cart", [body, *points], gravity=(0, 0, -G), initial={"Cart_z": 0.2})


CORNERS = ((0.5, 0.3), (0.5, -0.3), (-0.5, 0.3), (-0.5, -0.3))


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 1, 0, 2), (2, 3, 1, 0)])
@pytest.mark.parametrize("names", cases(["ABCD", "DZAQ"], fast=["DZAQ"]))
def test_a_symmetric_cart_stands_on_its_four_wheels_alike(order: tuple[int, ...], names: str) -> None:
    eqs = sb.form_equations(cart([CORNERS[k] for k in order], list(names)))
    state = sb.assemble(eqs)
    for name in names:
        assert state[f"reaction {name} Fz"] == pytest.approx(120 * G / 4, rel=CLOSE)
    wheels = tuple(f"reaction {name} Fz" for name in names)
    assert eqs.undetermined_reactions == wheels == sb.redundancy(eqs).undetermined
    run = sb.simulate(eqs, 0.1)
    assert any("undetermined" in note and "minimum-norm" in note for note in run.notes)


def test_a_cart_with_its_load_aside() -> None:
    """The least sum of squares of F_i under sum F = W, sum F x = W c_x, sum F y = W c_y has
    F_i = a + b x_i + c y_i; here sums of x, y and x y vanish: a = W / 4, b = W c_x / sum x^2, c alike."""
    c_x, c_y = 0.2, -0.1
    state = sb.assemble(sb.form_equations(cart(CORNERS, list("ABCD"), (c_x, c_y))))
    for name, (x, y) in zip("ABCD", CORNERS, strict=True):
        share = 1 / 4 + c_x * x / (4 * 0.5**2) + c_y * y / (4 * 0.3**2)
        assert state[f"reaction {name} Fz"] == pytest.approx(120 * G * share, rel=CLOSE)


def test_three_wheels_determine_everything() -> None:
    eqs = sb.form_equations(cart(CORNERS[:3], list("ABC"), (0.1, 0.1)))
    assert eqs.undetermined_reactions == () == sb.redundancy(eqs).undetermined
    assert not any("undetermined" in note for note in sb.simulate(eqs, 0.1).notes)


def door(
    names: Sequence[str] = ("H0", "H1"), friction: sb.Friction | None = None, torque: str = "0"
) -> sb.Model:
    """A door of 20 kg, its centre 0.4 m beside two hinges 1.6 m above each other; I = 1.5 + 20 0.4^2 = 4.7."""
    heights = dict(zip(names, (-0.8, 0.8), strict=True))
    body = sb.Body(
        "Door",
        mass=20,
        inertia=(2, 3, 1.5),
        frames={f"at{name}": sb.Frame(at=(-0.4, 0, z)) for name, z in heights.items()},
    )
    hinges = [
        sb.Revolute(name, f"ground.at{name}", f"Door.at{name}", coordinate=f"a{name}", friction=friction)
        for name in sorted(names)
    ]
    turn = sb.Torque("turn", on="Door", vector=(0, 0, torque))
    ground = {f"at{name}": sb.Frame(at=(0, 0, z)) for name, z in heights.items()}
    return sb.Model("door", [body, *hinges, turn], gravity=(0, 0, -G), ground=ground)


WAYS = (None, *FORMULATIONS)


@pytest.mark.parametrize("tree", [None, "absolute"])
@pytest.mark.parametrize("formulation", WAYS, ids=lambda f: type(f).__name__)
@pytest.mark.parametrize("names", cases([("H0", "H1"), ("Z", "A")], fast=[("Z", "A")]))
def test_two_hinges_share_the_weight_of_a_door(
    names: tuple[str, str], formulation: object, tree: str | None
) -> None:
    """At rest at 0: vertical m g / 2 each. The moment T = m g 0.4 about y is borne by horizontal forces -F, F
    at the distance L = 1.6 and moments M: the least 2 F^2 + 2 (M / L)^2 under F L + 2 M = T has
    F = c L, M = 2 c L^2, so F = T / (5 L), M = 2 T / 5. L is the largest distance between frames of a body."""
    eqs = sb.form_equations(door(names), formulation, tree=tree)  # type: ignore[arg-type]
    state = sb.assemble(eqs)
    moment = 20 * G * 0.4
    for name, sign in zip(names, (1, -1), strict=True):
        found = state[f"reaction {name}"]
        expected = [-sign * moment / (5 * 1.6), 0, 20 * G / 2, 0, -2 * moment / 5, 0]
        assert np.abs(np.abs(found) - np.abs(expected)).max() < CLOSE * moment
        assert found[2] > 0
    below, above = (state[f"reaction {name} Fx"] for name in names)
    assert below > 0 > above  # the door leans away from the lower hinge, and pulls the upper one
    entries = ("Fx", "Fy", "Fz", "Mx", "My")
    assert set(eqs.undetermined_reactions) == {f"reaction {n} {e}" for n in names for e in entries}
    if tree is None:
        assert any(n.startswith("redundant constraints leave undetermined: reaction") for n in eqs.notes)
        assert eqs.multiplier_names == ()


def test_formulas_keep_the_multipliers_of_redundant_rows() -> None:
    """The second hinge bears whatever its five multipliers are; both together bear the weight."""
    eqs = sb.form_equations(door())
    first, second = (eqs.reaction(name).force[2] for name in ("H0", "H1"))
    assert {str(symbol.func) for symbol in second.atoms(sp.Function)} == {"lambda_H1_3"}
    assert sp.simplify(first + second - sp.Rational(20 * 981, 100)) == 0


def test_texts_and_machine_code_give_the_same_share() -> None:
    eqs = sb.form_equations(door())
    space: dict[str, Any] = {}
    exec(sb.generate_code(eqs, "reaction H0", "python", parameters={}), space)
    found = np.ravel(space["f"](0.0, [0.3], [0.5]))
    expected = np.ravel(sb.compile(eqs, "reaction H0")(0.0, [0.3], [0.5]))
    # Sines of other libraries, and no fma: some eps of the weight.
    assert np.abs(found - expected).max() < 1e-12 * 20 * G


@pytest.mark.parametrize(
    ("tree", "friction"),
    rows(product([None, "absolute"], [sb.Friction(mu=0.2), sb.Friction(mu=0.2, v0=1e-5)]),
         fast=[("absolute", sb.Friction(mu=0.2)), (None, sb.Friction(mu=0.2, v0=1e-5))]),
)  # fmt: skip
def test_a_drawer_on_two_guides_is_held_by_its_whole_weight(friction: sb.Friction, tree: str | None) -> None:
    """N_1 + N_2 = m g however they share, as long as both push up: x = v t - mu g t^2 / 2."""
    places = {"L": -0.2, "R": 0.3}
    frames = {name: sb.Frame(at=(0, y, 0)) for name, y in places.items()}
    body = sb.Body("Drawer", mass=3, inertia=(0.1, 0.1, 0.1), frames=frames)
    guides = [
        sb.Prismatic(n, f"ground.{n}", f"Drawer.{n}", axis="x", coordinate=f"x{n}", friction=friction)
        for n in "LR"
    ]
    eqs = sb.form_equations(sb.Model("drawer", [body, *guides], gravity=(0, 0, -G), ground=frames), tree=tree)
    run = sb.simulate(eqs, 0.5, {"xL_dot": 2.0})
    assert run.status is sb.Status.SUCCESS
    assert run["friction_normal L"] + run["friction_normal R"] == pytest.approx(3 * G, rel=CLOSE)
    # With v0 the law has the strength v / sqrt(v^2 + v0^2) = 1 - 5e-11 at 1 m/s.
    assert run["xL"][-1] == pytest.approx(2.0 * 0.5 - 0.2 * G * 0.5**2 / 2, rel=1e-7)
    assert any(note.startswith("friction of L, R depends on undetermined reactions") for note in run.notes)


def test_a_door_with_friction_in_two_hinges() -> None:
    """With the shares above each hinge bears m g / 20 = 9.81 N across, one inward and one outward, half of
    the centripetal m 0.4 w^2 and half of the tangential m 0.4 w'. So N_1 and N_2 follow from w', and w' from
    them: I w' = -mu r (N_1 + N_2), which is iterated here; each step gains a factor of 1e-3."""
    mu, radius = 0.2, 0.02
    eqs = sb.form_equations(door(friction=sb.Friction(mu=mu, radius=radius)))
    run = sb.simulate(eqs, 2.0, {"aH0_dot": 1.0})
    assert run.status is sb.Status.SUCCESS
    for k in (0, -1):
        inward, rate = 20 * 0.4 * run["aH0_dot"][k] ** 2 / 2, 0.0
        for _ in range(20):
            tangential = 20 * 0.4 * rate / 2
            normals = [np.hypot(G - inward, tangential), np.hypot(G + inward, tangential)]
            rate = -mu * radius * sum(normals) / 4.7
        assert run["aH0_ddot"][k] == pytest.approx(rate, rel=CLOSE)
        found = [run["friction_normal H0"][k], run["friction_normal H1"][k]]
        assert sorted(found) == pytest.approx(normals, rel=CLOSE)


def test_hinges_that_stick_hold_alike() -> None:
    """Of one holding torque 0.03 N m each of two hinges takes half: the least sum of squares."""
    friction = sb.Friction(mu=0.2, radius=0.02)
    run = sb.simulate(sb.form_equations(door(friction=friction, torque="0.03")), 1.0)
    assert run.status is sb.Status.SUCCESS
    for name in ("H0", "H1"):
        assert run[f"friction {name}"][-1] == pytest.approx(-0.015, rel=CLOSE)
    assert abs(run["aH0"]).max() == 0.0


def cranks(lengths: Sequence[str]) -> sb.Model:
    """Parallel cranks on a rod, with their lengths as parameters."""
    feet = [0.0, 1.0, 2.5]
    elements: list[object] = []
    for k, length in enumerate(lengths):
        ends = {"o": sb.Frame(at=(f"-{length}/2", 0, 0)), "t": sb.Frame(at=(f"{length}/2", 0, 0))}
        elements.append(sb.Body(f"C{k}", mass=1, inertia=(0.1, 0.1, 0.1), frames=ends))
    frames = {f"p{k}": sb.Frame(at=(x - 1.2, 0, 0)) for k, x in enumerate(feet)}
    elements.append(sb.Body("Rod", mass=2, inertia=(0.5, 0.5, 0.5), frames=frames))
    for k in range(len(feet)):
        elements.append(sb.Revolute(f"A{k}", f"ground.f{k}", f"C{k}.o", coordinate=f"a{k}"))
        elements.append(sb.Revolute(f"B{k}", f"C{k}.t", f"Rod.p{k}", coordinate=f"b{k}"))
    ground = {f"f{k}": sb.Frame(at=(x, 0, 0)) for k, x in enumerate(feet)}
    initial = {f"{letter}{k}": sign * 1.0 for k in range(3) for letter, sign in (("a", 1), ("b", -1))}
    parameters = dict.fromkeys(lengths, 0.7)
    return sb.Model(
        "cranks", elements, gravity=(0, -G, 0), ground=ground, initial=initial, parameters=parameters
    )


def test_what_values_decide_stands_in_redundancy_and_in_the_run() -> None:
    """Three parallel cranks move only where their lengths are equal; then they share the load of the rod in the
    plane too. Off the plane loops of spatial joints are redundant whatever the lengths."""
    eqs = sb.form_equations(cranks(("l0", "l1", "l2")))
    off_plane = {f"reaction {j}{k} {e}" for j in "AB" for k in range(3) for e in ("Fz", "Mx", "My")}
    assert set(eqs.undetermined_reactions) == off_plane
    found = set(sb.redundancy(eqs).undetermined)
    # Forces along the cranks: along x of their own axes at the rod, along x and y of ground at their feet.
    at_feet = {f"reaction A{k} {e}" for k in range(3) for e in ("Fx", "Fy")}
    assert found - off_plane == at_feet | {f"reaction B{k} Fx" for k in range(3)}
    run = sb.simulate(eqs, 0.05)
    told = [
        note
        for note in run.notes
        if note.startswith("redundant constraints leave undetermined in this motion")
    ]
    assert len(told) == 1 and "reaction A0 Fx, Fy" in told[0] and "Fz" not in told[0]


def test_trees_leave_nothing_undetermined() -> None:
    body = sb.Body("B", mass=1, inertia=(1, 1, 1))
    eqs = sb.form_equations(sb.Model("t", [sb.Revolute("J", "ground", body, coordinate="a")]))
    assert eqs.undetermined_reactions == ()
    assert not any("undetermined" in note for note in eqs.notes)


@pytest.mark.parametrize("formulation", WAYS, ids=repr)
def test_loads_on_four_wheels_are_shares(formulation: Formulation | None) -> None:
    """Heights that hold identically are found while the equations are formed, in the frames of the contacts."""
    corners = {f"a{k}": sb.Frame(at=(x, y, "r")) for k, (x, y) in enumerate(product((1, -1), repeat=2))}
    elements: list[object] = [
        sb.Body("Cart", mass=3, inertia=(1, 1, 1), frames=corners),
        sb.Planar("floor", "ground", "Cart"),
    ]
    for k in range(4):
        elements.append(sb.Body(f"W{k}", mass=1, inertia=(0.1, 0.2, 0.1)))
        elements.append(sb.Revolute(f"pin{k}", f"Cart.a{k}", f"W{k}", axis="y"))
        elements.append(sb.Rolling(f"tyre{k}", "ground", f"W{k}", radius="r", normal="z", axis="y"))
    model = sb.Model("cart", elements, gravity=(0, 0, -9.81), parameters={"r": 0.3})
    eqs = sb.form_equations(model, formulation)
    assert {f"reaction tyre{k} Fz" for k in range(4)} <= set(eqs.undetermined_reactions)
    assert eqs.roots("reaction tyre0").shape == (6,)
