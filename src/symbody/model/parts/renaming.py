"""Elements under other names: every name, address and formula in them, by what each argument is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from symbody.errors import ExpressionError
from symbody.expr.language.formula import Formula
from symbody.model.element import FrameRef, make_frame_ref
from symbody.model.naming import GROUND, RESERVED_SYMBOLS
from symbody.model.output_arguments import OutputScope, join_words
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
    """

    prefix: str
    symbols: Mapping[str, str]
    scope: OutputScope
    at: FrameRef
    beginnings: frozenset[str] = frozenset()

    @property
    def ground(self) -> str:
        """The frame that is the ground of the part; "" if it is the ground of the model."""
        return "" if self.at == FrameRef(GROUND) else self.at.full_name

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
        return f"d {output}/d({', '.join(map(self._derivative_word, asked.by))})"

    def _derivative_word(self, word: str) -> str:
        return word if word in DERIVATIVE_GROUPS else self._output_symbol(word.strip("() "))

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
