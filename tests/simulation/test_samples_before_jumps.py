"""Samples inside a step that ends at a jump of a force, where the state is projected onto constraints."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb


def pulled(rope: bool) -> sb.EquationSet:
    parts = [
        sb.Body("b", mass=1),
        sb.Prismatic("Q", "ground", "b", coordinate="x", force=sb.Drive(applied="if(t < 1, P, -P)")),
        sb.Body("a", mass=2),
        sb.Prismatic("S", "ground", "a", coordinate="s"),
        sb.Distance("R", "a", "b", value=0.5, rope=rope),
    ]
    return sb.form_equations(sb.Model("pulled", parts, parameters={"P": 15}, initial={"x": 0, "s": -0.5}))


@pytest.mark.parametrize("rope", [False, True])
def test_speeds_before_a_jump_of_the_force(rope: bool) -> None:
    eqs = pulled(rope)
    run = sb.simulate(eqs, 2.0, times=np.linspace(0, 2, 101), rtol=1e-9)
    before = run.t < 1.0
    assert run["x_dot"][before] == pytest.approx(5.0 * run.t[before], abs=1e-8)
    assert run["x"][before] == pytest.approx(2.5 * run.t[before] ** 2, abs=1e-8)


@pytest.mark.parametrize("lanes", [False, True])
def test_the_same_in_sweeps(lanes: bool) -> None:
    forces = [3.0 * k for k in range(1, 9)]
    times = np.linspace(0, 2, 101)
    swept = sb.sweep(pulled(False), 2.0, parameters={"P": forces}, times=times, lanes=lanes)
    for force, speeds in zip(forces, swept["x_dot"], strict=True):
        assert speeds[times < 1.0] == pytest.approx(force / 3.0 * times[times < 1.0], abs=1e-7)
