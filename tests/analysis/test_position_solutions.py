"""Dependent coordinates in closed form, their branches, ranges, and the notes' steps to initial conditions."""

from __future__ import annotations

import math
import random
from functools import cache

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from tests.analysis.test_assembly import slider_crank

T = dynamicsymbols._t
theta, beta, gamma, s, x, y = dynamicsymbols("theta beta gamma s x y")
L1, L2, L3, L4 = sp.symbols("L1 L2 L3 L4")
CRANK = [L1 * sp.cos(theta) + L2 * sp.cos(beta) - s, L1 * sp.sin(theta) + L2 * sp.sin(beta)]
FOUR_BAR = [L1 * sp.cos(theta) + L2 * sp.cos(beta) - L3 * sp.cos(gamma) - L4,
            L1 * sp.sin(theta) + L2 * sp.sin(beta) - L3 * sp.sin(gamma)]  # fmt: skip
DATA = {"L1": 1.0, "L2": 3.0, "L3": 2.5, "L4": 3.2}
EPS = float(np.finfo(float).eps)


@cache
def crank() -> sb.PositionSolutions:
    return sb.solve_positions(CRANK, [beta, s])


def test_slider_crank_has_two_assemblies_in_closed_form() -> None:
    found = crank()
    assert len(found) == 2 and set(found.branches[0]) == {beta, s}
    root = math.sqrt(9 - math.sin(0.7) ** 2)
    values = found.evaluate({theta: 0.7, "L1": 1, "L2": 3})
    assert sorted(v["s"] for v in values) == pytest.approx(
        [math.cos(0.7) - root, math.cos(0.7) + root], abs=8 * EPS
    )
    for branch in found.branches:
        assert all(sp.simplify(row.subs(branch)) == 0 for row in CRANK)


def test_the_branch_is_picked_by_data_or_by_a_guess() -> None:
    found = crank()
    at = {"theta": 0.7, "L1": 1, "L2": 3}
    stretched = found.nearest({"s": 4.0}, at)
    numbers = {L1: 1, L2: 3, theta: 0.7}
    assert float(stretched[s].subs(numbers)) > 0 > float(found.nearest({s: -1.0}, at)[s].subs(numbers))
    # Guesses of angles count modulo whole turns.
    assert found.nearest({"beta": -0.2 + 6 * math.pi}, at) == stretched


def test_velocities_from_the_derivative_and_from_tau() -> None:
    found = crank()
    numbers = {L1: 1, L2: 3, theta: 0.7, theta.diff(T): 2.0}
    for branch in found.branches:
        J = sp.Matrix(CRANK)
        tau = -(J.jacobian([beta, s]).inv() * J.jacobian([theta]))
        for k, name in enumerate((beta, s)):
            direct = branch[name].diff(T).subs(numbers)
            by_tau = (tau[k] * theta.diff(T)).subs(branch).subs(numbers)
            assert float(direct) == pytest.approx(float(by_tau), abs=1e-12)


@pytest.mark.parametrize(
    "shape", [pytest.param("from ground", marks=pytest.mark.exhaustive), "from link to link"]
)
def test_four_bar_against_newton(shape: str) -> None:
    rows, unknowns = FOUR_BAR, [beta, gamma]
    if shape != "from ground":
        links = {beta: theta + beta, gamma: theta + beta + gamma}
        rows = [row.subs(links, simultaneous=True) for row in rows]
    found = sb.solve_positions(rows, unknowns)
    assert len(found) == 2
    rng = random.Random(1)
    for _ in range(20):
        at = DATA | {"theta": rng.uniform(-3, 3)}
        values = found.evaluate(at)
        assert None not in values and abs(values[0]["beta"] - values[1]["beta"]) > 1e-3
        for one in values:
            slack = [abs(float(row.subs({sp.Symbol(k): v for k, v in DATA.items()}).subs(
                {theta: at["theta"], beta: one["beta"], gamma: one["gamma"]}))) for row in rows]  # fmt: skip
            assert max(slack) < 1e-13


def test_a_configuration_out_of_reach_is_none_and_named() -> None:
    found = sb.solve_positions(FOUR_BAR, [beta, gamma])
    far = DATA | {"theta": 0.7, "L4": 20.0}
    assert found.evaluate(far) == (None, None)
    with pytest.raises(sb.AssemblyError) as caught:
        found.nearest({"beta": 0.0}, far)
    assert caught.value.problems[0].code == "positions.unreachable"


def test_an_equation_set_brings_its_constraints_and_values() -> None:
    eqs = sb.form_equations(slider_crank())
    found = sb.solve_positions(eqs, ["beta", "s"])  # by name
    state = sb.assemble(eqs, {"theta": 0.7}, {"s": 4.0})
    branch = found.nearest({"s": 4.0}, {"theta": 0.7})
    k = found.branches.index(branch)
    values = found.evaluate({"theta": 0.7})[k]
    assert values["s"] == pytest.approx(state.q["s"], abs=1e-12)
    assert values["beta"] == pytest.approx(state.q["beta"], abs=1e-12)
    longer = found.evaluate({"theta": 0.0, "L1": 2})[k]
    assert longer["s"] == pytest.approx(5.0, abs=1e-12)


def offset_crank() -> sb.EquationSet:
    """The slider's line lies `e` above the pivot; the cut joint measures along the rod."""
    elements = [one for one in slider_crank().elements if one.name != "D"]
    line = sb.Prismatic("D", "ground.line", "Slider", coordinate="s")
    values, ground = {"L1": 1, "L2": 3, "e": 0.5}, {"line": sb.Frame(at=(0, "e", 0))}
    return sb.form_equations(sb.Model("offset", [*elements, line], parameters=values, ground=ground))


def test_loops_closed_in_the_axes_of_a_link_are_solved_too() -> None:
    """s cos(theta + beta) + e sin(theta + beta) - ... of the rod's axes is turned into those of ground."""
    found = sb.solve_positions(offset_crank(), ["beta", "s"])
    rng = random.Random(2)
    for _ in range(20):
        at = {"theta": rng.uniform(-3, 3), "L1": rng.uniform(0.5, 1.5), "e": rng.uniform(-1, 1)}
        across = at["e"] - at["L1"] * math.sin(at["theta"])
        ahead, reach = at["L1"] * math.cos(at["theta"]), math.sqrt(9 - across**2)
        values = sorted(one["s"] for one in found.evaluate(at) if one is not None)
        assert values == pytest.approx([ahead - reach, ahead + reach], abs=1e-12)
    state = sb.assemble(offset_crank(), {"theta": 0.7}, {"s": 4.0})
    branch = found.evaluate({"theta": 0.7})[found.branches.index(found.nearest({"s": 4.0}, {"theta": 0.7}))]
    assert branch is not None and branch["s"] == pytest.approx(state.q["s"], abs=1e-12)


OTHERS = {
    "circles": ([x**2 + y**2 - L1**2, (x - L4) ** 2 + y**2 - L2**2], [x, y], {"L1": 3, "L2": 3, "L4": 2}),
    "slotted lever": ([s * sp.cos(beta) - L1 * sp.cos(theta), s * sp.sin(beta) - L1 * sp.sin(theta) - L4],
                      [s, beta], {"L1": 1, "L4": 3, "theta": 0.7}),
    "natural coordinates": ([x**2 + y**2 - 1, L1 * x - sp.cos(theta)], [x, y], {"L1": 2, "theta": 0.7}),
}  # fmt: skip


@pytest.mark.exhaustive
@pytest.mark.parametrize("kind", OTHERS)
def test_further_loops_have_two_branches_each(kind: str) -> None:
    rows, unknowns, at = OTHERS[kind]
    found = sb.solve_positions(rows, unknowns)
    assert len(found) == 2 and None not in found.evaluate(at)


REFUSED = {
    "positions.number": (CRANK, [beta], 20.0),
    "positions.dependent": (CRANK, [beta, gamma], 20.0),
    "positions.none": (
        [sp.cos(beta) + sp.cos(gamma) - s, sp.cos(beta) + sp.cos(gamma) - s - 1],
        [beta, s],
        20.0,
    ),
    "positions.time": (CRANK, [beta, s], 0.02),  # less than a process needs to start
    "positions.seconds": (CRANK, [beta, s], 0.0),
}


@pytest.mark.parametrize("code", REFUSED)
def test_refusals_name_cause_and_cure(code: str) -> None:
    rows, unknowns, seconds = REFUSED[code]
    with pytest.raises(sb.FormulationError) as caught:
        sb.solve_positions(rows, unknowns, seconds=seconds)
    assert caught.value.problems[0].code == code and caught.value.problems[0].fix


def test_values_that_are_missing_or_unknown_are_named() -> None:
    found = crank()
    with pytest.raises(sb.CompileError) as caught:
        found.evaluate({"theta": 0.7, "L7": 1})
    assert {p.code for p in caught.value.problems} == {"compile.missing_value", "compile.unknown_parameter"}
    with pytest.raises(sb.CompileError):
        found.nearest({"theta": 1.0}, {"theta": 0.7, "L1": 1, "L2": 3})


def test_continuation_fills_a_table() -> None:
    # The loop of the notes: s = 0.5 + 0.03 i, each solution the next guess.
    eqs = sb.form_equations(slider_crank(L1=1, L2=1.2))
    table, guess = np.zeros((10, 3)), {"theta": 1.9, "beta": -2.5}
    for i in range(10):
        state = sb.assemble(eqs, {"s": 0.5 + 0.03 * (i + 1)}, guess)
        guess = dict(state.q)
        table[i] = list(state.q.values())
    assert np.abs(np.diff(table[:, :2], axis=0)).max() < 0.1  # no jump to the other branch
    # Law of cosines: L2^2 = L1^2 + s^2 - 2 L1 s cos(theta).
    assert np.cos(table[:, 0]) == pytest.approx((1 + table[:, 2] ** 2 - 1.44) / (2 * table[:, 2]), abs=1e-12)


def two_freedoms() -> sb.Model:
    """The notes' 4.4.2: theta1 and y20 are given; a crank, a block on a vertical guide, a rod with a slide."""
    crank = sb.Body("Crank", mass=1, inertia=(0, 0, 0.1), frames={"P": sb.Frame(at=(1, 0, 0))})
    block, rod = sb.Body("Block", mass=2), sb.Body("Rod", mass=0.5, inertia=(0, 0, 0.2))
    return sb.Model(
        "two freedoms",
        [
            crank, block, rod,
            sb.Revolute("A", "ground", crank, coordinate="theta1"),
            sb.Prismatic("G", "ground.guide", block, axis="y", coordinate="y20"),
            sb.Revolute("B", "Crank.P", rod, coordinate="theta2"),
            sb.PointOnLine("slot", "Rod", "Block", axis="x"),
        ],
        gravity=(0, -9.81, 0),
        ground={"guide": sb.Frame(at=(3, 0, 0))},
    )  # fmt: skip


def test_initial_conditions_from_two_coordinates_and_two_velocities() -> None:
    eqs = sb.form_equations(two_freedoms())
    start = {"theta1": 0.2, "y20": 2.0, "theta1_dot": 0.0, "y20_dot": 0.1}
    state = sb.assemble(eqs, start)
    assert {name: state[name] for name in start} == pytest.approx(start, abs=1e-15)
    # The rod points from the crank's end to the block.
    dx, dy = 3 - math.cos(0.2), 2 - math.sin(0.2)
    absolute = state.q["theta2"] + 0.2
    assert math.sin(absolute) * dx - math.cos(absolute) * dy == pytest.approx(0, abs=1e-9)
    assert state.u["theta2_dot"] == pytest.approx(0.1 * dx / (dx**2 + dy**2), abs=1e-9)
    M, J, F, right = (np.asarray(state[name]) for name in ("mass_matrix", "jacobian", "forcing", "gamma"))
    n = len(F)
    A = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
    solved = np.linalg.solve(A, np.concatenate([F, np.atleast_1d(right)]))
    assert list(state.udot.values()) == pytest.approx(list(solved[:n]), abs=1e-9)
    assert list(state.multipliers.values()) == pytest.approx(list(solved[n:]), abs=1e-9)


RANGES = [
    ({"s": (-5, 0)}, -1),
    ({"s": (0, 5)}, 1),
    ({"beta": (6, 2 * math.pi + 3)}, None),
    ({"s": (0, "L1 + L2")}, 1),
]


@pytest.mark.parametrize(("ranges", "sign"), RANGES)
def test_ranges_choose_the_assembly(ranges: dict[str, tuple[float, float]], sign: int | None) -> None:
    state = sb.assemble(sb.form_equations(slider_crank()), {"theta": 0.7}, ranges=ranges)
    for name, (low, high) in ranges.items():
        assert low <= state.q[name] <= (4.0 if isinstance(high, str) else high)
    assert sign is None or math.copysign(1, state.q["s"]) == sign
    assert state.residual < 1e-9


def test_ranges_out_of_reach_tell_where_the_loop_closes() -> None:
    eqs = sb.form_equations(slider_crank())
    cases = {
        "assembly.out_of_range": {"s": (5, 6)},
        "assembly.range": {"s": (2, 1)},
        "assembly.unknown_name": {"S": (0, 1)},
    }
    for code, ranges in cases.items():
        with pytest.raises(sb.AssemblyError) as caught:
            sb.assemble(eqs, {"theta": 0.7}, ranges=ranges)
        assert caught.value.problems[0].code == code and caught.value.problems[0].fix
    with pytest.raises(sb.AssemblyError, match="not a position"):
        sb.assemble(eqs, {"theta": 0.7}, ranges={"theta_dot": (0, 1)})


def test_a_measured_angle_has_a_range_too() -> None:
    eqs = sb.form_equations(slider_crank())
    state = sb.assemble(eqs, guess={"theta": 0.5}, ranges={"C": (0.2, 0.3)})
    assert 0.2 <= state["C"] <= 0.3
