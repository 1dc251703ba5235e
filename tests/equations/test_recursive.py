"""Recursion against virtual work: values, reactions, energies; what it costs; and when it stands back."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.derivatives import with_outputs
from symbody.codegen.formation.sequences import form_sequence
from symbody.equations.formulations.recursive import RecursiveDynamics
from symbody.equations.solving.slopes import acceleration_slopes, inverse_dynamics
from symbody.expr.rewrite import substitute
from symbody.expr.sequences.folding import fold_constants
from symbody.expr.sequences.sequence import Roots
from tests.laws.building import build_model
from tests.laws.consistent_states import consistent_state
from tests.laws.evaluation import EPS, values_at
from tests.laws.formulations import case, derived, differences
from tests.laws.mechanisms import random_mechanism

BOTH = (sb.Recursive("articulated"), sb.Recursive("composite"))
# Rounding grows with the condition, which `differences` divides by; the rest is the number of operations.
MOST = 100.0


def arm() -> sb.Model:
    """Six hinges with the geometry and roughly the masses of a small industrial arm, all numbers."""
    frames = [  # Denavit & Hartenberg: length a, twist alpha, offset d before each hinge
        ("0", "0", "0.0892"), ("0", "pi/2", "0.1358"), ("0.425", "0", "-0.1197"),
        ("0.3923", "0", "0.093"), ("0", "pi/2", "0.0946"), ("0", "-pi/2", "0.0823"),
    ]  # fmt: skip
    masses = ("3.7", "8.393", "2.275", "1.219", "1.219", "0.1879")
    elements: list[sb.Body | sb.Revolute] = []
    before = "ground.foot"
    a, alpha, d = frames[0]
    ground = {"foot": sb.Frame(at=(a, "0", d), rotate=[("x", alpha)])}
    for k, mass in enumerate(masses):
        here = {"root": sb.Frame(at=("-0.1", "0.02", "-0.05"))}
        if k + 1 < len(masses):
            a, alpha, d = frames[k + 1]
            at = (f"{a} - 0.1", "0.02", f"{d} - 0.05")
            here["tip"] = sb.Frame(at=at, rotate=[("x", alpha)])
        inertia = (f"{mass}/100", f"{mass}/80", f"{mass}/90")
        elements += [
            sb.Body(
                f"L{k}",
                mass=mass,
                inertia=inertia,
                products=(f"{mass}/900", f"{mass}/1000", f"{mass}/800"),
                frames=here,
            ),
            sb.Revolute(f"J{k}", before, f"L{k}.root", coordinate=f"q{k}"),
        ]
        before = f"L{k}.tip"
    return sb.Model("arm", elements, gravity=("0", "0", "-9.81"), ground=ground)


def chain(links: int) -> sb.Model:
    elements: list[sb.Body | sb.Revolute] = []
    before = "ground"
    for k in range(links):
        ends = {"P": sb.Frame(at=(0, 0, "-1/2")), "Q": sb.Frame(at=(0, 0, "1/2"))}
        elements += [
            sb.Body(f"B{k}", mass="1.5", inertia=("0.1", "0.2", "0.3"), frames=ends),
            sb.Revolute(f"J{k}", before, f"B{k}.P", axis="yzx"[k % 3], coordinate=f"q{k}"),
        ]
        before = f"B{k}.Q"
    return sb.Model("chain", elements, gravity=(0, 0, "-9.81"))


def operations(eqs: sb.EquationSet, output: str = "udot") -> int:
    """The operations of one call, constants computed before."""
    return fold_constants(form_sequence(eqs, [output])[0]).operation_count


def compare(seeds: Sequence[int]) -> None:
    for seed in seeds:
        mechanism, tree = case(random_mechanism(seed))
        state = consistent_state(mechanism)
        first = derived(mechanism, state, sb.VirtualWork(), tree)
        for formulation in BOTH:
            found = differences(mechanism, first, derived(mechanism, state, formulation, tree))
            worst = max(error for error in found.values() if error is not None)
            assert worst < MOST, (seed, formulation, found)


def test_agrees_with_virtual_work() -> None:
    compare(range(3))


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(0, 300, 50))
def test_agrees_with_virtual_work_often(first: int) -> None:
    compare(range(first, first + 50))


@pytest.mark.parametrize("seed", [1, 5, 8])
def test_energies_and_power_are_those_of_virtual_work(seed: int) -> None:
    mechanism = random_mechanism(seed)
    state, model = consistent_state(mechanism), build_model(mechanism)
    words = ["kinetic_energy", "potential_energy", "power"]
    one = values_at(sb.form_equations(model, sb.VirtualWork()), state, words)
    two = values_at(sb.form_equations(model, sb.Recursive()), state, words)
    scale = max(abs(float(one[word])) for word in words)
    for word in words:
        # Sums of a few hundred products, none larger than the largest energy by orders of magnitude.
        assert abs(float(one[word]) - float(two[word])) <= 1e4 * EPS * scale


@pytest.mark.parametrize("method", ["articulated", "composite"])
@pytest.mark.parametrize("aligned", [False, True])
@pytest.mark.parametrize("regrouped", [False, True])
def test_each_trick_keeps_the_accelerations(method: str, aligned: bool, regrouped: bool) -> None:
    model = arm()
    how = sb.Recursive("articulated" if method == "articulated" else "composite", aligned, regrouped)
    q, u = np.array([0.3, -0.7, 1.1, 0.4, -0.9, 0.2]), np.array([0.5, 1.5, -0.4, 0.8, -1.2, 0.6])
    expected = sb.compile(sb.form_equations(model, sb.VirtualWork()), "udot")(0.0, q, u)
    found = sb.compile(sb.form_equations(model, how), "udot")(0.0, q, u)
    # The mass matrix of the arm has a condition below 1e5.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e5 * EPS * np.abs(expected).max())


def test_the_tricks_save_operations() -> None:
    """Bounds from the day it was written; fewer are welcome."""
    model = arm()
    plain = operations(sb.form_equations(model, sb.Recursive("composite", False, False)))
    aligned = operations(sb.form_equations(model, sb.Recursive("composite", True, False)))
    both = sb.form_equations(model, sb.Recursive("composite"))
    assert operations(both) < aligned < plain
    assert operations(both) <= ARM_UDOT
    assert operations(both, "forcing") <= ARM_BIAS
    assert operations(sb.form_equations(model)) == operations(both)
    assert operations(both) < 0.7 * operations(sb.form_equations(model, sb.VirtualWork()))


ARM_UDOT, ARM_BIAS = 830, 423


def test_forming_is_linear_in_the_length_of_a_chain() -> None:
    sizes = []
    for links in (40, 80):
        eqs = sb.form_equations(chain(links))
        eqs.roots("udot")
        dynamics = eqs.formed.dynamics
        assert isinstance(dynamics, RecursiveDynamics) and dynamics.recursion.chosen_method == "articulated"
        sizes.append(len(eqs.formed.graph))
    assert sizes[1] < 2.1 * sizes[0]
    # The ratio of two fillings of the graph; a mass matrix alone would make it 4.


def test_no_mass_at_a_leaf_is_named() -> None:
    elements = [
        sb.Body("A", mass=1, inertia=(1, 1, 1), frames={"P": sb.Frame(at=(1, 0, 0))}),
        sb.Body("B"),
        sb.Revolute("first", "ground", "A", coordinate="a"),
        sb.Revolute("second", "A.P", "B", coordinate="b"),
    ]
    for formulation in BOTH:
        eqs = sb.form_equations(sb.Model("light", elements), formulation)
        with pytest.raises(sb.SymbodyError, match="b_dot"):
            eqs.roots("udot")


def test_a_loop_of_massless_links_is_solved_with_its_constraints() -> None:
    """A leaf without mass is no obstacle where a loop holds it."""
    elements = [
        sb.Body("A", mass=1, inertia=(1, 1, 1), frames={"P": sb.Frame(at=(1, 0, 0))}),
        sb.Body("B", frames={"Q": sb.Frame(at=(2, 0, 0))}),
        sb.Revolute("first", "ground", "A", coordinate="a"),
        sb.Revolute("second", "A.P", "B", coordinate="b"),
        sb.PointOnLine("slot", "ground", "B.Q", axis="x"),
    ]
    model = sb.Model("crank", elements, gravity=(0, "-9.81", 0))
    q = np.array([0.5, -0.5 - math.asin(math.sin(0.5) / 2)])
    u = np.array([1.0, -1.0 - math.cos(0.5) / math.sqrt(4 - math.sin(0.5) ** 2)])
    found = sb.compile(sb.form_equations(model, sb.Recursive()), "udot")(0.0, q, u)
    expected = sb.compile(sb.form_equations(model, sb.VirtualWork()), "udot")(0.0, q, u)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_slopes_are_the_derivatives_of_the_accelerations() -> None:
    eqs = sb.form_equations(arm(), sb.Recursive())
    formed = eqs.formed
    by = [*formed.u, *formed.q]
    rows = acceleration_slopes(formed, by)
    slopes = Roots("slopes", (6, 12), tuple(x.index for row in rows for x in row))
    eqs = with_outputs(eqs, [slopes])
    f = sb.compile(eqs, "udot")
    rng = np.random.default_rng(3)
    u, q = rng.uniform(-1, 1, 6), rng.uniform(-1, 1, 6)
    found = sb.compile(eqs, "slopes")(0.0, q, u)
    h = 1e-6
    for k in range(12):
        step = h * np.eye(12)[k]
        ahead, back = f(0.0, q + step[6:], u + step[:6]), f(0.0, q - step[6:], u - step[:6])
        central = (ahead - back) / (2 * h)
        # Central differences: h^2 of third derivatives, below 1e4 of the values here, and eps cond / h.
        np.testing.assert_allclose(found[:, k], central, rtol=0, atol=1e-6 * np.abs(found).max())


def test_inverse_dynamics_is_what_the_equations_lack() -> None:
    for formulation in (sb.VirtualWork(), sb.Recursive()):
        eqs = sb.form_equations(arm(), formulation)
        formed = eqs.formed
        missing = inverse_dynamics(formed)
        udot = dict(
            zip(
                [formed.graph.symbol(u.derivative) for u in formed.u],
                eqs.roots("udot").nodes,
                strict=True,
            )
        )
        nodes = substitute(formed.graph, [x.index for x in missing], udot)
        eqs = with_outputs(eqs, [Roots("missing", (6,), tuple(nodes))])
        rng = np.random.default_rng(4)
        q, u = rng.uniform(-1, 1, 6), rng.uniform(-1, 1, 6)
        scale = np.abs(sb.compile(eqs, "forcing")(0.0, q, u)).max()
        # Forces of that size cancel, through accelerations of a system of condition below 1e5.
        assert np.abs(sb.compile(eqs, "missing")(0.0, q, u)).max() < 1e5 * EPS * scale


def test_different_trees_are_left_to_virtual_work() -> None:
    trees = sb.Trees(rotation=["J0", "J1"], translation=["J0"])
    eqs = sb.form_equations(chain(2), sb.Recursive(), tree=trees)
    assert eqs.formed.formulation == sb.VirtualWork()
    assert any("virtual work is used instead of recursion" in note for note in eqs.notes)
