"""Agreement of what is read with what is computed, checked whenever something is shown.

Formulas are the computed roots rewritten, so a difference is a fault of the rewriting. Mass matrix and
forcing may come from other recursions than the accelerations and inverse dynamics; these are compared too.

Equal fingerprints mean equal functions. Different ones do not always mean different functions, because roots,
kernels and rounded constants are opaque to them, and quaternions have norm 1; there, numbers at random points
decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from random import Random
from typing import Final, NamedTuple

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.slopes import inverse_dynamics
from symbody.equations.solving.solution import solve
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.expr.opcodes import CALL
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.written_function import write_out

# Random points at which numbers are compared, and the relative difference that rounding may reach there.
_POINTS: Final = 3
_ROUNDING: Final = 1e-6


class _Pair(NamedTuple):
    """Two nodes that should be the same function, and the place of the entry they belong to."""

    place: str
    computed: int
    shown: int


def check_rewriting(
    formed: EquationsOfMotion, name: str, computed: Sequence[int], shown: Sequence[int]
) -> None:
    """Raise if formulas are not the functions that are computed.

    Parameters
    ----------
    name : str
        The output.
    computed, shown : sequence of int
        Roots as they are compiled, and as they are shown; curves shown by name are compared by their pieces.

    Raises
    ------
    FormulationError
        If a formula is another function than its root.
    """
    entries = zip(computed, write_out(formed.graph, shown), strict=True)
    _check(formed, [_Pair(f"{name}[{k}]", a, b) for k, (a, b) in enumerate(entries)])


def check_dynamics(formed: EquationsOfMotion) -> None:
    """Raise if mass matrix and forcing do not belong to the accelerations and the inverse dynamics computed.

    With friction nothing is compared: the forcing contains unknown efforts then. With constraints the solver
    of the system takes M, F, J and gamma as they are shown, and only the inverse dynamics are compared.

    Raises
    ------
    FormulationError
        If ``M u' - F`` is not the inverse dynamics, or ``M u'`` of the accelerations is not F.
    """
    if formed.friction:
        return
    given = formed.expressions([u.derivative for u in formed.u])
    balance = zip(_products(formed, given), formed.dynamics.forcing, strict=True)
    sides = zip(inverse_dynamics(formed), balance, strict=True)
    pairs = [_Pair("inverse_dynamics", a.index, (b - force).index) for a, (b, force) in sides]
    _check(formed, pairs)
    if formed.rows:
        return
    try:
        udot, _ = solve(formed)
    except FormulationError:
        return  # no mass resists some speed, which has no acceleration
    solved = zip(_products(formed, udot), formed.dynamics.forcing, strict=True)
    _check(formed, [_Pair("udot", a.index, force.index) for a, force in solved])


def _products(formed: EquationsOfMotion, udot: Sequence[Expr]) -> list[Expr]:
    """Return ``M u'``."""
    zero = Expr(formed.graph, 0)
    rows = formed.dynamics.mass_matrix
    return [sum((a * b for a, b in zip(row, udot, strict=True)), zero) for row in rows]


def _check(formed: EquationsOfMotion, pairs: Sequence[_Pair]) -> None:
    graph = formed.graph
    pairs = [pair for pair in pairs if pair.computed != pair.shown]
    nodes = graph.reachable([node for pair in pairs for node in (pair.computed, pair.shown)])
    values = fingerprints(graph, list(nodes))
    doubtful = [pair for pair in pairs if values[pair.computed] != values[pair.shown]]
    different = list(_numerically_different(formed, doubtful))
    if different:
        what = "the formulas shown differ from the functions that are computed"
        why = "this is a bug in symbody, not a fault of the model"
        fix = "report it with the model; another formulation may work in the meantime"
        raise FormulationError(Problem("equations.views_differ", different[0].place, what, why, fix))


def _numerically_different(formed: EquationsOfMotion, pairs: Sequence[_Pair]) -> Iterator[_Pair]:
    """Return the pairs whose values differ by more than rounding at each of several random points."""
    graph, nodes = formed.graph, [node for pair in pairs for node in (pair.computed, pair.shown)]
    if not nodes or any(graph.ops[node] == CALL for node in graph.reachable(nodes)):
        return  # functions of a user's own are not called before anything is computed
    symbols = symbols_of(graph, nodes)
    places = {node: Input(str(k), "x", k) for k, node in enumerate(symbols)}
    program = build_sequence(
        graph, [Roots("", (len(nodes),), tuple(nodes))], places, merge=False, contract=False
    )
    random = Random(7)
    points = [_random_point(formed, symbols, random) for _ in range(_POINTS)]
    values = [evaluate_sequence(program, {"x": point})[0] for point in points]
    for k, pair in enumerate(pairs):
        differences = [
            abs(entries[2 * k] - entries[2 * k + 1]) > _ROUNDING * (1 + abs(entries[2 * k]))
            for entries in values
        ]
        if all(differences):  # not where a value is not a number
            yield pair


def _random_point(formed: EquationsOfMotion, symbols: Sequence[int], random: Random) -> list[float]:
    """Return a number for each symbol; quaternions have norm 1, without which rotations are none."""
    values = {node: random.uniform(0.3, 1.3) for node in symbols}
    for quaternion in formed.variables.quaternions:
        entries = [values.setdefault(node, random.uniform(0.3, 1.3)) for node in quaternion]
        norm = sum(x * x for x in entries) ** 0.5
        values |= {node: x / norm for node, x in zip(quaternion, entries, strict=True)}
    return [values[node] for node in symbols]
