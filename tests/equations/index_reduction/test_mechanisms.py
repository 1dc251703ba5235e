"""LUMethod on the equations of mechanisms against their own structure, and the structural reduction itself."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.model import resolve_parameters
from tests.analysis.test_assembly import slider_crank

T = dynamicsymbols._t


def first_order(eqs: sb.EquationSet) -> tuple[list[sp.Expr], list[sp.Expr], list[sp.Expr]]:
    """Hand-made equations q' = v, M v' = F + J^T lambda, Phi = 0; with q and v."""
    q = list(eqs.coordinates)
    v = [sp.Function(f"v_{name}")(T) for name in eqs.coordinate_names]
    rename = dict(zip([s.diff(T, 2) for s in q], [s.diff(T) for s in v], strict=True))
    speeds = dict(zip([s.diff(T) for s in q], v, strict=True))
    motion = [(row.lhs - row.rhs).subs(rename).subs(speeds) for row in eqs.dynamic_equations()]
    return [*(a.diff(T) - b for a, b in zip(q, v, strict=True)), *motion, *eqs.constraints], q, v


def four_bar(seed: int) -> sb.Model:
    """A random planar four-bar with numbers near those of a Grashof chain; a spring and a damper drive it."""
    rng = random.Random(seed)
    lengths = {"a": rng.uniform(0.5, 1), "b": rng.uniform(2, 2.5), "c": rng.uniform(1.8, 2.3), "d": 2.0}
    bodies = [
        sb.Body(name, mass=rng.uniform(0.5, 2), inertia=(0, 0, rng.uniform(0.05, 0.5)),
                frames={"in": sb.Frame(at=(f"-{length}/2", 0, 0)), "out": sb.Frame(at=(f"{length}/2", 0, 0))})
        for name, length in (("Crank", "a"), ("Rod", "b"), ("Rocker", "c"))
    ]  # fmt: skip
    return sb.Model(
        "four-bar",
        [
            *bodies,
            sb.Revolute("A", "ground", "Crank.in", coordinate="alpha", torque=sb.Drive(stiffness=3, damping=0.2)),
            sb.Revolute("B", "Crank.out", "Rod.in", coordinate="beta"),
            sb.Revolute("C", "Rod.out", "Rocker.out", tree=False),
            sb.Revolute("D", "ground.D", "Rocker.in", coordinate="delta"),
        ],
        gravity=(0, rng.uniform(-10, 10), 0),
        parameters=lengths,
        ground={"D": sb.Frame(at=("d", 0, 0))},
        initial={"beta": 0.5, "delta": 1.0},
    )  # fmt: skip


def pendulum_in_absolute_coordinates(seed: int) -> sb.Model:
    rng = random.Random(seed)
    body = sb.Body("Rod", mass=rng.uniform(0.5, 2), inertia=(0, 0, rng.uniform(0.05, 0.5)),
                   frames={"end": sb.Frame(at=("-L", 0, 0))})  # fmt: skip
    return sb.Model(
        "pendulum",
        [
            body,
            sb.Planar("plane", "ground", "Rod", coordinates=["x", "y", "phi"]),
            sb.Revolute("pin", "ground", "Rod.end", tree=False),
        ],
        gravity=(0, "-g", 0),
        parameters={"L": rng.uniform(0.5, 2), "g": 9.81},
        initial={"x": 0.5},
    )


MAKERS = {"four-bar": four_bar, "pendulum": pendulum_in_absolute_coordinates,
          "slider-crank": lambda seed: slider_crank(L1=0.5 + seed / 10)}  # fmt: skip


def check(model: sb.Model, seed: int) -> None:
    eqs = sb.form_equations(model)
    rows, q, v = first_order(eqs)
    unknowns = [*q, *v, *eqs.multipliers]
    reduced = sb.reduce_index(rows, unknowns)
    count = len(eqs.multiplier_names)
    assert [len(level) for level in reduced.algebraic] == [count] * 3
    rng = random.Random(seed)
    free = [str(s.args[0]).removesuffix("(t)") for s in eqs.independent_speeds]
    start = {free[0]: rng.uniform(0.2, 0.6), f"{free[0]}_dot": rng.uniform(-2, 2)}
    state = sb.assemble(eqs, start)
    numbers = {sp.Symbol(name): float(value) for name, value in resolve_parameters(model).items()}
    at = dict(zip(q, state.q.values(), strict=True)) | dict(zip(v, state.u.values(), strict=True))
    at |= dict(zip(eqs.multipliers, state.multipliers.values(), strict=True))
    rates = [s.diff(T) for s in unknowns]
    letters = sp.symbols(f"r:{len(rates)}")
    order = [*letters, *at, *numbers]
    given = [*at.values(), *numbers.values()]
    named = [row.subs(dict(zip(rates, letters, strict=True))) for row in reduced.ode]
    system = sp.lambdify(order, [*sp.Matrix(named).jacobian(letters), *named], cse=True)
    found = np.array(system(*[0.0] * len(letters), *given), float)
    n = len(letters)
    solved = np.linalg.solve(found[: n * n].reshape(n, n), -found[n * n :])
    accelerations = solved[len(q) : 2 * len(q)]
    size = 1.0 + float(np.abs(list(state.udot.values())).max())
    # The state closes to 1e-9 of its size; conditions of these mechanisms are below 1e4.
    assert accelerations == pytest.approx(list(state.udot.values()), abs=1e-8 * size)
    hidden = sp.lambdify([*at, *numbers], [row for level in reduced.algebraic for row in level], cse=True)
    scale = 1.0 + max(map(abs, state.multipliers.values()))
    values = np.array(hidden(*given), float) / (scale * size)
    pivots = [abs(float(p.subs(at).subs(numbers))) for p in reduced.assumed_nonzero]
    assert min(pivots, default=1.0) > 0
    # Rows are products of the pivots, in which they may be larger than one.
    assert np.abs(values).max() < 1e-8 * max(1.0, *pivots, 1.0) ** 3


@pytest.mark.parametrize("kind", ["pendulum", "slider-crank"])
def test_separated_equations_have_the_accelerations_of_the_mechanism(kind: str) -> None:
    check(MAKERS[kind](1), 1)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(1, 9))
@pytest.mark.parametrize("kind", MAKERS)
def test_separated_equations_of_many_mechanisms(kind: str, seed: int) -> None:
    check(MAKERS[kind](seed), seed)


def test_the_structure_of_a_mechanism() -> None:
    eqs = sb.form_equations(slider_crank())
    reduced = sb.reduce_index(eqs)
    Phi, velocities, accelerations = reduced.algebraic
    assert reduced.index == 3 and [len(Phi), len(velocities), len(accelerations)] == [2, 2, 2]
    for row, rate, second in zip(Phi, velocities, accelerations, strict=True):
        assert sp.simplify(sp.diff(row, T) - rate) == 0
        assert sp.simplify(sp.diff(row, T, 2) - second) == 0
    assert len(reduced.ode) == len(reduced.unknowns) == 5
    third = [s.diff(T, 3) for s in eqs.coordinates] + [s.diff(T) for s in eqs.multipliers]
    A = sp.Matrix(reduced.ode).jacobian(third)
    M, J = eqs.mass_matrix, eqs.constraint_jacobian
    wanted = M.row_join(-J.T).col_join(J.row_join(sp.zeros(2)))
    assert (A - wanted).applyfunc(sp.simplify) == sp.zeros(5)


def test_a_tree_has_index_0() -> None:
    model = sb.Model(
        "one", [sb.Body("B", mass=2), sb.Prismatic("p", "ground", "B", axis="x", coordinate="s")]
    )
    reduced = sb.reduce_index(sb.form_equations(model))
    (s,) = reduced.unknowns
    assert reduced.index == 0 and reduced.algebraic == () and reduced.ode == [2 * s.diff(T, 2)]


def test_quasi_speeds_bring_their_kinematic_equations() -> None:
    top = sb.Body("Top", mass=1, inertia=(1, 1, 2))
    joint = sb.Spherical("pivot", "ground", "Top", angles="313", coordinates=["a", "b", "c"], speeds="end")
    reduced = sb.reduce_index(sb.form_equations(sb.Model("top", [top, joint])))
    assert len(reduced.ode) == 6 == len(reduced.unknowns)


def test_friction_from_reactions_is_refused() -> None:
    body = sb.Body("B", mass=1, inertia=(0, 0, 1))
    slide = sb.Prismatic("p", "ground", body, axis="x", coordinate="s", friction=sb.Friction(mu=0.2, v0=0.1))
    model = sb.Model("rough", [slide], gravity=(0, -9.81, 0))
    with pytest.raises(sb.FormulationError) as caught:
        sb.reduce_index(sb.form_equations(model))
    assert caught.value.problems[0].code == "reduction.friction"
