"""Problems of SymPy's own tests, without rolling contact, as models.

Each test says which test or model of sympy.physics.mechanics (1.14) it answers. Tolerances: formulas of a few
operations on numbers of order one differ by some roundings, 100 eps of the largest value; linear systems by
that times their sensitivity.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
import sympy.physics.mechanics as me
from sympy.physics.mechanics.models import multi_mass_spring_damper, n_link_pendulum_on_cart

import symbody as sb
from tests.oracles.comparison import EPS, Floats, computed, sensitivity
from tests.oracles.kane import accelerations

ROUNDINGS = 100


def drawn(*names: str) -> dict[str, float]:
    """A value between 0.5 and 1.5 for each name."""
    return {name: 0.5 + random.Random(name).random() for name in names}


def close(found: Floats, expected: object) -> None:
    reference = np.array(expected, float)
    assert np.abs(found - reference.reshape(found.shape)).max() <= ROUNDINGS * EPS * np.abs(reference).max()


def agrees(
    model: sb.Model, values: Mapping[str, float], kane: me.KanesMethod, own: Mapping[str, str]
) -> None:
    """The model's accelerations are those of `kane`; `own` maps SymPy's names to the model's."""
    everything = dict(values) | {name: float(value) for name, value in parameters(model).items()}
    symbols = kane.mass_matrix.free_symbols | kane.forcing.free_symbols
    moving = me.find_dynamicsymbols(kane.mass_matrix) | me.find_dynamicsymbols(kane.forcing)
    known = {}
    for symbol in (symbols - {me.dynamicsymbols._t}) | moving:
        name = str(symbol.func if symbol.args else symbol)
        known[symbol] = everything[own.get(name, name)]
    M, F, exact = accelerations(kane, known)
    found, names = computed(model, values, "udot")
    order = [names.index(own[str(speed.func)]) for speed in kane.u]
    expected = np.array([float(x) for x in exact])
    scale = EPS * sensitivity(M.tolist(), list(F), expected)
    assert np.abs(found["udot"][order] - expected).max() <= ROUNDINGS * scale * np.abs(expected).max()


def parameters(model: sb.Model) -> dict[str, float]:
    return {name: float(value.text) for name, value in model.parameters.items() if value is not None}


# --- models.py -----------------------------------------------------------------------------------------------


def masses_in_series(n: int, gravity: bool, forces: bool) -> tuple[sb.Model, dict[str, float]]:
    elements: list[Any] = []
    before = "ground"
    for k in range(n):
        elements.append(sb.Body(f"block{k}", mass=f"m{k}"))
        drive = sb.Drive(stiffness=f"k{k}", damping=f"c{k}")
        elements.append(
            sb.Prismatic(f"slide{k}", before, f"block{k}", axis="x", coordinate=f"x{k}", force=drive)
        )
        if forces:
            elements.append(sb.Force(f"push{k}", f"block{k}", [f"f{k}", 0, 0]))
        before = f"block{k}"
    constants = drawn(*(f"{letter}{k}" for letter in "mkc" for k in range(n)), "g")
    if not gravity:
        constants.pop("g")
    inputs = [f"f{k}" for k in range(n)] if forces else []
    model = sb.Model(
        "series", elements, gravity=("g" if gravity else 0, 0, 0), parameters=constants, inputs=inputs
    )
    return model, drawn(*(name for k in range(n) for name in (f"x{k}", f"x{k}_dot", f"f{k}")))


@pytest.mark.parametrize("n", [1, 2, 3, 6])
@pytest.mark.parametrize("gravity", [False, True])
@pytest.mark.parametrize("forces", [False, True])
def test_masses_springs_and_dampers_in_series(n: int, gravity: bool, forces: bool) -> None:
    """models.multi_mass_spring_damper; with n = 1 also test_kane's test_one_dof."""
    model, values = masses_in_series(n, gravity, forces)
    agrees(
        model, values, multi_mass_spring_damper(n, gravity, forces), {f"v{k}": f"x{k}_dot" for k in range(n)}
    )


def pendulum_on_cart(n: int, torques: bool, absolute: bool) -> tuple[sb.Model, dict[str, float]]:
    """Links in angles against the vertical: as a second rotation tree, or as sums of relative angles."""
    elements: list[Any] = [
        sb.Body("cart", mass="m0"),
        sb.Prismatic("slide", "ground", "cart", axis="x", coordinate="q0", force=sb.Drive(applied="F")),
    ]
    for k in range(1, n + 1):
        before = "cart" if k == 1 else f"link{k - 1}"
        elements.append(
            sb.Body(f"link{k}", mass=f"m{k}", frames={"hinge": sb.Frame(at=(0, f"-l{k - 1}", 0))})
        )
        hinge = {"tree": {"rotation": False, "translation": True}} if absolute else {"coordinate": f"p{k}"}
        elements.append(sb.Revolute(f"hinge{k}", before, f"link{k}.hinge", **hinge))
        if absolute:
            tree = {"rotation": True, "translation": False}
            coordinates = (f"x{k}", f"y{k}", f"q{k}")
            elements.append(sb.Planar(f"angle{k}", "ground", f"link{k}", coordinates=coordinates, tree=tree))
        if torques:
            elements.append(sb.Torque(f"motor{k}", f"link{k}", [0, 0, f"T{k}"], reaction_on=before))
    constants = drawn(*(f"m{k}" for k in range(n + 1)), *(f"l{k}" for k in range(n)), "g")
    inputs = ["F", *(f"T{k}" for k in range(1, n + 1) if torques)]
    model = sb.Model("pendulum", elements, gravity=(0, "-g", 0), parameters=constants, inputs=inputs)
    names = [name for k in range(n + 1) for name in (f"q{k}", f"q{k}_dot")]
    return model, drawn(*names, *inputs)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
@pytest.mark.parametrize("torques", [False, True])
def test_pendulum_on_a_cart_in_absolute_angles(n: int, torques: bool) -> None:
    """models.n_link_pendulum_on_cart"""
    model, values = pendulum_on_cart(n, torques, absolute=True)
    kane = n_link_pendulum_on_cart(n, cart_force=True, joint_torques=torques)
    agrees(model, values, kane, {f"u{k}": f"q{k}_dot" for k in range(n + 1)})


def test_pendulum_on_a_cart_in_relative_angles() -> None:
    """models.n_link_pendulum_on_cart: absolute accelerations are sums of relative ones."""
    n = 4
    model, values = pendulum_on_cart(n, False, absolute=True)
    relative, _ = pendulum_on_cart(n, False, absolute=False)
    state = dict(values)
    for end in ("", "_dot"):
        angles = [0.0, *(values[f"q{k}{end}"] for k in range(1, n + 1))]
        state |= {f"p{k}{end}": angles[k] - angles[k - 1] for k in range(1, n + 1)}
    first, names = computed(model, values, "udot", "mass_matrix", "forcing")
    second, others = computed(relative, state, "udot")
    assert names[0] == others[0] == "q0_dot"
    summed = np.concatenate([second["udot"][:1], np.cumsum(second["udot"][1:])])
    scale = EPS * sensitivity(first["mass_matrix"], first["forcing"], first["udot"])
    assert np.abs(summed - first["udot"]).max() <= ROUNDINGS * scale * np.abs(first["udot"]).max()


# --- particles -----------------------------------------------------------------------------------------------


def test_two_masses_with_springs_and_dampers() -> None:
    """test_kane's test_two_dof, test_jointsmethod's test_two_dof_joints"""
    constants = drawn("m", "k1", "k2", "c1", "c2")
    slides = [
        sb.Prismatic(
            f"slide{k}", before, f"B{k}", axis="x", coordinate=f"q{k}",
            force=sb.Drive(stiffness=f"k{k}", damping=f"c{k}"),
        )
        for k, before in ((1, "ground"), (2, "B1"))
    ]  # fmt: skip
    model = sb.Model("two", [sb.Body("B1", mass="m"), sb.Body("B2", mass="m"), *slides], parameters=constants)
    values = drawn("q1", "q2", "q1_dot", "q2_dot")
    found, _ = computed(model, values, "udot")
    first, second = (
        constants[f"k{k}"] * values[f"q{k}"] + constants[f"c{k}"] * values[f"q{k}_dot"] for k in (1, 2)
    )
    close(found["udot"], [(second - first) / constants["m"], (first - 2 * second) / constants["m"]])


def test_two_masses_with_a_spring_between() -> None:
    """test_lagrange2's test_lagrange_2forces, in absolute displacements"""
    constants = drawn("m", "k", "nu")
    elements = [
        sb.Body("B1", mass="m"),
        sb.Body("B2", mass="m"),
        sb.Prismatic(
            "slide1", "ground", "B1", axis="x", coordinate="q1", force=sb.Drive(stiffness="k", damping="nu")
        ),
        sb.Prismatic("slide2", "ground", "B2", axis="x", coordinate="q2", force=sb.Drive(damping="nu")),
        sb.SpringDamper("spring", "B1", "B2", stiffness="k"),
    ]
    model = sb.Model("two", elements, parameters=constants)
    v = drawn("q1", "q2", "q1_dot", "q2_dot")
    found, _ = computed(model, v, "udot")
    m, k, nu = constants["m"], constants["k"], constants["nu"]
    pull = k * (v["q2"] - v["q1"])
    close(found["udot"], [(pull - k * v["q1"] - nu * v["q1_dot"]) / m, (-pull - nu * v["q2_dot"]) / m])


def test_simple_pendulum() -> None:
    """test_kane's test_pend, test_lagrange's test_simp_pen, test_jointsmethod's test_simple_pedulum"""
    elements = [
        sb.Body("B", mass="m", frames={"hinge": sb.Frame(at=("-l", 0, 0))}),
        sb.Revolute("pivot", "ground", "B.hinge", coordinate="q"),
    ]
    constants = drawn("m", "l", "g")
    model = sb.Model("pendulum", elements, gravity=("g", 0, 0), parameters=constants)
    values = drawn("q", "q_dot")
    found, _ = computed(model, values, "udot")
    close(found["udot"], [-constants["g"] / constants["l"] * math.sin(values["q"])])


def double_pendulum(gravity: str | int, **second: Any) -> tuple[sb.Model, dict[str, float]]:
    """Two equal point masses; the words of the second hinge are those given."""
    elements = [
        *(sb.Body(name, mass="m", frames={"hinge": sb.Frame(at=("-l", 0, 0))}) for name in ("P", "R")),
        sb.Revolute("first", "ground", "P.hinge", coordinate="q1"),
        sb.Revolute("second", "P", "R.hinge", coordinate="q2", **second),
    ]
    names = ["m", "l", "sigma", "delta"] if second else ["m", "l"]
    constants = drawn(*names, *(["g"] if gravity else []))
    model = sb.Model("double pendulum", elements, gravity=(gravity, 0, 0), parameters=constants)
    return model, constants | drawn("q1", "q2", "q1_dot", "q2_dot")


def test_double_pendulum_in_relative_angles() -> None:
    """test_jointsmethod's test_complete_simple_double_pendulum"""
    model, v = double_pendulum("g")
    found, _ = computed(model, v, "mass_matrix", "forcing")
    m, l, g, u1, u2 = (v[name] for name in ("m", "l", "g", "q1_dot", "q2_dot"))
    c, s, s1, s12 = math.cos(v["q2"]), math.sin(v["q2"]), math.sin(v["q1"]), math.sin(v["q1"] + v["q2"])
    close(found["mass_matrix"], m * l**2 * np.array([[3 + 2 * c, 1 + c], [1 + c, 1]]))
    first = -m * g * l * (s12 + 2 * s1) + m * l**2 * s * u2 * (2 * u1 + u2)
    close(found["forcing"], [first, -m * g * l * s12 - m * l**2 * s * u1**2])


def test_double_pendulum_in_absolute_angles() -> None:
    """test_lagrange's test_dub_pen, whose left-hand sides vanish with our accelerations"""
    model, v = double_pendulum("g")
    found, _ = computed(model, v, "udot")
    m, l, g = v["m"], v["l"], v["g"]
    q1, q2, d1, d2 = v["q1"], v["q1"] + v["q2"], v["q1_dot"], v["q1_dot"] + v["q2_dot"]
    a1, a2 = found["udot"][0], found["udot"].sum()
    c, s = math.cos(q1 - q2), math.sin(q1 - q2)
    first = [2 * g * math.sin(q1), l * c * a2, l * s * d2**2, 2 * l * a1]
    second = [g * math.sin(q2), l * c * a1, -l * s * d1**2, l * a2]
    for terms in (first, second):
        # the system [[2, c], [c, 1]] of these accelerations has a condition below 2 (3 + 1) / (2 - 1)
        assert abs(l * m * sum(terms)) <= 8 * ROUNDINGS * EPS * l * m * max(map(abs, terms))


def test_double_pendulum_with_a_spring_and_damper_in_the_hinge() -> None:
    """test_kane4's test_replace_qdots_in_force, whose speeds are the absolute rates"""
    model, v = double_pendulum(0, torque=sb.Drive(stiffness="sigma", damping="delta"))
    found, _ = computed(model, v, "udot")
    m, l, u1, u2 = v["m"], v["l"], v["q1_dot"], v["q1_dot"] + v["q2_dot"]
    c, s = math.cos(v["q2"]), math.sin(v["q2"])
    torque = v["sigma"] * v["q2"] + v["delta"] * (u2 - u1)
    M = m * l**2 * np.array([[2, c], [c, 1]])
    F = np.array([m * l**2 * s * u2**2 + torque, -m * l**2 * s * u1**2 - torque])
    expected = np.linalg.solve(M, F)
    ours = np.cumsum(found["udot"])
    assert (
        np.abs(ours - expected).max()
        <= ROUNDINGS * EPS * sensitivity(M, F, expected) * np.abs(expected).max()
    )


def test_spherical_pendulum_in_components_of_the_angular_velocity() -> None:
    """test_kane's test of a spherical pendulum by angles z-x-y, whose mass matrix is singular"""
    elements = [
        sb.Body("B", mass="m", frames={"pivot": sb.Frame(at=(0, "l", 0))}),
        sb.Spherical(
            "pivot", "ground", "B.pivot", angles="zxy", coordinates=["q1", "q2", "q3"], speeds="end",
            speed_names=["u1", "u2", "u3"],
        ),
    ]  # fmt: skip
    constants = drawn("m", "l", "g")
    model = sb.Model("spherical pendulum", elements, gravity=(0, "-g", 0), parameters=constants)
    v = constants | drawn("q1", "q2", "q3", "u1", "u2", "u3")
    found, _ = computed(model, v, "mass_matrix", "forcing")
    m, l, g = v["m"], v["l"], v["g"]
    (s1, c1), (s2, _), (s3, c3) = ((math.sin(v[f"q{k}"]), math.cos(v[f"q{k}"])) for k in (1, 2, 3))
    close(found["mass_matrix"], np.diag([m * l**2, 0, m * l**2]))
    first = g * (s1 * s3 - s2 * c1 * c3) - l * v["u2"] * v["u3"]
    third = -g * (s1 * c3 + s2 * s3 * c1) + l * v["u1"] * v["u2"]
    close(found["forcing"], [l * m * first, 0, l * m * third])


# --- rigid bodies --------------------------------------------------------------------------------------------


def test_moment_of_inertia_about_the_hinge() -> None:
    """test_kane's test_parallel_axis: the entry of the angle is the moment about the hinge."""
    elements = [
        sb.Body("C", mass="mC"),
        sb.Body("A", mass="mA", inertia=(0, 0, "Iz - mA*a**2"), frames={"hinge": sb.Frame(at=(0, "-a", 0))}),
        sb.Prismatic("slide", "ground", "C", axis="x", coordinate="q1", force=sb.Drive("F", "k", 0, "ls")),
        sb.Revolute("hinge", "C", "A.hinge", axis=(0, 0, -1), coordinate="q2"),
    ]
    constants = drawn("mA", "mC", "a", "k", "ls", "g") | {"Iz": 4.0}
    model = sb.Model("cart", elements, gravity=(0, "-g", 0), parameters=constants, inputs=["F"])
    v = constants | drawn("q1", "q2", "q1_dot", "q2_dot", "F")
    found, _ = computed(model, v, "mass_matrix", "forcing")
    swing = v["mA"] * v["a"]
    cross = swing * math.cos(v["q2"])
    close(found["mass_matrix"], [[v["mA"] + v["mC"], cross], [cross, v["Iz"]]])
    pull = v["F"] - v["k"] * (v["q1"] - v["ls"])
    turn = swing * math.sin(v["q2"])
    close(found["forcing"], [pull + turn * v["q2_dot"] ** 2, turn * v["g"]])


def test_chaos_pendulum() -> None:
    """test_jointsmethod's test_chaos_pendulum"""
    rod = sb.Body(
        "rod", mass="mA", inertia=("Ax", "Ax", 0),
        frames={"top": sb.Frame(at=(0, 0, "-lA")), "plate": sb.Frame(at=(0, 0, "lB - lA"))},
    )  # fmt: skip
    elements = [
        rod,
        sb.Body("plate", mass="mB", inertia=("Bx", "By", "Bz")),
        sb.Revolute("swing", "ground", "rod.top", axis="y", coordinate="theta"),
        sb.Revolute("spin", "rod.plate", "plate", axis="z", coordinate="phi"),
    ]
    constants = drawn("mA", "mB", "lA", "lB", "Ax", "Bx", "By", "Bz", "g")
    model = sb.Model("chaos", elements, gravity=(0, 0, "g"), parameters=constants)
    v = constants | drawn("theta", "phi", "theta_dot", "phi_dot")
    found, names = computed(model, v, "udot")
    assert names == ("theta_dot", "phi_dot")
    s, c, omega, alpha = math.sin(v["phi"]), math.cos(v["phi"]), v["theta_dot"], v["phi_dot"]
    driving = 2 * (v["By"] - v["Bx"]) * alpha * omega * s * c
    driving -= v["g"] * (v["lA"] * v["mA"] + v["lB"] * v["mB"]) * math.sin(v["theta"])
    inertia = v["Ax"] + v["Bx"] * s**2 + v["By"] * c**2 + v["lA"] ** 2 * v["mA"] + v["lB"] ** 2 * v["mB"]
    close(found["udot"], [driving / inertia, (v["Bx"] - v["By"]) * omega**2 * s * c / v["Bz"]])


def test_four_bar_linkage() -> None:
    """test_jointsmethod's test_four_bar_linkage_with_manual_constraints: its matrices at one state, as numbers"""
    moving = range(2, 5)
    links = [
        sb.Body(
            f"link{k}", mass=f"rho*l{k}", inertia=(0, 0, f"rho*l{k}**3/12"),
            frames={"P": sb.Frame(at=(f"-l{k}/2", 0, 0)), "Q": sb.Frame(at=(f"l{k}/2", 0, 0))},
        )
        for k in moving
    ]  # fmt: skip
    starts = ("ground.Q", "link2.Q", "link3.Q")
    joints = [
        sb.Revolute(f"J{k - 1}", start, f"link{k}.P", coordinate=f"q{k - 1}")
        for k, start in zip(moving, starts, strict=True)
    ]
    ground = {"P": sb.Frame(at=("-l1/2", 0, 0)), "Q": sb.Frame(at=("l1/2", 0, 0))}
    model = sb.Model(
        "four bars", [*links, *joints, sb.Revolute("closing", "link4.Q", "ground.P")], ground=ground,
        parameters={"l1": 0.13, "l2": 0.24, "l3": 0.21, "l4": 0.34, "rho": 997},
    )  # fmt: skip
    state = dict(zip(("q1", "q2", "q3"), (2.1, 0.6655470375077588, 2.527408138024188), strict=True))
    rates = (0.2, -0.17963733938852067, 0.1309060540601612)
    state |= dict(zip(("q1_dot", "q2_dot", "q3_dot"), rates, strict=True))
    M = np.array(
        [
            [3.452709815256506e01, 7.003948798374735e00, -4.939690970641498e00],
            [-2.203792703880936e-14, 2.071702479957077e-01, 2.842917573033711e-01],
            [-1.300000000000123e-01, -8.836934896046506e-03, 1.864891330060847e-01],
        ]
    )
    F = np.array([-0.031211821321648, -0.00066022608181, 0.001813559741243])
    expected = np.linalg.solve(M, F)
    # F is printed to 14 decimals and M to 15 digits, and its entry that is zero comes out as 2e-14
    error = np.abs(np.linalg.inv(M)) @ (np.array([4e-14, 4e-14, 4e-14]) * np.abs(expected).sum() + 1e-14)
    found, names = computed(model, state, "udot")
    order = [names.index(f"q{k}_dot") for k in (1, 2, 3)]
    assert np.all(np.abs(found["udot"][order] - expected) <= error)
