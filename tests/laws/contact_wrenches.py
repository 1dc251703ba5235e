"""What constraints do: wrenches on the two bodies of a contact, efforts along coupled coordinates."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import symbody as sb
from tests.laws.consistent_states import State
from tests.laws.contact_laws import contact_arm, contact_rows, heading, slopes
from tests.laws.motion import frame_place, relative_place
from tests.laws.parts import ContactPart, Mechanism
from tests.laws.rotations import Array, unit


def contact_outputs(mechanism: Mechanism) -> list[str]:
    """Reactions of contacts, the frames of those that roll, and the multipliers of couplings."""
    found = [f"reaction {contact.name}" for contact in mechanism.contacts]
    for contact in mechanism.contacts:
        if contact.rolls:
            found += [f"frame R {contact.name} ground", f"frame r {contact.name} ground ground"]
    return found + (["lambda"] if mechanism.couplings else [])


def wrench_on_end(
    mechanism: Mechanism, state: State, contact: ContactPart, found: Mapping[str, Array]
) -> tuple[Array, Array]:
    """Force and moment about end's origin, in ground axes."""
    place, axes = frame_place(mechanism, state.places, contact.start)
    reaction = found[f"reaction {contact.name}"]
    arm = np.zeros(3)
    if contact.rolls:
        relative = relative_place(mechanism, state.places, contact)[1]
        arm = axes @ contact_arm(contact, relative)
        # Where forward is for a ball is a choice, fixed in start.
        axes = (
            found[f"frame R {contact.name} ground"]
            if contact.kind == "sphere"
            else axes @ heading(contact, relative)
        )
    force = axes @ reaction[:3]
    return force, axes @ reaction[3:] + np.cross(arm, force)


def contact_errors(
    mechanism: Mechanism, state: State, contact: ContactPart, found: Mapping[str, Array]
) -> dict[str, float]:
    """How far a wrench does work on admissible motions, and a contact frame is off, relative to their sizes.

    A wrench without power on all twists that the rows allow is a combination of the rows.
    """
    length = mechanism.units.length
    r, relative = relative_place(mechanism, state.places, contact)
    place, axes = frame_place(mechanism, state.places, contact.start)
    force, moment = (axes.T @ part for part in wrench_on_end(mechanism, state, contact, found))
    rows = contact_rows(contact, r, relative) / np.array([length] * 3 + [1.0] * 3)
    wrench = np.concatenate([moment / length, force])
    rest = wrench - rows.T @ np.linalg.lstsq(rows.T, wrench, rcond=None)[0]
    least = max(body.mass for body in mechanism.bodies) * mechanism.units.acceleration
    errors = {f"power of {contact.name}": float(np.abs(rest).max() / max(np.abs(wrench).max(), least))}
    if contact.rolls:
        point = place + axes @ (r + contact_arm(contact, relative))
        frame = found[f"frame R {contact.name} ground"]
        off = (
            np.abs(frame @ frame.T - np.eye(3)).max() + np.abs(frame[:, 2] - axes @ unit(contact.axis)).max()
        )
        if contact.kind == "disc":
            off += np.abs(frame - axes @ heading(contact, relative)).max()
        off += np.abs(found[f"frame r {contact.name} ground ground"] - point).max() / length
        errors[f"contact frame of {contact.name}"] = float(off)
    return errors


def coupled_efforts(
    mechanism: Mechanism, eqs: sb.EquationSet, state: State, found: Mapping[str, Array]
) -> dict[str, float]:
    """The efforts along coordinates that the multipliers of couplings mean."""
    efforts: dict[str, float] = {}
    for coupling in mechanism.couplings:
        multiplier = float(found["lambda"][eqs.multiplier_names.index(f"lambda_{coupling.name}_1")])
        for name, slope in slopes(coupling, state.known).items():
            efforts[name] = efforts.get(name, 0.0) + multiplier * slope
    return efforts
