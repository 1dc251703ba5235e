"""Laws on the structure of the equations: M, the rows of J, gamma, the rates of position rows, skewness."""

from __future__ import annotations

import random
from typing import Any

import mpmath
import numpy as np
from scipy.linalg import null_space

import symbody as sb
from symbody.expr.calculus import jacobian
from symbody.expr.sequences.sequence import Roots
from tests.laws.agreement import SYSTEM
from tests.laws.consistent_states import State
from tests.laws.evaluation import EPS, arguments, condition, evaluator
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array

DIGITS = 50
STEP = mpmath.mpf(10) ** -15


def mass_matrix_errors(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> dict[str, float]:
    """Asymmetry of M, its least eigenvalue on admissible velocities, and T against u^T M u / 2."""
    found = evaluator(eqs, ["mass_matrix", "jacobian", "kinetic_energy"])(*arguments(eqs, state))
    M, J = found["mass_matrix"], np.atleast_2d(found["jacobian"])
    n = len(M)
    if not n:
        return {}
    d = 1 / np.sqrt(np.where(np.diag(M) > 0, np.diag(M), np.diag(M).max()))
    scaled = M * np.outer(d, d)
    rows = J * d
    rows = rows / np.maximum(np.linalg.norm(rows, axis=1), 1e-300)[:, None]
    free = null_space(rows, rcond=1e-9) if len(rows) else np.eye(n)
    least = np.linalg.eigvalsh(free.T @ scaled @ free).min() if free.shape[1] else 1.0
    errors = {"asymmetry": float(np.abs(scaled - scaled.T).max() / EPS), "indefinite": float(least <= 0)}
    if not any(joint.motions for joint in mechanism.joints):
        u = np.array(state.of(eqs.speed_names))
        terms = np.abs(np.outer(u, u) * M).sum()
        errors["kinetic energy"] = float(
            abs(found["kinetic_energy"] - u @ M @ u / 2) / (EPS * max(terms, 1e-300))
        )
    return errors


def row_errors(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> dict[str, float]:
    """The rows against differences along a flow with constant u, at 50 digits, in units of eps.

    Coordinates are those of the pose, speeds random and not admissible, so that no row is zero. Central
    differences with a step of 1e-15 are exact to 25 digits, so only the formulas are compared; what is left is
    what the derivation rounded when it folded numbers. Positions along the flow give J u + b, its change
    gives gamma, unit speeds give J.
    """
    if not eqs.multiplier_names:
        return {}
    rng = random.Random(f"flow {mechanism.seed}")
    outputs = ["constraints", "velocity_constraints", "gamma", "jacobian", "qdot", "position_jacobian"]
    full, flow, place = (evaluator(eqs, words) for words in (outputs, outputs[:2], outputs[:1]))
    with mpmath.workdps(DIGITS):
        t, q, u, r = ([mpmath.mpf(x) for x in np.atleast_1d(values)] for values in arguments(eqs, state))
        size = np.abs(state.of(eqs.speed_names)).max(initial=0.0) + 1e-3 / mechanism.units.time
        u = [x + mpmath.mpf(rng.uniform(-1, 1) * (abs(float(x)) + 1e-2 * size)) for x in u]
        at = full.precise(t[0], q, u, r)
        h = STEP * mechanism.units.time
        ahead, behind = (flow.precise(t[0] + s, _moved(q, at["qdot"], s), u, r) for s in (h, -h))
        still, back = (place.precise(t[0], _moved(q, at["qdot"], s), u, r) for s in (h, -h))
        rows = at["velocity_constraints"]
        scale = np.abs(at["jacobian"].astype(float)) @ np.abs([float(x) for x in u])
        scale = np.maximum(scale, np.abs(rows.astype(float)))
        scale = np.where(scale > 0, scale, 1.0)
        along = at["position_jacobian"] @ at["qdot"]
        # Constraints on velocities alone come last.
        held = slice(len(along))
        errors = {
            "rate of positions": _apart(_slope(ahead, behind, "constraints", h), rows[held], scale[held]),
            "gamma": _apart(
                -_slope(ahead, behind, "velocity_constraints", h), at["gamma"], _sizes(at, scale, mechanism)
            ),
            "position jacobian": _apart(_slope(still, back, "constraints", h), along, scale[held]),
        }
    return errors | {"jacobian": _column_error(eqs, state)}


def closed_errors(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> dict[str, float]:
    """What is left of the rows at a state that NumPy closed, in units of eps; and the count of the freedoms."""
    outputs = [*SYSTEM, "constraints", "velocity_constraints"]
    found = evaluator(eqs, outputs)(*arguments(eqs, state))
    freedoms = len(eqs.speed_names) - condition(found).rank
    errors = {"freedoms": 0.0 if freedoms == mechanism.freedoms else float("inf")}
    if eqs.multiplier_names:
        u = np.abs(state.of(eqs.speed_names))
        # Speeds are of order one; those that are zero could be of any size up to that.
        scale = np.abs(np.atleast_2d(found["jacobian"])) @ (u + u.max() + 1e-2 / mechanism.units.time)
        places = found["constraints"]
        errors["velocities"] = _apart(found["velocity_constraints"], np.zeros(len(scale)), scale)
        errors["positions"] = _apart(
            places, np.zeros(len(places)), scale[: len(places)] * mechanism.units.time
        )
    return errors


def _column_error(eqs: sb.EquationSet, state: State) -> float:
    """J against the velocity rows with one speed at a time, in floats."""
    t, q, u, r = arguments(eqs, state)
    J = np.atleast_2d(evaluator(eqs, ["jacobian"])(t, q, u, r)["jacobian"])
    f = evaluator(eqs, ["velocity_constraints"])
    rest = f(t, q, [0.0] * len(u), r)["velocity_constraints"]
    top = np.abs(J).max(axis=1, initial=1e-300) + np.abs(rest)
    errors = [0.0]
    for k in range(len(u)):
        ones = [float(j == k) for j in range(len(u))]
        errors.append(_apart(f(t, q, ones, r)["velocity_constraints"] - rest, J[:, k], top))
    return max(errors)


def _sizes(at: dict[str, Array], scale: Array, mechanism: Mechanism) -> Array:
    """The size of gamma's terms: a row's speed over the unit of time."""
    found: Array = np.maximum(np.abs(at["gamma"].astype(float)), scale / mechanism.units.time)
    return found


def _moved(q: list[Any], rates: Array, step: Any) -> list[Any]:
    return [x + step * rate for x, rate in zip(q, rates, strict=True)]


def _slope(ahead: dict[str, Array], behind: dict[str, Array], name: str, h: Any) -> Array:
    found: Array = (ahead[name] - behind[name]) / (2 * h)
    return found


def _apart(a: Array, b: Array, scale: Array) -> float:
    """The largest difference relative to the scale of its row, in units of eps."""
    errors = [float(abs(x - y)) / s for x, y, s in zip(a, b, scale, strict=True)]
    return max(errors, default=0.0) / EPS


def skewness_error(mechanism: Mechanism, eqs: sb.EquationSet, state: State) -> float | None:
    """``u^T (Mdot - 2 C) u = 0``: without loads, T changes by nothing but ``u^T F``.

    With F0 the forcing at the state and G that with all speeds zero times one and two, the quadratic part of the
    forcing is -C u; only mechanisms without motions and dampers have no other part, so it is taken from the
    even part: F(u) + F(-u) - 2 F(0) = -2 C u.
    """
    reads_rates = any("_dot" in term.name for law in _laws(mechanism) for term in law)
    if any(joint.motions for joint in mechanism.joints) or reads_rates or not eqs.speed_names:
        return None
    graph, names = eqs.formed.graph, eqs.formed.names
    mass = eqs.roots("mass_matrix").nodes
    slopes = jacobian(graph, list(mass), [names.value(name).index for name in eqs.coordinate_names])
    flat = tuple(slope for row in slopes for slope in row)
    roots = Roots("slopes", (len(mass), len(eqs.coordinate_names)), flat)
    f = evaluator(eqs, ["forcing", "qdot", roots])
    t, q, u, r = arguments(eqs, state)
    at, back, rest = f(t, q, u, r), f(t, q, [-x for x in u], r), f(t, q, [0.0] * len(u), r)
    v = np.array(u)
    n = len(v)
    changes = (at["slopes"] @ at["qdot"]).reshape(n, n)
    quadratic = (at["forcing"] + back["forcing"]) / 2 - rest["forcing"]
    # A component of the forcing may be the small rest of large ones, so the largest counts for all.
    terms = np.abs(np.outer(v, v) * changes).sum() + np.abs(v).sum() * np.abs(at["forcing"]).max()
    return float(abs(v @ changes @ v + 2 * (v @ quadratic)) / (EPS * max(terms, 1e-300)))


def _laws(mechanism: Mechanism) -> list[tuple]:  # type: ignore[type-arg]
    laws = [drive.applied for joint in mechanism.joints for drive in joint.drives.values()]
    laws += [spring.applied for spring in mechanism.springs]
    return laws + [law for load in mechanism.loads for law in load.vector]
