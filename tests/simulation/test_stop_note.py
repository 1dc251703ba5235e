"""What is noted of a motion that ended early."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.native.run import RawRun, Statistics
from symbody.simulation.results.checks import stop_note
from symbody.simulation.simulation_problem import SimulationProblem

EXAMPLES = Path(__file__).parents[2] / "examples"


def slider_crank(crank_mass: float, rod: float = 3.0) -> sb.EquationSet:
    bodies = [
        sb.Body("Crank", mass=crank_mass, inertia=(0, 0, 0), frames={"B": sb.Frame(at=(1, 0, 0))}),
        sb.Body("Rod", mass=0, inertia=(0, 0, 0), frames={"C": sb.Frame(at=(rod, 0, 0))}),
        sb.Body("Slider", mass=1),
    ]
    joints = [
        sb.Revolute("A", "ground", "Crank", coordinate="theta"),
        sb.Revolute("B", "Crank.B", "Rod", coordinate="beta"),
        sb.Revolute("C", "Rod.C", "Slider", tree=False),
        sb.Prismatic("D", "ground", "Slider", coordinate="s"),
    ]
    return sb.form_equations(sb.Model("slider-crank", [*bodies, *joints]))


def stopped(eqs: sb.EquationSet, q: list[float], status: sb.Status) -> str:
    """Return the note of a run of two samples that ended at q."""
    problem = SimulationProblem(eqs, {}, input_laws((), {}, (0.0, 1.0)), mechanism_scales(eqs, {}))
    n_u = len(eqs.speed_names)
    start = np.array([*np.zeros(n_u), 0.3, -0.4, 3.9, 0.0])
    end = np.array([*np.zeros(n_u), *q, 0.0])
    raw = RawRun(
        np.array([0.0, 0.5]), np.array([start, end]).T, status, Statistics(1, 0, 1, 0.0), 0.5, 0, None, None
    )
    return stop_note(problem, raw)


def test_at_a_dead_centre_no_mass_resists_a_massless_crank() -> None:
    # On the line the slider rests whatever the crank does: theta and beta = -4/3 theta move alone.
    note = stopped(slider_crank(0.0), [0.0, 0.0, 4.0], sb.Status.SINGULAR)
    assert "known up to t = 0.5 s" in note and "the motion of theta, beta has no mass" in note
    with pytest.raises(sb.SimulationError) as caught:
        sb.assemble(slider_crank(0.0), {"theta": 0.0}, {"s": 4.0})
    assert [(p.code, p.where) for p in caught.value.problems] == [("numerics.singular_mass", "theta, beta")]


def test_dependent_constraints_are_told_with_the_freedoms_they_leave() -> None:
    # With a rod of the crank's length, folded back, joint C is at the pivot: theta turns with s at rest, and
    # with theta + beta upright s moves alone.
    eqs = slider_crank(1.0, 1.0)
    upright = stopped(eqs, [np.pi / 2, np.pi, 0.0], sb.Status.STEP_COLLAPSE)
    assert "the constraints of joint C become dependent" in upright
    assert "2 degrees of freedom are there instead of 1" in upright
    ordinary = stopped(eqs, [0.3, -0.6, 2 * np.cos(0.3)], sb.Status.STEP_COLLAPSE)
    assert ordinary.endswith("there theta_dot changes too fast")
    assert "dependent" not in stopped(eqs, [np.pi / 2, np.pi, 0.0], sb.Status.INTERRUPTED)


def test_a_success_needs_no_note() -> None:
    eqs = slider_crank(1.0)
    run = sb.simulate(eqs, 0.1, {"theta": 0.3}, guess={"s": 3.9})
    assert run.success and not any("known up to" in note for note in run.notes)
    assert replace(run.statistics, rejected=None).rejected is None


def test_where_constraints_follow_from_others_partition_goes_on_or_is_named() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "gallery" / "drives" / "cycloid_drive.toml"))
    # Whether steps collapse where a row vanishes hangs on rounding; a motion is right, or the note has the cure.
    run, held = sb.simulate(eqs, 2.4), sb.simulate(eqs, 2.4, constraints=sb.Baumgarte(50.0))
    assert run.status is sb.Status.SUCCESS
    for motion, note in (
        (run, "sb.Partition() integrates the motion"),
        (held, "sb.Partition() may pass this position"),
    ):
        assert motion.success or any(note in each for each in motion.notes)
        assert not motion.success or motion["psi"][-1] == pytest.approx(-0.2 * np.pi * 2.4, abs=1e-6)


def test_steps_of_a_given_length_end_closed_where_other_constraints_count() -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "gallery" / "drives" / "cycloid_drive.toml"))
    run = sb.simulate(eqs, 3.0, integrator=sb.FixedStep(2e-3))
    # At t = 2.5 s a row vanishes. Whether a step ends there hangs on its rounding.
    assert run["psi"] == pytest.approx(-0.2 * np.pi * run.t, abs=1e-6)
    assert run.success or any("or use sb.Partition()" in note for note in run.notes)
    assert not any("identical to the last digit" in note for note in run.notes)


def test_a_corner_in_the_balance_of_a_massless_foot_is_named() -> None:
    leg = sb.Drive(applied="-k*(l+0.5)")
    elements = [
        sb.Body("Trunk", mass=1.0),
        sb.Body("Foot"),
        sb.Prismatic("lift", "ground", "Trunk", axis="y", coordinate="y"),
        sb.Prismatic("leg", "Trunk", "Foot", axis="y", coordinate="l", force=leg),
        sb.Force("ground contact", "Foot", (0, "if(y + l < 0, -K*(y + l), 0)", 0)),
    ]
    values = {"k": 1000.0, "K": 1e5}
    eqs = sb.form_equations(sb.Model("hopper", elements, gravity=(0, -9.81, 0), parameters=values))
    run = sb.simulate(eqs, 1.0, {"y": 0.5, "y_dot": -1.0})
    assert run.status is sb.Status.STEP_COLLAPSE
    assert "l has no mass" in run.notes[-1] and "put a damper along it" in run.notes[-1]
