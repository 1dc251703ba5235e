"""By hand in space: a top, a pendulum of two links, and forces at sliding points; against drawn ones."""

from __future__ import annotations

from collections.abc import Iterator
from random import Random

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody import mbsymba as mb
from symbody.equations.formulations.formulation import Formulation
from tests.formulations import UNLIMITED
from tests.mbsymba.spots import all_same, same, t, values

L, m, A, C, G = sp.symbols("L m A C G")
TOP = {"L": 1.0, "m": 1.0, "A": 2.0, "C": 1.0, "G": 9.8}
EPS = float(np.finfo(float).eps)


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, 0, -G))
    yield
    mb.set_gravity(None)


def close(by_hand: sb.EquationSet, drawn: sb.EquationSet, *outputs: str) -> None:
    """Both give the same numbers at random states: coordinates in the same order, parameters by name."""
    random = Random(1)
    assert by_hand.state_names == drawn.state_names
    names = sorted(drawn.parameter_names)
    f, g = (sb.compile(eqs, outputs, free=names) for eqs in (by_hand, drawn))
    for _ in range(20):
        q, u, p = (
            [random.uniform(0.3, 1.3) for _ in each]
            for each in (drawn.coordinate_names, drawn.speed_names, names)
        )
        for left, right in zip(f(0.3, q, u, (), p), g(0.3, q, u, (), p), strict=True):
            # 1e4 roundings for the condition of M
            assert np.abs(left - right).max() <= 1e4 * EPS * (1 + np.abs(right).max())


def top_by_hand() -> tuple[mb.BODY, mb.FRAME, list[sp.Expr]]:
    q = zeta, eta, xi = dynamicsymbols("zeta eta xi")
    RF = mb.rotate("Z", zeta) * mb.rotate("X", eta) * mb.rotate("Z", xi)
    moment = A - m * L**2
    return mb.make_BODY(mb.make_POINT(RF, 0, 0, L), m, moment, moment, C, name="Top"), RF, list(q)


def top_drawn(formulation: Formulation) -> sb.EquationSet:
    moment = "A - m*L^2"
    body = sb.Body("Top", "m", (moment, moment, "C"), frames={"base": sb.Frame((0, 0, "-L"))})
    pivot = sb.Spherical(
        "pivot", "ground", body["base"], angles="313", coordinates=["zeta", "eta", "xi"], speeds="rates"
    )
    return sb.form_equations(sb.Model("top", [pivot], gravity=(0, 0, "-G"), parameters=TOP), formulation)


@pytest.mark.parametrize("formulation", UNLIMITED, ids=lambda f: type(f).__name__)
def test_top(formulation: Formulation) -> None:
    body, _, q = top_by_hand()
    eqs = mb.equation_set([body], q, formulation, parameters=TOP)
    outputs = (
        "udot",
        "mass_matrix",
        "forcing",
        "kinetic_energy",
        "potential_energy",
        "power",
        "frame r Top ground ground",
    )
    close(eqs, top_drawn(formulation), *outputs)
    eta = q[1]
    wanted = [
        [A * sp.sin(eta) ** 2 + C * sp.cos(eta) ** 2, 0, C * sp.cos(eta)],
        [0, A, 0],
        [C * sp.cos(eta), 0, C],
    ]
    assert all_same(eqs.mass_matrix, sp.Matrix(wanted))


def test_motion_of_the_top() -> None:
    body, _, q = top_by_hand()
    eqs = mb.lagrange_equations({body}, q, t).equation_set
    run = sb.simulate(
        eqs, 10.0, initial={"eta": np.pi / 2, "xi_dot": 10.0}, parameters=TOP, rtol=1e-10, atol=1e-12
    )
    assert run.success and np.degrees(run["eta"][-1]) == pytest.approx(101.361144, abs=5.1e-7)
    assert run["zeta"][-1] == pytest.approx(9.38110645, abs=5.1e-9)
    place = run["frame r Top ground ground"][:, -1]
    assert place == pytest.approx([0.04280216, 0.97947023, -0.19699251], abs=5.1e-9)


def test_euler_about_the_pivot_is_lagrange() -> None:
    """Moments along the line of nodes, the vertical and the top's axis are Lagrange's equations."""
    body, RF, q = top_by_hand()
    eeq = mb.euler_equations(body, mb.origin(RF))
    lagrange = mb.lagrange_equations([body], q, t)
    nodes = mb.uvec_X(mb.rotate("Z", q[0]))
    found = [mb.dot_prod(eeq, axis) for axis in (mb.uvec_Z(mb.ground), nodes, mb.uvec_Z(RF))]
    assert eeq.frame == RF and all_same(found, lagrange)


def test_a_chain_in_space_with_a_force_and_a_torque() -> None:
    q = a, b = list(dynamicsymbols("a b"))
    F, T = dynamicsymbols("F T")
    k = sp.Symbol("k")
    RF1 = mb.rotate("Z", a)
    RF2 = RF1 * mb.translate(L, 0, 0) * mb.rotate("X", b)
    b1 = mb.make_BODY(mb.make_POINT(RF1, L / 2, 0, 0), m, A, A, C, 0, k, 0, name="one")
    b2 = mb.make_BODY(mb.make_POINT(RF2, 0, L / 3, 0), m, A, C, A, name="two")
    tip = mb.make_POINT(RF2, 0, L, 0)
    push = mb.make_FORCE(RF1, F, 0, 2 * F, tip, b2, b1)
    wind = mb.make_FORCE(mb.make_VECTOR(mb.ground, 1, F, 0), tip, b2)
    twist = mb.make_TORQUE(RF2, T, 0, 0, b2, b1)
    found = mb.equation_set([b1, b2, push, wind, twist], q, parameters={"k": 0.1, **TOP})
    one = sb.Body(
        "one",
        "m",
        ("A", "A", "C"),
        (0, "k", 0),
        {"base": sb.Frame(("-L/2", 0, 0)), "end": sb.Frame(("L/2", 0, 0))},
    )
    two = sb.Body(
        "two",
        "m",
        ("A", "C", "A"),
        frames={"base": sb.Frame((0, "-L/3", 0)), "tip": sb.Frame((0, "2*L/3", 0))},
    )
    elements = [
        sb.Revolute("J1", "ground", one["base"], axis="z", coordinate="a"),
        sb.Revolute("J2", one["end"], two["base"], axis="x", coordinate="b"),
        sb.Force("push", on=two["tip"], reaction_on=one, vector=("F", 0, "2*F"), resolved_in=one),
        sb.Force("wind", on=two["tip"], vector=(1, "F", 0)),
        sb.Torque("twist", on=two, reaction_on=one, vector=("T", 0, 0), resolved_in=two),
    ]
    drawn = sb.form_equations(
        sb.Model("chain", elements, gravity=(0, 0, "-G"), parameters={"k": 0.1, **TOP}, inputs=["F", "T"])
    )
    assert found.input_names == drawn.input_names and found.notes[0].endswith("F, T")
    names = sorted(drawn.parameter_names)
    f, g = (sb.compile(each, ("udot", "power", "forcing"), free=names) for each in (found, drawn))
    arguments = (0.0, [0.4, 0.9], [1.1, -0.7], [2.0, 3.0], [2.0, 1.0, 9.8, 0.1, 1.3, 0.7])
    for left, right in zip(f(*arguments), g(*arguments), strict=True):
        assert left == pytest.approx(right, rel=1e-12)
    q_forces = mb.lagrange_equations([b1, b2, push, wind, twist], q, t)
    M, rest = mb.GenerateMatrix(q_forces, mb.diff(q, t, t))
    numbers = dict(zip(names, arguments[4], strict=True))
    point = {sp.Symbol(name): x for name, x in numbers.items()} | {
        F: 2.0,
        T: 3.0,
        a: 0.4,
        b: 0.9,
        a.diff(): 1.1,
        b.diff(): -0.7,
    }
    from_text = [x.xreplace(point) for x in (M.LUsolve(rest))]
    assert [float(x) for x in from_text] == pytest.approx(f(*arguments)[0], rel=1e-10)


@pytest.mark.exhaustive  # SymPy needs seconds for each
@pytest.mark.parametrize("seed", range(6))
def test_random_chains_against_matrices_in_sympy(seed: int) -> None:
    """Two bodies on random chains of steps; T and V from 4 x 4 matrices, with no angular velocity at all."""
    random = Random(seed)
    q = list(dynamicsymbols("q1:4"))
    RF, H, T, V = mb.ground, sp.eye(4), sp.Integer(0), sp.Integer(0)
    parts = []
    for k in range(2):
        for _ in range(random.randint(2, 3)):
            x = random.choice(q) + random.randint(0, 2)
            step = random.choice("XYZT")
            where = random.randrange(3)
            a, b = [(1, 2), (2, 0), (0, 1)][where]
            S = sp.eye(4)
            if step == "T":
                RF = RF * mb.translate(*(x if j == where else j for j in range(3)))
                S[:3, 3] = sp.Matrix([x if j == where else j for j in range(3)])
            else:
                RF = RF * mb.rotate("XYZ"[where], x)
                S[a, a], S[a, b], S[b, a], S[b, b] = sp.cos(x), -sp.sin(x), sp.sin(x), sp.cos(x)
            H = H * S
        mass, centre = random.randint(1, 3), [random.randint(-1, 2) for _ in range(3)]
        E = sp.Matrix(3, 3, lambda i, j: 4 if i == j else 1) * random.randint(1, 2)  # second moments
        inertia = E.trace() * sp.eye(3) - E
        entries = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
        parts.append(mb.make_BODY(mb.make_POINT(RF, *centre), mass, *entries, name=f"B{k}"))
        r = H * sp.Matrix([*centre, 1])
        v, R = r.diff(t), H[:3, :3].diff(t)
        T += (mass * v.dot(v) + (R * E * R.T).trace()) / 2
        V += mass * G * r[2]
    occurring = [x for x in q if (T + V).has(x)]
    wanted = [T.diff(x.diff()).diff(t) - T.diff(x) + V.diff(x) for x in occurring]
    found = mb.lagrange_equations(parts, occurring)
    assert all_same(found, wanted)
    numbers = {x: random.uniform(0.2, 1.2) for y in occurring for x in (y, y.diff())} | {G: 9.8}
    M, rest = mb.GenerateMatrix(found, mb.diff(occurring, t, t))
    M, rest = (np.array(values(each, numbers)).reshape(each.shape) for each in (M, rest))
    if np.linalg.cond(M) > 1e8:
        return  # both bodies do not resist this coordinate
    for formulation in UNLIMITED:
        f = sb.compile(mb.equation_set(parts, occurring, formulation, parameters={"G": 9.8}), "udot")
        udot = f(0.0, [numbers[x] for x in occurring], [numbers[x.diff()] for x in occurring])
        assert M @ udot == pytest.approx(rest.ravel(), rel=1e-9, abs=1e-9)


def test_a_spring_and_damper_of_the_notes() -> None:
    mb.set_gravity(None)
    s = dynamicsymbols("s")
    Ls0, Ks, Cs = sp.symbols("Ls0 Ks Cs")
    body = mb.make_BODY(mb.translate(Ls0 + s, 0, 0), m)
    contact = mb.make_POINT(mb.ground, Ls0 + s, 0, 0)  # not fixed on the body, but at its material
    spring = mb.make_FORCE(mb.ground, -s * Ks - Cs * mb.diff(s, t), 0, 0, contact, body)
    found = mb.lagrange_equations({body, spring}, [s], t)
    wanted = m * s.diff(t, 2) + Ks * s + Cs * s.diff()
    assert same(found[0], wanted) and same(mb.comp_X(mb.newton_equations([body, spring])), wanted)
    assert mb.equation_set([body, spring], [s]).mass_matrix[0] == m


def test_constraints_on_velocities_and_motions_in_time() -> None:
    """A skate: no sliding across the blade; the row enters by its derivatives by the rates."""
    mb.set_gravity(None)
    q = x, y, phi = list(dynamicsymbols("x y phi"))
    RF = mb.translate(x, y, 0) * mb.rotate("Z", phi)
    body = mb.make_BODY(RF, m, 0, 0, C, name="skate")
    sliding = mb.comp_Y(mb.velocity(mb.origin(RF)))
    lam = dynamicsymbols("lambda1")
    blade = mb.make_CONSTRAINT(sliding, lam)
    found = mb.lagrange_equations([body, blade], [*q, lam])
    wanted = [
        m * x.diff(t, 2) + lam * sp.sin(phi),
        m * y.diff(t, 2) - lam * sp.cos(phi),
        C * phi.diff(t, 2),
        sliding,
    ]
    assert all_same(found, wanted)
    eqs = mb.equation_set([body, blade], q, parameters={"m": 2.0, "C": 0.5})
    assert eqs.constraints.shape == (0, 1) and eqs.constraint_jacobian.shape == (1, 3)
    run = sb.simulate(eqs, 1.0, initial={"x_dot": 1.0, "phi_dot": 2.0})
    assert [run["x"][-1], run["y"][-1]] == pytest.approx([np.sin(2) / 2, (1 - np.cos(2)) / 2], abs=1e-7)
    driven = mb.make_CONSTRAINT(phi - sp.sin(t), dynamicsymbols("mu"))
    eqs = mb.equation_set([body, driven], q, parameters={"m": 2.0, "C": 0.5})
    run = sb.simulate(eqs, 1.0, initial={"phi_dot": 1.0})
    assert run["phi"][-1] == pytest.approx(np.sin(1), abs=1e-9) and run["mu"][-1] == pytest.approx(
        -0.5 * np.sin(1), abs=1e-7
    )
    assert run.energy[-1] - run.energy[0] == pytest.approx(run.work[-1] - run.work[0], abs=1e-7)


def test_natural_coordinates_have_a_constant_mass_matrix() -> None:
    mb.set_gravity(None)
    ux, uy, x, y = q = list(dynamicsymbols("ux uy x y"))
    RF = sp.Matrix([[ux, -uy, 0, x], [uy, ux, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])
    body = mb.make_BODY(mb.make_POINT(RF, L, 0, 0), m, 0, 0, C)
    T = mb.kinetic_energy(body, True)
    rates = [each.diff() for each in q]
    M = sp.hessian(T.xreplace(dict(zip(rates, sp.symbols("v1:5"), strict=True))), sp.symbols("v1:5"))
    wanted = [[C + m * L**2, 0, m * L, 0], [0, C + m * L**2, 0, m * L], [m * L, 0, m, 0], [0, m * L, 0, m]]
    assert all_same(M, sp.Matrix(wanted))
    phi = dynamicsymbols("phi")
    turned = {ux: sp.cos(phi), uy: sp.sin(phi)}
    on_circle = [e.subs(turned).doit() for e in (T, mb.kinetic_energy({body}))]
    assert same(*on_circle)
    with pytest.raises(sb.FormulationError, match="Lagrange"):
        mb.equation_set([body], q, sb.VirtualWork(), nat_coords=True)
