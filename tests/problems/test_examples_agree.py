"""Every example: four ways to its accelerations, and the same mechanism in other axes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.evaluate import evaluate_sequence
from tests.codegen.native import call_address
from tests.problems.mechanisms import (
    EPS,
    NAMES,
    Array,
    State,
    condition,
    data_of,
    equations_of,
    motions,
    numbers_of,
    random_values,
    state_of,
    turned,
)
from tests.tiers import cases

GCC = shutil.which("gcc")
T = dynamicsymbols._t


def closed_form(eqs: sb.EquationSet) -> Callable[[State], Array]:
    """Accelerations and multipliers from the SymPy matrices, solved numerically."""
    q, u, r = (sp.symbols(f"{letter}0:{len(group)}") for letter, group in
               (("q_", eqs.coordinates), ("u_", eqs.speeds), ("r_", eqs.inputs)))  # fmt: skip
    # Derivatives first: a rate contains its coordinate.
    plain = [
        *zip(eqs.speeds, u, strict=True),
        *zip(eqs.coordinates, q, strict=True),
        *zip(eqs.inputs, r, strict=True),
    ]
    values = {sp.Symbol(name): value for name, value in numbers_of(eqs.model).items()}

    def numeric(matrix: sp.Matrix) -> sp.Matrix:
        for old, new in plain:
            matrix = matrix.xreplace({old: new})
        return matrix.xreplace(values)

    rates = numeric(sp.Matrix([equation.rhs for equation in eqs.kinematic_equations]))
    velocity = numeric(eqs.velocity_constraints)
    gamma = -(velocity.jacobian(q) * rates) if velocity.rows else velocity
    matrices = [numeric(eqs.mass_matrix), numeric(eqs.forcing), numeric(eqs.constraint_jacobian), gamma]
    function = sp.lambdify([q, u, r], matrices, "numpy")

    def solve(state: State) -> Array:
        M, F, J, g = (np.array(part, dtype=float) for part in function(state.q, state.u, state.r))
        J, g = J.reshape(-1, len(M)), g.reshape(-1)
        K = np.block([[M, -J.T], [J, np.zeros((len(J), len(J)))]])
        solution: Array = np.linalg.solve(K, np.concatenate([F.ravel(), g]))
        return solution

    return solve


def c_function(eqs: sb.EquationSet, folder: Path) -> Callable[[State], Array]:
    assert GCC is not None
    (folder / "f.c").write_text(
        sb.generate_code(eqs, ["udot", "lambda"], "c", parameters={}), encoding="ascii"
    )
    command = [GCC, "-std=c99", "-Wall", "-Werror", "-O1", "-shared", "-fPIC", "-o", "f.so", "f.c", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "f.so"))
    sequence, _ = form_sequence(eqs, ["udot", "lambda"])

    def call(state: State) -> Array:
        groups = {"t": [0.0], "q": list(state.q), "u": list(state.u), "r": list(state.r)}
        address = ctypes.cast(library["f"], ctypes.c_void_p).value
        assert address is not None
        status, found = call_address(address, sequence, groups, library["f_work_size"]())
        assert status == 0
        return np.array(found)

    return call


@pytest.mark.skipif(GCC is None, reason="needs gcc")
@pytest.mark.parametrize("name", cases(NAMES, fast=lambda name: "spatial" not in name))
def test_four_ways_to_the_accelerations(name: str, tmp_path: Path) -> None:
    eqs = equations_of(name)
    rng = np.random.default_rng(1)
    symbolic, compiled = closed_form(eqs), sb.compile(eqs, ["udot", "lambda"])
    text = c_function(eqs, tmp_path)
    sequence, _ = form_sequence(eqs, ["udot", "lambda"])
    for _ in range(20):
        state = state_of(eqs, random_values(eqs, rng))
        reference = symbolic(state)
        # Each way solves with a backward error of some eps; the forcing is summed from some ten terms.
        tolerance = 100 * EPS * condition(eqs, state) * max(1.0, np.abs(reference).max())
        groups = {"t": [0.0], "q": list(state.q), "u": list(state.u), "r": list(state.r)}
        plain = np.concatenate(evaluate_sequence(sequence, groups))
        native = np.concatenate(compiled(0.0, state.q, state.u, state.r))
        assert np.abs(plain - reference).max() < tolerance
        assert np.abs(native - reference).max() < tolerance
        assert np.abs(text(state) - reference).max() < tolerance
        # The sequence is one and the same; only sin and cos differ, by 1.5 ulp.
        assert np.abs(native - plain).max() < tolerance


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", NAMES)
def test_the_mechanism_turned_as_a_whole_moves_alike(name: str) -> None:
    eqs = equations_of(name)
    rng = np.random.default_rng(2)
    for _ in range(3):
        other = sb.form_equations(turned(data_of(name), rng))
        assert other.coordinate_names == eqs.coordinate_names and other.speed_names == eqs.speed_names
        joints = [f"reaction {joint.name}" for joint in eqs.model.joints]
        here, there = (sb.compile(each, ["udot", "kinetic_energy", *joints]) for each in (eqs, other))
        for _ in range(10):
            state = state_of(eqs, random_values(eqs, rng))
            expected, found = here(0.0, state.q, state.u, state.r), there(0.0, state.q, state.u, state.r)
            # Entries of turned vectors and tensors are rounded: some eps of the largest.
            tolerance = 100 * EPS * condition(eqs, state)
            for a, b in zip(expected, found, strict=True):
                assert np.abs(a - b).max() < tolerance * max(1.0, np.abs(a).max())


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_are_the_time_derivatives_of_velocities(name: str) -> None:
    """Along one state's own motion, by central differences: v' = vdot and w' = wdot of every body."""
    eqs = equations_of(name)
    rng = np.random.default_rng(3)
    measure, xdot = motions(eqs), sb.compile(eqs, "xdot")
    for _ in range(5):
        state = state_of(eqs, random_values(eqs, rng))
        rate = xdot(0.0, state.q, state.u, state.r)
        n = len(state.u)
        h = 1e-5
        after, before = (
            measure(State(state.q + k * rate[n:], state.u + k * rate[:n], state.r)) for k in (h, -h)
        )
        now = measure(state)
        for body in eqs.model.bodies:
            for slow, fast in (("r", "v"), ("v", "vdot"), ("w", "wdot")):
                old, new = (f"frame {kind} {body.name} ground ground" for kind in (slow, fast))
                difference = (after[old] - before[old]) / (2 * h)
                # h^2/6 third derivatives (up to 1e3 here) + eps/h rounding of values up to 10: below 1e-7.
                assert difference == pytest.approx(now[new], abs=1e-7 * max(1.0, np.abs(rate).max() ** 3))
