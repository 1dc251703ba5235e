"""python-control takes what linearization gives: the same poles, the same motion, a feedback that holds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import symbody as sb
from tests.analysis.test_linearize import cart_pendulum, four_bar
from tests.spectra import assert_same_spectrum

control = pytest.importorskip("control", reason="python-control is not installed")


def test_poles_and_names() -> None:
    lin = sb.linearize(cart_pendulum(), outputs=["x", "phi"])
    system = lin.to_control()
    assert list(system.state_labels) == ["x_dot", "phi_dot", "x", "phi"]
    assert list(system.input_labels) == ["F"] and list(system.output_labels) == ["x", "phi"]
    assert_same_spectrum(control.poles(system), lin.eigenvalues, atol=1e-9)
    loop = sb.linearize(four_bar(), {"q1": -1.2})
    assert loop.to_control().nstates == 2 and loop.to_control().ninputs == 0


def test_the_response_is_that_of_the_matrices() -> None:
    lin = sb.linearize(cart_pendulum(), {"phi": "pi"}, cyclic=["x"], outputs=["phi"])
    start, times = np.array([0.1, 0.0, 0.02]), np.linspace(0.0, 1.0, 11)
    response = control.initial_response(lin.to_control(), times, start)
    wanted = [(lin.C @ expm(lin.A * t) @ start)[0] for t in times]
    # control integrates by matrix exponentials of steps: some roundings a step.
    assert np.ravel(response.outputs) == pytest.approx(wanted, abs=1e-10)


def test_its_feedback_holds_the_full_equations() -> None:
    lin = sb.linearize(cart_pendulum())
    gain, _, poles = control.lqr(lin.to_control(), np.eye(4), np.eye(1))
    law = " ".join(f"{-k:+.17g}*{name}" for k, name in zip(gain[0], lin.state_names, strict=True))
    run = sb.simulate(cart_pendulum(), 12.0, {"phi": 0.1}, inputs={"F": law})
    assert poles.real.max() < -0.5 and run.success
    assert np.abs(run.q[:, -1]).max() < 1e-3
