"""Law: all formulations give the same equations, accelerations and reactions."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from symbody.graph.trees import TreeChoice
from symbody.model import resolve_parameters
from tests.formulations import FORMULATIONS, name_of
from tests.laws.agreement import SYSTEM, choices, other_orientations
from tests.laws.building import build_model
from tests.laws.consistent_states import State, consistent_state
from tests.laws.evaluation import EPS, Condition, condition, independent_rows, values_at
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array

OTHERS = {name_of(each): each for each in FORMULATIONS if not isinstance(each, sb.VirtualWork)}


@dataclass(frozen=True, slots=True, eq=False)
class Derived:
    """Results of one formulation at a state; `turning` marks the speeds that are angular."""

    turning: Array
    values: dict[str, Array]
    reactions: dict[str, Array]
    condition: Condition


def case(mechanism: Mechanism) -> tuple[Mechanism, TreeChoice]:
    """The mechanism of a seed with one of its coordinates: trees as chosen, absolute or random, any angles."""
    rng = random.Random(f"formulations {mechanism.seed}")
    if rng.random() < 0.5:
        mechanism = other_orientations(mechanism)
    return mechanism, rng.choice([None, *choices(mechanism, 2)])


def derived(mechanism: Mechanism, state: State, formulation: Formulation, tree: TreeChoice = None) -> Derived:
    """System matrices, accelerations and reactions at a state, by plain evaluation."""
    eqs = sb.form_equations(build_model(mechanism), formulation, tree=tree)
    parameters = {name: float(value) for name, value in resolve_parameters(eqs.model).items()}
    eqs = eqs.for_values(parameters) if eqs.multiplier_names else eqs
    reactions = {name: f"reaction {name}" for name in mechanism.linked}
    found = values_at(eqs, state, [*SYSTEM, "constraints", *reactions.values()])
    return Derived(
        np.array([eqs.units[name] == "rad/s" for name in eqs.speed_names], dtype=bool),
        {name: found[name] for name in (*SYSTEM, "constraints")},
        {joint: found[output] for joint, output in reactions.items()},
        condition(found),
    )


def differences(mechanism: Mechanism, one: Derived, two: Derived) -> dict[str, float | None]:
    """Differences of two derivations in units of ``eps cond scale``, the scale that of the largest term.

    Every speed is weighted by the root of its entry in diag(M), one that moves no mass by that of the whole
    mass: then all entries of M are at most 1, those of F and u' have one unit, and a unit of acceleration of
    the whole mass bounds terms that cancel from below.
    """
    weights = np.sqrt(np.diag(one.values["mass_matrix"]))
    mass = float(np.sqrt(sum(body.mass for body in mechanism.bodies)))
    weights = np.where(weights > 0, weights, mass * np.where(one.turning, mechanism.units.length, 1.0))
    unit = mass * mechanism.units.acceleration
    rounding = EPS * max(one.condition.number, two.condition.number)
    gap = {name: one.values[name] - two.values[name] for name in SYSTEM}
    inertia = np.abs(gap["mass_matrix"] / np.outer(weights, weights)).max(initial=0.0)
    force, speed = one.values["forcing"] / weights, one.values["udot"] * weights
    lengths = np.linalg.norm(one.values["jacobian"] / weights, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    rows = np.abs(gap["jacobian"] / weights / lengths[:, None]).max(initial=0.0)
    right, turned = one.values["gamma"] / lengths, gap["gamma"] / lengths
    return {
        "mass matrix": float(inertia / rounding),
        "forcing": _relative(gap["forcing"] / weights, max(np.abs(force).max(initial=0.0), unit), rounding),
        "jacobian": float(rows / rounding),
        "gamma": _relative(turned, max(np.abs(right).max(initial=0.0), unit), rounding),
        "accelerations": _relative(
            gap["udot"] * weights, max(np.abs(speed).max(initial=0.0), unit), rounding
        ),
        "reactions": _reactions(mechanism, one, two, rounding),
    }


def _relative(gap: Array, scale: float, rounding: float) -> float:
    return float(np.abs(gap).max(initial=0.0) / (scale * rounding))


def _reactions(mechanism: Mechanism, one: Derived, two: Derived, rounding: float) -> float | None:
    """The difference of reactions, moments divided by the unit of length; undetermined ones have one share.

    Reactions have a condition of their own: where motions prescribe all accelerations, these are exact while
    multipliers still come from an ill-conditioned balance.
    """
    if not one.reactions:
        return None
    weights = np.array([1.0] * 3 + [1 / mechanism.units.length] * 3)
    size = max(np.abs(wrench * weights).max() for wrench in one.reactions.values())
    scale = max(size, max(body.mass for body in mechanism.bodies) * mechanism.units.acceleration)
    gap = max(np.abs((one.reactions[j] - two.reactions[j]) * weights).max() for j in one.reactions)
    own = EPS * max(multiplier_condition(one.values), multiplier_condition(two.values))
    return float(gap / (max(rounding, own) * scale))


def multiplier_condition(values: Mapping[str, Array]) -> float:
    """How much the multipliers change for data changed by one eps relative; see `evaluation.Condition`.

    With diag(M) and rows of unit length multipliers and accelerations have one unit; changes are relative to
    the largest of both.
    """
    M, J = values["mass_matrix"], np.atleast_2d(values["jacobian"])
    if not len(J):
        return 1.0
    n, mass = len(M), np.diag(M)
    d = np.where(mass > 0, 1 / np.sqrt(np.where(mass > 0, mass, 1.0)), 1.0)
    lengths = np.linalg.norm(J * d, axis=1)
    lengths = np.where(lengths > 0, lengths, 1.0)
    A = J * d / lengths[:, None]
    kept = independent_rows(A)
    A, right = A[kept], (values["gamma"] / lengths)[kept]
    K = np.block([[M * np.outer(d, d), -A.T], [A, np.zeros((len(kept), len(kept)))]])
    b = np.concatenate([values["forcing"] * d, right])
    inverse = np.linalg.inv(K)
    x = inverse @ b
    change = np.abs(inverse) @ (np.abs(K) @ np.abs(x) + np.abs(b))
    top = np.abs(x).max(initial=0.0)
    return float(change[n:].max(initial=0.0) / top) if top > 0 else 1.0


def compared(mechanism: Mechanism) -> dict[str, dict[str, float | None]]:
    """The differences of each other formulation from virtual work, by its name."""
    mechanism, tree = case(mechanism)
    state = consistent_state(mechanism)
    first = derived(mechanism, state, sb.VirtualWork(), tree)
    return {
        name: differences(mechanism, first, derived(mechanism, state, formulation, tree))
        for name, formulation in OTHERS.items()
    }
