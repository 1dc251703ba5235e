"""Assembly: closed loops, fixed values, branches, and what is said when nothing fits."""

from __future__ import annotations

import math

import numpy as np
import pytest

import symbody as sb
from symbody.analysis import state as state_module
from tests.problems.mechanisms import equations_of

EPS = np.finfo(float).eps


def slider_crank(**parameters: float) -> sb.Model:
    crank = sb.Body("Crank", mass=1, inertia=(0, 0, 0.1), frames={"B": sb.Frame(at=("L1", 0, 0))})
    rod = sb.Body("Rod", mass=1, inertia=(0, 0, 0.1), frames={"C": sb.Frame(at=("L2", 0, 0))})
    return sb.Model(
        "slider-crank",
        [
            crank,
            rod,
            sb.Body("Slider", mass=1),
            sb.Revolute("A", "ground", "Crank", coordinate="theta"),
            sb.Revolute("B", "Crank.B", "Rod", coordinate="beta"),
            sb.Revolute("C", "Rod.C", "Slider", tree=False),
            sb.Prismatic("D", "ground", "Slider", coordinate="s"),
        ],
        parameters={"L1": 1, "L2": 3} | parameters,
    )


def test_positions_and_velocities_follow_from_one_angle() -> None:
    state = sb.assemble(sb.form_equations(slider_crank()), {"theta": 0.7, "theta_dot": 2.0})
    s, root = state.q["s"], math.sqrt(9 - math.sin(0.7) ** 2)
    assert state.q["theta"] == 0.7
    # Closed form: s = cos(theta) + sqrt(9 - sin^2); rounding of some sums below 4.
    assert s == pytest.approx(math.cos(0.7) + root, abs=20 * EPS)
    s_dot = -2.0 * math.sin(0.7) - 2.0 * math.sin(0.7) * math.cos(0.7) / root
    assert state.u["s_dot"] == pytest.approx(s_dot, abs=50 * EPS)
    assert state.residual < 20 * EPS
    assert state["s"] == s and state["2*s"] == 2 * s


@pytest.mark.parametrize("unit", [1e-6, 1e3, 1e6])
@pytest.mark.parametrize("theta", [0.3, 0.7, 1.1, 2.0])
def test_velocities_in_any_unit_of_length(unit: float, theta: float) -> None:
    eqs = sb.form_equations(slider_crank(L1=unit, L2=3 * unit))
    state = sb.assemble(eqs, {"theta": theta, "theta_dot": 30.0}, {"s": 4.0 * unit})
    root = math.sqrt(9 - math.sin(theta) ** 2)
    s_dot = -30.0 * math.sin(theta) * (1.0 + math.cos(theta) / root) * unit
    # The loop is closed to some eps, and speeds are a few sums of what follows from it.
    assert state.u["theta_dot"] == pytest.approx(30.0, rel=10 * EPS)
    assert state.u["s_dot"] == pytest.approx(s_dot, rel=50 * EPS)
    with pytest.raises(sb.AssemblyError, match="theta_dot = 30, s_dot ="):
        sb.assemble(eqs, {"theta": theta, "theta_dot": 30.0, "s_dot": s_dot * 1.001}, {"s": 4.0 * unit})


def test_other_assemblies_are_listed() -> None:
    state = sb.assemble(sb.form_equations(slider_crank()), {"theta": 0.7}, {"s": 4.0})
    (other,) = state.branches
    root = math.sqrt(9 - math.sin(0.7) ** 2)
    assert other.q["s"] == pytest.approx(math.cos(0.7) - root, abs=1e-12)


def test_the_guess_chooses_the_branch() -> None:
    eqs = sb.form_equations(slider_crank())
    assert (
        sb.assemble(eqs, {"theta": 0.7}, {"s": -2, "beta": 2.0}).q["s"]
        < 0
        < sb.assemble(eqs, {"theta": 0.7}).q["s"]
    )


def test_a_measured_coordinate_can_be_fixed() -> None:
    eqs = sb.form_equations(slider_crank())
    state = sb.assemble(eqs, {"C": 0.2}, {"theta": 0.5})
    assert state["C"] == pytest.approx(0.2, abs=1e-9)
    assert abs(state.residual) < 1e-12


def test_independent_speeds_not_given_are_zero() -> None:
    state = sb.assemble(sb.form_equations(slider_crank()), {"theta": 0.3})
    assert set(state.u.values()) == {0.0}


def test_conflicting_values_are_named() -> None:
    eqs = sb.form_equations(slider_crank())
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs, {"theta": 0.7, "s": 3.9, "theta_dot": 1.0})
    (problem,) = caught.value.problems
    assert problem.code == "assembly.conflict" and "theta = 0.7, s = 3.9" in problem.what
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs, {"theta": 0.7, "theta_dot": 1.0, "s_dot": 1.0})
    assert caught.value.problems[0].code == "assembly.velocity_conflict"


def test_a_loop_that_cannot_close_names_joint_and_distance() -> None:
    # An offset of the slider's line by 5 m is out of reach of 1 m + 3 m.
    model = slider_crank()
    elements = [e for e in model.elements if e.name != "D"]
    lifted = sb.Model("far", [*elements, sb.Prismatic("D", "ground.line", "Slider", coordinate="s")],
                      parameters={"L1": 1, "L2": 3}, ground={"line": sb.Frame(at=(0, 5, 0))})  # fmt: skip
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(sb.form_equations(lifted), {})
    (problem,) = caught.value.problems
    assert problem.code == "assembly.open" and problem.where == "joint C"
    assert "open by 1 m" in problem.what


def test_unknown_names_are_refused_with_the_nearest() -> None:
    with pytest.raises(sb.AssemblyError, match="theta"):
        sb.assemble(sb.form_equations(slider_crank()), {"thete": 1})


def test_a_tree_is_taken_as_it_is() -> None:
    body = sb.Body("B", mass=1, inertia=(0, 0, 1))
    eqs = sb.form_equations(
        sb.Model("tree", [sb.Revolute("a", "ground", body, coordinate="x")], initial={"x": 0.5})
    )
    state = sb.assemble(eqs, {"x_dot": 2})
    assert dict(state.q) == {"x": 0.5} and dict(state.u) == {"x_dot": 2.0} and state.branches == ()


def test_what_a_state_computes_is_compiled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    state = sb.assemble(sb.form_equations(slider_crank()), {"theta": 0.7}, {"s": 4.0})
    formed: list[tuple[str, ...]] = []
    bound_function = state_module.bound_function

    def counted(eqs: sb.EquationSet, outputs: tuple[str, ...], *rest: object, **choices: object) -> object:
        formed.append(outputs)
        return bound_function(eqs, outputs, *rest, **choices)

    monkeypatch.setattr(state_module, "bound_function", counted)
    energies = {other["s + beta"] for other in (state, state, *state.branches)}
    assert formed == [("s + beta",)] and len(energies) == 1 + len(state.branches)


def test_guessed_rates_that_are_no_speeds_are_told_when_they_move() -> None:
    """Rates of a quaternion follow from the angular velocity: q' = q (0, w) / 2, here (0, 0.5, 0, 0) at q = 1."""
    eqs = sb.form_equations(sb.Model("free", [sb.Body("B", mass=1, inertia=(1, 1, 1))]))
    spin = next(name for name in eqs.speed_names if eqs.units[name] == "rad/s")
    state = sb.assemble(eqs, {spin: 1.0}, {"B_qx_dot": 2.0})
    assert dict(state.moved) == {"B_qx_dot": pytest.approx(-1.5, abs=4 * EPS)}


@pytest.mark.parametrize("reach", [(0.0, 0.0, 2.0), (1.0, 0.0, 2.0), (-3.0, 0.0, 0.0)])
def test_a_body_is_rigid_where_its_ends_stay_open(reach: tuple[float, float, float]) -> None:
    """A body of 1 m between two balls points from one to the other; both are open by half of what is missing."""
    body = sb.Body("B", mass=1, inertia=(1, 1, 1), frames={"far": sb.Frame(at=(0, 0, 1))})
    joints = [
        sb.Spherical("near", "ground", "B", tree=False),
        sb.Spherical("far", "ground.far", "B.far", tree=False),
    ]
    eqs = sb.form_equations(sb.Model("rod", [body, *joints], ground={"far": sb.Frame(at=reach)}))
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs)
    gap = (math.hypot(*reach) - 1.0) / 2.0
    assert f"joint near stays open by {gap:.3g} m" in str(caught.value)
    assert f"joint far by {gap:.3g} m" in str(caught.value)


def test_antiparallel_axes_are_no_assembly() -> None:
    # The wheel's axle must point along z; its mirror image closes the dot products too.
    a = sb.Body("A", mass=1, inertia=(1, 1, 1))
    model = sb.Model("turned", [sb.Revolute("hinge", "ground", a, tree=False)])
    eqs = sb.form_equations(model, tree="absolute")
    for w in (0.0, 0.05):
        guess = {"A_qw": w, "A_qx": 1.0, "A_qy": 0.1, "A_qz": 0.1}
        state = sb.assemble(eqs, {}, guess)
        assert np.asarray(state["frame R A ground"])[2, 2] == pytest.approx(1.0, abs=1e-12)


def test_fixed_quaternions_are_units_or_refused() -> None:
    eqs = sb.form_equations(sb.Model("free", [sb.Body("B", mass=1, inertia=(1, 1, 1))]))
    names = ("B_qw", "B_qx", "B_qy", "B_qz")
    state = sb.assemble(eqs, dict(zip(names, (2.0, 0.0, 0.0, 2.0), strict=True)))
    assert [state.q[name] for name in names] == pytest.approx(
        [math.sqrt(0.5), 0, 0, math.sqrt(0.5)], abs=2 * EPS
    )
    state = sb.assemble(eqs, {"B_qx": 0.6})
    assert [state.q[name] for name in names] == pytest.approx([0.8, 0.6, 0, 0], abs=2 * EPS)
    assert sb.assemble(eqs, {"B_qw": 0.0}).q["B_qw"] == 0.0
    for fixed in (dict.fromkeys(names, 0.0), {"B_qw": 1.1}):
        with pytest.raises(sb.AssemblyError) as caught:
            sb.assemble(eqs, fixed)
        assert caught.value.problems[0].code == "assembly.quaternion"


def test_guessed_rates_of_cut_joints_are_asked_before_what_the_file_says() -> None:
    """The slider's rate is no speed where bodies are free; the file starts the crank with another."""
    model = equations_of("slider_crank").model
    for tree in ("joints", "absolute"):
        eqs = sb.form_equations(model, tree=tree)
        state = sb.assemble(eqs, {"theta": 0.6}, guess={"s_dot": -0.3, "theta_dot": 7.0})
        rates = [sb.compile(eqs, name)(0.0, [*state.q.values()], [*state.u.values()], [0.0])
                 for name in ("s_dot", "theta_dot")]  # fmt: skip
        whole = sb.assemble(eqs, {"theta": 0.6, "theta_dot": 1.0})
        ratio = float(sb.compile(eqs, "s_dot")(0.0, [*whole.q.values()], [*whole.u.values()], [0.0]))
        assert rates[0] == pytest.approx(-0.3, rel=1e-12)
        assert rates[1] == pytest.approx(-0.3 / ratio, rel=1e-12)
        assert state.moved["theta_dot"] == pytest.approx(rates[1] - 7.0, rel=1e-12)
