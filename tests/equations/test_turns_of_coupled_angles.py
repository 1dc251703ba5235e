"""Whole turns of angles that couplings tie to each other count, whether they are substituted or not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import symbody as sb


def turned_train() -> sb.Model:
    """A wheel x that turns twice as fast as y, against a spring, a damper, and a torque tau."""
    elements: list[Any] = []
    for name, torque in (("x", sb.Drive(applied="tau", stiffness=5)), ("y", sb.Drive(damping=0.1))):
        elements.append(sb.Body(f"B{name}", mass=1, inertia=[1, 1, 1]))
        joint = sb.Revolute(f"J{name}", "ground", f"B{name}", axis="z", coordinate=name, torque=torque)
        elements.append(joint)
    gear = sb.Gear("gear", ["x", "y"], ratio=2, offset=0.1)
    return sb.Model("turned", [*elements, gear], inputs=["tau"], gravity=[0, 0, 0])


@pytest.mark.parametrize("substitute", [True, False])
def test_turns_of_a_coordinate_that_follows_count(substitute: bool) -> None:
    """An angle that a coupling gives is no measured one: 7 rad are not 7 - 2 pi, and the spring counts them."""
    eqs = sb.form_equations(turned_train(), substitute=substitute)
    assert sb.compile(eqs, "x")(0.0, *start_of(eqs, {"x": 7.0}), [0.0]) == pytest.approx(7)
    assert sb.compile(eqs, "y")(0.0, *start_of(eqs, {"x": 0.7}, {"y": 3.0}), [0.0]) == pytest.approx(0.3)
    rest = sb.find_equilibrium(eqs, {"y": 3}, unknowns="tau", fixed={"x": 10.0})
    assert rest.inputs["tau"] == pytest.approx(50)
    run = sb.inverse_dynamics(eqs, {"x": "10 + t^2"}, "tau", [0.0, 1.0])
    assert run["x"] == pytest.approx([10, 11])
    inertia = 1 + 1 / 4
    assert run["tau"] == pytest.approx([2 * inertia + 50, 2 * inertia + 55 + 0.1 * 2 / 4])


@pytest.mark.parametrize("substitute", [True, False])
def test_ranges_of_geared_angles_are_where_the_gear_holds(substitute: bool) -> None:
    eqs = sb.form_equations(turned_train(), substitute=substitute)
    for guess, name in ({"x": 0.7}, "x"), ({"y": 0.3}, "y"):
        q, u = start_of(eqs, {}, guess, ranges={name: (6, 7)})
        x, y = sb.compile(eqs, ["x", "y"])(0.0, q, u, [0.0])
        assert x == pytest.approx(2 * y + 0.1)
        assert 6 <= (x if name == "x" else y) <= 7
    with pytest.raises(sb.AssemblyError, match="x from 0 to 1"):
        sb.assemble(eqs, ranges={"y": (6, 7), "x": (0, 1)})


def start_of(eqs: sb.EquationSet, *values: Any, **words: Any) -> tuple[Any, Any]:
    """Return q and u of an assembled state."""
    state = sb.assemble(eqs, *values, **words)
    return np.array(list(state.q.values())), np.array(list(state.u.values()))
