"""The fault checklist, E: constraints, initial conditions, configuration, rows 43 to 60."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import symbody as sb
from symbody.errors import AssemblyError, FormulationError, ModelError
from symbody.model.constraint import ConstraintElement
from tests.faults.refusals import refused, refused_file, refused_model
from tests.tiers import rows

EPS = np.finfo(float).eps
DOWN = (0, "-9.81", 0)
NORMAL, ALONG = (1, 2, 2), (0, math.sqrt(0.5), -math.sqrt(0.5))  # perpendicular, and no letters


@cache
def slider_crank(
    crank: float = 1, rod: float = 3, motion: str | None = None, as_constraint: bool = False
) -> sb.EquationSet:
    return sb.form_equations(
        sb.Model(
            "slider-crank",
            [
                sb.Body("Crank", mass=1, inertia=(0, 0, 0.1), frames={"B": sb.Frame(at=(crank, 0, 0))}),
                sb.Body("Rod", mass=1, inertia=(0, 0, 0.1), frames={"C": sb.Frame(at=(rod, 0, 0))}),
                sb.Body("Slider", mass=1),
                sb.Revolute("A", "ground", "Crank", coordinate="theta", motion=motion,
                            as_constraint=as_constraint, torque=None if motion else sb.Drive("T")),
                sb.Revolute("B", "Crank.B", "Rod", coordinate="beta"),
                sb.Revolute("C", "Rod.C", "Slider", tree=False),
                sb.Prismatic("D", "ground", "Slider", coordinate="s", force=sb.Drive("F")),
            ],
            inputs=["F"] if motion else ["T", "F"],
        )
    )  # fmt: skip


@cache
def parallelogram(
    base: float = 2, normal: tuple[float, ...] = (0, 0, 1), along: tuple[float, ...] = (1, 0, 0)
) -> sb.EquationSet:
    """Cranks of 1 m, a rod of 2 m; with a base of 2 m they all lie on one line at a change point."""
    bodies = [
        sb.Body(name, mass=1, inertia=(0.1, 0.1, 0.1),
                frames={"tip": sb.Frame(at=tuple(length * x for x in along))})
        for name, length in (("Crank", 1.0), ("Rod", 2.0), ("Rocker", 1.0))
    ]  # fmt: skip
    joints = [
        sb.Revolute("A", "ground", "Crank", axis=normal, coordinate="a"),
        sb.Revolute("B", "Crank.tip", "Rod", axis=normal, coordinate="b"),
        sb.Revolute("D", "ground.post", "Rocker", axis=normal, coordinate="d"),
        sb.Revolute("C", "Rod.tip", "Rocker.tip", axis=normal),
    ]
    ground = {"post": sb.Frame(at=tuple(base * x for x in along))}
    return sb.form_equations(sb.Model("parallelogram", [*bodies, *joints], ground=ground, gravity=DOWN))


@cache
def shaft(gap: float = 0.0, tree: bool = False) -> sb.EquationSet:
    """A shaft of 1 m in two hinges, the second of which stands farther by a gap."""
    body = sb.Body("Shaft", mass=1, inertia=(1, 1, 1), frames={"far": sb.Frame(at=(0, 0, 1))})
    hinges = [
        sb.Revolute("near", "ground", "Shaft", coordinate="a", tree=tree),
        sb.Revolute("far", "ground.far", "Shaft.far", tree=False),
    ]
    return sb.form_equations(sb.Model("shaft", [body, *hinges], ground={"far": sb.Frame(at=(0, 0, 1 + gap))}))


def two_sliders(height: float, motions: tuple[str | None, str | None] = (None, None)) -> sb.Model:
    """A body on two parallel slides; nothing lets it rise to the second."""
    return sb.Model(
        "slides",
        [
            sb.Body("B", mass=1),
            sb.Prismatic("p", "ground", "B", axis="x", coordinate="x", motion=motions[0]),
            sb.Prismatic("q", "ground.high", "B", axis="x", coordinate="z", motion=motions[1]),
        ],
        ground={"high": sb.Frame(at=(0, height, 0))},
    )


def test_row_43_a_duplicated_constraint_is_dropped_and_named() -> None:
    found = sb.redundancy(shaft())
    assert found.degrees_of_freedom == 1
    assert len(found.dropped) == 5 and set(found.kept).isdisjoint(found.dropped)
    assert {*found.kept, *found.dropped} == set(shaft().multiplier_names)
    run = sb.simulate(shaft(), 1.0, {"a_dot": 1.0})
    assert run.success and run["a"][-1] == pytest.approx(1.0, abs=1e-8)  # the tolerance of the run
    assert run["constraint_violation"].max() < 1e-9


def test_row_44_constraints_that_contradict_each_other() -> None:
    # x = 0 and x = 1
    assert refused(lambda: two_sliders(0.0, ("0", "1")), ModelError, "p, q") == [
        ("model.over_driven", "joint p, motion; joint q, motion")
    ]
    assert refused(lambda: shaft(0.1, True), FormulationError, "lambda_far_3 is the constant") == [
        ("equations.never_closed", "joint far")
    ]
    # With absolute coordinates only numbers tell; both hinges are equally open, either may be named.
    # In the sum of squares 0.1 m is least if each hinge has half of it; a body keeps its length.
    for attempt in (sb.assemble, lambda eqs: sb.simulate(eqs, 1.0)):
        told = "joint near cannot be closed: a gap of 0.05 m and 0 deg remains"
        assert refused(lambda attempt=attempt: attempt(shaft(0.1)), AssemblyError, told) == [
            ("assembly.open", "joint near")
        ]
    refused(lambda: sb.assemble(shaft(1.0)), AssemblyError, "joint far has a gap of 0.5 m and 0 deg")


def test_row_45_a_planar_mechanism_of_spatial_joints() -> None:
    flat = parallelogram()
    (note,) = [note for note in flat.notes if "hold identically" in note]
    assert "joint C: 3 closing equations" in note and "lambda_C_3, lambda_C_4, lambda_C_5" in note
    found = sb.redundancy(flat)
    assert (found.degrees_of_freedom, found.kept, found.dropped) == (1, ("lambda_C_1", "lambda_C_2"), ())
    assert found.instantaneous == 2  # initial values of 0 are its change point
    # In axes without letters what is idle is found by symbols or by numbers; either way it is told.
    tilted = parallelogram(normal=NORMAL, along=ALONG)
    told = " ".join(tilted.notes) + " ".join(sb.redundancy(tilted).dropped)
    found = sb.redundancy(tilted)
    assert found.degrees_of_freedom == 1 and len(found.kept) == 2
    assert all(f"lambda_C_{k}" in told for k in range(1, 6) if f"lambda_C_{k}" not in found.kept)


@pytest.mark.parametrize(
    ("integrator", "constraints"),
    rows(
        [(None, None), (sb.Stiff(), None), (sb.Stiff(), sb.GGL()), (None, sb.Partition())],
        fast=[(None, None), (sb.Stiff(), sb.GGL()), (None, sb.Partition())],
    ),
    ids=["explicit", "stiff", "GGL", "partition"],
)
def test_row_46_a_parallelogram_goes_through_its_change_points(
    integrator: sb.Stiff | None, constraints: sb.GGL | sb.Partition | None
) -> None:
    run = sb.simulate(
        parallelogram(), 3.0, {"a": 1.0, "a_dot": 8.0}, guess={"b": -1.0, "d": 1.0},
        integrator=integrator, constraints=constraints,
    )  # fmt: skip
    assert run.success and run["a"][-1] > 1.0 + 6 * math.pi  # six change points and more
    # The branch is kept: an antiparallelogram has d = a on the line only.
    assert np.abs(run["a"] - run["d"]).max() < 1e-6
    # Projection closes to 1e-10, Newton's method of the implicit formulas to their tolerance of 1e-8.
    assert run.constraint_violation.max() < 1e-7 and run.velocity_violation.max() < 1e-6
    # A local error of 1e-8 in speeds is 2e-8 in kinetic energy, in each step, all of one sign at worst.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()


def test_row_46_a_speed_that_no_branch_has_does_not_move() -> None:
    # On the line the rows of velocity leave d_dot = 3 a_dot open, which those of acceleration forbid.
    with pytest.raises(sb.AssemblyError) as caught:
        sb.simulate(parallelogram(), 1.0, {"a": 0.0, "a_dot": 1.0, "d_dot": 3.0})
    assert caught.value.problems[0].code == "assembly.singular"
    # The speeds of a branch move.
    assert sb.simulate(parallelogram(), 0.5, {"a": 0.0, "a_dot": 8.0, "d_dot": 8.0}).success


@pytest.mark.parametrize(
    "way",
    [{}, {"constraints": sb.Baumgarte()}, {"integrator": sb.Stiff()}, {"constraints": sb.Partition()}],
    ids=["projection", "Baumgarte", "stiff", "partition"],
)
def test_row_47_a_lock_up_ends_the_motion_with_its_time(way: dict[str, object]) -> None:
    # A crank longer than its rod, driven: the rod is upright at sin(theta) = 1/3.
    eqs = slider_crank(crank=3, rod=1, motion="t")
    assert eqs.degrees_of_freedom == 0
    run = sb.simulate(eqs, 2.0, {}, guess={"beta": -0.1, "s": 4.0}, **way)
    assert run.status is sb.Status.STEP_COLLAPSE and not run.success
    # The loop opens by 2.8 m/s after it; what is tolerated, 1e-9 at most, is open after 1e-9 s.
    assert run.t[-1] == pytest.approx(math.asin(1 / 3), abs=1e-8)
    # Joint C is closed by s = 3 cos(theta) + sqrt(1 - 9 sin(theta)^2), whose slope is infinite there.
    assert run.notes[-1].startswith(
        f"the motion is known up to t = {run.t[-1]:.9g} s; there the mechanism locks: the prescribed motions "
        "can continue only with infinite beta_dot, s_dot if joint C stays closed, and 0 degrees of freedom are left"
    )


def test_row_47_a_lock_up_beside_a_free_motion_counts_it() -> None:
    eqs = sb.form_equations(
        sb.Model(
            "slider-crank and pendulum",
            [
                *slider_crank(crank=3, rod=1, motion="t").model.elements,
                sb.Body("Bob", mass=1, inertia=(1, 1, 1)),
                sb.Revolute("P", "Rod.C", "Bob", coordinate="phi"),
            ],
            inputs=["F"],
        )
    )
    run = sb.simulate(eqs, 2.0, {}, guess={"beta": -0.1, "s": 4.0})
    assert run.status is sb.Status.STEP_COLLAPSE
    assert "locks" in run.notes[-1] and "joint C stays" in run.notes[-1]
    assert "1 degree of freedom is left" in run.notes[-1]


@pytest.mark.parametrize("motion", ["sin(t)", "sin(40*t)"])
def test_row_55_all_motion_follows_from_time(motion: str) -> None:
    eqs = slider_crank(motion=motion)
    run = sb.simulate(eqs, 2.0, guess={"s": 4.0}, constraints=sb.Partition())
    assert run.success and run.constraint_violation.max() < 1e-14
    inside = run.at(np.linspace(0.0, 2.0, 301))
    theta = np.sin(inside.t if motion == "sin(t)" else 40 * inside.t)
    # The polynomial of a step follows to its error, which some hundred steps of 1e-8 bound.
    assert np.abs(inside["s"] - np.cos(theta) - np.sqrt(9 - np.sin(theta) ** 2)).max() < 1e-6
    assert run.energy_drift < 1e-6 * max(1.0, run["kinetic_energy"].max())


def test_row_47_a_free_crank_turns_back_before_its_lock_up() -> None:
    start = {"theta": 0.0, "theta_dot": 1.0}
    run = sb.simulate(slider_crank(crank=3, rod=1), 2.0, start, guess={"s": 4.0})
    assert run.success and run["theta"][-1] < run["theta"].max() < math.asin(1 / 3)
    assert run.constraint_violation.max() < 1e-9
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()


def test_row_48_a_start_at_the_dead_centre() -> None:
    start, guess = {"theta": 0.0, "theta_dot": 2.0}, {"s": 4.0}
    runs = [
        sb.simulate(slider_crank(), 2.0, start, guess=guess, constraints=way)
        for way in (None, sb.Partition())
    ]
    for run in runs:
        assert run.success and run["s_dot"][0] == pytest.approx(0.0, abs=10 * EPS)
        assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()
    # Local errors of 1e-8 in some ten steps.
    assert runs[0]["theta"][-1] == pytest.approx(runs[1]["theta"][-1], abs=1e-6)
    # The slider's place can be fixed there, its speed cannot.
    by_slider = sb.assemble(slider_crank(), {"s": 4.0, "theta_dot": 2.0})
    assert by_slider.u["theta_dot"] == pytest.approx(2.0, abs=10 * EPS)
    assert refused(
        lambda: sb.assemble(slider_crank(), {"theta": 0.0, "s_dot": 1.0}, guess), words="s_dot = 1"
    ) == [("assembly.velocity_conflict", "fixed")]


def test_row_49_fixed_places_contradict_and_guesses_are_moved() -> None:
    wrong = {"theta": 0.7, "s": 3.9}
    for attempt in (sb.assemble, lambda eqs, fixed: sb.simulate(eqs, 1.0, fixed)):
        assert refused(
            lambda attempt=attempt: attempt(slider_crank(), {**wrong, "theta_dot": 1.0}),
            AssemblyError,
            "no configuration has theta = 0.7, s = 3.9",
        ) == [("assembly.conflict", "fixed")]
    state = sb.assemble(slider_crank(), {"theta": 0.7}, {"s": 3.9})
    s = math.cos(0.7) + math.sqrt(9 - math.sin(0.7) ** 2)
    assert state.q["theta"] == 0.7 and state.q["s"] == pytest.approx(s, abs=20 * EPS)
    assert state.moved["s"] == pytest.approx(s - 3.9, abs=20 * EPS) and "theta" not in state.moved
    # What is as close as any loop is built, is closed.
    assert sb.assemble(slider_crank(), {"theta": 0.0, "s": 4.0 + 1e-12}).residual < 2e-12


def test_row_50_fixed_speeds_contradict_and_the_rest_is_solved() -> None:
    start = {"theta": 0.7, "theta_dot": 1.0}
    assert refused(
        lambda: sb.assemble(slider_crank(), {**start, "s_dot": 1.0}),
        AssemblyError,
        "theta_dot = 1, s_dot = 1",
    ) == [("assembly.velocity_conflict", "fixed")]
    state = sb.assemble(slider_crank(), start, {"s": 4.0, "s_dot": 5.0})
    sine, cosine = math.sin(0.7), math.cos(0.7)
    root = math.sqrt(9 - sine**2)
    # s(theta) of the closed form, differentiated once and twice; rounding of some sums below 4
    slope = -sine - sine * cosine / root
    bend = -cosine - math.cos(1.4) / root - (sine * cosine) ** 2 / root**3
    assert state.u["theta_dot"] == pytest.approx(1.0, abs=50 * EPS)
    assert state.u["s_dot"] == pytest.approx(slope, abs=50 * EPS)
    assert state.udot["s_ddot"] == pytest.approx(slope * state.udot["theta_ddot"] + bend, abs=100 * EPS)
    # Guesses that were changed are told, for speeds as for places.
    assert state.moved["s_dot"] == pytest.approx(slope - 5.0, abs=50 * EPS)
    assert not {"theta", "theta_dot", "beta_dot"} & set(state.moved)  # as wanted, or not guessed
    # The rod's pin carries what accelerates the slider along its line.
    rod = state.q["theta"] + state.q["beta"]  # reactions are in the axes of the joint's start
    along, across = np.asarray(state["reaction C"])[:2]
    push = abs(along * math.cos(rod) - across * math.sin(rod))
    assert push == pytest.approx(abs(state.udot["s_ddot"]), abs=1e3 * EPS)


def test_row_51_too_many_values_and_too_few() -> None:
    too_many = {"theta": 0.7, "s": 3.9, "beta": 0.0, "theta_dot": 1.0}
    refused(
        lambda: sb.assemble(slider_crank(), too_many), AssemblyError, "no configuration has s = 3.9, beta"
    )
    # Values too many that agree are no fault.
    assert dict(sb.assemble(slider_crank(), {"theta": 0, "s": 4, "beta": 0}).q) == {
        "theta": 0.0, "beta": 0.0, "s": 4.0,
    }  # fmt: skip
    # Without values: near zero, at rest, and what had to be moved is told.
    state = sb.assemble(slider_crank(), guess={"s": 3.5})
    assert set(state.u.values()) == {0.0}
    assert state.residual < 1e-9 and state.moved
    assert len(refused(lambda: sb.assemble(slider_crank(), {"thet": 0.7, "foo": 1}), AssemblyError)) == 2


def test_row_52_a_loop_that_cannot_close_names_joint_and_distance() -> None:
    # 1 m + 2 m + 1 m do not reach over 5 m.
    for attempt in (sb.assemble, lambda eqs: sb.simulate(eqs, 1.0)):
        assert refused(
            lambda attempt=attempt: attempt(parallelogram(5.0)), AssemblyError, "a gap of 1 m"
        ) == [("assembly.open", "joint C")]


def test_row_53_the_nearest_of_two_assemblies_and_always_the_same() -> None:
    root = math.sqrt(9 - math.sin(0.7) ** 2)
    near, far = math.cos(0.7) + root, math.cos(0.7) - root
    for guess, expected, other in (({"s": 4.0}, near, far), ({"s": -2.0, "beta": -3.6}, far, near)):
        states = [sb.assemble(slider_crank(), {"theta": 0.7}, guess) for _ in range(2)]
        assert states[0].q == states[1].q
        listed = [[branch.q for branch in state.branches] for state in states]
        assert listed[0] == listed[1] and len(listed[0]) == 1
        assert states[0].q["s"] == pytest.approx(expected, abs=1e-12)
        assert listed[0][0]["s"] == pytest.approx(other, abs=1e-12)


def test_row_54_redundant_actuation_and_a_stop_as_an_event() -> None:
    # Virtual power T theta_dot + F s_dot = 0: two drives of one freedom hold each other.
    slope = sb.assemble(slider_crank(), {"theta": 0.7, "theta_dot": 1.0}).u["s_dot"]
    balanced = {"F": 10.0, "T": -10.0 * slope}
    state = sb.assemble(slider_crank(), {"theta": 0.7}, inputs=balanced)
    assert np.abs(list(state.udot.values())).max() < 1e4 * EPS
    start = {"theta": 0.0, "theta_dot": 2.0}
    stop = sb.Event("s - 3.5", direction=-1, action="stop")
    run = sb.simulate(slider_crank(), 2.0, start, guess={"s": 4.0}, events=stop)
    assert run.status is sb.Status.STOPPED and run["s"][-1] == pytest.approx(3.5, abs=1e-9)


def test_row_54_unilateral_limits_reached() -> None:
    # A hard stop is an event that reverses the speed, a rope one that takes its part along the rope.
    ball = sb.Body("Ball", mass=2)
    slide = sb.Prismatic("P", "ground", ball, axis="y", coordinate="y")
    floor = sb.Event("y", direction=-1, action={"y_dot": "-0.5*y_dot"}, name="floor")
    falling = sb.form_equations(sb.Model("fall", [slide], gravity=DOWN))
    run = sb.simulate(falling, 1.5, {"y": 4.905}, events=floor)
    assert [event.name for event in run.events] == ["floor"]
    assert run.events[0].t == pytest.approx(1.0, abs=1e-9)
    assert run["y"][-1] == pytest.approx(4.905 * 0.5 - 9.81 * 0.125, abs=1e-7)
    rope = sb.Distance("rope", "ground", "Ball", value=3, rope=True)
    hung = sb.form_equations(sb.Model("rope", [slide, rope], gravity=DOWN))
    run = sb.simulate(hung, 1.5, {"y": -1.0})
    taut = [event for event in run.events if event.name == "rope taut"]
    assert len(taut) == 1 and taut[0].t == pytest.approx(math.sqrt(4 / 9.81), abs=1e-9)
    assert run["y"][-1] == pytest.approx(-3.0, abs=1e-9)
    impulse = 2 * math.sqrt(2 * 9.81 * 2)
    assert any("rope" in note and f"{impulse:.3g}" in note for note in run.notes), run.notes


@cache
def moved_pivot(as_constraint: bool) -> sb.EquationSet:
    """A pendulum whose pivot moves by a law."""
    joints = [
        sb.Prismatic("P", "ground", "Pivot", axis="x", coordinate="x",
                     motion="0.2*sin(5*t) + t^2/10", as_constraint=as_constraint),
        sb.Revolute("J", "Pivot", "Bob.pin", coordinate="phi"),
    ]  # fmt: skip
    bob = sb.Body("Bob", mass=1, inertia=(0, 0, 0.1), frames={"pin": sb.Frame(at=(0, 1, 0))})
    return sb.form_equations(sb.Model("pivot", [sb.Body("Pivot", mass=1), bob, *joints], gravity=DOWN))


def test_row_55_explicit_time_in_a_tree() -> None:
    times = np.linspace(0.0, 2.0, 41)
    held, replaced = (sb.simulate(moved_pivot(way), 2.0, {"phi": 0.5}, times=times) for way in (True, False))
    assert held.success and replaced.success
    law = 0.2 * np.sin(5 * times) + times**2 / 10
    assert np.abs(held["x"] - law).max() < 1e-9  # projected to 1e-10 of some metres
    assert np.abs(replaced["x"] - law).max() < 1e-14
    # Local errors of 1e-8 in some thirty steps; the effort is an acceleration of some 10 rad/s^2.
    for name, bound in (("phi", 1e-6), ("phi_dot", 1e-6), ("effort P", 1e-5)):
        assert np.abs(held[name] - replaced[name]).max() < bound
    # (I + m l^2) phi'' = -m l (g sin(phi) + x'' cos(phi)), l = m = 1
    phi, rate = replaced["phi"], 0.2 - 5 * np.sin(5 * times)
    expected = -(9.81 * np.sin(phi) + rate * np.cos(phi)) / 1.1
    np.testing.assert_allclose(replaced["phi_ddot"], expected, rtol=0, atol=1e3 * EPS)


def test_row_55_explicit_time_in_a_loop() -> None:
    times = np.linspace(0.0, 2.0, 21)
    law, guess = "0.3*t^2 + sin(t)", {"s": 4.0}
    held, replaced = (
        sb.simulate(slider_crank(motion=law, as_constraint=way), 2.0, guess=guess, times=times)
        for way in (True, False)
    )
    theta = 0.3 * times**2 + np.sin(times)
    s = np.cos(theta) + np.sqrt(9 - np.sin(theta) ** 2)
    for run in (held, replaced):
        assert run.success
        assert np.abs(run["s"] - s).max() < 4e-9  # 1e-10 of a mechanism of some metres, along the rod
        assert run.velocity_violation.max() < 1e-9
    for name in ("s_dot", "effort A", "reaction C"):
        assert np.abs(held[name] - replaced[name]).max() < 1e-7


@cache
def bead(*conditions: ConstraintElement, parameter: float | None = None) -> sb.EquationSet:
    """A bead without weight."""
    parts = [sb.Body("Bead", mass=2), sb.Cartesian("free", "ground", "Bead", coordinates=["x", "y", "z"])]
    parameters = {} if parameter is None else {"L": parameter}
    return sb.form_equations(sb.Model("bead", [*parts, *conditions], parameters=parameters))


@pytest.mark.parametrize(
    "rod",
    [
        sb.Distance("c", "ground", "Bead", "1 + t^2/4"),
        sb.Constraint("c", "sqrt(x^2 + y^2 + z^2) - 1 - t^2/4"),
        sb.Constraint("c", "(x*x_dot + y*y_dot + z*z_dot)/sqrt(x^2 + y^2 + z^2) - t/2"),
    ],
    ids=["distance", "equation", "rate"],
)
def test_row_55_explicit_time_in_constraints(rod: ConstraintElement) -> None:
    # Angular momentum is kept, m (L'' - L phi'^2) = lambda, and the rod gives the power lambda L'.
    run = sb.simulate(bead(rod), 2.0, {"x": 1.0, "y": 0.0, "z": 0.0, "y_dot": 1.5, "z_dot": 0.0})
    length, rate = 1 + run.t**2 / 4, 1.5 / (1 + run.t**2 / 4) ** 2
    assert run.success
    # Local errors of 1e-8 in some thirty steps.
    np.testing.assert_allclose(np.hypot(run["x"], run["y"]), length, atol=1e-6)
    np.testing.assert_allclose(run["x"] * run["y_dot"] - run["y"] * run["x_dot"], 1.5, atol=1e-6)
    np.testing.assert_allclose(run["lambda_c_1"], 2 * (0.5 - length * rate**2), atol=1e-5)
    np.testing.assert_allclose(run["power"], 2 * (0.5 - length * rate**2) * run.t / 2, atol=1e-5)
    assert np.ptp(run["energy"] - run["work"]) < 1e-6


INTEGRABLE = [
    "x_dot - x",  # exp(-t) x
    "y*x_dot + sin(x)*y_dot",  # any in two variables
    "exp(t)*(x*x_dot + y*y_dot)",
    "(1 + t)*x_dot + x",
    "y*z*x_dot + x*z*y_dot + x*y*z_dot",
    "x_dot/x + y_dot/y + z_dot/z",
    "(y - z)*x_dot + (z - x)*y_dot + (x - y)*z_dot",  # a . curl a = -2 (y - z + z - x + x - y)
    "x*y_dot - y*x_dot",
    "cos(x)*(y*x_dot + x*y_dot + w*z_dot + z*w_dot)",
    "2*t*x*x_dot + 2*y*y_dot*t + x^2 + y^2 - w_dot",
]
NOT_INTEGRABLE = [
    "t*x_dot - y_dot",
    "y_dot - x*z_dot",  # the contact form
    "z*x_dot + x*y_dot + y*z_dot",  # a . curl a = x + y + z
    "sin(w)*x_dot - cos(w)*y_dot",  # a blade
    "y*x_dot - x*y_dot + w*z_dot - z*w_dot",
    "x_dot + y*z_dot + z*w_dot",
    "x_dot + y + t*z*y_dot",
    "x_dot - 0.2*cos(z)*w_dot",
]


@pytest.mark.parametrize("equation", INTEGRABLE + NOT_INTEGRABLE)
def test_row_56_a_constraint_on_velocities_that_is_one_on_positions(equation: str) -> None:
    parts = [
        *bead().model.elements,
        sb.Body("Rider", mass=1, inertia=(0, 0, 1)),
        sb.Revolute("axle", "Bead", "Rider", coordinate="w"),
    ]
    eqs = sb.form_equations(sb.Model("pfaff", [*parts, sb.Constraint("c", equation)]))
    notes = [note for note in eqs.notes if "time derivative of a position constraint" in note]
    assert (len(notes) == 1) == (equation in INTEGRABLE)
    assert all(note.startswith("constraint c: lambda_c_1 ") for note in notes)
    assert eqs.degrees_of_freedom == 3


def test_row_56_rolling_and_blades_are_told_only_where_they_go_straight() -> None:
    blade = sb.KnifeEdge("c", "ground", "Skate")
    skate = sb.Body("Skate", mass=1, inertia=(0, 0, 1))
    notes = [
        [
            note
            for note in sb.form_equations(sb.Model("skate", [skate, joint, blade])).notes
            if "time derivative of a position constraint" in note
        ]
        for joint in (
            sb.Planar("j", "ground", "Skate"),
            sb.Rectangular("j", "ground", "Skate"),
        )
    ]
    assert [len(listed) for listed in notes] == [0, 1]
    # The same motion, with the position held too where it is told.
    start = {"x": 1.0, "y": 0.0, "z": 0.0, "x_dot": 0.0, "y_dot": 1.0, "z_dot": 0.5}
    runs = [
        sb.simulate(bead(sb.Constraint("c", text)), 2.0, start)
        for text in ("x*x_dot + y*y_dot", "x^2/2 + y^2/2 - 1/2")
    ]
    for run in runs:  # twenty steps of 1e-8
        np.testing.assert_allclose([run["x"][-1], run["y"][-1], run["z"][-1]],
                                   [math.cos(2), math.sin(2), 1.0], atol=1e-6)  # fmt: skip
        np.testing.assert_allclose(run["lambda_c_1"], -2.0, atol=1e-6)


@pytest.mark.parametrize(
    ("equation", "words"),
    [
        ("x_dot^2 + y_dot^2 - 1", "2*x_dot, which contains speeds"),
        ("x_dot*y_dot", "not linear in x_dot"),
        ("z + sqrt(x_dot)", "not linear in x_dot"),
        ("sin(t*y_dot) - x", "not linear in y_dot"),
    ],
)
def test_row_57_constraints_that_are_not_of_first_degree_in_speeds(equation: str, words: str) -> None:
    assert refused(
        lambda: bead(sb.Constraint("c", ["x - y", equation])), FormulationError, words
    ) == [("equations.nonlinear_in_speeds", "constraint c, equations[1]")]  # fmt: skip
    # What only looks so is none.
    assert bead(
        sb.Constraint("c", "(x_dot + y_dot)^2 - x_dot^2 - 2*x_dot*y_dot - y_dot^2 + z_dot")
    ).multiplier_names == ("lambda_c_1",)


def quaternion(*values: float) -> dict[str, float]:
    return dict(zip(("B_qw", "B_qx", "B_qy", "B_qz"), values, strict=True))


def test_row_58_quaternions_of_another_norm() -> None:
    body = sb.Body("B", mass=1, inertia=(1, 2, 3))
    model = sb.Model("thrown", [body], initial=quaternion(1, 2, 2, 4))
    assert any("quaternion B_qw, B_qx, B_qy, B_qz of norm 5 is normalized" in note for note in model.notes)
    eqs = sb.form_equations(model)
    state = sb.assemble(eqs)
    expected = pytest.approx([0.2, 0.4, 0.4, 0.8], abs=4 * EPS)
    assert [state.q[name] for name in quaternion(1, 0, 0, 0)] == expected
    run = sb.simulate(eqs, 1.0, {"B_wx": 1.0})
    norms = sum(run[name] ** 2 for name in quaternion(1, 0, 0, 0))
    assert run.success and np.abs(norms - 1).max() < 1e-9


def test_row_58_the_zero_quaternion() -> None:
    assert refused_model(sb.Body("B"), initial=quaternion(0, 0, 0, 0), words="norm zero") == [
        ("initial.zero_quaternion", "model, initial.B_qw")
    ]


@pytest.mark.parametrize(("matrix", "words"), [
    ([[1, 0, 0], [0, 1, 0], [0, 1e-3, 1]], "deviate from an orthonormal set by 0.001"),
    ([[1, 0, 0], [0, 1, 0], [0, 9e-6, 1]], "deviate from an orthonormal set by 9e-06"),
    ([[1 + 1e-8, 0, 0], [0, 1, 0], [0, 0, 1]], "deviate from an orthonormal set by 2e-08"),
    ([[2, 0, 0], [0, 1, 0], [0, 0, 1]], "deviate from an orthonormal set by 3"),
    ([[1, 0, 0], [0, 1, 0], [0, 0, -1]], "determinant is -1"),
])  # fmt: skip
def test_row_59_a_matrix_that_is_no_rotation(matrix: list[list[float]], words: str) -> None:
    body = sb.Body("B", frames={"f": sb.Frame(matrix=matrix)})
    assert refused_model(body, words=words) == [("model.not_a_rotation", "body B, frames.f.matrix")]


def test_row_59_noise_is_repaired() -> None:
    refused_file("matrix_not_orthonormal", "model.not_a_rotation")
    refused_file("matrix_left_handed", "model.not_a_rotation")
    noisy = sb.Frame(matrix=[[1 + 1e-9, 0, 0], [0, 1, 1e-9], [0, 0, 1]])
    body = sb.Body("B", mass=1, inertia=(1, 1, 1), frames={"f": noisy})
    model = sb.Model("noise", [body, sb.Revolute("j", "ground", "B.f", coordinate="a")])
    found = np.asarray(sb.assemble(sb.form_equations(model), {"a": 0.3})["frame R B ground"])
    # Products of three matrices of entries below 1.
    np.testing.assert_allclose(found @ found.T, np.eye(3), rtol=0, atol=10 * EPS)


def test_row_60_constraints_that_no_coordinate_is_in() -> None:
    eqs = sb.form_equations(two_sliders(0.0))  # 0 = 0
    assert eqs.multiplier_names == ()
    assert any("joint q: 5 closing equations hold identically and are dropped" in note for note in eqs.notes)
    assert refused(  # 1 = 0
        lambda: sb.form_equations(two_sliders(1.0)), FormulationError, "is the constant -1"
    ) == [("equations.never_closed", "joint q")]


def test_row_60_equations_that_nothing_moves_in() -> None:
    for text in ("0", "x - x", "sin(x)^2 + cos(x)^2 - 1", "t*(y_dot - y_dot)"):
        eqs = bead(sb.Constraint("c", text))
        assert eqs.multiplier_names == ()
        note = "constraint c: 1 equation holds identically and is dropped (lambda_c_1)"
        assert note in eqs.notes
    for text, side in (
        ("1", "1"),
        ("sin(x)^2 + cos(x)^2 - 2", "sin(x)**2"),
        ("t - 1", "t - 1"),
        ("3*t", "3*t"),
    ):
        assert refused(
            lambda text=text: bead(sb.Constraint("c", text)), FormulationError, f"left-hand side {side}"
        ) == [("equations.never_closed", "constraint c")]
    fixed = [sb.Body("Pole"), sb.Weld("w", "ground", "Pole"), sb.Distance("c", "ground.G", "Pole", 2)]
    ground = {"G": sb.Frame(at=(1, 0, 0))}
    assert refused(
        lambda: sb.form_equations(sb.Model("m", fixed, ground=ground)), FormulationError, "side -1"
    ) == [("equations.never_closed", "constraint c")]


def test_row_60_equations_in_parameters_alone_are_judged_by_their_values() -> None:
    held = sb.Constraint("c", "L - 2")
    eqs = bead(held, parameter=2.0)
    assert eqs.degrees_of_freedom == 3
    assert sb.assemble(eqs, {"x": 1.0}).q["x"] == 1.0
    assert sb.simulate(eqs, 1.0, {"x_dot": 1.0})["x"][-1] == pytest.approx(1.0, abs=1e-8)
    for attempt in (sb.assemble, lambda eqs, **words: sb.simulate(eqs, 1.0, **words)):
        assert refused(
            lambda attempt=attempt: attempt(eqs, parameters={"L": 3}), FormulationError, "side 1 with L = 3"
        ) == [("equations.never_closed", "constraint c")]
    other = bead(held, parameter=2.5)
    for judged in (
        lambda: other.degrees_of_freedom,
        lambda: sb.compile(other, "udot"),
        lambda: sb.redundancy(other),
    ):
        refused(judged, FormulationError, "L - 2 = 0, has the left-hand side 0.5 with L = 2.5")
