"""What JAX and CasADi make of their texts by themselves: derivatives against differences of plain evaluation."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import mpmath
import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from symbody.expr.sequences.sequence import Sequence
from tests.codegen.texts.running import CASADI, JAX, Point
from tests.problems.mechanisms import equations_of, random_values, state_of
from tests.problems.test_parallelogram import parallelogram

JAX_CALLER = """
import json, sys
import jax, jax.numpy as jnp
from made import f
q, u, r = (jnp.array(x, dtype=float) for x in json.load(sys.stdin))
whole = lambda q: jnp.concatenate(list(f(0.5, q, u, r)))
forward, backward = jax.jit(jax.jacfwd(whole))(q), jax.jit(jax.jacrev(whole))(q)
mapped = jax.jit(jax.vmap(whole))(jnp.stack([q, q + 0.1]))
one = jax.grad(lambda q: f(0.5, q, u, r).udot[0])(q)
print(json.dumps([x.tolist() for x in (forward, backward, mapped, jnp.stack([whole(q), whole(q + 0.1)]), one)]))
"""
CASADI_CALLER = """
import json, sys
import casadi as ca, numpy as np
from made import f
q, u, r = json.load(sys.stdin)
x = ca.SX.sym("x", len(q))
results = ca.vertcat(*f(0.5, x, u, r, []))
slope = ca.Function("slope", [x], [ca.jacobian(results, x)])
print(json.dumps([np.array(slope(q)).tolist()]))
"""


def slopes(sequence: Sequence, point: Point) -> np.ndarray:
    """Central differences by the coordinates with 50 digits: errors far below a rounding."""
    with mpmath.workdps(50):
        step = mpmath.mpf(10) ** -15
        columns = []
        for k in range(len(point["q"])):
            ends = []
            for sign in (1, -1):
                moved = {group: [mpmath.mpf(x) for x in values] for group, values in point.items()}
                moved["q"][k] += sign * step
                ends.append([x for each in evaluate_sequence(sequence, moved, MPMATH) for x in each])
            columns.append([float((a - b) / (2 * step)) for a, b in zip(*ends, strict=True)])
    return np.array(columns).T


def ran(interpreter: str | None, text: str, caller: str, point: Point, folder: Path) -> list[np.ndarray]:
    assert interpreter is not None
    (folder / "made.py").write_text(text, encoding="ascii")
    (folder / "caller.py").write_text(caller, encoding="ascii")
    code = f"import sys; sys.path.insert(0, {str(folder)!r}); import caller"
    given = json.dumps([point["q"], point["u"], point["r"]])
    done = subprocess.run(
        [interpreter, "-I", "-c", code], input=given, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return [np.array(x) for x in json.loads(done.stdout)]


def case(name: str) -> tuple[sb.EquationSet, Point]:
    if name == "dead centre":
        return parallelogram(), {"t": [0.5], "q": [0.0] * 3, "u": [0.5, -0.5, 0.5], "r": []}
    eqs = equations_of(name)
    state = state_of(eqs, random_values(eqs, np.random.default_rng(2)))
    return eqs, {"t": [0.5], "q": [*state.q], "u": [*state.u], "r": [*state.r]}


@pytest.mark.skipif(CASADI is None, reason="needs the package casadi")
@pytest.mark.parametrize("name", ["slider_crank", "spinning_top"])
def test_casadi(name: str, tmp_path: Path) -> None:
    eqs, point = case(name)
    outputs = ["udot", "lambda"] if eqs.multiplier_names else ["udot", "qdot"]
    sequence, _ = form_sequence(eqs, outputs)
    (found,) = ran(
        CASADI, sb.generate_code(eqs, outputs, "casadi", parameters={}), CASADI_CALLER, point, tmp_path
    )
    reference = slopes(sequence, point)
    # Condition numbers below 1e3, a hundred operations: 1e5 eps.
    assert np.abs(found - reference).max() < 1e-10 * max(1.0, np.abs(reference).max())


@pytest.mark.exhaustive
@pytest.mark.skipif(JAX is None, reason="needs jax here or an interpreter in SYMBODY_JAX_PYTHON")
@pytest.mark.parametrize("name", ["slider_crank", "spinning_top"])
def test_jax(name: str, tmp_path: Path) -> None:
    eqs, point = case(name)
    outputs = ["udot", "lambda"] if eqs.multiplier_names else ["udot", "qdot"]
    sequence, _ = form_sequence(eqs, outputs)
    text = sb.generate_code(eqs, outputs, "jax", parameters={})
    forward, backward, mapped, separate, one = ran(JAX, text, JAX_CALLER, point, tmp_path)
    reference = slopes(sequence, point)
    bound = 1e-10 * max(1.0, np.abs(reference).max())
    assert np.abs(forward - reference).max() < bound
    assert np.abs(backward - reference).max() < bound
    assert np.abs(one - reference[0]).max() < bound
    assert np.abs(mapped - separate).max() < 1e-11 * max(1.0, np.abs(separate).max())


@pytest.mark.skipif(CASADI is None, reason="needs the package casadi")
def test_casadi_differentiates_at_a_dead_centre(tmp_path: Path) -> None:
    """The rank changes there, so there is no derivative to compare with: it is that of the rows kept."""
    eqs, point = case("dead centre")
    (found,) = ran(
        CASADI,
        sb.generate_code(eqs, ["udot", "lambda"], "casadi", parameters={}),
        CASADI_CALLER,
        point,
        tmp_path,
    )
    assert np.isfinite(found).all()
