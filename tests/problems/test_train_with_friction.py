"""Trains of blocks with dry friction between springs: against a smooth law at a small speed."""

from __future__ import annotations

import pytest

import symbody as sb

V0 = 1e-5


def train(count: int, friction: sb.Friction) -> sb.EquationSet:
    """Blocks in a row on guides of their own, springs between neighbours, pulled back and forth at one end."""
    blocks = [sb.Body(f"B{k}", "m") for k in range(count)]
    guides = [
        sb.Prismatic(f"g{k}", "ground", block, coordinate=f"x{k}", friction=friction)
        for k, block in enumerate(blocks)
    ]
    loads = [sb.Force("pull", blocks[-1].name, ("60*sin(9*t)", 0, 0))]
    for k in range(count - 1):
        spring = f"k*(x{k + 1} - x{k})"
        loads.append(sb.Force(f"s{k}", f"B{k}", (spring, 0, 0)))
        loads.append(sb.Force(f"r{k}", f"B{k + 1}", (f"-{spring}", 0, 0)))
    numbers = {"m": 1.0, "k": 400.0, "f": 3.0}
    return sb.form_equations(
        sb.Model("train", [*blocks, *guides, *loads], gravity=(0, 0, 0), parameters=numbers)
    )


def compare(count: int) -> None:
    dry = sb.simulate(train(count, sb.Friction(force="f")), 1.0, rtol=1e-9, atol=1e-11)
    smooth = sb.simulate(
        train(count, sb.Friction(force="f", v0=V0)), 1.0, rtol=1e-8, atol=1e-11, integrator=sb.Stiff()
    )
    assert dry.success and smooth.success and dry.energy_drift < 1e-8
    names = [event.name for event in dry.events]
    assert len(names) >= count and {f"g{k} slips forward" for k in range(count)} <= set(names)
    assert len(names) > count  # some turn back or stick
    # at rest the smooth law creeps, by up to 10 V0 in this time
    for k in range(count):
        assert dry[f"x{k}"][-1] == pytest.approx(float(smooth[f"x{k}"][-1]), abs=10.0 * V0)


def test_five_blocks_break_away_one_after_the_other() -> None:
    compare(5)


@pytest.mark.exhaustive
@pytest.mark.parametrize("count", [8, 16])
def test_many_blocks_break_away_one_after_the_other(count: int) -> None:
    compare(count)
