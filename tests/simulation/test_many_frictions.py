"""Several joints that stick and slip: however they are listed, shared, or as close as a smooth law comes."""

from __future__ import annotations

from functools import cache
from itertools import permutations, product

import numpy as np
import pytest

import symbody as sb
from tests.tiers import rows

PINS = "ABCD"
START = {"a": 0.6, "b": -0.3, "c": 1.1}


def four_bar(rubbing: str, order: tuple[str, ...], mu_static: float) -> sb.EquationSet:
    """A four-bar linkage under its weight whose pins of radius 0.05 m rub with mu = 0.1."""
    lengths = {"Crank": 0.5, "Rod": 1.5, "Rocker": 1.0}
    bodies = {
        name: sb.Body(name, length, (0, 0, length**3 / 12),
                      frames={"p": sb.Frame(at=(-length / 2, 0, 0)), "q": sb.Frame(at=(length / 2, 0, 0))})
        for name, length in lengths.items()
    }  # fmt: skip
    base = sb.Frame(at=(1.6, 0, 0))
    ends = {"A": ("ground", "Crank.p", "a"), "B": ("Crank.q", "Rod.p", "b"),
            "C": ("Rod.q", "Rocker.q", "c"), "D": ("ground.right", "Rocker.p", "d")}  # fmt: skip
    law = sb.Friction(mu=0.1, mu_static=mu_static, radius=0.05)
    joints = [
        sb.Revolute(
            name, *ends[name][:2], coordinate=ends[name][2], friction=law if name in rubbing else None
        )
        for name in order
    ]
    model = sb.Model("four-bar", [*bodies.values(), *joints], gravity=(0, -9.81, 0), ground={"right": base})
    return sb.form_equations(model, tree=sb.Trees("ABC", "ABC"))


@cache
def moved(rubbing: str, order: tuple[str, ...], mu_static: float) -> sb.Trajectory:
    return sb.simulate(
        four_bar(rubbing, order, mu_static), 2.5, {"a": 0.6}, guess=START, rtol=1e-9, atol=1e-11
    )


@pytest.mark.parametrize(
    ("order", "rubbing", "mu_static"),
    rows(product([*permutations(PINS)][1:], ["B", PINS], [0.1, 0.2]),
         fast=[(tuple("BADC"), PINS, 0.1), (tuple("DCBA"), "B", 0.2)]),
)  # fmt: skip
def test_the_order_of_joints_changes_nothing(rubbing: str, order: tuple[str, ...], mu_static: float) -> None:
    first, other = moved(rubbing, tuple(PINS), mu_static), moved(rubbing, order, mu_static)
    assert first.success and other.success and first.energy_drift < 1e-6
    assert len(first.modes) == (3 if rubbing == "B" else 18)
    assert not any("undetermined reactions" in note for note in first.notes)  # those in the plane are not

    def changes(run: sb.Trajectory) -> list[tuple[float, str, str]]:
        return sorted((round(change.t, 6), change.name, change.mode) for change in run.modes)

    times = [[change[0] for change in changes(run)] for run in (first, other)]
    assert [change[1:] for change in changes(first)] == [change[1:] for change in changes(other)]
    assert times[1] == pytest.approx(times[0], abs=1e-6)
    for name in ("a", "b", "c"):
        assert other[name][-1] == pytest.approx(first[name][-1], abs=1e-7)


def test_a_door_on_two_hinges_stops_by_both() -> None:
    """Each hinge holds back by its torque: w falls by (2 + 3) N m over 4 kg m2, and 4.9 N m do not open it."""
    door = sb.Body(
        "Door",
        mass=12,
        inertia=(4, 4, 4),
        frames={"low": sb.Frame(at=(0, 0, -1)), "up": sb.Frame(at=(0, 0, 1))},
    )
    hinges = [
        sb.Revolute(
            f"hinge {place}",
            f"ground.{place}",
            f"Door.{place}",
            coordinate=name,
            friction=sb.Friction(force=torque),
        )
        for place, name, torque in (("low", "a", 2), ("up", "b", 3))
    ]
    push = sb.Torque("push", on="Door", vector=[0, 0, "if(t < 2, 0, if(t < 3, 4.9, 5.1))"])
    ground = {"low": sb.Frame(at=(0, 0, -1)), "up": sb.Frame(at=(0, 0, 1))}
    eqs = sb.form_equations(sb.Model("door", [door, *hinges, push], ground=ground, initial={"a_dot": 1}))
    run = sb.simulate(eqs, 4.0, times=[0, 0.5, 2, 3, 4], rtol=1e-10)
    rest = 1 / (2 * 1.25)
    assert run.success
    assert run["a"] == pytest.approx([0, 0.5 - 1.25 / 8, rest, rest, rest + 0.1 / 4 / 2], abs=1e-8)
    assert run["a"] == pytest.approx(run["b"], abs=1e-12)
    assert {change.name for change in run.modes if change.mode == "sticks"} >= {"hinge low"}


def train(n: int, v0: float | None) -> sb.EquationSet:
    """Blocks on a rough floor between springs, pulled at one end to and fro."""
    bodies = [sb.Body(f"B{k}", mass=1 + 0.1 * k) for k in range(n)]
    law = sb.Friction(mu=0.2, v0=v0)
    guides = [
        sb.Prismatic(f"g{k}", "ground", body, axis="x", coordinate=f"x{k}", friction=law)
        for k, body in enumerate(bodies)
    ]
    forces = [sb.Force("pull", on=f"B{n - 1}", vector=["60*sin(4*t)", 0, 0])]
    for k in range(n - 1):
        spring = f"300*(x{k + 1} - x{k})"
        forces += [sb.Force(f"s{k}", on=f"B{k}", vector=[spring, 0, 0]),
                   sb.Force(f"r{k}", on=f"B{k + 1}", vector=[f"-{spring}", 0, 0])]  # fmt: skip
    return sb.form_equations(sb.Model("train", [*bodies, *guides, *forces], gravity=(0, 0, -9.81)))


@pytest.mark.parametrize("n", [8, pytest.param(16, marks=pytest.mark.exhaustive)])
def test_many_joints_move_as_with_a_fine_smooth_law(n: int) -> None:
    """The smooth law creeps by v0 at most where joints stick: 1e-6 m/s over 1.5 s, and times of slip follow."""
    dry = sb.simulate(train(n, None), 1.5, rtol=1e-9, atol=1e-11)
    smooth = sb.simulate(train(n, 1e-6), 1.5, rtol=1e-9, atol=1e-11, integrator=sb.Stiff())
    assert dry.success and smooth.success
    assert len(dry.modes) > 2 * n
    assert any(change.mode == "sticks" for change in dry.modes)
    np.testing.assert_allclose(dry.q[:, -1], smooth.q[:, -1], rtol=0, atol=1e-4)
    assert np.abs(dry.q[:, -1]).max() > 0.05
