"""Elements under other names: every name, address and formula in them, by what each argument is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.errors import ExpressionError
from symbody.expr.language.formula import Formula
from symbody.model.constraints import Rolling
from symbody.model.element import Element, FrameRef, make_frame_ref
from symbody.model.frame_index import FrameIndex
from symbody.model.joint import Joint
from symbody.model.naming import GROUND, RESERVED_SYMBOLS
from symbody.model.output_names import (
    DERIVATIVE_GROUPS,
    ELEMENT_OUTPUTS,
    FRAME_OUTPUT,
    WHOLE_OUTPUTS,
    DerivativeRequest,
    is_multiplier,
    output_words,
    parse_derivative,
    parse_frame,
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
    elements : tuple of Element
        Those of the part, with the joints that stand for the motion of bodies without one.
    frames : FrameIndex
        Those of the part.
    at : FrameRef
        What is the ground of the part.
    taken : frozenset of str
        Elements of the whole under their names there, which may begin like those of the part.
    """

    prefix: str
    symbols: Mapping[str, str]
    elements: tuple[Element, ...]
    frames: FrameIndex
    at: FrameRef
    taken: frozenset[str] = frozenset()

    def element_name(self, name: str) -> str:
        """Return the new name of an element."""
        return f"{self.prefix}_{name}"

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
        if text in WHOLE_OUTPUTS:
            return text
        asked = parse_derivative(text)
        if asked is not None:
            return self._derivative(asked)
        first, _, rest = text.partition(" ")
        if first == FRAME_OUTPUT and rest:
            return f"{first} {self._frame_words(rest)}"
        if first in ELEMENT_OUTPUTS and rest:
            return f"{first} {self._element_words(rest, ELEMENT_OUTPUTS[first])}"
        if is_multiplier(text, self._names(Element)):
            return self._output_symbol(text)
        return self._expression(text)

    def _derivative(self, asked: DerivativeRequest) -> str:
        output = self.output(asked.output)
        if asked.alone:
            (word,) = (self._output_symbol(word) for word in asked.by)
            return f"d {output}/d({word})" if word in DERIVATIVE_GROUPS else f"d {output}/d {word}"
        return f"d {output}/d({', '.join(map(self._derivative_word, asked.by))})"

    def _derivative_word(self, word: str) -> str:
        return word if word in DERIVATIVE_GROUPS else self._output_symbol(word.strip("() "))

    def _frame_words(self, text: str) -> str:
        """Return the words of a frame's motion; the ground that they leave out is that of the part."""
        addresses = [
            FrameRef(body, frame).full_name
            for body, names in self.frames.frames.items()
            for frame in ("", *names)
        ]
        contacts = self._names(Rolling)
        asked = parse_frame(text, {*addresses, *contacts})
        if asked is None:
            return text
        frames = [
            self.element_name(word) if word in contacts else self._address(word) for word in asked.frames
        ]
        if self.at != FrameRef(GROUND):
            count = 2 if asked.kind == "R" else 3
            frames += [self.at.full_name] * (count - len(frames))
        return self._join([asked.kind, *frames, asked.entry] if asked.entry else [asked.kind, *frames])

    def _address(self, word: str) -> str:
        body, _, point = word.partition(".")
        found = self.frames.find(make_frame_ref(body, point))
        return self.frame(found).full_name if isinstance(found, FrameRef) else self.element_name(word)

    def _element_words(self, text: str, owners: tuple[type[Element], ...]) -> str:
        """Return the words behind the first: an element, and its coordinate or an entry."""
        word, *others = output_words(text, self._names(*owners))
        owner = next((each for each in self.elements if each.name == word and isinstance(each, owners)), None)
        if isinstance(owner, Joint):
            others = [self.symbol(name) if name in owner.coordinates else name for name in others]
        return self._join([self.element_name(word), *others])

    def _join(self, words: Sequence[str]) -> str:
        """Return the words of an output, in quotes where another name begins with one and a blank."""
        *first, last = words
        quoted = [
            f'"{word}"' if any(name.startswith(f"{word} ") for name in self.taken) else word for word in first
        ]
        return " ".join((*quoted, last))

    def _names(self, *kinds: type[Element]) -> list[str]:
        return [element.name for element in self.elements if isinstance(element, kinds)]

    def _expression(self, text: str) -> str:
        try:
            formula = Formula.from_value(text, has_outputs=True)
        except ExpressionError:
            return text  # whoever makes the output says what is wrong
        names = {name: self._output_symbol(name) for name in formula.names}
        new = formula.rename(names, {name: self.output(name) for name in formula.outputs}).text
        first, blank, _ = new.partition(" ")
        is_output = new in WHOLE_OUTPUTS or (blank and first in (FRAME_OUTPUT, *ELEMENT_OUTPUTS))
        return f"({new})" if is_output else new

    def _output_symbol(self, name: str) -> str:
        """Return the new name of a symbol in an output; equations name some after elements."""
        if name in self.symbols or name in RESERVED_SYMBOLS:
            return self.symbol(name)
        if is_multiplier(name, self._names(Element)):
            return f"lambda_{self.element_name(name.removeprefix('lambda_'))}"
        return self.element_name(name)
