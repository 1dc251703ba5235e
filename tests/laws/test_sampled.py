"""Sampled signals on random mechanisms: those that nothing reads change no bit of a motion."""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from tests.laws.building import build_model
from tests.laws.consistent_states import consistent_state
from tests.laws.mechanisms import random_mechanism
from tests.laws.motions import ATOL, MOST_STEPS, RTOL
from tests.laws.tally import chunks, name_of

NUMBER = 300
SHARE = 0.2  # of the mechanism's unit of time


def sampled_signals(eqs: sb.EquationSet, unit: float, rng: random.Random) -> list[sb.Signal | sb.PID]:
    """Signals that read states, outputs and each other, sampled at several rates."""
    state = rng.choice([*eqs.state_names, "t"])
    body = rng.choice([body.name for body in eqs.model.bodies])
    return [
        sb.Signal("sampled_state", state, sample=rng.uniform(0.01, 0.3) * unit),
        sb.Signal("sampled_place", output=f"frame r {body} ground ground x", sample=0.05 * unit),
        sb.Signal("sampled_sum", "sampled_sum + sampled_state", sample=0.1 * unit, initial=1),
        sb.PID("sampled_servo", f"sampled_sum - {state}", {"p": 1, "i": 2, "d": 3}, sample=0.07 * unit),
    ]


def run_of(model: sb.Model, known: dict[str, float], span: tuple[float, float]) -> sb.Trajectory:
    eqs = sb.form_equations(model)
    guess = {name: known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
    inputs = {name: known[name] for name in model.inputs}
    return sb.simulate(eqs, span, guess=guess, inputs=inputs, rtol=RTOL, atol=ATOL, max_steps=MOST_STEPS)


def with_elements(model: sb.Model, elements: Iterable[object]) -> sb.Model:
    return sb.Model(
        model.name, [*model.elements, *elements], model.gravity, model.parameters, model.inputs, model.initial,
        model.ground, (), model.ground_shapes,
    )  # fmt: skip


def check(seeds: Iterable[int]) -> None:
    sampled = 0
    for seed in seeds:
        mechanism = random_mechanism(seed)
        state, unit = consistent_state(mechanism), mechanism.units.time
        model, span = build_model(mechanism), (state.t, state.t + SHARE * unit)
        plain = run_of(model, state.known, span)
        more = sampled_signals(sb.form_equations(model), unit, random.Random(f"sampled {seed}"))
        run = run_of(with_elements(model, more), state.known, span)
        for name in ("t", "q", "u"):
            assert getattr(run, name).tobytes() == getattr(plain, name).tobytes(), (seed, name)
        if not plain.success or plain.t[-1] == span[0]:
            continue
        assert run.held_values is not None
        sampled += run.held_values.t.size
        instants = run.held_values.t[
            np.isclose((run.held_values.t - span[0]) / (0.05 * unit) % 1.0, 0.0, atol=1e-9)
        ]
        found = run.at(instants)
        size = np.abs(found["sampled_place"]).max()
        np.testing.assert_allclose(found["sampled_place"], found[str(more[1].output)], atol=1e-12 * size)
    assert sampled


def test_sampled_signals_that_nothing_reads_change_no_bit() -> None:
    check((0, 1))


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(NUMBER), ids=name_of)
def test_sampled_signals_that_nothing_reads_change_no_bit_often(seeds: range) -> None:
    check(seeds)
