"""Formulas as text, whatever the notation: from the root inwards, in time linear in the text.

A notation splits one node into its pieces; brackets, names of shared parts and the order
of writing are dealt with here, without recursion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import Final, NamedTuple, TypeAlias

from symbody.errors import ExpressionError, Problem
from symbody.expr.graph import Constant, Graph
from symbody.expr.language.literals import EXACT_DIGITS
from symbody.expr.printing.definitions import EXPAND_LIMIT, definitions
from symbody.expr.rewrite import tree_size

# How tightly a piece of text binds, weakest first.
CHOICE, BOTH, NEGATION, COMPARISON, SUM, PRODUCT, POWER, ATOM = range(8)

# Text, or a node and how tightly its text has to bind in this place.
Piece: TypeAlias = str | tuple[int, int]


class Layout(NamedTuple):
    """What a node looks like, its operands left open; `strength` is how tightly it binds."""

    pieces: Sequence[Piece]
    strength: int


Notation: TypeAlias = Callable[[int], Layout]
NotationFor: TypeAlias = Callable[[Mapping[int, str]], Notation]


class Brackets(NamedTuple):
    """What is put around a piece that binds too weakly."""

    opening: str
    closing: str


ROUND: Final = Brackets("(", ")")


def print_node(graph: Graph, node: int, notation: NotationFor, brackets: Brackets = ROUND) -> str:
    """Return a node written out.

    Raises
    ------
    ExpressionError
        Above `EXPAND_LIMIT` operations.
    """
    size = tree_size(graph, node)
    if size > EXPAND_LIMIT:
        raise ExpressionError(
            Problem(
                "expression.too_long", "", f"written out the formula has {_rough(size)} operations",
                f"printed formulas are limited to {EXPAND_LIMIT}, because shared parts are written "
                f"repeatedly",
                "print the form with definitions z1, z2, ..., or generate code",
            )
        )  # fmt: skip
    return _write_pieces(node, {}, notation({}), brackets)


def printed_with_definitions(
    graph: Graph,
    nodes: Sequence[int],
    notation: NotationFor,
    limit: int,
    write_name: Callable[[str], str] = str,
    brackets: Brackets = ROUND,
) -> tuple[list[str], list[tuple[str, str]]]:
    """Return nodes with shared parts named where one of them would exceed `limit` operations.

    Returns
    -------
    (texts, definitions)
        Definitions are pairs of name and text, each using earlier names only.
    """
    named = {node: write_name(name) for node, name in definitions(graph, nodes, limit).items()}
    layout = notation(named)
    defined = [(name, _write_pieces(node, named, layout, brackets)) for node, name in named.items()]
    return [named.get(node) or _write_pieces(node, named, layout, brackets) for node in nodes], defined


def join_pieces(separator: str, groups: Sequence[Sequence[Piece]]) -> list[Piece]:
    """Return all pieces of `groups`, with a separator between each two groups."""
    pieces: list[Piece] = []
    for group in groups:
        pieces += [separator, *group] if pieces else group
    return pieces


def bind_tightly(piece: Piece, strength: int) -> Piece:
    """Return a piece whose text, if it is a node's, has to bind as tightly as `strength`."""
    return piece if isinstance(piece, str) else (piece[0], strength)


def no_formula() -> ExpressionError:
    """Return the error for entries of kernels."""
    return ExpressionError(
        Problem(
            "expression.no_formula", "", "an entry of solve_saddle has no formula",
            "systems with loops are solved numerically with pivoting", "generate code instead",
        )
    )  # fmt: skip


def number_text(value: Constant) -> str:
    """Return a constant as the language writes it: ``3/4``, ``9.81``, rounded ones with 17 digits.

    An exact number is a decimal if it ends within 15 digits, halves to eighths excepted. Reading it
    gives the same constant, except for a rounded zero, which reads as the exact one.
    """
    if isinstance(value, float):
        return format(value, "#.17g") if value else str(value)
    exact = Fraction(value)
    if exact.denominator < 10:
        return str(exact)
    return _decimal(exact) or str(exact)


def _decimal(value: Fraction) -> str | None:
    rest, twos, fives = value.denominator, 0, 0
    while rest % 2 == 0:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    places = max(twos, fives)
    digits = str(abs(value.numerator) * 10**places // value.denominator)
    if rest != 1 or len(digits) > EXACT_DIGITS:
        return None
    sign = "-" if value < 0 else ""
    exponent = len(digits) - 1 - places
    if exponent < -5:
        point = "." if len(digits) > 1 else ""
        return f"{sign}{digits[0]}{point}{digits[1:]}e{exponent}"
    digits = digits.rjust(places + 1, "0")
    return f"{sign}{digits[:-places]}.{digits[-places:]}"


def _write_pieces(root: int, named: Mapping[int, str], notation: Notation, brackets: Brackets) -> str:
    out: list[str] = []
    stack: list[Piece] = list(reversed(notation(root).pieces))
    while stack:
        piece = stack.pop()
        if isinstance(piece, str):
            out.append(piece)
            continue
        node, strength = piece
        if node in named:
            out.append(named[node])
            continue
        layout = notation(node)
        if layout.strength < strength:
            out.append(brackets.opening)
            stack.append(brackets.closing)
        stack.extend(reversed(layout.pieces))
    return "".join(out)


def _rough(size: int) -> str:
    return str(size) if size < 10**15 else f"about 2**{size.bit_length() - 1}"
