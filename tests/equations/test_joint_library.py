"""Every joint: as branch, walked backwards and cut, the same motion, reactions and efforts; and closed forms."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice
from tests.laws.agreement import SYSTEM, acceleration_error, outcome, reaction_error
from tests.laws.balance import balance_errors, effort_outputs
from tests.laws.consistent_states import consistent_state
from tests.laws.drafts import Draft, coordinate_names
from tests.laws.draws import Draws
from tests.laws.evaluation import EPS, condition, equations, values_at
from tests.laws.joint_laws import FREEDOMS, LAYOUT, freedoms, letters
from tests.laws.parts import Mechanism, Units
from tests.laws.tally import BOUND
from tests.tiers import rows

# Joints beside revolute, prismatic, planar, spherical and free ones, which have tests of their own.
LIBRARY = tuple(
    kind for kind in LAYOUT if kind not in ("weld", "revolute", "prismatic", "planar", "spherical", "free")
)
ROWS = {"screw": 6}  # one more, because the angle of a cut screw joins the coordinates
ANGLES = "zyx"  # so that measured angles are the coordinates, not another triple of the same rotation
ONE_TREE = tuple(kind for kind in LIBRARY if kind not in ("screw", "telescoping"))


def two_bodies(
    kind: str, *, backwards: bool = False, driven: int | None = None, fixed: bool = False
) -> Mechanism:
    """A body on a spherical joint, and one on it by a joint with drives; one coordinate may be prescribed.

    `backwards`: the joint's end is nearer to ground. `fixed`: the motion is a constraint.
    """
    draws = Draws(random.Random(f"{kind} {backwards}"), Units())
    draft = Draft(draws, t=0.4)
    draft.add_body("spherical")
    first, last = draft.frame("B1"), ""
    draft.bodies.append(draws.body("B2"))
    last = draft.put("B2", draws.frame())
    joint = draft.joint(kind, *((last, first) if backwards else (first, last)))
    joint = replace(
        joint, motions={}, as_constraint=fixed, named=True, names=coordinate_names("J2", kind, ANGLES, True)
    )
    if joint.sequence:
        joint = replace(joint, sequence=ANGLES)
        angles = iter(draws.orientation(ANGLES))
        values = tuple(
            next(angles) if word == "o" else x for x, word in zip(joint.values, letters(joint), strict=True)
        )
        joint = replace(joint, values=values)
    if driven is not None:
        name = joint.names[driven]
        joint = replace(joint, motions={name: draws.motion(joint.values[driven], 1.0, draft.t)})
    drives = {name: draws.drive(1.0, 1.0, [("t", 1.0)]) for name in joint.names}
    draft.joints.append(replace(joint, drives=drives))
    ball = replace(draft.joints[0], drives={}, motions={})
    found = replace(draft.finished(), joints=(ball, draft.joints[1]), seed=7, gravity=(1.0, -2.0, -9.0))
    return found


def check_agreement(mechanism: Mechanism, choices: list[TreeChoice]) -> None:
    """Compare trees with each other, and each with Newton's and Euler's law."""
    state = consistent_state(mechanism)
    reference = equations(mechanism, "joints")
    first = outcome(mechanism, reference, state)
    efforts = list(effort_outputs(mechanism).values())
    names = [f"{name}{suffix}" for name in mechanism.joints[1].names for suffix in ("", "_dot", "_ddot")]
    wanted = [*SYSTEM, *efforts, *names]
    known = values_at(reference, state, wanted)
    for choice in choices:
        eqs = equations(mechanism, choice)
        other = outcome(mechanism, eqs, state)
        assert acceleration_error(mechanism, state, first, other) < BOUND
        error = reaction_error(mechanism, first, other)
        assert error is not None and error < BOUND
        assert max(balance_errors(mechanism, eqs, state).values()) < BOUND
        found = values_at(eqs, state, wanted)
        # Second rates of angles follow from accelerations by the inverse of matrices with entries above 0.3.
        scale = 10 * max(abs(float(known[name])) for name in [*names, *efforts]) + 10
        tolerance = BOUND * EPS * max(condition(found).number, condition(known).number) * scale
        for name in [*efforts, *names]:
            apart = float(found[name] - known[name])
            apart = math.remainder(apart, 2 * math.pi) if name in mechanism.joints[1].names else apart
            assert abs(apart) <= tolerance, (choice, name)


def cut(mechanism: Mechanism) -> list[TreeChoice]:
    """The second joint out of both trees, and where the law allows it out of one."""
    found: list[TreeChoice] = [sb.Trees(rotation=["J1"], translation=["J1"]), "absolute"]
    if mechanism.joints[1].kind in ONE_TREE:
        found += [sb.Trees(["J1", "J2"], ["J1"]), sb.Trees(["J1"], ["J1", "J2"])]
    return found


@pytest.mark.parametrize(  # one after the other: each joint in one direction
    ("kind", "backwards"),
    rows(product(LIBRARY, [False, True]), fast=[*zip(LIBRARY, [False, True] * len(LIBRARY), strict=False)]),
)
def test_branch_and_chord_agree(kind: str, backwards: bool) -> None:
    mechanism = two_bodies(kind, backwards=backwards)
    check_agreement(mechanism, cut(mechanism))


@pytest.mark.parametrize(
    "fixed",
    [False, pytest.param(True, marks=pytest.mark.exhaustive)],
    ids=["known", "as_constraint"],
)
@pytest.mark.parametrize(
    ("kind", "driven"),
    rows(
        [(kind, k) for kind in LIBRARY for k in range(FREEDOMS[kind]) if k in (0, FREEDOMS[kind] - 1)],
        fast=lambda kind, k: k == FREEDOMS[kind] - 1,
    ),
)
def test_prescribed_motions_agree(kind: str, driven: int, fixed: bool) -> None:
    mechanism = two_bodies(kind, driven=driven, fixed=fixed)
    check_agreement(mechanism, cut(mechanism)[:1])


@pytest.mark.parametrize("kind", LIBRARY)
def test_coordinates_and_rows_are_counted(kind: str) -> None:
    mechanism = two_bodies(kind)
    mechanism = replace(mechanism, joints=tuple(replace(joint, drives={}) for joint in mechanism.joints))
    n = FREEDOMS[kind]
    branch = equations(mechanism, "joints")
    assert len(branch.speed_names) == 3 + n and not branch.multiplier_names
    chord = equations(mechanism, sb.Trees(["J1"], ["J1"]))
    assert len(chord.multiplier_names) == ROWS.get(kind, 6 - n)
    assert chord.degrees_of_freedom == 3 + n
    joint = branch.model.joint("J2")
    assert (len(joint.coordinates), joint.locked_directions) == (n, 6 - n)


@pytest.mark.parametrize("kind", ["screw", "telescoping"])
def test_a_joint_whose_shift_turns_is_in_both_trees_or_in_neither(kind: str) -> None:
    mechanism = two_bodies(kind)
    for choice in (sb.Trees(["J1", "J2"], ["J1"]), sb.Trees(["J1"], ["J1", "J2"])):
        with pytest.raises(sb.TopologyError) as caught:
            equations(mechanism, choice)
        assert [(p.code, p.where) for p in caught.value.problems] == [("topology.mixed_joint", "joint J2")]


def test_the_angle_of_a_cut_screw_joins_the_coordinates_with_a_note() -> None:
    eqs = equations(two_bodies("screw"), sb.Trees(["J1"], ["J1"]))
    assert "cJ2" in eqs.coordinate_names
    assert any("joint J2: its displacement depends on cJ2" in note for note in eqs.notes)


@pytest.mark.parametrize("kind", LIBRARY)
def test_reactions_do_no_work(kind: str) -> None:
    """The power of the reaction in each motion of the joint, by NumPy's law, is zero."""
    mechanism = two_bodies(kind)
    reaction = values_at(equations(mechanism), consistent_state(mechanism), ["reaction J2"])["reaction J2"]
    w, v = freedoms(mechanism.joints[1])
    size = max(np.abs(reaction).max(), 1.0)
    # Three products of numbers below 10, in a reaction good to eps times a condition number below 1e4.
    assert np.abs(w.T @ reaction[3:] + v.T @ reaction[:3]).max() < 1e5 * EPS * size


# --- closed forms ---------------------------------------------------------------------------------------


def accelerations(joint: object, values: dict[str, float], **body: object) -> dict[str, float]:
    """The accelerations of a body on a joint, by name; in exact parameters of size one."""
    words = {"mass": 2, "inertia": (4, 3, 5), **body}
    model = sb.Model("m", [sb.Body("B", **words), joint], gravity=(0, 0, "-10"), inputs=["F", "T"])
    eqs = sb.form_equations(model)
    q = [values.get(name, 0.0) for name in eqs.coordinate_names]
    u = [values.get(name, 0.0) for name in eqs.speed_names]
    udot = sb.compile(eqs, "udot")(0.0, q, u, [values.get("F", 0.0), values.get("T", 0.0)])
    return dict(zip(eqs.acceleration_names, udot.tolist(), strict=True))


def near(x: float) -> object:
    # Some ten rounded operations.
    return pytest.approx(x, rel=50 * EPS, abs=50 * EPS)


def test_a_nut_on_a_thread_falls_slowly() -> None:
    pitch = 0.3
    found = accelerations(
        sb.Screw("j", "ground", "B", pitch, coordinate="a", torque=sb.Drive("T")), {"T": 0.0}
    )
    slope = 2 * math.pi / pitch
    fall = 10 / (1 + 5 * slope**2 / 2)
    assert found["a_ddot"] * pitch / (2 * math.pi) == near(-fall)
    held = accelerations(
        sb.Screw("j", "ground", "B", pitch, coordinate="a", torque=sb.Drive("T")),
        {"T": 20 * pitch / (2 * math.pi)},
    )
    assert abs(held["a_ddot"]) < 50 * EPS * 20  # the torque that carries the weight


def test_the_axial_reaction_of_a_screw_and_its_torque() -> None:
    """A nut held by its prescribed angle: the effort is weight times pitch by turn, the thread carries the weight."""
    screw = sb.Screw("j", "ground", "B", "p", coordinate="a", motion="w*t")
    model = sb.Model(
        "m",
        [sb.Body("B", mass=2, inertia=(4, 3, 5)), screw],
        gravity=(0, 0, -10),
        parameters={"p": 0.3, "w": 2},
    )
    eqs = sb.form_equations(model)
    f = sb.compile(eqs, ["reaction j", "effort j"])
    reaction, effort = f(0.7, [], [])
    carried = 20 * 0.3 / (2 * math.pi)
    assert float(effort) == near(carried)
    assert reaction == near([0, 0, 20, 0, 0, -carried])


def test_a_sleeve_turns_and_slides_apart() -> None:
    joint = sb.Cylindrical(
        "j", "ground", "B", coordinates=["a", "s"], force={"s": sb.Drive("F")}, torque={"a": sb.Drive("T")}
    )
    assert accelerations(joint, {"F": 3, "T": 4}) == {"a_ddot": near(4 / 5), "s_ddot": near(3 / 2 - 10)}


def test_a_pin_in_a_slot() -> None:
    joint = sb.PinSlot(
        "j", "ground", "B", coordinates=["a", "s"], force={"s": sb.Drive("F")}, torque={"a": sb.Drive("T")}
    )
    assert accelerations(joint, {"F": 3, "T": 4, "a_dot": 2}) == {
        "a_ddot": near(4 / 5),
        "s_ddot": near(3 / 2),
    }


def test_tables_slide_without_turning() -> None:
    table = sb.Rectangular("j", "ground", "B", axis="x", coordinates=["y", "z"], force={"y": sb.Drive("F")})
    assert accelerations(table, {"F": 3}) == {"y_ddot": near(1.5), "z_ddot": near(-10)}
    gantry = sb.Cartesian("j", "ground", "B", coordinates=["x", "y", "z"], force={"y": sb.Drive("F")})
    assert accelerations(gantry, {"F": 3}) == {"x_ddot": near(0), "y_ddot": near(1.5), "z_ddot": near(-10)}


def test_a_body_in_a_bearing_falls_along_it_and_turns_freely() -> None:
    joint = sb.Bearing("j", "ground", "B", coordinates=["s", "a", "b", "c"], torque={"a": sb.Drive("T")})
    found = accelerations(joint, {"T": 4, "s_dot": 1})
    assert found == {"s_ddot": near(-10), "a_ddot": near(4 / 4), "b_ddot": near(0), "c_ddot": near(0)}


def test_a_gimbal_near_its_lock_precesses() -> None:
    """Euler's equations with the spin about z: a torque-free symmetric rotor has constant angle rates."""
    joint = sb.Gimbal("j", "ground", "B", angles="zxz", coordinates=["a", "b", "c"])
    tilt, spin = 0.7, 3.0
    precession = 5 * spin / ((3 - 5) * math.cos(tilt))  # (A - C) a' cos b = C c'
    found = accelerations(joint, {"b": tilt, "a_dot": precession, "c_dot": spin}, inertia=(3, 3, 5))
    assert all(abs(x) < 50 * EPS * precession**2 for x in found.values())


def test_a_telescope_is_a_radius() -> None:
    """In polar coordinates: s'' = s a'^2 and (m s^2 + I) a'' = -2 m s s' a'."""
    joint = sb.Telescoping("j", "ground", "B", axis="x", angles="zyx", coordinates=["a", "b", "c", "s"])
    found = accelerations(joint, {"s": 1.5, "s_dot": 0.4, "a_dot": 2})
    assert found["s_ddot"] == near(1.5 * 4)
    assert found["a_ddot"] == near(-2 * 2 * 1.5 * 0.4 * 2 / (2 * 1.5**2 + 5))


def shafts(joint: object, bend: float) -> sb.EquationSet:
    """Two shafts in bearings that meet at an angle, joined in the middle."""
    tilted = sb.Frame(rotate=[("x", bend)])
    bodies = [sb.Body(name, mass=1, inertia=(1, 1, 1)) for name in ("A", "B")]
    hinges = [
        sb.Revolute("in", "ground", "A", coordinate="a"),
        sb.Revolute("out", "ground.tilted", "B", coordinate="c"),
    ]
    return sb.form_equations(sb.Model("shafts", [*bodies, *hinges, joint], ground={"tilted": tilted}))


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3, 2.9])
def test_a_universal_joint_turns_unevenly(angle: float) -> None:
    bend = 0.6
    eqs = shafts(sb.Universal("u", "A", "B", axes=["y", "x"], tree=False), bend)
    state = sb.assemble(eqs, fixed={"a": angle, "a_dot": 1.0}, guess={"c": angle})
    ratio = math.cos(bend) / (1 - math.sin(bend) ** 2 * math.cos(angle) ** 2)
    assert state["c_dot"] == pytest.approx(ratio, abs=1e-8)  # assembled to 1e-9 of its size


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.3, 2.9])
@pytest.mark.parametrize("bend", [0.0, 0.6, 1.4])
def test_a_constant_velocity_joint_turns_evenly(angle: float, bend: float) -> None:
    eqs = shafts(sb.ConstantVelocity("u", "A", "B", tree=False), bend)
    state = sb.assemble(eqs, fixed={"a": angle, "a_dot": 1.0}, guess={"c": angle + 0.3})
    assert state["c_dot"] == pytest.approx(1.0, abs=1e-8)
    assert math.remainder(state["c"] - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-8)


def test_shafts_in_line_carry_the_torque_across() -> None:
    """At zero bend, where the azimuth has no meaning, a cut joint still has its reaction."""
    eqs = shafts(sb.ConstantVelocity("u", "A", "B", tree=False), 0.0)
    reaction = sb.compile(eqs, "reaction u")(0.0, [0.2, 0.2], [1.0, 1.0])
    assert np.abs(reaction).max() < 50 * EPS


def test_angles_measured_in_fractions_of_a_turn_stay_within_a_half() -> None:
    joint = sb.Universal("u", "ground", "B", axes=[(1, 2, 2), (2, 1, -2)], coordinates=["a", "b"], tree=False)
    eqs = sb.form_equations(sb.Model("m", [sb.Body("B", mass=1, inertia=(1, 1, 1)), joint]))
    state = sb.assemble(eqs, fixed={"a": 2.5, "b": -2.0})
    assert (state["a"], state["b"]) == (pytest.approx(2.5, abs=1e-8), pytest.approx(-2.0, abs=1e-8))
