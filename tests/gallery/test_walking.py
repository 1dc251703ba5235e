"""Walking: the gait of the simplest machine, and a rimless wheel whose spokes are rigid contacts."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

import symbody as sb

WALKER = Path(__file__).parents[2] / "examples" / "gallery" / "motions" / "walker.py"
ALPHA, SLOPE, SPOKES, G = np.pi / 8, 0.08, 8, 9.81


def test_newton_finds_the_gait_of_the_literature() -> None:
    """Garcia et al. 1998, with the digits of Bhounsule 2014; multipliers by differences of 1e-5."""
    names = runpy.run_path(str(WALKER))
    behind, multipliers, period = names["gait"](sb.form_equations(names["model"]()))
    assert behind == pytest.approx([0.200310900544, -0.199832473005], abs=1e-9)
    assert period == pytest.approx(3.8824637529, abs=1e-8)
    (pair,) = (each for each in multipliers if each.imag > 0)
    assert pair == pytest.approx(-0.19009984 + 0.55759878j, abs=5e-6)


def rimless_wheel(inertia: float) -> sb.EquationSet:
    """Return eight spokes of 1 m, whose ends are rigid contacts that stick, down a slope along x."""
    angles = 2 * ALPHA * np.arange(SPOKES)
    feet = {f"foot{k}": sb.Frame((float(np.sin(a)), 0, float(-np.cos(a)))) for k, a in enumerate(angles)}
    wheel = sb.Body("Wheel", 1.0, (inertia,) * 3, frames=feet)
    contacts = [
        sb.Contact(f"spoke{k}", "ground", f"Wheel.foot{k}", ["plane", "point"], normal="rigid",
                   friction=sb.Friction(mu=2.0))
        for k in range(SPOKES)
    ]  # fmt: skip
    joint = sb.Planar("move", "ground", wheel, axis="y", coordinates=["z", "x", "theta"])
    gravity = (G * np.sin(SLOPE), 0, -G * np.cos(SLOPE))
    return sb.form_equations(sb.Model("rimless wheel", [joint, *contacts], gravity=gravity))


@pytest.mark.parametrize("inertia", [1e-6, 0.3])
def test_a_rimless_wheel_of_rigid_contacts_rolls_as_mcgeer_says(inertia: float) -> None:
    """A strike leaves 1 - (1 - cos(2a))/(1 + J/(m l^2)) of the rate; to it a step adds the work of the weight.

    McGeer 1990; without inertia the rate behind a strike tends to cot(2a) sqrt(4 g/l sin(a) sin(slope)).
    """
    start, sine, cosine = 1.4, np.sin(ALPHA), np.cos(ALPHA)
    first = {
        "theta": -ALPHA, "z": cosine, "x": -sine,
        "theta_dot": start, "x_dot": start * cosine, "z_dot": start * sine,
    }  # fmt: skip
    run = sb.simulate(rimless_wheel(inertia), 9.0, first, rtol=1e-10)
    assert run.success
    strikes = [event for event in run.events if event.name.endswith("impact")]
    behind = np.array([run.at(event.t + 1e-9)["theta_dot"] for event in strikes])
    left = 1 - (1 - np.cos(2 * ALPHA)) / (1 + inertia)
    gain = 4 * G * sine * np.sin(SLOPE) / (1 + inertia)
    squares = [start**2]
    for _ in strikes:
        squares.append(left**2 * (squares[-1] + gain))
    assert len(strikes) >= 8
    np.testing.assert_allclose(behind, np.sqrt(squares[1:]), rtol=2e-6)
    if inertia < 1e-3:
        end = np.sqrt(4 * G * sine * np.sin(SLOPE)) / np.tan(2 * ALPHA)
        assert end == pytest.approx(1.0954628396, abs=1e-9)
        assert behind[-1] ** 2 - end**2 == pytest.approx(0.5 ** len(strikes) * (start**2 - end**2), rel=1e-2)
    assert {event.name.partition(" ")[0] for event in strikes} > {"spoke1", "spoke2", "spoke3"}
