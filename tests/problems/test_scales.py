"""Mechanisms of a nanometre and of 1,000 km, against closed forms: the same digits as those of a metre."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from tests.tiers import cases

LENGTHS = (1e-9, 1.0, 1e6)
GRAVITY = 9.81
START = 1.0  # rad


def rod(length: float, tree: Any = "absolute") -> sb.EquationSet:
    """A uniform rod hung up at its end."""
    inertia = length**2 / 12
    body = sb.Body("Rod", 1, (inertia, 0, inertia), frames={"end": sb.Frame(at=(0, length / 2, 0))})
    pin = sb.Revolute("pin", "ground", "Rod.end", coordinate="theta")
    return sb.form_equations(sb.Model("rod", [body, pin], gravity=(0, -GRAVITY, 0)), tree=tree)


def swing(t: float, length: float) -> float:
    """The angle of the rod let go at START: ``sin(theta/2) = k sn(K(k) - w t, k)``, k = sin(START/2).

    A uniform rod about its end is a pendulum of w^2 = 3 g / (2 L).
    """
    k = np.sin(START / 2)
    sn = ellipj(ellipk(k**2) - np.sqrt(1.5 * GRAVITY / length) * t, k**2)[0]
    return float(2 * np.arcsin(k * sn))


@pytest.mark.parametrize("length", cases(LENGTHS, fast=[LENGTHS[0]]))
@pytest.mark.parametrize(
    ("options", "bound"),
    [
        # Each error is its integrator's at rtol = 1e-8, at 1 m as at any other length: the steps of Explicit and
        # Partition, 50, add 1e-8 each at most; those of the multistep methods, 500 and 1500, do, too.
        ({}, 5e-7),
        ({"constraints": sb.Partition()}, 5e-7),
        pytest.param({"integrator": sb.Stiff()}, 5e-6, marks=pytest.mark.exhaustive),
        ({"integrator": sb.Stiff(), "constraints": sb.GGL()}, 1.5e-5),
    ],
    ids=["projection", "partition", "stiff", "ggl"],
)
def test_a_rod_of_any_length_swings_the_same_way(
    length: float, options: dict[str, Any], bound: float
) -> None:
    end = 10 * float(np.sqrt(length / GRAVITY))
    run = sb.simulate(rod(length), end, {"theta": START}, **options)
    assert run.success
    assert run["theta"][-1] == pytest.approx(swing(end, length), abs=bound)
    # Said as a share of the length: IDA holds constraints to rtol, the others to 1e-10 or rounding.
    assert run.constraint_violation.max() < 1e-7


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("integrator", [None, sb.Stiff()], ids=["explicit", "stiff"])
def test_a_distance_is_a_length_of_the_mechanism(length: float, integrator: Any) -> None:
    # The rod is a constraint, and no frame has an offset. A point on it is a pendulum of w^2 = g / L, which is
    # the swing of a uniform rod of 3/2 that length.
    mass = sb.Cartesian("mass", "ground", sb.Body("Mass", 1), coordinates=("x", "y", "z"))
    link = sb.Distance("link", "ground", "Mass", value=length)
    eqs = sb.form_equations(sb.Model("pendulum", [mass, link], gravity=(0, -GRAVITY, 0)))
    guess = {"x": length * np.sin(START), "y": -length * np.cos(START)}
    end = 10 * float(np.sqrt(length / GRAVITY))
    run = sb.simulate(eqs, end, guess=guess, integrator=integrator)
    # As above; and closed to 1e-10, as it is said to be.
    assert run["x"][-1] / length == pytest.approx(np.sin(swing(end, 1.5 * length)), abs=5e-7)
    assert np.hypot(run["x"], run["y"]) / length == pytest.approx(1.0, abs=1e-10)
    assert run.constraint_violation.max() <= 1e-10


@pytest.mark.parametrize("depth", LENGTHS)
def test_an_equilibrium_takes_its_length_from_the_guess(depth: float) -> None:
    # A spring of force -m g (y / d)^3 carries the weight, which pulls along y, at y = d; its slope there, 3 m g / d, gives 1e-9 for
    # the balance of forces to 1e-9 a third of that in y / d.
    law = f"{-GRAVITY!r}*(y/{depth!r})^3"
    mass = sb.Prismatic(
        "mass", "ground", sb.Body("Mass", 1), axis="y", coordinate="y", force=sb.Drive(law=law)
    )
    eqs = sb.form_equations(sb.Model("hung", [mass], gravity=(0, GRAVITY, 0)))
    found = sb.find_equilibrium(eqs, {"y": 0.5 * depth})
    assert found["y"] / depth == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("amplitude", LENGTHS)
@pytest.mark.parametrize("tree", [None, "absolute"])
def test_an_oscillator_without_lengths_takes_that_of_its_start(amplitude: float, tree: Any) -> None:
    # m x'' = -k x from rest is a cos(w t); w = 2 rad/s and 10 s are 20 rad.
    spring = sb.Drive(stiffness=8)
    slider = sb.Prismatic("slider", "ground", sb.Body("Mass", 2), axis="x", coordinate="x", force=spring)
    run = sb.simulate(sb.form_equations(sb.Model("oscillator", [slider]), tree=tree), 10, {"x": amplitude})
    # 38 steps of rtol, of quantities that swing up to twice what a coordinate does (the speed).
    assert run["x"][-1] / amplitude == pytest.approx(np.cos(20.0), abs=38 * 2e-8)
    assert not run.notes


def test_without_any_length_a_note_names_the_cure() -> None:
    mass = sb.Body("Mass", 1)
    slider = sb.Prismatic("slider", "ground", mass, axis="y", coordinate="y", force=sb.Drive(stiffness="k"))
    # Let go where the spring is relaxed: y = -(m g / k) (1 - cos w t), with m g / k = 1 nm.
    stiffness = GRAVITY / 1e-9
    model = sb.Model("hung", [slider], gravity=(0, -GRAVITY, 0), parameters={"k": stiffness})
    eqs, end = sb.form_equations(model), 20 / float(np.sqrt(stiffness))
    assert any('scales={"length"' in note for note in sb.simulate(eqs, end).notes)
    run = sb.simulate(eqs, end, scales={"length": 1e-9})
    assert run["y"][-1] == pytest.approx(-1e-9 * (1 - np.cos(20.0)), rel=1e-6)
    assert not run.notes


@pytest.mark.parametrize("length", LENGTHS)
def test_tolerances_are_shares_of_sizes_unless_they_are_given(length: float) -> None:
    # 1e-10 of the length (half of it is the frame's offset) or 1 rad, and of that over sqrt(length / g).
    eqs = rod(length)
    known, at_rest = mechanism_scales(eqs, {}).fit_span(2.0, 1e5), np.zeros(len(eqs.state_names))
    found = dict(zip(eqs.state_names, known.tolerances(eqs, at_rest), strict=True))
    time = np.sqrt(length / 2 / GRAVITY)
    expected = {"m": length / 2, "m/s": length / 2 / time, "rad/s": 1 / time}
    for name, value in found.items():
        assert value == pytest.approx(1e-10 * expected.get(eqs.units.get(name, ""), 1.0), rel=1e-12), name
    assert (known.tolerances(eqs, at_rest, 0.25) == 0.25).all()


@pytest.mark.parametrize("length", LENGTHS)
def test_a_rod_between_walls_rests_at_the_same_angle(length: float) -> None:
    # Both ends of a uniform rod of length 2 a slide, one on a wall and one on the floor; a spring of stiffness
    # k = m g / a pulls the lower end to the corner. With s the angle from the floor the energy is
    # m g a sin s + k (2 a cos s)^2 / 2, whose slope m g a (cos s - 4 sin s cos s) is 0 at sin s = 1/4 (cos s = 0
    # is the rod upright).
    a = length / 2
    inertia = length**2 / 12
    frames = {"up": sb.Frame(at=(0, a, 0)), "down": sb.Frame(at=(0, -a, 0))}
    body = sb.Body("Rod", 1, (inertia, 0, inertia), frames=frames)
    elements = [
        body,
        sb.Planar("plane", "ground", "Rod", coordinates=("x", "y", "angle")),
        sb.PointOnPlane("wall", "ground", "Rod.up", axis="x"),
        sb.PointOnPlane("floor", "ground", "Rod.down", axis="y"),
        sb.SpringDamper("spring", "ground", "Rod.down", stiffness=GRAVITY / a),
    ]
    eqs = sb.form_equations(sb.Model("rod", elements, gravity=(0, -GRAVITY, 0)))
    # Upright at angle 0; leant by c to the wall the lower end is at x = 2 a sin c, so that s = pi/2 - c.
    lean = 1.2
    guess = {"x": a * np.sin(lean), "y": a * np.cos(lean), "angle": lean}
    found = sb.find_equilibrium(eqs, guess)
    assert np.cos(found["angle"]) == pytest.approx(0.25, abs=1e-9)
    assert found.q["y"] / length == pytest.approx(0.125, abs=1e-9)


@pytest.mark.parametrize(
    ("scales", "word"),
    [({"lenght": 1.0}, "length"), ({"length": 0.0}, "positive"), ({"time": float("nan")}, "positive")],
)
def test_scales_that_make_no_sense_are_refused(scales: dict[str, float], word: str) -> None:
    with pytest.raises(sb.UsageError, match=word):
        sb.simulate(rod(1.0), 1.0, scales=scales)


def rails(length: float) -> sb.EquationSet:
    """Two carts on crossing rails, held at one distance by an equation: it has no unit, so there is no length."""
    carts = [sb.Body("A", 1), sb.Body("B", 2)]
    parts = [
        sb.Prismatic("along", "ground", "A", axis="x", coordinate="x", force=sb.Drive("F", stiffness=1)),
        sb.Prismatic("across", "ground", "B", axis="y", coordinate="y"),
        sb.Constraint("apart", "x^2 + y^2 - L^2"),
    ]
    return sb.form_equations(sb.Model("rails", [*carts, *parts], parameters={"L": length}, inputs=["F"]))


@pytest.mark.parametrize("length", LENGTHS)
def test_kinematics_and_inverse_dynamics_take_lengths_from_what_is_led(length: float) -> None:
    """With y' = -x x'/y and d'Alembert's principle, F = x'' + x - 2 y'' x/y for 1 kg, 2 kg and 1 N/m."""
    eqs = rails(length)
    t = np.linspace(0.0, 1.0, 5)
    run = sb.inverse_dynamics(eqs, {"x": "L*(0.1 + 0.5*sin(t))"}, "F", t, guess={"y": 0.9 * length})
    x, v, a = 0.1 + 0.5 * np.sin(t), 0.5 * np.cos(t), -0.5 * np.sin(t)
    y = np.sqrt(1 - x**2)
    bend = -(v**2 + x * a + (x * v / y) ** 2) / y
    np.testing.assert_allclose(run["y"] / length, y, rtol=1e-12)
    np.testing.assert_allclose(run["F"] / length, a + x - 2 * bend * x / y, rtol=1e-9)

    path = sb.trace_positions(eqs, {"x": length * np.array([0.1, 0.5, 0.9, 1.1])}, {"y": 0.9 * length})
    assert path.limits["x"] == pytest.approx(length, rel=1e-9)
    places = sb.singular_configurations(eqs, "x", {"y": (-0.9 * length, 0.5 * length)}, guess={"x": length})
    assert sorted(one.q["x"] / length for one in places) == pytest.approx([-1, 1])
    guess = {"x": 0.6 * length, "y": 0.8 * length}
    assert sb.velocity_ratios(eqs, "x", sb.assemble(eqs, guess=guess)).dependent == ("y_dot",)
    assert sb.redundancy(eqs, guess=guess).degrees_of_freedom == 1


def test_lengths_that_follow_from_nothing_can_be_given() -> None:
    """The first place led to is 0, and the other coordinate is to be found: nothing has a length but `scales`."""
    length, places = 1e-9, [0.0, 3e-10]
    eqs = rails(length)
    found = sb.trace_positions(eqs, {"x": places}, scales={"length": length})
    np.testing.assert_allclose(np.abs(found["y"]), np.sqrt(length**2 - np.square(places)), rtol=1e-9)
    with pytest.raises(sb.UsageError, match="is not a positive number"):
        sb.inverse_dynamics(eqs, {"x": "0"}, "F", [0.0], scales={"length": 0.0})


def test_ratios_and_freedoms_count_by_the_length_given() -> None:
    """A cart 1 km away on a rail of its own is no measure for two carts that are held a nanometre apart."""
    length = 1e-9
    rail = sb.Prismatic("aside", "ground", sb.Body("C", 1), axis="z", coordinate="z")
    pair = rails(length).model
    eqs = sb.form_equations(sb.Model("rails", [*pair.elements, rail], parameters={"L": length}, inputs=["F"]))
    scales = {"length": length}
    guess = {"x": 0.6 * length, "y": 0.8 * length, "z": 1e3}
    state = sb.assemble(eqs, guess=guess, scales=scales)
    assert sb.redundancy(eqs, guess=guess, scales=scales).degrees_of_freedom == 2
    ratios = sb.velocity_ratios(eqs, ["x", "z"], state, scales=scales)
    assert ratios.dependent == ("y_dot",)
    np.testing.assert_allclose(ratios.at(state), [[-0.75, 0.0]], rtol=1e-9)


def test_what_counts_as_rest_follows_the_length_given() -> None:
    """An oscillator that passes 0 at 1 nm/s moves, if a nanometre is large; beside a metre it is at rest."""
    part = sb.Prismatic(
        "slide", "ground", sb.Body("A", 1), axis="x", coordinate="x", force=sb.Drive(stiffness=1)
    )
    eqs = sb.form_equations(sb.Model("oscillator", [part]))
    at = {"x": 0.0, "x_dot": 1e-9}
    assert not sb.linearize(eqs, at, scales={"length": 1e-9}).is_stationary
    assert sb.linearize(eqs, at, scales={"length": 1.0}).is_stationary
