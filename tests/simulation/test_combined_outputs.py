"""Outputs that only solvers read, combined into one: their values, and what it costs to form them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.equations.solving.sticking import STICKS
from symbody.expr.fingerprints import merging
from symbody.expr.sequences import sequence
from symbody.simulation.hybrid.switching import SwitchingModes
from symbody.simulation.inputs.input_laws import input_laws
from symbody.simulation.simulation_problem import SimulationProblem
from tests.equations.test_for_values import TYPED, tilted


def dry_chain(count: int, limit: float = 2.0) -> sb.EquationSet:
    """A pendulum of several links whose hinges have dry friction up to a limit [N m]."""
    ends = {"P": sb.Frame(at=(-1, 0, 0)), "Q": sb.Frame(at=(1, 0, 0))}
    bodies = [sb.Body(f"B{k}", mass=1, inertia=(0, 0, 1), frames=ends) for k in range(count)]
    places = ["ground", *(f"B{k}.Q" for k in range(count))]
    hinges = [
        sb.Revolute(f"J{k}", places[k], f"B{k}.P", coordinate=f"a{k}", friction=sb.Friction(force=limit))
        for k in range(count)
    ]
    return sb.form_equations(sb.Model("dry chain", [*bodies, *hinges], gravity=(0, -9.81, 0)))


def problem_of(eqs: sb.EquationSet) -> SimulationProblem:
    return SimulationProblem(eqs, {}, input_laws((), {}, (0.0, 1.0)), mechanism_scales(eqs, {}))


@pytest.mark.parametrize("modes", [(STICKS, 1, -1), (STICKS, STICKS, STICKS), (1, 1, -1)])
def test_combined_outputs_are_those_alone(modes: tuple[int, ...]) -> None:
    """Eighty operations or so in sums that do not cancel: 1e-13 is a thousand roundings of the largest."""
    eqs = dry_chain(3)
    switching = SwitchingModes(problem_of(eqs))
    for element, mode in zip(switching.switch.elements, modes, strict=True):
        element.mode = mode
    problem, names = switching.problem, tuple(f"friction {joint}" for joint in switching.modal.joints)
    x = np.array([0.3, -0.2, 0.7, 0.4, 1.1, -0.6])
    (together,) = problem.values_at((names,), 0.0, x)
    alone = [float(problem.values_at((name,), 0.0, x)[0]) for name in names]
    assert together == pytest.approx(alone, abs=1e-13 * np.abs(alone).max())


def test_modes_and_their_ends_are_merged_once_for_all_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without it each joint adds five outputs, and each of them the merging of the whole mechanism."""
    merged: list[int] = []

    def count(*given: object) -> list[int]:
        merged.append(len(given[1]))  # type: ignore[arg-type]
        return merging.merge_equal(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(sequence, "merge_equal", count)

    def merges(joints: int) -> int:
        merged.clear()
        sb.simulate(dry_chain(joints, limit=1e4), 1e-3)  # all stick, in the first modes that are tried
        return len(merged)

    few, many = merges(2), merges(4)
    assert few == many
    assert max(merged) >= 3 * 4  # reserve, effort and acceleration of each joint


def test_rows_that_are_rounding_are_gone_from_combined_outputs() -> None:
    eqs = tilted()
    problem = problem_of(eqs)
    names: Sequence[str] = [f"a{k}_ddot" for k in range(4)]
    x = np.append(np.linspace(0.5, 2.0, len(eqs.speed_names)), list(sb.assemble(eqs).q.values()))
    (together,) = problem.values_at((tuple(names),), 0.0, x)
    alone = [float(value) for value in problem.values_at(names, 0.0, x)]
    assert max(map(abs, alone)) > 0.1
    assert together == pytest.approx(alone, abs=1e-13 * max(map(abs, alone)))
    reduced = eqs.for_values(TYPED)
    assert reduced is not eqs
    assert reduced.for_values(TYPED) is reduced
