"""What the contacts of examples/gallery do beyond their comparisons: limits, ends, equations by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.gallery.test_gallery_checks import module_of, motion_of


@pytest.mark.parametrize(("share", "slips"), [(0.97, True), (1.01, False)])
def test_a_box_slips_while_it_is_lifted_if_friction_is_less_than_it_needs(share: float, slips: bool) -> None:
    """At the start of the lift each finger needs `m (g + a)/2`, once the table bears nothing any more."""
    module = module_of("gripper")
    (begin, end), rise = module.LIFTS, module.RISE
    free = begin + (end - begin) / np.pi * np.arccos(1 - 2 * module.SINKS / rise)  # s, off the table
    lift = rise / 2 * (np.pi / (end - begin)) ** 2 * np.cos(np.pi * (free - begin) / (end - begin))
    module.MU = share * module.MASS * (module.G + lift) / (2 * module.GRIP)
    run = sb.simulate(sb.form_equations(module.model()), 1.4, rtol=1e-8)
    assert run.success
    slipped = [event.t for event in run.events if event.name == "left friction slips"]
    assert bool(slipped) == slips
    if slips:
        assert begin < slipped[0] < free
    else:
        assert run["z"][-1] - run["z"][0] == pytest.approx(rise, abs=1e-9)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_corners_that_strike_almost_at_once_stay_between_the_walls(rtol: float) -> None:
    """At loose tolerances one is a little behind its wall when the other strikes, and seen all the same."""
    module = module_of("clearance")
    run = sb.simulate(sb.form_equations(module.model()), 0.2, rtol=rtol)
    assert run.success
    assert min(run[f"gap {name}"].min() for name in module.CORNERS) > -0.01 * module.PLAY


@pytest.mark.exhaustive
def test_a_tippe_top_ends_upside_down_with_the_spin_that_jellett_says() -> None:
    module = module_of("tippe_top")
    run = sb.simulate(sb.form_equations(module.model()), 20.0, rtol=1e-8)
    assert np.degrees(module.lean(run)[-1]) > 178
    ends = -module.SPIN * (np.cos(module.LEAN) - module.OFF) / (1 + module.OFF)
    assert run["flight_wz"][-1] == pytest.approx(ends, rel=1e-3)  # smooth friction leaves some nutation
    module.MU = 0.0
    smooth = sb.simulate(sb.form_equations(module.model()), 3.0, rtol=1e-8)
    assert module.lean(smooth).max() < module.LEAN + 1e-6
    assert smooth["flight_wz"][-1] == pytest.approx(module.SPIN, rel=1e-6)


@pytest.mark.exhaustive
def test_a_slider_with_clearance_flies_as_by_hand_and_loses_energy_at_impacts() -> None:
    """The first flight by the equations of the three angles; later no gap is negative, no impact adds energy."""
    module, run = module_of("clearance"), motion_of("clearance")
    m2, m3 = module.MASSES[1:]

    def rates(_: float, values: Any) -> Any:
        angles, w = values[:3], values[3:]
        inertia = module.matrices(angles)[0]
        coupled = (m2 / 2 + m3) * module.CRANK * module.ROD * np.sin(angles[0] - angles[1])
        weights = np.array([module.MASSES[0] / 2 + m2 + m3, m2 / 2 + m3, 0]) * module.G
        pull = -weights * [module.CRANK, module.ROD, 0] * np.cos(angles)
        return [*w, *np.linalg.solve(inertia, pull + coupled * np.array([-(w[1] ** 2), w[0] ** 2, 0]))]

    def strikes(_: float, values: Any) -> float:
        return float(module.matrices(values[:3])[1].min())

    strikes.terminal = True  # type: ignore[attr-defined]
    first = [0, 0, module.TILT, *module.SPEEDS, 0]
    flight: Any = solve_ivp(rates, (0, 0.01), first, method="DOP853", rtol=1e-12, atol=1e-14, events=strikes)
    assert run.events[0].t == pytest.approx(flight.t[-1], abs=1e-10)
    before = run.at(run.events[0].t - 1e-9)
    by_hand = flight.y[3:, -1]
    assert before["phi_dot"] == pytest.approx(by_hand[0], rel=1e-6)
    assert before["phi_dot"] + before["rod_dot"] == pytest.approx(by_hand[1], rel=1e-6)
    for corner in module.CORNERS:
        assert run[f"gap {corner}"].min() > -1e-9
    energy = run["energy"]
    assert np.diff(energy).max() < 1e-8 * energy[0] and energy[-1] < 0.95 * energy[0]
