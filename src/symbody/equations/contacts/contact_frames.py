"""Frames in points of contact: of what rolls, and of what touches."""

from __future__ import annotations

from collections.abc import Iterable

from symbody.equations.constraints.rolling import rolling_frame
from symbody.equations.contacts.contact_geometry import at_least_gap
from symbody.equations.contacts.pairs import contact_geometry
from symbody.equations.kinematics.frame_steps import RotationStep, TranslationStep
from symbody.equations.kinematics.motion import Kinematics, add_frames
from symbody.equations.kinematics.naming import Names
from symbody.model.constraints import Rolling
from symbody.model.contacts.contact import Contact
from symbody.model.element import Element
from symbody.spatial.matrix import matrix3
from symbody.spatial.rotation import DirectionCosines
from symbody.spatial.vector import Vector, components, cross, dot, vector


def add_contact_frames(names: Names, kinematics: Kinematics, elements: Iterable[Element]) -> Kinematics:
    """Return the kinematics with a frame for each contact; its velocities are computed when read.

    It is called like the element. Its origin is the point of contact, z the normal.
    """
    steps = []
    for element in elements:
        if isinstance(element, Rolling):
            steps.append(rolling_frame(names, kinematics, element))
        elif isinstance(element, Contact):
            steps.append(_touching_frame(names, kinematics, element))
    if not steps:
        return kinematics
    return add_frames(kinematics, [step for step, _ in steps], [step for _, step in steps], lazy=True)


def _touching_frame(
    names: Names, kinematics: Kinematics, contact: Contact
) -> tuple[RotationStep, TranslationStep]:
    """Return the steps to the frame where the gap is least, in the middle between the surfaces.

    With axes ``a_k`` the angular velocity relative to start is ``sum_k (a_i' . a_j) a_k``, i, j, k cyclic.
    """
    tree, start = kinematics.tree, contact.start.full_name
    geometry = contact_geometry(names, kinematics, contact)
    forward, normal = geometry.forward, geometry.normal
    left = cross(tree, normal, forward)
    axes = (forward, left, normal)
    cosines = DirectionCosines(matrix3(*(components(tree, axis, start) for axis in axes)).T)
    x, y, z = (components(tree, axis, start) for axis in axes)
    in_start = [vector(tree.orientation_frame(start), axis) for axis in (x, y, z)]
    rates = [axis.map(kinematics.rate) for axis in in_start]
    turning = Vector({})
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turning = turning + axes[k] * dot(tree, rates[i], in_start[j])
    places = [components(tree, touch.point, start) for touch in geometry.touches]
    first, second, third = (
        at_least_gap(geometry.touches, tuple(place[k] for place in places)) for k in range(3)
    )
    at = vector(tree.orientation_frame(start), (first, second, third))
    return (
        RotationStep(contact.name, start, (cosines,), turning),
        TranslationStep(contact.name, start, start, geometry.touches[0].point if len(places) == 1 else at),
    )
