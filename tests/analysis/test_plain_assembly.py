"""First states by the compiled kernel are those of `assemble_taut`, and what is not plain is left to it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.configurations.assembly import assemble_taut
from symbody.analysis.configurations.kept_values import kept_initial_values
from tests.mechanisms import example
from tests.tiers import cases

EXAMPLES = Path(__file__).parents[2] / "examples"
PATHS = sorted(EXAMPLES.glob("*/*.toml"))


def both(
    eqs: sb.EquationSet, fixed: Mapping[str, Any], guess: Mapping[str, Any], **more: Any
) -> tuple[sb.State, sb.State]:
    """Return the state by the kernel, if it is plain, and the one by Python."""
    kept = kept_initial_values(eqs, fixed, guess)
    return (
        sb.assemble(eqs, fixed, guess, **more),
        assemble_taut(eqs, {**fixed, **kept}, guess, more.get("parameters"), more.get("inputs")),
    )


def agree(ours: sb.State, theirs: sb.State) -> None:
    for name in ("q", "u", "udot", "multipliers", "moved"):
        a, b = getattr(ours, name), getattr(theirs, name)
        assert list(a) == list(b)
        scale = max(map(abs, b.values()), default=0.0)
        np.testing.assert_allclose([*a.values()], [*b.values()], rtol=1e-9, atol=1e-9 * (1.0 + scale))
    assert ours.has_dependent_constraints == theirs.has_dependent_constraints


@pytest.mark.parametrize(
    "path", cases(PATHS, fast=lambda path: path.stem != "stewart_platform"), ids=lambda path: path.stem
)
def test_examples_start_as_by_python(path: Path) -> None:
    eqs = sb.form_equations(sb.load_model(path))
    ours, theirs = both(eqs, {}, {})
    assert (ours.plain is None) == bool(eqs.signal_state_names)  # these Python completes
    assert theirs.plain is None
    assert ours.plain is None or ours.plain.is_regular
    agree(ours, theirs)


@pytest.mark.parametrize("name", ["slider_crank", "four_bar", "spatial_four_bar"])
def test_any_values_and_guesses_start_as_by_python(name: str) -> None:
    eqs = example(name)
    random = np.random.default_rng(5)
    used = 0
    for _ in range(15):
        angle, speed = eqs.coordinate_names[0], eqs.speed_names[0]
        fixed = {angle: float(random.uniform(-1.0, 1.0)), speed: float(random.normal())}
        guess = dict(zip(eqs.coordinate_names[1:], random.normal(size=9) * 0.5, strict=False))
        guess |= {eqs.speed_names[1]: 1.0}
        try:
            ours, theirs = both(eqs, fixed, guess)
        except sb.AssemblyError:
            continue
        agree(ours, theirs)
        used += ours.plain is not None
    assert used > 5


def test_new_values_of_parameters_and_inputs_count() -> None:
    eqs = example("slider_crank")
    more = {"parameters": {"m2": 2.5}, "inputs": {eqs.input_names[0]: 3.0}}
    ours, theirs = both(eqs, {eqs.speed_names[0]: 1.0}, {}, **more)
    agree(ours, theirs)
    assert ours.udot != sb.assemble(eqs, {eqs.speed_names[0]: 1.0}).udot


def test_quaternions_keep_norm_one() -> None:
    eqs = example("stewart_platform")
    names = eqs.quaternions[0]
    ours, theirs = both(eqs, {}, {names[1]: 0.4, names[2]: 0.1})
    agree(ours, theirs)
    assert ours.plain is not None
    assert sum(ours.q[name] ** 2 for name in names) == pytest.approx(1.0, rel=1e-14)


def test_what_is_not_plain_is_left_to_python() -> None:
    eqs = example("slider_crank")
    rates = [f"{name}_dot" for name in eqs.coordinate_names]
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs, dict.fromkeys(rates, 1.0))
    assert caught.value.problems[0].code == "assembly.velocity_conflict"
    with pytest.raises(sb.AssemblyError) as caught:
        sb.assemble(eqs, dict.fromkeys(eqs.coordinate_names, 1.0))
    assert caught.value.problems[0].code == "assembly.conflict"
    assert sb.assemble(eqs, ranges={eqs.coordinate_names[0]: (-3.0, 3.0)}).plain is None


def test_branches_are_those_of_python() -> None:
    ours, theirs = both(example("four_bar"), {"theta": 0.5}, {})
    assert ours.plain is not None
    assert len(ours.branches) == len(theirs.branches) > 0
    for a, b in zip(ours.branches, theirs.branches, strict=True):
        agree(a, b)
