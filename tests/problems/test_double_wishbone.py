"""A double wishbone suspension: two loops in space over one freedom, against its closure equations in numpy."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.problems.mechanisms import Array

# Hard points at design height [m]: x forward, y outboard, z up.
LF, LR = np.array([0.15, 0.30, 0.22]), np.array([-0.20, 0.32, 0.20])
UF, UR = np.array([0.12, 0.42, 0.50]), np.array([-0.15, 0.44, 0.47])
RACK, TOWER = np.array([-0.13, 0.33, 0.24]), np.array([0.02, 0.45, 0.75])
LOWER, UPPER = np.array([0.0, 0.75, 0.19]), np.array([-0.02, 0.70, 0.48])
TIE, WHEEL = np.array([-0.14, 0.72, 0.23]), np.array([0.0, 0.80, 0.30])
COIL = np.array([0.01, 0.60, 0.20])  # on the lower arm
ROD = float(np.linalg.norm(TIE - RACK))


def unit(v: Array) -> Array:
    result: Array = v / np.linalg.norm(v)
    return result


def at(point: Array, origin: Array) -> sb.Frame:
    return sb.Frame(at=tuple((point - origin).tolist()))


@cache
def equations(link: str = "distance") -> sb.EquationSet:
    """One side with a fixed rack; the tie rod a distance, or a body between a universal and a ball joint."""
    lower, upper, wheel = (LF + LOWER) / 2, (UF + UPPER) / 2, WHEEL
    bodies = [
        sb.Body("Lower", mass=3.0, inertia=(0.06, 0.03, 0.08),
                frames={"bush": at(LF, lower), "ball": at(LOWER, lower), "coil": at(COIL, lower)}),
        sb.Body("Upper", mass=1.5, inertia=(0.02, 0.01, 0.025),
                frames={"bush": at(UF, upper), "ball": at(UPPER, upper)}),
        sb.Body("Carrier", mass=28.0, inertia=(0.7, 1.1, 0.7),
                frames={"lower": at(LOWER, wheel), "upper": at(UPPER, wheel), "tie": at(TIE, wheel)}),
    ]  # fmt: skip
    joints = [
        sb.Revolute("lower_bush", "ground.lower", "Lower.bush", axis=unit(LR - LF).tolist(), coordinate="p"),
        sb.Revolute("upper_bush", "ground.upper", "Upper.bush", axis=unit(UR - UF).tolist(), coordinate="s"),
        sb.Spherical("lower_ball", "Lower.ball", "Carrier.lower", angles="321", coordinates=["a", "b", "c"]),
        sb.Spherical("upper_ball", "Upper.ball", "Carrier.upper"),
    ]
    spring = sb.SpringDamper("coil", "ground.tower", "Lower.coil", stiffness=20e3, damping="d", free=0.6)
    along = unit(TIE - RACK)
    if link == "distance":
        rod: list[sb.Body | sb.Universal | sb.Spherical | sb.Distance]
        rod = [sb.Distance("tie_rod", "ground.rack", "Carrier.tie", value=ROD)]
    else:
        across = unit(np.cross(along, [0.0, 0.0, 1.0]))
        middle = (RACK + TIE) / 2
        rod = [
            sb.Body("Rod", frames={"inner": at(RACK, middle), "outer": at(TIE, middle)}),
            sb.Universal("inner", "ground.rack", "Rod.inner",
                         axes=[across.tolist(), np.cross(along, across).tolist()], coordinates=["e", "f"]),
            sb.Spherical("outer", "Rod.outer", "Carrier.tie"),
        ]  # fmt: skip
    ground = {name: at(p, np.zeros(3)) for name, p in
              (("lower", LF), ("upper", UF), ("rack", RACK), ("tower", TOWER))}  # fmt: skip
    return sb.form_equations(
        sb.Model("wishbones", [*bodies, *joints, spring, *rod], gravity=(0, 0, -9.81), ground=ground,
                 parameters={"d": 0.0})
    )  # fmt: skip


def turn(axis: Array, angle: float) -> Array:
    """Rodrigues' formula."""
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    result: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    return result


def closed(p: float) -> tuple[Array, Array]:
    """Place of the wheel's centre and orientation of the carrier for an angle of the lower arm.

    By Newton's method on the angle of the upper arm and the rotation vector of the carrier: distances from
    the lower ball to the upper one as a vector (three equations), and the length of the tie rod.
    """
    low = LF + turn(unit(LR - LF), p) @ (LOWER - LF)

    def carrier(x: Array) -> Array:
        angle = float(np.linalg.norm(x[1:]))
        return turn(x[1:] / angle, angle) if angle > 0 else np.eye(3)

    def gap(x: Array) -> Array:
        up, R = UF + turn(unit(UR - UF), x[0]) @ (UPPER - UF), carrier(x)
        tie = low + R @ (TIE - LOWER)
        return np.array([*(low + R @ (UPPER - LOWER) - up), np.linalg.norm(tie - RACK) - ROD])

    x = np.zeros(4)
    for _ in range(50):
        slopes = np.stack([(gap(x + d) - gap(x - d)) / 2e-6 for d in 1e-6 * np.eye(4)], axis=1)
        step = np.linalg.solve(slopes, gap(x))
        x = x - step
        if np.abs(step).max() < 1e-14:
            break
    assert np.abs(gap(x)).max() < 1e-13
    return low + carrier(x) @ (WHEEL - LOWER), carrier(x)


def camber_and_toe(R: Array) -> tuple[float, float]:
    """Of a wheel whose axle is y of the carrier: camber positive outwards at the top, toe-in positive."""
    axle = R[:, 1]
    return float(-np.arcsin(axle[2])), float(np.arctan2(axle[0], axle[1]))


@pytest.mark.parametrize("link", ["distance", "body"])
def test_one_freedom(link: str) -> None:
    eqs = equations(link)
    assert eqs.degrees_of_freedom == 1
    found = sb.redundancy(eqs)
    assert found.degrees_of_freedom == 1 and not found.dropped


def test_camber_and_toe_over_the_travel() -> None:
    curves = []
    for p in np.linspace(-0.2, 0.2, 5):
        state = sb.assemble(equations(), {"p": p})
        r, R = np.asarray(state["frame r Carrier"]), np.asarray(state["frame R Carrier"])
        place, turned = closed(float(p))
        # Differences of 1e-6 in Newton's method: its end is as exact as `gap`, some eps of 1 m.
        np.testing.assert_allclose(r, place, atol=1e-12)
        np.testing.assert_allclose(R, turned, atol=1e-12)
        curves.append((r[2] - WHEEL[2], *camber_and_toe(R)))
    travel, camber, toe = np.array(curves).T
    assert np.abs([travel[2], camber[2], toe[2]]).max() < 1e-12  # design height
    order = np.argsort(travel)
    assert np.ptp(travel) > 0.15
    # The upper arm is the shorter one and falls inwards: the top of the wheel goes inwards in jounce.
    assert (np.diff(camber[order])[2:] < 0).all() and camber[order][-1] < np.radians(-1.5)
    # The rack stands high behind the axle: steered one way all along the travel.
    assert (np.diff(toe[order]) < 0).all() and np.radians(1) < np.ptp(toe) < np.radians(3)


def test_a_massless_rod_is_a_distance() -> None:
    states = [sb.assemble(equations(link), {"p": 0.1, "p_dot": 1.3}) for link in ("distance", "body")]
    for kind in ("r", "v", "vdot", "wdot"):
        a, b = (np.asarray(state[f"frame {kind} Carrier"]) for state in states)
        assert np.abs(a - b).max() < 1e-9 * max(1.0, np.abs(a).max()), kind  # conditions of about 1e4
    force = states[0].multipliers["lambda_tie_rod_1"]
    body = np.asarray(states[1]["reaction outer"])[:3]
    assert np.linalg.norm(body) == pytest.approx(abs(force), rel=1e-8) and abs(force) > 1.0


def check(run: sb.Trajectory) -> None:
    assert run.success
    assert run.constraint_violation.max() < 1e-9 and run.velocity_violation.max() < 1e-9
    # A local error of 1e-8 in the speeds in each step, all of one sign at worst.
    assert run.energy_drift < 2e-8 * run.statistics.accepted * run["kinetic_energy"].max()
    for k in np.linspace(0, run.t.size - 1, 6).astype(int):
        place, R = closed(float(run["p"][k]))
        # Loops are closed to 1e-10 of the largest length, which three points share.
        np.testing.assert_allclose(run["frame r Carrier"][:, k], place, atol=1e-9)
        np.testing.assert_allclose(run["frame R Carrier"][..., k], R, atol=1e-8)


def test_bounces_on_the_coil() -> None:
    run = sb.simulate(equations(), 3.0, {"p": 0.1})
    check(run)
    crossings = np.flatnonzero(np.diff(np.sign(run["p_dot"])) != 0)
    assert crossings.size > 10  # several bounces


@pytest.mark.exhaustive
@pytest.mark.parametrize("link", ["distance", "body"])
def test_bounces_for_a_minute(link: str) -> None:
    check(sb.simulate(equations(link), 60.0, {"p": 0.1}))


def test_settles_with_a_damper() -> None:
    run = sb.simulate(equations(), 8.0, {"p": 0.1}, parameters={"d": 2000})
    assert run.success and np.abs(run.u[:, -1]).max() < 1e-6
    assert run.work[-1] == pytest.approx(run.energy[-1] - run.energy[0], rel=1e-6)
    # At rest the coil carries the weight of all bodies by virtual work: dV/dp = 0.
    rest = float(run["p"][-1])
    heights = [closed(rest + d)[0][2] for d in (1e-4, -1e-4)]
    lower = [(LF + turn(unit(LR - LF), rest + d) @ ((LOWER - LF) / 2))[2] for d in (1e-4, -1e-4)]
    coils = [np.linalg.norm(LF + turn(unit(LR - LF), rest + d) @ (COIL - LF) - TOWER) for d in (1e-4, -1e-4)]
    heavy = 9.81 * (28 * (heights[0] - heights[1]) + 3 * (lower[0] - lower[1]))
    spring = 20e3 * (np.mean(coils) - 0.6) * (coils[0] - coils[1])
    # The upper arm of 1.5 kg, whose centre moves half as much as its ball, is some 3 % of the weight.
    assert spring == pytest.approx(-heavy, rel=0.05)
