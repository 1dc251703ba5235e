"""The content of a model as its file has it: parts that are included are taken out again."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace

from symbody.expr.language.formula import Formula
from symbody.model.body import Body
from symbody.model.element import Element
from symbody.model.frame import Frame
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.model.parts.expansion import PartContent, part_content
from symbody.model.parts.include import Include
from symbody.model.shapes.shape import BodyShape


@dataclass(frozen=True, slots=True)
class OwnContent:
    """The content of a model without the parts that it includes."""

    elements: tuple[Element, ...]
    parameters: Mapping[str, Formula | None]
    inputs: tuple[str, ...]
    initial: Mapping[str, Formula]
    ground: Mapping[str, Frame]
    ground_shapes: tuple[BodyShape, ...]
    includes: tuple[Include, ...]
    held_initial: tuple[str, ...]


def whole_content(model: Model) -> OwnContent:
    """Return all that a model consists of, its parts among it."""
    return OwnContent(
        model.elements, model.parameters, model.inputs, model.initial, model.ground, model.ground_shapes, (),
        model.held_initial,
    )  # fmt: skip


def own_content(model: Model) -> OwnContent:
    """Return the content of a model's file: parts from files that are unchanged stay includes."""
    own = whole_content(model)
    names = [element.name for element in model.elements]
    for include in reversed(model.includes):
        content = part_content(include, model.bodies, model.ground, names, [])
        if include.file and content is not None and _is_unchanged(own, content, {*include.share}):
            own = _remove_part(own, content, include)
    return own


def _is_unchanged(own: OwnContent, content: PartContent, shared: AbstractSet[str]) -> bool:
    holds = all(element in own.elements for element in content.elements)
    holds &= all(
        own.parameters.get(name) == value for name, value in content.parameters.items() if name not in shared
    )
    return holds and all(own.initial.get(name) is not None for name in content.initial)


def _remove_part(whole: OwnContent, content: PartContent, include: Include) -> OwnContent:
    at, shared = content.at.body, {*include.share}
    elements = [
        _remove_frames(element, content) if isinstance(element, Body) and element.name == at else element
        for element in whole.elements
        if element not in content.elements
    ]
    ground = {
        name: frame for name, frame in whole.ground.items() if at != GROUND or name not in content.frames
    }
    count = len(content.shapes) if at == GROUND else 0
    shapes = whole.ground_shapes[: len(whole.ground_shapes) - count]

    def is_same(name: str) -> bool:
        priorities = (name in content.initial.held, name in whole.held_initial)
        return content.initial.get(name) == whole.initial[name] and priorities[0] == priorities[1]

    gone = {name for name in content.parameters if name not in shared}
    return OwnContent(
        tuple(elements),
        {name: value for name, value in whole.parameters.items() if name not in gone},
        tuple(name for name in whole.inputs if name not in content.inputs or name in shared),
        {name: value for name, value in whole.initial.items() if not is_same(name)},
        ground,
        shapes,
        (include, *whole.includes),
        tuple(name for name in whole.held_initial if not is_same(name)),
    )


def _remove_frames(body: Body, content: PartContent) -> Body:
    frames = {name: frame for name, frame in body.frames.items() if name not in content.frames}
    count = len(body.shapes) - len(content.shapes)
    return replace(body, frames=FrozenMapping(frames), shapes=body.shapes[:count])
