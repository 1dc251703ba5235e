"""Names of outputs as people read them: Greek letters, indices, dots, and units."""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Final

from matplotlib.mathtext import MathTextParser

from symbody.errors import ExpressionError
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.language.formula import Formula, build
from symbody.expr.printing.latex import latex_name, to_inline_latex

# Outputs that are words.
_WORDS: Final = frozenset(
    "time energy kinetic_energy potential_energy work power constraint_violation velocity_violation".split()
)
_KINDS: Final = {
    "r": "r", "v": "v", "vdot": r"\dot{v}", "w": r"\omega", "wdot": r"\dot{\omega}", "R": "R",
}  # fmt: skip
_FRAME: Final = re.compile(r"(?:frame )?(r|vdot|v|wdot|w|R) (.+?)(?: ([xyz]{1,2}))?")
_WRENCH: Final = re.compile(r"reaction (.+) ([FM])([xyz])")
# Of what stands in a row, apart from formulas.
_PHRASE: Final = re.compile(r"(friction|friction_\w+|rope_\w+|effort|length|angle|reaction) .+")
_POWERS: Final = {"^2": "\u00b2", "^3": "\u00b3", "^4": "\u2074"}
_LONGEST: Final = 80  # letters of an expression that is set as a formula


def readable(name: str, states: Collection[str] = ()) -> str:
    r"""Return the name of an output or an expression for matplotlib, formulas between dollar signs.

    Parameters
    ----------
    states : collection of str
        Coordinates and speeds, which stand behind parameters in a product.

    Examples
    --------
    >>> print(readable("theta_1_ddot"), readable("reaction pin Fx"), readable("kinetic_energy"))
    $\ddot{\theta}_{1}$ reaction pin $F_{x}$ kinetic energy
    """
    if name in _WORDS:
        return name.replace("_", " ")
    wrench = _WRENCH.fullmatch(name)
    if wrench is not None:
        return f"reaction {plain(wrench[1])} ${wrench[2]}_{{{wrench[3]}}}$"
    if _PHRASE.fullmatch(name):
        first, _, rest = name.partition(" ")
        return plain(f"{first.replace('_', ' ')} {rest}")
    frame = _FRAME.fullmatch(name)
    if frame is not None:
        return _frame_label(*frame.groups())
    return _formula(name, states) or plain(name)


def _frame_label(kind: str, place: str, component: str | None) -> str:
    if component is None and kind == "r":
        return plain(place)
    index = f"_{{{component}}}" if component else ""
    return f"{plain(place)} ${_KINDS[kind]}{index}$"


def _formula(text: str, states: Collection[str]) -> str:
    """Return an expression as a formula, or nothing where it is none, or too long."""
    if len(text) > _LONGEST:
        return ""
    graph = Graph()
    names: dict[Symbol, str] = {}

    def symbol(name: str, column: int) -> int:
        if name == "pi":
            return graph.pi()
        base, order = _split_name(name)
        kind = SymbolKind.COORDINATE if order or name in states else SymbolKind.PARAMETER
        return graph.symbol(Symbol(base, kind, order))

    def output(name: str, column: int) -> int:
        named = Symbol(name, SymbolKind.INPUT)
        names[named] = _quoted_symbol(name)
        return graph.symbol(named)

    try:
        node = build(Formula.from_value(text, has_outputs=True), graph, symbol, outputs=output)
        label = f"${to_inline_latex(graph, node, names)}$"
        MathTextParser("path").parse(label)
    except (ExpressionError, ValueError):  # no expression, or more than mathtext has
        return ""
    return label


def _split_name(name: str) -> tuple[str, int]:
    for ending, order in (("_ddot", 2), ("_dot", 1)):
        if name.endswith(ending) and len(name) > len(ending):
            return name.removesuffix(ending), order
    return name, 0


def _quoted_symbol(name: str) -> str:
    """Return an output within a formula, as a symbol with indices."""
    wrench = _WRENCH.fullmatch(name)
    if wrench is not None:
        return rf"{wrench[2]}_{{{latex_name(wrench[1])},{wrench[3]}}}"
    frame = _FRAME.fullmatch(name)
    if frame is not None:
        kind, place, component = frame.groups()
        place = re.sub(r" ground\b", "", place)
        return rf"{_KINDS[kind]}_{{{latex_name(place)}{',' + component if component else ''}}}"
    return latex_name(name.replace("_", " ")) if " " in name or name in _WORDS else latex_name(name)


def plain(text: str) -> str:
    """Return text that matplotlib prints as it is, not as mathematics."""
    return text.replace("\\$", "$").replace("$", r"\$")


def printed_length(text: str) -> int:
    """Return about how many letters a label takes, formulas counted without their commands."""
    formulas = re.sub(r"\\(?:d*ot|left|right|mathrm|operatorname|,)(?![a-z])|[{}$^_]", "", text)
    return len(re.sub(r"\\[A-Za-z]+", "w", formulas))


def shown_unit(unit: str) -> str:
    """Return a unit with raised powers."""
    for typed, raised in _POWERS.items():
        unit = re.sub(re.escape(typed) + r"(?!\d)", raised, unit)
    return unit


def typed_unit(unit: str) -> str:
    """Return a unit as it is typed: the reverse of `shown_unit`."""
    for typed, raised in _POWERS.items():
        unit = unit.replace(raised, typed)
    return unit
