"""Derivatives of outputs by name: against differences with 50 digits, other formulations, closed forms."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.codegen.formation.sequences import form_sequence
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.precise_numbers import MPMATH
from symbody.formats import model_from_urdf
from tests.problems.mechanisms import EXAMPLES, equations_of, random_values, state_of

Array = NDArray[np.float64]
Point = dict[str, list[float]]
EPS = float(np.finfo(float).eps)
BASE = """<link name="base"><inertial><origin xyz="0.1 0.02 -0.1"/><mass value="5"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0" iyz="-0.02"/></inertial></link>"""


def robot_arm(formulation: sb.Recursive | sb.VirtualWork | None = None) -> sb.EquationSet:
    text = (EXAMPLES / "robot_arm" / "robot_arm.urdf").read_text(encoding="utf-8")
    model = model_from_urdf(text.replace('<link name="base"/>', BASE), floating_base=True)
    return sb.form_equations(model, formulation or sb.Recursive())


def point_of(eqs: sb.EquationSet, seed: int = 3) -> Point:
    """A consistent state with quaternions of length 1."""
    state = state_of(eqs, random_values(eqs, np.random.default_rng(seed)))
    for names in eqs.quaternions:
        places = [eqs.coordinate_names.index(name) for name in names]
        state.q[places] /= np.linalg.norm(state.q[places])
    return {"t": [0.5], "q": list(state.q), "u": list(state.u), "r": list(state.r)}


def differences(eqs: sb.EquationSet, output: str, groups: str, point: Point) -> Array:
    """Central differences with 50 digits, entry by entry along the last axis: errors far below a rounding."""
    sequence, _ = form_sequence(eqs, output)
    (asked,) = sequence.outputs
    columns = []
    with mpmath.workdps(50):
        step = mpmath.mpf(10) ** -15
        for group in groups:
            for k in range(len(point[group])):
                ends = []
                for sign in (1, -1):
                    moved = {name: [mpmath.mpf(x) for x in values] for name, values in point.items()}
                    moved[group][k] += sign * step
                    ends.append(list(evaluate_sequence(sequence, moved, MPMATH)[0]))
                columns.append([float((a - b) / (2 * step)) for a, b in zip(*ends, strict=True)])
    return np.array(columns).T.reshape(*asked.shape, len(columns))


def deviation(found: Array, expected: Array) -> float:
    assert found.shape == expected.shape
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def values(eqs: sb.EquationSet, name: str, point: Point) -> Array:
    found = sb.compile(eqs, name, quick=True)(0.5, point["q"], point["u"], point["r"])
    return np.asarray(found)


# Systems of a condition below 1e4 at these points, some tens of roundings each.
CLOSE = 1e6 * EPS


@pytest.mark.parametrize("method", ["articulated", "composite"])
def test_accelerations_of_a_floating_tree(method: str) -> None:
    eqs = robot_arm(sb.Recursive(method))
    point = point_of(eqs)
    expected = differences(eqs, "udot", "qur", point)
    assert deviation(values(eqs, "d udot/d(q, u, r)", point), expected) < CLOSE
    n = len(eqs.coordinate_names)
    assert deviation(values(eqs, "d udot/d q", point), expected[:, :n]) < CLOSE
    assert np.array_equal(values(eqs, "d udot/dq", point), values(eqs, "d udot/d q", point))


@pytest.mark.parametrize("name", ["slider_crank", "spatial_four_bar"])
def test_closed_loops(name: str) -> None:
    eqs = equations_of(name)
    point = point_of(eqs)
    for output in ("udot", "lambda", "constraints"):
        found = values(eqs, f"d {output}/d(q, u)", point)
        assert deviation(found, differences(eqs, output, "qu", point)) < CLOSE, output


@pytest.mark.parametrize("output", ["mass_matrix", "kinetic_energy", "forcing", "power"])
def test_other_outputs_by_coordinates(output: str) -> None:
    eqs = robot_arm()
    point = point_of(eqs)
    found = values(eqs, f"d {output}/d(q,u)", point)
    assert deviation(found, differences(eqs, output, "qu", point)) < CLOSE


def test_recursion_and_virtual_work_agree_on_slopes() -> None:
    """Not by components of a quaternion, which formulations continue differently beyond length 1."""
    first, second = robot_arm(), robot_arm(sb.VirtualWork())
    point = point_of(first)
    one, two = (values(eqs, "d udot/d(q, u, r)", point) for eqs in (first, second))
    w, x, y, z = point["q"][3:7]
    # along rotations of the base they mean the same
    turn = 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
    assert deviation(one[:, 3:7] @ turn, two[:, 3:7] @ turn) < CLOSE
    assert deviation(np.delete(one, range(3, 7), 1), np.delete(two, range(3, 7), 1)) < CLOSE


def test_inverse_dynamics_take_accelerations_after_the_inputs() -> None:
    for eqs in (robot_arm(), robot_arm(sb.VirtualWork())):
        point = point_of(eqs)
        f, g = sb.compile(eqs, ["mass_matrix", "forcing", "udot"]), sb.compile(eqs, "inverse_dynamics")
        assert g.signature.r == (*eqs.input_names, *eqs.acceleration_names)
        now = f(0.0, point["q"], point["u"], point["r"])
        given = np.random.default_rng(1).uniform(-1, 1, len(eqs.speed_names))
        found = g(0.0, point["q"], point["u"], [*point["r"], *given])
        expected = now.mass_matrix @ given - now.forcing
        size = np.abs(now.mass_matrix).max() + np.abs(now.forcing).max()
        assert np.abs(found - expected).max() < 100 * EPS * size  # some tens of operations
        left = g(0.0, point["q"], point["u"], [*point["r"], *now.udot])
        assert np.abs(left).max() < 100 * EPS * (np.abs(now.mass_matrix) @ np.abs(now.udot)).max()


def test_pendulum_in_closed_form() -> None:
    bob = sb.Body("Bob", mass="m", frames={"o": sb.Frame(at=(0, "L", 0))})
    pivot = sb.Revolute("pivot", "ground", "Bob.o", coordinate="theta", torque=sb.Drive(applied="T"))
    model = sb.Model(
        "pendulum", [bob, pivot], gravity=(0, "-g", 0), parameters={"m": 2, "L": 3, "g": 10}, inputs=["T"]
    )
    eqs = sb.form_equations(model)
    by_state = values(eqs, "d udot/d theta", {"q": [0.4], "u": [0.1], "r": [5.0]})
    assert by_state.shape == (1,)  # one symbol gives no axis
    assert by_state == pytest.approx([-10 / 3 * np.cos(0.4)], rel=1e-14)
    both = values(eqs, "d udot/d(T, m, t)", {"q": [0.4], "u": [0.1], "r": [5.0]})
    assert both == pytest.approx(np.array([[1 / 18, -5 / 36, 0.0]]), rel=1e-14)
    twice = values(eqs, "d d potential_energy/d theta/d theta", {"q": [0.4], "u": [0.1], "r": [5.0]})
    assert twice == pytest.approx(2 * 10 * 3 * np.cos(0.4), rel=1e-14)


def test_a_symbol_named_like_a_group_is_reached_by_parentheses() -> None:
    slider = sb.Body("Slider", mass="m")
    rail = sb.Prismatic("rail", "ground", "Slider", coordinate="q", force=sb.Drive(applied="r"))
    push = sb.Prismatic("other", "ground", "Second", coordinate="z")
    elements = [slider, sb.Body("Second", mass=1), rail, push]
    model = sb.Model("slider", elements, parameters={"m": 4}, inputs=["r"])
    eqs = sb.form_equations(model)
    point = {"q": [0.0, 0.0], "u": [0.0, 0.0], "r": [1.0]}
    assert values(eqs, "d energy/d q", point).shape == (2,)
    assert values(eqs, "d energy/d (q)", point).shape == (2,)
    assert values(eqs, "d energy/d ((q))", point).shape == (1,)


def test_what_cannot_be_differentiated_is_named() -> None:
    eqs = robot_arm()
    with pytest.raises(sb.SymbodyError, match="cannot differentiate by 'lfit'") as caught:
        eqs.roots("d udot/d lfit")
    (problem,) = caught.value.problems
    assert problem.code == "equations.derivative_by" and "lift" in problem.fix
    with pytest.raises(sb.SymbodyError, match="neither an output nor an expression"):
        eqs.roots("d udott/d q")
