"""Every pair of shapes: one contact in all formulations, either way round, with its derivatives and energy."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import symbody as sb
from tests.contacts.pairs import FRICTION, LAW, NAMES, ORDERED, Floats, pose, scene
from tests.formulations import FORMULATIONS
from tests.tiers import cases, rows

# In the fast tier each pair stands in one of the three tests at least.
FORMED, DERIVED = ORDERED[::5], ORDERED[1::5]
MOVED = [(words, -0.02) for words in ORDERED if words not in FORMED + DERIVED] + [
    (words, 0.05) for words in FORMED[:1]
]
OUTPUTS = ["udot", "gap touch", "contact_force touch", "slip touch", "power", "potential_energy"]


def values(model: sb.Model, formulation: sb.Recursive | None, q: Floats, u: Floats) -> Floats:
    eqs = sb.form_equations(model, formulation)
    return np.concatenate([np.ravel(x) for x in sb.compile(eqs, OUTPUTS, quick=True)(0.0, q, u)])


@pytest.mark.parametrize("words", cases(ORDERED, fast=FORMED), ids=NAMES)
def test_all_formulations_and_both_orders_agree(words: tuple[str, str]) -> None:
    """Lagrange takes the force from the potential, the others from gap, normal and point: these fit each other."""
    model = scene(words)
    q, u = pose(words, 3, -0.01)
    expected = values(model, None, q, u)
    assert expected[12] == pytest.approx(-0.01, abs=1e-13) and expected[15] > 0
    for each in FORMULATIONS:
        found = values(model, each, q, u)  # type: ignore[arg-type]
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())
    other = values(scene(words, turned=True), None, q, u)
    np.testing.assert_allclose(other[:13], expected[:13], rtol=1e-9, atol=1e-10 * np.abs(expected).max())
    assert other[15] == pytest.approx(expected[15])  # the normal turns, and so does the end
    assert np.hypot(*other[13:15]) == pytest.approx(np.hypot(*expected[13:15]))


@pytest.mark.parametrize("words", cases(ORDERED, fast=DERIVED), ids=NAMES)
def test_derivatives_are_those_of_differences(words: tuple[str, str]) -> None:
    model = scene(words)
    q, u = pose(words, 4, -0.02)
    eqs = sb.form_equations(model)
    function = sb.compile(
        eqs, ["udot", "d udot/d q", "d udot/d u", "gap touch", "d gap touch/d q"], quick=True
    )
    _, by_q, by_u, _, gap_by_q = function(0.0, q, u)
    for k, step in enumerate(np.eye(12) * 1e-6):
        ahead, back = function(0.0, q + step, u), function(0.0, q - step, u)
        scale = np.abs(by_q).max()
        np.testing.assert_allclose(by_q[:, k], (ahead[0] - back[0]) / 2e-6, atol=2e-7 * scale)
        np.testing.assert_allclose(gap_by_q[k], (ahead[3] - back[3]) / 2e-6, atol=1e-8)
        ahead, back = function(0.0, q, u + step), function(0.0, q, u - step)
        np.testing.assert_allclose(by_u[:, k], (ahead[0] - back[0]) / 2e-6, atol=2e-7 * np.abs(by_u).max())


@pytest.mark.parametrize(("words", "gap"), rows(product(ORDERED, (0.05, -0.02)), fast=MOVED), ids=str)
def test_the_rate_of_the_gap_is_the_velocity_along_the_normal(words: tuple[str, str], gap: float) -> None:
    """The frame of the contact moves with it: z is the normal, and the force pushes along it alone."""
    model = scene(words, friction=None)
    q, u = pose(words, 5, gap)
    eqs = sb.form_equations(model)
    function = sb.compile(eqs, ["qdot", "gap touch", "frame r touch", "frame R touch", "frame v touch",
                                "frame w touch", "contact_force touch", "power"], quick=True)  # fmt: skip
    qdot, now, r, R, v, w, force, power = function(0.0, q, u)
    step = 1e-6
    ahead, back = function(0.0, q + step * qdot, u), function(0.0, q - step * qdot, u)
    gap_rate = (ahead[1] - back[1]) / (2 * step)
    np.testing.assert_allclose(v, (ahead[2] - back[2]) / (2 * step), atol=1e-7)
    spin = (ahead[3] - back[3]) / (2 * step) @ R.T
    np.testing.assert_allclose(w, [spin[2, 1], spin[0, 2], spin[1, 0]], atol=1e-7)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-13)
    if gap > 0:
        assert not force.any() and power == 0
    else:
        spring = 2e3 * (-now) ** 1.5
        assert force[2] == pytest.approx(spring * max(0, 1 - 0.2 * gap_rate), rel=1e-6)
        assert power == pytest.approx((force[2] - spring) * gap_rate, rel=1e-5) and power <= 0


def test_friction_opposes_the_slip() -> None:
    words = ("plane", "sphere")
    model = scene(words, LAW, FRICTION)
    q, u = pose(words, 6, -0.01)
    slip, force = sb.compile(sb.form_equations(model), ["slip touch", "contact_force touch"], quick=True)(
        0.0, q, u
    )
    speed = np.hypot(*slip)
    np.testing.assert_allclose(force[:2], -0.4 * force[2] * slip / np.hypot(speed, 0.05), rtol=1e-13)
