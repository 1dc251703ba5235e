"""Limbs of equal structure side by side: the bits of one after the other, and fewer instructions."""

from __future__ import annotations

import random

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.llvm.order import order_operations, order_pairs
from symbody.codegen.llvm.pairs.matching import find_pairs
from symbody.codegen.llvm.pairs.terms import Terms
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.sequence import Sequence
from symbody.model.element import Element
from tests.codegen.native import call

AXES = "xyzyxz"


def limbs(seed: int, count: int, links: int, *, odd: bool = False) -> sb.Model:
    """A floating trunk with limbs that mirror each other; one of them may lack a number."""
    source = random.Random(seed)
    axes = [source.choice(AXES) for _ in range(links)]
    masses = [round(source.uniform(0.5, 2), 3) for _ in range(links)]
    elements: list[Element] = [
        sb.Body("T", mass=9, inertia=(0.3, 0.2, 0.25), frames={
            f"P{k}": sb.Frame(at=(0.1 * (k // 2), 0.2 * (-1) ** k, 0.05)) for k in range(count)
        }),
        sb.Free("base", "ground", "T"),
    ]  # fmt: skip
    for k in range(count):
        side, before = (-1) ** k, f"T.P{k}"
        for i, (axis, mass) in enumerate(zip(axes, masses, strict=True)):
            y = 0 if odd and k == 0 and i == 0 else 0.03 * side
            ends = {"P": sb.Frame(at=(0.01, 0.02 * side, 0.15)), "Q": sb.Frame(at=(0.02, y, -0.15))}
            elements += [
                sb.Body(f"B{k}{i}", mass=mass, inertia=(0.011, 0.012, 0.005),
                        products=(0.001 * side, 0.0003, 0.0005 * side), frames=ends),
                sb.Revolute(f"J{k}{i}", before, f"B{k}{i}.P", axis=axis, coordinate=f"q{k}{i}",
                            torque=sb.Drive(applied=f"tau{k}{i}")),
            ]  # fmt: skip
            before = f"B{k}{i}.Q"
    inputs = [f"tau{k}{i}" for k in range(count) for i in range(links)]
    return sb.Model("limbs", elements, (0, 0, -9.81), inputs=inputs)


def sequence_of(model: sb.Model, output: str = "udot") -> Sequence:
    return fold_constants(form_sequence(sb.form_equations(model), output)[0])


def states(sequence: Sequence, count: int = 20) -> list[dict[str, list[float]]]:
    source = np.random.default_rng(1)
    return [
        {group: source.uniform(-1, 1, sequence.group_size(group)).tolist() for group in "tqurp"}
        for _ in range(count)
    ]


def plain_results(sequence: Sequence, monkeypatch: pytest.MonkeyPatch) -> list[list[float]]:
    """Outputs at all states by code without pairs."""
    with monkeypatch.context() as patch:
        patch.setattr("symbody.codegen.llvm.native.find_pairs", lambda sequence: {})
        function = compile_sequence(sequence, keep_ir=True)
    assert "<2 x double> %v" not in function.ir
    return [call(function, sequence, state)[1] for state in states(sequence)]


@pytest.fixture
def any_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("symbody.codegen.llvm.pairs.matching._WORTH", 0)


def check_bits(sequence: Sequence, piece_size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    function = compile_sequence(sequence, piece_size=piece_size, keep_ir=True)
    found = [call(function, sequence, state)[1] for state in states(sequence)]
    assert found == plain_results(sequence, monkeypatch)


@pytest.mark.parametrize(("count", "links", "odd", "piece_size"), [(4, 2, False, 250), (2, 3, True, 8000)])
@pytest.mark.usefixtures("any_gain")
def test_pairs_have_the_bits_of_single_operations(
    count: int, links: int, odd: bool, piece_size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    sequence = sequence_of(limbs(1, count, links, odd=odd))
    assert find_pairs(order_operations(sequence))
    check_bits(sequence, piece_size, monkeypatch)


@pytest.mark.usefixtures("any_gain")
def test_circles_of_circles_that_differ_in_their_order_compile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pairs of them would need each other: the inner one of each limb is the outer one of the other."""
    outputs = ["udot", "sin(cos(q00 + 1))", "cos(sin(q10 + 1))"]
    sequence = fold_constants(form_sequence(sb.form_equations(limbs(1, 2, 3)), outputs)[0])
    assert find_pairs(order_operations(sequence))
    check_bits(sequence, 8000, monkeypatch)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("output", ["udot", "mass_matrix", "inverse_dynamics", "d udot/d(q, u)"])
@pytest.mark.usefixtures("any_gain")
def test_random_limbs_have_the_bits_of_single_operations(
    seed: int, output: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = limbs(seed, 2 + seed % 3, 1 + seed % 4, odd=seed % 2 == 1)
    check_bits(sequence_of(model, output), 300 + 100 * seed, monkeypatch)


def test_most_operations_of_limbs_are_paired_and_stand_behind_what_both_read() -> None:
    sequence = order_operations(sequence_of(limbs(1, 2, 6)))
    pairs = find_pairs(sequence)
    after, pairs = order_pairs(sequence, pairs)
    terms = Terms(after)
    work = sum(map(terms.is_work, range(len(after.operations))))
    assert 2 * sum(map(terms.is_work, pairs)) > 0.6 * work
    assert all(j < k for k, operation in enumerate(after.operations) for j in operation.operands)
    computed = {first: second for first, second in pairs.items() if terms.is_work(first)}
    assert all(second == first + 1 for first, second in computed.items())
    assert all(first not in after.operations[second].operands for first, second in computed.items())


def test_a_chain_has_no_limbs_however_alike_its_links_are() -> None:
    assert not find_pairs(order_operations(sequence_of(limbs(3, 1, 6))))
