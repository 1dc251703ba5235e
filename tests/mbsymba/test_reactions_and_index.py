"""Reactions from multipliers (4.3.1), and the index reduced in three steps (4.4.1)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from tests.mbsymba import slider_crank as sc
from tests.mbsymba.spots import t, values


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    yield
    mb.set_gravity(None)


def two_bodies() -> tuple[list[sp.Expr], list[sp.Expr], list[sp.Expr], list[sp.Expr]]:
    """Newton's equations, constraints, coordinates, reactions: a crank, a slider and a massless rod."""
    q = x1, y1, a1, x2, y2, a2 = list(dynamicsymbols("x1 y1 a1 x2 y2 a2"))
    L, D, m, J, g = sp.symbols("L D m J g")
    RF1, RF2 = (mb.translate(x, y, 0) * mb.rotate("Z", a) for x, y, a in ((x1, y1, a1), (x2, y2, a2)))
    one, two = mb.make_BODY(RF1, m, 0, 0, J), mb.make_BODY(RF2, m, 0, 0, J)
    foot, tip, pin = mb.make_POINT(RF1, -L, 0, 0), mb.make_POINT(RF1, L, 0, 0), mb.origin(RF2)
    rx, ry, n, tau, pull = reactions = list(dynamicsymbols("rx ry n tau pull"))
    along = mb.project(mb.join_points(tip, pin), mb.ground)
    forces = [
        mb.make_FORCE(mb.ground, rx, ry, 0, foot, one),
        mb.make_FORCE(mb.ground, 0, n, 0, pin, two),
        mb.make_TORQUE(mb.ground, 0, 0, tau, two),
        mb.make_FORCE(along * (pull / D), tip, one, None),
        mb.make_FORCE(-along * (pull / D), pin, two),
        mb.make_FORCE(mb.ground, 0, -m * g, 0, mb.origin(RF1), one),
        mb.make_FORCE(mb.ground, 0, -m * g, 0, pin, two),
    ]
    eqs = []
    for body in (one, two):
        neq, eeq = (mb.newton_equations([body, *forces]), mb.euler_equations([body, *forces], body))
        eqs += [mb.comp_X(neq), mb.comp_Y(neq), mb.comp_Z(eeq)]
    at = mb.project(mb.join_points(mb.origin(mb.ground), foot), mb.ground)
    Phi = [mb.comp_X(at), mb.comp_Y(at), y2, sp.sin(a2), mb.dot_prod(along, along) - D**2]
    return eqs, Phi, q, reactions


def test_the_index_is_reduced_in_three_steps() -> None:
    eqs, Phi, q, reactions = two_bodies()
    newvars, first = mb.first_order(eqs, q)
    complete, unknowns = first + Phi, newvars + reactions
    assert len(complete) == 17 == len(unknowns)
    rates = mb.diff(unknowns, t)
    dae1, alg1 = mb.LUMethod(complete, rates)
    dae2, alg2 = mb.LUMethod(dae1, rates)
    ode, alg3 = mb.LUMethod(dae2, rates)
    assert [len(alg1), len(alg2), len(alg3)] == [5, 5, 5] and len(ode) == 17
    # alg2 is Phi_q v: it vanishes for a velocity that the constraints allow, and not for another
    numbers = {sp.Symbol("L"): 0.5, sp.Symbol("D"): 1.3} | dict(
        zip(q, (0.4, 0.3, np.arctan2(3, 4), 0, 0, 0), strict=True)
    )
    numbers[q[3]] = 0.8 + np.sqrt(1.3**2 - 0.6**2)
    dots = newvars[6:]
    J = np.array([values([phi.diff(x) for x in q], numbers) for phi in Phi])
    v = np.linalg.svd(J)[2][-1]
    allowed = numbers | dict(zip(dots, v, strict=True))
    # 1e-12 is 1e3 roundings of products of numbers near 1
    assert np.abs(J @ v).max() < 1e-12 and np.abs(values(alg2, allowed)).max() < 1e-12
    other = numbers | dict(zip(dots, v + 0.1, strict=True))
    assert np.abs(values(alg2, other)).max() > 1e-3


def test_reactions_from_multipliers_by_virtual_displacements() -> None:
    """R = (J_Psi^T)^-1 Phi_q^T lambda: the power of the reactions, collected by them and by the rates."""
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -sc.g, 0))
    parts, Phi, q = sc.recursive()
    crank, rod, slider = parts
    Rx, Ry = dynamicsymbols("Rx Ry")
    R = mb.make_VECTOR(mb.ground, Rx, Ry, 0)
    # the constraint is written with the vector from the slider to the rod's end, but any length will do
    scaled = [2 * Phi[0] + Phi[1], 3 * Phi[1]]
    lambdas = list(dynamicsymbols("lambda1:3"))
    end = mb.make_POINT(rod.frame, sc.L2, 0, 0)
    power = mb.dot_prod(R, mb.velocity(end)) - mb.dot_prod(R, mb.velocity(mb.origin(slider.frame)))
    rates = mb.diff(q, t)
    by_rates = mb.GenerateMatrix([power], rates)[0].T  # one equation a coordinate, linear in R
    JPsiT = mb.GenerateMatrix(list(by_rates), [Rx, Ry])[0]
    PhiqT = sp.Matrix(scaled).jacobian(q).T
    eqs = mb.equation_set([*parts, mb.make_CONSTRAINT(scaled, lambdas)], q, parameters=sc.DATA)
    state = sb.assemble(eqs, fixed=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"])
    numbers: dict[object, float] = {sp.Symbol(name): x for name, x in sc.DATA.items()}
    numbers |= {x: state[x.func.__name__] for x in q}
    left, right = (np.array(values(M, numbers)).reshape(M.shape) for M in (JPsiT, PhiqT))
    found = np.linalg.lstsq(left, right @ [*state.multipliers.values()], rcond=None)[0]
    plain = mb.equation_set([*parts, mb.make_CONSTRAINT(Phi, lambdas)], q, parameters=sc.DATA)
    direct = sb.assemble(plain, fixed=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"]).multipliers
    assert found == pytest.approx([*direct.values()], rel=1e-9)


def test_weights_that_count_twice_are_warned_of() -> None:
    theta = dynamicsymbols("theta")
    m, g = sp.symbols("m g")
    body = mb.make_BODY(mb.make_POINT(mb.rotate("Z", theta), 1, 0, 0), m)
    weight = mb.make_FORCE(mb.ground, 0, -m * g, 0, mb.CoM(body), body)
    mb.newton_equations([body, weight])
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -g, 0))
    with pytest.warns(UserWarning, match="counts twice"):
        mb.lagrange_equations([body, weight], [theta])
    with pytest.warns(UserWarning, match="counts twice"):
        mb.newton_equations([body, weight])
    assert mb.newton_equations([body]) == (mb.acceleration(body) + mb.make_VECTOR(mb.ground, 0, g, 0)) * m
