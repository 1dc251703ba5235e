"""One-sided elements in analyses: no rope pushes, none is longer than it is, and dry joints stick."""

from __future__ import annotations

import math
import random
from functools import cache

import numpy as np
import pytest
from scipy.optimize import minimize

import symbody as sb
from tests.tiers import cases

G = 9.81
CHUNK = 20
ROPES = ("left", "right", "between")


def balls() -> sb.Model:
    """Two balls in the vertical plane on three ropes, one of them on a spring, too."""
    one, two = sb.Body("One", "m1"), sb.Body("Two", "m2")
    ground = {"a": sb.Frame(), "b": sb.Frame(at=("w", 0, 0)), "c": sb.Frame(at=("xs", "ys", 0))}
    parts = [
        one, two,
        sb.Rectangular("j1", "ground", one, coordinates=["x1", "y1"]),
        sb.Rectangular("j2", "ground", two, coordinates=["x2", "y2"]),
        sb.Distance("left", "ground.a", one, "La", rope=True),
        sb.Distance("right", "ground.b", two, "Lb", rope=True),
        sb.Distance("between", one, two, "Lc", rope=True),
        sb.SpringDamper("spring", "ground.c", one, stiffness="k", free="l0"),
    ]  # fmt: skip
    values = dict.fromkeys(("m1", "m2", "w", "ys", "La", "Lb", "Lc", "k"), 1.0) | {"xs": 0.0, "l0": 0.5}
    return sb.Model("balls", parts, gravity=(0, -G, 0), ground=ground, parameters=values)


@cache
def ball_equations() -> sb.EquationSet:
    return sb.form_equations(balls())


def draw(rng: random.Random) -> dict[str, float]:
    width, left, right = rng.uniform(0.5, 2), rng.uniform(0.3, 1.2), rng.uniform(0.3, 1.2)
    return {
        "m1": rng.uniform(0.3, 3), "m2": rng.uniform(0.3, 3), "w": width, "xs": rng.uniform(-1, width + 1),
        "ys": rng.uniform(-1.5, 0.8), "La": left, "Lb": right,
        "Lc": max(rng.uniform(0.3, 1.8), 1.05 * (width - left - right)),
        "k": rng.choice([rng.uniform(1, 20), rng.uniform(50, 200)]), "l0": rng.uniform(0.1, 0.8),
    }  # fmt: skip


def energy(q: np.ndarray, p: dict[str, float]) -> float:
    stretch = math.hypot(q[0] - p["xs"], q[1] - p["ys"]) - p["l0"]
    return float(p["m1"] * G * q[1] + p["m2"] * G * q[3] + p["k"] * stretch**2 / 2)


def spans(q: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """Vectors along the ropes, in their order, (3, 2)."""
    return np.array([[q[0], q[1]], [q[2] - p["w"], q[3]], [q[0] - q[2], q[1] - q[3]]])


def slacks(q: np.ndarray, p: dict[str, float]) -> np.ndarray:
    return np.array([p["La"], p["Lb"], p["Lc"]]) ** 2 - (spans(q, p) ** 2).sum(axis=1)


def unbalanced(q: np.ndarray, tensions: np.ndarray, p: dict[str, float]) -> np.ndarray:
    """What is left of weights, spring and ropes on the balls, (4,) [N]."""
    force = np.array([0.0, -p["m1"] * G, 0.0, -p["m2"] * G])
    arm = q[:2] - [p["xs"], p["ys"]]
    length = float(np.linalg.norm(arm))
    force[:2] -= p["k"] * (length - p["l0"]) * arm / length
    pulls = tensions[:, np.newaxis] * spans(q, p) / np.linalg.norm(spans(q, p), axis=1)[:, np.newaxis]
    force[:2] -= pulls[0] + pulls[2]
    force[2:] += pulls[2] - pulls[1]
    return force


def lowest(p: dict[str, float], start: np.ndarray) -> np.ndarray | None:
    """Where SLSQP finds the least energy with no rope too long; None where it does not converge."""
    limits = [{"type": "ineq", "fun": lambda q: slacks(q, p)}]
    found = minimize(energy, start, args=(p,), constraints=limits, method="SLSQP",
                     options={"maxiter": 500, "ftol": 1e-13})  # fmt: skip
    return np.asarray(found.x) if found.success and slacks(found.x, p).min() > -1e-7 else None


def check_ropes(seed: int) -> None:
    """Forces balance, ropes pull, none is too long, what is slack does not pull; and least energy is found.

    Balance is exact to rounding of terms below 1e3 N; ropes are at their length to 2e-9 of it, twice that
    in its square. SLSQP ends within some 1e-6 of where the energy, which rises with the square, is least.
    """
    rng = random.Random(seed)
    p = draw(rng)
    hanging = np.array([0.0, -0.5 * p["La"], p["w"], -0.5 * p["Lb"]])
    best = lowest(p, hanging)
    guess = hanging if best is None or rng.random() < 0.5 else best
    found = sb.find_equilibrium(ball_equations(), dict(zip(("x1", "y1", "x2", "y2"), guess, strict=True)), p)
    for state in (found, *found.branches):
        q = np.array(list(state.q.values()))
        tensions = np.array([float(state[f"rope_tension {name}"]) for name in ROPES])
        scale = G * (p["m1"] + p["m2"]) + tensions.max() + p["k"]
        assert np.abs(unbalanced(q, tensions, p)).max() < 1e-8 * scale
        assert tensions.min() > -1e-8 * scale and slacks(q, p).min() > -1e-8
        assert np.abs(tensions * slacks(q, p)).max() < 1e-7 * scale
    if best is not None and guess is best:
        assert np.abs(np.array(list(found.q.values())) - best).max() < 1e-3


# 1827 ends at equilibria with different ropes taut
@pytest.mark.parametrize("seed", cases([*range(3), 1827], fast=[1, 1827]))
def test_ropes_at_rest_fulfil_the_conditions_of_one_sided_contact(seed: int) -> None:
    check_ropes(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(100))
def test_ropes_at_rest_fulfil_the_conditions_of_one_sided_contact_everywhere(chunk: int) -> None:
    for seed in range(1000 + CHUNK * chunk, 1000 + CHUNK * (chunk + 1)):
        check_ropes(seed)


@cache
def ball(spring: bool = False) -> sb.EquationSet:
    """A ball of 2 kg on a rope of 1 m, and on a spring of 100 N/m from 3 m above on request."""
    body = sb.Body("Ball", 2)
    parts = [
        body,
        sb.Rectangular("place", "ground", body, coordinates=["x", "y"]),
        sb.Distance("rope", "ground", body, 1, rope=True),
    ]
    if spring:
        parts.append(sb.SpringDamper("spring", "ground.up", body, stiffness=100, free="l0"))
    return sb.form_equations(sb.Model("ball", parts, gravity=(0, -G, 0), parameters={"l0": 2.5} if spring else {},
                                      ground={"up": sb.Frame(at=(0, 3, 0))}))  # fmt: skip


def test_a_ball_hangs_below_its_rope_and_does_not_stand_on_it() -> None:
    """Standing the rope would push with the weight, 19.62 N."""
    for guess in ({"y": 0.9}, {"y": 0.2, "x": 0.1}, {"y": -0.5}):
        found = sb.find_equilibrium(ball(), guess)
        assert found.q["y"] == pytest.approx(-1.0) and float(found["rope_tension rope"]) == pytest.approx(
            2 * G
        )
        assert not found.branches and any("rope rope is taut with 19.62 N" in note for note in found.notes)
        assert found.verdict == "marginal"  # an undamped pendulum


def test_a_slack_rope_does_not_push() -> None:
    """The spring alone holds the ball 0.1962 m below where it is free: at 0.3038 m above the rope's end."""
    found = sb.find_equilibrium(ball(spring=True), {"y": 0.9})
    assert found.q["y"] == pytest.approx(3 - 2.5 - 0.1962) and float(found["rope_tension rope"]) == 0.0
    assert found.multipliers == {} and "rope rope is slack" in found.notes


def test_a_rope_without_tension_leaves_stability_undecided() -> None:
    """The spring alone holds the ball where the rope has its length: y = -1 at l0 = 4 - 0.1962."""
    found = sb.find_equilibrium(ball(spring=True), {"y": -0.99}, {"l0": 3.8038})
    assert found.q["y"] == pytest.approx(-1.0) and found.stable is None and found.verdict == "undecided"
    assert any("at its length without tension" in note for note in found.notes)


def test_a_board_on_three_ropes_has_tensions_that_all_pull() -> None:
    """Ropes in a row leave one share undetermined: of least norm, the one far from the weight would push."""
    places = (-1.0, 0.9, 1.0)
    frames = {f"e{k}": sb.Frame(at=(x - 0.95, 0, 0)) for k, x in enumerate(places)}
    board = sb.Body("Board", 1, (0, 0, 1), frames=frames)
    ropes = [sb.Distance(f"r{k}", f"ground.g{k}", f"Board.e{k}", 1, rope=True) for k in range(3)]
    ground = {f"g{k}": sb.Frame(at=(x, 0, 0)) for k, x in enumerate(places)}
    model = sb.Model("board", [board, sb.Planar("p", "ground", board, coordinates=["x", "y", "phi"]), *ropes],
                     gravity=(0, -G, 0), ground=ground)  # fmt: skip
    found = sb.find_equilibrium(sb.form_equations(model), {"x": 0.95, "y": -1.0})
    assert found.q == pytest.approx({"x": 0.95, "y": -1.0, "phi": 0.0}, abs=1e-8)
    taut = [note for note in found.notes if "is taut with" in note]
    assert taut and not any("push" in note or "with -" in note for note in found.notes)


def test_linear_equations_have_the_ropes_that_pull() -> None:
    """Hanging x'' = -g/L x; inside the circle a free ball; standing on it the rope is slack at once."""
    hanging = sb.linearize(ball(), {"x": 0, "y": -1})
    assert hanging.A == pytest.approx(np.array([[0, -G], [1, 0]])) and hanging.state_names == ("x_dot", "x")
    assert "rope rope is taut with 19.62 N: it constrains small deviations" in hanging.notes
    for y in (0.9, 1.0):
        free = sb.linearize(ball(), {"x": 0, "y": y})
        assert free.A.shape == (4, 4) and not free.A[:2].any()
        assert "rope rope is slack: it constrains nothing" in free.notes
    level = sb.linearize(ball(), {"x": 1, "y": 0})
    assert any("rope rope switches at this state" in note for note in level.notes)


def test_speeds_follow_by_the_ropes_that_are_taut() -> None:
    """On the circle y' = -x/y x'; off it the ball has two freedoms, and ratios of the circle do not hold."""
    on, off = sb.assemble(ball(), {"x": 0.6, "y": -0.8}), sb.assemble(ball(), {"x": 0.1, "y": 0.1})
    ratios = sb.velocity_ratios(ball(), "x", at=on)
    assert ratios.at(on) == pytest.approx(np.array([[0.75]]))
    assert any("assumed" in note for note in ratios.notes)
    with pytest.raises(sb.SimulationError, match=r"kinematics\.rope.*slack"):
        ratios.at(off)
    free = sb.velocity_ratios(ball(), at=off)
    assert free.independent == ("x_dot", "y_dot") and any("is slack here" in note for note in free.notes)


def test_positions_are_led_up_to_where_a_rope_is_too_short() -> None:
    led = sb.trace_positions(ball(), {"x": np.linspace(0.1, 1.2, 7), "y": 0.3})
    assert led.limits["x"] == pytest.approx(math.sqrt(1 - 0.3**2), abs=1e-8) and not led.success
    assert any("the rope would have to be longer" in note for note in led.notes)
    circle = sb.trace_positions(ball(), {"x": np.linspace(0.0, 0.9, 5)}, {"y": -1})
    assert circle["y"] == pytest.approx(-np.sqrt(1 - circle["x"] ** 2))
    with pytest.raises(sb.UsageError, match="rope rope is slack here"):
        sb.trace_positions(ball(), {"x": np.linspace(0.0, 0.9, 5)}, {"y": -0.3})


def test_what_is_said_of_all_configurations_says_that_ropes_are_taut() -> None:
    assert sb.redundancy(ball()).notes == ("rope rope is assumed to be taut",)
    assert sb.redundancy(ball()).degrees_of_freedom == 1 == ball().degrees_of_freedom
    ends = sb.singular_configurations(ball(), "x", {"x": (-1.2, 1.2)}, guess={"x": 0.6, "y": -0.8})
    assert [one.q["x"] for one in ends] == pytest.approx([-1.0, 1.0], abs=1e-7)


def incline(angle: float) -> sb.EquationSet:
    """A block of 2 kg on an incline along x, with a coefficient of friction of 0.5."""
    slide = sb.Prismatic("slide", "ground", sb.Body("B", 2), axis="x", coordinate="x",
                         friction=sb.Friction(mu=0.5))  # fmt: skip
    down = (G * math.sin(angle), -G * math.cos(angle), 0)
    return sb.form_equations(sb.Model("incline", [slide], gravity=down))


def test_friction_holds_a_block_on_an_incline_up_to_its_angle() -> None:
    """It rests up to tan a = mu wherever it is put; the effort is m g sin a, the limit mu m g cos a."""
    held = sb.find_equilibrium(incline(0.4), {"x": 0.3})
    assert held.q["x"] == 0.3 and held.verdict == "drifting" and held.stable is None
    assert float(held["friction slide"]) == pytest.approx(-2 * G * math.sin(0.4))
    assert any("friction holds the mechanism at the guess" in note for note in held.notes)
    with pytest.raises(sb.AssemblyError, match="friction at rest was assumed to be 0"):
        sb.find_equilibrium(incline(0.5), {"x": 0.3})


def test_linear_equations_about_a_joint_that_sticks() -> None:
    held = sb.linearize(incline(0.4))
    assert held.state_names == ("x",) and held.A[0, 0] == 0.0 and held.is_stationary
    sliding = sb.linearize(incline(0.5))
    rate = G * (math.sin(0.5) - 0.5 * math.cos(0.5))
    assert sliding.affine[0] == pytest.approx(rate) and "joint slide begins to slip forward" in sliding.notes


def test_an_edge_of_friction_is_named() -> None:
    """At tan a = mu the static limit is reached: it may stick or slip."""
    notes = sb.linearize(incline(math.atan(0.5))).notes
    assert any("the friction of joint slide switches" in note for note in notes)
