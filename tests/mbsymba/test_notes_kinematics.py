"""Sections 2.3 to 3.3 of the notes: positions in closed form and by numbers, tau, singular configurations."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from tests.mbsymba.spots import POINTS, all_same, t, values

x10, y10, theta1, x20, y20, theta2 = Q = list(dynamicsymbols("x10 y10 theta1 x20 y20 theta2"))
L, L2, beta1 = sp.symbols("L L2 beta1")
DATA = {L: 1, L2: 4, beta1: sp.pi / 2}  # (3.1)


def constraints() -> list[sp.Expr]:
    """A crank on a pivot, a slider on a line inclined by beta1, a rod: revolute, prismatic, rod."""
    RF1, RF2 = (
        mb.translate(x, y, 0) * mb.rotate("Z", a) for x, y, a in ((x10, y10, theta1), (x20, y20, theta2))
    )
    pivot = mb.project(mb.join_points(mb.origin(mb.ground), mb.make_POINT(RF1, -L / 2, 0, 0)), mb.ground)
    RFa, RF2aux = mb.rotate("Z", beta1), RF2 * mb.rotate("Z", beta1)
    along = mb.project(mb.join_points(mb.make_POINT(RF1, L / 2, 0, 0), mb.origin(RF2)), mb.ground)
    return [
        *(mb.comp_X(pivot), mb.comp_Y(pivot)),
        mb.dot_prod(mb.uvec_Y(RFa), mb.uvec_X(RF2aux)),
        mb.dot_prod(mb.uvec_Y(RFa), mb.join_points(mb.origin(RFa), mb.origin(RF2aux))),
        mb.dot_prod(along, along) - L2**2,
    ]


def small() -> tuple[sb.EquationSet, list[sp.Expr], list[sp.Expr]]:
    """The same in the angle of the crank, that of the rod, and the height of the slider."""
    theta, phi, s = q = list(dynamicsymbols("theta phi s"))
    RF1 = mb.rotate("Z", theta)
    RF2 = mb.translate(L * sp.cos(theta), L * sp.sin(theta), 0) * mb.rotate("Z", phi)
    RF3 = mb.translate(0, s, 0)
    gap = mb.project(mb.join_points(mb.origin(RF3), mb.make_POINT(RF2, L2, 0, 0)), mb.ground)
    Phi = [mb.comp_X(gap), mb.comp_Y(gap)]
    bodies = [mb.make_BODY(RF, 1, 0, 0, 1) for RF in (RF1, RF2, RF3)]
    rows = mb.make_CONSTRAINT(Phi, dynamicsymbols("lambda1:3"))
    return mb.equation_set([*bodies, rows], q, parameters={"L": 1, "L2": 4}), Phi, q


def test_all_assemblies_and_the_one_that_is_meant() -> None:
    """N-25 to N-27: one freedom, four assemblies, one picked by numbers, and led on from it."""
    Phi = constraints()
    assert len(Phi) == 5 and len(Q) - len(Phi) == 1
    found = sb.solve_positions(Phi, [x10, y10, x20, y20, theta2])
    assert len(found) == 4
    random = Random(26)
    for _ in range(POINTS):
        # Off the inclination where the slider's line has no height over its foot.
        given = {"L": random.uniform(0.5, 1.5), "L2": random.uniform(3, 5), "beta1": random.uniform(0.4, 2.7)}
        given["theta1"] = random.uniform(-3, 3)
        tip = given["L"] * np.exp(1j * given["theta1"])
        turn = np.exp(1j * given["beta1"])
        across, ahead = (tip / turn).imag, (tip / turn).real
        for way in found.evaluate(given):
            assert way is not None
            place = complex(way["x20"], way["y20"]) / turn
            sign = 1 if place.real > ahead else -1
            # 1e-9: the closed form divides by sin(beta1) of 0.4 and more
            assert abs(place - (ahead + sign * np.sqrt(given["L2"] ** 2 - across**2))) < 1e-9
    above = found.nearest({y20: 4, theta2: 0}, {**DATA, theta1: 0.2})
    (height,) = values([above[y20]], {L: 1, L2: 4, beta1: np.pi / 2, theta1: 0.2})
    assert height == pytest.approx(np.sin(0.2) + np.sqrt(16 - np.cos(0.2) ** 2), abs=1e-12)


def test_a_table_by_continuation() -> None:
    """N-27: the slider led in ten steps of 0.03, each position the guess for the next."""
    eqs, _, _ = small()
    heights = 4.1 + 0.03 * np.arange(10)
    traced = sb.trace_positions(eqs, {"s": heights}, guess={"theta": 0.2, "phi": 1.8})
    assert traced.success and len(traced.columns()) >= 3
    # by hand from the triangle of pivot, slider and pin
    angle = np.arcsin((heights**2 + 1 - 16) / (2 * heights))
    assert traced["theta"] == pytest.approx(angle, abs=1e-9)


def test_initial_positions_from_guesses_and_in_ranges() -> None:
    """N-30."""
    eqs, _, _ = small()
    wanted = np.sin(0.2) + np.sqrt(16 - np.cos(0.2) ** 2)
    by_guess = sb.assemble(eqs, fixed={"theta": 0.2}, guess={"s": 4, "phi": 1.8})
    by_range = sb.assemble(eqs, fixed={"theta": 0.2}, ranges={"s": (0, 6)})
    below = sb.assemble(eqs, fixed={"theta": 0.2}, ranges={"s": (-6, 0)})
    assert [by_guess["s"], by_range["s"]] == pytest.approx([wanted, wanted], abs=1e-9)
    assert below["s"] == pytest.approx(2 * np.sin(0.2) - wanted, abs=1e-9)


def test_tau_is_what_solving_the_rates_gives() -> None:
    """N-31: -J_D^-1 J_I by GenerateMatrix, solve(d(Phi)/dt), and `velocity_ratios`, at 20 points."""
    eqs, Phi, (theta, phi, s) = small()
    J_D, _ = mb.GenerateMatrix(mb.diff(Phi, t), mb.diff([phi, s], t))
    J_I, _ = mb.GenerateMatrix(mb.diff(Phi, t), mb.diff([theta], t))
    tau = list(-J_D.inv() * J_I)
    rates = sp.solve(mb.diff(Phi, t), [phi.diff(t), s.diff(t)])
    solved = [rates[x.diff(t)] / theta.diff(t) for x in (phi, s)]
    ratios = sb.velocity_ratios(eqs, "theta")
    assert all_same(tau, [sp.simplify(each) for each in solved]) and all_same(tau, list(ratios.tau))
    random = Random(31)
    for _ in range(POINTS):
        angle = random.uniform(-3, 3)
        rod = np.arccos(-np.cos(angle) / 4)
        place = {theta: angle, phi: rod, s: np.sin(angle) + 4 * np.sin(rod), L: 1, L2: 4}
        numbers = ratios.at({"theta": angle, "phi": rod, "s": place[s]})[:, 0]
        assert numbers == pytest.approx(values(tau, place), abs=1e-9)


@pytest.mark.exhaustive
def test_singular_configurations_are_those_with_the_constraints() -> None:
    """N-32: det(J_D) = 0 alone says nothing; with the constraints it has a solution, or has none."""
    eqs, Phi, (theta, phi, s) = small()
    driving = sb.velocity_ratios(eqs, "theta").determinant  # vanishes where the rod lies flat: out of reach
    assert sp.simplify(driving.subs(phi, 0)) == 0
    assert not sb.singular_configurations(eqs, "theta", {"theta": (-3, 3)}, guess={"phi": 1.8, "s": 4})
    locked = sb.singular_configurations(eqs, "s", {"theta": (-3, 3)}, guess={"phi": 1.8, "s": 4})
    assert {one.kind for one in locked} == {"lock-up"} and len(locked) == 4  # whole turns do not count
    assert eqs.units["theta"] == eqs.units["phi"] == "rad" and "coordinate s cannot drive" in str(locked[0])
    assert {round(one.q["s"], 6) for one in locked} == {5, 3, -3, -5}  # crank and rod in line
    J = np.array([values([row.diff(x) for x in (theta, phi, s)], {theta: np.pi / 2, phi: np.pi / 2, s: 5, L: 1, L2: 4})
                  for row in Phi])  # fmt: skip
    assert np.linalg.matrix_rank(J, 1e-9) == 2 > np.linalg.matrix_rank(J[:, :2], 1e-9)  # rank Phi_q > Phi_qD
    crossing = sb.singular_configurations(
        eqs, "theta", {"theta": (-1, 1)}, guess={"phi": 2, "s": 1}, parameters={"L2": 1}
    )
    assert {one.kind for one in crossing} == {"bifurcation"} and len(crossing) == 1
    J = np.array([values([row.diff(x) for x in (theta, phi, s)], {theta: 0, phi: np.pi, s: 0, L: 1, L2: 1})
                  for row in Phi])  # fmt: skip
    assert np.linalg.matrix_rank(J, 1e-9) == 1 == np.linalg.matrix_rank(J[:, 1:], 1e-9)


def test_the_bracket_of_the_cam_is_refused() -> None:
    """N-97: ``uvec_Y(RFa, project(...))`` as printed, and as it is meant."""
    RFa, Pb = mb.rotate("Z", beta1), mb.translate(x10, y10, 0)
    between = mb.project(mb.join_points(mb.origin(RFa), mb.origin(Pb)), mb.ground)
    with pytest.raises(TypeError):
        mb.dot_prod(mb.uvec_Y(RFa, between))
    meant = mb.dot_prod(mb.uvec_Y(RFa), between)
    assert all_same([meant], [-x10 * sp.sin(beta1) + y10 * sp.cos(beta1)])
