"""What is read is what is computed: differences that are planted are raised, none are there by themselves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.outputs import textbook
from symbody.equations.recursive import recursion
from symbody.equations.recursive.coupled_aba import UncoupledMotions
from symbody.expr.graph import Graph
from symbody.expr.opcodes import ADD, SUB
from tests.equations.test_derivation import chain
from tests.formulations import FORMULATIONS

EXAMPLES = Path(__file__).parents[2] / "examples"
WAYS = [sb.Recursive("articulated"), sb.Recursive("composite"), *FORMULATIONS]


def of_example(name: str, formulation: Formulation | None = None) -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"), formulation)


def test_a_formula_that_is_not_what_is_computed_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rewriting forgets the last term of each sum, as it could by a fault of the normal form."""

    def forgetful(graph: Graph, nodes: list[int], quaternions: object) -> list[int]:
        return [graph.left[node] if graph.ops[node] in (ADD, SUB) else node for node in nodes]

    monkeypatch.setattr(textbook, "readable", forgetful)
    with pytest.raises(sb.FormulationError, match=r"equations\.views_differ") as caught:
        print(of_example("rr_robot").forcing)
    assert caught.value.problems[0].where.startswith("forcing[")


def test_a_mass_matrix_that_does_not_fit_the_inverse_dynamics_is_raised(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The matrix by composite bodies is twice what the recursive Newton-Euler algorithm needs."""
    rows_of = recursion.mass_rows

    def doubled(*arguments: Any) -> Any:
        return [{k: entry * 2 for k, entry in row.items()} for row in rows_of(*arguments)]

    monkeypatch.setattr(recursion, "mass_rows", doubled)
    with pytest.raises(sb.FormulationError, match=r"\[equations\.views_differ\] inverse_dynamics"):
        print(sb.form_equations(chain(3), sb.Recursive("articulated")).mass_matrix)


def test_accelerations_that_do_not_fit_the_mass_matrix_are_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    """Articulated bodies give twice the accelerations."""
    solve = UncoupledMotions.accelerations

    def doubled(*arguments: Any) -> Any:
        return {u: value * 2 for u, value in solve(*arguments).items()}

    monkeypatch.setattr(UncoupledMotions, "accelerations", doubled)
    with pytest.raises(sb.FormulationError, match=r"\[equations\.views_differ\] udot"):
        print(sb.form_equations(chain(3), sb.Recursive("articulated")).forcing)


@pytest.mark.parametrize("formulation", WAYS, ids=repr)
@pytest.mark.parametrize("name", ["rr_robot", "spinning_top_omega", "four_bar"])
def test_examples_are_shown_without_a_difference(name: str, formulation: Formulation) -> None:
    eqs = of_example(name, formulation)
    n = len(eqs.speeds)
    assert eqs.mass_matrix.shape == (n, n) and eqs.forcing.shape == (n, 1)
