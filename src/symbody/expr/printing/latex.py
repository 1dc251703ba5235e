"""The two styles that people read: LaTeX, and one line of plain text such as ``m x'' + d x' + k x``."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar, Final

from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.language.caret import printable
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.printing.layout import (
    ATOM,
    POWER,
    PRODUCT,
    SUM,
    Brackets,
    Layout,
    Piece,
    bind_tightly,
    join_pieces,
    print_node,
    printed_with_definitions,
)
from symbody.expr.printing.names import GREEK, name_words
from symbody.expr.printing.numerals import ALL_DIGITS, Numerals
from symbody.expr.printing.textbook import Factor, Style, textbook

_NAMES: Final[Mapping[str, str]] = {
    **{name: rf"\{name}" for name in "sin cos tan sinh cosh tanh exp log min max".split()},
    "asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "sign": r"\operatorname{sgn}",
}  # fmt: skip
_AROUND: Final[Mapping[str, tuple[str, str]]] = {
    "abs": (r"\left|", r"\right|"), "floor": (r"\left\lfloor ", r" \right\rfloor"), "sqrt": (r"\sqrt{", "}"),
}  # fmt: skip
_POWER_OF_NAME: Final = frozenset("sin cos tan sinh cosh tanh".split())
_ESCAPES: Final[Mapping[str, str]] = {
    "\\": r"{\backslash}", "^": r"{\wedge}", "~": r"{\sim}", "'": r"{\prime}", " ": r"\ ",
    **{c: rf"\{c}" for c in "{}$&#%_"},
}  # fmt: skip


def to_display(graph: Graph, node: int) -> str:
    """Return a node as one line of plain text; primes are time derivatives, blanks are products.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, and for entries of kernels.
    """
    return print_node(graph, node, textbook(graph, [node], _PLAIN), _PLAIN.brackets)


def to_latex(graph: Graph, node: int, names: Mapping[Symbol, str] | None = None) -> str:
    """Return a node as LaTeX without delimiters; dots are time derivatives.

    Parameters
    ----------
    names : mapping of Symbol to LaTeX, optional
        How symbols are written, derivatives by their dots if not named themselves; taken as it is.
        `latex_name` by default.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, and for entries of kernels.
    """
    style = _Latex(names=dict(names or {}))
    return print_node(graph, node, textbook(graph, [node], style), style.brackets)


def to_inline_latex(graph: Graph, node: int, names: Mapping[Symbol, str] | None = None) -> str:
    """Return a node as LaTeX of the height of a line, quotients with a slash: for the labels of pictures.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, and for entries of kernels.
    """
    style = _InlineLatex(names=dict(names or {}))
    return print_node(graph, node, textbook(graph, [node], style), style.brackets)


def to_display_with_definitions(
    graph: Graph,
    nodes: Sequence[int],
    limit: int = EXPAND_LIMIT,
    numerals: Numerals = ALL_DIGITS,
    leading: Mapping[int, int] | None = None,
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes as plain text, with shared parts named z1, z2, ... if one exceeds `limit` operations.

    Parameters
    ----------
    numerals : Numerals
        How many digits numbers have.
    leading : mapping of node to node, optional
        The symbol whose terms come first in a sum.

    Returns
    -------
    (texts, definitions)
        Definitions are pairs of name and text, each using earlier names only.
    """
    notation = textbook(graph, nodes, _Plain(numerals=numerals), leading)
    return printed_with_definitions(graph, nodes, notation, limit, str, _PLAIN.brackets)


def to_latex_with_definitions(
    graph: Graph,
    nodes: Sequence[int],
    limit: int = EXPAND_LIMIT,
    numerals: Numerals = ALL_DIGITS,
    leading: Mapping[int, int] | None = None,
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes as LaTeX, as `to_display_with_definitions` does as plain text."""
    style = _Latex(numerals=numerals)
    notation = textbook(graph, nodes, style, leading)
    return printed_with_definitions(graph, nodes, notation, limit, latex_name, style.brackets)


def latex_name(name: str) -> str:
    r"""Return a name as LaTeX: Greek letters, indices after ``_`` and of final digits, all else escaped.

    Examples
    --------
    >>> print(latex_name("beta_1"), latex_name("m1"), latex_name("lambda_rod_2"))
    \beta_{1} m_{1} \lambda_{\mathrm{rod},2}
    """
    head, *indices = name_words(name)
    return _word(head) + (f"_{{{','.join(map(_word, indices))}}}" if indices else "")


def _word(word: str) -> str:
    if word in GREEK:
        return f"\\{word}"
    text = "".join(map(_character, word))
    return text if len(word) <= 1 or (word.isascii() and word.isdigit()) else rf"\mathrm{{{text}}}"


def _character(character: str) -> str:
    """Return one character of a name as LaTeX that cannot mean anything else."""
    if character.isascii() and character.isalnum():
        return character
    if character in _ESCAPES:
        return _ESCAPES[character]
    if not character.isprintable():
        return f"{{U{ord(character):04X}}}"
    words = unicodedata.name(character, "").split()
    if words[:1] == ["GREEK"] and words[2:3] == ["LETTER"] and len(words) == 4:
        letter = words[3].lower() if words[1] == "SMALL" else words[3].capitalize()
        letter = letter.replace("lamda", "lambda").replace("Lamda", "Lambda")
        return f"{{\\{letter}}}" if letter in GREEK or letter == "pi" else character
    return character if character.isalnum() else f"{{{character}}}"


@dataclass(frozen=True, slots=True)
class _Plain(Style):
    """One line of text."""

    def symbol(self, symbol: Symbol) -> str:
        return printable(symbol.name) + "'" * symbol.order

    def number(self, value: Constant) -> str:
        return self.numerals.text(value)

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        return self.inline_quotient(ratio, above, below)

    def power(self, base: Piece, exponent: Piece) -> Layout:
        return Layout([base, "^", bind_tightly(exponent, ATOM)], POWER)

    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        pieces = [f"{name}(", *join_pieces(", ", [[argument] for argument in arguments]), ")"]
        return Layout(pieces, ATOM) if exponent == 1 else Layout([*pieces, f"^{exponent}"], POWER)

    def choice(self, cases: Sequence[tuple[Piece, Piece]], otherwise: Piece) -> Layout:
        pieces: list[Piece] = []
        for value, condition in cases:
            pieces += ["if(", condition, ", ", value, ", "]
        return Layout([*pieces, otherwise, ")" * len(cases)], ATOM)


@dataclass(frozen=True, slots=True)
class _Latex(Style):
    """LaTeX for the mathematical mode of LaTeX, KaTeX and MathJax."""

    names: Mapping[Symbol, str] = field(default_factory=dict)
    brackets: ClassVar[Brackets] = Brackets(r"\left(", r"\right)")
    times: ClassVar[str] = r" \, "
    pi: ClassVar[str] = r"\pi"
    relations: ClassVar[Sequence[str]] = ("<", ">", r"\le", r"\ge", "=", r"\ne", r"\wedge", r"\vee", r"\neg ")

    def symbol(self, symbol: Symbol) -> str:
        if symbol in self.names:
            return self.names[symbol]
        base = self.names.get(Symbol(symbol.name, symbol.kind)) or latex_name(symbol.name)
        if symbol.order == 0:
            return base
        if symbol.order <= 4:
            return rf"\{'d' * symbol.order}ot{{{base}}}"
        return rf"{{{base}^{{({symbol.order})}}}}"

    def number(self, value: Constant) -> str:
        text = self.numerals.text(value)
        mantissa, _, exponent = text.partition("e")
        if not exponent:
            return text
        power = f"10^{{{int(exponent)}}}"
        return power if mantissa == "1" else rf"{mantissa} \cdot {power}"

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        if not below and ratio.denominator != 1 and above:
            number = rf"\frac{{{ratio.numerator}}}{{{ratio.denominator}}}"
            return Layout(join_pieces(self.times, [[number], *above]), PRODUCT)
        top, bottom = self.with_number(ratio, above, below)
        pieces = self.line(top or [["1"]])
        if not bottom:
            return Layout(pieces, PRODUCT)
        return Layout([r"\frac{", *pieces, "}{", *self.line(bottom), "}"], POWER)

    def power(self, base: Piece, exponent: Piece) -> Layout:
        return Layout([base, "^{", exponent, "}"], POWER)

    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        listed = join_pieces(", ", [[argument] for argument in arguments])
        power = "" if exponent == 1 else f"^{{{exponent}}}"
        if name in _AROUND:
            before, after = _AROUND[name]
            return Layout([before, *listed, after + power], POWER if power else ATOM)
        written = _NAMES.get(name) or rf"\operatorname{{{''.join(map(_character, name))}}}"
        if name in _POWER_OF_NAME:
            return Layout([rf"{written}{power}\left(", *listed, r"\right)"], POWER if power else ATOM)
        return Layout([rf"{written}\left(", *listed, rf"\right){power}"], POWER if power else ATOM)

    def choice(self, cases: Sequence[tuple[Piece, Piece]], otherwise: Piece) -> Layout:
        pieces: list[Piece] = [r"\begin{cases} "]
        for value, condition in cases:
            pieces += [value, r" & \text{if}\ ", condition, r" \\ "]
        return Layout([*pieces, otherwise, r" & \text{otherwise} \end{cases}"], SUM)


@dataclass(frozen=True, slots=True)
class _InlineLatex(_Latex):
    """LaTeX without fractions; dots stand over the letter alone, since simple readers centre them."""

    def symbol(self, symbol: Symbol) -> str:
        head, *indices = name_words(symbol.name)
        if symbol.order == 0 or not indices or any(known.name == symbol.name for known in self.names):
            return _Latex.symbol(self, symbol)
        below = latex_name(symbol.name).removeprefix(latex_name(head))
        return _Latex.symbol(self, Symbol(head, symbol.kind, symbol.order)) + below

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        return self.inline_quotient(ratio, above, below)


_PLAIN: Final = _Plain()
