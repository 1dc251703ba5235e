"""Degrees of freedom: speeds less independent constraints, counted where the mechanism is assembled.

The rank of J is not that of its formulas: a loop that only just fits moves although a count of its rows
says otherwise (Bennett, Bricard). So it is taken at configurations on which all constraints hold, found by
Newton steps of least length from several starts; that at most of them is the generic one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from typing import Final

from symbody.equations.formed import Formed
from symbody.equations.showing.outputs import output_roots
from symbody.equations.solving.idle import check_idle
from symbody.equations.solving.noise import without_noise
from symbody.errors import AssemblyError, Problem
from symbody.expr.evaluate import evaluate_sequence
from symbody.expr.saddle import solve_saddle
from symbody.expr.sequence import Input, build_sequence
from symbody.expr.sequence import Sequence as Program
from symbody.model.model import resolve_parameters

_STARTS: Final = 8
_STEPS: Final = 60
_CLOSED: Final = 1e-10  # of the size of the mechanism
# Between the rounding left by assembly (1e-10) and what a pose one twentieth of a radian off leaves.
_RANK_CUT: Final = 1e-6
_SPREAD: Final = 0.3  # of starts about the initial values, in rad and in the mechanism's own length


def degrees_of_freedom(formed: Formed) -> int:
    """Return the number of independent speeds at a generic assembled configuration.

    Raises
    ------
    AssemblyError
        If the loops close from no start.
    ModelError
        If a parameter has no value.
    """
    return len(formed.u) - (_generic(formed)[0] if formed.rows else 0)


def independent_speeds(formed: Formed) -> tuple[int, ...]:
    """Return which speeds determine all others at a generic configuration, the earliest possible."""
    n = len(formed.u)
    if not formed.rows:
        return tuple(range(n))
    _, slopes = _generic(formed)
    basis: list[list[float]] = []
    dependent = set()
    for k in reversed(range(n)):
        column = slopes[k::n]
        size = math.sqrt(sum(x * x for x in column))
        for _ in range(2):
            for unit in basis:
                share = sum(x * y for x, y in zip(unit, column, strict=True))
                column = [x - share * y for x, y in zip(column, unit, strict=True)]
        rest = math.sqrt(sum(x * x for x in column))
        if rest > _RANK_CUT * size:
            basis.append([x / rest for x in column])
            dependent.add(k)
    return tuple(k for k in range(n) if k not in dependent)


def _generic(formed: Formed) -> tuple[int, list[float]]:
    """Return the rank that J has at most assembled configurations, and J at one of them.

    Raises
    ------
    AssemblyError
        If the loops close from no start.
    """
    resolved = {name: float(value) for name, value in resolve_parameters(formed.topology.model).items()}
    check_idle(formed, resolved)
    formed = without_noise(formed, resolved)
    program = _program(formed)
    values = [resolved[symbol.name] for symbol in formed.parameters]
    start, random = _start(formed), Random(1)
    found: list[tuple[int, list[float]]] = []
    for k in range(_STARTS):
        guess = [x + (random.uniform(-_SPREAD, _SPREAD) if k else 0.0) for x in start]
        q = _assembled(formed, program, values, guess)
        if q is not None:
            slopes = _values(formed, program, values, q)[2]
            found.append((_rank(formed, slopes), slopes))
    if found:
        ranks = [rank for rank, _ in found]
        generic = max(sorted(set(ranks)), key=ranks.count)
        return next(pair for pair in found if pair[0] == generic)
    raise _open(formed)


def assembled_values(formed: Formed, outputs: Sequence[str]) -> list[list[list[float]]]:
    """Return outputs that depend on positions alone at assembled configurations, near the start and far away.

    Raises
    ------
    AssemblyError
        If the loops close from no start.
    """
    resolved = {name: float(value) for name, value in resolve_parameters(formed.topology.model).items()}
    formed = without_noise(formed, resolved)
    closing, program = _program(formed), _program(formed, outputs)
    values = [resolved[symbol.name] for symbol in formed.parameters]
    start, random = _start(formed), Random(1)
    found = []
    for k in range(2 * _STARTS):
        spread = 0.0 if k == 0 else _SPREAD if k < _STARTS else math.pi
        q = _assembled(formed, closing, values, [x + random.uniform(-spread, spread) for x in start])
        if q is not None:
            found.append(_values(formed, program, values, q))
    if not found:
        raise _open(formed)
    return found


def _open(formed: Formed) -> AssemblyError:
    return AssemblyError(
        Problem("equations.not_assembled", formed.topology.model.name,
                "the degrees of freedom cannot be counted, because the loops close from none of the starts",
                f"{_STARTS} starts about the initial values were tried",
                "check lengths, or give [initial] values near a configuration that closes")
    )  # fmt: skip


def _program(
    formed: Formed, names: Sequence[str] = ("constraints", "position_jacobian", "jacobian")
) -> Program:
    graph = formed.graph
    places = {graph.symbol(q): Input(q.label, "q", k) for k, q in enumerate(formed.q)}
    places |= {graph.symbol(p): Input(p.name, "p", k) for k, p in enumerate(formed.parameters)}
    places |= {graph.symbol(r): Input(r.name, "r", k) for k, r in enumerate(formed.inputs)}
    places[formed.names.value("t").index] = Input("t", "t", 0)
    return build_sequence(graph, [output_roots(formed, name) for name in names], places)


def _start(formed: Formed) -> list[float]:
    """Return the initial values of the model, as far as they are numbers, and small numbers otherwise."""
    initial = formed.topology.model.initial
    given = {name: formula.constant() for name, formula in initial.items()}
    random = Random(0)
    start = [
        random.uniform(0.1, 0.4) if given.get(q.name) is None else float(given[q.name] or 0) for q in formed.q
    ]
    place = {formed.graph.symbol(q): k for k, q in enumerate(formed.q)}
    for quaternion in formed.variables.quaternions:
        start[place[quaternion[0]]] += 1.0
    return start


def _values(
    formed: Formed, program: Program, parameters: Sequence[float], q: Sequence[float]
) -> list[list[float]]:
    inputs = {"q": list(q), "p": list(parameters), "r": [0.0] * len(formed.inputs), "t": [0.0]}
    return [[float(x) for x in values] for values in evaluate_sequence(program, inputs)]


def _assembled(
    formed: Formed, program: Program, parameters: Sequence[float], guess: Sequence[float]
) -> list[float] | None:
    """Return coordinates near a guess on which all constraints hold, or None."""
    n = len(guess)
    unit = [float(i == j) for i in range(n) for j in range(n)]
    q = list(guess)
    place = {formed.graph.symbol(symbol): k for k, symbol in enumerate(formed.q)}
    norms = [[place[node] for node in quaternion] for quaternion in formed.variables.quaternions]
    for _ in range(_STEPS):
        phi, slopes, _ = _values(formed, program, parameters, q)
        for places in norms:
            phi.append((sum(q[k] ** 2 for k in places) - 1) / 2)
            slopes += [q[k] if k in places else 0.0 for k in range(n)]
        if not all(map(math.isfinite, (*phi, *slopes))):
            return None
        size = 1 + max(map(abs, q), default=0.0)
        if max(map(abs, phi), default=0.0) < _CLOSED * size:
            return q
        step = solve_saddle(unit, slopes, [0.0] * n, [-x for x in phi], rank_cut=_RANK_CUT).udot
        longest = max(map(abs, step), default=0.0)
        shortened = min(1.0, size / longest) if longest else 1.0
        q = [x + shortened * dx for x, dx in zip(q, step, strict=True)]
    return None


def _rank(formed: Formed, slopes: Sequence[float]) -> int:
    n, m = len(formed.u), len(formed.rows)
    unit = [float(i == j) for i in range(n) for j in range(n)]
    return solve_saddle(unit, slopes, [0.0] * n, [0.0] * m, rank_cut=_RANK_CUT).rank
