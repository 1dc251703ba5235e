"""The two styles people read: LaTeX, and one line of plain text such as ``m x'' + d x' + k x``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from symbody.expr.graph import Constant, Graph, Symbol
from symbody.expr.printing import ATOM, POWER, PRODUCT, Shown, Style, bracketed, show
from symbody.expr.text import number_text

_GREEK: Final = frozenset(
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi "
    "psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega".split()
)
_LATEX_NAMES: Final = frozenset("sin cos tan sinh cosh tanh exp log min max".split())
_RELATIONS: Final = {"lt": "<", "le": "<=", "eq": "==", "and": "and", "or": "or"}
_LATEX_RELATIONS: Final = {"lt": "<", "le": r"\le", "eq": "=", "and": r"\wedge", "or": r"\vee"}
_SPECIAL: Final = {"\\": r"\backslash ", "{": r"\{", "}": r"\}", "^": r"\hat{\ }", "~": r"\sim "}


def to_display(graph: Graph, node: int) -> str:
    """Return a node as one line of plain text; primes are time derivatives."""
    return show(graph, node, _PLAIN)


def to_latex(graph: Graph, node: int, names: Mapping[Symbol, str] | None = None) -> str:
    """Return a node as LaTeX without delimiters; dots are time derivatives.

    Parameters
    ----------
    names : mapping of Symbol to LaTeX, optional
        How underived symbols are written; by default ``beta_1`` is a Greek letter with an index.
    """
    return show(graph, node, replace(_LATEX, symbol=partial(_latex_symbol, names or {})))


def latex_name(name: str) -> str:
    r"""Return a name as LaTeX: Greek letters, digits and parts after ``_`` as index; all else escaped.

    >>> latex_name("beta_1"), latex_name("m1")
    ('\\beta_{1}', 'm_{1}')
    """
    head, *tail = name.split("_")
    split = re.fullmatch(r"([A-Za-z]+)(\d+)", head)
    if split and not tail:
        head, tail = split.group(1), [split.group(2)]
    index = ",".join(_latex_word(part) for part in tail if part)
    return f"{_latex_word(head)}_{{{index}}}" if index else _latex_word(head)


def _latex_word(word: str) -> str:
    if word in _GREEK:
        return f"\\{word}"
    text = _escaped(word)
    return text if len(word) <= 1 or word.isdigit() else rf"\mathrm{{{text}}}"


def _escaped(word: str) -> str:
    return "".join(_SPECIAL.get(c, f"\\{c}" if c in "$&#%_" else c) for c in word)


def _latex_symbol(names: Mapping[Symbol, str], symbol: Symbol) -> str:
    base = names.get(Symbol(symbol.name, symbol.kind)) or latex_name(symbol.name)
    if symbol.order == 0:
        return base
    if symbol.order <= 4:
        return rf"\{'d' * symbol.order}ot{{{base}}}"
    return rf"{base}^{{({symbol.order})}}"


def _plain_power(base: Shown, exponent: Shown) -> Shown:
    text = f"{bracketed(base, ATOM, _PLAIN)}^{bracketed(exponent, ATOM, _PLAIN)}"
    return Shown(text, POWER, base.order, max(base.rank, 1))


def _plain_fraction(top: Shown, bottom: Shown) -> Shown:
    text = f"{bracketed(top, PRODUCT, _PLAIN)}/{bracketed(bottom, POWER, _PLAIN)}"
    return Shown(text, PRODUCT, max(top.order, bottom.order), 3)


def _plain_condition(relation: str, parts: Sequence[str]) -> str:
    return f"not ({parts[0]})" if relation == "not" else f" {_RELATIONS[relation]} ".join(parts)


def _latex_power(base: Shown, exponent: Shown) -> Shown:
    text = f"{bracketed(base, ATOM, _LATEX)}^{{{exponent.text}}}"
    return Shown(text, POWER, base.order, max(base.rank, 1))


def _latex_number(value: Constant) -> str:
    text = number_text(value)
    top, slash, bottom = text.partition("/")
    mantissa, e, exponent = text.partition("e")
    if slash:
        return rf"\frac{{{top}}}{{{bottom}}}"
    return rf"{float(mantissa):g} \cdot 10^{{{int(exponent)}}}" if e else text


def _latex_function(name: str, parts: Sequence[str]) -> str:
    if name == "abs":
        return rf"\left|{parts[0]}\right|"
    if name == "floor":
        return rf"\left\lfloor {parts[0]} \right\rfloor"
    written = f"\\{name}" if name in _LATEX_NAMES else rf"\operatorname{{{_escaped(name)}}}"
    return rf"{written}\left({', '.join(parts)}\right)"


def _latex_condition(relation: str, parts: Sequence[str]) -> str:
    return rf"\neg ({parts[0]})" if relation == "not" else f" {_LATEX_RELATIONS[relation]} ".join(parts)


_PLAIN: Final = Style(
    symbol=lambda symbol: symbol.name + "'" * symbol.order,
    number=number_text,
    pi="pi",
    product=" ",
    fraction=_plain_fraction,
    power=_plain_power,
    root=lambda part: Shown(f"sqrt({part.text})", ATOM, part.order, 3),
    function=lambda name, parts: f"{name}({', '.join(parts)})",
    condition=_plain_condition,
    choice=lambda condition, a, b: f"if({condition}, {a}, {b})",
    brackets=lambda text: f"({text})",
)

_LATEX: Final = Style(
    symbol=partial(_latex_symbol, {}),
    number=_latex_number,
    pi=r"\pi",
    product=r" \, ",
    fraction=lambda a, b: Shown(rf"\frac{{{a.text}}}{{{b.text}}}", POWER, max(a.order, b.order), 3),
    power=_latex_power,
    root=lambda part: Shown(rf"\sqrt{{{part.text}}}", ATOM, part.order, 3),
    function=_latex_function,
    condition=_latex_condition,
    choice=lambda condition, a, b: (
        rf"\begin{{cases}} {a} & \text{{if }} {condition} \\ {b} & \text{{otherwise}} \end{{cases}}"
    ),
    brackets=lambda text: rf"\left({text}\right)",
)
