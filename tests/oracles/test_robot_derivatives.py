"""Derivatives of accelerations and of inverse dynamics of robots beside Pinocchio, where it is installed."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from tests.oracles.comparison import EPS, Floats, compiled, sensitivity
from tests.oracles.robots import PinocchioRobot, comparable, example_robots, loaded

SMALL = [("double_pendulum", False), ("ur5_robot", False), ("iris_simple", True)]
MORE = [("double_pendulum_continuous", False), ("so101", False), ("double_pendulum", True), ("anymal", True)]
# Roundings: derivatives take several times the operations of what is derived, on both sides.
ROUNDINGS = 2000


def tangent(theirs: PinocchioRobot, names: tuple[str, ...], q: dict[str, float]) -> Floats:
    """How coordinates change along v: the base's turns change its quaternion, its shifts nothing else."""
    found = np.zeros((len(names), len(theirs.speeds)))
    for k, speed in enumerate(theirs.speeds):
        if speed.endswith("_dot") and speed.removesuffix("_dot") in names:
            found[names.index(speed.removesuffix("_dot")), k] = 1.0
        elif speed.endswith("_wx"):
            base = speed.removesuffix("_wx")
            rows = [names.index(f"{base}_{part}") for part in ("qw", "qx", "qy", "qz")]
            w, x, y, z = (q[names[row]] for row in rows)
            turns = 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
            found[np.ix_(rows, [k, k + 1, k + 2])] = turns
    return found


def worst(name: str, floating: bool) -> float:
    """The largest deviation of a derivative at a random state, in roundings of what it is made of."""
    path = next(path for path in example_robots() if path.stem == name)
    text = comparable(path.read_text(encoding="utf-8"))
    theirs = PinocchioRobot.of(text, floating)
    assert not theirs.ties
    model = loaded(text, floating)
    code = compiled(model, "udot", "mass_matrix", "forcing", "d udot/d q", "d udot/d u", "d udot/d r")
    order = [code.speed_names.index(speed) for speed in theirs.speeds]
    q, u = theirs.state(5)
    tau = np.random.default_rng(6).uniform(-1.0, 1.0, len(theirs.speeds))
    given = {f"tau_{speed.removesuffix('_dot')}": x for speed, x in zip(theirs.speeds, tau, strict=True)}
    tau *= [f"tau_{speed.removesuffix('_dot')}" in model.inputs for speed in theirs.speeds]
    found = code(q | u | given)
    here, v = theirs.vectors(q, u)
    theirs.pin.computeABADerivatives(theirs.model, theirs.data, here, v, tau)
    data, names = theirs.data, code.groups[0]
    efforts = [f"tau_{speed.removesuffix('_dot')}" for speed in theirs.speeds]
    columns = [efforts.index(name) for name in code.groups[2] if name in efforts]
    pairs = [
        (found["d udot/d q"][order] @ tangent(theirs, names, q), np.array(data.ddq_dq)),
        (found["d udot/d u"][np.ix_(order, order)], np.array(data.ddq_dv)),
        (found["d udot/d r"][order], np.array(data.Minv)[:, columns]),
    ]
    M, F = found["mass_matrix"][np.ix_(order, order)], found["forcing"][order]
    scale = EPS * sensitivity(M, F, found["udot"][order])
    return max(float(np.abs(a - b).max() / np.abs(b).max() / scale) for a, b in pairs if b.size)


@pytest.mark.parametrize(("name", "floating"), SMALL)
def test_derivatives_agree_with_pinocchio(name: str, floating: bool) -> None:
    assert worst(name, floating) <= ROUNDINGS


@pytest.mark.exhaustive
@pytest.mark.parametrize(("name", "floating"), MORE)
def test_more_derivatives_agree_with_pinocchio(name: str, floating: bool) -> None:
    assert worst(name, floating) <= ROUNDINGS


def test_inverse_dynamics_and_their_derivatives_agree_with_pinocchio() -> None:
    path = next(path for path in example_robots() if path.stem == "ur5_robot")
    text = comparable(path.read_text(encoding="utf-8"))
    theirs = PinocchioRobot.of(text, False)
    eqs = sb.form_equations(loaded(text, False))
    f = sb.compile(eqs, ["inverse_dynamics", "d inverse_dynamics/d q", "d inverse_dynamics/d u"])
    q, u = theirs.state(8)
    a = np.random.default_rng(9).uniform(-1.0, 1.0, len(theirs.speeds))
    here, v = theirs.vectors(q, u)
    assert tuple(theirs.speeds) == eqs.speed_names
    none = [0.0] * len(eqs.input_names)
    found = f(0.0, [q[name] for name in eqs.coordinate_names], v, [*none, *a])
    efforts = theirs.inverse(q, u, a)
    by_q, by_v, _ = map(np.array, theirs.pin.computeRNEADerivatives(theirs.model, theirs.data, here, v, a))
    for ours, expected in zip(found, (efforts, by_q, by_v), strict=True):
        # Sums of some tens of terms of the size of the largest effort.
        size = max(np.abs(expected).max(), np.abs(efforts).max())
        np.testing.assert_allclose(ours, expected, rtol=0, atol=ROUNDINGS * EPS * size)
