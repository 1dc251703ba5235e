"""Equations of index 1: one linear system for rates and reactions, integrated by SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from tests.analysis.test_assembly import slider_crank

T = dynamicsymbols._t
x, y, lam, F = dynamicsymbols("x y lam F")
m, g, L = sp.symbols("m g L")
PHI = x**2 + y**2 - L**2
MOTION = [m * x.diff(T, 2) + 2 * lam * x, m * y.diff(T, 2) + 2 * lam * y + m * g]
SECOND = [x.diff(T, 2), y.diff(T, 2)]
DATA = {m: 2.0, g: 9.81}


def pendulum_angle(t: float) -> float:
    """The angle from the vertical of a pendulum of length 1 let go at 1 rad, integrated in the angle itself."""
    run = solve_ivp(lambda t, s: [s[1], -9.81 * math.sin(s[0])], (0, t), [1.0, 0.0], rtol=1e-11, atol=1e-12)
    return float(run.y[0, -1])


def test_pendulum_integrated_from_the_linear_system() -> None:
    f = sb.solve_index_1([*MOTION, PHI.diff(T, 2)], SECOND, [lam], parameters=DATA)
    assert f.state_names == ("x_dot", "y_dot", "x", "y") and f.reaction_names == ("lam",)
    start = [0.0, 0.0, math.sin(1.0), -math.cos(1.0)]
    run = solve_ivp(f, (0, 2), start, rtol=1e-10, atol=1e-12)
    angle = pendulum_angle(2.0)
    assert run.y[2:, -1] == pytest.approx([math.sin(angle), -math.cos(angle)], abs=1e-7)
    # 2 lam L^2 = m (v^2 - g y) at every sample, up to the drift of the constraints.
    v2 = run.y[0] ** 2 + run.y[1] ** 2
    assert f.reactions(run.t, run.y)[0] == pytest.approx(v2 - 9.81 * run.y[3], abs=1e-6)
    assert f.reactions(0.0, start).shape == (1,)


def test_first_order_equations_as_the_notes_have_them() -> None:
    vx, vy = dynamicsymbols("vx vy")
    dae = [m * vx.diff(T) + 2 * lam * x, m * vy.diff(T) + 2 * lam * y + m * g, x.diff(T) - vx, y.diff(T) - vy,
           x * vx.diff(T) + y * vy.diff(T) + vx**2 + vy**2]  # fmt: skip
    f = sb.solve_index_1(dae, [s.diff(T) for s in (x, y, vx, vy)], [lam], parameters={"m": 2, "g": 9.81})
    assert f(0.0, [0.6, -0.8, 4.0, 3.0]) == pytest.approx([4, 3, -f.reactions(0, [0.6, -0.8, 4, 3])[0] * 0.6, 
                                                          f.reactions(0, [0.6, -0.8, 4, 3])[0] * 0.8 - 9.81])  # fmt: skip
    assert f.reactions(0, [0.6, -0.8, 4, 3]) == pytest.approx([25 + 9.81 * 0.8])


def test_baumgarte_terms_pull_an_open_constraint_shut() -> None:
    zeta, omega = 0.95, 20.0
    pulled = PHI.diff(T, 2) + 2 * zeta * omega * PHI.diff(T) + omega**2 * PHI
    f = sb.solve_index_1([*MOTION, pulled], SECOND, [lam], parameters=DATA | {L: 1.0})
    run = solve_ivp(
        f, (0, 2), [0.0, 0.0, 1.05 * math.sin(1.0), -1.05 * math.cos(1.0)], rtol=1e-10, atol=1e-12
    )
    # Phi'' + 2 zeta omega Phi' + omega^2 Phi = 0 exactly, from Phi = 0.1025 at rest: underdamped.
    decay, frequency = zeta * omega, omega * math.sqrt(1 - zeta**2)
    at = run.t < 0.5
    wanted = (
        0.1025
        * np.exp(-decay * run.t)
        * (np.cos(frequency * run.t) + decay / frequency * np.sin(frequency * run.t))
    )
    found = run.y[2] ** 2 + run.y[3] ** 2 - 1.0
    assert at.sum() > 5 and found == pytest.approx(wanted, abs=1e-7)


def test_a_mechanism_has_the_rates_of_its_own_xdot_and_reactions() -> None:
    eqs = sb.form_equations(slider_crank())
    f = sb.solve_index_1(eqs)
    state = sb.assemble(eqs, {"theta": 0.7, "theta_dot": 2.0})
    start = [*state.u.values(), *state.q.values()]
    assert f(0.0, start) == pytest.approx([*state.udot.values(), *state.u.values()], rel=1e-12)
    run = solve_ivp(f, (0, 1), start, rtol=1e-9, atol=1e-10)
    wanted = sb.simulate(eqs, 1.0, {"theta": 0.7, "theta_dot": 2.0}, rtol=1e-10, atol=1e-12)
    assert run.y[:3, -1] == pytest.approx(wanted.u[:, -1], abs=1e-6)
    assert f.reactions(run.t, run.y).shape == (2, run.t.size)
    assert f.reactions(0.0, start) == pytest.approx(list(state.multipliers.values()), rel=1e-9)


def test_alpha_and_beta_are_zeta_omega_and_omega() -> None:
    a, b = sb.Baumgarte(alpha=19.0, beta=20.0), sb.Baumgarte()
    assert (a.zeta, a.omega) == (0.95, 20.0) == (b.zeta, b.omega) and a == b
    assert (b.alpha, b.beta) == (19.0, 20.0)
    eqs = sb.form_equations(slider_crank())
    off = [0.0, 1.0, 0.0, 0.7, -0.2, 3.7]
    found = [
        sb.solve_index_1(method.applied(eqs))(0.0, off) for method in (a, b, sb.Baumgarte(alpha=5, beta=3))
    ]
    assert (found[0] == found[1]).all() and np.abs(found[2] - found[1]).max() > 1e-3
    for wrong in ({"alpha": 1.0}, {"beta": 1.0}, {"alpha": 1.0, "beta": 1.0, "omega": 20.0}):
        with pytest.raises(sb.UsageError) as caught:
            sb.Baumgarte(**wrong)
        assert caught.value.problems[0].code == "simulation.baumgarte"
    with pytest.raises(sb.UsageError):
        sb.Baumgarte(alpha=-1.0, beta=2.0)


REFUSED = {
    "index_1.number": (MOTION, [lam], DATA),
    "index_1.open": ([*MOTION, PHI], [lam, F], DATA),
    "index_1.unknowns": ([MOTION[0] - F, MOTION[1], PHI.diff(T, 2)], [lam], DATA),
    "compile.missing_value": ([*MOTION, PHI.diff(T, 2)], [lam], {m: 1}),
    "compile.unknown_parameter": ([*MOTION, PHI.diff(T, 2)], [lam], DATA | {"M": 1}),
    "index_1.parameter": ([*MOTION, PHI.diff(T, 2)], [lam], {m: "two", g: 1}),
    "reduction.not_linear": ([MOTION[0] + lam**2, MOTION[1], PHI.diff(T, 2)], [lam], DATA),
}


@pytest.mark.parametrize("code", REFUSED)
def test_refusals_name_cause_and_cure(code: str) -> None:
    equations, reactions, data = REFUSED[code]
    if code == "index_1.open":
        equations = [*equations, x.diff(T, 2)]
    with pytest.raises(sb.SymbodyError) as caught:
        sb.solve_index_1(equations, SECOND, reactions, parameters=data)
    assert caught.value.problems[0].code == code and caught.value.problems[0].fix


def test_a_singular_mass_is_named_in_the_call() -> None:
    f = sb.solve_index_1([*MOTION, PHI.diff(T, 2)], SECOND, [lam], parameters={m: 0, g: 9.81})
    with pytest.raises(sb.SimulationError) as caught:
        f(0.0, [0.0, 0.0, 1.0, 0.0])
    assert caught.value.problems[0].code == "index_1.singular" and "y_ddot" in caught.value.problems[0].what


def test_a_state_of_the_wrong_length_is_refused_with_the_order() -> None:
    f = sb.solve_index_1([*MOTION, PHI.diff(T, 2)], SECOND, [lam], parameters=DATA)
    with pytest.raises(sb.CompileError, match="x_dot, y_dot, x, y"):
        f(0.0, [0.0, 1.0])
