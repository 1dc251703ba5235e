"""Velocity ratios, traced positions and singular configurations against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from tests.analysis.test_assembly import slider_crank
from tests.mechanisms import example

SLIDER_CRANK = sb.form_equations(slider_crank())
# Places are found where a determinant changes its sign; 1e-6 is what is promised.
FOUND = 1e-6


def four_bar(crank: float, coupler: float, rocker: float, ground: float) -> sb.EquationSet:
    lengths = {"Crank": crank, "Coupler": coupler, "Rocker": rocker}
    bars = [sb.Body(name, mass=1, inertia=(0, 0, 1), frames={"Q": sb.Frame(at=(length, 0, 0))})
            for name, length in lengths.items()]  # fmt: skip
    joints = [
        sb.Revolute("A", "ground", "Crank", coordinate="theta"),
        sb.Revolute("B", "Crank.Q", "Coupler", coordinate="beta"),
        sb.Revolute("C", "Coupler.Q", "Rocker.Q", tree=False),
        sb.Revolute("D", "ground.O", "Rocker", coordinate="phi"),
    ]
    place = {"O": sb.Frame(at=(ground, 0, 0))}
    return sb.form_equations(
        sb.Model("four-bar", [*bars, *joints], ground=place, initial={"phi": 1, "theta": 0.8})
    )


def test_ratios_of_the_slider_crank_in_closed_form() -> None:
    ratios = sb.velocity_ratios(SLIDER_CRANK, "theta")
    L1, L2 = sp.symbols("L1 L2")
    theta, beta, s = dynamicsymbols("theta beta s")
    # From s = L1 cos(theta) + L2 cos(theta + beta), 0 = L1 sin(theta) + L2 sin(theta + beta).
    beta_rate = -1 - L1 * sp.cos(theta) / (L2 * sp.cos(theta + beta))
    s_rate = -L1 * sp.sin(theta) - L2 * sp.sin(theta + beta) * (1 + beta_rate)
    b = sp.asin(-sp.sin(theta) / 3) - theta
    place = {L1: 1, L2: 3, s: sp.cos(theta) + 3 * sp.cos(theta + b)}
    for found, expected in zip(ratios.tau, (beta_rate, s_rate), strict=True):
        apart = (found - expected).subs(place).subs(beta, b).subs(theta, sp.Float("0.7", 40))
        assert abs(apart.evalf(30)) < 1e-20
    numbers = ratios.at({"theta": 0.7})
    assert ratios.dependent == ("beta_dot", "s_dot")
    expected = [float(e.subs(place).subs(beta, b).subs(theta, 0.7)) for e in (beta_rate, s_rate)]
    assert numbers[:, 0] == pytest.approx(expected, abs=1e-12)


def test_speeds_and_accelerations_follow() -> None:
    ratios = sb.velocity_ratios(SLIDER_CRANK, "theta")
    found = ratios.accelerations({"theta": 0.7}, {"theta": 2.0}, {"theta_ddot": 1.0})
    state = sb.assemble(SLIDER_CRANK, {"theta": 0.7, "theta_dot": 2.0})
    assert ratios.speeds(state, {"theta": 2.0}) == pytest.approx(dict(state.u), abs=1e-12)
    sin, cos, root = np.sin(0.7), np.cos(0.7), np.sqrt(9 - np.sin(0.7) ** 2)
    slope = -sin - sin * cos / root
    curve = -cos - ((cos**2 - sin**2) * root**2 + sin**2 * cos**2) / root**3
    assert found["s_ddot"] == pytest.approx(slope * 1.0 + curve * 4.0, abs=1e-12)


def test_the_holding_force_is_that_of_virtual_work() -> None:
    """Checklist N-53: a torque on the crank held by a force on the slider."""
    model = slider_crank()
    held = sb.Model(
        "held",
        [*model.bodies, *(j for j in model.joints if j.name not in "AD"),
         sb.Revolute("A", "ground", "Crank", coordinate="theta", torque=sb.Drive(applied="T")),
         sb.Prismatic("D", "ground", "Slider", coordinate="s", force=sb.Drive(applied="F"))],
        inputs=["T", "F"], parameters={"L1": 1, "L2": 3},
    )  # fmt: skip
    eqs = sb.form_equations(held)
    ratios = sb.velocity_ratios(eqs, "theta")
    force = ratios.holding("F")
    state = sb.assemble(eqs, {"theta": 0.7}, inputs={"T": 2.0})
    place = {symbol: state.q[str(symbol.func)] for symbol in eqs.coordinates}
    T, (L1, L2) = eqs.inputs[0], sp.symbols("L1 L2")
    value = float(force.subs(T, 2).subs(place).subs({L1: 1, L2: 3}))
    slope = ratios.at(state)[ratios.dependent.index("s_dot"), 0]
    assert value == pytest.approx(-2 / slope, rel=1e-12)
    # Inverse dynamics of a mechanism that stands still, with its multipliers, knows nothing of ratios.
    run = sb.inverse_dynamics(eqs, {"theta": "0.7"}, "F", [0.0], inputs={"T": "2"}, guess={"s": 4})
    assert run["F"] == pytest.approx(value, rel=1e-11)
    balanced = sb.assemble(eqs, {"theta": 0.7}, inputs={"T": 2.0, "F": value})
    assert ratios.generalized_forces(balanced) == pytest.approx(0, abs=1e-12)
    unloaded = sb.assemble(eqs, {"theta": 0.7})
    assert ratios.generalized_forces({"theta": 0.7}).tolist() == ratios.generalized_forces(unloaded).tolist()


def test_the_choice_of_independent_speeds_is_told() -> None:
    ratios = sb.velocity_ratios(SLIDER_CRANK)
    assert ratios.independent[0] in ratios.notes[0]
    dead = sb.assemble(SLIDER_CRANK, {"theta": 0.0})
    assert sb.velocity_ratios(SLIDER_CRANK, at=dead).independent != ("s_dot",)
    with pytest.raises(sb.SimulationError) as caught:
        sb.velocity_ratios(SLIDER_CRANK, "s").at(dead)
    (problem,) = caught.value.problems
    assert problem.code == "kinematics.singular" and "joint D" in problem.why and "theta = 0" in problem.what


@pytest.mark.parametrize("names", ["sigma", ["theta", "s"]])
def test_impossible_choices_are_refused(names: str | list[str]) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.velocity_ratios(SLIDER_CRANK, names)
    assert all(problem.fix for problem in caught.value.problems)


def test_positions_are_traced_as_in_the_notes() -> None:
    """Checklist N-27: s = 0.5 + 0.03 i, each solution the next guess."""
    angles = 0.5 + 0.03 * np.arange(1, 11)
    table = sb.trace_positions(SLIDER_CRANK, {"theta": angles}, guess={"s": 4})
    assert table.success and table.q.shape == (3, 10)
    assert table["s"] == pytest.approx(np.cos(angles) + np.sqrt(9 - np.sin(angles) ** 2), abs=1e-13)
    assert list(table.columns()) == ["theta", "beta", "s"]


def test_a_dead_end_is_a_limit() -> None:
    table = sb.trace_positions(SLIDER_CRANK, {"s": np.linspace(3.5, 4.5, 11)}, guess={"theta": 0.5})
    assert not table.success and table.limits["s"] == pytest.approx(4.0, abs=1e-9)
    assert table.joint in table.notes[0] and table["s"].size == table.q.shape[1]


def test_questions_without_a_path_are_refused() -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.trace_positions(sb.form_equations(sb.Model("two", [
            sb.Body("P", mass=1), sb.Body("Q", mass=1),
            sb.Prismatic("J", "ground", "P", coordinate="x"), sb.Prismatic("K", "P", "Q", coordinate="y"),
        ])), {"x": [0, 1]})  # fmt: skip
    (problem,) = caught.value.problems
    assert problem.code == "kinematics.freedoms_left"
    assert problem.what == "with x driven, 1 more can still move freely: y_dot"
    with pytest.raises(sb.UsageError):
        sb.trace_positions(SLIDER_CRANK, {"theta": [0, 1], "s": [1, 2, 3]})


def test_a_rod_that_spins_between_two_balls_is_named() -> None:
    """Which of the degrees of freedom is left, not only that there is one."""
    with pytest.raises(sb.UsageError) as caught:
        sb.trace_positions(example("spatial_four_bar"), {"theta": [0.1, 0.2]}, guess={"phi": 0.3})
    (problem,) = caught.value.problems
    assert problem.what == "with theta driven, 1 more can still move freely: sigma_dot"


def test_dead_centres_lock_the_slider_but_not_the_crank() -> None:
    ends = (-0.5, 4.0)
    found = sb.singular_configurations(SLIDER_CRANK, "s", {"theta": ends})
    places = sorted((one.q["theta"], one.q["s"], one.limits["s"]) for one in found)
    expected = [(0, -2, "maximum"), (0, 4, "maximum"), (np.pi, -4, "minimum"), (np.pi, 2, "minimum")]
    places.sort(key=lambda place: (round(place[0], 3), place[1]))
    for place, wanted in zip(places, expected, strict=True):
        assert place[:2] == pytest.approx(wanted[:2], abs=FOUND) and place[2] == wanted[2]
    assert {one.kind for one in found} == {"lock-up"} and {one.joint for one in found} == {"D"}
    assert sb.singular_configurations(SLIDER_CRANK, "theta", {"theta": ends}) == ()


def test_a_long_crank_locks() -> None:
    found = sb.singular_configurations(
        SLIDER_CRANK, "theta", {"theta": (-1, 1)}, parameters={"L1": 3, "L2": 1}
    )
    limit = np.arcsin(1 / 3)
    assert [one.q["theta"] for one in found] == pytest.approx([-limit, limit], abs=FOUND)
    assert [(one.kind, one.joint, one.limits["theta"]) for one in found] == [
        ("lock-up", "A", "minimum"), ("lock-up", "A", "maximum"),
    ]  # fmt: skip


def test_a_parallelogram_branches_where_it_is_flat() -> None:
    found = sb.singular_configurations(four_bar(1, 3, 1, 3), "theta", {"theta": (-1, 4)})
    assert [one.q["theta"] for one in found] == pytest.approx([0, np.pi], abs=FOUND)
    assert {(one.kind, one.joint) for one in found} == {("bifurcation", "C")}
    assert "branches cross" in str(found[0])


@pytest.mark.exhaustive
def test_a_kite_has_its_change_points() -> None:
    """s + l = p + q: the bars lie in a line at theta = 0 and pi."""
    found = sb.singular_configurations(four_bar(2, 2, 1.5, 1.5), "theta", {"theta": (-1, 4)})
    assert [one.q["theta"] for one in found] == pytest.approx([0, np.pi], abs=FOUND)
    assert {one.kind for one in found} == {"bifurcation"}


@pytest.mark.parametrize(
    "over", [{"theta": 0.3}, {"C": (0, 1)}, {"theta": (1, 0)}, {"theta": (0, 1), "s": 3.0}]
)
def test_ranges_that_make_no_sense_are_refused(over: dict[str, float | tuple[float, float]]) -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.singular_configurations(SLIDER_CRANK, "theta", over)
    assert all(problem.fix for problem in caught.value.problems)


def test_ranges_and_values_take_degrees_and_formulas() -> None:
    eqs = four_bar(1.0, 3.0, 2.5, 3.0)
    in_degrees = sb.trace_positions(eqs, {"theta": ["10 deg", "pi/9", 0.5]})
    plain = sb.trace_positions(eqs, {"theta": [np.radians(10), np.pi / 9, 0.5]})
    np.testing.assert_allclose(in_degrees.q, plain.q, atol=1e-9)
    places = sb.singular_configurations(eqs, "phi", over={"theta": ("0 deg", "360 deg")})
    same = sb.singular_configurations(eqs, "phi", over={"theta": (0, 2 * np.pi)})
    assert len(places) == len(same) == 4
    for one, other in zip(places, same, strict=True):
        assert one.q["theta"] == pytest.approx(other.q["theta"], abs=1e-6)
    with pytest.raises(sb.ExpressionError, match="over theta"):
        sb.trace_positions(eqs, {"theta": ["10 dg"]})


def test_places_that_cannot_be_reached_from_each_other_are_told_apart() -> None:
    """A crank-rocker has two assemblies, and in each the rocker has two dead positions."""
    eqs = four_bar(1.0, 3.0, 2.5, 3.0)
    places = sb.singular_configurations(eqs, "phi", over={"theta": (0, 2 * np.pi)})
    assert sorted(place.assembly for place in places) == [1, 1, 2, 2]
    for place in places:  # the rocker stays on its side of the ground
        near = [other for other in places if other.assembly == place.assembly]
        assert len({np.sign(np.sin(other.q["phi"])) for other in near}) == 1
        assert str(place).endswith(f", in assembly {place.assembly}")
