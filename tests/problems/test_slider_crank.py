"""Slider-crank: checklist D-60 .. D-63; the loop cut at every joint, in every kind of tree."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs
from symbody.formats.native import from_data
from symbody.graph.trees import TreeChoice, Trees
from tests.problems.mechanisms import (
    EPS,
    EXAMPLES,
    absolute_values,
    compiled,
    condition,
    data_of,
    equations_of,
    motions,
    numbers_of,
    random_values,
    state_of,
)
from tests.tiers import cases

T = dynamicsymbols._t
theta, beta, s, F, lambda_x, lambda_y = dynamicsymbols("theta beta s F lambda_B_1 lambda_B_2")
m1, m2, m3, I1, I2, L1, L2, G = sp.symbols("m1 m2 m3 I1 I2 L1 L2 G")

TREES: dict[str, TreeChoice] = {
    "cut at A": Trees("BCD", "BCD"),
    "cut at B": Trees("ACD", "ACD"),
    "cut at C": Trees("ABD", "ABD"),
    "cut at D": Trees("ABC", "ABC"),
    "joints": "joints",
    "absolute": "absolute",
    "rotation at A B D, translation at A C D": Trees("ABD", "ACD"),
    "rotation at B C D, translation at A B C": Trees("BCD", "ABC"),
    "rotation absolute, translation at A C D": Trees((), "ACD"),
}


@cache
def named() -> sb.Model:
    """The example with a name for the angle of B too."""
    data = data_of("slider_crank")
    data["joint"][1]["coordinate"] = "phi"
    data.pop("initial")
    return from_data(data)


@cache
def named_equations() -> sb.EquationSet:
    return sb.form_equations(named(), tree=TREES["cut at B"])


def test_three_dynamic_equations_and_two_constraints() -> None:
    built = BuildEQs(EXAMPLES / "slider_crank" / "slider_crank.toml")
    assert list(built.vQ) == [theta, beta, s]
    assert len(built.GetDynEQs()) == 3 and len(built.GetPosCons()) == 2
    assert list(built.vLambda) == [lambda_x, lambda_y]
    assert built.equations.degrees_of_freedom == 1
    assert [note for note in built.notes if note.startswith("joint B is cut")]


def test_closed_forms() -> None:
    eqs = equations_of("slider_crank")
    share = m2 * L2 * sp.sin(beta) / 2
    assert eqs.mass_matrix == sp.Matrix(
        [[I1 + m1 * L1**2 / 4, 0, 0], [0, I2 + m2 * L2**2 / 4, share], [0, share, m2 + m3]]
    )
    weight = [-m1 * G * L1 * sp.cos(theta) / 2, m2 * G * L2 * sp.cos(beta) / 2]
    assert eqs.forcing == sp.Matrix([*weight, F - m2 * L2 * sp.cos(beta) * beta.diff(T) ** 2 / 2])
    # Where the rod's end B stands from the crank's end B, in the axes of the crank.
    assert eqs.constraints == sp.Matrix(
        [
            s * sp.cos(theta) - L1 - L2 * sp.cos(beta - theta),
            -s * sp.sin(theta) - L2 * sp.sin(beta - theta),
        ]
    )
    assert sp.expand(eqs.position_jacobian - eqs.constraints.jacobian([theta, beta, s])) == sp.zeros(2, 3)
    rates = {angle.diff(T): angle.diff(T) for angle in (theta, beta, s)}
    assert sp.expand(eqs.velocity_constraints - eqs.constraints.diff(T).subs(rates)) == sp.zeros(2, 1)


def test_constraint_forces_stand_in_the_equations() -> None:
    eqs = equations_of("slider_crank")
    forces = eqs.constraint_jacobian.T * sp.Matrix([lambda_x, lambda_y])
    inertial = eqs.mass_matrix * sp.Matrix([theta, beta, s]).diff(T, 2)
    for k, equation in enumerate(eqs.dynamic_equations()):
        assert sp.expand(equation.lhs - inertial[k]) == 0
        assert sp.expand(equation.rhs - eqs.forcing[k] - forces[k]) == 0


def test_acceleration_of_the_one_freedom() -> None:
    """theta'' by Lagrange with beta and s eliminated by hand, at 20 states."""
    angle, rate = sp.symbols("angle rate")
    lean = sp.asin(-L1 * sp.sin(angle) / L2)
    travel = L1 * sp.cos(angle) + L2 * sp.cos(lean)
    crank = sp.Matrix([L1 * sp.cos(angle), L1 * sp.sin(angle)]) / 2
    rod = sp.Matrix([travel - L2 * sp.cos(lean) / 2, -L2 * sp.sin(lean) / 2])
    speeds = [crank.diff(angle), rod.diff(angle)]
    inertia = I1 + I2 * lean.diff(angle) ** 2 + m3 * travel.diff(angle) ** 2
    inertia += m1 * speeds[0].dot(speeds[0]) + m2 * speeds[1].dot(speeds[1])
    force = F * travel.diff(angle) - G * (m1 * crank[1] + m2 * rod[1]).diff(angle)
    eqs = equations_of("slider_crank")
    values = {sp.Symbol(name): value for name, value in numbers_of(eqs.model).items()}
    formula = ((force - inertia.diff(angle) * rate**2 / 2) / inertia).subs(values)
    expected = sp.lambdify([angle, rate, F], formula)
    udot = sb.compile(eqs, "udot")
    rng = np.random.default_rng(5)
    for _ in range(20):
        state = state_of(eqs, random_values(eqs, rng))
        # Both are a few dozen operations; the saddle point system amplifies rounding by its condition.
        tolerance = 100 * EPS * condition(eqs, state)
        found = udot(0.0, state.q, state.u, state.r)[0]
        assert found == pytest.approx(
            expected(state.q[0], state.u[0], state.r[0]), rel=tolerance, abs=tolerance
        )


def test_reactions_hold_piston_and_rod() -> None:
    """Newton for the piston and the rod alone, with the reactions of all joints."""
    eqs = equations_of("slider_crank")
    p = numbers_of(eqs.model)
    measure = motions(eqs)
    rng = np.random.default_rng(6)
    for _ in range(20):
        state = state_of(eqs, random_values(eqs, rng))
        found = measure(state)
        R = found["frame R Crank ground"]
        weight = np.array([0, -p["G"], 0])
        push = np.array([state.r[0], 0, 0])
        on_rod = R @ found["reaction B"][:3] + found["reaction C"][:3]
        on_piston = found["reaction D"][:3] - found["reaction C"][:3] + push
        on_crank = found["reaction A"][:3] - R @ found["reaction B"][:3]
        tolerance = 100 * EPS * condition(eqs, state)
        for body, mass, force in (
            ("Rod", "m2", on_rod),
            ("Piston", "m3", on_piston),
            ("Crank", "m1", on_crank),
        ):
            acceleration = found[f"frame vdot {body} ground ground"]
            scale = max(1.0, np.abs(force).max())
            assert np.abs(p[mass] * (acceleration - weight) - force).max() < tolerance * scale


@pytest.mark.parametrize("choice", cases(TREES, fast=["cut at C", "rotation at A B D, translation at A C D"]))
def test_every_tree_gives_the_same_motion_and_reactions(choice: str) -> None:
    reference = named_equations()
    eqs = sb.form_equations(named(), tree=TREES[choice])
    assert eqs.degrees_of_freedom == 1
    if choice == "absolute":
        assert len(eqs.speeds) == 18
    expect, measure = motions(reference), motions(eqs)
    rng = np.random.default_rng(7)
    for _ in range(100):
        values = random_values(reference, rng)
        start = state_of(reference, values)
        expected = expect(start)
        values |= {
            "phi": values["beta"] - values["theta"],
            "phi_dot": values["beta_dot"] - values["theta_dot"],
        }
        state = state_of(eqs, values | absolute_values(eqs, expected))
        violation = compiled(eqs, "constraints", "velocity_constraints")(0.0, state.q, state.u, state.r)
        assert max(np.abs(part).max() for part in violation) < 1e-14 * 10  # lengths and speeds of order 1
        found = measure(state)
        worst = max(condition(reference, start), condition(eqs, state))
        for name, value in expected.items():
            # Both solutions are backward stable; the given states differ by some eps.
            scale = max(1.0, *(np.abs(entry).max() for entry in expected.values()))
            assert np.abs(found[name] - value).max() < 100 * EPS * worst * scale, name


# Every joint left out for rotation with every one left out for translation, absolute coordinates, and a mixture.
MOTIONS: dict[str, TreeChoice] = TREES | {
    f"no rotation at {r}, no translation at {t}": Trees("ABCD".replace(r, ""), "ABCD".replace(t, ""))
    for r in "ABCD"
    for t in "ABCD"
    if r != t
}
# All in the exhaustive tier; every cut in the fast one.
FAST = ("cut at A", "cut at C", "cut at D")
_TIMES = np.linspace(0.0, 10.0, 41)
_START: dict[str, float | str] = {"theta": "pi/6", "theta_dot": 5.0}


@cache
def reference_run() -> sb.Trajectory:
    """The motion in the crank's angle alone, at the tightest tolerances: energy is its own witness."""
    return _run(named_equations())


def _run(eqs: sb.EquationSet) -> sb.Trajectory:
    found = sb.simulate(eqs, 10.0, _START, times=_TIMES, rtol=1e-12, atol=1e-13)
    assert found.success and found.t.tolist() == _TIMES.tolist()
    return found


@pytest.mark.parametrize(
    "choice",
    [name if name in FAST else pytest.param(name, marks=pytest.mark.exhaustive) for name in MOTIONS],
)
def test_every_tree_moves_alike_for_ten_seconds(choice: str) -> None:
    reference, run = reference_run(), _run(sb.form_equations(named(), tree=MOTIONS[choice]))
    # Local errors of 1e-12 over a few hundred steps; the crank turns about eight times without damping,
    # where errors grow with time, not exponentially.
    for name in ("theta", "beta", "s", "theta_dot", "s_dot"):
        assert np.abs(run[name] - reference[name]).max() < 1e-8, name
    pin, expected = run["reaction B"], reference["reaction B"]
    assert pin.shape == (6, _TIMES.size)
    # Accelerations follow from the state, some ten times its error; forces reach about 100 N.
    assert np.abs(pin - expected).max() < 1e-8 * max(1.0, np.abs(expected).max())
    assert run.constraint_violation.max() < 1e-10 and run.energy_drift < 1e-8


def test_the_motion_keeps_the_loop_of_the_textbook() -> None:
    """s and beta by the closed form of the triangle A B C at every stored time; energy without friction."""
    run, p = reference_run(), numbers_of(named())
    angle = run["theta"]
    lean = -np.arcsin(p["L1"] * np.sin(angle) / p["L2"])
    assert run["beta"] == pytest.approx(lean, abs=1e-10)
    assert run["s"] == pytest.approx(p["L1"] * np.cos(angle) + p["L2"] * np.cos(lean), abs=1e-10)
    assert run["phi"] == pytest.approx(lean - angle, abs=1e-10)
    assert angle[-1] - angle[0] > 4 * np.pi  # past both dead centres, many times
    assert np.ptp(run["energy"]) < 1e-8


def test_initial_values_of_the_file_are_guesses() -> None:
    """The loop closes near them; a value that is given holds exactly."""
    eqs = equations_of("slider_crank")
    run = sb.simulate(eqs, 0.1)
    assert run["theta"][0] == pytest.approx(np.pi / 6, abs=0.1)
    assert run.constraint_violation.max() < 1e-10
    given = sb.simulate(eqs, 0.1, {"theta": 0.7})
    assert given["theta"][0] == 0.7
