"""Walking: the gait of the simplest machine, and a rimless wheel whose spokes are rigid contacts."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.contacts.pairs import Floats

WALKER = Path(__file__).parents[2] / "examples" / "gallery" / "motions" / "walker.py"
ALPHA, SLOPE, SPOKES, G = np.pi / 8, 0.08, 8, 9.81


def test_newton_finds_the_gait_of_the_literature() -> None:
    """Digits of a program by Bhounsule (2013) for the gait of Garcia et al. 1998; SciPy for the multipliers.

    A note in the program of Garcia has multipliers of -0.1912 +- 0.5563i, differences with steps that it does
    not tell; integrated variational equations give those of the example, which are differences of 1e-5.
    """
    names = runpy.run_path(str(WALKER))
    behind, multipliers, period = names["gait"](sb.form_equations(names["model"]()))
    assert behind == pytest.approx([0.20031090056, -0.19983247303], abs=1e-10)
    assert period == pytest.approx(3.882, abs=5e-4)
    (pair,) = (each for each in multipliers if each.imag > 0)
    assert pair == pytest.approx(-0.1912 + 0.5563j, abs=2e-3)
    ahead, jacobian, lasts = varied_step(behind, names["SLOPE"])
    assert ahead == pytest.approx(behind, abs=1e-9) and period == pytest.approx(lasts, abs=1e-8)
    assert pair == pytest.approx(max(np.linalg.eigvals(jacobian), key=lambda each: each.imag), abs=1e-6)


def varied_step(behind: Floats, slope: float) -> tuple[Floats, Floats, float]:
    """Return the state behind the next landing, its derivative by that behind this one, and the time between.

    The equations of Garcia et al. 1998, whose foot has no mass, with their variational equations.
    """
    angle, rate = behind

    def rates(_: float, values: Floats) -> Floats:
        theta, phi, w, swing = values[:4]
        along, down = np.sin(theta - slope), np.cos(theta - slope)
        slopes = np.zeros((4, 4))
        slopes[0, 2] = slopes[1, 3] = 1
        slopes[2, 0] = down
        slopes[3, :3] = down + along * np.sin(phi), (w * w - down) * np.cos(phi), 2 * w * np.sin(phi)
        moved = slopes @ values[4:].reshape(4, 4)
        return np.array([w, swing, along, along + (w * w - down) * np.sin(phi), *moved.ravel()])

    def lands(_: float, values: Floats) -> float:
        return float(values[1] - 2 * values[0] - 10 * max(values[0], 0))

    lands.terminal, lands.direction = True, 1  # type: ignore[attr-defined]
    first = [angle, 2 * angle, rate, (1 - np.cos(2 * angle)) * rate, *np.eye(4).ravel()]
    run: Any = solve_ivp(rates, (0, 6), first, method="DOP853", rtol=1e-13, atol=1e-15, events=lands)
    end = run.y_events[0][0]
    along_motion, at_landing = rates(0.0, end)[:4], np.array([-2.0, 1, 0, 0])
    moved = end[4:].reshape(4, 4) @ [
        [1, 0],
        [2, 0],
        [0, 1],
        [2 * np.sin(2 * angle) * rate, 1 - np.cos(2 * angle)],
    ]
    moved -= np.outer(along_motion, at_landing @ moved) / (at_landing @ along_motion)
    theta, w = end[0], end[2]
    changed = np.array([[-1, 0, 0, 0], [-2 * np.sin(2 * theta) * w, 0, np.cos(2 * theta), 0]])
    return np.array([-theta, np.cos(2 * theta) * w]), changed @ moved, float(run.t_events[0][0])


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
        assert behind[-1] ** 2 - end**2 == pytest.approx(0.5 ** len(strikes) * (start**2 - end**2), rel=1e-2)
    assert {event.name.partition(" ")[0] for event in strikes} > {"spoke1", "spoke2", "spoke3"}
