"""One slider-crank by hand in global, recursive and natural coordinates, and drawn: the same motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from symbody.equations.formulations.formulation import Formulation
from tests.formulations import UNLIMITED
from tests.mbsymba import slider_crank as sc
from tests.mbsymba.spots import t, values

# theta'' and the force in the pin C are found by a solution whose condition is below 1e4.
CLOSE = 1e-10


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -sc.g, 0))
    yield
    mb.set_gravity(None)


def by_hand(name: str, formulation: Formulation | None, nat: bool = False) -> sb.EquationSet:
    objects, q = sc.objects_of(sc.MECHANISMS[name]())
    return mb.equation_set(objects, q, formulation, nat_coords=nat, parameters=sc.DATA)


def crank_and_pin(eqs: sb.EquationSet, name: str) -> list[float]:
    """theta'', s'' and the force on the rod by the slider in ground axes."""
    state = sb.assemble(eqs, fixed=sc.INITIAL[name], guess=sc.GUESS[name])
    if name == "natural":
        turning = state["u1x"] * state.udot["u1y_ddot"] - state["u1y"] * state.udot["u1x_ddot"]
    else:
        turning = state.udot["theta_ddot"]
    multipliers = list(state.multipliers.values())
    return [turning, state.udot["s_ddot"], *multipliers[:2]]


def drawn_values() -> list[float]:
    eqs = sb.form_equations(sc.drawn())
    state = sb.assemble(eqs, fixed=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"])
    f = sb.compile(eqs, "reaction C")
    q, u = [[state[name] for name in names] for names in (eqs.coordinate_names, eqs.speed_names)]
    force = f(0.0, q, u)[:2]  # the slider's axes are those of ground
    return [state.udot["theta_ddot"], state.udot["s_ddot"], *force]


@pytest.mark.parametrize("name", sc.MECHANISMS)
def test_accelerations_and_reactions_are_those_of_the_drawn_one(name: str) -> None:
    wanted = drawn_values()
    cases = [(each, False) for each in UNLIMITED] + [(None, name == "natural")]
    for formulation, nat in cases:
        assert crank_and_pin(by_hand(name, formulation, nat), name) == pytest.approx(wanted, rel=CLOSE)


@pytest.mark.parametrize("name", sc.MECHANISMS)
def test_the_motion_is_that_of_the_drawn_one(name: str) -> None:
    ends = []
    for eqs, key in ((by_hand(name, None), name), (sb.form_equations(sc.drawn()), "recursive")):
        run = sb.simulate(
            eqs, 1.0, initial=sc.INITIAL[key], guess=sc.GUESS[key], rtol=1e-11, atol=1e-13,
            times=np.linspace(0, 1, 11),
        )  # fmt: skip
        assert run.success
        angle = np.unwrap(np.arctan2(run["u1y"], run["u1x"])) if key == "natural" else run["theta"]
        ends.append([angle, run["s"], run.energy - run.energy[0]])
    # errors of 1e-11 a step over some hundred steps, doubled by the two runs
    assert np.abs(np.array(ends[0]) - np.array(ends[1])).max() < 1e-8


def test_newton_and_euler_with_reactions_as_unknowns() -> None:
    """Step 5 of the notes: accelerations and reactions from one linear system, weights as forces."""
    mb.set_gravity(None)
    (crank, rod, slider), Phi, q = sc.absolute()
    RF1, RF2, RF3 = crank.frame, rod.frame, slider.frame
    ax, ay, bx, by, cx, cy, n, tau = reactions = list(dynamicsymbols("ax ay bx by cx cy n tau"))
    ground, nothing = mb.ground, 0
    tip, end = mb.make_POINT(RF1, sc.L1 / 2, 0, 0), mb.make_POINT(RF2, sc.L2 / 2, 0, 0)
    forces = [
        *(
            mb.make_FORCE(ground, 0, -m * sc.g, 0, mb.CoM(b), b)
            for m, b in ((sc.m1, crank), (sc.m2, rod), (sc.m3, slider))
        ),
        mb.make_FORCE(ground, ax, ay, nothing, mb.make_POINT(RF1, -sc.L1 / 2, 0, 0), crank),
        mb.make_FORCE(ground, bx, by, nothing, tip, rod, crank),
        mb.make_FORCE(mb.make_VECTOR(ground, cx, cy, 0), end, rod, slider),
        mb.make_FORCE(ground, 0, n, 0, mb.origin(RF3), slider),
        mb.make_TORQUE(ground, 0, 0, tau, slider),
    ]
    eqs = []
    for body in (crank, rod, slider):
        neq = mb.newton_equations([body, *forces])
        eeq = mb.euler_equations([body, *forces], mb.CoM(body))
        eqs += [mb.comp_X(neq), mb.comp_Y(neq), mb.comp_Z(eeq)]
    acc = mb.diff(q, t, t)
    M, rest = mb.GenerateMatrix(eqs, acc)
    V, Fe = mb.GenerateMatrix(list(rest), reactions)
    assert sp.simplify(M * sp.Matrix(acc) - V * sp.Matrix(reactions) + Fe - sp.Matrix(eqs)) == sp.zeros(9, 1)
    AA, BB = mb.GenerateMatrix(eqs + mb.diff(Phi, t, t), acc + reactions)
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -sc.g, 0))
    state = sb.assemble(by_hand("absolute", None), fixed=sc.INITIAL["absolute"], guess=sc.GUESS["absolute"])
    numbers: dict[object, float] = {sp.Symbol(name): number for name, number in sc.DATA.items()}
    for x in q:
        numbers |= {x: state[x.func.__name__], x.diff(t): state[f"{x.func.__name__}_dot"]}
    A = np.array(values(AA, numbers)).reshape(AA.shape)
    x = np.linalg.solve(A, values(BB, numbers))
    wanted = drawn_values()
    found = dict(zip([*acc, *reactions], x, strict=True))
    theta, s = q[2].diff(t, 2), q[6].diff(t, 2)
    assert [found[key] for key in (theta, s, cx, cy)] == pytest.approx(wanted, rel=1e-8)
    # the reactions leave the equation set, whose multipliers of the same joints are these forces
    mb.set_gravity(None)
    placed = mb.equation_set(
        [crank, rod, slider, *forces, mb.make_CONSTRAINT(Phi, dynamicsymbols("lambda1:9"))], q,
        reactions=reactions, parameters=sc.DATA,
    )  # fmt: skip
    assert placed.input_names == () and any("reactions" in note for note in placed.notes)
    again = sb.assemble(placed, fixed=sc.INITIAL["absolute"], guess=sc.GUESS["absolute"])
    found_again = [again.udot["theta_ddot"], again.udot["s_ddot"], *list(again.multipliers.values())[:2]]
    assert found_again == pytest.approx(wanted, rel=1e-8)


def test_lagrange_equations_lead_to_the_equation_set() -> None:
    objects, q = sc.objects_of(sc.recursive())
    lambdas = list(dynamicsymbols("lambda1:3"))
    found = mb.lagrange_equations(set(objects), [*q, *lambdas], t)
    assert isinstance(found, list) and len(found) == 5
    eqs = found.equation_set
    acc = mb.diff(q, t, t)
    A, b = mb.GenerateMatrix(found[:3] + mb.diff(found[3:], t, t), acc + lambdas)
    state = sb.assemble(eqs, fixed=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"], parameters=sc.DATA)
    numbers: dict[object, float] = {sp.Symbol(name): number for name, number in sc.DATA.items()}
    for x in q:
        numbers |= {x: state[x.func.__name__], x.diff(t): state[f"{x.func.__name__}_dot"]}
    x = np.linalg.solve(np.array(values(A, numbers)).reshape(5, 5), values(b, numbers))
    assert x == pytest.approx([*state.udot.values(), *state.multipliers.values()], rel=1e-9)
    assert [x[0], x[2], *x[3:]] == pytest.approx(drawn_values(), rel=1e-9)
    newvars, first = mb.first_order(found, [*q, *lambdas])
    assert newvars == [*q, *lambdas, *dynamicsymbols("theta_dot beta_dot s_dot")] and len(first) == 8


@pytest.mark.parametrize("name", sc.MECHANISMS)
def test_formulas_to_read_are_the_code(name: str) -> None:
    eqs = by_hand(name, None)
    state = sb.assemble(eqs, fixed=sc.INITIAL[name], guess=sc.GUESS[name])
    q, u = [[state[each] for each in names] for names in (eqs.coordinate_names, eqs.speed_names)]
    numbers: dict[object, float] = {sp.Symbol(each): number for each, number in sc.DATA.items()}
    numbers |= dict(zip([*eqs.coordinates, *eqs.speeds], [*q, *u], strict=True))
    f = sb.compile(eqs, ("mass_matrix", "forcing", "jacobian", "constraints"))(0.0, q, u)
    read = (eqs.mass_matrix, eqs.forcing, eqs.constraint_jacobian, eqs.constraints)
    for code, formula in zip(f, read, strict=True):
        # natural coordinates are closed to 1e-12, and formulas differ by multiples of what is open
        assert np.ravel(code) == pytest.approx(values(formula, numbers), rel=1e-10, abs=1e-10)


def test_everything_else_works_on_it() -> None:
    eqs = by_hand("recursive", None)
    hanging = sb.find_equilibrium(eqs, guess={"theta": -1.5, "beta": 1.8, "s": 1.0})
    assert hanging["theta"] == pytest.approx(-np.pi / 2, abs=1e-9)
    drawn = sb.form_equations(sc.drawn())
    at = {"theta": -np.pi / 2}
    poles = [sb.linearize(each, at=at, parameters=sc.DATA).eigenvalues.imag.max() for each in (eqs, drawn)]
    assert poles[0] == pytest.approx(poles[1], rel=1e-9)
    assert "double" in sb.generate_code(eqs, ["udot", "lambda"], language="c")
    run = sb.simulate(eqs, 0.1, initial=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"])
    assert sb.plot(run, "theta") is not None
    assert eqs.degrees_of_freedom == 1 and len(eqs.dynamic_equations()) == 3
    assert eqs.constraint_jacobian.shape == (2, 3) and eqs.frame_motion("r", "rod").shape == (3, 1)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", sc.MECHANISMS)
@pytest.mark.parametrize(
    "keeping", [sb.Projection(), sb.Partition(), sb.Baumgarte(), sb.GGL()], ids=lambda c: type(c).__name__
)
def test_every_way_to_keep_the_constraints(name: str, keeping: object) -> None:
    eqs = by_hand(name, None)
    run = sb.simulate(eqs, 1.0, initial=sc.INITIAL[name], guess=sc.GUESS[name], constraints=keeping)
    # GGL runs by tolerances of the default 1e-8 over a chaotic second; the others keep 1e-7
    assert run.success and run["s"][-1] == pytest.approx(_end(), abs=1e-5)


def _end() -> float:
    run = sb.simulate(
        sb.form_equations(sc.drawn()), 1.0, initial=sc.INITIAL["recursive"], guess=sc.GUESS["recursive"]
    )
    return float(run["s"][-1])
