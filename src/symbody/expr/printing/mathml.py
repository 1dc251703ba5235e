"""Presentation MathML, which browsers and notebooks show without any program."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from html import escape
from typing import ClassVar, Final

from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.printing.layout import (
    ATOM,
    POWER,
    PRODUCT,
    SUM,
    Brackets,
    Layout,
    Piece,
    join_pieces,
    print_node,
    printed_with_definitions,
)
from symbody.expr.printing.names import GREEK, name_words
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals, full_text
from symbody.expr.printing.textbook import Factor, Style, textbook

_APPLY: Final = "<mo>\u2061</mo>"  # what stands, unseen, between a function and its bracket
_COMMA: Final = "<mo>,</mo>"
# Over a letter, one to four; accents, which pages hold a font for.
_DOTS: Final = ("\u02d9", "\u00a8", "...", "....")
_NAMES: Final = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "sign": "sgn"}
_AROUND: Final = {"abs": ("|", "|"), "floor": ("\u230a", "\u230b")}
_POWER_OF_NAME: Final = frozenset("sin cos tan sinh cosh tanh".split())
_LEFT: Final = '<mtd style="text-align:left">'
# A row of one piece is that piece.
_SINGLE: Final = re.compile(r"<mrow>(<(m[ino])>[^<]*</\2>)</mrow>")


def to_mathml(graph: Graph, node: int, names: Mapping[Symbol, str] | None = None) -> str:
    """Return a node as MathML elements, to be put into a ``math`` element; dots are time derivatives.

    Parameters
    ----------
    names : mapping of Symbol to MathML, optional
        How symbols are written, derivatives by their dots if not named themselves; taken as it is.
        By default as `mathml_name` writes them.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, and for entries of kernels.
    """
    style = _MathML(names=dict(names or {}))
    return _tidy(print_node(graph, node, textbook(graph, [node], style), style.brackets))


def to_mathml_with_definitions(
    graph: Graph,
    nodes: Sequence[int],
    limit: int = EXPAND_LIMIT,
    numerals: Numerals = ALL_DIGITS,
    leading: Mapping[int, int] | None = None,
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes as MathML, with shared parts named z1, z2, ... if one exceeds `limit` operations.

    Parameters
    ----------
    numerals : Numerals
        How many digits numbers have; rounded ones bear the full number in ``data-full``.
    leading : mapping of node to node, optional
        The symbol whose terms come first in a sum.

    Returns
    -------
    (formulas, definitions)
        Definitions are pairs of name and formula, each using earlier names only.
    """
    style = _MathML(numerals=numerals)
    notation = textbook(graph, nodes, style, leading)
    written = printed_with_definitions(graph, nodes, notation, limit, mathml_name, style.brackets)
    return [_tidy(text) for text in written[0]], [(name, _tidy(text)) for name, text in written[1]]


def mathml_name(name: str, order: int = 0) -> str:
    """Return a name as MathML: Greek letters, indices after ``_`` and of final digits, dots; all escaped.

    Examples
    --------
    >>> mathml_name("m1")
    '<msub><mi>m</mi><mn>1</mn></msub>'
    """
    head, *indices = name_words(name)
    base = _put_dots(_word(head), order)
    if not indices:
        return base
    below = _COMMA.join(map(_word, indices))
    return f"<msub>{base}{below if len(indices) == 1 else f'<mrow>{below}</mrow>'}</msub>"


def _put_dots(base: str, order: int) -> str:
    if order == 0:
        return base
    if order <= len(_DOTS):
        return f'<mover accent="true">{base}<mo stretchy="false">{_DOTS[order - 1]}</mo></mover>'
    return f"<msup>{base}<mrow><mo>(</mo><mn>{order}</mn><mo>)</mo></mrow></msup>"


def _word(word: str) -> str:
    if word.isascii() and word.isdigit():
        return f"<mn>{word}</mn>"
    shown = "".join(c if c.isprintable() else f"U+{ord(c):04X}" for c in word)
    return f"<mi>{escape(GREEK.get(word, shown))}</mi>"


def _tidy(text: str) -> str:
    return _SINGLE.sub(r"\1", text)


def _sign(mark: str) -> str:
    return f"<mo>{escape(mark)}</mo>"


@dataclass(frozen=True, slots=True)
class _MathML(Style):
    """Elements of MathML Core."""

    names: Mapping[Symbol, str] = field(default_factory=dict)
    brackets: ClassVar[Brackets] = Brackets("<mrow><mo>(</mo>", "<mo>)</mo></mrow>")
    times: ClassVar[str] = '<mo lspace="0" rspace="0.17em">\u2062</mo>'
    plus: ClassVar[str] = _sign("+")
    minus: ClassVar[str] = _sign("\u2212")
    negative: ClassVar[str] = '<mo form="prefix">\u2212</mo>'
    pi: ClassVar[str] = "<mi>\u03c0</mi>"
    relations: ClassVar[Sequence[str]] = tuple(map(_sign, "<>\u2264\u2265=\u2260\u2227\u2228\u00ac"))

    def symbol(self, symbol: Symbol) -> str:
        if symbol in self.names:
            return self.names[symbol]
        given = self.names.get(Symbol(symbol.name, symbol.kind))
        return _put_dots(given, symbol.order) if given else mathml_name(symbol.name, symbol.order)

    def number(self, value: Constant) -> str:
        text = self.numerals.text(value)
        full = f' data-full="{full_text(value)}"' if self.numerals.round_number(value) else ""
        mantissa, _, exponent = text.replace("-", "\u2212").partition("e")
        if not exponent:
            return f"<mn{full}>{mantissa}</mn>"
        sign = "\u2212" if exponent.startswith("\u2212") else ""
        power = f"<msup><mn>10</mn><mn>{sign}{int(exponent.lstrip('+' + sign))}</mn></msup>"
        return power if mantissa == "1" else f"<mn{full}>{mantissa}</mn><mo>\u00b7</mo>{power}"

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        if not below and ratio.denominator != 1 and above:
            number = f"<mfrac><mn>{ratio.numerator}</mn><mn>{ratio.denominator}</mn></mfrac>"
            return Layout(join_pieces(self.times, [[number], *above]), PRODUCT)
        top, bottom = self.with_number(ratio, above, below)
        pieces = self.line(top or [[self.number(1)]])
        if not bottom:
            return Layout(pieces, PRODUCT)
        return Layout(["<mfrac>", *_row(pieces), *_row(self.line(bottom)), "</mfrac>"], POWER)

    def power(self, base: Piece, exponent: Piece) -> Layout:
        return Layout(["<msup>", *_row([base]), *_row([exponent]), "</msup>"], POWER)

    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        listed = join_pieces(_COMMA, [[argument] for argument in arguments])
        if name == "sqrt":
            return self._raise_to(["<msqrt>", *_row(listed), "</msqrt>"], exponent)
        if name in _AROUND:
            before, after = map(_sign, _AROUND[name])
            return self._raise_to(_row([before, *listed, after]), exponent)
        word = f"<mi>{escape(_NAMES.get(name, name))}</mi>"
        bracket = [self.brackets.opening, *listed, self.brackets.closing]
        if exponent != 1 and name in _POWER_OF_NAME:
            return Layout([f"<msup>{word}{self.number(exponent)}</msup>", _APPLY, *bracket], POWER)
        return self._raise_to([word, _APPLY, *bracket], exponent)

    def _raise_to(self, pieces: Sequence[Piece], exponent: int) -> Layout:
        if exponent == 1:
            return Layout(pieces, ATOM)
        return Layout(["<msup>", *_row(pieces), self.number(exponent), "</msup>"], POWER)

    def choice(self, cases: Sequence[tuple[Piece, Piece]], otherwise: Piece) -> Layout:
        pieces: list[Piece] = ["<mrow><mo>{</mo><mtable>"]
        for value, condition in cases:
            pieces += [f"<mtr>{_LEFT}", value, f"</mtd>{_LEFT}<mtext>if </mtext>", condition, "</mtd></mtr>"]
        end = f"</mtd>{_LEFT}<mtext>otherwise</mtext></mtd></mtr></mtable></mrow>"
        return Layout([*pieces, f"<mtr>{_LEFT}", otherwise, end], SUM)


def _row(pieces: Sequence[Piece]) -> list[Piece]:
    return ["<mrow>", *pieces, "</mrow>"]
