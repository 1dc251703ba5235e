"""Large mechanisms: what grows with the square of their size is not formed, and numbers stay what they are."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import symbody as sb
from benchmarks.large_mechanisms import chain, ring, tree, truss
from symbody.analysis.configurations import plain_assembly
from symbody.analysis.linear import directional_slopes
from symbody.expr.deadline import watch_stages
from tests.tiers import cases

MANY = 110  # bodies, more than have code of their own for first states


def ball_chain(bodies: int) -> sb.Model:
    """A chain of balls joints, with four coordinates and three speeds each."""
    elements: list[Any] = []
    for k in range(1, bodies + 1):
        below = "ground" if k == 1 else f"B{k - 1}.end"
        frames = {"end": sb.Frame(at=(0.1, -1.0, 0.0))}
        elements += [
            sb.Body(f"B{k}", mass=1.0, inertia=(0.1, 0.2, 0.3), frames=frames),
            sb.Spherical(f"J{k}", below, f"B{k}"),
        ]
    return sb.Model("balls", elements, gravity=(0, -9.81, 0))


def driven_tree(bodies: int) -> sb.Model:
    """A tree with a torque at its root that a signal filters, and a spring beside it."""
    model = tree(bodies)
    torque = sb.Revolute("J1", "ground", "B1.top", axis="y", coordinate="q1",
                         torque=sb.Drive(applied="T - 3*lag", stiffness=2.0))  # fmt: skip
    elements = [torque if element.name == "J1" else element for element in model.elements]
    lag = sb.Signal("lag", rate="(T - lag)/0.1")
    return sb.Model("driven tree", [*elements, lag], gravity=(0, -9.81, 0), inputs=["T"])


def rubbing_chain(bodies: int) -> sb.Model:
    """A chain with friction, which reads a reaction, at its root."""
    model = chain(bodies)
    elements = [
        replace(element, friction=sb.Friction(mu=0.1, v0=0.1, radius=0.05))
        if isinstance(element, sb.Revolute) and str(element.start) == "ground"
        else element
        for element in model.elements
    ]
    return sb.Model("rubbing chain", elements, gravity=model.gravity, parameters=model.parameters)


def moving(eqs: sb.EquationSet) -> dict[str, float]:
    """Values of all states of a tree, without any symmetry."""
    names = [*eqs.coordinate_names, *eqs.speed_names]
    return {name: 0.3 * float(np.cos(1.7 * k)) for k, name in enumerate(names)}


@contextmanager
def counted_stages() -> Iterator[list[str]]:
    stages: list[str] = []
    with watch_stages(stages.append):
        yield stages


@pytest.mark.parametrize(
    "make",
    cases([chain, rubbing_chain, tree, driven_tree, ring, truss], fast=[tree, driven_tree, ring, truss]),
)
def test_columns_of_linear_equations_are_those_of_formulas(
    make: Callable[[int], sb.Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for many in (10_000, 1):
        monkeypatch.setattr(directional_slopes, "MANY_STATES", many)
        eqs = sb.form_equations(make(6))
        at = {} if eqs.multiplier_names else moving(eqs)
        found.append(sb.linearize(eqs, at, outputs=["energy"]))
    formulas, columns = found
    assert formulas.state_names == columns.state_names and formulas.notes == columns.notes
    for name in ("A", "B", "C", "D"):
        one, other = getattr(formulas, name), getattr(columns, name)
        assert np.abs(one - other).max(initial=0.0) < 1e-10 * max(1.0, np.abs(one).max(initial=0.0))


@pytest.mark.parametrize(("law", "by"), [("sqrt(q3)", "derivative by q3 here"), ("1/q3", "value here")])
def test_columns_that_are_not_finite_are_refused_by_their_names(
    law: str, by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(directional_slopes, "MANY_STATES", 1)
    eqs = sb.form_equations(driven_tree(6))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(sb.AssemblyError, match=f"no finite {by}"):
            sb.linearize(eqs, {**moving(eqs), "q3": 0.0}, inputs={"T": law})


@pytest.mark.exhaustive
def test_the_graph_of_linear_equations_grows_with_the_bodies_not_with_their_square() -> None:
    nodes = []
    for bodies in (60, 120):
        eqs = sb.form_equations(chain(bodies))
        sb.linearize(eqs)
        nodes.append(len(eqs.formed.graph.ops))
    assert nodes[1] < 2.3 * nodes[0]


@pytest.mark.parametrize("make", [tree, ball_chain])
def test_first_states_of_large_trees_are_those_of_small_ones(
    make: Callable[[int], sb.Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    states = []
    for many in (10_000, 1):
        monkeypatch.setattr(plain_assembly, "LARGE_TREE", many)
        eqs = sb.form_equations(make(5))
        states.append(sb.assemble(eqs, guess=moving(eqs)))
    for group in ("q", "u", "udot"):
        small, large = (getattr(state, group) for state in states)
        assert list(small) == list(large)
        assert list(large.values()) == pytest.approx(list(small.values()), rel=1e-12, abs=1e-12)
    assert states[0].moved == pytest.approx(states[1].moved)


def test_one_sequence_serves_the_first_state_and_the_motion_of_a_large_tree() -> None:
    eqs = sb.form_equations(tree(MANY))
    with counted_stages() as stages:
        run = sb.simulate(eqs, 0.01)
    assert run.status.success
    assert stages.count("computational sequence") == 1
    still = np.linalg.norm(run.u[:, 0])
    assert still == 0.0 and np.linalg.norm(run.u[:, -1]) > 0.0


@pytest.mark.exhaustive
def test_no_least_squares_on_trees(monkeypatch: pytest.MonkeyPatch) -> None:
    """There is nothing to solve for where nothing is closed, by which way ever values are given."""
    sizes: list[int] = []
    for name in ("lstsq", "svd", "qr"):
        plain = getattr(np.linalg, name)

        def measured(matrix: Any, *rest: Any, plain: Any = plain, **named: Any) -> Any:
            sizes.append(min(np.shape(matrix)))
            return plain(matrix, *rest, **named)

        monkeypatch.setattr(np.linalg, name, measured)
    for make, bodies in ((tree, MANY), (ball_chain, 45)):
        eqs = sb.form_equations(make(bodies))
        speed = eqs.speed_names[-1]
        state = sb.assemble(eqs, {speed: 1.5}, t=0.2)
        assert state.u[speed] == 1.5
        ranged = sb.assemble(eqs, {speed: 1.5}, ranges={eqs.coordinate_names[0]: (-9.0, 9.0)})
        assert ranged.u == state.u
        assert sb.simulate(eqs, 0.01, {speed: 1.5}).status.success
    assert max(sizes, default=0) <= 3
