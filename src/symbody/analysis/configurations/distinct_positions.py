"""`distinct`: of closed forms of the same coordinates, those that each give a pose that no other gives.

Formulas that differ may give equal poses: SymPy finds roots of squared equations more than once, and angles
of a ball joint have two sets of values for one placement. So the formulas are evaluated at random values of
what they depend on, and compared by the placements of all bodies, or by the coordinates and the directions of
angles. A root is known to its rounding over the smallest singular value of the equations about it, and is
compared to that.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.expr.calculus import jacobian
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.expr.sequences.sequence import Sequence as Program
from symbody.tolerances import ROOT, TINY

Floats = NDArray[np.float64]

_SAMPLES: Final = 12
_TRIALS: Final = 240
_SPREAD: Final = 0.1  # of the values of parameters
_ROUNDING: Final = 1e3 * float(np.finfo(float).eps)  # of the terms of long formulas
_NEAREST: Final = 1e-9
_FARTHEST: Final = 1e-3  # of what a root that is nearly double is still compared to


@dataclass(frozen=True, slots=True)
class Formulas:
    """Closed forms of unknowns in known symbols.

    Attributes
    ----------
    graph : Graph
        Of all nodes.
    rows : tuple of int
        Equations that vanish.
    unknowns, angles : tuple of int, frozenset of int
        Symbols that are solved for, and which of all symbols turn.
    solutions : tuple of tuple of int
        Each with one node for every unknown.
    placements : tuple of int
        Of each body place (3) and rotation matrix (9), in all symbols; without, unknowns are compared.
    values : mapping of name to float
        Of parameters, about which values are drawn.
    length : float or None
        Size of lengths [m]; None: the largest of the values drawn that are not angles.
    """

    graph: Graph
    rows: tuple[int, ...]
    unknowns: tuple[int, ...]
    angles: frozenset[int]
    solutions: tuple[tuple[int, ...], ...]
    placements: tuple[int, ...] = ()
    values: Mapping[str, float] | None = None
    length: float | None = None


def distinct_solutions(formulas: Formulas) -> list[int]:
    """Return the places of solutions with poses that no earlier ones give."""
    kept = list(range(len(formulas.solutions)))
    if len(kept) < 2:
        return kept
    samples = _Samples(formulas).poses()
    for k in reversed(range(len(formulas.solutions))):
        others = [j for j in kept if j != k]
        mine = [(sample[k], sample) for sample in samples if sample[k] is not None]
        if mine and all(_is_among(pose, [sample[j] for j in others]) for pose, sample in mine):
            kept = others
    return kept


def _is_among(pose: _Pose | None, others: Sequence[_Pose | None]) -> bool:
    return pose is not None and any(
        other is not None
        and float(np.abs(pose.place - other.place).max(initial=0.0)) <= pose.radius + other.radius
        for other in others
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Pose:
    """Numbers by which poses are compared, in units of their size, and the error of these."""

    place: Floats
    radius: float


class _Samples:
    """Poses of all solutions at random values of the known symbols, the same at every call."""

    def __init__(self, formulas: Formulas) -> None:
        self._formulas, graph = formulas, formulas.graph
        nodes = [*formulas.rows, *formulas.placements, *(x for s in formulas.solutions for x in s)]
        everything = dict.fromkeys((*symbols_of(graph, nodes), *formulas.unknowns))
        self._known = [node for node in everything if node not in formulas.unknowns]
        order = {node: Input(self._label(node), "q", k) for k, node in enumerate(everything)}
        self._places = {node: k for k, node in enumerate(everything)}
        self._width = len(everything)
        flat = [node for solution in formulas.solutions for node in solution]
        slopes = [x for row in jacobian(graph, list(formulas.rows), list(formulas.unknowns)) for x in row]
        self._solved = self._program(flat, order)
        self._checked = self._program([*formulas.rows, *slopes, *formulas.placements], order)

    def poses(self) -> list[list[_Pose | None]]:
        """Return the poses of each solution, None where it has none, at values where there is one."""
        random = np.random.default_rng(1)
        samples = []
        for _ in range(_TRIALS):
            sample = self._evaluate_poses(self._draw(random))
            if any(pose is not None for pose in sample):
                samples.append(sample)
            if len(samples) == _SAMPLES:
                break
        return samples

    def _label(self, node: int) -> str:
        graph = self._formulas.graph
        return graph.symbols[graph.left[node]].label

    def _program(self, nodes: list[int], order: Mapping[int, Input]) -> Program:
        return build_sequence(
            self._formulas.graph, [Roots("values", (len(nodes),), tuple(nodes))], dict(order)
        )

    def _draw(self, random: np.random.Generator) -> Floats:
        """Return values of all symbols, 0 for the unknowns."""
        graph, given = self._formulas.graph, self._formulas.values or {}
        drawn = np.zeros(self._width)
        size = 2.0 * (self._formulas.length or 1.0)
        for node in self._known:
            kind, name = graph.symbols[graph.left[node]].kind, self._label(node)
            if name in given:
                value = given[name] * (1.0 + random.uniform(-_SPREAD, _SPREAD))
            elif node in self._formulas.angles:
                value = random.uniform(-math.pi, math.pi)
            elif kind == SymbolKind.PARAMETER:
                value = random.uniform(0.5, 2.0)
            else:
                value = random.uniform(-size, size)
            drawn[self._places[node]] = value
        return drawn

    def _evaluate_poses(self, drawn: Floats) -> list[_Pose | None]:
        """Return the pose of each solution at values of what is known."""
        numbers = self._numbers(self._solved, drawn)
        n = len(self._formulas.unknowns)
        poses: list[_Pose | None] = []
        for k in range(len(self._formulas.solutions)):
            solution = numbers[k * n : (k + 1) * n]
            poses.append(self._pose(drawn, solution) if np.isfinite(solution).all() else None)
        return poses

    def _pose(self, drawn: Floats, numbers: Floats) -> _Pose | None:
        """Return the pose for values of the unknowns; None if the equations do not hold."""
        formulas, n, m = self._formulas, len(numbers), len(self._formulas.rows)
        full = drawn.copy()
        full[[self._places[node] for node in formulas.unknowns]] = numbers
        length = self._length(drawn)
        values = self._numbers(self._checked, full)
        if not np.isfinite(values).all():
            return None
        turning = np.array([node in formulas.angles for node in formulas.unknowns], dtype=np.bool_)
        slopes = values[m : m + m * n].reshape(m, n) * np.where(turning, 1.0, length)
        terms = np.abs(slopes).max(axis=1, initial=0.0)
        terms[terms == 0.0] = 1.0
        open_by = np.abs(values[:m]) / terms
        if (open_by > ROOT).any():
            return None
        least = float(np.linalg.svd(slopes / terms[:, np.newaxis], compute_uv=False)[-1])
        radius = (float(open_by.max(initial=0.0)) + _ROUNDING) / max(least, TINY)
        if formulas.placements:
            place = values[m + m * n :].reshape(-1, 12) / ([length] * 3 + [1.0] * 9)
        else:
            place = np.concatenate(
                [np.cos(numbers[turning]), np.sin(numbers[turning]), numbers[~turning] / length]
            )
        return _Pose(np.ravel(place), min(max(radius, _NEAREST), _FARTHEST))

    def _length(self, drawn: Floats) -> float:
        """Return the size of lengths."""
        if self._formulas.length is not None:
            return self._formulas.length
        lengths = [drawn[self._places[node]] for node in self._known if node not in self._formulas.angles]
        return max(map(abs, lengths), default=1.0) or 1.0

    def _numbers(self, program: Program, values: Floats) -> Floats:
        computed = evaluate_sequence(program, {"q": values.tolist()})[0]
        return np.array([x if isinstance(x, float) else float(x) for x in computed], dtype=np.float64)
