"""Motions that move no mass: springs in series, a Maxwell element, what forces leave undetermined."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from tests.codegen.texts.running import ALL
from tests.codegen.texts.running import run as run_text
from tests.formulations import FORMULATIONS, name_of
from tests.spectra import assert_same_spectrum
from tests.tiers import cases

K1, K2, C, MASS = 4.0, 6.0, 2.0, 1.5
PARAMETERS = {"k1": K1, "k2": K2, "c": C, "m": MASS}


def slide(name: str, start: str, end: str, coordinate: str, **force: Any) -> sb.Prismatic:
    return sb.Prismatic(name, start, end, axis="x", coordinate=coordinate, force=sb.Drive(**force))


def model(
    *joints: sb.Prismatic | sb.SpringDamper, points: tuple[str, ...] = ("P",), **others: Any
) -> sb.Model:
    bodies = [*(sb.Body(name) for name in points), sb.Body("A", mass="m")]
    return sb.Model("light", [*bodies, *joints], parameters=PARAMETERS, **others)


def series(chained: bool, **others: Any) -> sb.Model:
    """Two springs in series, the mass on a slide from the point between them or from ground."""
    if chained:
        joints = [slide("s", "ground", "P", "p", stiffness="k1"), slide("t", "P", "A", "a", stiffness="k2")]
    else:
        joints = [slide("s", "ground", "P", "p", applied="-k1*p + k2*(a - p)"),
                  slide("t", "ground", "A", "a", applied="-k2*(a - p)")]  # fmt: skip
    return model(*joints, **others)


def maxwell(chained: bool, **others: Any) -> sb.Model:
    """A spring and a damper in series."""
    if chained:
        joints = [slide("s", "ground", "P", "p", stiffness="k1"), slide("t", "P", "A", "a", damping="c")]
    else:
        joints = [slide("s", "ground", "P", "p", applied="-k1*p + c*(a_dot - p_dot)"),
                  slide("t", "ground", "A", "a", applied="-c*(a_dot - p_dot)")]  # fmt: skip
    return model(*joints, **others)


def place(run: sb.Trajectory, chained: bool) -> Any:
    return run["p"] + run["a"] if chained else run["a"]


@pytest.mark.parametrize("chained", [True, False])
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=name_of)
def test_springs_in_series_are_one_spring(formulation: Any, chained: bool) -> None:
    eqs = sb.form_equations(series(chained, gravity=(9.81, 0, 0)), formulation)
    assert eqs.multiplier_names == ("balance_p",) and eqs.degrees_of_freedom == 1
    stiffness = K1 * K2 / (K1 + K2)
    rest, w = MASS * 9.81 / stiffness, np.sqrt(stiffness / MASS)
    run = sb.simulate(eqs, 3, {"a": 0.3}, rtol=1e-10)
    x = place(run, chained)
    assert x == pytest.approx(rest + (x[0] - rest) * np.cos(w * run.t), abs=2e-8)
    assert run["balance_p"] == pytest.approx(0, abs=1e-8)
    assert np.ptp(run["energy"] - run["work"]) < 1e-8
    at_rest = sb.find_equilibrium(eqs)
    assert place_of(at_rest.q, chained) == pytest.approx(rest, rel=1e-12)
    assert_same_spectrum(sb.linearize(eqs, at_rest).eigenvalues, [-1j * w, 1j * w], atol=1e-9)


def place_of(q: Any, chained: bool) -> float:
    return float(q["p"] + q["a"] if chained else q["a"])


def test_values_given_to_simulate_are_kept_and_those_of_the_model_are_near() -> None:
    eqs = sb.form_equations(series(True, initial={"a": 0.3}))
    kept = sb.simulate(eqs, 0.1, {"a": 0.3})
    assert kept["a"][0] == 0.3 and kept["p"][0] == pytest.approx(0.3 * K2 / K1) and not kept.notes
    near = sb.simulate(eqs, 0.1)
    assert near["p"][0] * K1 == pytest.approx(near["a"][0] * K2)
    assert any("forces on massless parts do not balance" in note for note in near.notes)


@pytest.mark.parametrize("chained", [True, False])
@pytest.mark.parametrize("formulation", FORMULATIONS, ids=name_of)
def test_a_maxwell_element_is_one_more_state_without_speed(formulation: Any, chained: bool) -> None:
    eqs = sb.form_equations(maxwell(chained), formulation)
    assert len(eqs.speed_names) == 1 and set(eqs.coordinate_names) == {"p", "a"}
    assert not eqs.multiplier_names and eqs.degrees_of_freedom == 1
    # m x'' = -k p, p' = x' - k p/c: poles of m s^2 + (m k/c) s + k, and the free place.
    poles = np.append(np.roots([MASS, MASS * K1 / C, K1]), 0)
    assert_same_spectrum(sb.linearize(eqs).eigenvalues, poles, atol=1e-9)
    run = sb.simulate(eqs, 3, {"p": 0.3}, rtol=1e-10)
    assert run["energy"] - run["energy"][0] == pytest.approx(run["work"], abs=1e-8)
    if chained:  # stiffness has a potential, a formula has power; either way the damper takes energy
        assert run["work"][-1] < -0.1
    name = next(name for name in ("p_dot", "a_dot") if name not in eqs.speed_names)
    slip = run["a_dot"] if chained else run["a_dot"] - run["p_dot"]
    assert C * slip == pytest.approx(K1 * run["p"], abs=1e-12)
    assert any(name in note and "balance of forces" in note for note in eqs.notes)


@pytest.mark.parametrize("chained", [True, False])
def test_a_maxwell_element_that_is_held_relaxes(chained: bool) -> None:
    """Its end held at 1 from when the spring is stretched by all of it: the force falls as exp(-k t/c)."""
    if chained:
        joints = [slide("s", "ground", "P", "p", stiffness="k1"),
                  sb.Prismatic("t", "ground", "A", axis="x", coordinate="a", motion="1")]  # fmt: skip
        damper = [sb.SpringDamper("d", "P", "A", damping="c")]
    else:
        joints = [slide("s", "ground", "P", "p", applied="-k1*p - c*p_dot")]
        damper = []
    bodies = [sb.Body("P"), *([sb.Body("A", mass=1)] if chained else [])]
    eqs = sb.form_equations(sb.Model("held", [*bodies, *joints, *damper], parameters=PARAMETERS))
    assert eqs.speed_names == () and eqs.coordinate_names == ("p",)
    run = sb.simulate(eqs, 2, {"p": 0.5}, rtol=1e-10)
    assert run.success
    assert run["p"] == pytest.approx(0.5 * np.exp(-K1 / C * run.t), rel=1e-8)


def test_the_standard_linear_solid_responds_as_its_transfer_function() -> None:
    control = pytest.importorskip("control", reason="python-control is not installed")
    joints = [slide("s", "ground", "P", "p", applied="-k1*p + c*(a_dot - p_dot)"),
              slide("t", "ground", "A", "a", applied="F - k2*a - c*(a_dot - p_dot)")]  # fmt: skip
    eqs = sb.form_equations(model(*joints, inputs=("F",)))
    # Z(s) = k2 + k1 c s/(k1 + c s), x = F/(m s^2 + Z)
    system = control.tf([C, K1], [MASS * C, MASS * K1, K2 * C + K1 * C, K1 * K2])
    times = np.linspace(0, 6, 61)
    response = control.step_response(system, times).outputs
    run = sb.simulate(eqs, 6, inputs={"F": 1}, rtol=1e-11, times=times)
    assert run["a"] == pytest.approx(np.ravel(response), abs=1e-8)
    lin = sb.linearize(eqs, outputs=["a"]).to_control()
    assert np.ravel(control.step_response(lin, times).outputs) == pytest.approx(np.ravel(response), abs=1e-9)


@pytest.mark.parametrize("joined", [False, True])
def test_points_with_and_without_dampers_in_series(joined: bool) -> None:
    """Spring, point, damper, point, spring, mass: one point is placed by springs, one is a state."""
    if (
        joined
    ):  # each point on a slide from ground: what the damper says has to be parted from what springs say
        joints = [slide("s", "ground", "P", "p", applied="-k1*p - c*(p_dot - r_dot)"),
                  slide("u", "ground", "R", "r", applied="c*(p_dot - r_dot) - k2*(r - a)"),
                  slide("t", "ground", "A", "a", applied="k2*(r - a)")]  # fmt: skip
    else:
        joints = [slide("s", "ground", "P", "p", stiffness="k1"), slide("u", "P", "R", "r", damping="c"),
                  slide("t", "R", "A", "a", stiffness="k2")]  # fmt: skip
    eqs = sb.form_equations(model(*joints, points=("P", "R")))
    assert len(eqs.speed_names) == 2 and len(eqs.multiplier_names) == 1
    k = K1 * K2 / (K1 + K2)
    poles = np.append(np.roots([MASS, MASS * k / C, k]), 0)
    assert_same_spectrum(sb.linearize(eqs).eigenvalues, poles, atol=1e-8)
    run = sb.simulate(eqs, 2, {"a": 0.4, "r": 0.1}, rtol=1e-10)
    assert run["energy"] - run["energy"][0] == pytest.approx(run["work"], abs=1e-7)


def test_a_wheel_without_inertia_in_a_shaft() -> None:
    """Turns as well: a motor's angle, a torsion spring, a wheel that only a damper holds, a spring, a disc."""
    turning = {"axis": "z"}
    joints = [
        sb.Revolute(
            "r", "ground", "Wheel", coordinate="p", torque=sb.Drive(stiffness="k1", damping="c"), **turning
        ),
        sb.Revolute("t", "ground", "Disc", coordinate="a", **turning),
    ]
    shaft = sb.TorsionSpring("shaft", "Wheel", "Disc", axis="z", stiffness="k2")
    bodies = [sb.Body("Wheel", mass=3), sb.Body("Disc", mass=3, inertia=(1, 1, "m"))]
    eqs = sb.form_equations(sb.Model("shaft", [*bodies, *joints, shaft], parameters=PARAMETERS))
    assert eqs.state_names == ("a_dot", "p", "a")
    # c p' = -k1 p - k2 (p - a), m a'' = k2 (p - a)
    poles = np.roots([MASS * C, MASS * (K1 + K2), K2 * C, K1 * K2])
    assert_same_spectrum(sb.linearize(eqs).eigenvalues, poles, atol=1e-9)


@pytest.mark.parametrize(
    ("force", "words", "cure"),
    [
        ({}, "no spring or damper that acts along it", "put a spring or a damper"),
        ({"applied": "-p_dot^3 - p"}, "not linear in the rates", "give mass"),
        ({"stiffness": 1, "applied": "F"}, "second derivatives", "put a damper beside the spring"),
        ({"applied": "2"}, "no spring or damper that acts along it", "put a spring or a damper"),
    ],
)  # fmt: skip
def test_what_forces_do_not_determine_is_refused(force: dict[str, Any], words: str, cure: str) -> None:
    joints = [slide("s", "ground", "P", "p", **force), slide("t", "ground", "A", "a", stiffness=1)]
    eqs = sb.form_equations(model(*joints, inputs=("F",)))
    assert eqs.speed_names == ("p_dot", "a_dot")
    with pytest.raises(sb.SymbodyError) as caught:
        sb.compile(eqs, "udot")
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("equations.massless", "speed p_dot")
    assert words in problem.why and cure in problem.fix


def test_dry_friction_and_relative_places_are_refused() -> None:
    rubbing = sb.Prismatic("s", "ground", "P", coordinate="p", force=sb.Drive(stiffness=1, damping=1),
                           friction=sb.Friction(mu=0.3))  # fmt: skip
    driven = slide("s", "ground", "P", "p", stiffness=1, damping=1, applied="F")
    for joint, start, words in ((rubbing, "ground", "dry friction"), (driven, "P", "relative to it")):
        eqs = sb.form_equations(model(joint, slide("t", start, "A", "a", stiffness=1), inputs=("F",)))
        with pytest.raises(sb.SymbodyError, match=words):
            sb.compile(eqs, "udot")


def test_a_damper_without_direction_does_not_determine_a_point() -> None:
    joints = [slide("s", "ground", "P", "p", stiffness="k1"), slide("t", "ground", "A", "a")]
    eqs = sb.form_equations(model(*joints, sb.SpringDamper("d", "P", "A", damping="c")))
    with pytest.raises(sb.SymbodyError) as caught:
        sb.simulate(eqs, 1.0)
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("assembly.massless", "speed p_dot")
    assert "into a joint" in problem.fix


@pytest.mark.parametrize(
    ("made", "zeros"),
    [
        (maxwell(True), {"c": 0}),
        (maxwell(False), {"c": 0}),
        (series(True), {"k1": 0, "k2": 0}),
        (series(False), {"k1": 0, "k2": 0}),
    ],
)
def test_parameters_that_leave_a_point_undetermined_are_refused(
    made: sb.Model, zeros: dict[str, float]
) -> None:
    with pytest.raises(sb.SymbodyError) as caught:
        sb.simulate(sb.form_equations(made), 1.0, {"a": 0.1}, parameters=zeros)
    problem = caught.value.problems[0]
    assert problem.code == "compile.massless"
    assert problem.where in ("p", "p_dot", "a_dot")


def test_inputs_and_signals_act_on_points_that_have_dampers() -> None:
    joints = [slide("s", "ground", "P", "p", damping="c", applied="F + i - k2*(p - a)"),
              slide("t", "ground", "A", "a", applied="k2*(p - a)")]  # fmt: skip
    signal = sb.Signal("i", rate="-i", initial=2)
    bodies = [sb.Body("P"), sb.Body("A", mass="m")]
    m = sb.Model("driven", [*bodies, *joints, signal], parameters=PARAMETERS, inputs=("F",))
    eqs = sb.form_equations(m)
    assert eqs.state_names == ("a_dot", "p", "a", "i")
    run = sb.simulate(eqs, 2, inputs={"F": "sin(3*t)"}, rtol=1e-10)
    force = np.sin(3 * run.t) + 2 * np.exp(-run.t) - K2 * (run["p"] - run["a"])
    assert C * run["p_dot"] == pytest.approx(force, abs=1e-8)


def test_equations_with_dependent_speeds_too() -> None:
    """A blade on a plane carries a light point: its constraint and the balance are eliminated together."""
    parts = [
        sb.Body("Sled", mass=2, inertia=(0, 0, 0.3), frames={"edge": sb.Frame(at=(-0.2, 0, 0))}),
        sb.Body("P"),
        sb.Planar("plane", "ground", "Sled", coordinates=("x", "y", "th")),
        slide("s", "Sled", "P", "p", stiffness=5, damping=1),
        sb.SpringDamper("pull", "ground", "P", stiffness=3, damping=0.4),
        sb.KnifeEdge("blade", "ground", "Sled.edge"),
    ]
    start = {"x": 1.0, "y": 0.4, "th": 0.3, "p": 0.2}
    m = sb.Model("sled", parts, initial=start)
    plain = sb.form_equations(m)
    fewer = sb.form_equations(m, dependent_speeds="auto")
    assert "p_dot" not in plain.speed_names and len(fewer.speed_names) == len(plain.speed_names) - 1
    a, b = (sb.simulate(eqs, 2, rtol=1e-10) for eqs in (plain, fewer))
    for name in start:
        assert b[name][-1] == pytest.approx(a[name][-1], abs=1e-7)
    assert b["lambda_blade_1"][-1] == pytest.approx(a["lambda_blade_1"][-1], abs=1e-6)


@pytest.mark.parametrize("make", [series, maxwell])
def test_source_text_sweeps_and_steppers_know_balances(make: Any) -> None:
    eqs = sb.form_equations(make(True))
    n, k = len(eqs.coordinate_names), len(eqs.speed_names)
    q, u = np.linspace(0.2, 0.5, n), np.linspace(-0.3, 0.1, k)
    space: dict[str, Any] = {}
    exec(sb.generate_code(eqs, "xdot", "python", parameters={}), space)  # our own text
    wanted = sb.compile(eqs, "xdot")(0.0, q, u)
    assert np.ravel(space["f"](0.0, q, u)) == pytest.approx(wanted, rel=1e-13)
    many = sb.sweep(eqs, 2, {"k1": [3.0, K1, 9.0]}, initial={"a": 0.2})
    one = sb.simulate(eqs, 2, {"a": 0.2}, rtol=1e-9)
    assert many.success
    stepper = sb.Stepper(eqs, 2.0, initial={"a": 0.2})
    stepper.step()
    assert stepper["p"] == pytest.approx(one["p"][-1], abs=1e-6)


@pytest.mark.parametrize(
    "constraints",
    cases(
        [sb.Projection(), sb.Baumgarte(), sb.GGL(), sb.Partition(), None], fast=lambda each: each != sb.GGL()
    ),
)
def test_balances_hold_by_every_method_for_constraints(constraints: Any) -> None:
    eqs = sb.form_equations(series(True))
    run = sb.simulate(eqs, 3, {"a": 0.2}, constraints=constraints, rtol=1e-9)
    assert run.success
    assert run["k1*p - k2*a"] == pytest.approx(0, abs=1e-6)
    w = np.sqrt(K1 * K2 / (K1 + K2) / MASS)
    total = run["p + a"]
    assert total == pytest.approx(total[0] * np.cos(w * run.t), abs=1e-5)


@pytest.mark.parametrize("language", ALL)
@pytest.mark.parametrize("make", [series, maxwell])
def test_every_language_computes_the_same(make: Any, language: str, tmp_path: Path) -> None:
    eqs = sb.form_equations(make(True))
    sequence, _ = form_sequence(eqs, ["xdot", "kinetic_energy"])
    q, u = [0.2, 0.5], [-0.3, 0.1][: len(eqs.speed_names)]
    (values,) = run_text(language, sequence, [{"t": [0.0], "q": q, "u": u}], tmp_path)
    wanted = np.append(*(np.atleast_1d(x) for x in sb.compile(eqs, ["xdot", "kinetic_energy"])(0.0, q, u)))
    assert values == pytest.approx(wanted, rel=1e-13)


def test_equilibria_hold_what_dampers_alone_resist() -> None:
    joints = [slide("s", "ground", "P", "p", stiffness="k1", damping="c", free=0.3),
              slide("t", "ground", "A", "a", stiffness="k2", applied="F")]  # fmt: skip
    spring = sb.SpringDamper("between", "P", "A", stiffness=3)
    bodies = [sb.Body("P"), sb.Body("A", mass="m")]
    m = sb.Model(
        "rest", [*bodies, *joints, spring], parameters=PARAMETERS, gravity=(9.81, 0, 0), inputs=("F",)
    )
    eqs = sb.form_equations(m)
    assert eqs.state_names == ("a_dot", "p", "a")
    wanted = np.linalg.solve([[K1 + 3, -3], [-3, K2 + 3]], [0.3 * K1, MASS * 9.81 + 2])
    found = sb.find_equilibrium(eqs, inputs={"F": 2})
    assert [found.q["p"], found.q["a"]] == pytest.approx(wanted, rel=1e-10)
    pull = sb.find_equilibrium(eqs, unknowns=["F"], fixed={"a": 1.0})
    assert pull.q["p"] == pytest.approx((0.3 * K1 + 3) / (K1 + 3), rel=1e-10)
    creeping = sb.form_equations(maxwell(False))
    with pytest.raises(sb.SymbodyError, match="equilibrium.none"):
        sb.find_equilibrium(creeping, fixed={"p": 0.3})


def test_inverse_dynamics_of_a_point_that_springs_place() -> None:
    joints = [slide("s", "ground", "P", "p", applied="-k1*p + k2*(a - p)"),
              slide("t", "ground", "A", "a", applied="F - k2*(a - p)")]  # fmt: skip
    times = np.linspace(0, 1, 5)
    eqs = sb.form_equations(model(*joints, inputs=("F",)))
    run = sb.inverse_dynamics(eqs, {"a": "sin(t)"}, ["F"], times=times)
    assert run["F"] == pytest.approx((K1 * K2 / (K1 + K2) - MASS) * np.sin(times), abs=1e-12)
    light = sb.form_equations(maxwell(False, inputs=("F",)))
    with pytest.raises(sb.SymbodyError, match="inverse.first_order"):
        sb.inverse_dynamics(light, {"a": "sin(t)"}, ["F"], times=times)


def test_inverse_dynamics_with_dependent_speeds_is_refused() -> None:
    parts = [
        sb.Body("Sled", mass=2, inertia=(0, 0, 0.3)),
        sb.Planar("plane", "ground", "Sled", coordinates=("x", "y", "th")),
        sb.KnifeEdge("blade", "ground", "Sled"),
        sb.Force("push", "Sled", ("F", 0, 0)),
    ]
    eqs = sb.form_equations(sb.Model("sled", parts, inputs=("F",)), dependent_speeds="auto")
    with pytest.raises(sb.SymbodyError, match="inverse.dependent_speeds"):
        sb.inverse_dynamics(eqs, {"x": "t"}, ["F"], times=[0.0, 1.0])


def test_a_joint_that_nothing_resists_is_told_with_a_cure() -> None:
    """A rod of a planar mechanism, by mistake on an axis about which it has no inertia."""
    rod = sb.Body("Rod", mass=1, inertia=(0, 0, 0.1), frames={"top": sb.Frame(at=(0, 0.5, 0))})
    pivot = sb.Revolute(
        "pivot", "ground", "Rod.top", axis="y", coordinate="phi", torque=sb.Drive(damping=0.1)
    )
    eqs = sb.form_equations(sb.Model("planar", [rod, pivot]))
    assert any(
        "phi_dot" in note and "give the body mass, or inertia about the axis" in note for note in eqs.notes
    )
    assert not any("prescribed" in note for note in sb.simulate(eqs, 1.0).notes)
