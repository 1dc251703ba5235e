"""Equations by virtual work on trees of joints, against closed forms and laws."""

from __future__ import annotations

import random

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

from symbody.codegen import compile
from symbody.equations import EquationSet, form_equations
from symbody.errors import FormulationError
from symbody.model import (
    Body,
    Drive,
    Force,
    Frame,
    Model,
    Prismatic,
    Revolute,
    SpringDamper,
    Torque,
    Weld,
)
from tests.tiers import cases

EPS = np.finfo(float).eps


def rr_robot() -> Model:
    link1 = Body("Link1", mass="m1", inertia=(0, 0, "I1"),
                 frames={"base": Frame(at=("-L3", 0, 0)), "tip": Frame(at=("L4", 0, 0))})  # fmt: skip
    link2 = Body("Link2", mass="m2", inertia=(0, 0, "I2"), frames={"base": Frame(at=("-L5", 0, 0))})
    joints = [
        Revolute("shoulder", "ground", "Link1.base", coordinate="beta_1", torque=Drive(applied="T1")),
        Revolute("elbow", "Link1.tip", "Link2.base", coordinate="beta_2", torque=Drive(applied="T2")),
    ]
    names = ["m1", "m2", "I1", "I2", "L3", "L4", "L5", "G"]
    values = {name: 1 + k / 7 for k, name in enumerate(names)}
    return Model("RR", [link1, link2, *joints], (0, "-G", 0), values, inputs=["T1", "T2"])


def test_rr_robot_has_the_textbook_mass_matrix() -> None:
    eqs = form_equations(rr_robot())
    b2 = dynamicsymbols("beta_2")
    m1, m2, i1, i2, l3, l4, l5 = sp.symbols("m1 m2 I1 I2 L3 L4 L5")
    cross = m2 * (l3 + l4) * l5 * sp.cos(b2)
    m22 = i2 + m2 * l5**2
    m11 = i1 + m1 * l3**2 + i2 + m2 * ((l3 + l4) ** 2 + l5**2) + 2 * cross
    expected = sp.Matrix([[m11, m22 + cross], [m22 + cross, m22]])
    difference = (eqs.mass_matrix - expected).applyfunc(lambda e: sp.simplify(sp.expand(e)))
    assert difference == sp.zeros(2, 2)


def test_rr_robot_agrees_with_lagrange_of_its_own_energies() -> None:
    # The energies alone determine the equations; SymPy differentiates them.
    eqs = form_equations(rr_robot())
    t = dynamicsymbols._t
    lagrangian = eqs.kinetic_energy - eqs.potential_energy
    torques = dynamicsymbols("T1 T2")
    values = {s: 0.3 + 0.1 * k for k, s in enumerate(eqs.parameters)}
    state = {"beta_1": 0.4, "beta_2": -1.2, "w1": 0.7, "w2": -0.5, "T1": 0.2, "T2": -0.9}
    residuals = []
    for q, torque, equation in zip(eqs.coordinates, torques, eqs.dynamic_equations(), strict=True):
        lagrange = lagrangian.diff(q.diff(t)).diff(t) - lagrangian.diff(q) - torque
        residuals.append((lagrange - (equation.lhs - equation.rhs)).subs(values))
    b1, b2 = eqs.coordinates
    for residual in residuals:
        number = residual.subs({b1.diff(t, 2): 0.3, b2.diff(t, 2): -0.8}).subs(
            {b1.diff(t): state["w1"], b2.diff(t): state["w2"]}
        )
        number = number.subs({b1: state["beta_1"], b2: state["beta_2"], torques[0]: 0.2, torques[1]: -0.9})
        assert abs(float(number)) < 1e3 * EPS  # about a hundred rounded operations on numbers of size 1


def random_tree(seed: int, *, exchanged: bool = False) -> Model:
    """A random tree with general axes, offsets and all loads; `exchanged` swaps start and end of joints."""
    rng = random.Random(seed)

    def number() -> float:
        return round(rng.uniform(-1, 1), 3)

    def triple() -> tuple[float, float, float]:
        return (number(), number(), number())

    count = rng.randint(1, 5)
    elements: list[object] = []
    for k in range(count):
        a = [rng.uniform(0.5, 1.5) for _ in range(3)]
        inertia = (round(a[1] + a[2], 3), round(a[0] + a[2], 3), round(a[0] + a[1], 3))
        frames = {
            "in": Frame(at=triple(), rotate=[("z", number()), ("x", number())]),
            "out": Frame(at=triple(), rotate=[("y", number())]),
        }
        products = (0.05 * number(), 0.05 * number(), 0.05 * number())
        elements.append(Body(f"B{k}", mass=round(rng.uniform(0.5, 2), 3), inertia=inertia,
                             products=products, frames=frames))  # fmt: skip
        parent = "ground" if k == 0 else f"B{rng.randrange(k)}.out"
        ends = (parent, f"B{k}.in")
        kind = rng.choice(["revolute", "prismatic", "revolute", "weld"]) if k else "revolute"
        axis = (number(), number(), 1.0)
        drive = Drive(applied="F", stiffness=1.5, damping=0.3, free=0.2)
        if exchanged:
            # Seen from the other side, the end moves backwards along an axis that is fixed in both.
            ends = (ends[1], ends[0])
            axis = (-axis[0], -axis[1], -axis[2])
        if kind == "weld":
            elements.append(Weld(f"J{k}", *ends))
        elif kind == "revolute":
            elements.append(Revolute(f"J{k}", *ends, axis=axis, coordinate=f"x{k}", torque=drive))
        elif exchanged:
            elements.append(Prismatic(f"J{k}", *ends, axis=axis, coordinate=f"x{k}", force=drive))
        else:
            elements.append(Prismatic(f"J{k}", *ends, axis=axis, coordinate=f"x{k}", force=drive))
    elements.append(Force("push", "B0.out", triple(), resolved_in="B0", reaction_on=f"B{count - 1}"))
    elements.append(Torque("twist", f"B{count - 1}", triple(), reaction_on="B0"))
    elements.append(
        SpringDamper("spring", "ground.post", f"B{count - 1}.out", stiffness=2, damping=0.1, free=0.4)
    )
    elements.append(SpringDamper("band", "ground.post", f"B{count - 1}", stiffness=0.7))
    return Model("random", elements, gravity=triple(), inputs=["F"],
                 ground={"post": Frame(at=(2, -1, 3))})  # fmt: skip


def states(eqs: EquationSet, seed: int, count: int = 5) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    n = len(eqs.speed_names)
    return rng.uniform(-1, 1, (count, n)), rng.uniform(-1, 1, (count, n))


@pytest.mark.parametrize("seed", cases(range(12), fast=range(1, 5)))
def test_energy_changes_by_the_power_of_the_loads(seed: int) -> None:
    """dE/dt along the equations equals the power; equations and energies share nothing but kinematics."""
    eqs = form_equations(random_tree(seed))
    f = compile(eqs, ["energy", "power", "udot", "mass_matrix"])
    q, u = states(eqs, seed)
    h = 1e-5
    r = [0.6]
    at = f(0.0, q, u, r)
    # Fourth-order central difference of the energy along (u, u').
    weights = {-2: 1 / 12, -1: -2 / 3, 1: 2 / 3, 2: -1 / 12}
    slope = sum(w / h * f(0.0, q + k * h * u, u + k * h * at.udot, r).energy for k, w in weights.items())
    scale = np.abs(at.energy) + np.abs(at.power) + 1
    # Rounding of the difference, eps |E| / h, dominates its truncation h^4.
    bound = 200 * EPS / h * scale * np.linalg.cond(at.mass_matrix)
    assert (np.abs(slope - at.power) < bound).all()
    assert np.abs(at.mass_matrix - np.swapaxes(at.mass_matrix, -1, -2)).max() == 0
    assert np.linalg.eigvalsh(at.mass_matrix).min() > 0
    kinetic = compile(eqs, "kinetic_energy")(0.0, q, u, r)
    quadratic = 0.5 * np.einsum("bi,bij,bj->b", u, at.mass_matrix, u)
    assert kinetic == pytest.approx(quadratic, rel=1e3 * EPS)


@pytest.mark.parametrize("seed", cases(range(12), fast=range(1, 5)))
def test_exchanging_start_and_end_of_joints_changes_nothing(seed: int) -> None:
    one, two = (form_equations(random_tree(seed, exchanged=flag)) for flag in (False, True))
    q, u = states(one, seed)
    order = [two.coordinate_names.index(name) for name in one.coordinate_names]
    swapped = np.argsort(order)
    a = compile(one, ["udot", "mass_matrix"])(0.0, q, u, [0.3])
    b = compile(two, ["udot"])(0.0, q[:, swapped], u[:, swapped], [0.3])
    bound = 1e3 * EPS * np.linalg.cond(a.mass_matrix).max() * (1 + np.abs(a.udot).max())
    assert np.abs(a.udot - b[:, order]).max() < bound


def test_a_loop_that_can_never_close_is_refused_by_name() -> None:
    slider = Prismatic("a", "ground", Body("B", frames={"P": Frame(at=(0, 2, 0))}), coordinate="x")
    again = Prismatic("b", "ground", "B.P")
    with pytest.raises(FormulationError) as caught:
        form_equations(Model("loop", [slider, again]))
    assert [problem.code for problem in caught.value.problems] == ["equations.never_closed"]
    assert caught.value.problems[0].where == "joint b"


def test_a_speed_that_moves_no_mass_is_refused_by_name() -> None:
    arm = Revolute("a", "ground", Body("A", mass="m", inertia=(0, 0, "I")), coordinate="x")
    tip = Revolute("b", "A", Body("B"), coordinate="y")
    eqs = form_equations(Model("light", [arm, tip], parameters={"m": 1, "I": 1}))
    with pytest.raises(FormulationError) as caught:
        eqs.roots("udot")
    assert [problem.where for problem in caught.value.problems] == ["speed y_dot"]


def test_sizes_zero_work() -> None:
    eqs = form_equations(Model("empty", []))
    assert eqs.mass_matrix.shape == (0, 0) and eqs.dynamic_equations() == []
    f = compile(eqs, "xdot")
    assert f(0.0, [], []).shape == (0,)
    assert f(0.0, np.zeros((4, 0)), np.zeros((4, 0))).shape == (4, 0)


def test_equations_of_the_rr_robot_print_as_in_a_textbook() -> None:
    eqs = form_equations(rr_robot())
    b2 = dynamicsymbols("beta_2")
    m1, m2, i1, i2, l3, l4, l5 = sp.symbols("m1 m2 I1 I2 L3 L4 L5")
    # No simplification by SymPy: the entries come as they are compared here, up to order of terms.
    expected = i1 + i2 + l3**2 * m1 + m2 * (l5**2 + 2 * l5 * (l3 + l4) * sp.cos(b2) + (l3 + l4) ** 2)
    assert eqs.mass_matrix[0, 0] == expected
    assert eqs.mass_matrix[1, 1] == i2 + m2 * l5**2
    assert eqs.mass_matrix[0, 1] == i2 + l5 * m2 * (l5 + (l3 + l4) * sp.cos(b2))
