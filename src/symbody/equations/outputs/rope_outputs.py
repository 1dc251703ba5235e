"""Outputs about ropes: their tension, and by how much they are longer than the distance they span."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.solving.ropes import length_of, rope_row, ropes
from symbody.errors import FormulationError, Problem, nearest
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS

Output = tuple[tuple[int, ...], list[Expr]]


def rope_tension(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_tension R": the force with which it pulls; 0 where it is slack."""
    row = _find_row(formed, words)
    if any(row is other for other in formed.slack):
        return (), [number(formed.graph, 0)]
    return (), [-symbol(formed.graph, Symbol(row.name, SymbolKind.MULTIPLIER))]


def rope_slack(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_slack R": its length less the distance of its ends."""
    return (), [-_find_row(formed, words).value]


def rope_slack_rate(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_slack_dot R"."""
    row = _find_row(formed, words)
    total = -row.drift
    for u, slope in row.jacobian.items():
        total = total - slope * Expr(formed.graph, u)
    return (), [total]


def rope_slack_acceleration(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_slack_ddot R"."""
    row = _find_row(formed, words)
    total = row.gamma
    for slope, rate in _terms(formed, row):
        total = total - slope * rate
    return (), [total]


def rope_acceleration_size(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_size R": what cancels in its second rate: its rounding is a share of it."""
    row = _find_row(formed, words)
    total, speed = row.gamma.apply(ABS), number(formed.graph, 0)
    for slope, rate in _terms(formed, row):
        total = total + (slope * rate).apply(ABS)
    for u, slope in row.jacobian.items():
        speed = speed + (slope * Expr(formed.graph, u)).apply(ABS)
    return (), [total + speed**2 / length_of(formed, row)]


def rope_length(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_length R": of the rope itself."""
    return (), [length_of(formed, _find_row(formed, words))]


def _terms(formed: EquationsOfMotion, row: ConstraintEquation) -> list[tuple[Expr, Expr]]:
    """Return the slopes of a row with the accelerations they belong to."""
    graph, zero = formed.graph, number(formed.graph, 0)
    speeds = zip(formed.u, formed.kinematics.speeds, strict=True)
    return [(row.jacobian.get(node, zero), symbol(graph, u.derivative)) for u, node in speeds]


def _find_row(formed: EquationsOfMotion, words: Sequence[str]) -> ConstraintEquation:
    """Return the row of the rope that a name means.

    Raises
    ------
    FormulationError
        If there is none, with the nearest names.
    """
    names, text = ropes(formed), " ".join(words)
    if text in names:
        return rope_row(formed, text)
    what = f"there is no rope {text!r}"
    why = "ropes are constraints of type distance with rope = true"
    raise FormulationError(Problem("equations.unknown_rope", f"rope {text}", what, why, nearest(text, names)))
