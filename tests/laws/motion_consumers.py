"""Everything that computes a motion, asked for the same one: fragments beside each other, from 0 to 1 s."""

from __future__ import annotations

import csv
import json
import re
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

import symbody as sb
from tests.fmu.importer import instance
from tests.laws.motion_fragments import END, TIMES, Array, Fragment, Values, equations_of

BEARABLE_SECONDS = 120
# What no program, FMU or page computes: functions of Python, FMUs (exceptions of the target table).
PYTHON_ONLY = ("FMU input", "Python input")
SHIFT = 0.25


@dataclass(frozen=True)
class Motion:
    """Values at times; `end` is the time of the last one, and `shift` what was added to a coordinate at first."""

    t: Array
    values: Mapping[str, Array]
    shift: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Question:
    """Which fragments stand together, and where files may be written."""

    fragments: tuple[Fragment, ...]
    folder: Path
    controller: Path | None
    substitute: bool = False

    @property
    def eqs(self) -> sb.EquationSet:
        return equations_of(self.fragments, self.substitute)

    @property
    def watched(self) -> list[str]:
        return [name for fragment in self.fragments for name in fragment.scales]

    @property
    def events(self) -> list[sb.Event]:
        return [event for fragment in self.fragments for event in fragment.events]

    @property
    def laws(self) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for fragment in self.fragments:
            found |= fragment.laws(self.eqs, self.controller)
        return found

    @property
    def freely(self) -> str:
        return next((fragment.freely for fragment in self.fragments if fragment.freely), "")


Consumer = Callable[[Question], list[Motion]]


class Ended(Exception):
    """A motion that ended early, with its status, or was rejected inside of another."""


def by_simulate(**method: Any) -> Consumer:
    def consume(question: Question) -> list[Motion]:
        run = sb.simulate(
            question.eqs, END, times=TIMES, inputs=question.laws, events=question.events, **method
        )  # fmt: skip
        if not run.success:
            raise Ended(run.status.name)
        return [Motion(run.t, {name: run[name] for name in question.watched})]

    return consume


def by_stepper(**method: Any) -> Consumer:
    def consume(question: Question) -> list[Motion]:
        stepper = sb.Stepper(
            question.eqs, END / (TIMES.size - 1), inputs=question.laws, events=question.events, **method
        )  # fmt: skip
        t, rows = [stepper.t], [[stepper[name] for name in question.watched]]
        for _ in TIMES[1:]:
            if stepper.status is sb.Status.STOPPED:
                break
            stepper.step()
            t.append(stepper.t)
            rows.append([stepper[name] for name in question.watched])
        return [Motion(np.array(t), dict(zip(question.watched, np.array(rows, float).T, strict=True)))]

    return consume


def by_lanes(**method: Any) -> Consumer:
    """Two lanes; in the second one a coordinate begins elsewhere."""

    def consume(question: Question) -> list[Motion]:
        shifted = {question.freely: [0.0, SHIFT]} if question.freely else {}
        lanes = sb.LaneStepper(
            question.eqs, END / (TIMES.size - 1), 2, initial=shifted, inputs=question.laws,
            events=question.events, **method,
        )  # fmt: skip
        t, rows = [lanes.t.copy()], [[lanes[name].copy() for name in question.watched]]
        for _ in TIMES[1:]:
            if sb.Status.STOPPED in lanes.status:
                break
            lanes.step()
            t.append(lanes.t.copy())
            rows.append([lanes[name].copy() for name in question.watched])
        values = np.array(rows, float)
        return [
            Motion(
                np.array(t)[:, lane], dict(zip(question.watched, values[:, :, lane].T, strict=True)),
                {name: starts[lane] for name, starts in shifted.items()},
            )
            for lane in range(2)
        ]  # fmt: skip

    return consume


def by_sweep(**method: Any) -> Consumer:
    """Two cases; in the second one a coordinate begins elsewhere."""

    def consume(question: Question) -> list[Motion]:
        name = question.freely or next(iter(question.fragments[0].initial))
        first = next(fragment.initial[name] for fragment in question.fragments if name in fragment.initial)
        starts = [first, SHIFT] if question.freely else [first, first]
        sweep = sb.sweep(
            question.eqs, END, {}, initial={name: starts}, times=TIMES, inputs=question.laws, events=question.events, **method
        )  # fmt: skip
        motions = []
        for case, start in enumerate(starts):
            if sweep.status[case] is sb.Status.NOT_STARTED:
                raise Ended(re.findall(r"\[([a-z_.]+)\]", sweep.case_notes[case])[0])
            if sweep.status[case] not in (sb.Status.SUCCESS, sb.Status.STOPPED):
                raise Ended(sweep.status[case].name)
            run = sweep.trajectory(case)
            shift = {name: start - first} if question.freely else {}
            motions.append(Motion(run.t, {word: run[word] for word in question.watched}, shift))
        return motions

    return consume


def columns(text: str) -> list[Motion]:
    header, *rows = csv.reader(text.strip().splitlines())
    values = np.array(rows, float)
    return [Motion(values[:, 0], dict(zip(header[1:], values[:, 1:].T, strict=True)))]


def run_in(folder: Path, *command: str) -> str:
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=BEARABLE_SECONDS, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def by_program(language: str, **method: Any) -> Consumer:
    def consume(question: Question) -> list[Motion]:
        text = sb.generate_simulation(
            question.eqs, END, language, times=TIMES, events=question.events, **method
        )
        if language == "javascript":
            (question.folder / "motion.js").write_text(text)
            return columns(run_in(question.folder, "node", "motion.js"))
        (question.folder / "motion.c").write_text(text)
        run_in(
            question.folder, "cc", "-std=c99", "-O1", "-ffp-contract=off", "motion.c", "-o", "motion", "-lm"
        )
        return columns(run_in(question.folder, "./motion"))

    return consume


FRAMES = """
import { makeSimulation } from "./page.mjs";
const s = makeSimulation();
const rows = [[s.time, ...s.state]];
for (const t of TIMES.slice(1)) { if (s.code !== 0) break; s.advanceTo(t); rows.push([s.time, ...s.state]); }
console.log(NAMES + "\\n" + rows.map((row) => row.join(",")).join("\\n"));
"""


def by_page(question: Question) -> list[Motion]:
    """Frames of a live page, by its program under Node."""
    page = sb.animate(
        question.eqs, question.folder / "page.html", live=True, rtol=1e-9, events=question.events
    )
    (question.folder / "page.mjs").write_text(page.program.module, encoding="utf-8")  # type: ignore[union-attr]
    names = json.dumps(",".join(["t", *question.eqs.state_names, "work"]))
    script = FRAMES.replace("TIMES", json.dumps(TIMES.tolist())).replace("NAMES", names)
    (question.folder / "frames.mjs").write_text(script)
    return columns(run_in(question.folder, "node", "frames.mjs"))


def by_fmu(kind: str, tolerance: float) -> Consumer:
    """Steps of co-simulation by hand; in model exchange FMPy's CVODE integrates."""

    def consume(question: Question) -> list[Motion]:
        path = question.folder / "motion.fmu"
        if not path.exists():
            others = [name for name in question.watched if name not in question.eqs.state_names]
            sb.save_fmu(question.eqs, path, outputs=others, events=question.events, sources=False)
        if kind == "CoSimulation":
            return [steps_of(path, question, tolerance)]
        # Events are samples, so that the last one is where a motion stops.
        result = fmpy.simulate_fmu(
            str(path), stop_time=END, output_interval=END / (TIMES.size - 1), relative_tolerance=tolerance,
            fmi_type=kind, output=question.watched, record_events=True,
        )  # fmt: skip
        return [Motion(np.array(result["time"]), {name: np.array(result[name]) for name in question.watched})]

    return consume


def steps_of(path: Path, question: Question, tolerance: float) -> Motion:
    """Steps of an FMU until it says that it ends, and when."""
    with instance(path, "CoSimulation") as fmu:
        fmu.initialize(tolerance=tolerance)
        t, rows = [0.0], [fmu.get(*question.watched)]
        for start, end in zip(TIMES, TIMES[1:], strict=False):
            _, ends, _, reached = fmu.fmu.doStep(start, end - start)
            t.append(reached if ends else end)
            rows.append(fmu.get(*question.watched))
            if ends:
                break
    return Motion(np.array(t), dict(zip(question.watched, np.array(rows).T, strict=True)))


@dataclass(frozen=True)
class Way:
    """A consumer, what it takes for one tolerance, and whether it runs without Python."""

    consume: Consumer
    tolerance: float
    is_alone: bool = False
    step: float = 0.0


# The tolerance of a way is what its results agree to; fifty of them are allowed. An explicit method adds errors of
# rtol at each of its some hundred steps, in all directions. Backward differentiation loses up to a hundred tolerances
# in as many steps (docs/fmu.md), so it gets a hundredth of what is asked for. A method of order 2 adds an error of
# one sign at each step: 6/(12 rtol)^(1/3) = 260 of them for cos(6 t), so it gets a tenth. RK4 by 1/4000 s is wrong
# by 1e-12 where forces are smooth, and by step^2/8 times their slope in the step in which a contact begins: 2e-5. Where an event shifts its steps, a jump of
# a force lies inside of one, which reads it at its ends: an error of the step times the jump (docs/limits.md).
WAYS: dict[str, Way] = {
    "simulate": Way(by_simulate(rtol=1e-9), 1e-9),
    "simulate order 5": Way(by_simulate(rtol=1e-9, integrator=sb.Explicit(order=5)), 1e-9),
    "simulate FixedStep": Way(by_simulate(integrator=sb.FixedStep(1 / 4000)), 1e-6, step=1 / 4000),
    "simulate Stiff": Way(by_simulate(rtol=1e-10, integrator=sb.Stiff()), 1e-8),
    "simulate GeneralizedAlpha": Way(by_simulate(rtol=1e-6, integrator=sb.GeneralizedAlpha()), 1e-5),
    "simulate GGL": Way(by_simulate(rtol=1e-10, constraints=sb.GGL()), 1e-8),
    "simulate Baumgarte": Way(by_simulate(rtol=1e-9, constraints=sb.Baumgarte()), 1e-9),
    "simulate Partition": Way(by_simulate(rtol=1e-9, constraints=sb.Partition()), 1e-9),
    "Stepper": Way(by_stepper(rtol=1e-9), 1e-9),
    "Stepper Stiff": Way(by_stepper(rtol=1e-10, integrator=sb.Stiff()), 1e-8),
    "LaneStepper": Way(by_lanes(rtol=1e-9), 1e-9),
    "sweep": Way(by_sweep(rtol=1e-9), 1e-9),
    "sweep Stiff": Way(by_sweep(rtol=1e-10, integrator=sb.Stiff()), 1e-8),
    "C": Way(by_program("c", rtol=1e-9), 1e-9, is_alone=True),
    "C GeneralizedAlpha": Way(
        by_program("c", rtol=1e-6, integrator=sb.GeneralizedAlpha()), 1e-5, is_alone=True
    ),
    "JavaScript": Way(by_program("javascript", rtol=1e-9), 1e-9, is_alone=True),
    "live page": Way(by_page, 1e-9, is_alone=True),
    "FMU co-simulation": Way(by_fmu("CoSimulation", 1e-9), 1e-9, is_alone=True),
    "FMU model exchange": Way(by_fmu("ModelExchange", 1e-10), 1e-8, is_alone=True),
}
TOLERANCES = 50


def names_for(way: str, names: tuple[str, ...]) -> tuple[str, ...]:
    """The fragments that a consumer may have."""
    return tuple(name for name in names if not (WAYS[way].is_alone and name in PYTHON_ONLY))


def errors(question: Question, motion: Motion, way: Way) -> Values:
    """Errors of values, in tolerances."""
    tolerance = way.tolerance
    end = min([END, *(fragment.end for fragment in question.fragments)])
    found: dict[str, Any] = {"the end": np.abs(motion.t[-1] - end) / tolerance}
    for fragment in question.fragments:
        expected = fragment.reference(motion.t)
        at_jump = np.any([np.abs(motion.t - t) < 1e-6 for t in fragment.jumps], axis=0)
        for name, scale in fragment.scales.items():
            if name not in motion.values:
                continue  # a program prints states alone
            error = np.abs(motion.values[name] - expected[name] - motion.shift.get(name, 0.0))
            error = np.maximum(error - way.step * fragment.force_jump, 0.0) / scale / tolerance
            found[name] = np.where(at_jump, 0.0, error) if name.endswith("_dot") and fragment.jumps else error
    return found


def outcome(question: Question, way: str) -> str:
    """What a consumer makes of a motion: "right", "wrong" with the values that are, a code or a status."""
    chosen = WAYS[way]
    try:
        motions = chosen.consume(question)
    except sb.SymbodyError as error:
        return error.problems[0].code
    except Ended as error:
        return str(error)
    wrong = {
        name
        for motion in motions
        for name, error in errors(question, motion, chosen).items()
        if not np.all(error <= TOLERANCES)
    }
    return f"wrong: {', '.join(sorted(wrong))}" if wrong else "right"
