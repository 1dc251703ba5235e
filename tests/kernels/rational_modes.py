"""All solutions of reduced mode problems, in rational numbers: every mode and every sign of reactions is tried."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from random import Random

import numpy as np

from symbody.analysis.modes.reduced_modes import ModeCandidate, ModeSolution, Responses, decide
from symbody.kernels.modes.mode_problem import BACK, BOUNDED, HOLDS, LOOSE, UNILATERAL

Row = list[Fraction]


@dataclass(frozen=True)
class Problem:
    """Elements with one row each; reactions have one component, and static strengths are the kinetic ones.

    Attributes
    ----------
    kinds : list of int
    moves : list of int
        The sign of the rate; 0 at rest.
    strengths : list of Fraction
    reads : list of bool
        Whether the bound is the strength times a reaction.
    matrix, offsets, reactions, loads : lists of Fraction
        As `Responses`, with reactions of all elements.
    """

    kinds: list[int]
    moves: list[int]
    strengths: Row
    reads: list[bool]
    matrix: list[Row]
    offsets: Row
    reactions: list[Row]
    loads: Row

    def solutions(self) -> dict[tuple[Fraction, ...], tuple[int, ...]]:
        """Return the accelerations of all solutions, each with modes."""
        found: dict[tuple[Fraction, ...], tuple[int, ...]] = {}
        for modes in product(*map(self._choices, range(len(self.kinds)))):
            sliders = [k for k, mode in enumerate(modes) if self.reads[k] and mode != HOLDS]
            for signs in product((1, -1), repeat=len(sliders)):
                efforts = self._efforts(modes, dict(zip(sliders, signs, strict=True)))
                if efforts is None:
                    continue
                accelerations = affine(self.matrix, efforts, self.offsets)
                loads = affine(self.reactions, efforts, self.loads)
                signed = all(sign * loads[k] >= 0 for k, sign in zip(sliders, signs, strict=True))
                if signed and all(self._fits(modes, efforts, accelerations, loads)):
                    found[tuple(accelerations)] = modes
        return found

    def _choices(self, k: int) -> tuple[int, ...]:
        if self.moves[k]:
            return (self.moves[k],)
        return (HOLDS, LOOSE) if self.kinds[k] == UNILATERAL else (HOLDS, LOOSE, BACK)

    def _efforts(self, modes: Sequence[int], signs: dict[int, int]) -> Row | None:
        n = len(modes)
        rows, right = [], []
        for k, mode in enumerate(modes):
            row = [Fraction(k == i) for i in range(n)]
            value = Fraction(0)
            if mode == HOLDS:
                row, value = self.matrix[k], -self.offsets[k]
            elif k in signs:
                weight = mode * self.strengths[k] * signs[k]
                row = [x + weight * y for x, y in zip(row, self.reactions[k], strict=True)]
                value = -weight * self.loads[k]
            elif self.kinds[k] == BOUNDED:
                value = -mode * self.strengths[k]
            rows.append(row)
            right.append(value)
        return solve(rows, right)

    def _fits(self, modes: Sequence[int], efforts: Row, accelerations: Row, loads: Row) -> Iterator[bool]:
        for k, mode in enumerate(modes):
            bound = self.strengths[k] * (abs(loads[k]) if self.reads[k] else 1)
            if mode == HOLDS:
                yield efforts[k] >= 0 if self.kinds[k] == UNILATERAL else abs(efforts[k]) <= bound
            else:
                yield bool(self.moves[k]) or accelerations[k] * mode >= 0

    def decide(self, order: Sequence[int]) -> ModeSolution:
        """Return what the kernel decides for the elements in some order."""
        elements = [
            ModeCandidate(self.kinds[k], normals=int(self.reads[k]), sliding=float(self.strengths[k]),
                      static=float(self.strengths[k]), moves=bool(self.moves[k]), mode=self.moves[k],
                      slip=(float(self.moves[k]), 0.0))
            for k in order
        ]  # fmt: skip
        readers = [k for k in order if self.reads[k]]

        def table(rows: Sequence[Row], chosen: Sequence[int]) -> np.ndarray:
            return np.array([[float(rows[i][j]) for j in order] for i in chosen]).reshape(-1, len(order))

        offsets = np.array([float(self.offsets[k]) for k in order])
        loads = np.array([float(self.loads[k]) for k in readers])
        responses = Responses(offsets, table(self.matrix, order), loads, table(self.reactions, readers))
        return decide(elements, responses)


def draw(random: Random) -> Problem:
    """Return a problem with one to four elements; reactions depend on efforts weakly or strongly."""
    n = random.choice([1, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 4])
    coupling = random.choice([1, 4, 10, 40])
    width = n + random.randint(0, 1)
    rows = [[Fraction(random.randint(-4, 4)) for _ in range(width)] for _ in range(n)]
    matrix = [
        [sum((x * y for x, y in zip(a, b, strict=True)), Fraction(i == j, 3)) for j, b in enumerate(rows)]
        for i, a in enumerate(rows)
    ]
    kinds = [random.choice([UNILATERAL, BOUNDED, BOUNDED]) for _ in range(n)]
    return Problem(
        kinds=kinds,
        moves=[random.choice([0, 0, 0, 1, 1 if kind == UNILATERAL else -1]) for kind in kinds],
        strengths=[Fraction(random.randint(1, 8), 10) for _ in kinds],
        reads=[kind == BOUNDED and random.random() < 0.7 for kind in kinds],
        matrix=matrix,
        offsets=[Fraction(random.randint(-200, 200), 9) for _ in kinds],
        reactions=[[Fraction(random.randint(-40, 40), 11 * coupling) for _ in kinds] for _ in kinds],
        loads=[Fraction(random.randint(-50, 50), 7) for _ in kinds],
    )


def affine(matrix: Sequence[Row], x: Row, rest: Row) -> Row:
    return [c + sum(a * b for a, b in zip(row, x, strict=True)) for row, c in zip(matrix, rest, strict=True)]


def solve(matrix: Sequence[Row], right: Row) -> Row | None:
    """Return x with ``matrix x = right``; None where it is singular."""
    n = len(right)
    a = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for k in range(n):
        pivot = next((i for i in range(k, n) if a[i][k]), None)
        if pivot is None:
            return None
        a[k], a[pivot] = a[pivot], a[k]
        for i in range(n):
            if i != k and a[i][k]:
                factor = a[i][k] / a[k][k]
                a[i] = [x - factor * y for x, y in zip(a[i], a[k], strict=True)]
    return [a[k][n] / a[k][k] for k in range(n)]
