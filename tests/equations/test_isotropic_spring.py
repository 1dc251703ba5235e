"""A spring and damper in all directions alike: vector law, energy, and what it may not have."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.formats.native import model_from_toml, model_to_toml


def plane(spring: sb.SpringDamper, *elements: object, **values: float) -> sb.EquationSet:
    """A point of 2 kg in a plane, tied to a post."""
    parts = [
        sb.Body("A", mass=2, inertia=(1, 1, 1), frames={"eye": sb.Frame(at=(0.3, 0, 0))}),
        sb.Planar("J", "ground", "A", coordinates=["x", "y", "th"]),
        spring,
        *elements,
    ]
    post = {"post": sb.Frame(at=(0, 0, 0))}
    return sb.form_equations(sb.Model("plane", parts, parameters={"k": 8, "c": 4, **values}, ground=post))


def test_all_directions_are_damped_also_at_length_0() -> None:
    """m r'' = -k r - c r' in x and y alike: critical damping, r = v t exp(-2 t) from r = 0."""
    eqs = plane(sb.SpringDamper("S", "ground.post", "A", stiffness="k", damping="2*c", isotropic=True))
    run = sb.simulate(eqs, 2, {"x_dot": 0.3, "y_dot": -0.4}, rtol=1e-10)
    decay = run.t * np.exp(-2 * run.t)
    np.testing.assert_allclose(run["x"], 0.3 * decay, atol=1e-9)
    np.testing.assert_allclose(run["y"], -0.4 * decay, atol=1e-9)
    np.testing.assert_allclose(run["length S"], 0.5 * decay, atol=1e-9)
    assert abs(run.energy_drift) < 1e-9 and np.isfinite(run["effort S"]).all()
    # A turn of the body about its own centre does nothing; across the line it is damped.
    circling = sb.simulate(eqs, 0.1, {"x": 1.0, "y_dot": 1.0, "th_dot": 5.0})
    np.testing.assert_allclose(circling["th_dot"], 5.0)
    assert circling["y_ddot"][0] == pytest.approx(-4.0)


def test_it_is_two_forces_written_by_hand() -> None:
    """Between two moving points: -k r - c v on end, the opposite on start, v in ground axes."""
    second = [
        sb.Body("B", mass=3, inertia=(2, 2, 2), frames={"eye": sb.Frame(at=(0, -0.4, 0.1))}),
        sb.Spherical("K", "ground.post", "B.eye", "123"),
    ]
    names = ("A.eye", "B")
    signals = []
    for axis in "xyz":
        for kind in ("r", "v"):
            for end, place in (("e", names[1]), ("s", names[0])):
                signals.append(
                    sb.Signal(f"{kind}{end}{axis}", output=f"frame {kind} {place} ground ground {axis}")
                )
    force = [f"-k*(re{axis} - rs{axis}) - c*(ve{axis} - vs{axis})" for axis in "xyz"]
    pair = [
        sb.Force("on_end", names[1], vector=force),
        sb.Force("on_start", names[0], vector=[f"-({entry})" for entry in force]),
    ]
    idle = sb.SpringDamper("S", *names)
    made = plane(sb.SpringDamper("S", *names, stiffness="k", damping="c", isotropic=True), *second)
    written = plane(idle, *second, *signals, *pair)
    start = {
        "x": 0.5,
        "y": 0.2,
        "th": 0.3,
        "x_dot": 1.0,
        "th_dot": -2.0,
        "K_1": 0.4,
        "K_2": 0.2,
        "K_1_dot": 1.5,
    }
    runs = [sb.simulate(eqs, 0.5, start, times=[0, 0.25, 0.5], rtol=1e-11) for eqs in (made, written)]
    np.testing.assert_allclose(runs[0].u, runs[1].u, atol=1e-8)
    assert abs(runs[0].energy_drift) < 1e-8
    assert (np.diff(runs[0].energy) < 0).all()  # gravity is 0: what the damper takes never comes back


@pytest.mark.parametrize("formulation", [sb.VirtualWork(), sb.NewtonEuler(), sb.Lagrange(), sb.Recursive()])
def test_formulations_agree(formulation: object) -> None:
    spring = sb.SpringDamper("S", "ground.post", "A.eye", stiffness="k", damping="c", isotropic=True)
    model = plane(spring).model
    values = sb.compile(sb.form_equations(model, formulation), "udot")(0.0, [0.4, 0.1, 0.7], [1.0, -2.0, 3.0])
    usual = sb.compile(sb.form_equations(model), "udot")(0.0, [0.4, 0.1, 0.7], [1.0, -2.0, 3.0])
    np.testing.assert_allclose(values, usual, rtol=1e-12)
    # by hand: eye = (x + 0.3 cos, y + 0.3 sin), F = -k r - c v, th'' = (0.3 e) x F / I
    e = np.array([np.cos(0.7), np.sin(0.7)])
    r, v = np.array([0.4, 0.1]) + 0.3 * e, np.array([1.0, -2.0]) + 0.9 * np.array([-e[1], e[0]])
    F = -8 * r - 4 * v
    np.testing.assert_allclose(values, [*(F / 2), 0.3 * (e[0] * F[1] - e[1] * F[0])], rtol=1e-12)


def test_a_stiffness_that_changes_counts_as_work() -> None:
    spring = sb.SpringDamper("S", "ground.post", "A", stiffness="k + t", damping="c", isotropic=True)
    run = sb.simulate(plane(spring), 1, {"x": 0.5, "y_dot": 1.0}, rtol=1e-10)
    assert abs(run.energy_drift) < 1e-9 and run["potential_energy"][0] == 0.0


def test_files_and_units() -> None:
    spring = sb.SpringDamper("S", "ground.post", "A", stiffness="k", damping="c", isotropic=True)
    eqs = plane(spring)
    text = model_to_toml(eqs.model)
    assert "isotropic = true" in text and model_from_toml(text) == eqs.model
    assert eqs.units["length S"] == "m" and eqs.units["effort S"] == "N"
    assert "isotropic" not in model_to_toml(plane(sb.SpringDamper("S", "ground.post", "A")).model)


@pytest.mark.parametrize(
    "more", [{"free": 1}, {"applied": "k"}, {"law": "length"}, {"law": sb.Curve([0, 1], [0, 2])}]
)
def test_it_has_no_line_for_other_laws(more: dict[str, object]) -> None:
    with pytest.raises(sb.ModelError, match="an isotropic spring has no") as caught:
        sb.SpringDamper("S", "ground", "A", stiffness=1, isotropic=True, **more)
    assert caught.value.problems[0].code == "model.isotropic"
