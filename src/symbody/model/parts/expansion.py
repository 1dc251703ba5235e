"""Parts put into a model, under their new names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import TypeVar

from symbody.errors import Problem
from symbody.expr.language.formula import Formula
from symbody.expr.language.tokens import is_name
from symbody.model.body import Body
from symbody.model.checks.validation import Draft
from symbody.model.element import Element, FrameRef
from symbody.model.first_values import FirstValues
from symbody.model.frame import Frame
from symbody.model.frame_index import frame_index
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.naming import GROUND
from symbody.model.output_arguments import name_beginnings
from symbody.model.parts.include import Include
from symbody.model.parts.placing import place_frame, place_shape
from symbody.model.parts.renaming import Renaming
from symbody.model.shapes.shape import BodyShape
from symbody.model.signals.signal import Signal

V = TypeVar("V")


@dataclass(frozen=True, slots=True)
class PartContent:
    """What a part brings into a model.

    Attributes
    ----------
    parameters, inputs, initial
        Those that the model gets; of shared ones the model's own come first.
    frames, shapes
        On the body that is the ground of the part.
    """

    elements: tuple[Element, ...]
    parameters: Mapping[str, Formula | None]
    inputs: tuple[str, ...]
    initial: FirstValues
    at: FrameRef
    frames: Mapping[str, Frame]
    shapes: tuple[BodyShape, ...]


def add_parts(draft: Draft, includes: Iterable[Include], problems: list[Problem]) -> Draft:
    """Return the parts of a model with what is included; faults are added to `problems`."""
    placed: list[tuple[Include, AbstractSet[str]]] = []
    includes = tuple(includes)
    taken = {element.name for element in draft.elements}
    taken |= {f"{each.prefix}_{element.name}" for each in includes for element in each.part.elements}
    for include in includes:
        content = part_content(include, draft.bodies, draft.ground, taken, problems)
        if content is None:
            continue
        clashes = _clashes(draft, content, include)
        problems += clashes
        if clashes:
            continue
        draft = replace(
            draft,
            elements=(*_with_frames(draft.elements, content), *content.elements),
            parameters=_extend_values(draft.parameters, content.parameters),
            inputs=tuple(dict.fromkeys((*draft.inputs, *content.inputs))),
            initial=_extend_initial(draft.initial, content.initial),
            ground=_ground_frames(draft, content),
            ground_shapes=(*draft.ground_shapes, *(content.shapes if content.at.body == GROUND else ())),
        )
        if content.at != FrameRef(GROUND):
            placed.append((include, {f"{include.prefix}_{joint.name}" for joint in include.part.free_joints}))
    problems += _free_bodies(draft, placed)
    return draft


def _free_bodies(draft: Draft, placed: Iterable[tuple[Include, AbstractSet[str]]]) -> list[Problem]:
    """Return a problem for each body without a joint whose part stands elsewhere than on the ground."""
    index = frame_index(draft.bodies, draft.ground)
    ends = [index.find(address) for joint in draft.joints for address in (joint.start, joint.end)]
    joined = {end.body for end in ends if isinstance(end, FrameRef)}
    return [
        Problem("include.free", f"include {include.prefix}, at",
                f"{name} has no joint: its coordinates would start at the ground of the whole model",
                f"the ground of the part is at {include.at.full_name}",
                'give the body a joint in the part, [[joint]] type = "free", between = ["ground", ..], '
                "or a joint in the whole model")
        for include, names in placed for name in sorted(names - joined)
    ]  # fmt: skip


def _extend_values(values: Mapping[str, V], further: Mapping[str, V]) -> FrozenMapping[V]:
    """Return values with further ones behind them; those that stand there already stay."""
    return FrozenMapping({**values, **{name: value for name, value in further.items() if name not in values}})


def _extend_initial(values: FirstValues, further: FirstValues) -> FirstValues:
    """Return first values with further ones behind them; those that stand there already stay."""
    held = [name for name in further.held if name not in values]
    return FirstValues(_extend_values(values, further), (*values.held, *held))


def part_content(
    include: Include,
    bodies: Sequence[Body],
    ground: Mapping[str, Frame],
    taken: Iterable[str],
    problems: list[Problem],
) -> PartContent | None:
    """Return what a part brings, under its new names; None, with a fault, where it has no place.

    Parameters
    ----------
    taken : iterable of str
        The elements of the whole, those of its parts among them.
    """
    part, label = include.part, f"include {include.prefix}"
    at = frame_index(bodies, ground).find(include.at)
    if not isinstance(at, FrameRef):
        problems.append(Problem("model.unknown_place", f"{label}, at", at[0], "", at[1]))
        return None
    renaming = _make_renaming(include, at, frozenset(taken))
    base = _frame_of(at, bodies, ground)
    elements = [element.rename(renaming) for element in part.elements]
    new = {renaming.symbol(name): formula for name, formula in part.parameters.items()}
    parameters = {name: None if value is None else renaming.formula(value) for name, value in new.items()}
    parameters |= {renaming.symbol(name): value for name, value in include.parameters.items()}
    open_inputs = [name for name in part.inputs if name not in include.connect]
    frames: dict[str, Frame] = {}
    try:
        for name, frame in part.ground.items():
            frames[renaming.element_name(name)] = place_frame(base, frame.rename(renaming))
        shapes = [place_shape(base, shape.rename(renaming)) for shape in part.ground_shapes]
    except NotImplementedError as error:
        what = f"the ground of the part is at {at.full_name}, which is rotated by {error}"
        fix = "rotate this frame about x, y and z, one after the other"
        problems.append(Problem("include.ground", f"{label}, at", what, "", fix))
        return None
    signals = [
        Signal(renaming.symbol(name), formula)
        for name, formula in include.connect.items()
        if name in part.inputs and not is_name(formula.text)
    ]
    return PartContent(
        (*elements, *signals),
        parameters,
        tuple(renaming.symbol(name) for name in open_inputs),
        FirstValues(
            {renaming.symbol(name): renaming.formula(value) for name, value in part.initial.items()},
            map(renaming.symbol, part.held_initial),
        ),
        at,
        frames,
        tuple(shapes),
    )


def _make_renaming(include: Include, at: FrameRef, taken: frozenset[str]) -> Renaming:
    part = include.part
    joints = (*part.joints, *part.free_joints)
    speeds = [name for joint in joints for name in joint.quasi_speed_names]
    coordinates = [*part.coordinates, *(name for joint in part.free_joints for name in joint.coordinates)]
    constant = [*part.parameters, *part.inputs, *(table.name for table in part.tables)]
    moving = [*coordinates, *speeds, *(signal.name for signal in (*part.signals, *part.held_signals))]
    symbols = {name: f"{include.prefix}_{name}" for name in (*constant, *moving)}
    symbols |= {name: name for name in include.share}
    symbols |= {name: outer.text for name, outer in include.connect.items() if is_name(outer.text)}
    rates = {f"{name}{suffix}": f"{symbols[name]}{suffix}" for name in moving for suffix in ("_dot", "_ddot")}
    return Renaming(include.prefix, rates | symbols, part.output_scope, at, name_beginnings(taken))


def _frame_of(at: FrameRef, bodies: Iterable[Body], ground: Mapping[str, Frame]) -> Frame:
    frames = {GROUND: ground, **{body.name: body.frames for body in bodies}}[at.body]
    return frames[at.frame] if at.frame else Frame()


def _clashes(draft: Draft, content: PartContent, include: Include) -> list[Problem]:
    """Return a problem for each name of a part that the model has already."""
    here = {element.name for element in draft.elements}
    names = [element.name for element in content.elements if element.name in here]
    shared = {*include.share}
    symbols = [name for name in content.parameters if name in draft.parameters and name not in shared]
    symbols += [name for name in content.inputs if name in draft.inputs and name not in shared]
    return [
        Problem("include.collision", f"include {include.prefix}",
                f"{name!r} is a name in the part {include.part.name!r} and also in the model",
                "names of a part consist of its prefix and the names in its file", "choose another prefix")
        for name in (*names, *symbols)
    ]  # fmt: skip


def _with_frames(elements: Sequence[Element], content: PartContent) -> list[Element]:
    """Return elements, the body that is the ground of a part with the frames and shapes of that ground."""
    if not content.frames and not content.shapes:
        return list(elements)
    return [
        replace(
            element,
            frames=FrozenMapping({**element.frames, **content.frames}),
            shapes=(*element.shapes, *content.shapes),
        )
        if isinstance(element, Body) and element.name == content.at.body
        else element
        for element in elements
    ]


def _ground_frames(draft: Draft, content: PartContent) -> FrozenMapping[Frame]:
    added = content.frames if content.at.body == GROUND else {}
    return FrozenMapping({**draft.ground, **added})
