"""Motions past positions where three angles do not determine a rotation."""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb

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
