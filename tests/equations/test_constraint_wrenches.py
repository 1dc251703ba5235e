"""What constraints do to bodies: Newton's and Euler's laws with "reaction c", efforts, power, contact frames."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.model.constraint import ConstraintElement
from tests.tiers import cases

EPS = float(np.finfo(float).eps)
GRAVITY = np.array([0.3, -9.0, 1.0])
A = sb.Body("A", mass=2, inertia=(1, 2, 2.5), frames={"P": sb.Frame(at=(0.4, 0, 0.3), rotate=[("x", "0.4")])})
B = sb.Body(
    "B", mass=1, inertia=(1, 1.5, 2), frames={"Q": sb.Frame(at=(0, -0.3, 0.7), rotate=[("y", "0.3")])}
)
ENDS = ("A.P", "B.Q")
TREES = [None, pytest.param("absolute", marks=pytest.mark.exhaustive)]
CONTACTS = [
    sb.Distance("c", *ENDS, value="2 + sin(t)"),
    sb.PointOnLine("c", *ENDS, axis=(1, 2, -1)),
    sb.PointOnPlane("c", *ENDS, axis=(1, 2, -1)),
    sb.PointOnCurve("c", *ENDS, curve=["s", "s^2/2 + t", "cos(s)"], parameter="s"),
    sb.PointOnSurface("c", *ENDS, ["x^2/2 + y^2 - sin(z) - t - 1", "z - x*y"]),
    sb.Parallel("c", *ENDS, axes=["y", (1, 2, -1)]),
    sb.Perpendicular("c", *ENDS, axes=["y", "x"]),
    sb.Angle("c", *ENDS, axes=["z", "x"], value="1 + t/3"),
    sb.KnifeEdge("c", *ENDS, axis=(1, 2, -1)),
    sb.Rolling("c", *ENDS, radius=0.6),
    sb.Rolling("c", *ENDS, radius=0.6, normal=(1, 2, -1), axis="y"),
]


@pytest.mark.parametrize("tree", TREES)
@pytest.mark.parametrize(
    "contact",
    cases(CONTACTS, fast=[CONTACTS[k] for k in (1, 3, 4, 7, 9)]),
    ids=[f"{type(c).__name__}-{k}" for k, c in enumerate(CONTACTS)],
)
def test_both_bodies_obey_newton_and_euler(contact: ConstraintElement, tree: str | None) -> None:
    joints = [sb.Free("fa", "ground", "A", angles="xyz"), sb.Free("fb", "ground", "B", angles="zxz")]
    eqs = sb.form_equations(sb.Model("m", [A, B, *joints, contact], gravity=GRAVITY.tolist()), tree=tree)
    random = np.random.default_rng(5)
    names = (*eqs.coordinate_names, *eqs.speed_names)
    state = sb.assemble(eqs, {}, dict(zip(names, random.uniform(0.3, 1.2, len(names)), strict=True)), t=0.2)

    def seen(kind: str, frame: str) -> np.ndarray:
        return np.asarray(state[f"frame {kind} {frame} ground" + " ground" * (kind != "R")])

    axes = seen("R", "c" if isinstance(contact, sb.Rolling) else "A.P")
    force, moment = axes @ state["reaction c"][:3], axes @ state["reaction c"][3:]
    point = seen("r", "c" if isinstance(contact, sb.Rolling) else "B.Q")
    size = np.abs([*force, *moment]).max()
    assert size > 1e-2
    for body, sign in ((A, -1), (B, 1)):
        mass = float(body.mass.constant())
        r, spin = seen("R", body.name), seen("w", body.name)
        tensor = r @ np.diag([float(x.constant()) for x in body.inertia]) @ r.T
        inertial = mass * (seen("vdot", body.name) - GRAVITY)
        turning = tensor @ seen("wdot", body.name) + np.cross(spin, tensor @ spin)
        arm = point - seen("r", body.name)
        # Some hundred operations on numbers up to `size`; masses and inertias are within a factor of ten.
        bound = 1e4 * EPS * max(size, 10.0)
        np.testing.assert_allclose(inertial, sign * force, atol=bound)
        np.testing.assert_allclose(turning, sign * (moment + np.cross(arm, force)), atol=bound)
    if isinstance(contact, sb.Rolling):
        # Multipliers along normal, forward, left, in the point of contact, which moves with wheel and plane.
        normal, forward, left = state["lambda"][
            [eqs.multiplier_names.index(f"lambda_c_{k}") for k in (1, 2, 3)]
        ]
        np.testing.assert_allclose(
            state["reaction c"], [forward, left, normal, 0, 0, 0], atol=1e3 * EPS * size
        )


WHEELS = [sb.Body(f"W{k}", inertia=(0, 0, k), mass=1) for k in (1, 2, 3)]


def wheels(condition: ConstraintElement, motion: str | None, tree: str | None) -> sb.EquationSet:
    joints = [
        sb.Revolute(
            f"r{k}", "ground", f"W{k}", coordinate=f"a{k}",
            torque=sb.Drive(applied=0.7 * k, damping=0.1), motion=motion if k == 1 else None,
        )
        for k in (1, 2, 3)
    ]  # fmt: skip
    return sb.form_equations(sb.Model("wheels", [*WHEELS, *joints, condition]), tree=tree)


@pytest.mark.parametrize("tree", TREES)
@pytest.mark.parametrize("motion", [None, "sin(2*t)"])
@pytest.mark.parametrize(
    "condition",
    [
        sb.Gear("c", ["a1", "a2"], 2, offset="sin(2*t)"),
        sb.Constraint("c", "a1*a2 - a3 + t^2"),
        sb.Constraint("c", "a1_dot*a2 - a3_dot*2 - a2_dot + t^2"),
    ],
    ids=["gear", "equation", "rates"],
)
def test_power_of_couplings_that_time_moves(
    condition: ConstraintElement, motion: str | None, tree: str | None
) -> None:
    run = sb.simulate(wheels(condition, motion, tree), 1.0, rtol=1e-9, atol=1e-11)
    assert run.success and np.ptp(run["energy"]) > 0.1
    # Some thirty steps of 1e-9 on energies of order one.
    assert np.ptp(run["energy"] - run["work"]) < 1e-7


@pytest.mark.parametrize("tree", [None, "absolute"])
def test_effort_of_a_prescribed_wheel_holds_the_gear(tree: str | None) -> None:
    eqs = wheels(sb.Gear("c", ["a1", "a2"], 2), "sin(2*t)", tree)
    state = sb.assemble(eqs, t=0.3)
    # 2 a2'' = 1.4 - 0.1 a2' - 2 lambda, I1 a1'' = effort + lambda
    second = -4 * np.sin(0.6)
    pull = (1.4 - 0.1 * np.cos(0.6) - second) / 2
    found = state["lambda"][eqs.multiplier_names.index("lambda_c_1")]
    assert found == pytest.approx(pull, rel=1e-12)
    assert float(state["effort r1"]) == pytest.approx(second - pull, rel=1e-12)


MOVING = [
    sb.Distance("c", "A.P", "B.Q", "1 + 0.3*sin(t)"),
    sb.PointOnCurve("c", "A.P", "B.Q", ["s", "s^2 + sin(t)", "s*t"], "s"),
    sb.PointOnSurface("c", "A.P", "B.Q", "y - x^2 - z^2 - sin(t)"),
    sb.Angle("c", "A.P", "B.Q", ["x", "y"], "1 + t/3"),
    sb.Rolling("c", "A.P", "B.Q", 0.4, axis="x"),
]


@pytest.mark.parametrize("contact", MOVING, ids=lambda c: type(c).__name__)
def test_power_of_contacts_on_a_driven_body(contact: ConstraintElement) -> None:
    parts = [
        A, B, sb.Revolute("ra", "ground", "A", coordinate="a", motion="sin(2*t)"),
        sb.Free("fb", "ground", "B", angles="xyz"), contact,
    ]  # fmt: skip
    eqs = sb.form_equations(sb.Model("driven", parts, gravity=GRAVITY.tolist()))
    run = sb.simulate(eqs, 0.5, guess={"fb_x": 1.5, "fb_y": 0.3}, rtol=1e-9, atol=1e-11)
    assert run.success
    # Some fifty steps of 1e-9 on energies of order ten.
    assert np.ptp(run["energy"] - run["work"]) < 1e-6 < np.ptp(run["energy"])


def test_the_contact_frame_moves_as_its_outputs_say() -> None:
    mass, radius = 1.3, 0.4
    disc = sb.Body("Disc", mass=mass, inertia=[mass * radius**2 * k for k in (0.25, 0.25, 0.5)])
    free = sb.Free("free", "ground", "Disc", angles="313", coordinates=["x", "y", "z", "psi", "theta", "phi"])
    rolling = sb.Rolling("road", "ground", "Disc", radius=radius, axis="z")
    eqs = sb.form_equations(sb.Model("disc", [disc, free, rolling], gravity=[0, 0, -9.81]))
    start = {"psi": 0.4, "theta": 1.2, "phi": 0.0, "psi_dot": 1.0, "theta_dot": 0.3, "phi_dot": 4.0}
    step, t = 1e-4, 0.3
    times = np.array([0.0, t - step, t, t + step])
    run = sb.simulate(
        eqs, 0.4, {**start, "x": 0, "y": 0}, guess={"z": 0.37}, times=times, rtol=1e-12, atol=1e-13
    )

    def seen(kind: str) -> np.ndarray:
        found = run[f"frame {kind} road ground" + " ground" * (kind != "R")]
        return np.moveaxis(found, -1, 0)[1:]

    # Errors of differences: step^2/6 times third derivatives, which are below 1e4.
    bound = {"rtol": 0, "atol": 1e4 * step**2 / 6}
    r, v, w, rotation = (seen(kind) for kind in ("r", "v", "w", "R"))
    np.testing.assert_allclose((r[2] - r[0]) / (2 * step), v[1], **bound)
    np.testing.assert_allclose((v[2] - v[0]) / (2 * step), seen("vdot")[1], **bound)
    np.testing.assert_allclose((w[2] - w[0]) / (2 * step), seen("wdot")[1], **bound)
    spin = (rotation[2] - rotation[0]) / (2 * step) @ rotation[1].T
    np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], w[1], **bound)
    # The point of the rim is at rest there, the point of contact is not; both are on the road.
    np.testing.assert_allclose(r[:, 2], 0.0, atol=1e-10)
    assert np.abs(v[1][:2]).max() > 0.1
    # Forward is along the line of nodes, with the axle tilted by theta from the normal.
    psi = run["psi"][1:]
    forward = np.column_stack([np.cos(psi), np.sin(psi), 0 * psi])
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", rotation[:, :, 0], forward)), 1.0, atol=1e-12)
