"""The two styles that people read: LaTeX, and one line of plain text such as ``m x'' + d x' + k x``."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar, Final

from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.language.caret import shown
from symbody.expr.printing.definitions import EXPAND_LIMIT
from symbody.expr.printing.layout import (
    ATOM,
    CHOICE,
    POWER,
    PRODUCT,
    SUM,
    Brackets,
    Layout,
    Piece,
    joined,
    number_text,
    printed,
    printed_with_definitions,
)
from symbody.expr.printing.textbook import Factor, Style, textbook

# Letters that LaTeX has commands for; Alpha, Beta and the like are Latin capitals there. A parameter
# called pi is not among them: it is not the constant.
_GREEK: Final = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau upsilon phi chi "
    "psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split()
)
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
    return printed(graph, node, textbook(graph, [node], _PLAIN), _PLAIN.brackets)


def to_latex(graph: Graph, node: int, names: Mapping[Symbol, str] | None = None) -> str:
    """Return a node as LaTeX without delimiters; dots are time derivatives.

    Parameters
    ----------
    names : mapping of Symbol to LaTeX, optional
        How symbols are written, derivatives by their dots if not named themselves; taken as it is.
        By default as `latex_name` says.

    Raises
    ------
    ExpressionError
        Above 20,000 operations written out, and for entries of kernels.
    """
    style = _Latex(dict(names or {}))
    return printed(graph, node, textbook(graph, [node], style), style.brackets)


def to_display_with_definitions(
    graph: Graph, nodes: Sequence[int], limit: int = EXPAND_LIMIT
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes as plain text, with shared parts named z1, z2, ... if one exceeds `limit` operations.

    Returns
    -------
    (texts, definitions)
        Definitions are pairs of name and text, each using earlier names only.
    """
    return printed_with_definitions(graph, nodes, textbook(graph, nodes, _PLAIN), limit, str, _PLAIN.brackets)


def to_latex_with_definitions(
    graph: Graph,
    nodes: Sequence[int],
    limit: int = EXPAND_LIMIT,
    names: Mapping[Symbol, str] | None = None,
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes as LaTeX, as `to_display_with_definitions` does as plain text."""
    style = _Latex(dict(names or {}))
    notation = textbook(graph, nodes, style)
    return printed_with_definitions(graph, nodes, notation, limit, latex_name, style.brackets)


def latex_name(name: str) -> str:
    r"""Return a name as LaTeX: Greek letters, indices after ``_`` and of final digits, all else escaped.

    Examples
    --------
    >>> print(latex_name("beta_1"), latex_name("m1"), latex_name("lambda_rod_2"))
    \beta_{1} m_{1} \lambda_{\mathrm{rod},2}
    """
    head, *tail = name.split("_")
    split = re.fullmatch(r"([^\W\d_]+)([0-9]+)", head)
    if split is not None:
        head, tail = split[1], [split[2], *tail]
    if not head or not all(tail):
        return _word(name)
    return _word(head) + (f"_{{{','.join(map(_word, tail))}}}" if tail else "")


def _word(word: str) -> str:
    if word in _GREEK:
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
        return f"{{\\{letter}}}" if letter in _GREEK or letter == "pi" else character
    return character if character.isalnum() else f"{{{character}}}"


@dataclass(frozen=True, slots=True)
class _Plain(Style):
    """One line of text."""

    def symbol(self, symbol: Symbol) -> str:
        return shown(symbol.name) + "'" * symbol.order

    def number(self, value: Constant) -> str:
        return repr(value) if isinstance(value, float) else number_text(value)

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        top, bottom = _with_number(ratio, above, below)
        pieces = joined(self.times, top or [["1"]])
        if len(bottom) == 1:
            pieces += ["/", *bottom[0]]
        elif bottom:
            pieces += ["/(", *joined(self.times, bottom), ")"]
        return Layout(pieces, PRODUCT)

    def power(self, base: Piece, exponent: Piece) -> Layout:
        return Layout([base, "^", _at_least(exponent, ATOM)], POWER)

    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        pieces = [f"{name}(", *joined(", ", [[argument] for argument in arguments]), ")"]
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
        text = repr(value) if isinstance(value, float) else number_text(value)
        mantissa, _, exponent = text.partition("e")
        if not exponent:
            return text
        power = f"10^{{{int(exponent)}}}"
        return power if mantissa == "1" else rf"{mantissa} \cdot {power}"

    def ratio(self, ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]) -> Layout:
        if not below and ratio.denominator != 1 and above:
            number = rf"\frac{{{ratio.numerator}}}{{{ratio.denominator}}}"
            return Layout(joined(self.times, [[number], *above]), PRODUCT)
        top, bottom = _with_number(ratio, above, below)
        pieces = self._line(top or [["1"]])
        if not bottom:
            return Layout(pieces, PRODUCT)
        return Layout([r"\frac{", *pieces, "}{", *self._line(bottom), "}"], POWER)

    def _line(self, factors: Sequence[Factor]) -> list[Piece]:
        """Return a product that stands alone, above or below the line of a fraction or without one."""
        if len(factors) == 1 and len(factors[0]) == 1:
            return [_at_least(factors[0][0], CHOICE)]
        return joined(self.times, factors)

    def power(self, base: Piece, exponent: Piece) -> Layout:
        return Layout([base, "^{", exponent, "}"], POWER)

    def function(self, name: str, arguments: Sequence[Piece], exponent: int = 1) -> Layout:
        listed = joined(", ", [[argument] for argument in arguments])
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


def _with_number(
    ratio: Fraction, above: Sequence[Factor], below: Sequence[Factor]
) -> tuple[list[Factor], list[Factor]]:
    """Return the factors above and below the line with the ratio's numbers in front."""
    top: list[Factor] = [[str(ratio.numerator)]] if ratio.numerator != 1 else []
    bottom: list[Factor] = [[str(ratio.denominator)]] if ratio.denominator != 1 else []
    return [*top, *above], [*bottom, *below]


def _at_least(piece: Piece, strength: int) -> Piece:
    return piece if isinstance(piece, str) else (piece[0], strength)


_PLAIN: Final = _Plain()
