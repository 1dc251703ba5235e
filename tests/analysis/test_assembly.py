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
    assert "a gap of 1 m" in problem.what


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
    assert f"joint near cannot be closed: a gap of {gap:.3g} m" in str(caught.value)
    assert f"joint far has a gap of {gap:.3g} m" in str(caught.value)


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


def test_as_many_first_values_as_freedoms_are_kept() -> None:
    # Cranks of 0.13 and 0.29 m, a coupler of 0.41 m: the crank turns round, so that any theta closes. From
    # the other angles, which are 0, the nearest closed configuration lies 1.1 rad away from 20 degrees.
    model = four_bar_of_rods({"theta": "20 deg", "theta_dot": 15})
    eqs = sb.form_equations(model)
    state = sb.assemble(eqs)
    assert state.q["theta"] == pytest.approx(math.radians(20), abs=EPS)
    assert state.u["theta_dot"] == 15.0 and "theta" not in state.moved
    run = sb.simulate(eqs, 0.01)
    assert run["theta"][0] == state.q["theta"] and not any("instead of" in note for note in run.notes)
    sweep = sb.sweep(eqs, 0.01, {"m": [1.0, 2.0]})
    assert [sweep.trajectory(k)["theta"][0] for k in (0, 1)] == [state.q["theta"]] * 2


def test_more_first_values_than_freedoms_are_guesses() -> None:
    eqs = sb.form_equations(four_bar_of_rods({"theta": "20 deg", "phi": "30 deg"}))
    assert "theta" in sb.assemble(eqs).moved
    assert "theta" not in sb.assemble(eqs, {"theta": "20 deg"}).moved
    assert sb.assemble(eqs, {"phi": "100 deg"}).q["phi"] == pytest.approx(math.radians(100), abs=EPS)


def test_first_values_at_which_the_loops_do_not_close_are_guesses() -> None:
    eqs = sb.form_equations(four_bar_of_rods({"phi": "10 deg"}))
    assert abs(sb.assemble(eqs).moved["phi"]) > 0.1  # the rocker does not come there


def test_first_values_that_fit_are_kept_though_they_are_more_than_the_freedoms() -> None:
    eqs = sb.form_equations(three_cranks({"ta": "60 deg", "tb": "c"}))
    state = sb.assemble(eqs)
    assert state.q["ta"] == state.q["tb"] == pytest.approx(math.radians(60), abs=EPS)
    cases = sb.sweep(eqs, 0.01, parameters={"c": [math.pi / 3, 1.0]}, times=[0.0])
    assert cases["ta"][0, 0] == pytest.approx(math.radians(60), abs=EPS)
    apart = sb.assemble(eqs, parameters={"c": 1.0})  # angles that do not fit are guesses
    assert cases["ta"][1, 0] == pytest.approx(apart.q["ta"], abs=1e-9)
    assert math.cos(apart.q["ta"] - apart.q["tb"]) == pytest.approx(1.0)


def test_a_first_value_is_kept_where_constraints_repeat_others() -> None:
    eqs = sb.form_equations(three_cranks({"ta": "60 deg"}))
    assert eqs.degrees_of_freedom == 1
    assert sb.assemble(eqs).q["ta"] == pytest.approx(math.radians(60), abs=EPS)


def three_cranks(initial: dict[str, str]) -> sb.Model:
    bar = sb.Body("Bar", mass=1, frames={name: sb.Frame(at=(k - 1, 0, 0)) for k, name in enumerate("abc")})
    parts: list[sb.Element] = [bar]
    for name in "abc":
        parts += [
            sb.Body(f"K{name}", mass=0.2, inertia=(0, 0, 0.01), frames={"q": sb.Frame(at=(0.5, 0, 0))}),
            sb.Revolute(f"p{name}", f"ground.{name}", f"K{name}", axis="z", coordinate=f"t{name}"),
            sb.Revolute(f"q{name}", f"K{name}.q", f"Bar.{name}", axis="z", tree=name == "a"),
        ]
    values = {"c": math.pi / 3}
    return sb.Model("three cranks", parts, ground=dict(bar.frames), parameters=values, initial=initial)


def four_bar_of_rods(initial: dict[str, str | float]) -> sb.Model:
    lengths = {"Crank": 0.13, "Coupler": 0.41, "Rocker": 0.29}
    bodies = [
        sb.Body(name, mass="m", inertia=(0, 0, 0.01), frames={"end": sb.Frame(at=(length, 0, 0))})
        for name, length in lengths.items()
    ]
    joints = [
        sb.Revolute("O", "ground", "Crank", axis="z", coordinate="theta"),
        sb.Revolute("A", "Crank.end", "Coupler", axis="z", coordinate="beta"),
        sb.Revolute("C", "ground.C", "Rocker", axis="z", coordinate="phi"),
        sb.Revolute("B", "Coupler.end", "Rocker.end", axis="z"),
    ]
    ground = {"C": sb.Frame(at=(0.35, 0.06, 0))}
    return sb.Model("rods", [*bodies, *joints], ground=ground, parameters={"m": 1.0}, initial=initial)
