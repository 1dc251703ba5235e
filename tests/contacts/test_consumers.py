"""Short compliant contacts by whatever computes a motion, in one large step and in few: no step passes over one."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.fmu import binaries
from tests.contacts.test_motions import dipped, dipping_ball
from tests.fmu.importer import instance

END = 2.0
Consumer = Callable[[sb.EquationSet, int, Path], list[float]]

FRAMES = """
import { makeSimulation } from "./page.mjs";
const s = makeSimulation();
for (const t of TIMES) s.advanceTo(t);
console.log(JSON.stringify([s.state[1], s.state[0]]));
"""


@pytest.fixture(autouse=True)
def _light_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binaries, "FLAGS", (*binaries.FLAGS, "-O0"))


def times(count: int) -> list[float]:
    return [END * k / count for k in range(1, count + 1)]


def by_stepper(**ways: object) -> Consumer:
    def consume(eqs: sb.EquationSet, count: int, _: Path) -> list[float]:
        stepper = sb.Stepper(eqs, END / count, rtol=1e-9, **ways)  # type: ignore[arg-type]
        for _t in times(count):
            stepper.step()
        return [float(stepper["z"]), float(stepper["z_dot"])]

    return consume


def by_lanes(eqs: sb.EquationSet, count: int, _: Path) -> list[float]:
    """In the second lane the force that lifts is another one; the first is that of a stepper to the bit."""
    lanes = sb.LaneStepper(eqs, END / count, 2, parameters={"F": [10.0, 9.0]}, rtol=1e-9)
    assert not any("one after the other" in note for note in lanes.notes)
    single = sb.Stepper(eqs, END / count, parameters={"F": 9.0}, rtol=1e-9)
    for _t in times(count):
        lanes.step()
        single.step()
    assert (lanes.q[1] == single.q).all() and (lanes.u[1] == single.u).all()
    return [float(lanes["z"][0]), float(lanes["z_dot"][0])]


def by_page(eqs: sb.EquationSet, count: int, folder: Path) -> list[float]:
    page = sb.animate(eqs, folder / "page.html", live=True, rtol=1e-9)
    (folder / "page.mjs").write_text(page.program.module, encoding="utf-8")
    (folder / "frames.mjs").write_text(FRAMES.replace("TIMES", json.dumps(times(count))))
    done = subprocess.run(["node", "frames.mjs"], cwd=folder, capture_output=True, text=True, check=True)
    values: list[float] = json.loads(done.stdout)
    return values


def by_fmu(**ways: object) -> Consumer:
    def consume(eqs: sb.EquationSet, count: int, folder: Path) -> list[float]:
        sb.save_fmu(eqs, folder / "dip.fmu", sources=False, **ways)  # type: ignore[arg-type]
        with instance(folder / "dip.fmu", "CoSimulation") as fmu:
            fmu.initialize(tolerance=1e-9)
            fmu.steps([0.0, *times(count)])
            return fmu.get("z", "z_dot")

    return consume


needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="needs Node")
needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
LEVEL = sb.Event("z - 0.05", name="level")


def consumers() -> Iterator[object]:
    """Programs and sweeps stand in `test_motions`."""
    yield pytest.param(by_stepper(), id="Stepper")
    yield pytest.param(by_stepper(integrator=sb.Explicit(order=5)), id="Stepper of order 5")
    yield pytest.param(by_stepper(integrator=sb.Stiff()), id="Stepper by Stiff")
    yield pytest.param(by_stepper(events=LEVEL), id="Stepper with an event")
    yield pytest.param(by_lanes, id="LaneStepper")
    yield pytest.param(by_page, id="page", marks=needs_node)
    yield pytest.param(by_fmu(), id="FMU", marks=needs_compiler)
    yield pytest.param(
        by_fmu(integrator=sb.GeneralizedAlpha()), id="FMU by GeneralizedAlpha", marks=needs_compiler
    )
    yield pytest.param(by_fmu(events=LEVEL), id="FMU with an event", marks=needs_compiler)


@pytest.mark.parametrize("consume", list(consumers()))
@pytest.mark.parametrize(
    ("depth", "count", "end"), [(1e-3, 1, "contact"), (1e-4, 2, "limits"), (1e-6, 7, "contact")]
)
def test_no_consumer_passes_over_a_shallow_arc(
    consume: Consumer, depth: float, count: int, end: str, tmp_path: Path
) -> None:
    """As `test_shallow_arcs_are_seen` has it for whole motions: the arc is 5 m, what lies beyond the end 1 mm or less.

    An error of a place before the touch, 1e-7 m at most, grows by dz(2)/dz(0) = 10/v.
    """
    values = consume(dipping_ball(depth, end), count, tmp_path)
    assert values == pytest.approx(dipped(depth), abs=1e-6 / (20 * depth) ** 0.5)


def fast_teeth(**gear: object) -> sb.EquationSet:
    """A wheel that a heavy one throws back, within 3 ms at 1/3 s; at 1 s it would meet the next tooth."""
    first = sb.Revolute("first", "ground", sb.Body("A", inertia=(0, 0, 1)), coordinate="a")
    second = sb.Revolute("second", "ground", sb.Body("B", inertia=(0, 0, 1e6)), coordinate="b")
    play = sb.Backlash(angle=2.0, stiffness=1e6)
    mesh = sb.Gear("mesh", ["a", "b"], ratio=-1, backlash=play)
    return sb.form_equations(sb.Model("mesh", [first, second, mesh], initial={"a_dot": 3.0}))


@pytest.mark.parametrize("dt", [0.9, 0.3])
def test_teeth_are_met_in_free_flight(dt: float) -> None:
    """The heavy wheel is a wall: -3 (1e6 - 1)/(1e6 + 1)."""
    stepper = sb.Stepper(fast_teeth(), dt)
    while stepper.t < 0.89:
        stepper.step()
    assert stepper["a_dot"] == pytest.approx(-3 * (1e6 - 1) / (1e6 + 1), rel=1e-6)


def test_what_was_restored_meets_the_same_contacts_to_the_bit() -> None:
    """What is remembered of gaps is nothing: each step is looked at by itself."""
    stepper = sb.Stepper(dipping_ball(1e-4, "contact"), 0.3, rtol=1e-9)
    stepper.step().step()
    saved = stepper.save()
    other = sb.Stepper(dipping_ball(1e-4, "contact"), 0.3, rtol=1e-9).restore(saved)
    copied = stepper.copy()
    fresh = sb.Stepper(dipping_ball(1e-4, "contact"), 0.3, rtol=1e-9)
    for _ in range(5):
        states = [(*each.step().q, *each.u) for each in (stepper, other, copied)]
        assert states[0] == states[1] == states[2]
    stepper.reset()
    for _ in range(7):
        assert (*stepper.step().q, *stepper.u) == (*fresh.step().q, *fresh.u)


SHAKEN = """
import { makeSimulation } from "./page.mjs";
const s = makeSimulation();
const rows = [];
for (let k = 1; k <= 90; k += 1) {
  const isReached = s.advanceTo(k / 30, 2000);
  rows.push([s.time, s.state[1], s.state[0], isReached ? 1 : 0]);
  if (!isReached) break;
}
console.log(JSON.stringify(rows));
"""


@needs_node
def test_a_page_lets_go_what_is_thrown_off(tmp_path: Path) -> None:
    """Frames show states in the modes of their time; behind them the motion goes on in its own.

    The plate swings faster and faster; without restitution the ball forgets where it was at each strike.
    """
    ball = sb.Body("Ball", mass=0.4, inertia=(1, 1, 1))
    rail = sb.Prismatic("rail", "ground", ball, axis="z", coordinate="z")
    plate = sb.Stop("plate", "z - 0.02*sin(15*t + 10*t^2)")
    eqs = sb.form_equations(sb.Model("shaken", [rail, plate], gravity=(0, 0, -9.81)))
    run = sb.simulate(eqs, 3.0, times=[k / 30 for k in range(1, 91)], rtol=1e-9)
    page = sb.animate(eqs, tmp_path / "page.html", live=True, rtol=1e-9)
    (tmp_path / "page.mjs").write_text(page.program.module, encoding="utf-8")
    (tmp_path / "frames.mjs").write_text(SHAKEN)
    done = subprocess.run(["node", "frames.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    t, z, speed, reached = np.array(json.loads(done.stdout)).T
    assert reached.all() and t.size == 90
    assert len([event for event in run.events if event.name == "plate impact"]) > 10
    np.testing.assert_allclose(z, run["z"], atol=1e-7)
    np.testing.assert_allclose(speed, run["z_dot"], atol=1e-5)
