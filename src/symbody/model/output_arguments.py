"""What stands behind the first word of an output's name: elements, coordinates, frames, entries.

Each argument knows what may stand in its place, so that names are read, listed and renamed by it alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from symbody.model.body import Body
from symbody.model.declarations.field import NewNames
from symbody.model.declarations.fields import SymbolElementName
from symbody.model.element import Element, make_frame_ref
from symbody.model.frame import Frame
from symbody.model.frame_index import FrameIndex, frame_index
from symbody.model.joint import Joint
from symbody.model.naming import GROUND

Words = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class OutputScope:
    """What names of outputs refer to.

    Attributes
    ----------
    elements : mapping of name to Element
        Those of a model, and the joints that stand for the motion of bodies without one.
    frames : FrameIndex
        All of its frames.
    beginnings : frozenset of str
        What stands before a blank in the name of an element.
    """

    elements: Mapping[str, Element]
    frames: FrameIndex
    beginnings: frozenset[str]

    def is_frame(self, word: str, *, may_be_entry: bool = False) -> bool:
        """Return whether a word is the address of a frame, or the name of a contact, which has one.

        Parameters
        ----------
        may_be_entry : bool
            Whether an entry such as ``x`` may stand here, which wins over a frame ``x`` of some body.
        """
        element = self.elements.get(word)
        if element is not None and element.has_frame:
            return True
        body, _, point = word.partition(".")
        known, address = self.frames.frames, make_frame_ref(body, point)
        if address.body in known:
            return not address.frame or address.frame in known[address.body]
        is_entry = may_be_entry and {*word} <= {*"xyz"}
        return not point and not is_entry and any(word in names for names in known.values())


class OutputArgument(ABC):
    """One word behind the first in the names of some outputs.

    Attributes
    ----------
    letter : str
        What the documentation writes for it.
    is_needed : bool
        Whether it cannot be left out.
    is_listed : bool
        Whether lists of outputs show each choice; else they leave the word out.
    """

    letter: str
    is_needed: bool
    is_listed: bool = True

    @abstractmethod
    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return what may stand here, behind the words before; "" if the word may be left out."""

    def accepts(self, word: str, scope: OutputScope, before: Words) -> bool:
        """Return whether a word may stand here."""
        return word in self.choices(scope, before)

    def rename(self, word: str, scope: OutputScope, before: Words, names: NewNames) -> str:
        """Return the word as it reads in a model that the part is put into."""
        return word


# Takes an element; returns what follows its name: ("",) if nothing does, () if it has no such output.
Following = Callable[[Element], tuple[str, ...]]


@dataclass(frozen=True)
class ElementWord(OutputArgument):
    """The name of an element; if it is left out, all those are meant."""

    letter: str
    following: Following
    is_needed: bool = True

    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return the elements that have such an output."""
        fitting = [name for name, element in scope.elements.items() if self.following(element)]
        return fitting if self.is_needed else ["", *fitting]

    def accepts(self, word: str, scope: OutputScope, before: Words) -> bool:
        """Return whether a word is the name of such an element."""
        element = scope.elements.get(word)
        return bool(self.following(element)) if element is not None else not (word or self.is_needed)

    def rename(self, word: str, scope: OutputScope, before: Words, names: NewNames) -> str:
        """Return the new name of the element."""
        return names.element_name(word) if word else ""


@dataclass(frozen=True)
class CoordinateWord(OutputArgument):
    """A coordinate of the element before, one of those that its `ElementWord` lets follow."""

    letter: str
    following: Following
    is_needed: bool = False

    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return the coordinates of the element that have such an output."""
        owner = scope.elements.get(before[0]) if before else None
        return () if owner is None else self.following(owner)

    def rename(self, word: str, scope: OutputScope, before: Words, names: NewNames) -> str:
        """Return the new name of a coordinate; directions of springs are no symbols."""
        return names.symbol(word) if word and isinstance(scope.elements.get(before[0]), Joint) else word


@dataclass(frozen=True)
class SpeedWord(OutputArgument):
    """A coordinate whose rate is a speed, or a quasi-speed; if it is left out, all speeds are meant.

    Which of them are speeds follows from the trees, so that lists leave the word out.
    """

    letter: str
    is_needed: bool = False
    is_listed: bool = False

    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return the quasi-speeds of all joints, and the coordinates where these have none."""
        joints = (element for element in scope.elements.values() if isinstance(element, Joint))
        return ["", *(name for joint in joints for name in _moving_names(joint))]

    def rename(self, word: str, scope: OutputScope, before: Words, names: NewNames) -> str:
        """Return the new name of a coordinate or speed."""
        return names.symbol(word) if word else ""


def _moving_names(joint: Joint) -> Iterator[str]:
    for coordinates, speeds in (
        (joint.translation_coordinates, joint.translation_speeds),
        (joint.rotation_coordinates, joint.rotation_speeds),
    ):
        own = coordinates if speeds is None else speeds.names
        yield from (name for name in own if name not in joint.motions)


@dataclass(frozen=True)
class FrameWord(OutputArgument):
    """The address of a frame; if it is left out, the ground is meant.

    Attributes
    ----------
    fits : callable
        Takes the words before, returns whether one more frame may follow.
    """

    letter: str
    is_needed: bool = False
    fits: Callable[[Words], bool] = lambda before: True
    is_listed: bool = False

    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return the addresses of all frames but the ground."""
        known = scope.frames.frames.items()
        bodies = (body for body, _ in known if body != GROUND)
        points = (f"{body}.{name}" for body, names in known for name in sorted(names))
        contacts = (name for name, element in scope.elements.items() if element.has_frame)
        return (*bodies, *points, *contacts)

    def accepts(self, word: str, scope: OutputScope, before: Words) -> bool:
        """Return whether a word is the address of a frame."""
        if not word:
            return not self.is_needed
        return scope.is_frame(word, may_be_entry=not self.is_needed) and self.fits(before)

    def rename(self, word: str, scope: OutputScope, before: Words, names: NewNames) -> str:
        """Return the new address; a frame that is left out is the ground of the part."""
        return names.address(word) if word else names.ground if self.fits(before) else ""


@dataclass(frozen=True)
class EntryWord(OutputArgument):
    """One of some words, such as an entry of an output with several.

    Attributes
    ----------
    words : callable
        Takes the words before, returns these in order.
    """

    letter: str
    words: Callable[[Words], tuple[str, ...]]
    is_needed: bool = False
    is_listed: bool = True

    def choices(self, scope: OutputScope, before: Words) -> Iterable[str]:
        """Return the words."""
        return self.words(before) if self.is_needed else ("", *self.words(before))


def make_scope(
    elements: Iterable[Element], bodies: Iterable[Body], ground: Mapping[str, Frame]
) -> OutputScope:
    """Return what names of outputs refer to; of two elements of one name the later counts, a free joint.

    Signals, blocks and tables are not among them: their names are symbols, and may be those of elements.
    """
    own = (each for each in elements if not isinstance(each.fields["name"], SymbolElementName))
    named = {element.name: element for element in own}
    return OutputScope(named, frame_index(bodies, ground), name_beginnings(named))


def name_beginnings(names: Iterable[str]) -> frozenset[str]:
    """Return what stands before a blank in some names.

    >>> sorted(name_beginnings(["A", "B one two"]))
    ['B', 'B one']
    """
    return frozenset(name[:k] for name in names for k, letter in enumerate(name) if letter == " ")


def join_words(words: Words, beginnings: Container[str]) -> str:
    """Return words as one text, in quotes where another name begins with one and a blank.

    >>> join_words(["reaction", "A", "Fx"], {"A"}), join_words(["reaction", "A", ""], {"A"})
    ('reaction "A" Fx', 'reaction A')
    """
    *first, last = (word for word in words if word)
    return " ".join((*(f'"{word}"' if word in beginnings else word for word in first), last))


def split_words(text: str, arguments: Sequence[OutputArgument], scope: OutputScope) -> tuple[str, ...]:
    """Return the words of a text: one for each argument, "" where it is left out.

    Each is what is quoted, or the longest that fits. If words do not fit the arguments, all of them are
    returned as they are.
    """
    words = _fitting_words(text, arguments, scope)
    if words is None and '"' in text:  # quotes about several words
        words = _fitting_words(text.replace('"', ""), arguments, scope)
    return _plain_words(text, arguments, scope) if words is None else words


def _fitting_words(
    text: str, arguments: Sequence[OutputArgument], scope: OutputScope
) -> tuple[str, ...] | None:
    words: tuple[str, ...] = ()
    rest = text.strip()
    for argument in arguments:
        word, behind = _take_word(rest, partial(argument.accepts, scope=scope, before=words)) or ("", rest)
        if not word and not argument.accepts("", scope, words):
            return None
        words, rest = (*words, word), behind
    return None if rest else words


def _plain_words(text: str, arguments: Sequence[OutputArgument], scope: OutputScope) -> tuple[str, ...]:
    def fits(word: str) -> bool:
        return any(argument.accepts(word, scope, ()) for argument in arguments)

    words, rest = [], text.strip()
    while rest:
        first, _, behind = rest[1:].partition('"') if rest.startswith('"') else rest.partition(" ")
        word, rest = _take_word(rest, fits) or (first, behind.strip())
        words.append(word)
    return tuple(words)


def _take_word(text: str, fits: Callable[[str], bool]) -> tuple[str, str] | None:
    """Return the longest beginning of a text that fits, or what it quotes, and what follows."""
    if text.startswith('"'):
        word, _, behind = text[1:].partition('"')
        return (word, behind.strip()) if fits(word) else None
    end = len(text)
    while end > 0:
        if fits(text[:end]):
            return text[:end], text[end:].strip()
        end = text.rfind(" ", 0, end)
    return None
