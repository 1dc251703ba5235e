"""What is made is handed to other processes and copied; it gives the same there."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.equations.equation_set import EquationSet
from tests.equations.test_columns import random_tree
from tests.formulations import FORMULATIONS
from tests.tiers import cases

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*/*.toml"))
SLIDER_CRANK = next(path for path in EXAMPLES if path.stem == "slider_crank")
OSCILLATOR = next(path for path in EXAMPLES if path.stem == "spring_mass_damper")
CLOSE = {"s": 4.0}


def crank() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(SLIDER_CRANK))


def oscillator() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(OSCILLATOR))


def of_equations(eqs: sb.EquationSet) -> list[Any]:
    names = (
        eqs.coordinate_names,
        eqs.speed_names,
        eqs.input_names,
        eqs.parameter_names,
        eqs.signal_state_names,
    )
    q, u, r, p, s = (np.linspace(0.2, 0.7, len(each)) for each in names)
    f = sb.compile(eqs, ["mass_matrix", "forcing"], free=eqs.parameter_names)
    return [eqs.state_names, eqs.notes, [x.tolist() for x in f(0.3, q, u, r, p, s=s)]]


def of_run(run: sb.Trajectory) -> list[Any]:
    return [run.t.tolist(), run["energy"].tolist(), run.status, run.notes, run.at(run.t[-1] / 2)["theta"]]


def run(**choices: Any) -> sb.Trajectory:
    return sb.simulate(crank(), 0.1, initial={"theta": 0.5}, guess=CLOSE, **choices)


MAKERS: dict[str, tuple[Callable[[], Any], Callable[[Any], Any]]] = {
    "model": (lambda: sb.load_model(SLIDER_CRANK), lambda model: [model.name, model.elements, model.parameters]),
    "equations": (crank, lambda eqs: [*of_equations(eqs), str(eqs.mass_matrix), eqs.degrees_of_freedom]),
    "function": (lambda: sb.compile(oscillator(), "udot"), lambda f: f(0.0, [0.1], [0.2], [0.0] * len(f.signature.r)).tolist()),
    "state": (lambda: sb.assemble(crank(), {"theta": 0.6}, guess=CLOSE),
              lambda state: [state.q, state["energy"], [other.q for other in state.branches]]),
    "equilibrium": (lambda: sb.find_equilibrium(oscillator()), lambda rest: [rest.q, rest.verdict]),
    "linearization": (lambda: sb.linearize(oscillator()), lambda lin: [lin.A.tolist(), lin.verdict]),
    "run": (run, of_run),
    "run with events": (partial(run, events=[sb.Event("theta - 0.45")]), of_run),
    "run by GGL": (partial(run, constraints=sb.GGL(), integrator=sb.Stiff()), of_run),
    "ratios": (lambda: sb.velocity_ratios(crank(), "theta"),
               lambda ratios: ratios.at(sb.assemble(ratios.eqs, {"theta": 0.6}, guess=CLOSE)).tolist()),
    "sweep": (lambda: sb.sweep(crank(), 0.05, {"m1": [1.0, 2.0]}, guess=CLOSE),
              lambda sweep: [sweep["theta"].tolist(), sweep["energy"].tolist()]),
    "inverse dynamics": (lambda: sb.inverse_dynamics(crank(), {"theta": "0.5 + t"}, "F", [0.0, 0.1], guess=CLOSE),
                         lambda found: found["F"].tolist()),
}  # fmt: skip


def answer(kind: str, thing: Any) -> Any:
    return repr(MAKERS[kind][1](thing))


@pytest.fixture(scope="module")
def worker() -> Iterator[ProcessPoolExecutor]:
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        yield pool


@pytest.mark.parametrize("kind", cases(MAKERS, fast=lambda kind: kind != "run by GGL"))
def test_another_process_has_the_same(kind: str, worker: ProcessPoolExecutor) -> None:
    thing = MAKERS[kind][0]()
    expected = answer(kind, thing)
    assert worker.submit(answer, kind, thing).result() == expected
    assert answer(kind, copy.deepcopy(thing)) == expected
    assert answer(kind, copy.copy(thing)) == expected


def whole(eqs: sb.EquationSet) -> sb.EquationSet:
    """The equations as derived ones are handed over: with their whole graph."""
    return EquationSet(eqs.model, eqs.formed, eqs.notes)


def check_whole(eqs: sb.EquationSet) -> None:
    expected = of_equations(eqs)
    assert of_equations(pickle.loads(pickle.dumps(eqs))) == expected
    assert of_equations(pickle.loads(pickle.dumps(whole(eqs)))) == expected


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_equations_of_the_examples(path: Path) -> None:
    check_whole(sb.form_equations(sb.load_model(path)))


WAYS = (None, *FORMULATIONS)


@pytest.mark.parametrize("seed", cases(range(5), fast=[0]))
def test_equations_of_random_trees(seed: int) -> None:
    model = random_tree(seed, 3, floating=bool(seed % 2), loads=("", "own", "tie")[seed % 3])
    check_whole(sb.form_equations(model, WAYS[seed % len(WAYS)]))


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(20))
def test_equations_of_many_random_trees(chunk: int) -> None:
    for seed in range(100 + 10 * chunk, 110 + 10 * chunk):
        model = random_tree(seed, 2 + seed % 5, floating=bool(seed % 2), loads=("", "own", "tie")[seed % 3])
        check_whole(sb.form_equations(model, WAYS[seed % len(WAYS)]))
