"""Short pulses after a rest are not stepped over, by any integrator, in any way in which they enter."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from tests.laws.pulses import Struck, struck

Floats = NDArray[np.float64]

NUMBER = 2000
RTOL = 1e-9
# A new start by backward differentiation is as short as ATOL over the rate: times as late as 30 s need that long.
ATOL = {"Explicit": 1e-12, "Stiff": 1e-8}
# A run takes some hundred steps, each with an error of RTOL of the largest speed; backward differentiation
# controls the last correction instead, which is some hundred times less exact.
ALLOWED = {"Explicit": 1e-6, "Stiff": 1e-4}
WAYS: list[dict[str, object]] = [
    {},
    {"integrator": sb.Explicit(order=5)},
    {"integrator": sb.Stiff()},
    {"constraints": sb.Partition()},
    {"constraints": sb.GGL()},
    {"constraints": sb.Baumgarte()},
]


def error(case: Struck, way: dict[str, object], atol: float, rng: np.random.Generator) -> float:
    """How far a motion ends from the exact one, relative to the larger of speed and displacement."""
    eqs = sb.form_equations(case.model)
    times = [None, [case.end], np.linspace(0.0, case.end, 7)][rng.integers(3)]
    run = sb.simulate(
        eqs,
        case.end,
        inputs=case.inputs,
        times=times,
        rtol=RTOL,
        atol=atol,
        **way,  # type: ignore[arg-type]
    )
    assert run.success, case.words
    return _error(case, eqs, np.concatenate([run.q[:, -1], run.u[:, -1]]))


def _error(case: Struck, eqs: sb.EquationSet, last: Floats) -> float:
    names = (*eqs.coordinate_names, *eqs.speed_names)
    name = "x" if "x" in names else "r"
    found = np.array([last[names.index(name)], last[names.index(f"{name}_dot")]])
    return float(np.abs(found - case.exact).max() / np.abs(case.exact).max())


def check(seed: int) -> None:
    rng = np.random.default_rng([3, seed])
    case = struck(rng)
    way = WAYS[rng.integers(len(WAYS))]
    is_stiff = isinstance(way.get("integrator"), sb.Stiff) or isinstance(way.get("constraints"), sb.GGL)
    kind = "Stiff" if is_stiff else "Explicit"
    found = error(case, way, ATOL[kind], rng)
    assert found < ALLOWED[kind] * case.condition, f"seed {seed}: {found:.3g}, {case.words}, {way}"


# In 84 the steps before a corner add up to the rounding of t less than the way there.
@pytest.mark.parametrize("seed", [*range(12), 84])
def test_pulses_after_a_rest_are_seen(seed: int) -> None:
    check(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(12, NUMBER, 100))
def test_many_pulses_after_a_rest_are_seen(first: int) -> None:
    for seed in range(first, min(first + 100, NUMBER)):
        check(seed)


@pytest.mark.parametrize("lanes", [False, True])
def test_sweeps_see_the_pulses_of_each_case(lanes: bool) -> None:
    """A mass without spring under a force of 1/w for a time w: it goes with v = 1 m/s from then on."""
    joint = sb.Prismatic("j", "ground", "B", axis="x", coordinate="x", force=sb.Drive("F"))
    parameters = {"start": 1, "width": 1}
    eqs = sb.form_equations(
        sb.Model("cart", [sb.Body("B", mass=1), joint], inputs=["F"], parameters=parameters)
    )
    starts, widths = np.linspace(2.0, 8.0, 7), np.geomspace(1e-5, 1e-1, 5)
    values = {"start": np.repeat(starts, widths.size), "width": np.tile(widths, starts.size)}
    laws = {
        "window": "if(t > start and t < start + width, 1/width, 0)",
        "bell": "exp(-((t - start)/width)^2)/width/sqrt(pi)",
    }
    for law in laws.values():
        found = sb.sweep(eqs, 10.0, values, inputs={"F": law}, times=[10.0], combine="list", lanes=lanes)
        np.testing.assert_allclose(found["x_dot"][:, -1], 1.0, rtol=1e-6)
        alone = sb.simulate(
            eqs, 10.0, parameters={"start": starts[1], "width": widths[0]}, inputs={"F": law}, times=[10.0]
        )
        # Both are right to the tolerance of a step; the pieces of time they look at need not be the same.
        np.testing.assert_allclose(found["x_dot"][widths.size, -1], alone["x_dot"][-1], rtol=2e-8)
