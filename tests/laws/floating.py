"""Mechanisms that hang on nothing: whatever acts, acts between their own bodies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.laws.drafts import coordinate_names
from tests.laws.parts import BodyPart, JointPart, Mechanism

BASE, FREE = "base", "afloat"


def floating(mechanism: Mechanism) -> Mechanism:
    """The mechanism with a body in place of ground, on a joint that holds nothing, and without gravity.

    Loads have their reaction on another body already, so momentum and angular momentum are kept.
    """

    def place(address: str) -> str:
        body, dot, frame = address.partition(".")
        return f"{BASE}{dot}{frame}" if body == "ground" else address

    units = mechanism.units
    tensor = units.mass * units.length**2 * np.diag([0.4, 0.5, 0.6])
    base = BodyPart(BASE, units.mass, tensor, dict(mechanism.ground))
    names = coordinate_names(FREE, "free", "quaternion", named=False)
    free = JointPart(
        FREE, "free", "ground", BASE, names, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), sequence="quaternion",
        speeds="end", named=False,
    )  # fmt: skip
    joints = [replace(part, start=place(part.start), end=place(part.end)) for part in mechanism.joints]
    springs = [replace(part, start=place(part.start), end=place(part.end)) for part in mechanism.springs]
    contacts = [replace(part, start=place(part.start), end=place(part.end)) for part in mechanism.contacts]
    loads = tuple(
        replace(
            load,
            on=place(load.on),
            resolved_in=place(load.resolved_in),
            reaction_on=place(load.reaction_on),
        )
        for load in mechanism.loads
    )
    return replace(
        mechanism,
        gravity=(0.0, 0.0, 0.0),
        ground={},
        bodies=(base, *mechanism.bodies),
        joints=(free, *joints),
        springs=tuple(springs),
        contacts=tuple(contacts),
        loads=loads,
    )
