"""A law: as many equations are printed as there are unknowns, whatever they are printed as.

Unknowns are the accelerations, the multipliers, and of dry friction the efforts and the reactions that they come
from. What is printed is evaluated at a random point; its rank in the unknowns, constraints differentiated, is that
of the system that is solved.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.builder.tasks.equations import derive_equations
from symbody.equations.outputs.equation_lines import equation_lines, written_sections
from symbody.equations.outputs.equation_page import equations_page
from symbody.equations.outputs.equation_sections import EquationSection, equation_sections
from symbody.equations.outputs.printed_equations import LONG
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.written_function import write_out
from symbody.formats.native import to_data
from tests.laws.building import build_model
from tests.laws.mechanisms import random_mechanism

ROOT = Path(__file__).parents[2] / "examples"
FAST = ("four_bar", "slider_crank", "cart_pole_pid")
EXAMPLES = sorted(path.parent.name for path in ROOT.glob("*/*.toml") if path.stem == path.parent.name)
GALLERY = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "gallery").rglob("*.toml"))
STEP = 1e-6  # of central differences, wrong by its square; ranks are told apart at 1e-6 of the largest value


def skate() -> sb.Model:
    body = sb.Body("B", mass="m", inertia=(0, 0, "J"))
    joint = sb.Planar("p", "ground", "B", coordinates=("x", "y", "th"))
    edge = sb.KnifeEdge("k", "ground", "B", axis="y")
    return sb.Model("skate", [body, joint, edge], parameters={"m": 1, "J": 1})


def skate_by_formula() -> sb.Model:
    body = sb.Body("B", mass="m", inertia=(0, 0, "J"))
    joint = sb.Planar("p", "ground", "B", coordinates=("x", "y", "th"))
    rule = sb.Constraint("k", "x_dot*sin(th) - y_dot*cos(th)")
    return sb.Model("skate", [body, joint, rule], parameters={"m": 1, "J": 1})


def coin() -> sb.Model:
    disc = sb.Body("coin", mass="m", inertia=("J/2", "J", "J/2"))
    joint = sb.Free("free", "ground", "coin")
    rolling = sb.Rolling("contact", "ground", "coin", radius="R", axis="y", normal="z")
    return sb.Model("rolling coin", [disc, joint, rolling], gravity=(0, 0, "-g"),
                    parameters={"m": 1, "J": 0.1, "R": 0.3, "g": 9.81})  # fmt: skip


def ball_on_a_turntable() -> sb.Model:
    table = sb.Body("table", mass=1, inertia=(1, 1, 1))
    ball = sb.Body("ball", mass="m", inertia=("J", "J", "J"))
    turning = sb.Revolute("axle", "ground", "table", axis="z", coordinate="turn")
    joint = sb.Free("free", "ground", "ball")
    rolling = sb.Rolling("contact", "table", "ball", radius="R", normal="z")
    return sb.Model("turntable", [table, ball, turning, joint, rolling], gravity=(0, 0, "-g"),
                    parameters={"m": 1, "J": 0.1, "R": 0.3, "g": 9.81})  # fmt: skip


def rubbing() -> sb.Model:
    """Friction from a reaction that reads accelerations, and of given strength."""
    arm = sb.Body(
        "arm",
        mass="m",
        inertia=(0, 0, "J"),
        frames={"A": sb.Frame(at=("-L", 0, 0)), "B": sb.Frame(at=("L", 0, 0))},
    )
    block = sb.Body("block", mass="m")
    bearing = sb.Revolute("pin", "ground", "arm.A", coordinate="th", friction=sb.Friction(mu=0.2, radius="r"))
    guide = sb.Prismatic("guide", "arm.B", "block", coordinate="s", friction=sb.Friction(force=1, static=2))
    return sb.Model("rubbing", [arm, block, bearing, guide], gravity=(0, "-g", 0),
                    parameters={"m": 1, "J": 0.1, "L": 1, "r": 0.1, "g": 9.81})  # fmt: skip


MODELS = {each.__name__: each for each in (skate, skate_by_formula, rubbing, coin, ball_on_a_turntable)}


def evaluator(eqs: sb.EquationSet, nodes: Sequence[int]) -> Callable[[dict[str, float]], NDArray[np.float64]]:
    """Return what evaluates nodes at a point; names that it lacks get numbers that depend on the name alone."""
    graph = eqs.formed.graph
    written = write_out(graph, nodes)
    symbols = symbols_of(graph, written)
    labels = [graph.symbols[graph.left[k]] for k in symbols]
    places = {node: Input(str(k), "x", k) for k, node in enumerate(symbols)}
    program = build_sequence(graph, [Roots("", (len(written),), tuple(written))], places)
    usual = {each.label: Random(f"{each.kind}:{each.label}").uniform(0.3, 1.3) for each in labels}

    def evaluate(values: dict[str, float]) -> NDArray[np.float64]:
        point = [values.get(each.label, usual[each.label]) for each in labels]
        return np.array(evaluate_sequence(program, {"x": point})[0], dtype=float).ravel()

    return evaluate


def random_point(eqs: sb.EquationSet) -> dict[str, float]:
    names = (*eqs.coordinate_names, *eqs.speed_names)
    values = {name: Random(name).uniform(0.3, 1.3) for name in names}
    for four in eqs.quaternions:
        norm = sum(values[name] ** 2 for name in four) ** 0.5
        values |= {name: values[name] / norm for name in four}
    return values


def slopes(eqs: sb.EquationSet, nodes: Sequence[int], names: Sequence[str]) -> NDArray[np.float64]:
    """Return derivatives by `names` at a random point, by central differences."""
    point = random_point(eqs) | {name: Random(name).uniform(0.3, 1.3) for name in names}
    evaluate = evaluator(eqs, nodes)
    ends = [[evaluate({**point, name: point[name] + sign * STEP}) for name in names] for sign in (1.0, -1.0)]
    return (np.array(ends[0]) - np.array(ends[1])).reshape(len(names), len(nodes)).T / (2 * STEP)


def printed_matrix(eqs: sb.EquationSet, sections: dict[str, EquationSection]) -> NDArray[np.float64]:
    """Return what is printed by the accelerations and the multipliers, constraints differentiated."""

    def residuals(key: str) -> list[int]:
        return [left for left, _ in sections[key].sides] if key in sections else []

    pairs = [pair for key in ("motion", "friction") if key in sections for pair in sections[key].sides]
    graph = eqs.formed.graph
    efforts = [graph.symbols[graph.left[left]].label for left, _ in pairs[len(eqs.speed_names) :]]
    unknowns = [*eqs.acceleration_names, *eqs.multiplier_names, *efforts]
    left, right = (slopes(eqs, [pair[k] for pair in pairs], unknowns) for k in (0, 1))
    velocities = slopes(eqs, residuals("velocities"), eqs.speed_names)
    point, columns = random_point(eqs), []
    rates_at = evaluator(eqs, eqs.roots("qdot").nodes)
    residuals_at = evaluator(eqs, residuals("positions"))
    for speed in eqs.speed_names:
        moving = {**point, **dict.fromkeys(eqs.speed_names, 0.0), speed: 1.0}
        rates = rates_at(moving) - rates_at({**moving, speed: 0.0})
        ends = []
        for sign in (1.0, -1.0):
            moved = {
                name: point[name] + sign * STEP * float(rate)
                for name, rate in zip(eqs.coordinate_names, rates, strict=True)
            }
            ends.append(residuals_at({**point, **moved}))
        columns.append((ends[0] - ends[1]) / (2 * STEP))
    positions = np.array(columns).reshape(len(eqs.speed_names), -1).T
    constraints = np.vstack([positions, velocities])
    others = np.zeros((len(constraints), len(unknowns) - len(eqs.speed_names)))
    return np.vstack([left - right, np.hstack([constraints, others])])


def solved_matrix(eqs: sb.EquationSet) -> NDArray[np.float64]:
    n, m = len(eqs.speed_names), len(eqs.multiplier_names)
    point = random_point(eqs)
    mass = evaluator(eqs, eqs.roots("mass_matrix").nodes)(point).reshape(n, n)
    jacobian = evaluator(eqs, eqs.roots("jacobian").nodes)(point).reshape(m, n)
    return np.block([[mass, -jacobian.T], [jacobian, np.zeros((m, m))]])


def rank(matrix: NDArray[np.float64]) -> int:
    if not matrix.size:
        return 0
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return int((sizes > 1e-6 * max(sizes[0], 1e-300)).sum())


def check(model: sb.Model, folder: Path = ROOT) -> None:
    eqs = sb.form_equations(model)
    listed = equation_sections(eqs.textbook, LONG)
    sections = {section.key: section for section in listed}
    counts = [len(sections[key].sides) for key in ("motion", "positions", "velocities") if key in sections]
    assert sum(counts) == len(eqs.speed_names) + len(eqs.multiplier_names)
    laws = len(sections["friction"].sides) if "friction" in sections else 0
    assert laws == sum(1 + law.reads_reaction for law in eqs.formed.friction)
    if eqs.speed_names:
        assert rank(printed_matrix(eqs, sections)) == rank(solved_matrix(eqs)) + laws
    check_writers(eqs, listed, folder)


def check_writers(eqs: sb.EquationSet, listed: list[EquationSection], folder: Path) -> None:
    """Every writer prints the equations of every section."""
    total = sum(len(section.sides) + len(section.words) for section in listed)
    lines = [line for line in equation_lines(eqs.textbook) if line.count(" = ")]
    named = [section for section in written_sections(eqs.textbook, False, LONG) if section.title == "where"]
    definitions = sum(len(section.sides) for section in named)
    assert len(lines) == total + definitions
    assert equations_page(eqs.textbook).count('class="sb-equation"') == total + definitions
    assert len(re.findall(r"(?<!\\\\) ?&?= ", eqs.latex(width=10**6))) >= total
    answer = derive_equations(payload(eqs, folder), lambda *_: None)
    blocks = answer["tabs"][0]["blocks"]
    assert len(blocks) == sum(bool(section.sides) for section in listed)
    if any(block["mathml"] is None for block in blocks):
        return  # too long for a panel, which says so
    shown = "".join(block["mathml"] for block in blocks)
    assert shown.count('class="sb-equation"') >= sum(len(section.sides) for section in listed)


def payload(eqs: sb.EquationSet, folder: Path) -> dict[str, Any]:
    return {"data": to_data(eqs.model), "folder": str(folder), "options": {}}


@pytest.mark.parametrize(
    "name",
    [
        *("skate", "skate_by_formula", "rubbing"),
        *(pytest.param(x, marks=pytest.mark.exhaustive) for x in ("coin", "ball_on_a_turntable")),
    ],
)
def test_printed_equations_determine_the_unknowns(name: str) -> None:
    check(MODELS[name]())


@pytest.mark.parametrize(
    "name", [*FAST, *(pytest.param(x, marks=pytest.mark.exhaustive) for x in EXAMPLES if x not in FAST)]
)
def test_examples(name: str) -> None:
    check(sb.load_model(ROOT / name / f"{name}.toml"), ROOT / name)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", GALLERY)
def test_gallery(name: str) -> None:
    check(sb.load_model(ROOT / name), (ROOT / name).parent)


@pytest.mark.parametrize(
    "seed", [38, *(pytest.param(k, marks=pytest.mark.exhaustive) for k in range(40) if k != 38)]
)
def test_random_mechanisms(seed: int) -> None:
    check(build_model(random_mechanism(seed)))


def test_the_report_and_the_notebook_have_the_velocity_constraints(tmp_path: Path) -> None:
    eqs = sb.form_equations(skate())
    sb.save_report(eqs, tmp_path / "r.html", sections=["equations"])
    text = (tmp_path / "r.html").read_text("utf-8")
    assert text.count('class="sb-equation"') == 4 and "Constraints on velocities" in text
    assert str(eqs._repr_html_()).count('class="sb-equation"') == 4
    assert r"\dot{y}" in eqs.latex() and "velocity constraints:" in str(eqs)
