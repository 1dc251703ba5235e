"""Parts put into a model, under their new names; and taken out again, as a file has the model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from symbody.errors import ExpressionError, Problem
from symbody.expr.language.formula import Formula
from symbody.expr.language.tokens import is_name
from symbody.model.body import Body
from symbody.model.checks.validation import Draft
from symbody.model.declarations.arguments import ZERO
from symbody.model.declarations.formula_site import Triple
from symbody.model.element import Element, FrameRef, make_frame_ref
from symbody.model.first_values import FirstValues
from symbody.model.frame import Frame
from symbody.model.frame_index import frame_index
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.naming import GROUND, RESERVED_SYMBOLS
from symbody.model.output_arguments import OutputScope, join_words, name_beginnings
from symbody.model.output_names import (
    DERIVATIVE_GROUPS,
    MULTIPLIER,
    DerivativeRequest,
    is_multiplier,
    kind_of,
    parse_derivative,
    read_output,
    rename_output,
)
from symbody.model.parts.include import Include
from symbody.model.shapes.shape import BodyShape
from symbody.model.signals.signal import Signal

if TYPE_CHECKING:
    from symbody.model.model import Model

V = TypeVar("V")


class PlacedPart(NamedTuple):
    """What a part brings into a model; frames and shapes of its ground go to the body that this is at."""

    content: Draft
    at: FrameRef


def add_parts(draft: Draft, includes: Iterable[Include], problems: list[Problem]) -> Draft:
    """Return the parts of a model with what is included; faults are added to `problems`."""
    placed: list[tuple[Include, AbstractSet[str]]] = []
    includes = tuple(includes)
    taken = {element.name for element in draft.elements}
    taken |= {f"{each.prefix}_{element.name}" for each in includes for element in each.part.elements}
    for include in includes:
        placed_part = place_part(include, draft, taken, problems)
        if placed_part is None:
            continue
        content, at = placed_part
        clashes = _clashes(draft, content, include)
        problems += clashes
        if clashes:
            continue
        held = [name for name in content.initial.held if name not in draft.initial]
        draft = replace(
            draft,
            elements=(*_with_frames(draft.elements, placed_part), *content.elements),
            parameters=_extend_values(draft.parameters, content.parameters),
            inputs=tuple(dict.fromkeys((*draft.inputs, *content.inputs))),
            initial=FirstValues(_extend_values(draft.initial, content.initial), (*draft.initial.held, *held)),
        )
        if at.body == GROUND:
            shapes = (*draft.ground_shapes, *content.ground_shapes)
            draft = replace(
                draft, ground=FrozenMapping({**draft.ground, **content.ground}), ground_shapes=shapes
            )
        if at != FrameRef(GROUND):
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


def place_part(
    include: Include, whole: Draft, taken: Iterable[str], problems: list[Problem]
) -> PlacedPart | None:
    """Return what a part brings, under its new names; None, with a fault, where it has no place.

    Parameters
    ----------
    taken : iterable of str
        The elements of the whole, those of its parts among them.
    """
    part, label = include.part, f"include {include.prefix}"
    at = frame_index(whole.bodies, whole.ground).find(include.at)
    if not isinstance(at, FrameRef):
        problems.append(Problem("model.unknown_place", f"{label}, at", at[0], "", at[1]))
        return None
    renaming = _make_renaming(include, at, frozenset(taken))
    frames = {GROUND: whole.ground, **{body.name: body.frames for body in whole.bodies}}[at.body]
    base = frames[at.frame] if at.frame else Frame()
    elements = [element.rename(renaming) for element in part.elements]
    new = {renaming.symbol(name): formula for name, formula in part.parameters.items()}
    parameters = {name: None if value is None else renaming.formula(value) for name, value in new.items()}
    parameters |= {renaming.symbol(name): value for name, value in include.parameters.items()}
    open_inputs = [name for name in part.inputs if name not in include.connect]
    try:
        ground = {
            renaming.element_name(name): place_on(base, frame.rename(renaming))
            for name, frame in part.ground.items()
        }
        shapes = [place_on(base, shape.rename(renaming)) for shape in part.ground_shapes]
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
    initial = {renaming.symbol(name): renaming.formula(value) for name, value in part.initial.items()}
    content = Draft(
        (*elements, *signals), part.gravity, FrozenMapping(parameters),
        tuple(renaming.symbol(name) for name in open_inputs),
        FirstValues(initial, map(renaming.symbol, part.held_initial)), FrozenMapping(ground), tuple(shapes),
    )  # fmt: skip
    return PlacedPart(content, at)


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
    renaming = Renaming(include.prefix, rates | symbols, part.output_scope, at, name_beginnings(taken))
    stops = {
        old.name: new.name
        for joint in part.joints
        for old, new in zip(joint.stops, joint.rename(renaming).stops, strict=True)
    }
    return replace(renaming, stops=stops)


def _clashes(draft: Draft, content: Draft, include: Include) -> list[Problem]:
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


def _with_frames(elements: Sequence[Element], part: PlacedPart) -> list[Element]:
    """Return elements, the body that is the ground of a part with the frames and shapes of that ground."""
    content, at = part
    if not content.ground and not content.ground_shapes:
        return list(elements)
    return [
        replace(
            element,
            frames=FrozenMapping({**element.frames, **content.ground}),
            shapes=(*element.shapes, *content.ground_shapes),
        )
        if isinstance(element, Body) and element.name == at.body
        else element
        for element in elements
    ]


def model_content(model: Model) -> Draft:
    """Return all that a model consists of, its parts among it."""
    return Draft(
        model.elements, model.gravity, model.parameters, model.inputs, model.initial, model.ground,
        model.ground_shapes,
    )  # fmt: skip


def own_content(model: Model) -> tuple[Draft, tuple[Include, ...]]:
    """Return the content of a model's file: parts from files that are unchanged stay includes."""
    own, includes = model_content(model), list[Include]()
    names = [element.name for element in model.elements]
    for include in reversed(model.includes):
        part = place_part(include, model_content(model), names, [])
        if include.file and part is not None and _is_unchanged(own, part.content, {*include.share}):
            own = _remove_part(own, part, {*include.share})
            includes.insert(0, include)
    return own, tuple(includes)


def _is_unchanged(own: Draft, content: Draft, shared: AbstractSet[str]) -> bool:
    values = content.parameters.items()
    return (
        all(element in own.elements for element in content.elements)
        and all(own.parameters.get(name) == value for name, value in values if name not in shared)
        and all(name in own.initial for name in content.initial)
    )


def _remove_part(whole: Draft, part: PlacedPart, shared: AbstractSet[str]) -> Draft:
    content, at = part
    frames, shapes, initial = content.ground, content.ground_shapes, content.initial

    def without_frames(body: Element) -> Element:
        if not isinstance(body, Body) or body.name != at.body:
            return body
        own = {name: frame for name, frame in body.frames.items() if name not in frames}
        return replace(body, frames=FrozenMapping(own), shapes=body.shapes[: len(body.shapes) - len(shapes)])

    def is_same(name: str) -> bool:
        is_held = (name in initial.held) == (name in whole.initial.held)
        return is_held and initial.get(name) == whole.initial[name]

    gone = {*frames} if at.body == GROUND else set()
    count = len(whole.ground_shapes) - (len(shapes) if at.body == GROUND else 0)
    kept = {name for name in whole.parameters if name in shared or name not in content.parameters}
    return replace(
        whole,
        elements=tuple(without_frames(each) for each in whole.elements if each not in content.elements),
        parameters=FrozenMapping({name: x for name, x in whole.parameters.items() if name in kept}),
        inputs=tuple(name for name in whole.inputs if name not in content.inputs or name in shared),
        initial=FirstValues(
            {name: x for name, x in whole.initial.items() if not is_same(name)}, whole.initial.held
        ),
        ground=FrozenMapping({name: x for name, x in whole.ground.items() if name not in gone}),
        ground_shapes=whole.ground_shapes[:count],
    )


@dataclass(frozen=True, slots=True)
class Renaming:
    """New names for the elements and symbols of a part.

    Attributes
    ----------
    prefix : str
        Of elements and of frames on the ground.
    symbols : mapping of str to str
        All symbols of the part with their new names.
    scope : OutputScope
        Elements of the part, with the joints that stand for the motion of bodies without one, and its frames.
    at : FrameRef
        What is the ground of the part.
    beginnings : frozenset of str
        What elements of the whole begin with, which may be the name of one of the part.
    stops : mapping of str to str
        Those that limits of joints are, whose names contain those of coordinates, with their new names.
    """

    prefix: str
    symbols: Mapping[str, str]
    scope: OutputScope
    at: FrameRef
    beginnings: frozenset[str] = frozenset()
    stops: Mapping[str, str] = field(default_factory=dict)

    @property
    def ground(self) -> str:
        """The frame that is the ground of the part; "" if it is the ground of the model."""
        return "" if self.at == FrameRef(GROUND) else self.at.full_name

    def element_name(self, name: str) -> str:
        """Return the new name of an element."""
        return self.stops.get(name) or f"{self.prefix}_{name}"

    def symbol(self, name: str) -> str:
        """Return the new name of a symbol."""
        return self.symbols.get(name, name)

    def frame(self, address: FrameRef) -> FrameRef:
        """Return where a frame of the part is."""
        if address.body != GROUND:
            return FrameRef(self.element_name(address.body), address.frame)
        return FrameRef(self.at.body, self.element_name(address.frame)) if address.frame else self.at

    def formula(self, formula: Formula) -> Formula:
        """Return a formula in the new names."""
        return formula.rename(self.symbols)

    def output(self, text: str) -> str:
        """Return the name of an output, or an expression, in the new names."""
        derivative = parse_derivative(text)
        if derivative is not None:
            return self._derivative(derivative)
        asked = read_output(text, self.scope)
        if asked is not None:
            return join_words(rename_output(asked, self.scope, self), self.beginnings)
        if is_multiplier(text, self.scope.elements):
            return self._output_symbol(text)
        return self._expression(text)

    def _derivative(self, asked: DerivativeRequest) -> str:
        output = self.output(asked.output)
        if asked.alone:
            (word,) = (self._output_symbol(word) for word in asked.by)
            return f"d {output}/d({word})" if word in DERIVATIVE_GROUPS else f"d {output}/d {word}"
        groups = DERIVATIVE_GROUPS
        words = (word if word in groups else self._output_symbol(word.strip("() ")) for word in asked.by)
        return f"d {output}/d({', '.join(words)})"

    def address(self, word: str) -> str:
        """Return the new address of a frame, or of a contact, which has one of its own."""
        body, _, point = word.partition(".")
        ref = self.scope.frames.find(make_frame_ref(body, point))
        return self.frame(ref).full_name if isinstance(ref, FrameRef) else self.element_name(word)

    def _expression(self, text: str) -> str:
        try:
            formula = Formula.from_value(text, has_outputs=True)
        except ExpressionError:
            return text  # whoever makes the output says what is wrong
        names = {name: self._output_symbol(name) for name in formula.names}
        new = formula.rename(names, {name: self.output(name) for name in formula.outputs}).text
        return new if kind_of(new) is None else f"({new})"

    def _output_symbol(self, name: str) -> str:
        """Return the new name of a symbol in an output; equations name some after elements."""
        if name in self.symbols or name in RESERVED_SYMBOLS:
            return self.symbol(name)
        if is_multiplier(name, self.scope.elements):
            return f"{MULTIPLIER}{self.element_name(name.removeprefix(MULTIPLIER))}"
        return self.element_name(name)


P = TypeVar("P", Frame, BodyShape)


def place_on(base: Frame, item: P) -> P:
    """Return a frame or shape given in the axes of `base` in the axes of the body on which that stands.

    Raises NotImplementedError, which names the rotation, if that cannot be written with the angles of `base`.
    """
    if base == Frame():
        return item
    x, y, z = (_sum_of(pair) for pair in zip(base.at, _rotate(base, item.at), strict=True))
    at: Triple = (x, y, z)
    if base.matrix is not None and not item.rotate and item.matrix is None:
        return replace(item, at=at, matrix=base.matrix)
    if item.matrix is not None and not base.rotate and base.matrix is None:
        return replace(item, at=at)
    if base.matrix is not None or item.matrix is not None:
        raise NotImplementedError("a matrix, as well as the frame on it")
    return replace(item, at=at, rotate=(*base.rotate, *item.rotate))


def _rotate(base: Frame, vector: Triple) -> Triple:
    if base.matrix is not None:
        x, y, z = (_sum_of(_product(a, b) for a, b in zip(row, vector, strict=True)) for row in base.matrix)
        return (x, y, z)
    for axis, angle in reversed(base.rotate):
        if not isinstance(axis, str):
            raise NotImplementedError("an angle about an oblique axis")
        vector = _turn(axis, angle, vector)
    return vector


def _turn(axis: str, angle: Formula, vector: Triple) -> Triple:
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    c, s = Formula.from_value(f"cos({angle.text})"), Formula.from_value(f"sin({angle.text})")
    entries = list(vector)
    entries[i] = _difference(_product(c, vector[i]), _product(s, vector[j]))
    entries[j] = _sum_of((_product(s, vector[i]), _product(c, vector[j])))
    x, y, z = entries
    return (x, y, z)


def _sum_of(terms: Iterable[Formula]) -> Formula:
    shown = [term for term in terms if term.constant() != 0]
    if not shown:
        return ZERO
    return shown[0] if len(shown) == 1 else Formula.from_value(" + ".join(f"({x.text})" for x in shown))


def _product(a: Formula, b: Formula) -> Formula:
    if a.constant() == 0 or b.constant() == 0:
        return ZERO
    if b.constant() == 1:
        return a
    return b if a.constant() == 1 else Formula.from_value(f"({a.text})*({b.text})")


def _difference(a: Formula, b: Formula) -> Formula:
    if b.constant() == 0:
        return a
    return Formula.from_value(f"-({b.text})" if a.constant() == 0 else f"({a.text}) - ({b.text})")
