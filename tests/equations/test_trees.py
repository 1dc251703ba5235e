"""Choice of trees: what is cut, what it costs, and that nothing of it changes the physics."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.expr.canonical import sub
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph
from symbody.graph.trees import Trees


def slider_crank(**flags: bool | dict[str, bool]) -> sb.Model:
    crank = sb.Body("Crank", mass="m1", inertia=(0, 0, "I1"), frames={
        "A": sb.Frame(at=("-L1/2", 0, 0)), "B": sb.Frame(at=("L1/2", 0, 0))})  # fmt: skip
    rod = sb.Body("Rod", mass="m2", inertia=(0, 0, "I2"), frames={
        "B": sb.Frame(at=("-L2/2", 0, 0)), "C": sb.Frame(at=("L2/2", 0, 0))})  # fmt: skip
    return sb.Model(
        "slider-crank",
        [
            crank,
            rod,
            sb.Body("Slider", mass="m3"),
            sb.Revolute("A", "ground", "Crank.A", coordinate="theta", tree=flags.get("A")),
            sb.Revolute("B", "Crank.B", "Rod.B", tree=flags.get("B")),
            sb.Revolute("C", "Slider", "Rod.C", coordinate="beta", tree=flags.get("C")),
            sb.Prismatic("D", "ground", "Slider", coordinate="s", tree=flags.get("D")),
        ],
        gravity=(0, "-g", 0),
        parameters={"m1": 1, "m2": 2, "m3": 3, "I1": 0.1, "I2": 0.2, "L1": 1, "L2": 2, "g": 9.81},
    )


def test_the_joint_without_names_is_cut_and_its_empty_rows_are_dropped() -> None:
    eqs = sb.form_equations(slider_crank())
    assert eqs.coordinate_names == ("theta", "beta", "s")
    assert eqs.multiplier_names == ("lambda_B_1", "lambda_B_2")
    assert eqs.constraints.shape == (2, 1) and eqs.constraint_jacobian.shape == (2, 3)
    assert any("joint B is cut: it names no coordinates" in note for note in eqs.notes)
    assert not any("without a name" in note for note in eqs.notes)  # there are none
    assert any("3 closing equations hold identically" in note for note in eqs.notes)
    assert eqs.degrees_of_freedom == 1
    assert eqs.independent_speeds == eqs.speeds[:1]


@pytest.mark.parametrize("cut", "ACD")
def test_flags_choose_the_cut(cut: str) -> None:
    eqs = sb.form_equations(slider_crank(**{cut: False}))
    assert {name.split("_")[1] for name in eqs.multiplier_names} == {cut}
    assert eqs.degrees_of_freedom == 1


@pytest.mark.parametrize(
    ("tree", "speeds", "freedoms"),
    [
        ("joints", 3, 1),
        ("absolute", 18, 1),
        (Trees(["A", "B", "D"], ["A", "C", "D"]), 3, 1),
        (Trees(["A", "B", "D"], ["A", "B", "C"]), 2, 1),
        (Trees(["A"], ["A"]), 13, 1),
    ],
)
def test_any_legal_trees_have_one_degree_of_freedom(tree: object, speeds: int, freedoms: int) -> None:
    eqs = sb.form_equations(slider_crank(), tree=tree)  # type: ignore[arg-type]
    assert len(eqs.speed_names) == speeds
    assert eqs.degrees_of_freedom == freedoms


@pytest.mark.parametrize(
    ("tree", "code", "where"),
    [
        (Trees(["A", "B", "C", "D"], ["A", "B", "C"]), "topology.cycle", "tree, rotation"),
        (Trees(["A", "B", "C"], ["A", "X"]), "topology.unknown_joint", "tree, translation"),
        (Trees(["A", "A"], ["A"]), "topology.twice", "tree, rotation"),
        ("best", "topology.unknown_choice", "tree"),
    ],
)
def test_what_is_no_tree_is_told(tree: object, code: str, where: str) -> None:
    with pytest.raises(sb.TopologyError) as caught:
        sb.form_equations(slider_crank(), tree=tree)  # type: ignore[arg-type]
    assert [(problem.code, problem.where) for problem in caught.value.problems] == [(code, where)]


def test_a_cycle_is_shown() -> None:
    with pytest.raises(sb.TopologyError, match="ground - Crank - Rod - Slider - ground"):
        sb.form_equations(slider_crank(), tree=Trees(["A", "B", "C", "D"], []))


def test_a_single_body_falls_freely_in_absolute_coordinates() -> None:
    model = sb.Model(
        "stone", [sb.Body("B", mass=2, inertia=(1, 2, 3))], gravity=(0, 0, "-g"), parameters={"g": 9.81}
    )
    eqs = sb.form_equations(model)
    assert eqs.coordinate_names == ("B_x", "B_y", "B_z", "B_qw", "B_qx", "B_qy", "B_qz")
    assert eqs.speed_names == ("B_vx", "B_vy", "B_vz", "B_wx", "B_wy", "B_wz")
    w = np.array([0.3, -0.2, 0.5])
    udot = sb.compile(eqs, "udot")(0.0, [0, 0, 0, 1, 0, 0, 0], [1, 2, 3, *w])
    euler = [(2 - 3) * w[1] * w[2] / 1, (3 - 1) * w[2] * w[0] / 2, (1 - 2) * w[0] * w[1] / 3]
    np.testing.assert_allclose(udot, [0, 0, -9.81, *euler], rtol=1e-15, atol=1e-15)
    assert eqs.invariants[0].subs(dict.fromkeys(eqs.invariants[0].free_symbols, 0)) is not None


def same(graph: Graph, a: int, b: int) -> bool:
    return find_zeros(graph, [sub(graph, a, b)]) == [True]


def test_printed_and_computed_equations_are_the_same() -> None:
    eqs = sb.form_equations(slider_crank())
    names = ("mass_matrix", "forcing", "jacobian", "constraints", "velocity_constraints", "gamma")
    graph = eqs.formed.graph
    from_code = [node for name in names for node in eqs.roots(name).nodes]
    printed = [node for name in names for node in eqs.textbook.readable(name).nodes]
    assert len(from_code) == len(printed)
    assert all(same(graph, a, b) for a, b in zip(from_code, printed, strict=True))
