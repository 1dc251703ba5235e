"""What a built model exports, against each other and against the equations they come from."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs, ModelEquations
from tests.problems.mechanisms import EPS, EXAMPLES, condition, numbers_of, random_values, state_of

T = dynamicsymbols._t
NAMES = ("spring_mass_damper", "projectile", "rr_robot", "spinning_top_omega", "slider_crank")


@pytest.fixture(scope="module", params=NAMES)
def built(request: pytest.FixtureRequest) -> ModelEquations:
    return BuildEQs(EXAMPLES / request.param / f"{request.param}.toml")


def numeric(model: ModelEquations, matrix: sp.Matrix, values: dict[str, float]) -> sp.Matrix:
    eqs = model.equations
    numbers = {sp.Symbol(name): value for name, value in numbers_of(eqs.model).items()}
    for group, names in ((eqs.speeds, eqs.speed_names), (eqs.coordinates, eqs.coordinate_names), (eqs.inputs, eqs.input_names)):  # fmt: skip
        matrix = matrix.xreplace({symbol: values[name] for symbol, name in zip(group, names, strict=True)})
    return matrix.xreplace(numbers)


def test_states_are_speeds_then_coordinates(built: ModelEquations) -> None:
    assert list(built.vX) == [*built.vP, *built.vQ]
    assert list(built.vXdot) == [*built.vPdot, *built.vQdot]
    assert built.vXdot == built.vX.diff(T)
    assert built.vX.cols == 1


def test_dynamic_equations_are_mass_matrix_times_accelerations(built: ModelEquations) -> None:
    right = built.vF
    if built.vLambda.rows:
        right = right + built.xJacVel.T * built.vLambda
    left = built.xM * built.vPdot
    for k, equation in enumerate(built.GetDynEQs()):
        assert isinstance(equation, sp.Eq)
        assert sp.expand(left[k] - equation.lhs) == 0
        assert sp.expand(right[k] - equation.rhs) == 0


def test_rates_of_the_coordinates(built: ModelEquations) -> None:
    rates = built.GetKinTrans()
    assert [rate.lhs for rate in rates] == list(built.vQdot)
    assert [rate.rhs for rate in rates] == list(built.vKinTransRHS)


def test_constraints_and_their_derivatives(built: ModelEquations) -> None:
    """xJacPos, xJacVel, vVelRHS, vAccRHS are what differentiation of Phi gives."""
    Phi = sp.Matrix([equation.lhs for equation in built.GetPosCons()])
    assert len(Phi) == len(built.GetVelCons()) == len(built.GetAccCons()) == built.vLambda.rows
    if not len(Phi):
        assert built.xJacPos.shape == (0, len(built.vQ)) and built.xJacVel.shape == (0, len(built.vP))
        assert built.vVelRHS.shape == built.vAccRHS.shape == (0, 1)
        return
    rng = np.random.default_rng(12)
    values = random_values(built.equations, rng)
    jacobian = numeric(built, Phi.jacobian(built.vQ), values)
    assert np.array(numeric(built, built.xJacPos, values) - jacobian, float) == pytest.approx(0, abs=1e-14)
    rate = numeric(built, Phi.diff(T).subs(dict(zip(built.vQdot, built.vKinTransRHS, strict=True))), values)
    told = sp.Matrix([equation.lhs for equation in built.GetVelCons()])
    assert np.array(numeric(built, told, values) - rate, float) == pytest.approx(0, abs=1e-14)
    assert built.xJacVel * built.vP - built.vVelRHS != sp.zeros(len(Phi), 1)
    residual = numeric(built, built.xJacVel * built.vP - built.vVelRHS, values)
    assert np.array(residual - rate, float) == pytest.approx(0, abs=1e-14)
    twice = sp.Matrix([equation.lhs - equation.rhs for equation in built.GetAccCons()])
    accelerations = dict(zip(built.vPdot, sp.symbols("a0:3"), strict=True))
    difference = numeric(built, (twice - told.diff(T)).subs(accelerations), values)
    # A constraint and its derivative: entries of order 1, a dozen operations each.
    assert np.array(difference.subs(dict.fromkeys(sp.symbols("a0:3"), 0.7)), float) == pytest.approx(
        0, abs=1e-13
    )


def test_the_system_has_an_equation_for_every_unknown(built: ModelEquations) -> None:
    ordinary, whole = built.GetSysODEs(), built.GetSysEQs()
    unknown = [*built.vPdot, *built.vLambda]
    unknown += [rate for rate in built.vQdot if rate not in list(built.vP)]
    assert len(whole) == len(unknown) and whole[: len(ordinary)] == ordinary
    values = random_values(built.equations, np.random.default_rng(13))
    system = sp.Matrix([equation.lhs - equation.rhs for equation in whole])
    names = sp.symbols(f"y0:{len(unknown)}")
    plain = numeric(built, system.subs(dict(zip(unknown, names, strict=True))), values)
    solution = sp.Matrix(plain).jacobian(names).LUsolve(-plain.subs(dict.fromkeys(names, 0)))
    state = state_of(built.equations, values)
    udot, multipliers = sb.compile(built.equations, ["udot", "lambda"])(0.0, state.q, state.u, state.r)
    expected = [*udot, *multipliers]
    found = np.array(solution, float).ravel()[: len(expected)]
    # Backward stable solutions of one system, by elimination and by the kernel.
    tolerance = 100 * EPS * condition(built.equations, state)
    assert found == pytest.approx(expected, rel=tolerance, abs=tolerance)


def test_frame_motion_with_substitutions() -> None:
    built = BuildEQs(EXAMPLES / "rr_robot" / "rr_robot.toml")
    b1, b2 = built.vQ
    still = built.GetFrameMotion("v", "P", "Ground", "Ground", {b2: 0})
    L3, L4, L5, L6 = sp.symbols("L3:7")
    assert sp.expand(still[0] + (L3 + L4 + L5 + L6) * sp.sin(b1) * b1.diff(T)) == 0
    assert built.GetFrameMotion("R", "Link2", subs=[sp.Eq(b1, 0), sp.Eq(b2, 0)]) == sp.eye(3)
    relative = built.GetFrameMotion("w", "Link2", "Link1", "Link2")
    assert relative == sp.Matrix([0, 0, b2.diff(T)])


def test_parameters_and_reactions() -> None:
    built = BuildEQs(EXAMPLES / "slider_crank" / "slider_crank.toml")
    assert [str(parameter) for parameter in built.GetParams()] == [
        "m1",
        "m2",
        "m3",
        "I1",
        "I2",
        "L1",
        "L2",
        "G",
    ]
    reaction = built.GetReaction("B")
    # On the rod by the crank, in the axes of the crank: the multipliers themselves.
    assert list(reaction.force) == [*built.vLambda, 0] and reaction.moment == sp.zeros(3, 1)
    opposite = built.GetReaction("B", on="Crank")
    assert opposite.force == -reaction.force
