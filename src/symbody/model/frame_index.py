"""Which frame each address of a model means."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from symbody.errors import Problem, nearest
from symbody.model.body import Body
from symbody.model.element import Element, FrameRef
from symbody.model.frame import Frame
from symbody.model.naming import CENTRE, GROUND


def frame_refs(element: Element) -> dict[str, FrameRef]:
    """Return the addresses an element holds, by field name."""
    values = ((name, getattr(element, name)) for name in element.fields)
    return {name: value for name, value in values if isinstance(value, FrameRef)}


@dataclass(frozen=True, slots=True)
class FrameIndex:
    """All frames of a model.

    Attributes
    ----------
    frames : mapping of body name to names of its frames
        Ground included.
    """

    frames: Mapping[str, frozenset[str]]

    def find(self, address: FrameRef) -> FrameRef | tuple[str, str]:
        """Return the address with its body, or what is wrong with it and the cure."""
        if address.body in self.frames:
            known = self.frames[address.body]
            if not address.frame or address.frame in known:
                return FrameRef(address.body, address.frame)
            is_ground = address.body == GROUND
            cure = nearest(address.frame, known if is_ground else [*known, CENTRE])
            if is_ground:
                cure += f" Or define it: [ground.frames] {address.frame} = {{ at = [..] }}"
            return f"{address.body} has no frame {address.frame!r}", cure
        if address.frame:
            return f"there is no body {address.body!r}", nearest(address.body, self.frames)
        return self._find_alone(address.body)

    def _find_alone(self, word: str) -> FrameRef | tuple[str, str]:
        homes = [body for body, names in self.frames.items() if word in names]
        if len(homes) == 1:
            return FrameRef(homes[0], word)
        if homes:
            choices = " or ".join(f"{body}.{word}" for body in homes[:5])
            return f"several bodies have a frame {word!r}", f"write {choices}"
        points = [f"{body}.{name}" for body, names in self.frames.items() for name in sorted(names)]
        return f"there is no body or frame {word!r}", nearest(word, [*self.frames, *points])


def frame_index(bodies: Iterable[Body], ground: Mapping[str, Frame]) -> FrameIndex:
    """Return the frames of a model."""
    found = {GROUND: frozenset(ground)}
    for body in bodies:  # of two with one name, which is told elsewhere, both are searched
        found[body.name] = found.get(body.name, frozenset()) | frozenset(body.frames)
    return FrameIndex(found)


def include_bodies(elements: Iterable[Element]) -> list[Element]:
    """Return the elements, each preceded by the bodies it carries, bodies met again left out."""
    listed = list(elements)
    known: dict[str, list[Element]] = {}
    for element in listed:
        if isinstance(element, Body):
            known.setdefault(element.name, []).append(element)
    result: list[Element] = []
    for element in listed:
        for address in frame_refs(element).values():
            body = address.body_object
            if body is not None and body not in known.setdefault(body.name, []):
                known[body.name].append(body)
                result.append(body)
        result.append(element)
    return result


def resolve_frames(
    elements: Iterable[Element], places: FrameIndex, labels: Mapping[int, str]
) -> tuple[list[Element], list[Problem]]:
    """Return the elements with every address looked up, and the addresses that mean nothing."""
    result: list[Element] = []
    problems: list[Problem] = []
    for k, element in enumerate(elements):
        found: dict[str, FrameRef] = {}
        for name, address in frame_refs(element).items():
            place = places.find(address)
            if isinstance(place, FrameRef):
                found[name] = place
            else:
                what, fix = place
                where = f"{labels[k]}, {element.fields[name].place or name}"
                problems.append(Problem("model.unknown_place", where, what, "", fix))
        changes: dict[str, Any] = dict(found)
        result.append(replace(element, **changes) if found else element)
    return result, problems


def element_labels(elements: Iterable[Element]) -> dict[int, str]:
    """Return a unique label of each element by its place; equal names are told apart by that place."""
    plain = [f"{element.kind} {element.name}" for element in elements]
    count = Counter(plain)
    return {k: label if count[label] == 1 else f"{label} (element {k + 1})" for k, label in enumerate(plain)}
