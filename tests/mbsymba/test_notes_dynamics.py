"""Sections 4.4 to 4.9 of the notes: initial conditions, Baumgarte, virtual work, equilibrium, inverse."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import numpy as np
import pytest
import scipy.integrate
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from tests.mbsymba import slider_crank as sc
from tests.mbsymba.spots import POINTS, all_same, same, t, values


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -sc.g, 0))
    yield
    mb.set_gravity(None)


def equations(way: str) -> sb.EquationSet:
    objects, q = sc.objects_of(sc.MECHANISMS[way]())
    return mb.equation_set(objects, q, parameters=sc.DATA)


def test_initial_conditions_the_special_way() -> None:
    """N-49: [[M, Phi_q^T], [Phi_q, 0]] at 20 states is what the code computes."""
    objects, q = sc.objects_of(sc.recursive())
    lambdas = list(dynamicsymbols("lambda1:3"))
    lgr_eq = mb.lagrange_equations(objects, [*q, *lambdas], t)
    Phi = objects[-1].exprs
    acc = mb.diff(q, t, t)
    aa, bb = mb.GenerateMatrix(lgr_eq[:3] + mb.diff(Phi, t, t), acc + lambdas)
    Phi_q, _ = mb.GenerateMatrix(mb.diff(Phi, t), mb.diff(q, t))
    assert all_same(aa[:3, 3:], -Phi_q.T) and all_same(aa[3:, :3], Phi_q) and all_same(aa[3:, 3:], [0] * 4)
    f, random = sb.compile(equations("recursive"), ("udot", "lambda")), Random(49)
    for _ in range(POINTS):
        theta, rate = random.uniform(-3, 3), random.uniform(-2, 2)
        lean, L1, L2 = np.arcsin(sc.DATA["L1"] / sc.DATA["L2"] * np.sin(theta)), sc.DATA["L1"], sc.DATA["L2"]
        turning = L1 * np.cos(theta) / (L2 * np.cos(lean)) * rate
        place = [theta, -lean - theta, L1 * np.cos(theta) + L2 * np.cos(lean)]
        speed = [rate, -turning - rate, -L1 * np.sin(theta) * rate - L2 * np.sin(lean) * turning]
        numbers: dict[object, float] = {sp.Symbol(name): value for name, value in sc.DATA.items()}
        numbers |= dict(zip(q, place, strict=True)) | dict(zip(mb.diff(q, t), speed, strict=True))
        matrix, right = (np.reshape(values(part, numbers), part.shape) for part in (aa, bb))
        found = np.linalg.solve(matrix, right)[:, 0]
        assert found == pytest.approx(np.hstack(f(0.0, place, speed)), rel=1e-8, abs=1e-9)


def test_baumgarte_by_hand_and_by_name() -> None:
    """N-51, N-52, N-94: Phi'' + 2 zeta omega Phi' + omega^2 Phi, solved for accelerations and reactions."""
    assert (sb.Baumgarte().zeta, sb.Baumgarte().omega) == (0.95, 20)
    objects, q = sc.objects_of(sc.recursive())
    lambdas = list(dynamicsymbols("lambda1:3"))
    lgr_eq = mb.lagrange_equations(objects, [*q, *lambdas], t)
    Phi = lgr_eq[3:]
    zeta, omega = sp.Rational(95, 100), 20
    rows = zip(mb.diff(Phi, t, t), mb.diff(Phi, t), Phi, strict=True)
    Phi_Baum = [a + 2 * zeta * omega * b + omega**2 * c for a, b, c in rows]
    newvars, dae = mb.first_order(lgr_eq[:3] + Phi_Baum, q)
    data = {name: value for name, value in sc.DATA.items()}
    by_hand = sb.solve_index_1(dae, mb.diff(newvars, t), lambdas, parameters=data)
    by_name = sb.solve_index_1(sb.Baumgarte(zeta=0.95, omega=20).applied(equations("recursive")))
    random = Random(51)
    for _ in range(POINTS):  # at states that leave the constraints open, too
        state = {name: random.uniform(-1, 1) for name in by_hand.state_names} | {
            "s": random.uniform(0.9, 1.3)
        }
        x, y = (np.array([state[name] for name in one.state_names]) for one in (by_hand, by_name))
        rates, again = by_hand(0.0, x), by_name(0.0, y)
        order = [by_hand.state_names.index(name) for name in by_name.state_names]
        assert rates[order] == pytest.approx(again, rel=1e-8, abs=1e-8)
        assert by_hand.reactions(0.0, x) == pytest.approx(by_name.reactions(0.0, y), rel=1e-8, abs=1e-8)
    # What is open closes as fast as omega says, whatever the slips of the notes, zeta omega_n without 2.
    start = sb.assemble(equations("recursive"), sc.INITIAL["recursive"], sc.GUESS["recursive"])
    x0 = np.array([start[name] for name in by_name.state_names]) + 1e-3
    run = scipy.integrate.solve_ivp(by_name, (0, 1), x0, rtol=1e-9, atol=1e-12)
    phi = sb.compile(equations("recursive"), "constraints")
    before, after = (np.abs(phi.of_state(0.0, x)).max() for x in (x0, run.y[:, -1]))
    assert after < 1e-6 * before  # exp(-0.95*20) is 6e-9


def test_virtual_work_holds() -> None:
    """N-53: sum of force times velocity, with the velocity ratios put in, solved for the holding force."""
    crank, rod, slider = sc.recursive()[0]
    _, Phi, (theta, beta, s) = sc.recursive()
    fe = dynamicsymbols("fe")
    weights = [(body, mb.make_VECTOR(mb.ground, 0, -m * sc.g, 0))
               for body, m in ((crank, sc.m1), (rod, sc.m2), (slider, sc.m3))]  # fmt: skip
    VW = sum(mb.dot_prod(mb.velocity(body), w) for body, w in weights)
    VW += mb.dot_prod(mb.velocity(slider), mb.make_VECTOR(mb.ground, -fe, 0, 0))
    rates = sp.solve(mb.diff(Phi, t), [beta.diff(t), s.diff(t)])
    (force,) = sp.solve(VW.subs(rates), fe)
    assert not force.has(theta.diff(t)) or sp.simplify(force.diff(theta.diff(t))) == 0
    push = mb.make_FORCE(mb.ground, -fe, 0, 0, mb.origin(mb.translate(s, 0, 0)), slider)
    objects = [crank, rod, slider, push, mb.make_CONSTRAINT(Phi, dynamicsymbols("lambda1:3"))]
    eqs = mb.equation_set(objects, [theta, beta, s], parameters=sc.DATA)
    holding = sb.velocity_ratios(eqs, "theta").holding("fe")
    random = Random(53)
    for _ in range(POINTS):
        angle = random.uniform(0.2, 1.5)
        lean = np.arcsin(sc.DATA["L1"] / sc.DATA["L2"] * np.sin(angle))
        place = sc.DATA["L1"] * np.cos(angle) + sc.DATA["L2"] * np.cos(lean)
        numbers: dict[object, float] = {sp.Symbol(name): value for name, value in sc.DATA.items()}
        numbers |= {theta: angle, beta: -lean - angle, s: place, theta.diff(t): 1.0}
        by_hand = 9.81 * np.cos(angle) * (0.7 + 1.3) / 2 / (np.sin(angle) + np.cos(angle) * np.tan(lean))
        assert values([force, holding], numbers) == pytest.approx([by_hand, by_hand], rel=1e-9)


def test_equilibrium_in_two_ways() -> None:
    """N-54: rates and accelerations 0 in the equations of motion; the crank hangs, or stands."""
    objects, q = sc.objects_of(sc.recursive())
    lambdas = list(dynamicsymbols("lambda1:3"))
    dae = mb.lagrange_equations(objects, [*q, *lambdas], t)
    still = {x.diff(t, 2): 0 for x in q} | {x.diff(t): 0 for x in q}
    numbers = {sp.Symbol(name): value for name, value in sc.DATA.items()}
    equilibrium_eq = [row.subs(still).subs(numbers) for row in dae]
    eqs, guess = equations("recursive"), {"beta": 1.8, "s": 1.0}
    for angle, verdict in ((-np.pi / 2, "marginal"), (np.pi / 2, "unstable")):
        rest = sb.find_equilibrium(eqs, guess={"theta": angle * 1.05, **guess, "beta": -np.sign(angle) * 1.8})
        start = [rest[x.name] + 0.01 for x in q] + [rest.multipliers[x.name] + 0.1 for x in lambdas]
        found = [float(x) for x in sp.nsolve(equilibrium_eq, [*q, *lambdas], start)]
        assert rest["theta"] == pytest.approx(angle, abs=1e-8) and rest.verdict == verdict
        assert found == pytest.approx([*rest.q.values(), *rest.multipliers.values()], abs=1e-7)


def test_inverse_dynamics_from_the_equations_of_motion_alone() -> None:
    """N-56: as many unknowns, multipliers and a torque, as equations of motion; at 20 times."""
    parts, Phi, q = sc.recursive()
    theta, beta, s = q
    Tm, *lambdas = dynamicsymbols("Tm lambda1 lambda2")
    objects = [*parts, mb.make_TORQUE(mb.ground, 0, 0, Tm, parts[0]), mb.make_CONSTRAINT(Phi, lambdas)]
    lgr_eq = mb.lagrange_equations(objects, [*q, *lambdas], t)
    A, b = mb.GenerateMatrix(lgr_eq[:3], [*lambdas, Tm])
    numbers = {sp.Symbol(name): value for name, value in sc.DATA.items()}
    lean = sp.asin(sc.L1 / sc.L2 * sp.sin(sp.pi * t**2))
    law = {
        theta: sp.pi * t**2,
        beta: -lean - sp.pi * t**2,
        s: sc.L1 * sp.cos(sp.pi * t**2) + sc.L2 * sp.cos(lean),
    }
    known = [(x.diff(t, k), value.subs(numbers).diff(t, k)) for k in (2, 1, 0) for x, value in law.items()]
    entries = sp.lambdify(t, [part.subs(numbers).subs(known) for part in (A, b)], cse=True)
    times = np.linspace(0, 1, POINTS)
    wanted = np.array([np.linalg.solve(*entries(time))[:, 0] for time in times]).T
    eqs = mb.equation_set(objects, q, parameters=sc.DATA)
    need = sb.inverse_dynamics(eqs, {"theta": "pi*t^2"}, "Tm", times, guess={"beta": 0, "s": 1.4})
    found = np.array([need[name] for name in ("lambda1", "lambda2", "Tm")])
    assert np.abs(found - wanted).max() < 1e-8 * np.abs(wanted).max()


def test_friction_of_the_notes() -> None:
    """N-55, N-93: the smoothed sign, with the square of v0 under the root that (4.8.1) lacks."""
    s, N, Fe = dynamicsymbols("s N Fe")
    mu_c, mu_s, v0, x0, x = sp.symbols("mu_c mu_s v0 x0 x")
    v = s.diff(t)
    body = mb.make_BODY(mb.translate(s, 0, 0), 1, 0, 0, 1)
    law = -mu_c * sp.Abs(N) * sp.sin(sp.atan(v / v0))
    force = mb.comp_X(mb.make_FORCE(mb.ground, law, 0, 0, mb.CoM(body), body))
    right = -mu_c * sp.Abs(N) * v / (v0 * sp.sqrt(1 + v**2 / v0**2))
    printed = -mu_c * sp.Abs(N) * v / (v0 * sp.sqrt(1 + v**2))
    assert same(force, right) and not same(force, printed)
    static = -mu_s * sp.Abs(N) * sp.sin(sp.atan(Fe / x0))
    assert same(static, -mu_s * sp.Abs(N) * Fe / (x0 * sp.sqrt(1 + Fe**2 / x0**2)))
    smooth = sp.sin(sp.atan(x / 0.01))
    spots = [float(smooth.subs(x, at)) for at in (0.01, 0.1, 1)]
    assert spots == pytest.approx([0.70710678, 0.99503719, 0.99995], abs=5.1e-6)
