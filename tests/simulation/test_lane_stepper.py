"""Motions stepped side by side: each lane is the stepper with its values, to the bit."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import symbody as sb
from tests.simulation.loops import example, pushed_mass
from tests.simulation.test_events import G, ball

N = 11
ANGLES = np.linspace(-0.3, 0.3, N)
MASSES = np.linspace(0.1, 0.2, N)


def side_by_side(name: str, initial: dict[str, Any], parameters: dict[str, Any], **options: Any) -> Any:
    """Return motions in lanes, and the same ones by single steppers."""
    eqs = example(name)
    lanes = sb.LaneStepper(eqs, 0.01, N, parameters=parameters, initial=initial, **options)
    singles = [
        sb.Stepper(eqs, 0.01, {k: v[i] for k, v in parameters.items()}, initial={k: v[i] for k, v in initial.items()}, **options)
        for i in range(N)
    ]  # fmt: skip
    return lanes, singles


def balancing(**options: Any) -> Any:
    return side_by_side("cart_pole", {"theta": ANGLES}, {"mp": MASSES.tolist()}, **options)


def assert_same(lanes: sb.LaneStepper, singles: list[sb.Stepper]) -> None:
    np.testing.assert_array_equal(lanes.u, [single.u for single in singles])
    np.testing.assert_array_equal(lanes.q, [single.q for single in singles])
    np.testing.assert_array_equal(lanes.t, [single.t for single in singles])


def step_all(lanes: sb.LaneStepper, singles: list[sb.Stepper], steps: int, seed: int = 4) -> None:
    for forces in np.random.default_rng(seed).normal(0.0, 3.0, (steps, len(singles))):
        lanes.step(F=forces)
        for single, force in zip(singles, forces.tolist(), strict=True):
            single.step(F=force)


@pytest.mark.parametrize(
    "options",
    [{}, {"integrator": sb.Explicit(order=5, max_step=0.004)}, {"integrator": sb.FixedStep(0.003, "semi-implicit")}],
    ids=["default", "order 5", "fixed"],
)  # fmt: skip
def test_lanes_are_single_steppers_to_the_bit(options: dict[str, Any]) -> None:
    lanes, singles = balancing(**options)
    step_all(lanes, singles, 40)
    assert_same(lanes, singles)
    assert not lanes.notes
    assert lanes.lane(3).save() == singles[3].save()
    np.testing.assert_array_equal(lanes["energy"], [single["energy"] for single in singles])
    assert (lanes["theta"] == lanes.q[:, 1]).all()
    assert lanes.x.shape == (N, 4)


@pytest.mark.parametrize("stiffness", [[0.0, 9.0], [9.0, 0.0], [0.0, 0.0], [4.0, 9.0]])
def test_parameters_that_are_exactly_0_in_some_lanes(stiffness: list[float]) -> None:
    """They stand in the code of these lanes, which is another one then: such lanes are stepped one by one."""
    rail = sb.Prismatic(
        "rail", "ground", sb.Body("Cart", mass=1), coordinate="x", force=sb.Drive(stiffness="k")
    )
    eqs = sb.form_equations(sb.Model("cart", [rail], parameters={"k": 1}, initial={"x": 5}))
    lanes = sb.LaneStepper(eqs, 0.5, 2, parameters={"k": stiffness}).step().step()
    assert lanes["x"] == pytest.approx(5 * np.cos(np.sqrt(stiffness)), abs=1e-7)
    alone = any("one after the other" in note for note in lanes.notes)
    assert alone == (min(stiffness) == 0.0 < max(stiffness))
    lanes.set(k=[1.0, 4.0])
    assert not any("one after the other" in note for note in lanes.notes)


@pytest.mark.parametrize("constraints", [None, sb.Baumgarte()], ids=str)
def test_closed_loops_in_lanes(constraints: Any) -> None:
    lanes, singles = side_by_side(
        "slider_crank", {"theta_dot": ANGLES}, {"m1": MASSES.tolist()}, constraints=constraints
    )
    step_all(lanes, singles, 20)
    assert_same(lanes, singles)
    assert np.abs(lanes["constraints"]).max() < 1e-7


LAWS = {
    "jump": "if(t < 0.1, 1, -2)", "late pulse": "if(t > 13.3 and t < 13.301, 1000, 0)",
    "table": sb.Table([0.0, 0.1, 0.1, 20.0], [0.0, 1.0, -1.0, 2.0]), "python": lambda t, q, u: 3.0 - 2.0 * t,
    "states": "2*x_dot - t",
}  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_laws_in_lanes(law: str) -> None:
    """Also where they are looked at beyond the first thousand steps."""
    lanes, singles = balancing(inputs={"F": LAWS[law]})
    for _ in range(1400 if law == "late pulse" else 25):
        lanes.step()
        for single in singles:
            single.step()
    assert_same(lanes, singles)
    assert bool(lanes.notes) is (law == "python")


def test_single_lanes_are_set_and_reset() -> None:
    lanes, singles = balancing()
    step_all(lanes, singles, 5)
    lanes.set([2, -1], mp=[0.3, 0.4], l="0.2 + 0.4")
    singles[2].set(mp=0.3, l="0.2 + 0.4")
    singles[-1].set(mp=0.4, l="0.2 + 0.4")
    fallen = np.abs(lanes["theta"]) > 0.3
    assert 0 < fallen.sum() < N
    lanes.reset(fallen, theta=0.05)
    for single in np.array(singles)[fallen]:
        single.reset(theta=0.05)
    with pytest.raises(sb.UsageError, match=r"stepper\.input_without_value"):
        lanes.step()
    step_all(lanes, singles, 5)
    assert_same(lanes, singles)
    assert len(set(lanes.t.tolist())) == 2
    assert lanes.parameters[2] == singles[2].parameters


def test_saved_lanes_go_on_to_the_bit() -> None:
    lanes, singles = balancing()
    step_all(lanes, singles, 5)
    lanes.set(4, mp=0.5)
    saved = lanes.save()
    ends = []
    for other in (lanes, lanes.copy(), balancing()[0]):
        assert other.restore(saved) is other
        for force in (1.0, -2.0):
            other.step(np.full((N, 1), force)).step()
        ends.append(other.save())
    assert ends[0] == ends[1] == ends[2] != saved
    for bad in (b"", saved[:-1], saved[:200] + b"x" + saved[201:], singles[0].save()):
        with pytest.raises(sb.UsageError, match=r"stepper\.(not_saved|other_kind)"):
            lanes.restore(bad)
    with pytest.raises(sb.UsageError, match=r"stepper\.other_kind"):
        sb.LaneStepper(example("cart_pole"), 0.01, 3).restore(saved)
    assert lanes.save() == ends[0]


@pytest.mark.parametrize("copies", [copy.copy, copy.deepcopy])
def test_copies_by_the_library_go_their_own_way(copies: Callable[[Any], Any]) -> None:
    """An environment of reinforcement learning that holds a stepper is copied by `copy.deepcopy`."""
    lanes, singles = balancing()
    for motion in (lanes, singles[0]):
        motion.step(F=1.0)
        before, other = motion.save(), copies(motion)
        other.step(F=-5.0)
        assert motion.save() == before
        motion.step(F=-5.0)
        assert motion.save() == other.save()


def test_restored_motions_keep_their_own_duration_of_steps() -> None:
    for make in (
        lambda dt: sb.Stepper(example("cart_pole"), dt),
        lambda dt: sb.LaneStepper(example("cart_pole"), dt, 2),
    ):
        saved, other = make(0.01).step(F=1.0).save(), make(0.03)
        other.restore(saved).step()
        assert np.ravel(other.t) == pytest.approx(0.04, rel=1e-12)


def test_events_of_lanes() -> None:
    """Lanes with events are stepped one after the other; one that stops keeps its own time."""
    event = sb.Event("y", -1, "stop", "ground")
    lanes = sb.LaneStepper(ball(), 0.1, 3, initial={"y": [1.0, 2.0, 9.0]}, events=event)
    assert "one after the other" in lanes.notes[-1]
    stops: dict[int, float] = {}
    while lanes.t.max() < 0.85:
        lanes.step()
        stops |= {k: lanes.events[k][0].t for k, end in enumerate(lanes.status) if end is sb.Status.STOPPED}
    assert stops == {k: pytest.approx(np.sqrt(2.0 * (k + 1) / G)) for k in (0, 1)}


def test_lanes_that_break_off_leave_the_others_alone() -> None:
    eqs = pushed_mass("x_dot**2", 0.0, 0.0)
    lanes = sb.LaneStepper(eqs, 0.3, 9, initial={"x_dot": [0.1] * 4 + [1.0] + [0.1] * 4})
    with pytest.raises(sb.SimulationError, match="lane 4") as caught:
        for _ in range(4):
            lanes.step()
    assert caught.value.problems[0].code == "stepper.broke_off"
    assert lanes.status[4].name in ("STEP_COLLAPSE", "NOT_FINITE")
    assert {status for k, status in enumerate(lanes.status) if k != 4} == {sb.Status.SUCCESS}
    assert lanes.t == pytest.approx([1.2] * 4 + [1.0] + [1.2] * 4, abs=1e-3)
    lanes.reset(4, x_dot=0.1)
    single = sb.Stepper(eqs, 0.3, initial={"x_dot": 1.0}).reset(x_dot=0.1).step()
    assert lanes.step().x[4].tolist() == [*single.u, *single.q]
    assert set(lanes.status) == {sb.Status.SUCCESS}


REFUSED: list[tuple[str, Callable[[sb.LaneStepper], object]]] = [
    ("stepper.unknown_name", lambda s: s.step(G=1.0)),
    ("stepper.lane_values", lambda s: s.step(F=np.ones(N + 1))),
    ("stepper.lane_values", lambda s: s.step(np.ones((N, 2)))),
    ("stepper.input_value", lambda s: s.step(F=np.full(N, np.nan))),
    ("stepper.input_value", lambda s: s.step(F="much")),
    ("stepper.lanes", lambda s: s.reset([N])),
    ("stepper.lanes", lambda s: s.reset(np.ones(N - 1, dtype=bool))),
    ("stepper.lanes", lambda s: s.lane(N)),
    ("stepper.lanes", lambda s: s.lane([0, 1])),  # type: ignore[arg-type]
    ("stepper.lanes", lambda s: s.lane(None)),  # type: ignore[arg-type]
    ("stepper.lanes", lambda s: s.set([[0], [1, 2]], mp=0.1)),
    ("stepper.pickle", pickle.dumps),
    ("stepper.lane_values", lambda s: s.set([0, 1], mp=[0.1])),
    ("model.negative_mass", lambda s: s.set(mp=[0.2] * (N - 1) + [-1.0])),
    ("assembly.unknown_name", lambda s: s.reset(z=0.0)),
]


@pytest.mark.parametrize(
    ("code", "call"), REFUSED, ids=[f"{code} {k}" for k, (code, _) in enumerate(REFUSED)]
)
def test_refusals_change_nothing(code: str, call: Callable[[sb.LaneStepper], object]) -> None:
    lanes = sb.LaneStepper(example("cart_pole"), 0.01, N, initial={"theta": ANGLES})
    lanes.step(F=1.0)
    before = lanes.save()
    with pytest.raises(sb.SymbodyError) as caught:
        call(lanes)
    assert caught.value.problems[0].code == code
    assert lanes.save() == before
    assert (lanes.step().t == 0.02).all()


@pytest.mark.parametrize("count", [0, -1])
def test_numbers_of_lanes_that_mean_nothing(count: int) -> None:
    with pytest.raises(sb.UsageError, match=r"stepper\.lanes"):
        sb.LaneStepper(example("cart_pole"), 0.01, count)


@pytest.mark.parametrize("points", [4, 101])
@pytest.mark.parametrize("events", [(), sb.Event("x - 100")])
def test_no_lane_moves_where_one_would_leave_a_table(points: int, events: Any) -> None:
    """A lane that was not reset comes to the end of the table first; 3*0.1 is 0.3 but for the last bit."""
    t = np.linspace(0.0, 0.3, points)
    push = sb.Prismatic("J", "ground", "B", axis="x", coordinate="x", force=sb.Drive(applied="F"))
    eqs = sb.form_equations(sb.Model("pushed", [sb.Body("B", mass=1), push], inputs=["F"]))
    law = sb.Table(t, t, outside="error")
    lanes = sb.LaneStepper(eqs, 0.1, 3, inputs={"F": law}, events=events)
    lanes.step().reset([0, 2])
    lanes.step().step()
    before = lanes.save()
    with pytest.raises(sb.UsageError, match="lane 1, input F: the table covers 0 to 0.3 s") as caught:
        lanes.step()
    assert [problem.code for problem in caught.value.problems] == ["simulation.table_range"]
    assert lanes.save() == before
    np.testing.assert_allclose(lanes.t, [0.2, 0.3, 0.2], rtol=1e-15)
    stepper = sb.Stepper(eqs, 0.1, inputs={"F": law}, events=events).step().step().step()
    with pytest.raises(sb.UsageError, match=r"simulation\.table_range"):
        stepper.step()


def test_lanes_beside_one_that_is_rejected_end_their_step() -> None:
    """The prescribed position jumps at t = 0.25 where the parameter says so."""
    elements = [
        sb.Body("A", mass=1),
        sb.Prismatic("J", "ground", "A", axis="x", coordinate="x", motion="if(t < 0.25, t, t + torn)"),
        sb.Body("B", mass=1),
        sb.Prismatic("K", "A", "B", axis="x", coordinate="y"),
    ]
    eqs = sb.form_equations(sb.Model("torn", elements, parameters={"torn": 0}))
    lanes = sb.LaneStepper(eqs, 0.1, 3, parameters={"torn": [0, 1, 0]}).step().step()
    with pytest.raises(sb.UsageError, match="lane 1, motion x"):
        lanes.step()
    np.testing.assert_allclose(lanes.t, [0.3, 0.2, 0.3])
