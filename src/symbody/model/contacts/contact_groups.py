"""Groups of contacts: one for each pair of places that addresses with ``*`` fit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from itertools import product

from symbody.errors import Problem, nearest
from symbody.model.body import Body
from symbody.model.contacts.contact import Contact
from symbody.model.element import Element, FrameRef
from symbody.model.frame import Frame
from symbody.model.naming import GROUND

_ANY = "*"


def expand_groups(
    elements: Iterable[Element], ground: Mapping[str, Frame], problems: list[Problem], notes: list[str]
) -> tuple[Element, ...]:
    """Return the elements, a contact of each pair of places in the stead of a group.

    A pair of two bodies is taken once; no body touches itself. Each contact is called like the group and the
    places that its pattern fits. Groups that fit no pair go to `problems`, what the others are to `notes`.
    """
    listed = tuple(elements)
    frames = {GROUND: tuple(ground)}
    frames |= {body.name: tuple(body.frames) for body in listed if isinstance(body, Body)}
    expanded: list[Element] = []
    for element in listed:
        if not isinstance(element, Contact) or not _is_group(element, frames):
            expanded.append(element)
            continue
        members = _members(element, frames)
        expanded += members
        if members:
            names = ", ".join(member.name for member in members)
            notes.append(f"contact {element.name} stands for {len(members)} contacts: {names}")
        else:
            what = f"{element.start} and {element.end} fit no two bodies"
            why = "* stands for any letters in the name of a body, or of a frame behind its dot"
            fix = nearest(element.start.body.replace(_ANY, ""), frames)
            problems.append(Problem("contact.group", f"contact {element.name}, between", what, why, fix))
    return tuple(expanded)


def _is_group(contact: Contact, frames: Mapping[str, tuple[str, ...]]) -> bool:
    return any(
        _ANY in place.full_name and (place.body not in frames or _ANY in place.frame)
        for place in (contact.start, contact.end)
    )


def _members(group: Contact, frames: Mapping[str, tuple[str, ...]]) -> list[Contact]:
    sides = [_fitting_places(place, frames) for place in (group.start, group.end)]
    pairs: dict[frozenset[FrameRef], tuple[FrameRef, FrameRef]] = {}
    for first, second in product(*sides):
        if first.body != second.body:
            pairs.setdefault(frozenset((first, second)), (first, second))
    members = []
    for pair in pairs.values():
        words = [
            place.full_name.replace(".", "_")
            for place, pattern in zip(pair, (group.start, group.end), strict=True)
            if _ANY in pattern.full_name
        ]
        members.append(replace(group, name="_".join((group.name, *words)), start=pair[0], end=pair[1]))
    return members


def _fitting_places(pattern: FrameRef, frames: Mapping[str, tuple[str, ...]]) -> list[FrameRef]:
    """Return the places that an address fits; one without ``*`` is looked up later, as it is."""
    if _ANY not in pattern.full_name:
        return [pattern]
    return [
        FrameRef(body, frame)
        for body, own in frames.items()
        if fnmatchcase(body, pattern.body)
        for frame in ([name for name in own if fnmatchcase(name, pattern.frame)] if pattern.frame else [""])
        if body != GROUND or frame
    ]
