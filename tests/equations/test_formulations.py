"""Newton-Euler and Lagrange: the same equations as virtual work, from derivations of their own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from random import Random

import numpy as np
import pytest
import sympy as sp

import symbody as sb
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.newton_euler import NewtonEuler, solve_free_bodies
from symbody.expr.sympy.sympy_bridge import SympyMatrix
from symbody.graph.trees import TreeChoice
from tests.laws.evaluation import EPS, condition, evaluator
from tests.laws.formulations import OTHERS, compared, multiplier_condition
from tests.laws.mechanisms import random_mechanism
from tests.laws.rotations import Array
from tests.laws.tally import BOUND, Tally
from tests.tiers import cases

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/*.toml"))
CASES = [pytest.param(formulation, id=name) for name, formulation in OTHERS.items()]
SYSTEM = ("mass_matrix", "forcing", "jacobian", "gamma", "udot")


def values(
    model: sb.Model,
    formulation: Formulation,
    tree: TreeChoice = None,
    fixed: Mapping[str, float] | None = None,
) -> dict[str, Array]:
    """System, accelerations and reactions at a random state, or at an assembled one.

    The equations agree off the constraints too, but for rates of measured angles.
    """
    eqs = sb.form_equations(model, formulation, tree=tree)
    random = Random(7)
    state = {name: random.uniform(0.2, 0.9) for name in (*eqs.coordinate_names, *eqs.speed_names)}
    for quaternion in eqs.quaternions:
        norm = sum(state[name] ** 2 for name in quaternion) ** 0.5
        state |= {name: state[name] / norm for name in quaternion}
    if fixed:
        found = sb.assemble(eqs, fixed)
        state |= {**found.q, **found.u}
    reactions = [f"reaction {joint.name}" for joint in model.joints]
    call = evaluator(eqs, [*SYSTEM, *reactions])
    q, u = ([state[name] for name in names] for names in (eqs.coordinate_names, eqs.speed_names))
    q += [random.uniform(0.2, 0.9) for _ in eqs.signal_state_names]
    return call(0.3, q, u, [random.uniform(-1, 1) for _ in eqs.input_names])


def check(
    model: sb.Model,
    formulation: Formulation,
    tree: TreeChoice = None,
    fixed: Mapping[str, float] | None = None,
) -> None:
    """All outputs within 100 eps cond of virtual work, each measured by its largest term.

    Speeds are below 1 and lengths about 1: terms of a forcing that cancel reach the largest entry of M, those
    of accelerations and gamma reach 1.
    """
    one, two = values(model, sb.VirtualWork(), tree, fixed), values(model, formulation, tree, fixed)
    rounding = BOUND * EPS * max(condition(one).number, multiplier_condition(one))
    top = {name: float(np.abs(found).max(initial=0.0)) for name, found in one.items()}
    heaviest = top["mass_matrix"]
    # Reactions of a body that hardly carries anything cancel forces of the whole mechanism.
    force = max([heaviest, *(size for name, size in top.items() if name not in SYSTEM)])
    floor = {"mass_matrix": 0.0, "forcing": heaviest, "jacobian": 0.0, "gamma": 1.0, "udot": 1.0}
    for name, expected in one.items():
        scale = max(top[name], floor.get(name, force))
        assert two[name].shape == expected.shape
        gap = np.abs(two[name] - expected)
        worst = np.unravel_index(gap.argmax(), gap.shape) if gap.size else ()
        allowed = rounding * scale
        assert gap.max(initial=0.0) <= allowed, (
            f"{name}{worst}: {gap[worst]:.3g} apart, {allowed:.3g} allowed"
        )


SLOW = ("stewart_platform", "bicycle", "four_legs")


@pytest.mark.parametrize("formulation", CASES)
@pytest.mark.parametrize(
    "path", cases(EXAMPLES, fast=lambda path: path.stem not in SLOW), ids=lambda path: path.stem
)
def test_examples_have_the_same_equations(path: Path, formulation: Formulation) -> None:
    check(sb.load_model(path), formulation)


@pytest.mark.parametrize("formulation", CASES)
@pytest.mark.parametrize("tree", cases(["joints", "absolute"], fast=["absolute"]))
def test_any_tree(tree: TreeChoice, formulation: Formulation) -> None:
    """Absolute coordinates have quaternions, and drives of cut joints act on bodies."""
    check(driven_pendulum(), formulation, tree, {"p": 0.5, "s": 0.4, "p_dot": 0.7, "s_dot": 0.3})


@pytest.mark.exhaustive
def test_random_mechanisms() -> None:
    tally = Tally()
    for seed in (5, 14, 19, 20, 22, 23, 25, 34, 43, 57):
        for formulation, found in compared(random_mechanism(seed)).items():
            for law, error in found.items():
                tally.enter(seed, f"{formulation}, {law}", error)
    tally.close("formulations")


@pytest.mark.parametrize("formulation", [pytest.param(sb.VirtualWork(), id="virtual work"), *CASES])
def test_two_links_in_closed_form(formulation: Formulation) -> None:
    """Two uniform arms in a vertical plane, relative angles; Craig, Introduction to Robotics, chapter 6."""
    eqs = sb.form_equations(two_links(), formulation)
    names = "m1 m2 I1 I2 a b l g"
    m1, m2, I1, I2, a, b, l, g = (find(eqs, name) for name in names.split())  # noqa: E741
    (_, second), (rate1, rate2) = eqs.coordinates, eqs.speeds
    first = eqs.coordinates[0]
    c, s = sp.cos(second), sp.sin(second)
    far = I2 + m2 * b**2
    M = sp.Matrix([[I1 + m1 * a**2 + m2 * l**2 + far + 2 * m2 * l * b * c, far + m2 * l * b * c],
                   [far + m2 * l * b * c, far]])  # fmt: skip
    weight = m2 * b * g * sp.cos(first + second)
    F = sp.Matrix([m2 * l * b * s * (2 * rate1 * rate2 + rate2**2) - weight - (m1 * a + m2 * l) * g * sp.cos(first),
                   -m2 * l * b * s * rate1**2 - weight])  # fmt: skip
    assert is_zero(eqs.mass_matrix - M)
    assert is_zero(eqs.forcing - F)


@pytest.mark.parametrize("formulation", CASES)
def test_a_rotor_and_a_prescribed_motion(formulation: Formulation) -> None:
    """A slide moved as sin(t) under a pendulum with a rotor: (I + m l^2 + J) theta'' = m l (sin t cos theta)."""
    model = sb.Model("cart", [
        sb.Body("Cart", mass=3),
        sb.Body("Bob", mass="m", inertia=(0, 0, "I"), frames={"top": sb.Frame(at=(0, "l", 0))}),
        sb.Prismatic("slide", "ground", "Cart", coordinate="x", motion="sin(t)"),
        sb.Revolute("hinge", "Cart", "Bob.top", coordinate="theta", armature="J"),
    ], parameters={"m": 2, "I": 0.3, "l": 0.7, "J": 0.2})  # fmt: skip
    eqs = sb.form_equations(model, formulation)
    m, I, l, J = (find(eqs, name) for name in ("m", "I", "l", "J"))  # noqa: E741
    t, theta = sp.Symbol("t"), eqs.coordinates[0]
    assert is_zero(eqs.mass_matrix - sp.Matrix([[I + m * l**2 + J]]))
    assert is_zero(eqs.forcing - sp.Matrix([m * l * sp.sin(t) * sp.cos(theta)]))
    check(model, formulation)


@pytest.mark.parametrize("formulation", CASES)
def test_constraints_beside_joints(formulation: Formulation) -> None:
    """A rod between bodies and a blade: one row differentiated, one row of speeds alone."""
    model = sb.Model("sledge", [
        sb.Body("Sledge", mass=2, inertia=(1, 1, 0.4), frames={"blade": sb.Frame(at=(0.2, 0, 0))}),
        sb.Body("Load", mass=1, inertia=(0.1, 0.1, 0.2)),
        sb.Planar("floor", "ground", "Sledge", coordinates=("x", "y", "phi")),
        sb.Planar("other", "ground", "Load", coordinates=("a", "b", "psi")),
        sb.Distance("rod", "Sledge", "Load", value="L"),
        sb.KnifeEdge("edge", "ground", "Sledge.blade", axis="y"),
    ], parameters={"L": 1.3})  # fmt: skip
    check(model, formulation)


@pytest.mark.parametrize("formulation", CASES)
def test_coordinates_of_one_rate_are_told_apart(formulation: Formulation) -> None:
    """A block turns with one joint and shifts with another, which hold each other's motion.

    Rates of all coordinates that are only measured are 0 then: one number, and still each drive acts along
    an axis of its own, as the reactions must tell.
    """
    model = sb.Model("held", [
        sb.Body("Block", mass=2, inertia=(0.1, 0.2, 0.3)),
        sb.Cartesian("carriage", "ground", "Block", coordinates=("x", "y", "z"),
                     force={"x": sb.Drive(applied=5), "y": sb.Drive(stiffness=40, free=0.2), "z": sb.Drive(applied=-7)}),
        sb.Gimbal("turret", "ground", "Block", coordinates=("a", "b", "c"),
                  torque={"a": sb.Drive(applied=3), "b": sb.Drive(applied=-2), "c": sb.Drive(stiffness=6, free=0.1)}),
    ], gravity=(0, -9.81, 0))  # fmt: skip
    trees = sb.Trees(rotation=["carriage"], translation=["turret"])
    one, two = values(model, sb.VirtualWork(), trees), values(model, formulation, trees)
    for name, expected in one.items():
        assert np.allclose(two[name], expected, rtol=0, atol=100 * EPS * 40), name
    assert np.linalg.norm(one["reaction carriage"]) > 1


def test_newton_euler_has_every_reaction_in_its_system() -> None:
    """A tree has no multipliers, and still the reactions come from the saddle system, not from a balance."""
    eqs = sb.form_equations(two_links(), sb.NewtonEuler())
    assert eqs.formed.formulation == NewtonEuler() and eqs.multiplier_names == ()
    free = solve_free_bodies(eqs.formed)
    assert set(free.wrenches) == {"shoulder", "elbow"}
    assert eqs.formed.dynamics.accelerations(eqs.formed) == (free.udot, [])


def two_links() -> sb.Model:
    return sb.Model("two links", [
        sb.Body("Upper", mass="m1", inertia=(0, 0, "I1"), frames={
            "near": sb.Frame(at=("-a", 0, 0)), "far": sb.Frame(at=("l - a", 0, 0))}),
        sb.Body("Lower", mass="m2", inertia=(0, 0, "I2"), frames={"near": sb.Frame(at=("-b", 0, 0))}),
        sb.Revolute("shoulder", "ground", "Upper.near", coordinate="p"),
        sb.Revolute("elbow", "Upper.far", "Lower.near", coordinate="r"),
    ], gravity=(0, "-g", 0), parameters={
        "m1": 1, "m2": 2, "I1": 0.1, "I2": 0.2, "a": 0.4, "b": 0.6, "l": 1, "g": 9.81})  # fmt: skip


def driven_pendulum() -> sb.Model:
    return sb.Model("driven", [
        sb.Body("Arm", mass=1, inertia=(0.2, 0.25, 0.3), products=(0.01, 0.02, -0.01), frames={
            "near": sb.Frame(at=(-0.4, 0, 0)), "far": sb.Frame(at=(0.5, 0, 0.1), rotate=[("x", "pi/3")])}),
        sb.Body("Ram", mass=2, inertia=(0.3, 0.2, 0.1)),
        sb.Revolute("turn", "ground", "Arm.near", coordinate="p", armature=0.4,
                    torque=sb.Drive(applied="sin(t)", damping=0.3)),
        sb.Prismatic("push", "Arm.far", "Ram", axis="y", coordinate="s", armature=0.2,
                     force=sb.Drive(stiffness=3, damping=0.2, free=0.1)),
        sb.SpringDamper("line", "ground", "Ram", stiffness=2, damping=0.4, free=0.3),
        sb.Force("wind", "Ram", (1, 2, 3), resolved_in="Arm", reaction_on="Arm"),
        sb.Torque("twist", "Ram", (0, 1, "0.3*s_dot")),
    ], gravity=(0, -9.81, 0))  # fmt: skip


def find(eqs: sb.EquationSet, name: str) -> sp.Symbol:
    return next(symbol for symbol in eqs.parameters if symbol.name == name)


def is_zero(matrix: SympyMatrix) -> bool:
    return all(sp.simplify(sp.expand(entry)) == 0 for entry in matrix)
