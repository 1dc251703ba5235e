"""Linear equations against closed forms, other coordinates, and the differential-algebraic equations."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import eig

import symbody as sb
from symbody.analysis.linear.modes import spectrum
from tests.problems.mechanisms import equations_of
from tests.spectra import assert_same_spectrum
from tests.tiers import cases

Array = NDArray[np.float64]
G = 9.81


@cache
def pendulum() -> sb.EquationSet:
    """A point mass of 0.1 kg on 1 m."""
    bob = sb.Body("Bob", mass="m", frames={"o": sb.Frame(at=(0, "L", 0))})
    pivot = sb.Revolute(
        "pivot", "ground", "Bob.o", axis="z", coordinate="theta", torque=sb.Drive(applied="T", damping="d")
    )
    values = {"m": 0.1, "L": 1, "g": G, "d": 0}
    return sb.form_equations(
        sb.Model("pendulum", [bob, pivot], gravity=(0, "-g", 0), parameters=values, inputs=["T"])
    )


@cache
def cart_pendulum() -> sb.EquationSet:
    cart = sb.Body("Cart", mass="M")
    bob = sb.Body("Bob", mass="m", inertia=(0, 0, "I"), frames={"o": sb.Frame(at=(0, "-l", 0))})
    slide = sb.Prismatic("slide", "ground", "Cart", axis="x", coordinate="x", force=sb.Drive(applied="F"))
    pin = sb.Revolute("pin", "Cart", "Bob.o", axis="z", coordinate="phi")
    values = {"M": 0.5, "m": 0.2, "I": 0.006, "l": 0.3}
    return sb.form_equations(
        sb.Model(
            "cart", [cart, bob, slide, pin], gravity=(0, -G, 0), parameters=values, inputs=["F"]
        )
    )  # fmt: skip


def test_pendulum_below_and_above() -> None:
    below = sb.linearize(pendulum())
    A, B, C, D = below
    np.testing.assert_allclose(A, [[0, -G], [1, 0]])
    np.testing.assert_allclose(B, [[10], [0]])
    assert C.shape == (0, 2) and D.shape == (0, 1)
    assert (below.state_names, below.input_names, below.output_names) == (("theta_dot", "theta"), ("T",), ())
    assert_same_spectrum(below.eigenvalues, [3.132091953j, -3.132091953j], atol=1e-9)
    assert below.verdict == "marginal" and below.is_stationary and below.affine == pytest.approx([0, 0])
    above = sb.linearize(pendulum(), {"theta": "pi"})
    assert_same_spectrum(above.eigenvalues, [3.132091953, -3.132091953], atol=1e-9)
    assert above.verdict == "unstable" and above.is_stationary


@pytest.mark.parametrize(
    ("place", "theta", "rate"),
    [("0", -0.09969216, -0.10297115), ("pi", -31.41904, -107.82711)],
)
def test_linear_pendulum_after_a_second(place: str, theta: float, rate: float) -> None:
    """From 0.1 rad and 0.1 rad/s; the exact one is at -0.09962075, -0.10364098."""
    lin = sb.linearize(pendulum(), {"theta": place})
    start = np.array([0.1, 0.1 - (math.pi if place == "pi" else 0.0)])
    values, vectors = np.linalg.eig(lin.A)
    end = (vectors @ (np.exp(values) * np.linalg.solve(vectors, start))).real
    end[1] += math.pi if place == "pi" else 0.0
    assert end == pytest.approx([rate, theta], rel=1e-6)  # digits given


def test_a_point_that_is_no_equilibrium_is_told() -> None:
    lin = sb.linearize(pendulum(), {"theta": 0.3})
    assert not lin.is_stationary and "theta_dot' = -2.899" in " ".join(lin.notes)
    assert lin.affine == pytest.approx([-G * math.sin(0.3), 0])
    assert lin.A[0, 1] == pytest.approx(-G * math.cos(0.3))


def test_damping_frequency_and_time_constant() -> None:
    """theta'' + 2 zeta w theta' + w^2 theta = 0 with d = 2 zeta w m L^2."""
    w, zeta = math.sqrt(G), 0.2
    lin = sb.linearize(pendulum(), parameters={"d": 2 * zeta * w * 0.1})
    first = lin.modes[0]
    assert lin.verdict == "stable" and first.eigenvalue.imag > 0
    assert first.frequency == pytest.approx(w) and first.damping_ratio == pytest.approx(zeta)
    assert first.time_constant == pytest.approx(1 / (zeta * w))
    assert first.shape["theta"] * first.eigenvalue == pytest.approx(first.shape["theta_dot"])


def test_cart_and_pendulum() -> None:
    """Upright, (M + m) x'' - m l phi'' = F and (I + m l^2) phi'' - m l x'' = m g l phi, phi turning to the left."""
    M, m, inertia, length = 0.5, 0.2, 0.006, 0.3
    p = inertia * (M + m) + M * m * length**2
    lin = sb.linearize(cart_pendulum(), outputs=["x", "phi"])
    assert lin.state_names == ("x_dot", "phi_dot", "x", "phi")
    A = np.zeros((4, 4))
    A[0, 3] = m**2 * G * length**2 / p
    A[1, 3] = m * G * length * (M + m) / p
    A[2, 0] = A[3, 1] = 1
    B = np.array([[(inertia + m * length**2) / p], [m * length / p], [0], [0]])
    np.testing.assert_allclose(lin.A, A, rtol=1e-12)
    np.testing.assert_allclose(lin.B, B, rtol=1e-12)
    np.testing.assert_array_equal(lin.C, [[0, 0, 1, 0], [0, 0, 0, 1]])
    assert lin.verdict == "unstable"
    hanging = sb.linearize(cart_pendulum(), {"phi": "pi"})
    assert hanging.verdict == "drifting"  # the cart can stand anywhere
    without = sb.linearize(cart_pendulum(), {"phi": "pi"}, cyclic=["x"])
    assert without.state_names == ("x_dot", "phi_dot", "phi") and without.verdict == "marginal"


def test_steady_precession_of_the_top() -> None:
    """Nutation about a steady precession, from the effective potential of the Lagrange top.

    A z^2 cos(eta) - C w z + m g L = 0 with z the precession, w the spin component of the angular velocity; then
    Omega^2 = z^2 sin^2(eta) + (2 z cos(eta) - C w / A)^2 (Goldstein, Classical Mechanics, section 5.7).
    """
    A, C, weight, eta, z = 2.0, 1.0, 9.8, 1.0, 1.3
    w = (A * z**2 * math.cos(eta) + weight) / (C * z)
    start = {"zeta": 0, "eta": eta, "xi": 0, "zeta_dot": z, "eta_dot": 0, "xi_dot": w - z * math.cos(eta)}
    lin = sb.linearize(equations_of("spinning_top"), start, cyclic=("zeta", "xi"))
    assert lin.state_names == ("zeta_dot", "eta_dot", "xi_dot", "eta") and lin.is_stationary
    nutation = math.sqrt((z * math.sin(eta)) ** 2 + (2 * z * math.cos(eta) - C * w / A) ** 2)
    assert max(lin.eigenvalues.imag) == pytest.approx(nutation, rel=1e-12)
    assert lin.verdict == "marginal" and lin.modes[0].frequency <= lin.modes[0].tolerance
    moving = sb.linearize(equations_of("spinning_top"), start)
    assert not moving.is_stationary and "cyclic" in moving.notes[-1]


@cache
def sleeping_top() -> sb.EquationSet:
    """The top in angles that are regular upright, its axis spun by the last."""
    top = sb.Body("Top", mass=1, inertia=(1, 1, 1), frames={"o": sb.Frame(at=(0, 0, -1))})
    pivot = sb.Spherical("pivot", "ground", "Top.o", angles="xyz", coordinates=["a", "b", "c"])
    return sb.form_equations(sb.Model("sleeping top", [top, pivot], gravity=(0, 0, -9.8)))


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "unstable"), (1.01, "marginal")])
def test_sleeping_top_needs_spin(share: float, verdict: str) -> None:
    """Upright it is stable from C w = 2 sqrt(A m g L), with A = 2 about the fixed point and C = 1."""
    spin = share * 2 * math.sqrt(2 * 9.8)
    lin = sb.linearize(
        sleeping_top(), {"a": 0, "b": 0, "c": 0, "c_dot": spin, "a_dot": 0, "b_dot": 0}, cyclic=["c"]
    )
    assert lin.is_stationary and lin.verdict == verdict


def hung_body(angles: str) -> sb.EquationSet:
    """A body on a ball joint with three dampers and springs of which none goes through the joint."""
    ends = {"p": (0.4, 0.1, 0.0), "q": (-0.1, 0.5, 0.2), "r": (0.1, -0.2, 0.6)}
    frames = {name: sb.Frame(at=at) for name, at in ends.items()} | {"o": sb.Frame(at=(-0.1, 0.1, -0.2))}
    posts = {"P": (0.5, 0.9, 0.1), "Q": (-0.8, 0.7, 0.3), "R": (0.2, 0.1, 1.4)}
    body = sb.Body("Body", mass=2, inertia=(0.11, 0.15, 0.21), products=(0.01, -0.02, 0.03), frames=frames)
    names = ["e0", "e1", "e2", "e3"] if angles == "quaternion" else ["a", "b", "c"]
    ball = sb.Spherical("ball", "ground", "Body.o", angles=angles, coordinates=names)
    springs = [
        sb.SpringDamper(
            f"s{a}", f"ground.{a.upper()}", f"Body.{a}", stiffness=50 + 20 * k, damping=0.3, free=0.2
        )
        for k, a in enumerate(ends)
    ]
    ground = {name: sb.Frame(at=at) for name, at in posts.items()}
    return sb.form_equations(sb.Model("hung", [body, ball, *springs], gravity=(0, 0, -G), ground=ground))


def test_quaternions_oscillate_as_angles_do() -> None:
    found = []
    for angles in ("quaternion", "xyz", "323"):
        eqs = hung_body(angles)
        guess = {"a": 0.3, "b": 0.4, "c": -0.3} if angles == "323" else {}
        state = sb.find_equilibrium(eqs, guess)
        lin = sb.linearize(eqs, state, outputs=["frame r Body ground ground"])
        assert lin.is_stationary and lin.A.shape == (6, 6) and lin.verdict == "stable" and state.stable
        found.append((state["frame r Body ground ground"], lin))
    first, lin = found[0]
    assert lin.state_names[3:] == ("ball_rx", "ball_ry", "ball_rz")
    for place, other in found[1:]:
        np.testing.assert_allclose(place, first, atol=1e-12)
        assert_same_spectrum(other.eigenvalues, lin.eigenvalues, rtol=1e-9)
    assert lin.output_names[0] == "frame r Body ground ground[0]" and lin.C.shape == (3, 6)


@cache
def four_bar(spring: bool = True) -> sb.EquationSet:
    ground = {"r": sb.Frame(at=(1.0, 0, 0)), "p": sb.Frame(at=(0.3, -0.8, 0))}
    elements: list[sb.Body | sb.Revolute | sb.SpringDamper] = []
    for name, length in (("A", 0.4), ("B", 1.1), ("C", 0.9)):
        frames = {"o": sb.Frame(at=(-length / 2, 0, 0)), "t": sb.Frame(at=(length / 2, 0, 0))}
        elements.append(sb.Body(name, mass=length, inertia=(0, 0, length**3 / 12), frames=frames))
    elements += [
        sb.Revolute("J1", "ground", "A.o", coordinate="q1"), sb.Revolute("J2", "A.t", "B.o", coordinate="q2"),
        sb.Revolute("J3", "ground.r", "C.o", coordinate="q3"), sb.Revolute("J4", "B.t", "C.t"),
    ]  # fmt: skip
    if spring:
        elements.append(sb.SpringDamper("S", "ground.p", "B", stiffness=40, damping=2, free=0.5))
    return sb.form_equations(sb.Model("four-bar", elements, gravity=(0, -G, 0), ground=ground))


def pencil(eqs: sb.EquationSet, state: sb.State) -> Array:
    """Finite eigenvalues of the equations with their multipliers kept, by central differences, at rest."""
    f = sb.compile(eqs, ["forcing", "jacobian", "constraints", "mass_matrix", "qdot"])
    q, u = np.array(list(state.q.values())), np.zeros(len(state.u))
    n, m = len(u), len(state.multipliers)
    pull, r = np.array(list(state.multipliers.values())), np.zeros(len(eqs.input_names))

    def residual(z: Array) -> Array:
        found = f(0.0, z[n : 2 * n], z[:n], r)
        forces = found.forcing + found.jacobian.T @ z[2 * n :]
        return np.concatenate([forces, found.qdot, found.constraints])

    z, h = np.concatenate([u, q, pull]), 1e-5
    rows = np.stack([(residual(z + h * e) - residual(z - h * e)) / (2 * h) for e in np.eye(len(z))], axis=1)
    E = np.zeros_like(rows)
    E[:n, :n] = f(0.0, q, u, r).mass_matrix
    E[n : 2 * n, n : 2 * n] = np.eye(n)
    assert m == len(eqs.multiplier_names)
    values = eig(rows, E, right=False, homogeneous_eigvals=True)
    finite = np.abs(values[1]) > 1e-6 * np.abs(values[0])
    return np.asarray(values[0][finite] / values[1][finite])


def test_loop_has_the_finite_eigenvalues_of_its_pencil() -> None:
    eqs = four_bar()
    state = sb.find_equilibrium(eqs, {"q1": -1.2, "q2": 0.7, "q3": -1.4})
    assert max(map(abs, state.udot.values())) < 1e-11 and state.stable
    expected = pencil(eqs, state)
    slowest = expected[np.argsort(np.abs(expected))[:2]]
    # Differences of 1e-5 are good to 1e-10; the double infinite eigenvalues do not touch the finite ones.
    assert_same_spectrum(state.linearization.eigenvalues, slowest, rtol=1e-6)


@pytest.mark.parametrize("seed", cases(range(6), fast=range(2)))
def test_random_six_bars_have_the_finite_eigenvalues_of_their_pencils(seed: int) -> None:
    """Two loops, a spring and a damper, lengths and masses at random; stable or not."""
    rng = np.random.default_rng(seed)
    eqs = sb.form_equations(six_bar(rng))
    state = sb.find_equilibrium(eqs)
    assert max(map(abs, state.udot.values())) < 1e-9
    expected, found = pencil(eqs, state), state.linearization.eigenvalues
    # Those of the loops are infinite, of order 3; differences and rounding leave them above 1e3 in these units.
    slowest = expected[np.argsort(np.abs(expected))[: found.size]]
    scale = np.abs(found).max()
    assert_same_spectrum(found, slowest, atol=1e-5 * scale)


def six_bar(rng: np.random.Generator) -> sb.Model:
    """A four-bar, and a coupler point that leads a rocker by another link."""
    a, b, c, d, e = (float(x) for x in rng.uniform([0.4, 1.4, 1.2, 1.6, 1.0], [0.6, 1.7, 1.5, 1.9, 1.4]))

    def link(name: str, length: float, **frames: sb.Frame) -> sb.Body:
        ends = {"p": sb.Frame(at=(-length / 2, 0, 0)), "q": sb.Frame(at=(length / 2, 0, 0)), **frames}
        mass = float(rng.uniform(0.5, 2))
        return sb.Body(name, mass=mass, inertia=(0, 0, mass * length**2 / 12), frames=ends)

    hinges = [("J1", "ground", "A.p"), ("J2", "A.q", "B.p"), ("J3", "ground.o", "C.p"), ("J4", "B.q", "C.q"),
              ("J5", "C.m", "D.p"), ("J6", "ground.e", "E.p"), ("J7", "D.q", "E.q")]  # fmt: skip
    return sb.Model("six-bar", [
        link("A", a), link("B", b), link("C", c, m=sb.Frame(at=(0, 0.1, 0))), link("D", d), link("E", e),
        *(sb.Revolute(name, start, end, coordinate=f"q{name[1]}") for name, start, end in hinges),
        sb.SpringDamper("S", "ground.e", "A.q", stiffness=float(rng.uniform(20, 60)), damping=1.5, free=1.0),
    ], gravity=(0, -G, 0), ground={"o": sb.Frame(at=(1.5, 0, 0)), "e": sb.Frame(at=(3.0, 0.2, 0))},
       initial={"q1": 1.2})  # fmt: skip


@pytest.mark.parametrize("name", ["q1", "q2", "q3"])
def test_any_independent_coordinate_gives_the_same_eigenvalues(name: str) -> None:
    state = sb.find_equilibrium(four_bar(), {"q1": -1.2, "q2": 0.7, "q3": -1.4})
    lin = sb.linearize(four_bar(), state, independent=[name])
    assert lin.state_names == (f"{name}_dot", name)
    assert_same_spectrum(lin.eigenvalues, state.linearization.eigenvalues, rtol=1e-9)


def test_recovered_deviations_keep_the_loop_closed() -> None:
    state = sb.find_equilibrium(four_bar(), {"q1": -1.2, "q2": 0.7, "q3": -1.4})
    known = state.linearization.recover({state.linearization.state_names[1]: 1e-6})
    moved = np.array([state.q[name] + known[name] for name in four_bar().coordinate_names])
    still = np.array(list(state.q.values()))
    phi = sb.compile(four_bar(), "constraints")
    u = np.zeros(len(state.u))
    assert np.abs(phi(0.0, moved, u) - phi(0.0, still, u)).max() < 1e-11  # second order in 1e-6
    with pytest.raises(sb.AssemblyError, match=r"linearize\.deviations"):
        state.linearization.recover({"q9": 1.0})


def test_laws_of_inputs_close_loops() -> None:
    """T = -k theta is a spring; it is no input any more."""
    lin = sb.linearize(pendulum(), inputs={"T": "-0.5*theta - 0.1*theta_dot"})
    assert lin.input_names == () and lin.B.shape == (2, 0)
    assert lin.A[0] == pytest.approx([-1.0, -G - 5.0])


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        ({"independent": ["q1", "q2"]}, "linearize.independent", "1 coordinates are independent here, but 2"),
        ({"independent": ["q9"]}, "linearize.unknown_name", "known names: q1, q1_dot"),
        ({"independent": ["q1", "q1_dot", "q2_dot"]}, "linearize.independent", "q1_dot, q2_dot"),
        ({"cyclic": ["q1"]}, "linearize.not_cyclic", "the rate of q1_dot"),
        ({"cyclic": ["q9"]}, "linearize.unknown_name", "cyclic"),
        ({"independent": ["q2"], "cyclic": ["q1"]}, "linearize.cyclic", "q1"),
    ],
)  # fmt: skip
def test_impossible_choices_are_refused(arguments: dict[str, list[str]], code: str, said: str) -> None:
    with pytest.raises(sb.AssemblyError) as caught:
        sb.linearize(four_bar(), {"q1": 1.2}, **arguments)  # type: ignore[arg-type]
    assert caught.value.problems[0].code == code and said in str(caught.value)


def test_singular_choice_at_the_dead_centre() -> None:
    """The piston's coordinate does not determine where the crank goes."""
    with pytest.raises(
        sb.AssemblyError, match=r"singular_choice.*not all other states are determined by s here"
    ):
        sb.linearize(equations_of("slider_crank"), {"theta": 0}, independent=["s"])
    assert sb.linearize(equations_of("slider_crank"), {"theta": 0}).state_names == ("theta_dot", "theta")


def test_unreachable_closure() -> None:
    with pytest.raises(sb.AssemblyError, match=r"assembly\.(conflict|open)"):
        sb.linearize(equations_of("slider_crank"), {"s": 5.0})


@pytest.mark.parametrize("name", ["cart", "four-bar", "quaternion"])
def test_the_recursive_formulation_has_the_same_linear_equations(name: str) -> None:
    eqs, at = {
        "cart": lambda: (cart_pendulum(), {"phi": 0.3, "phi_dot": 0.5}),
        "four-bar": lambda: (four_bar(), {"q1": 1.2, "q1_dot": 0.5}),
        "quaternion": lambda: (hung_body("quaternion"), {}),
    }[name]()
    again = sb.form_equations(eqs.model, formulation=sb.Recursive())
    found, wanted = (sb.linearize(each, at) for each in (again, eqs))
    assert found.state_names == wanted.state_names
    # Condition of M below 1e3, some hundred roundings of terms of A.
    for part, expected in zip(found, wanted, strict=True):
        np.testing.assert_allclose(part, expected, rtol=0, atol=1e-11 * max(1.0, np.abs(wanted.A).max()))


def test_derivatives_are_outputs_too() -> None:
    """compile(eqs, "A"), of all states, constraints held by the kernel."""
    A, B = sb.compile(four_bar(), ["A", "B"])(0.0, [1.2, -1.0, 1.5], [0.1, 0.2, 0.3])
    xdot = sb.compile(four_bar(), "xdot")
    x, h = np.array([0.1, 0.2, 0.3, 1.2, -1.0, 1.5]), 1e-6
    columns = [(xdot.of_state(0.0, x + h * e) - xdot.of_state(0.0, x - h * e)) / (2 * h) for e in np.eye(6)]
    np.testing.assert_allclose(A, np.stack(columns, axis=1), rtol=1e-7, atol=1e-7)
    assert B.shape == (6, 0)


def test_formulas_of_the_pendulum() -> None:
    eqs = pendulum()
    theta, rate = eqs.states[1], eqs.states[0]
    m, length, g, d = (next(p for p in eqs.parameters if p.name == name) for name in "mLgd")
    assert eqs.A[0, 0] == -d / (length**2 * m) and not eqs.A[0, 1].has(rate)
    assert eqs.A[0, 1].subs(theta, 0) == -g / length and eqs.A[1, 0] == 1
    assert eqs.B[0, 0] == 1 / (length**2 * m)


def test_control_is_asked_for_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """python-control gets matrices and names; without it the message says what to install."""
    asked: dict[str, object] = {}

    class Control:
        @staticmethod
        def ss(*matrices: Array, **names: list[str]) -> str:
            asked.update(names, shapes=[matrix.shape for matrix in matrices])
            return "system"

    lin = sb.linearize(pendulum())
    module = "symbody.analysis.linear.linearization.import_module"
    monkeypatch.setattr(module, lambda name: Control)
    assert lin.to_control() == "system"
    assert asked["states"] == asked["outputs"] == ["theta_dot", "theta"] and asked["inputs"] == ["T"]
    assert asked["shapes"] == [(2, 2), (2, 1), (2, 2), (2, 1)]

    def missing(name: str) -> None:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(module, missing)
    with pytest.raises(sb.EnvironmentFault, match=r"pip install symbody\[control\]"):
        lin.to_control()


@pytest.mark.filterwarnings("error")
def test_entries_of_very_different_size_give_no_warning() -> None:
    modes = spectrum(np.array([[1.0, 1e30], [1e-30, 3.0]]), ("a", "b"), 1, 1.0).modes
    assert [mode.eigenvalue.real for mode in modes] == pytest.approx([2 + math.sqrt(2), 2 - math.sqrt(2)])
