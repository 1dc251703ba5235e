"""Derivations as a whole: memory, threads, determinism, frozen results."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import FrozenInstanceError

import pytest

import symbody as sb


def chain(links: int) -> sb.Model:
    """A chain of links turning about alternating axes."""
    elements: list[object] = []
    for k in range(links):
        frames = {"in": sb.Frame(at=(0, 0, "-l")), "out": sb.Frame(at=(0, 0, "l"))}
        elements.append(sb.Body(f"B{k}", mass="m", inertia=("A", "A", "C"), frames=frames))
        start = "ground" if k == 0 else f"B{k - 1}.out"
        elements.append(sb.Revolute(f"J{k}", start, f"B{k}.in", axis="xyz"[k % 3], coordinate=f"q{k}"))
    parameters = {"m": 1, "l": 0.5, "A": 0.2, "C": 0.1, "g": 9.81}
    return sb.Model("chain", elements, gravity=(0, "-g", 0), parameters=parameters)


def derived(links: int) -> str:
    return sb.generate_code(sb.form_equations(chain(links)), ["xdot", "kinetic_energy"])


@pytest.mark.exhaustive
@pytest.mark.parametrize("times", [150, pytest.param(1000, marks=pytest.mark.exhaustive)])
def test_many_derivations_leave_memory_constant(times: int) -> None:
    model = chain(2)

    def repeat(times: int) -> None:
        for _ in range(times):
            eqs = sb.form_equations(model)
            eqs.roots("xdot")
        gc.collect()

    repeat(30)
    tracemalloc.start()
    repeat(30)
    before = tracemalloc.get_traced_memory()[0]
    eqs = sb.form_equations(model)
    eqs.roots("xdot")
    one = tracemalloc.get_traced_memory()[0] - before
    del eqs
    repeat(times)
    grown = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    # What the interpreter itself caches stays far below what one derivation holds.
    assert grown < one


def test_two_threads_derive_at_once_with_the_serial_result() -> None:
    serial = [derived(links) for links in (3, 4, 3, 4)]
    with ThreadPoolExecutor(2) as pool:
        parallel = list(pool.map(derived, (3, 4, 3, 4)))
    assert parallel == serial


@pytest.mark.exhaustive
def test_every_process_generates_the_same_bytes() -> None:
    script = "from tests.equations.test_derivation import derived; print(derived(3))"
    texts = {
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": seed, "SYMBODY_CACHE": "off"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("0", "1", "4711")
    }
    assert len(texts) == 1 and "int f(" in texts.pop()


def test_results_are_frozen() -> None:
    eqs = sb.form_equations(chain(1))
    with pytest.raises(FrozenInstanceError):
        eqs.model = chain(2)  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        eqs.model.name = "other"  # type: ignore[misc]


def test_formulas_too_long_to_write_come_with_definitions() -> None:
    # Nine links about alternating axes: entries of more than 20,000 operations written out.
    eqs = sb.form_equations(chain(9))
    values = {symbol: 0.3 + k / 10 for k, symbol in enumerate((*eqs.parameters, *eqs.states))}
    assert eqs.definitions
    known = dict(values)
    for symbol, expression in eqs.definitions:
        known[symbol] = expression.xreplace(known).evalf(30)
    found = eqs.mass_matrix.xreplace(known).evalf(30)
    f = sb.compile(eqs, "mass_matrix", parameters={str(p): values[p] for p in eqs.parameters})
    states = [values[x] for x in eqs.states]
    expected = f.of_state(0.0, states)
    # Entries are sums of some hundred products of numbers below 10.
    assert max(abs(float(found[i, j]) - expected[i, j]) for i in range(9) for j in range(9)) < 1e-11
