"""What names of outputs mean: the registry of their kinds.

Reading, units, lists, completion, names in parts and the tables of the documentation go by it. Equations make
the values: `symbody.equations.outputs.output_roots` has one function for each kind.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import methodcaller
from types import MappingProxyType
from typing import Final, NamedTuple

from symbody.model.declarations.field import NewNames
from symbody.model.joint import Joint
from symbody.model.output_arguments import (
    CoordinateWord,
    ElementWord,
    EntryWord,
    FrameWord,
    OutputArgument,
    OutputScope,
    SpeedWord,
    Words,
    join_words,
    split_words,
)

# Headings of the editor's tree and of lists of outputs, in their order.
TITLES: Final = (
    "Positions", "Speeds", "Accelerations", "Inputs", "Signals", "Energies", "Lengths and angles of springs",
    "Forces and torques", "Reactions", "Ropes", "Contacts", "Motion of frames",
    "Multipliers and constraint error", "Equations",
)  # fmt: skip
POSITIONS, SPEEDS, ACCELERATIONS, INPUTS, SIGNALS, ENERGIES, SPRINGS = TITLES[:7]
LOADS, REACTIONS, ROPES, CONTACTS, FRAMES, MULTIPLIERS, EQUATIONS = TITLES[7:]


@dataclass(frozen=True, slots=True)
class OutputKind:
    """A kind of output: the words of its names, its unit, and what it means.

    Attributes
    ----------
    word : str
        The first word.
    title : str
        One of `TITLES`.
    meaning : str
        For the documentation.
    unit : str
        "" where entries differ in their units; several, with commas, where the words decide.
    arguments : tuple of OutputArgument
        What stands behind the word.
    shape : str
        "" if it is a number; else its shape where no entry is named.
    choose_unit : callable, optional
        Takes the words behind the first and the scope, returns which of several units it has.
    is_readable : bool
        Whether results list it; what is not is for `compile` alone.
    """

    word: str
    title: str
    meaning: str
    unit: str
    arguments: tuple[OutputArgument, ...] = ()
    shape: str = ""
    choose_unit: Callable[[Words, OutputScope], str] | None = None
    is_readable: bool = True

    @property
    def pattern(self) -> str:
        """How its names are written."""
        return " ".join([self.word, *(argument.letter for argument in self.arguments)])

    def entries(self, words: Words) -> tuple[str, ...]:
        """Return the names of the entries of an output; none if it is a number, or they are numbered."""
        last = self.arguments[-1] if self.arguments else None
        return last.words(words[:-1]) if isinstance(last, EntryWord) and not words[-1] else ()


class OutputName(NamedTuple):
    """The name of an output, read: its kind, and the words behind the first, "" where one is left out."""

    kind: OutputKind
    words: Words

    @property
    def group(self) -> str:
        """The element, if the output is one entry of several that belong to it."""
        return self.words[0] if self.words[1:] and self.kind.shape else ""

    @property
    def addresses(self) -> tuple[str, ...]:
        """The elements and frames in it."""
        pairs = zip(self.kind.arguments, self.words, strict=False)
        return tuple(word for each, word in pairs if word and isinstance(each, ElementWord | FrameWord))

    def text(self, scope: OutputScope) -> str:
        """Return the name, in quotes where it would mean another."""
        plain = join_words((self.kind.word, *self.words), ())
        if scope.beginnings.isdisjoint(self.words) or read_output(plain, scope) == self:
            return plain
        return join_words((self.kind.word, *self.words), scope.beginnings)

    def unit(self, scope: OutputScope) -> str:
        """Return its unit."""
        choose = self.kind.choose_unit
        return self.kind.unit if choose is None else choose(self.words, scope)

    @property
    def is_number(self) -> bool:
        """Whether it is one number."""
        return not self.kind.shape or (bool(self.words) and bool(self.words[-1]))


# The grammar of the arguments.
FRAME_OUTPUT: Final = "frame"
WRENCH: Final = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
_VECTOR: Final = ("x", "y", "z")
_MATRIX: Final = tuple(row + column for row in _VECTOR for column in _VECTOR)
MOTION_UNITS: Final = MappingProxyType(
    {"r": "m", "v": "m/s", "vdot": "m/s^2", "R": "", "w": "rad/s", "wdot": "rad/s^2"}
)
# What people call these kinds of motion elsewhere.
MOTION_WORDS: Final = MappingProxyType(
    {
        "r": ("position", "pos", "location", "path", "r", "p"),
        "v": ("velocity", "vel", "speed", "v"),
        "vdot": ("acceleration", "acc", "a", "vdot"),
        "R": ("orientation", "rotation", "attitude", "pose", "R"),
        "w": ("angular velocity", "angular_velocity", "omega", "w"),
        "wdot": ("angular acceleration", "angular_acceleration", "alpha", "wdot"),
    }
)


def _effort_unit(words: Words, scope: OutputScope) -> str:
    """Return the unit of what acts along the coordinate of an element: the only one, if none is named."""
    owner, word = scope.elements.get(words[0]), words[-1] if len(words) > 1 else ""
    if owner is None:
        return ""
    if isinstance(owner, Joint):
        coordinate = word or owner.coordinates[0]
        turning = owner.rotation_coordinates if owner.quaternion is None else ()
        return "N m" if coordinate in turning else "N" if coordinate in owner.translation_coordinates else ""
    units = owner.effort_unit.split(", ")
    return units[-1] if word.startswith("r") else units[0]


def _normal_unit(words: Words, scope: OutputScope) -> str:
    owner = scope.elements.get(words[0])
    friction = owner.friction if isinstance(owner, Joint) else None
    return "N" if friction is not None and friction.reads_reaction else ""


def _gap_unit(words: Words, scope: OutputScope) -> str:
    """Return the unit of the gap of a contact; that of a stop follows from its formula."""
    owner = scope.elements.get(words[0])
    return "m" if owner is not None and owner.kind == "contact" else ""


def _motion_entries(words: Words) -> tuple[str, ...]:
    return _MATRIX if words[:1] == ("R",) else _VECTOR


def _has_axes(words: Words) -> bool:
    """Return whether the frame may follow in which a motion is resolved: not behind a matrix of rotation."""
    return words[:1] != ("R",)


def _elements(kind: str, letter: str, *, is_needed: bool = True) -> ElementWord:
    return ElementWord(letter, methodcaller("output_words", kind), is_needed)


def _coordinate_words(kind: str, letter: str) -> tuple[OutputArgument, ...]:
    """Return the arguments for an element and one of its coordinates, where it has several."""
    words = _elements(kind, letter)
    return words, CoordinateWord("[rx]" if kind == "angle" else "[x]", words.following)


_FRICTION: Final = (_elements("friction", "J"),)
_ROPE: Final = (_elements("rope", "R"),)
_STOP: Final = (_elements("stop", "S"),)
MULTIPLIER: Final = "lambda_"
_ROW: Final = re.compile(r"_(?:\d+|motion(?:_\d+)?|stick)")

_ALL: Final = (
    OutputKind("kinetic_energy", ENERGIES, "kinetic energy T relative to ground", "J"),
    OutputKind("potential_energy", ENERGIES, "potential energy V of gravity and springs", "J"),
    OutputKind("energy", ENERGIES, "kinetic plus potential energy, T + V", "J"),
    OutputKind("power", ENERGIES, "power of all that has no potential", "W"),
    OutputKind("length", SPRINGS, "length of a spring; place of a bushing along x, y, z", "m",
               _coordinate_words("length", "S")),
    OutputKind("angle", SPRINGS, "angle of a torsion spring; angles of a bushing", "rad",
               _coordinate_words("angle", "S")),
    OutputKind("effort", LOADS, "applied + spring + damper + prescribed motion, along x", "N, N m",
               _coordinate_words("effort", "J"), choose_unit=_effort_unit),
    OutputKind("friction", LOADS, "effort of dry friction along the coordinate", "N, N m", _FRICTION,
               choose_unit=_effort_unit),
    OutputKind("friction_normal", LOADS, "reaction that friction comes from, or 1", "N", _FRICTION,
               choose_unit=_normal_unit),
    OutputKind("friction_reserve", LOADS, "effort up to which it sticks, less the present one", "N, N m",
               (_elements("friction", "[J]", is_needed=False),), "n", _effort_unit),
    OutputKind("mode", LOADS,
               "joint: 0 sticks, 1 or -1 slips forward or backward; rope, gap: 1 taut or closed, 0 not", "",
               (_elements("mode", "J"),)),
    OutputKind("reaction", REACTIONS, "wrench on B by A of what connects A and B", "N, N m",
               (_elements("reaction", "J"), EntryWord("[Fx]", lambda _: WRENCH)), "6",
               lambda words, _: {"F": "N", "M": "N m"}.get(words[1][:1], "")),
    OutputKind("rope_tension", ROPES, "force with which a rope pulls", "N", _ROPE),
    OutputKind("rope_length", ROPES, "length of the rope itself", "m", _ROPE),
    OutputKind("rope_slack", ROPES, "its length less the distance of its ends", "m", _ROPE),
    OutputKind("rope_slack_dot", ROPES, "rate of the slack", "m/s", _ROPE),
    OutputKind("rope_slack_ddot", ROPES, "second rate of the slack", "m/s^2", _ROPE),
    OutputKind("rope_size", ROPES, "size of the terms of the second rate of the slack", "m/s^2", _ROPE),
    OutputKind("gap", CONTACTS, "distance of two shapes, negative where they overlap; what a stop limits",
               "m, rad", (_elements("gap", "C"),), choose_unit=_gap_unit),
    OutputKind("contact_force", CONTACTS, "force of a contact on its end, in the axes of its frame", "N",
               (_elements("contact_force", "C"), EntryWord("[x]", lambda _: _VECTOR)), "3"),
    OutputKind("contact_point", CONTACTS, "where that force acts, from its start in the axes of that", "m",
               (_elements("contact_point", "C"), EntryWord("[x]", lambda _: _VECTOR)), "3"),
    OutputKind("slip", CONTACTS, "velocity of its end relative to its start across the normal, where the gap "
               "is least", "m/s", (_elements("slip", "C"), EntryWord("[x]", lambda _: _VECTOR[:2])), "2"),
    OutputKind("opening_effort", CONTACTS, "effort with which a closed stop opens its gap", "N, N m", _STOP,
               choose_unit=_gap_unit),
    OutputKind("gap_dot", CONTACTS, "rate of the gap of a stop", "m/s, rad/s", _STOP, choose_unit=_gap_unit),
    OutputKind("gap_ddot", CONTACTS, "its second rate", "m/s^2, rad/s^2", _STOP, choose_unit=_gap_unit),
    OutputKind("friction_rate", LOADS, "the rate that friction is against", "", _FRICTION, is_readable=False),
    OutputKind("slip_along", CONTACTS, "slip along the heading of a mode", "", _FRICTION, is_readable=False),
    OutputKind("row_gap", CONTACTS, "gap of a rope, stop or point of contact", "", _STOP, is_readable=False),
    OutputKind("gap_scale", CONTACTS, "what the gap is small against", "", _STOP, is_readable=False),
    OutputKind("restitution", CONTACTS, "share of the rate that is left after an impact", "", _STOP,
               is_readable=False),
    OutputKind(FRAME_OUTPUT, FRAMES, "motion of END relative to REFERENCE, components along axes of IN",
               ", ".join(filter(None, MOTION_UNITS.values())),
               (EntryWord("KIND", lambda _: tuple(MOTION_UNITS), is_needed=True),
                FrameWord("END", is_needed=True, is_listed=True), FrameWord("[REFERENCE]"),
                FrameWord("[IN]", fits=_has_axes), EntryWord("[x]", _motion_entries, is_listed=False)),
               "3, 3 x 3", lambda words, _: MOTION_UNITS.get(words[0], "")),
    OutputKind("udot", EQUATIONS, "accelerations u'", "", shape="n_u"),
    OutputKind("qdot", EQUATIONS, "rates q' of the coordinates", "", shape="n_q"),
    OutputKind("xdot", EQUATIONS, "rates (u', q', s') of the states", "", shape="n_x"),
    OutputKind("signal_rates", EQUATIONS, "rates s' of the states of signals", "", shape="n_s"),
    OutputKind("A", EQUATIONS, "derivatives of x' with respect to the states", "", shape="n_x x n_x"),
    OutputKind("B", EQUATIONS, "derivatives of x' with respect to the inputs", "", shape="n_x x n_r"),
    OutputKind("lambda", MULTIPLIERS, "multipliers of the constraints", "", shape="n_c"),
    OutputKind("mass_matrix", EQUATIONS, "mass matrix M", "", shape="n_u x n_u"),
    OutputKind("forcing", EQUATIONS, "F, all but M u' and the multipliers", "", shape="n_u"),
    OutputKind("gravity_forcing", EQUATIONS, "part of F that gravity makes, or that along x alone", "",
               (SpeedWord("[x]"),), "n_u"),
    OutputKind("bias", EQUATIONS, "the forcing with opposite sign, -F", "", shape="n_u"),
    OutputKind("inverse_dynamics", EQUATIONS, "M u' - F, with u' as an argument", "", shape="n_u",
               is_readable=False),
    OutputKind("constraints", MULTIPLIERS, "position constraints Phi", "", shape="n_h"),
    OutputKind("velocity_constraints", MULTIPLIERS, "velocity constraints J u + b", "", shape="n_c"),
    OutputKind("gamma", MULTIPLIERS, "right-hand side of J u' = gamma", "", shape="n_c"),
    OutputKind("jacobian", MULTIPLIERS, "constraint Jacobian J, in the speeds", "", shape="n_c x n_u"),
    OutputKind("position_jacobian", MULTIPLIERS, "derivatives of Phi with respect to q", "",
               shape="n_h x n_q"),
    # for integrators of a user's own: the drift, and the move that takes it back
    OutputKind("position_residual", MULTIPLIERS, "drift of the coordinates", "", shape="n"),
    OutputKind("position_move", MULTIPLIERS, "move of q that takes the drift back", "", shape="n_q"),
    OutputKind("velocity_residual", MULTIPLIERS, "drift of the speeds", "", shape="n_c"),
    OutputKind("velocity_move", MULTIPLIERS, "move of u that takes the drift back", "", shape="n_u"),
    OutputKind("friction_residual", EQUATIONS, "0 where friction fits the reactions", "", shape="n"),
    OutputKind("friction_margin", EQUATIONS, "positive where both are determined", "", shape="n"),
    OutputKind("mode_responses", EQUATIONS, "what decides which joints stick, ropes pull", "", shape="n",
               is_readable=False),
    OutputKind("alignment", EQUATIONS, "cosines that are 1 where cut joints are closed", "", shape="n"),
)  # fmt: skip

# By first word. Those without arguments are of the whole mechanism.
OUTPUT_KINDS: Final[Mapping[str, OutputKind]] = MappingProxyType({kind.word: kind for kind in _ALL})
# What may be differentiated by, beside symbols: all coordinates, speeds, inputs, states of signals.
DERIVATIVE_GROUPS: Final = ("q", "u", "r", "s")
_DERIVATIVE: Final = re.compile(
    r"d\s+(?P<output>.+?)\s*/\s*d\s*(?:\((?P<list>[^/]*)\)|(?P<one>[^/()]+))\s*", re.S
)


class DerivativeRequest(NamedTuple):
    """An output, the words it is differentiated by, and whether that is one symbol, which adds no axis."""

    output: str
    by: tuple[str, ...]
    alone: bool


def parse_derivative(name: str) -> DerivativeRequest | None:
    """Return the request that a name like ``d udot/d q`` contains; None if it is not a derivative."""
    found = _DERIVATIVE.fullmatch(name.strip())
    if found is None:
        return None
    if found["one"] is not None:
        word = found["one"].strip()
        return DerivativeRequest(found["output"], (word,), word not in DERIVATIVE_GROUPS)
    return DerivativeRequest(found["output"], tuple(word.strip() for word in found["list"].split(",")), False)


def is_multiplier(name: str, elements: Iterable[str]) -> bool:
    """Return whether a name is that of a multiplier of one of some elements.

    >>> is_multiplier("lambda_rod_2", ["rod"]), is_multiplier("lambda_max", ["rod"])
    (True, False)
    """
    text = name.removeprefix(MULTIPLIER)
    return text != name and any(
        text.startswith(element) and _ROW.fullmatch(text, len(element)) for element in elements
    )


def kind_of(name: str) -> OutputKind | None:
    """Return the kind that the first word of a name says; None of symbols and expressions.

    >>> kind_of("reaction pin Fx").word, kind_of("energy").word, kind_of("reaction"), kind_of("reaction * 2")
    ('reaction', 'energy', None, None)
    """
    first, _, rest = name.partition(" ")
    kind = OUTPUT_KINDS.get(first)
    if kind is None:
        return None
    if name == first:
        return None if any(each.is_needed for each in kind.arguments) else kind
    is_argument = rest.strip()[:1] not in tuple("-+*/^<>=(,") and rest.strip() != ""
    return kind if kind.arguments and is_argument else None


def read_output(name: str, scope: OutputScope) -> OutputName | None:
    """Return the kind and words of a name; None of symbols, multipliers, derivatives and expressions."""
    kind = kind_of(name)
    if kind is None:
        return None
    return OutputName(kind, split_words(name.removeprefix(kind.word), kind.arguments, scope))


def list_outputs(scope: OutputScope) -> Iterator[OutputName]:
    """Yield the outputs of a mechanism in the order of the kinds, of motions of frames those in ground."""
    for kind in OUTPUT_KINDS.values():
        for words in _word_lists(kind.arguments, scope, ()):
            yield OutputName(kind, words)


class ListedOutput(NamedTuple):
    """An output in a list: its name, heading, the element it is an entry of, and whether it is a number."""

    name: str
    title: str
    group: str = ""
    is_number: bool = True


def list_readable(scope: OutputScope, symbols: Mapping[str, Iterable[str]]) -> list[ListedOutput]:
    """Return all that can be read of a mechanism, in the order of the headings.

    Parameters
    ----------
    symbols : mapping of heading to names
        Coordinates, speeds, inputs and others that have no kind.
    """
    listed: dict[str, ListedOutput] = {}
    for title, names in symbols.items():
        for name in names:
            listed.setdefault(name, ListedOutput(name, title))
    for asked in list_outputs(scope):
        if not asked.kind.is_readable:
            continue
        name = asked.text(scope)
        listed.setdefault(name, ListedOutput(name, asked.kind.title, asked.group, asked.is_number))
    return sorted(listed.values(), key=lambda each: TITLES.index(each.title))


def _word_lists(
    arguments: Sequence[OutputArgument], scope: OutputScope, before: tuple[str, ...]
) -> Iterator[tuple[str, ...]]:
    if len(before) == len(arguments):
        yield before
        return
    argument = arguments[len(before)]
    for word in argument.choices(scope, before) if argument.is_listed else ("",):
        yield from _word_lists(arguments, scope, (*before, word))


def rename_output(asked: OutputName, scope: OutputScope, names: NewNames) -> tuple[str, ...]:
    """Return the words of an output of a part, the first among them, as they read in a model.

    Words that do not fit are renamed as far as they may be elements, lest they name others in the model.
    """
    kind, words = asked
    new = [
        each.rename(words[k], scope, words[:k], names) for k, each in enumerate(kind.arguments[: len(words)])
    ]
    return (kind.word, *new, *words[len(new) :])
