"""Cyclic coordinates: whether nothing depends on them, by the graph or along the motion that changes them.

A motion is stationary if cyclic coordinates alone change in it. Its linear equations are constant if they are
the same at all its points, where the columns of the cyclic coordinates vanish. The graph proves that of a
coordinate that is absent from the equations. What is left is where the symmetry shows only when dependent
deviations are eliminated, as of the yaw of a bicycle, or at some values, as of a top with two equal moments
of inertia; there the state is moved along, closed again, and its linear equations are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.linear.independence import Selection
from symbody.analysis.linear.matrices import Matrices
from symbody.analysis.linear.orbits import PLACES, Orbit, OrbitPlace, natural_rate, not_cyclic, symbol_node
from symbody.analysis.linear.slopes import SlopeFunction
from symbody.errors import AssemblyError
from symbody.expr.calculus import forward
from symbody.expr.canonical import ONE, ZERO
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph
from symbody.expr.opcodes import EQ, FLOOR, LE, LT, PICK, SADDLE, SIGN
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.program import unroll
from symbody.tolerances import ASSEMBLED

Floats = NDArray[np.float64]
# What a coordinate can decide although derivatives by it are 0.
_STEPS: Final = frozenset({LT, LE, EQ, SIGN, FLOOR})


def check_cyclic(
    function: SlopeFunction, q: Floats, u: Floats, selection: Selection, cyclic: Sequence[str]
) -> tuple[str, ...]:
    """Check that nothing depends on cyclic coordinates, and return what was not proved.

    Raises
    ------
    AssemblyError
        If rates of other states, outputs, or their derivatives change with one of them.
    """
    shown = [name for name in dict.fromkeys(cyclic) if not _is_absent(function, name, cyclic)]
    if not shown:
        return ()
    orbit = Orbit(function, selection, tuple(cyclic), tuple(shown))
    closed = orbit.correct(q, u)
    start = orbit.place(q, u) if closed is None else orbit.place(*closed)
    for name in shown:
        _refuse([name], _changes_with(orbit, start, [name]))
    for names, step in orbit.directions(start):
        for place in orbit.places(start, names, step):
            _refuse(names, [*_changes_with(orbit, place, names), *_changes_between(orbit, start, place)])
    return (
        f"{', '.join(shown)} can be cyclic: nothing else changes at {PLACES} positions along the motion; "
        f"this is a numerical check, the formulas alone do not prove it",
    )


def _refuse(names: Sequence[str], reading: Sequence[str]) -> None:
    if reading:
        raise AssemblyError(not_cyclic(names, list(dict.fromkeys(reading))))


def _is_absent(function: SlopeFunction, name: str, cyclic: Sequence[str]) -> bool:
    """Return whether a coordinate is in nothing but the rates of cyclic ones."""
    eqs = function.eqs
    if name not in eqs.coordinate_names:
        return False
    speeds = len(eqs.speed_names)
    cyclic_rates = {speeds + k for k, other in enumerate(eqs.coordinate_names) if other in cyclic}
    read = [node for k, node in enumerate(function.nodes) if k not in cyclic_rates]
    return is_absent(eqs.formed.graph, read, symbol_node(function, name))


def _changes_with(orbit: Orbit, place: OrbitPlace, names: Sequence[str]) -> list[str]:
    """Return the names of all that changes with cyclic coordinates at a place, to first order."""
    bounds, kept = _bounds(orbit, place, place), orbit.kept_states
    columns = [k for k, name in enumerate(orbit.selection.names) if name in names and name in orbit.shown]
    rates = np.abs(place.matrices.A) > bounds.A
    shown = np.abs(place.matrices.C) > bounds.C
    return [
        *_rates(orbit, [k for k in kept if rates[k, columns].any()]),
        *_names_where(orbit.function.outputs, _rows(shown[:, columns])),
    ]


def _changes_between(orbit: Orbit, start: OrbitPlace, here: OrbitPlace) -> list[str]:
    """Return the names of all that differs between two places."""
    bounds, kept = _bounds(orbit, start, here), orbit.kept_states

    def differs(one: Floats, other: Floats, bound: Floats) -> NDArray[np.bool_]:
        return np.asarray(~(np.abs(one - other) <= bound))  # what is not a number is not the same either

    one, other = start.matrices, here.matrices
    A = differs(one.A, other.A, bounds.A)[:, kept]
    affine, B = differs(one.affine, other.affine, bounds.affine), differs(one.B, other.B, bounds.B)
    C = _rows(differs(one.C, other.C, bounds.C)[:, kept])
    D = _rows(differs(one.D, other.D, bounds.D))
    near, far = start.slopes.switches, here.slopes.switches
    sizes = np.fmax(np.abs(near), np.abs(orbit.function.beside - near))  # the second need not exist
    over = differs(near, far, ASSEMBLED * sizes)
    return [
        *_rates(orbit, [k for k in kept if A[k].any() or affine[k]]),
        *(f"the effect of {name}" for name in _names_where(orbit.function.inputs, _rows(B[kept].T))),
        *_names_where(orbit.function.outputs, C | D),
        *(
            f"the condition on {what}"
            for what in _names_where([what for what, _ in orbit.function.switches], over)
        ),
    ]


def _rates(orbit: Orbit, places: Sequence[int]) -> list[str]:
    return [f"the rate of {orbit.selection.names[k]}" for k in places]


def _rows(entries: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return in which rows anything holds."""
    return np.asarray(entries.any(axis=1))


def _names_where(names: Sequence[str], chosen: NDArray[np.bool_]) -> Iterator[str]:
    return (name for name, yes in zip(names, chosen, strict=True) if yes)


def _bounds(orbit: Orbit, start: OrbitPlace, here: OrbitPlace) -> Matrices:
    """Return bounds of the differences that rounding and the closing of loops may make."""
    a, b = start.terms, here.terms
    n, w = len(orbit.selection.speeds.independent), natural_rate(start, orbit.selection)
    noise = max(start.noise, here.noise)
    close = noise + (ASSEMBLED if orbit.selection.coordinates.dependent else 0.0)
    A, B, C, D = (np.maximum(x, y) for x, y in ((a.A, b.A), (a.B, b.B), (a.C, b.C), (a.D, b.D)))
    # Rounding of one row gets into all others by the solution for accelerations; their units are the same.
    powers = np.ones_like(A)
    powers[:n, :n], powers[:n, n:], powers[n:, n:] = w, w * w, w
    reach = np.ones(len(A))
    reach[:n] = np.abs(start.u / orbit.selection.u_sizes)[list(orbit.selection.speeds.independent)]
    affine = close * (A @ reach + np.maximum(a.affine, b.affine))
    affine[:n] += noise * w * w
    affine[n:] += noise * w
    return Matrices(
        close * A + noise * powers,
        close * B + noise * B.max(axis=0, initial=0.0),
        close * C + noise * C.max(axis=1, keepdims=True, initial=0.0),
        close * D + noise * D.max(axis=0, initial=0.0),
        affine,
    )


def is_absent(graph: Graph, roots: Sequence[int], symbol: int) -> bool:
    """Return whether nothing in `roots` changes with a symbol.

    True is certain. Systems of equations are compared by their coefficients, so that False may also mean
    that these change and their solution does not.
    """
    if symbol not in symbols_of(graph, roots):
        return True
    roots = unroll(graph, roots)
    derivatives = {symbol: ONE}
    for operands, results in _stages(graph, roots):
        if not all(find_zeros(graph, forward(graph, operands, derivatives))):
            return False
        derivatives.update(dict.fromkeys(results, ZERO))
    return all(find_zeros(graph, forward(graph, roots, derivatives)))


def _stages(graph: Graph, roots: Sequence[int]) -> Iterator[tuple[tuple[int, ...], list[int]]]:
    """Return the operands of systems of equations and of steps, in order, and the nodes of their results."""
    for node in graph.reachable(roots):
        op = graph.ops[node]
        if op == SADDLE:
            kernel = graph.kernels[graph.right[node]]
            yield graph.operands(node), [graph.node(PICK, node, k) for k in range(kernel.n + kernel.m)]
        elif op in _STEPS:
            yield graph.operands(node), [node]
