"""A Stewart platform (6-UPS): five loops in space, six freedoms, and its legs in three descriptions."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.problems.mechanisms import EPS, Array, compiled, equations_of, model_of
from tests.tiers import cases

NAME = "stewart_platform"
LENGTHS = {"L1": 1.0, "L2": 1.1, "L3": 1.05, "L4": 1.1, "L5": 1.0, "L6": 1.05}
LEGS = range(1, 7)


def points(table: dict[str, sb.Frame], letter: str) -> Array:
    """Places of the joints in their body, one a row."""
    return np.array([[float(x.text) for x in table[f"{letter}{k}"].at] for k in LEGS])


@cache
def corners() -> tuple[Array, Array]:
    model = model_of(NAME)
    return points(dict(model.ground), "a"), points(dict(model.body("Platform").frames), "b")


def leg_lengths(r: Array, R: Array) -> Array:
    """Inverse kinematics: the distances of the joints for a place and orientation of the platform."""
    feet, tips = corners()
    return np.linalg.norm(r + tips @ R.T - feet, axis=1)


@cache
def on_springs() -> sb.EquationSet:
    """The platform alone, on springs between points instead of legs."""
    model = model_of(NAME)
    springs = [
        sb.SpringDamper(f"s{k}", f"ground.a{k}", f"Platform.b{k}", stiffness="k", damping="d", free="L0")
        for k in LEGS
    ]
    return sb.form_equations(_platform("springs", springs, model, {"k": 4000, "d": 0, "L0": 1.15}))


@cache
def on_rods() -> sb.EquationSet:
    """The platform alone, on massless rods whose lengths change with time."""
    rods = [sb.Distance(f"rod{k}", f"ground.a{k}", f"Platform.b{k}", moving(k)) for k in LEGS]
    return sb.form_equations(_platform("rods", rods, model_of(NAME), {}))


def _platform(name: str, legs: list[sb.SpringDamper] | list[sb.Distance], model: sb.Model,
              parameters: dict[str, float]) -> sb.Model:  # fmt: skip
    return sb.Model(
        name, [model.body("Platform"), *legs], gravity=(0, 0, "-9.81"), parameters=parameters,
        ground=dict(model.ground), initial={"Platform_z": 1.0},
    )  # fmt: skip


def moving(k: int) -> str:
    return f"{LENGTHS[f'L{k}']} + 0.05*sin({2 + 0.3 * k}*t + {k})"


@cache
def on_driven_legs() -> sb.EquationSet:
    """The legs without mass, their lengths prescribed."""
    model, elements = model_of(NAME), []
    for element in model.elements:
        if isinstance(element, sb.Prismatic):
            k = int(element.name[-1])
            between = f"Lower{k}.foot", f"Upper{k}.tip"
            element = sb.Prismatic(f"leg{k}", *between, axis="z", coordinate=f"L{k}", motion=moving(k))
        elements.append(element)
    parameters = {"G": 9.81, "leg": 0}
    driven = sb.Model(
        "driven", elements, gravity=(0, 0, "-G"), parameters=parameters, ground=dict(model.ground)
    )
    return sb.form_equations(driven)


def check_run(run: sb.Trajectory) -> None:
    assert run.success
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    # A local error of 1e-8 in the speeds is 2e-8 in the energy, in each step, all of one sign at worst.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()
    states = run["frame r Platform"].T, np.moveaxis(run["frame R Platform"], -1, 0)
    measured = np.array([leg_lengths(r, R) for r, R in zip(*states, strict=True)])
    stored = np.stack([run[name] for name in LENGTHS], axis=1)
    np.testing.assert_allclose(measured, stored, atol=3e-10)  # three closings of 1e-10 of 1 m


def test_six_freedoms() -> None:
    eqs = equations_of(NAME)
    assert eqs.degrees_of_freedom == 6 and len(eqs.constraints) == 15
    assert sb.redundancy(eqs).degrees_of_freedom == 6


def test_assembles_at_lengths_of_the_legs() -> None:
    """From guesses 0.1 m and half a radian off."""
    state = sb.assemble(equations_of(NAME), LENGTHS)
    assert state.residual < 1e-12
    assert max(map(abs, state.moved.values())) > 0.4
    found = leg_lengths(np.asarray(state["frame r Platform"]), np.asarray(state["frame R Platform"]))
    assert found == pytest.approx(list(LENGTHS.values()), abs=1e-12)


def test_bounces_on_its_springs() -> None:
    check_run(sb.simulate(equations_of(NAME), 3.0, LENGTHS))


@pytest.mark.exhaustive
def test_bounces_for_a_minute() -> None:
    check_run(sb.simulate(equations_of(NAME), 60.0, LENGTHS))


def test_legs_without_mass_are_springs() -> None:
    """Twelve massless bodies on three joints a leg; udot of the platform as with springs between points."""
    legs, springs = equations_of(NAME), on_springs()
    state = sb.assemble(legs, LENGTHS, parameters={"leg": 0})
    r, R = (np.asarray(state[f"frame {kind} Platform"]) for kind in "rR")
    place = dict(zip(("Platform_x", "Platform_y", "Platform_z"), r, strict=True))
    quaternion = _quaternion(R)
    turned = dict(zip((f"Platform_q{x}" for x in "wxyz"), quaternion, strict=True))
    other = sb.assemble(springs, place | turned)
    for kind in ("vdot", "wdot"):
        expected, found = (np.asarray(each[f"frame {kind} Platform"]) for each in (other, state))
        # Conditions of both systems are about 1e3; accelerations are about 20.
        assert np.abs(found - expected).max() < 1e5 * EPS * np.abs(expected).max()
        assert np.abs(expected).max() > 1


def _quaternion(R: Array) -> Array:
    """Scalar first; the platform is turned by far less than pi."""
    w = math.sqrt(1 + np.trace(R)) / 2
    return np.array([w, *(np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4 * w))])


@pytest.mark.exhaustive
@pytest.mark.parametrize("t", cases([0.0, 0.7], fast=[0.7]))
def test_driven_legs_are_rods(t: float) -> None:
    """No freedom left: place, acceleration and the forces in the legs follow from the lengths."""
    legs, rods = on_driven_legs(), on_rods()
    assert legs.degrees_of_freedom == rods.degrees_of_freedom == 0
    expected, found = sb.assemble(rods, t=t), sb.assemble(legs, t=t)
    for kind in ("r", "v", "vdot", "wdot"):
        a, b = (np.asarray(each[f"frame {kind} Platform"]) for each in (expected, found))
        # Positions close to 1e-15 m; J has the condition 10, accelerations are second derivatives.
        assert np.abs(a - b).max() < 1e-10, kind
    forces = [expected.multipliers[f"lambda_rod{k}_1"] for k in LEGS]
    efforts = [float(found[f"effort leg{k}"]) for k in LEGS]
    np.testing.assert_allclose(efforts, forces, atol=1e-9)  # of 100 N
    assert sum(forces) > 100.0


def test_closings_are_those_of_the_compiled_functions() -> None:
    """Closing equations vanish where the legs are as long as inverse kinematics says, and not beside it."""
    eqs = equations_of(NAME)
    state = sb.assemble(eqs, LENGTHS)
    q, u = np.array(list(state.q.values())), np.zeros(len(eqs.speed_names))
    f = compiled(eqs, "constraints")
    assert np.abs(f(0.0, q, u, np.zeros(6))).max() < 1e-12
    q[eqs.coordinate_names.index("L4")] += 1e-3
    assert np.abs(f(0.0, q, u, np.zeros(6))).max() > 1e-4
