"""Independent coordinates: constraints to rounding, another choice when a pivot wears out."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from tests.simulation.loops import damped_slider, example, held_pendulum, overstretched, turning_pendulum


def test_constraints_hold_to_rounding_at_every_step() -> None:
    run = sb.simulate(example("slider_crank"), 2.0, constraints=sb.Partition())
    assert run.success
    # Lengths of 1 m, each a sum of four products.
    assert run["constraint_violation"].max() < 1e-14
    # The crank makes more than one turn and the work of gravity returns: energy of some 10 J to the tolerance.
    assert np.ptp(run["energy"] - run["work"]) < 1e-6


def test_a_full_turn_needs_another_choice() -> None:
    """Of x and y of a turning pendulum neither is independent all the way round."""
    eqs = held_pendulum()
    run = sb.simulate(eqs, 5.0, {"theta": 0.0, "theta_dot": 9.0}, constraints=sb.Partition(worst=0.5))
    reference = sb.simulate(
        turning_pendulum(), 5.0, {"theta": 0.0, "theta_dot": 9.0}, times=run.t, rtol=1e-12
    )
    assert run.success and run["theta"][-1] > 2.0 * np.pi
    assert run["constraint_violation"].max() < 1e-14
    # Some 300 steps with 1e-8 each, angles that grow by a factor of ten.
    assert np.abs(run["theta"] - reference["theta"]).max() < 3e-5
    assert np.abs(run["x"] - np.sin(reference["theta"])).max() < 3e-5


def test_samples_and_dense_output_lie_on_the_motion() -> None:
    times = np.linspace(0.0, 2.0, 21)
    run = sb.simulate(held_pendulum(), 2.0, times=times, constraints=sb.Partition())
    reference = sb.simulate(turning_pendulum(), 2.0, rtol=1e-12)
    assert (run.t == times).all()
    assert run["constraint_violation"].max() <= 1e-10
    assert np.abs(run["theta"] - reference.at(times).q[0]).max() < 1e-6
    inside = np.linspace(0.0, 2.0, 77)
    assert np.abs(run.at(inside).q[-1] - reference.at(inside).q[0]).max() < 1e-6


def test_steps_in_vain_are_counted() -> None:
    run = sb.simulate(example("slider_crank"), 2.0, constraints=sb.Partition())
    spent = run.statistics
    assert spent.rejected is not None and spent.rejected > 0
    changes = sum("other independent coordinates" in note for note in run.notes)
    # Eleven stages a step, tried or taken; at the end of one that is taken two, before and after it is closed,
    # three more for its polynomial; two to begin.
    least = 11 * (spent.accepted + spent.rejected) + 5 * spent.accepted + 2
    assert spent.evaluations == least or changes
    assert spent.evaluations >= least


def test_trees_are_integrated_as_they_are() -> None:
    run = sb.simulate(turning_pendulum(), 1.0, constraints=sb.Partition())
    plain = sb.simulate(turning_pendulum(), 1.0)
    assert run.success and (run.q == plain.q).all() and (run.u == plain.u).all()


def test_events() -> None:
    stop = sb.Event("x", direction=-1, action="stop")
    run = sb.simulate(held_pendulum(), 3.0, constraints=sb.Partition(), events=stop)
    reference = sb.simulate(
        turning_pendulum(), 3.0, events=sb.Event("theta", direction=-1, action="stop"), rtol=1e-11
    )
    assert run.status is sb.Status.STOPPED
    assert abs(run.t[-1] - reference.t[-1]) < 1e-7


@pytest.mark.parametrize("constraints", [None, sb.Partition()])
def test_samples_and_events_on_the_way_past_change_points(constraints: sb.Partition | None) -> None:
    """A parallelogram braked by a held torque, past flat poses: both cranks turn alike, the rod does not.

    So ``(2 I + M r^2) a'' = T`` without gravity, and a torque held for h takes the share 0.3 h / inertia.
    """
    at = {"tip": sb.Frame(at=(1, 0, 0))}
    cranks = [sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1), frames=at) for name in ("A", "D")]
    rod = sb.Body("Rod", mass=2, inertia=(0.2, 0.2, 0.2), frames={"end": sb.Frame(at=(2, 0, 0))})
    joints = [
        sb.Revolute("J0", "ground", "A", coordinate="a"),
        sb.Revolute("J1", "A.tip", "Rod", coordinate="b"),
        sb.Revolute("J2", "ground.post", "D", coordinate="d", torque=sb.Drive(applied="brake")),
        sb.Revolute("J3", "D.tip", "Rod.end", tree=False),
    ]
    brake = sb.Signal("brake", "-0.3*a_dot", sample=0.05)
    post = {"post": sb.Frame(at=(2, 0, 0))}
    eqs = sb.form_equations(sb.Model("held", [*cranks, rod, *joints, brake], ground=post))
    run = sb.simulate(
        eqs, 2.0, {"a": 1.0, "a_dot": 8.0}, guess={"b": -1.0, "d": 1.0}, constraints=constraints,
        events=sb.Event("sin(a)", name="flat"),
    )  # fmt: skip
    assert run.success, run.notes
    assert np.abs(run["a"] - run["d"]).max() < 1e-8
    assert len(run.events) == int((run["a"][-1]) // np.pi) and len(run.events) > 3
    assert run.held_values is not None
    inertia = 2 * 0.1 + 2 * 1.0**2
    speeds = 8.0 * (1.0 - 0.3 * 0.05 / inertia) ** np.arange(41)
    np.testing.assert_allclose(run.held_values.values[0], -0.3 * speeds, rtol=1e-6)


def test_nothing_moves_beyond_a_lock_up() -> None:
    """There a constraint follows from others, to rounding; it still has to hold."""
    guess = {"theta": 0.7, "beta": -1.4, "y": -1e-4}
    run = sb.simulate(overstretched(), 1.0, guess=guess, constraints=sb.Partition(), max_steps=300)
    assert run.status is sb.Status.STEP_COLLAPSE and any("locks" in note for note in run.notes)
    # Rates grow as the root of the time that is left, so that it is rounding that ends the motion.
    assert abs(run.t[-1] - 0.5) < 1e-8
    assert run["constraint_violation"].max() < 1e-14


def test_limits() -> None:
    run = sb.simulate(held_pendulum(), 3.0, constraints=sb.Partition(), max_steps=3)
    assert run.status is sb.Status.TOO_MANY_STEPS
    run = sb.simulate(held_pendulum(), 1.0, constraints=sb.Partition(), integrator=sb.Explicit(max_step=0.05))
    assert np.diff(run.t).max() <= 0.05 * (1.0 + 1e-9)


def test_what_makes_no_sense() -> None:
    with pytest.raises(sb.UsageError):
        sb.Partition(worst=1.0)
    with pytest.raises(sb.UsageError, match="sb.Explicit"):
        sb.simulate(held_pendulum(), 1.0, constraints=sb.Partition(), integrator=sb.Stiff())
    assert sb.simulate(damped_slider(), 1e-5, constraints=sb.Partition()).success
