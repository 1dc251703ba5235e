"""Robots from URDF beside Pinocchio, where it is installed: accelerations, mass matrix, efforts, gravity."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from tests.oracles.comparison import EPS, compiled, sensitivity
from tests.oracles.robots import PinocchioRobot, comparable, example_robots, loaded

# As between other trees, see test_numeric_codes: both sides are rounded.
ROUNDINGS = 400
STATES = 3
SMALL = [("double_pendulum", False), ("double_pendulum_continuous", False), ("ur5_robot", False)]
MORE = [
    ("panda", False),
    ("double_pendulum", True),
    ("iris_simple", True),
    ("xarm7", False),
    ("so101", False),
]


def worst(name: str, floating: bool, states: int = STATES) -> dict[str, float]:
    """The largest deviation of each quantity over states, in roundings of what it is made of."""
    path = next(path for path in example_robots() if path.stem == name)
    text = comparable(path.read_text(encoding="utf-8"))
    theirs = PinocchioRobot.of(text, floating)
    model = loaded(text, floating)
    code = compiled(model, "udot", "mass_matrix", "forcing")
    order = [code.speed_names.index(speed) for speed in theirs.speeds]
    errors: dict[str, list[float]] = {}
    for number in range(states):
        q, u = theirs.state(number)
        random = np.random.default_rng(1000 + number)
        tau = random.uniform(-1.0, 1.0, len(theirs.speeds))
        given = {f"tau_{speed.removesuffix('_dot')}": x for speed, x in zip(theirs.speeds, tau, strict=True)}
        tau *= [f"tau_{speed.removesuffix('_dot')}" in model.inputs for speed in theirs.speeds]
        found = code(q | u | given)
        M, F = found["mass_matrix"][np.ix_(order, order)], found["forcing"][order]
        udot = found["udot"][order]
        M0, h0 = theirs.matrices(q, u)
        a = random.uniform(-1.0, 1.0, len(tau))
        scale = EPS * sensitivity(M, F, udot)
        expected = theirs.accelerations(q, u, tau)
        terms = np.abs(M0) @ np.abs(a) + np.abs(h0) + np.abs(tau)
        here = {
            "udot": np.abs(udot - expected).max() / np.abs(udot).max() / scale,
            "mass matrix": np.abs(M - M0).max() / np.abs(M0).max() / EPS,
            "forcing": np.abs(F - (tau - h0)).max() / terms.max() / EPS,
            "rnea": np.abs(M @ a - F + tau - theirs.inverse(q, u, a)).max() / terms.max() / EPS,
        }
        rest = {name: 0.0 for name in u}
        gravity = -code(q | rest | {name: 0.0 for name in given})["forcing"][order]
        here["gravity"] = np.abs(gravity - theirs.matrices(q, rest)[1]).max() / terms.max() / EPS
        for quantity, error in here.items():
            errors.setdefault(quantity, []).append(float(error))
    return {quantity: max(values) for quantity, values in errors.items()}


@pytest.mark.parametrize(("name", "floating"), SMALL)
def test_robots_agree_with_pinocchio(name: str, floating: bool) -> None:
    found = worst(name, floating)
    assert max(found.values()) <= ROUNDINGS, found


@pytest.mark.exhaustive
@pytest.mark.parametrize(("name", "floating"), MORE)
def test_more_robots_agree_with_pinocchio(name: str, floating: bool) -> None:
    found = worst(name, floating)
    assert max(found.values()) <= ROUNDINGS, found


# Robots whose files are at fault, and how.
REFUSED = {"ur3": "urdf.no_links", "alex_psyonic_hands": "urdf.mimic_unknown"}
# Joints that move nothing with mass: Pinocchio divides by zero.
MASSLESS = {"romeo", "romeo_laas_small"}


@pytest.mark.exhaustive
def test_every_example_loads_or_is_at_fault() -> None:
    for path in example_robots():
        for floating in (False, True):
            if path.stem in REFUSED:
                with pytest.raises(sb.SymbodyError) as caught:
                    sb.load_urdf(path, floating_base=floating)
                assert REFUSED[path.stem] in {problem.code for problem in caught.value.problems}
            else:
                sb.load_urdf(path, floating_base=floating)


@pytest.mark.exhaustive
def test_every_example_agrees_with_pinocchio() -> None:
    errors = {
        (path.stem, floating): max(worst(path.stem, floating, 1).values())
        for path in example_robots()
        for floating in (False, True)
        if path.stem not in {*REFUSED, *MASSLESS}
        and loaded(path.read_text(encoding="utf-8"), floating).joints
    }
    assert len(errors) > 120
    assert max(errors.values()) <= ROUNDINGS, errors
