"""Poses and motions of a random mechanism by NumPy alone: places, twists, what loops and motions demand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.laws.contact_laws import contact_rows, row_values, slopes
from tests.laws.joint_laws import FREEDOMS, freedoms, rotation, shift
from tests.laws.parts import ContactPart, CouplingPart, JointPart, Mechanism
from tests.laws.rotations import Array, skew

Places = dict[str, tuple[Array, Array]]


def frame_place(mechanism: Mechanism, places: Places, address: str) -> tuple[Array, Array]:
    """Origin and axes of a frame in ground."""
    body, frame = mechanism.frame(address)
    r, a = places[body]
    return r + a @ np.array(frame.at), a @ frame.matrix


def body_places(mechanism: Mechanism) -> Places:
    """Centre of mass and axes of every body, along the joints that are not closing."""
    places: Places = {"ground": (np.zeros(3), np.eye(3)), **mechanism.placed}
    for joint in mechanism.joints:
        if joint.closing:
            continue
        near, far = (joint.start, joint.end)
        if near.partition(".")[0] in places:
            r, a = _across(mechanism, places, joint)
        else:
            near, far = far, near
            r, a = _back_across(mechanism, places, joint)
        body, frame = mechanism.frame(far)
        axes = a @ frame.matrix.T
        places[body] = (r - axes @ np.array(frame.at), axes)
    return places


def _across(mechanism: Mechanism, places: Places, joint: JointPart) -> tuple[Array, Array]:
    r, a = frame_place(mechanism, places, joint.start)
    return r + a @ shift(joint), a @ rotation(joint)


def _back_across(mechanism: Mechanism, places: Places, joint: JointPart) -> tuple[Array, Array]:
    r, a = frame_place(mechanism, places, joint.end)
    axes = a @ rotation(joint).T
    return r - axes @ shift(joint), axes


@dataclass(frozen=True, slots=True, eq=False)
class Freedoms:
    """All freedoms of the joints that are not closing, and of free bodies, as columns.

    Attributes
    ----------
    columns : mapping of joint or free body to slice
    spins, slides : mapping of body to (3, n)
        Angular velocity and velocity of the centre of mass, in ground axes.
    known : mapping of column to joint and coordinate
        Columns whose rate is prescribed.
    """

    size: int
    columns: dict[str, slice]
    spins: dict[str, Array]
    slides: dict[str, Array]
    known: dict[int, tuple[JointPart, str]]


def all_freedoms(mechanism: Mechanism, places: Places) -> Freedoms:
    """The freedoms of a mechanism at its pose."""
    columns, at = {}, 0
    known = {}
    for joint in (joint for joint in mechanism.joints if not joint.closing):
        columns[joint.name] = slice(at, at + FREEDOMS[joint.kind])
        for k, name in enumerate(joint.names):
            if name in joint.motions:
                known[at + k] = (joint, name)
        at += FREEDOMS[joint.kind]
    for body in mechanism.placed:
        columns[body] = slice(at, at + 6)
        at += 6
    zero = np.zeros((3, at))
    found = Freedoms(at, columns, {"ground": zero}, {"ground": zero}, known)
    for body in mechanism.placed:
        found.slides[body], found.spins[body] = zero.copy(), zero.copy()
        found.slides[body][:, columns[body]] = np.eye(3, 6)
        found.spins[body][:, columns[body]] = np.eye(3, 6, 3)
    for joint in (joint for joint in mechanism.joints if not joint.closing):
        _add_joint(mechanism, places, joint, found)
    return found


def _add_joint(mechanism: Mechanism, places: Places, joint: JointPart, found: Freedoms) -> None:
    start, end = joint.start.partition(".")[0], joint.end.partition(".")[0]
    (r_s, a_s), (r_e, _) = (frame_place(mechanism, places, address) for address in (joint.start, joint.end))
    own = np.zeros((2, 3, found.size))
    own[0][:, found.columns[joint.name]], own[1][:, found.columns[joint.name]] = (
        a_s @ part for part in freedoms(joint)
    )
    forward = start in found.spins
    near, far, sign = (start, end, 1) if forward else (end, start, -1)
    spin = found.spins[near] + sign * own[0]
    # The arm from start to end is carried by the start body, whose spin is that of the near or the far one.
    carrier = found.spins[near] if forward else spin
    near_point = found.slides[near] - skew((r_s if forward else r_e) - places[near][0]) @ found.spins[near]
    far_point = near_point + sign * (-skew(r_e - r_s) @ carrier + own[1])
    found.spins[far] = spin
    found.slides[far] = far_point + skew((r_e if forward else r_s) - places[far][0]) @ spin


def relative_motion(
    mechanism: Mechanism, places: Places, motion: Freedoms, joint: JointPart | ContactPart
) -> Array:
    """(6, n): angular velocity, then rate of the shift, of end relative to start, in start axes."""
    start, end = joint.start.partition(".")[0], joint.end.partition(".")[0]
    (r_s, a_s), (r_e, _) = (frame_place(mechanism, places, address) for address in (joint.start, joint.end))
    v_s = motion.slides[start] - skew(r_s - places[start][0]) @ motion.spins[start]
    v_e = motion.slides[end] - skew(r_e - places[end][0]) @ motion.spins[end]
    v = v_e - v_s + skew(r_e - r_s) @ motion.spins[start]
    return np.vstack([a_s.T @ (motion.spins[end] - motion.spins[start]), a_s.T @ v])


def locked_rows(joint: JointPart, length: float) -> tuple[Array, Array]:
    """(6 - f, 6) rows that a relative motion must fulfil, and their values for prescribed coordinates.

    Lengths are divided by `length`; the second is a (6, k) basis of the prescribed directions.
    """
    scale = np.array([1, 1, 1, 1 / length, 1 / length, 1 / length])
    own = np.vstack(freedoms(joint)) * scale[:, None]
    driven = [k for k, name in enumerate(joint.names) if name in joint.motions]
    free = np.delete(own, driven, axis=1)
    if free.shape[1]:
        u, _, _ = np.linalg.svd(free)
        rows = u[:, free.shape[1] :].T
    else:
        rows = np.eye(6)
    return rows * scale, (own / scale[:, None])[:, driven]


@dataclass(frozen=True, slots=True, eq=False)
class Demands:
    """What closing joints and constraints demand of the freedoms: ``rows s = values``; lengths are divided by the unit."""

    rows: Array
    values: Array


def demands(mechanism: Mechanism, places: Places, motion: Freedoms) -> Demands:
    """The rows of all closing joints, motions and constraints."""
    rows, values = [np.zeros((0, motion.size))], [np.zeros(0)]
    for joint in (joint for joint in mechanism.joints if joint.closing):
        locked, driven = locked_rows(joint, mechanism.units.length)
        rates = np.array(
            [m.rate(mechanism.t) for m in (joint.motions[n] for n in joint.names if n in joint.motions)]
        )
        rows.append(locked @ relative_motion(mechanism, places, motion, joint))
        values.append(locked @ driven @ rates)
    for contact in mechanism.contacts:
        own, rate = _contact_demand(mechanism, places, motion, contact)
        rows.append(own)
        values.append(rate)
    for coupling in mechanism.couplings:
        own, rate = _coupling_demand(mechanism, places, motion, coupling)
        rows.append(own)
        values.append(rate)
    return Demands(np.vstack(rows), np.concatenate(values))


def relative_place(mechanism: Mechanism, places: Places, part: ContactPart) -> tuple[Array, Array]:
    """Position and axes of end, in start axes."""
    (r_s, a_s), (r_e, a_e) = (frame_place(mechanism, places, address) for address in (part.start, part.end))
    return a_s.T @ (r_e - r_s), a_s.T @ a_e


def _contact_demand(
    mechanism: Mechanism, places: Places, motion: Freedoms, contact: ContactPart
) -> tuple[Array, Array]:
    local = contact_rows(contact, *relative_place(mechanism, places, contact))
    # Rows on velocities are divided by the unit of length; those on directions and of surfaces have none.
    turning = contact.kind in ("parallel", "perpendicular", "angle", "surface")
    length = 1.0 if turning else mechanism.units.length
    rows = local @ relative_motion(mechanism, places, motion, contact)
    return rows / length, row_values(contact, mechanism.t) / length


def _coupling_demand(
    mechanism: Mechanism, places: Places, motion: Freedoms, coupling: CouplingPart
) -> tuple[Array, Array]:
    known = {name: x for joint in mechanism.joints for name, x in zip(joint.names, joint.values, strict=True)}
    row = np.zeros(motion.size)
    for name, slope in slopes(coupling, known).items():
        joint = next(joint for joint in mechanism.joints if name in joint.names)
        rates = coordinate_rates(mechanism, places, motion, joint)
        row += slope * rates[joint.names.index(name)]
    length = mechanism.units.length if coupling.kind in ("rack", "belt") else 1.0
    time = mechanism.t
    value = coupling.offset.at(time) if coupling.along else coupling.offset.rate(time)
    return row[None, :] / length, np.array([value / length])


def coordinate_rates(mechanism: Mechanism, places: Places, motion: Freedoms, joint: JointPart) -> Array:
    """(f, n): the freedoms of any joint, closing or not, by the freedoms of the mechanism."""
    scale = np.array([1.0] * 3 + [1 / mechanism.units.length] * 3)[:, None]
    relative = relative_motion(mechanism, places, motion, joint)
    found: Array = np.linalg.pinv(np.vstack(freedoms(joint)) * scale) @ (relative * scale)
    return found


def freedom_scales(mechanism: Mechanism, motion: Freedoms) -> Array:
    """The unit of each freedom: 1 for angles, the unit of length for displacements."""
    scales = np.ones(motion.size)
    for joint in (joint for joint in mechanism.joints if not joint.closing):
        w, _ = freedoms(joint)
        scales[motion.columns[joint.name]] = np.where(w.any(axis=0), 1.0, mechanism.units.length)
    for body in mechanism.placed:
        scales[motion.columns[body]] = [mechanism.units.length] * 3 + [1.0] * 3
    return scales
