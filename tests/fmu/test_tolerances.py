"""FMUs at three tolerances: their errors are those of the motion, not of the export."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symbody as sb
from tests.fmu.importer import KINDS, NAMES, simulate, states
from tests.mechanisms import example

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
END = 1.0
TIMES = np.linspace(0.0, END, 21)
TOLERANCES = (1e-4, 1e-6, 1e-8)
FAST = ("rr_robot", "slider_crank")
# A test of its own; and an integrator that begins anew at samples adds errors, see test_samples.
ELSEWHERE = ("stewart_platform", "cart_pole_pid")


def growth_in_model_exchange(eqs: sb.EquationSet, exact: Any, sizes: Any) -> float:
    """Return by how much errors grow over tolerances in the equations of model exchange.

    It is measured by another integrator of the kind of FMPy's CVODE: backward differentiation formulas, at the
    tolerances that FMPy gives CVODE.
    """
    f = sb.compile(sb.Baumgarte().applied(eqs) if eqs.multiplier_names else eqs, "xdot")
    r = [0.0] * len(eqs.input_names)
    growths = [1.0]
    for tolerance in TOLERANCES:
        run = solve_ivp(
            lambda t, x: f.of_state(t, x, r), (0.0, END), exact[:, 0], method="BDF", rtol=tolerance,
            atol=tolerance * sizes, t_eval=TIMES,
        )  # fmt: skip
        growths.append(error(run.y, exact, sizes) / tolerance)
    return max(growths)


def growth_in_simulate(eqs: sb.EquationSet, exact: Any, sizes: Any) -> float:
    """Return by how much errors of `simulate` grow over its tolerance."""
    return max(
        1.0, *(error(run_of_simulate(eqs, tolerance), exact, sizes) / tolerance for tolerance in TOLERANCES)
    )


def run_of_simulate(eqs: sb.EquationSet, rtol: float) -> Any:
    """Return the states without inputs: in an FMU also those are 0 that follow a table in the model."""
    return states(sb.simulate(eqs, END, times=TIMES, rtol=rtol, inputs=dict.fromkeys(eqs.input_names, 0)))


def error(x: Any, exact: Any, sizes: Any) -> float:
    return float((np.abs(x - exact) / sizes[:, np.newaxis]).max())


def check_errors(name: str, version: str, path: Path) -> None:
    eqs = example(name)
    made = sb.save_fmu(eqs, path, version)  # type: ignore[arg-type]
    nominal = {v.name: v.nominal for v in made.variables}
    exact = run_of_simulate(eqs, 1e-12)
    sizes = np.array([nominal[name] for name in eqs.state_names])
    sizes = np.maximum(sizes, np.abs(exact).max(axis=1))
    growths = (growth_in_model_exchange(eqs, exact, sizes), growth_in_simulate(eqs, exact, sizes))
    for kind, growth in zip(KINDS, growths, strict=True):
        for tolerance in TOLERANCES:
            seen = error(simulate(made.path, kind, END, eqs.state_names, tolerance), exact, sizes)
            assert seen < 10.0 * tolerance * growth, (kind, tolerance, growth)


@pytest.mark.parametrize("name", FAST)
def test_errors_are_those_of_the_motion(name: str, tmp_path: Path) -> None:
    check_errors(name, "3.0", tmp_path / f"{name}.fmu")


@pytest.mark.exhaustive
@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("name", [name for name in NAMES if name not in ELSEWHERE])
def test_errors_of_all_examples(name: str, version: str, tmp_path: Path) -> None:
    check_errors(name, version, tmp_path / f"{name}.fmu")


@pytest.mark.exhaustive
def test_errors_of_the_stewart_platform(tmp_path: Path) -> None:
    check_errors(
        "stewart_platform", "3.0", tmp_path / "stewart_platform.fmu"
    )  # its compilation takes minutes
