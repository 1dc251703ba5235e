"""Motions past positions where three angles do not determine a rotation."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.model.joint import Joint

TOP = sb.Body("Top", mass=1, inertia=(1, 1.2, 1.5))


def motion(angles: str, second: float, rate: float) -> sb.Trajectory:
    names = ["a", "b", "c"] if angles != "quaternion" else ["a", "b", "c", "d"]
    pivot = sb.Spherical("pivot", "ground", TOP, angles=angles, coordinates=names)
    eqs = sb.form_equations(sb.Model("top", [pivot]))
    if angles == "quaternion":
        return sb.simulate(eqs, 1.5, initial={"pivot_wx": rate})
    return sb.simulate(eqs, 1.5, initial={"a": 0.3, "b": second, "c": 0.1, "b_dot": rate})


@pytest.mark.parametrize(("angles", "second"), [("313", 0.5), ("space 313", 0.5), ("xyz", np.pi / 2 - 0.5)])
def test_a_passage_is_an_event_with_advice(angles: str, second: float) -> None:
    run = motion(angles, second, -1.0 if angles != "xyz" else 1.0)
    assert run.success
    passages = [event for event in run.events if event.name == "pivot singular angles"]
    assert len(passages) == 1
    # The body turns almost evenly: inertias differ by a fifth, and the passage is after half a radian.
    assert passages[0].t == pytest.approx(0.5, abs=0.05)
    notes = [note for note in run.notes if note.startswith("joint pivot: at t = ")]
    assert len(notes) == 1 and "b passes" in notes[0] and "quaternion" in notes[0]


def test_motions_far_from_it_and_quaternions_say_nothing() -> None:
    for run in (motion("313", 1.5, 0.3), motion("quaternion", 0.0, 3.0)):
        assert run.success and not run.events
        assert not any("singular" in note or "passes" in note for note in run.notes)


JOINTS: list[Joint] = [
    sb.Free("pivot", "ground", TOP, "123", coordinates=["x", "y", "z", "a", "b", "c"]),
    sb.Gimbal("pivot", "ground", TOP, coordinates=["a", "b", "c"]),
    sb.Bearing("pivot", "ground", TOP, coordinates=["s", "a", "b", "c"]),
    sb.Telescoping("pivot", "ground", TOP, coordinates=["a", "b", "c", "s"]),
]


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: type(joint).__name__)
def test_every_joint_with_three_angles_tells_it(joint: Joint) -> None:
    start = {"a": 0.3, "b": np.pi / 2 - 0.5, "c": 0.1, "b_dot": 1.0}
    run = sb.simulate(sb.form_equations(sb.Model("top", [joint])), 1.0, start)
    (passage,) = run.events
    assert run.success and passage.name == "pivot singular angles"
    assert passage.t == pytest.approx(0.5, abs=0.05)
    (note,) = [note for note in run.notes if note.startswith("joint pivot: at t = ")]
    # A joint that cannot have a quaternion is told to take another sequence.
    assert ("quaternion" if isinstance(joint, sb.Free) else "another sequence of angles") in note
