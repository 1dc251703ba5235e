"""Derivatives of trees column by column, side by side: the numbers of those that follow one by one."""

from __future__ import annotations

import random

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.derivatives import with_outputs
from symbody.codegen.formation.sequences import form_sequence
from symbody.equations.formulations.recursive import RecursiveDynamics
from symbody.equations.recursive.chains import TOGETHER, chains
from symbody.equations.recursive.udot_derivatives import FEWEST_SPEEDS
from symbody.equations.solving.slopes import acceleration_slopes
from symbody.expr import opcodes as op
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Roots

EPS = float(np.finfo(float).eps)
# A solution with M multiplies the roundings of its entries by its condition; the rest is how many there are.
ROUNDINGS = 100.0

Element = sb.Body | sb.Revolute | sb.Prismatic | sb.Free | sb.SpringDamper


def random_tree(seed: int, count: int, *, floating: bool, loads: str = "", long: float = 0.7) -> sb.Model:
    """Bodies on hinges and slides about any axes; each hangs on the one before with probability `long`.

    `loads` may be "own" for springs, dampers and rotors in joints, "tie" for a spring to ground too.
    """
    source = random.Random(seed)

    def number(low: float, high: float) -> str:
        return f"{source.uniform(low, high):.3f}"

    def frame() -> sb.Frame:
        return sb.Frame(
            at=tuple(number(-0.5, 0.5) for _ in range(3)),
            rotate=[(axis, number(-3, 3)) for axis in ("z", "x", "z")],
        )

    elements: list[Element] = []
    for k in range(count):
        frames = {"in": frame(), **{f"out{j}": frame() for j in range(3)}}
        moments = tuple(number(0.3, 0.5) for _ in range(3))
        elements.append(
            sb.Body(
                f"B{k}",
                mass=number(0.5, 3),
                inertia=moments,
                products=("0.02", "-0.03", "0.01"),
                frames=frames,
            )
        )
        if k == 0 and floating:
            elements.append(sb.Free("base", "ground", "B0", speeds="twist"))
            continue
        parent = k - 1 if source.random() < long else source.randrange(max(1, k))
        start = "ground" if k == 0 else f"B{parent}.out{source.randrange(3)}"
        more = {"armature": number(0.01, 0.2)} if loads and source.random() < 0.5 else {}
        axis = source.choice(["x", "y", "z", (1, 2, 2)])
        if source.random() < 0.75:
            drive = sb.Drive(f"T{k}", stiffness="0.7", damping="0.3") if loads else sb.Drive(f"T{k}")
            elements.append(
                sb.Revolute(f"J{k}", start, f"B{k}.in", axis=axis, coordinate=f"q{k}", torque=drive, **more)
            )
        else:
            elements.append(
                sb.Prismatic(
                    f"J{k}", start, f"B{k}.in", axis=axis, coordinate=f"q{k}", force=sb.Drive(f"T{k}"), **more
                )
            )
    if loads == "tie":
        elements.append(
            sb.SpringDamper("tie", "ground", f"B{count - 1}.out0", stiffness="5", free="0.2", damping="0.4")
        )
    inputs = [f"T{k}" for k in range(count) if not (k == 0 and floating)]
    return sb.Model(f"tree {seed}", elements, gravity=("1", "-9.81", "2"), inputs=inputs)


def derivatives(eqs: sb.EquationSet, by: list[str]) -> tuple[sb.CompiledFunction, sb.CompiledFunction]:
    """The derivatives as compiled, and those that follow one by one."""
    formed = eqs.formed
    groups = {"q": formed.q, "u": formed.u, "r": formed.inputs}
    symbols = [symbol for word in by for symbol in groups[word]]
    rows = acceleration_slopes(formed, symbols)
    name = f"{' '.join(by)} one by one"  # sequences are kept by their names
    roots = Roots(name, (len(formed.u), len(symbols)), tuple(x.index for row in rows for x in row))
    return sb.compile(eqs, f"d udot/d({', '.join(by)})"), sb.compile(with_outputs(eqs, [roots]), name)


def states(eqs: sb.EquationSet, seed: int, count: int = 5) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (count, len(eqs.coordinate_names)))
    for names in eqs.quaternions:
        places = [eqs.coordinate_names.index(name) for name in names]
        q[:, places] /= np.linalg.norm(q[:, places], axis=1, keepdims=True)
    return (
        q,
        rng.uniform(-1, 1, (count, len(eqs.speed_names))),
        rng.uniform(-1, 1, (count, len(eqs.input_names))),
    )


def has_programs(eqs: sb.EquationSet, output: str) -> bool:
    sequence, _ = form_sequence(eqs, output)
    return any(operation.op == op.MAP for operation in sequence.operations)


def check(model: sb.Model, seed: int, by: list[str]) -> float:
    """The largest deviation, in roundings times the condition of M."""
    eqs = sb.form_equations(model, sb.Recursive())
    assert has_programs(eqs, f"d udot/d({', '.join(by)})")
    side_by_side, one_by_one = derivatives(eqs, by)
    mass = sb.compile(eqs, "mass_matrix")
    q, u, r = states(eqs, seed)
    found, expected, M = (f(0.0, q, u, r) for f in (side_by_side, one_by_one, mass))
    scale = EPS * np.linalg.cond(M) * np.abs(expected).max(axis=(1, 2))
    return float((np.abs(found - expected).max(axis=(1, 2)) / scale).max())


KINDS = [(False, ""), (False, "own"), (True, "own"), (True, "tie")]


@pytest.mark.parametrize(
    ("floating", "loads"), [KINDS[0], pytest.param(*KINDS[2], marks=pytest.mark.exhaustive)]
)  # floating ones below
def test_side_by_side_is_one_by_one(floating: bool, loads: str) -> None:
    model = random_tree(7, 7 if floating else 10, floating=floating, loads=loads, long=0.7)
    assert check(model, 1, ["q", "u", "r"]) < ROUNDINGS


@pytest.mark.parametrize(
    "by", [["r", "u"], *(pytest.param(by, marks=pytest.mark.exhaustive) for by in (["u", "q"], ["q"]))]
)
def test_any_columns_in_any_order(by: list[str]) -> None:
    assert check(random_tree(8, 7, floating=True, loads="own", long=0.6), 2, by) < ROUNDINGS


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(60))
def test_side_by_side_is_one_by_one_often(seed: int) -> None:
    floating, loads = KINDS[seed % 4]
    source = random.Random(seed)
    model = random_tree(seed, source.randrange(9, 26), floating=floating, loads=loads, long=source.random())
    worst = check(model, seed, ["q", "u", "r"])
    print(f"{worst:.2g} roundings times the condition")
    assert worst < ROUNDINGS


def test_derivatives_are_differences_of_accelerations() -> None:
    eqs = sb.form_equations(random_tree(9, 7, floating=True, loads="own"), sb.Recursive())
    slopes, f = sb.compile(eqs, "d udot/d(q, u, r)"), sb.compile(eqs, "udot")
    (q,), (u,), (r,) = states(eqs, 3, 1)
    found, x, h = slopes(0.0, q, u, r), np.concatenate([q, u, r]), 1e-6
    parts = [len(q), len(q) + len(u)]
    for k in range(len(x)):
        ends = [f(0.0, *np.split(x + sign * h * np.eye(len(x))[k], parts)) for sign in (1, -1)]
        central = (ends[0] - ends[1]) / (2 * h)
        # h^2 of third derivatives, below 1e5 of the values here, and eps cond / h.
        np.testing.assert_allclose(found[:, k], central, rtol=0, atol=1e-6 * np.abs(found).max())


@pytest.mark.exhaustive
def test_lanes_texts_and_single_points_agree() -> None:
    eqs = sb.form_equations(random_tree(10, 9, floating=True), sb.Recursive())
    single, lanes = (sb.compile(eqs, ["udot", "d udot/d(q, u)"], lanes=chosen) for chosen in (False, True))
    q, u, r = states(eqs, 4, 19)
    for one, two in zip(single(0.0, q, u, r), lanes(0.0, q, u, r), strict=True):
        np.testing.assert_array_equal(one, two)
    assert written_out(single.sequence).operation_count == single.sequence.operation_count


def test_accelerations_have_their_bits_with_and_without_derivatives() -> None:
    eqs = sb.form_equations(random_tree(11, 7, floating=True, loads="own"), sb.Recursive())
    alone, both = sb.compile(eqs, "udot"), sb.compile(eqs, ["udot", "d udot/d(q, u, r)"])
    q, u, r = states(eqs, 5)
    np.testing.assert_array_equal(alone(0.0, q, u, r), both(0.0, q, u, r).udot)
    slopes = sb.compile(eqs, "d udot/d(q, u, r)")
    np.testing.assert_array_equal(slopes(0.0, q, u, r), both(0.0, q, u, r)[1])


@pytest.mark.exhaustive
def test_what_is_no_tree_of_single_joints_goes_one_by_one() -> None:
    few = sb.form_equations(random_tree(12, FEWEST_SPEEDS - 1, floating=False), sb.Recursive())
    assert not has_programs(few, "d udot/d(q, u)")
    model = random_tree(12, 9, floating=False)
    assert has_programs(sb.form_equations(model, sb.Recursive()), "d udot/d(q, u)")
    assert not has_programs(sb.form_equations(model, sb.VirtualWork()), "d udot/d(q, u)")
    assert not has_programs(sb.form_equations(model, sb.Recursive("articulated")), "d udot/d(q, u)")
    elements = [
        *model.elements,
        sb.Body("ball", mass=1, inertia=(1, 1, 1)),
        sb.Spherical("J", "B3.out1", "ball"),
    ]
    ball = sb.Model("with a ball", elements, gravity=(0, 0, -9.81), inputs=model.inputs)
    assert not has_programs(sb.form_equations(ball, sb.Recursive()), "d udot/d(q, u)")


def test_small_branches_go_together() -> None:
    eqs = sb.form_equations(random_tree(13, 24, floating=True, long=0.2), sb.Recursive())
    formed = eqs.formed
    assert isinstance(formed.dynamics, RecursiveDynamics)
    rates = {q.index: formed.variables.rates[q.index] for q in formed.expressions(formed.q)}
    found = chains(formed.graph, formed.dynamics.recursion.base_tree, rates)
    assert found is not None and found.base
    assert sorted(found.links) == list(range(1, 24))
    for segment in found.segments:
        chain = all(
            found.tree.links[b].parent == a for a, b in zip(segment.links, segment.links[1:], strict=False)
        )
        assert chain or len(segment.links) <= TOGETHER
        for k in segment.links:
            inside = found.carriers(k) & set(segment.links)
            assert found.carriers(k) - inside <= {
                0, *(j for home in found.inward(segment.parent) for j in found.segments[home].links)
            }  # fmt: skip
    assert max(len(segment.links) for segment in found.segments) > 1
