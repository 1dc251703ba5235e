"""Ropes: shocks, slackness and winches against closed forms."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import symbody as sb

G, M, L = 9.81, 0.7, 0.8
TIGHT = {"rtol": 1e-11, "atol": 1e-12}


def ball(value: str = "L", **options: object) -> sb.Model:
    """A ball in the vertical plane, on a rope from the origin."""
    body = sb.Body("Ball", "m")
    place = sb.Rectangular("place", "ground", body, coordinates=["x", "y"])
    rope = sb.Distance("rope", "ground", body, value, rope=True)
    return sb.Model("ball", [body, place, rope], gravity=(0, "-g", 0),
                    parameters={"m": M, "g": G, "L": L})  # fmt: skip


@cache
def ball_equations(value: str = "L") -> sb.EquationSet:
    return sb.form_equations(ball(value))


def names(run: sb.Trajectory) -> list[str]:
    return [event.name for event in run.events]


def test_a_ball_thrown_up_flies_until_the_rope_is_taut() -> None:
    x0, vx, vy = 0.1, 1.5, 4.0
    run = sb.simulate(ball_equations(), 0.5, {"x": x0, "y": 0.0, "x_dot": vx, "y_dot": vy}, **TIGHT)
    assert run.success
    roots = np.roots([G**2 / 4, -vy * G, vx**2 + vy**2, 2 * x0 * vx, x0**2 - L**2])
    t = min(root.real for root in roots if abs(root.imag) < 1e-12 and root.real > 0)
    first = run.events[0]
    assert first.name == "rope taut"
    # Errors of the integration at rtol = 1e-11; the parabola itself is within the order of the method.
    assert first.t == pytest.approx(t, abs=1e-10)
    place = np.array([x0 + vx * t, vy * t - G * t**2 / 2])
    before = np.array([vx, vy - G * t])
    along = place / L
    after = before - along * (along @ before)
    (k,) = np.flatnonzero((run.t[:-1] == run.t[1:]) & (run.t[1:] == first.t))[:1]
    assert np.array([run["x_dot"][k], run["y_dot"][k]]) == pytest.approx(before, abs=1e-9)
    assert np.array([run["x_dot"][k + 1], run["y_dot"][k + 1]]) == pytest.approx(after, abs=1e-9)
    lost = M * (along @ before) ** 2 / 2
    assert run["work"][k] == pytest.approx(0.0, abs=1e-9)
    assert run["work"][k + 1] == pytest.approx(-lost, abs=1e-9)
    assert run.energy_drift < 1e-9
    (note,) = [note for note in run.notes if "impact" in note]
    assert f"rope by {M * (along @ before):.6g} N s; {lost:.6g} J are lost" in note


def test_slack_ropes_are_no_constraints() -> None:
    eqs = ball_equations()
    assert eqs.degrees_of_freedom == 1 and any("taut rope" in note for note in eqs.notes)
    run = sb.simulate(eqs, 0.1, {"x": 0.1, "y": 0.0})
    assert (run["rope_tension rope"] == 0.0).all() and (run["reaction rope"] == 0.0).all()
    assert (run["lambda_rope_1"] == 0.0).all()
    assert run["rope_slack rope"] == pytest.approx(L - np.hypot(run["x"], run["y"]))
    assert (run["lambda"] == 0.0).all()


def test_a_pendulum_over_the_top_goes_slack() -> None:
    """Released at the bottom with 2 g L < v0^2 < 5 g L; a parabola from where the tension ends to the circle."""
    v0 = np.sqrt(3.5 * G * L)
    run = sb.simulate(ball_equations(), 1.6, {"x": 0.0, "y": -L, "x_dot": v0}, guess={"y_dot": 0.0}, **TIGHT)
    assert run.success
    slack, taut = run.events[:2]
    assert names(run)[:2] == ["rope slack", "rope taut"]
    height = (v0**2 - 2 * G * L) / (3 * G)
    # The slope of the tension there is about 3 m g^(3/2) / L^(1/2): events are good to what it is good to.
    assert slack.state["y"] == pytest.approx(height, abs=1e-9)
    v2 = v0**2 - 2 * G * (L + height)
    assert v2 == pytest.approx(G * height)
    c, s = height / L, np.sqrt(1 - (height / L) ** 2)
    v = np.sqrt(v2)
    # Upwards on the right: velocity v (-c, s).
    roots = np.roots([G**2 / 4, -v * s * G, v2 - height * G, 2 * (L * s * -v * c + height * v * s), 0.0])
    t = max(root.real for root in roots if abs(root.imag) < 1e-4)
    assert taut.t - slack.t == pytest.approx(t, abs=1e-8)
    inside = run.at(slack.t + 0.3 * t)
    assert inside["x"] == pytest.approx(L * s - v * c * 0.3 * t, abs=1e-8)
    assert inside["rope_tension rope"] == 0.0
    assert run["rope_tension rope"][run.t < slack.t].min() > -1e-9
    assert run.energy_drift < 1e-8


@cache
def two_bodies() -> sb.EquationSet:
    one, two = (sb.Body(name, mass, (0.01, 0.02, 0.03), frames={"e": sb.Frame(at=(0.1, 0, 0))})
                for name, mass in (("One", 1.0), ("Two", 2.5)))  # fmt: skip
    joints = [sb.Free("f1", "ground", one, angles="xyz"), sb.Free("f2", "ground", two, angles="xyz")]
    rope = sb.Distance("a long rope", "One.e", "Two.e", 1, rope=True)
    return sb.form_equations(sb.Model("two", [one, two, *joints, rope], gravity=(0, 0, 0)))


@pytest.mark.exhaustive
def test_momentum_of_free_bodies_is_kept() -> None:
    eqs = two_bodies()
    start = {"f1_x": 0.0, "f2_x": 0.3, "f2_y": 0.2, "f1_x_dot": -1.0, "f1_y_dot": 0.4, "f2_x_dot": 1.0,
             "f2_z_dot": 0.3, "f1_3_dot": 2.0, "f2_1_dot": -1.0}  # fmt: skip
    run = sb.simulate(eqs, 2.0, start, **TIGHT)
    assert run.success and "a long rope taut" in names(run)
    for axis in "xyz":
        momentum = 1.0 * run[f"f1_{axis}_dot"] + 2.5 * run[f"f2_{axis}_dot"]
        assert np.abs(momentum - momentum[0]).max() < 1e-9
    spin = angular_momentum(run)
    assert np.abs(spin - spin[:, :1]).max() < 1e-8
    assert run["rope_tension a long rope"].min() > -1e-9
    assert run.energy_drift < 1e-8 and run["energy"][-1] < run["energy"][0] - 0.1


def angular_momentum(run: sb.Trajectory) -> np.ndarray:
    total = np.zeros((3, run.t.size))
    for name, mass in (("One", 1.0), ("Two", 2.5)):
        r, v = run[f"frame r {name}"], run[f"frame v {name}"]
        turn, w = run[f"frame R {name}"], run[f"frame w {name}"]
        local = np.einsum("jit,jt->it", turn, w) * np.array([0.01, 0.02, 0.03])[:, np.newaxis]
        total += mass * np.cross(r, v, axis=0) + np.einsum("ijt,jt->it", turn, local)
    return total


def winch() -> sb.Model:
    load = sb.Body("Load", "m")
    guide = sb.Prismatic("guide", "ground", load, axis="y", coordinate="y")
    rope = sb.Distance("rope", "ground", load, "L - V*t", rope=True)
    return sb.Model("winch", [load, guide, rope], gravity=(0, "-g", 0),
                    parameters={"m": M, "g": G, "L": L, "V": 0.2})  # fmt: skip


def test_a_falling_load_is_caught_by_a_winch_and_hoisted() -> None:
    run = sb.simulate(sb.form_equations(winch()), 0.5, {"y": -L + 0.05, "y_dot": 0.0}, **TIGHT)
    assert run.success and names(run) == ["rope taut"]
    t = (-0.2 + np.sqrt(0.04 + 2 * G * 0.05)) / G
    assert run.events[0].t == pytest.approx(t, abs=1e-10)
    hanging = np.flatnonzero(run.t == run.events[0].t)[1]
    assert run["y_dot"][hanging:] == pytest.approx(0.2, abs=1e-9)
    assert run["rope_tension rope"][hanging:] == pytest.approx(M * G, rel=1e-9)
    (note,) = [note for note in run.notes if "impact" in note]
    jump = G * t + 0.2
    assert f"{M * jump:.6g} N s; {M * jump**2 / 2:.6g} J are lost" in note
    assert run.energy_drift < 1e-9


def carts(friction: sb.Friction | None = None) -> sb.Model:
    """Two carts on one rail, the first pulled by F, a rope between them."""
    one, two = sb.Body("One", "m1"), sb.Body("Two", "m2")
    joints = [sb.Prismatic("p1", "ground", one, coordinate="x1"),
              sb.Prismatic("p2", "ground", two, coordinate="x2", friction=friction)]  # fmt: skip
    rope = sb.Distance("rope", two, one, "L", rope=True)
    pull = sb.Force("pull", one, ("F", 0, 0))
    numbers = {"m1": 2.0, "m2": 0.5, "g": G, "L": L, "mu": 0.2, "mus": 0.3}
    return sb.Model("carts", [one, two, *joints, rope, pull], gravity=(0, 0, "-g"), parameters=numbers,
                    inputs=["F"])  # fmt: skip


@pytest.mark.exhaustive
def test_a_cart_pulls_another_after_a_shock() -> None:
    eqs = sb.form_equations(carts())
    times = np.linspace(0.0, 1.0, 11)
    start = {"x1": 0.3, "x2": 0.0, "x1_dot": 1.0, "x2_dot": 0.0}
    run = sb.simulate(eqs, 1.0, start, inputs={"F": 3.0}, times=times, **TIGHT)
    assert (run.t == times).all() and names(run) == ["rope taut"]
    t = (-1.0 + np.sqrt(1.0 + 2 * 1.5 * 0.5)) / 1.5
    assert run.events[0].t == pytest.approx(t, abs=1e-10)
    common = 2.0 * (1.0 + 1.5 * t) / 2.5
    later = times > t
    assert run["x1_dot"][later] == pytest.approx(common + 1.2 * (times[later] - t), abs=1e-9)
    assert run["x1"][later] - run["x2"][later] == pytest.approx(L, abs=1e-9)
    assert run["rope_tension rope"][later] == pytest.approx(3.0 * 0.5 / 2.5, abs=1e-9)
    assert run.energy_drift < 1e-9
    # The pull ends: both go on at the same speed, and nothing decides whether the rope is taut.
    free = sb.simulate(eqs, 1.0, start, inputs={"F": 0.0}, **TIGHT)
    assert free.success and names(free) == ["rope taut"]
    assert free["x2_dot"][-1] == pytest.approx(0.8, abs=1e-12)


@pytest.mark.exhaustive
def test_a_sample_at_a_shock_is_the_state_after_it() -> None:
    start = {"x1": 0.3, "x2": 0.0, "x1_dot": 1.0, "x2_dot": 0.0}
    eqs = sb.form_equations(carts())
    run = sb.simulate(eqs, 1.0, {**start, "x1": L}, inputs={"F": 0.0}, times=[0.0, 0.5, 1.0])
    assert run["x1_dot"] == pytest.approx(0.8, abs=1e-12)
    run = sb.simulate(eqs, 0.5, {**start, "x1": L}, inputs={"F": 0.0})
    assert run["x1_dot"][:2] == pytest.approx([1.0, 0.8], abs=1e-12) and (run.t[:2] == 0.0).all()
    assert run["work"][:2] == pytest.approx([0.0, -0.2], abs=1e-12)
    assert run["energy"][:2] == pytest.approx([1.0, 0.8], abs=1e-12) and names(run) == ["rope taut"]


def test_a_rope_on_a_block_with_friction() -> None:
    """The block sticks until it is jerked, and stops together with the cart that pulls it."""
    eqs = sb.form_equations(carts(sb.Friction(mu="mu", mu_static="mus")))
    start = {"x1": 0.3, "x2": 0.0, "x1_dot": 1.0, "x2_dot": 0.0}
    run = sb.simulate(eqs, 3.0, start, inputs={"F": 0.0}, **TIGHT)
    assert run.success and names(run) == ["rope taut", "p2 slips forward", "p2 sticks"]
    t = 0.5
    assert run.events[0].t == pytest.approx(t, abs=1e-10)
    slower = 0.2 * 0.5 * G / 2.5
    assert run.events[2].t == pytest.approx(t + 0.8 / slower, abs=1e-8)
    assert run["x2"][-1] == pytest.approx(0.8**2 / (2 * slower), abs=1e-9)
    sliding = (run.t > run.events[0].t) & (run.t < run.events[2].t)
    assert run["rope_tension rope"][sliding] == pytest.approx(2.0 * slower, abs=1e-9)
    assert run["friction p2"][sliding] == pytest.approx(-0.2 * 0.5 * G, abs=1e-9)
    assert run.energy_drift < 1e-9


@pytest.mark.exhaustive
def test_a_taut_rope_breaks_a_block_away() -> None:
    eqs = sb.form_equations(carts(sb.Friction(mu="mu", mu_static="mus")))
    run = sb.simulate(eqs, 1.0, {"x1": L, "x2": 0.0}, inputs={"F": "3*t"}, **TIGHT)
    assert names(run) == ["p2 slips forward"]
    away = 0.3 * 0.5 * G / 3.0
    assert run.events[0].t == pytest.approx(away, abs=1e-9)
    s = 1.0 - away
    rate = (3.0 * away - 0.2 * 0.5 * G) * s / 2.5 + 3.0 * s**2 / 5.0
    assert run["x2_dot"][-1] == pytest.approx(rate, abs=1e-9)


def two_ropes() -> sb.EquationSet:
    ball_body = sb.Body("Ball", "m", frames={"o": sb.Frame()})
    place = sb.Rectangular("place", "ground", ball_body, coordinates=["x", "y"])
    ropes = [sb.Distance("first", "ground", ball_body, "L", rope=True),
             sb.Distance("second", "ground.peg", ball_body, "l", rope=True)]  # fmt: skip
    return sb.form_equations(
        sb.Model("two ropes", [ball_body, place, *ropes], gravity=(0, "-g", 0),
                 ground={"peg": sb.Frame(at=("px", "py", 0))},
                 parameters={"m": M, "g": G, "L": L, "px": 0.0, "py": -0.5, "l": 0.4})
    )  # fmt: skip


def test_the_second_of_two_ropes_takes_over_or_stops_the_ball() -> None:
    eqs = two_ropes()
    corner = np.array([0.0, -L])  # of a swing from the left, at which the second rope goes taut
    start = {"x": -0.3, "y": -np.sqrt(L**2 - 0.09), "x_dot": 1.0, "y_dot": -0.3 / np.sqrt(L**2 - 0.09)}
    for peg, after in ((np.array([-0.2, -0.5]), "first slack"), (np.array([-0.5, -1.2]), None)):
        length = float(np.linalg.norm(corner - peg))
        values = {"px": peg[0], "py": peg[1], "l": length}
        run = sb.simulate(eqs, 0.45, start, parameters=values, **TIGHT)
        assert run.success and run.energy_drift < 1e-8
        hit = run.events[0]
        assert hit.name == "second taut"
        # The events at which its distance is its length again: the bottom of the first circle.
        assert [hit.state["x"], hit.state["y"]] == pytest.approx(corner, abs=1e-8)
        (k, *_) = np.flatnonzero((run.t[:-1] == run.t[1:]) & (run.t[1:] == hit.t))
        speed = hit.state["x_dot"]
        along = (corner - peg) / length
        if after is None:  # the ropes pull in opposite senses: the ball stays where it is
            assert np.hypot(run["x_dot"][k + 1], run["y_dot"][k + 1]) == pytest.approx(0.0, abs=1e-9)
        else:
            assert names(run)[1] == after
            left = np.array([speed, 0.0]) - along * along[0] * speed
            assert [run["x_dot"][k + 1], run["y_dot"][k + 1]] == pytest.approx(left, abs=1e-8)


def test_assembly_with_ropes() -> None:
    eqs = ball_equations()
    with pytest.raises(sb.AssemblyError, match=r"assembly\.rope_too_short.*constraint rope") as caught:
        sb.assemble(eqs, {"x": 1.0, "y": 0.0})
    assert "1 m apart, but the rope is 0.8 m long" in str(caught.value)
    # What is guessed is moved to the rope's length; speeds that are not fixed keep it taut.
    state = sb.assemble(eqs, {"x": 0.5, "x_dot": 1.0}, {"y": -2.0})
    assert state.q["y"] == pytest.approx(-np.sqrt(L**2 - 0.25)) and state.moved["y"] > 1.0
    assert state.u["y_dot"] == pytest.approx(0.5 / np.sqrt(L**2 - 0.25))
    v2 = 1.0 + state.u["y_dot"] ** 2
    assert state["rope_tension rope"] == pytest.approx(M * (v2 / L + G * np.sqrt(L**2 - 0.25) / L))
    # Shorter ropes are no constraints, taut ones that would push neither.
    assert sb.assemble(eqs, {"x": 0.1, "y": 0.0}).multipliers == {}
    above = sb.assemble(eqs, {"x": 0.0, "y": L})
    assert above.udot["y_ddot"] == pytest.approx(-G) and above["rope_tension rope"] == 0.0
    # Fixed speeds may stretch it: the motion begins with the shock.
    assert sb.assemble(eqs, {"x": L, "y": 0.0, "x_dot": 1.0}).u["x_dot"] == 1.0


@pytest.mark.exhaustive
@pytest.mark.parametrize("held", [sb.Baumgarte(), sb.GGL(), sb.Partition()])
def test_other_ways_to_hold_constraints(held: object) -> None:
    v0 = np.sqrt(3.5 * G * L)
    start = {"x": 0.0, "y": -L, "x_dot": v0, "y_dot": 0.0}
    run = sb.simulate(ball_equations(), 1.2, start, constraints=held)
    reference = sb.simulate(ball_equations(), 1.2, start, **TIGHT)
    assert run.success and names(run) == names(reference)
    # rtol = 1e-8 over some 100 steps; Baumgarte's drift is of the order of 1e-6.
    assert run["x"][-1] == pytest.approx(reference["x"][-1], abs=1e-4)
    assert run.events[0].t == pytest.approx(reference.events[0].t, abs=1e-5)


def chain() -> sb.EquationSet:
    """Three balls in the plane, each on a rope from the one before."""
    balls = [sb.Body(f"B{k}", "m") for k in range(3)]
    places = [
        sb.Rectangular(f"p{k}", "ground", body, coordinates=[f"x{k}", f"y{k}"])
        for k, body in enumerate(balls)
    ]
    ropes = [
        sb.Distance(f"r{k}", "ground" if k == 0 else balls[k - 1], balls[k], "L", rope=True) for k in range(3)
    ]
    numbers = {"m": 1.0, "g": G, "L": 0.5}
    return sb.form_equations(
        sb.Model("chain", [*balls, *places, *ropes], gravity=(0, "-g", 0), parameters=numbers)
    )


@pytest.mark.exhaustive
def test_a_chain_of_ropes_never_stretches_and_never_pushes() -> None:
    eqs, random = chain(), np.random.default_rng(4)
    for _ in range(4):
        start: dict[str, float] = {}
        place = np.zeros(2)
        for k in range(3):
            place = place + random.uniform(-0.3, 0.3, 2)
            speed = random.uniform(-2.0, 2.0, 2)
            start |= {f"x{k}": place[0], f"y{k}": place[1], f"x{k}_dot": speed[0], f"y{k}_dot": speed[1]}
        run = sb.simulate(eqs, 3.0, start, rtol=1e-9, atol=1e-11)
        assert run.success and len(run.events) > 5
        for k in range(3):
            # What counts as at its length is 2e-9 of it; tensions are of up to 100 N, states good to 1e-9.
            assert run[f"rope_slack r{k}"].min() > -2e-9
            assert run[f"rope_tension r{k}"].min() > -1e-7
        # rtol of some 100 J, gathered over 3 s.
        assert run.energy_drift < 1e-6


@pytest.mark.exhaustive
def test_a_ball_starts_where_its_rope_begins() -> None:
    run = sb.simulate(ball_equations(), 1.0, {"x": 0.0, "y": 0.0})
    assert run.success and names(run) == ["rope taut"]
    assert run.events[0].t == pytest.approx(np.sqrt(2 * L / G), abs=1e-9)
    assert run["y"][-1] == pytest.approx(-L, abs=1e-9)


def test_as_many_slack_ropes_as_speeds() -> None:
    body = sb.Body("Ball", "m")
    place = sb.Rectangular("place", "ground", body, coordinates=["x", "y"])
    ropes = [sb.Distance(f"rope {k}", f"ground.hook{k}", body, "L", rope=True) for k in range(2)]
    hooks = {f"hook{k}": sb.Frame(at=(0.3 * k, 0, 0)) for k in range(2)}
    model = sb.Model("swing", [body, place, *ropes], (0, -G, 0), {"m": M, "L": L}, ground=hooks)
    run = sb.simulate(sb.form_equations(model), 0.1, {"x": 0.1, "y": -0.1})
    assert run.success and run["y"][-1] == pytest.approx(-0.1 - G * 0.1**2 / 2)


def test_an_action_cannot_lengthen_a_rope() -> None:
    parts = [
        sb.Prismatic("way", "ground", sb.Body("Ball", mass=1), axis="x", coordinate="x"),
        sb.Distance("leash", "ground", "Ball", 1.0, rope=True),
    ]
    eqs = sb.form_equations(sb.Model("leashed", parts))
    far = sb.Event("t - 0.5", action={"x": "1.5"}, name="far")
    run = sb.simulate(eqs, 1.0, {"x_dot": 0.2}, events=far)
    assert run.status is sb.Status.UNMET_ACTION
    assert run.t[-1] == pytest.approx(0.5)
    assert (
        "action of event 'far' moves the ends of leash farther apart than the rope is long" in run.notes[-1]
    )


def test_an_action_at_a_taut_rope_is_a_shock() -> None:
    """A ball whose rate is doubled on a taut rope is stopped by it at once, and the work counts."""
    parts = [
        sb.Prismatic("way", "ground", sb.Body("Ball", mass=2), axis="x", coordinate="x"),
        sb.Distance("leash", "ground", "Ball", 1.0, rope=True),
    ]
    eqs = sb.form_equations(sb.Model("leashed", parts))
    kick = sb.Event("t - 0.5", action={"x_dot": "3"}, name="kick")
    run = sb.simulate(eqs, 1.0, {"x": 1.0, "x_dot": 0.0}, events=kick)
    assert run.success
    assert abs(run["x_dot"][-1]) < 1e-12
    assert run["x"][-1] == pytest.approx(1.0, abs=1e-9)
    assert any("9 J are lost" in note for note in run.notes)
    assert run.energy_drift < 1e-9
