"""Matrices of successive steps, each formed from the longest part of its sequence that has one.

A step is coded by a whole number, its inverse by the opposite one, and a sequence of steps by the
tuple of codes, a *word*. Two ways through a tree that come to the same word share one matrix.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import count
from typing import Any

from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.spatial.matrix import Matrix3, identity
from symbody.spatial.rotation import ElementaryRotation, Rotation, merge_steps

Word = tuple[int, ...]


class StepProducts:
    """Products of step matrices in one graph; it only grows.

    Once ``R_ac`` is known, ``R_ab`` for the neighbour b of c costs one product with the matrix of one
    step. The first of far pairs costs as many as there are steps; those between are then known.
    """

    __slots__ = ("_codes", "_graph", "_matrices", "_merged", "_next", "_steps")

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._next = count(1)
        self._codes: dict[ElementaryRotation, int] = {}
        self._steps: dict[int, ElementaryRotation] = {}
        self._merged: dict[tuple[int, int], Word | None] = {}
        self._matrices: dict[Word, Matrix3[Expr]] = {(): identity(graph)}

    def __getstate__(self) -> tuple[object, ...]:
        """Return what a copy needs; a counter cannot be pickled from Python 3.14 on."""
        return self._graph, self._codes, self._steps, self._merged, self._matrices

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        self._graph, self._codes, self._steps, self._merged, self._matrices = state
        self._next = count(max(self._steps, default=0) + 1)

    def word(self, rotation: Rotation) -> Word:
        """Return the codes of the steps of a rotation, identities left out."""
        return tuple(self._code(step) for step in rotation.turns if not step.is_identity)

    def merge_codes(self, codes: Iterable[int]) -> Word:
        """Return the codes with neighbours merged."""
        word: list[int] = []
        for code in codes:
            together = self._merge_pair(word[-1], code) if word else None
            if together is None:
                word.append(code)
            else:
                word[-1:] = together
        return tuple(word)

    def rotation(self, word: Word) -> Rotation:
        """Return the rotation of a reduced word."""
        return Rotation(tuple(self._steps[code] for code in word))

    def matrix(self, word: Word) -> Matrix3[Expr]:
        """Return the product of the step matrices of a reduced word."""
        if word in self._matrices:
            return self._matrices[word]
        for length in range(len(word) - 1, 0, -1):
            if word[-length:] in self._matrices:
                return self._extend_left(word, length)
            # A short beginning is left alone: from the end, which is deep in the tree, more is shared.
            if 2 * length >= len(word) > 2 and word[:length] in self._matrices:
                return self._extend_right(word, length)
        self._step_matrix(word[-1])
        return self._extend_left(word, 1)

    def _extend_right(self, word: Word, length: int) -> Matrix3[Expr]:
        result = self._matrices[word[:length]]
        for end in range(length + 1, len(word) + 1):
            result = result @ self._step_matrix(word[end - 1])
            self._keep(word[:end], result)
        return result

    def _extend_left(self, word: Word, length: int) -> Matrix3[Expr]:
        result = self._matrices[word[-length:]]
        for start in range(len(word) - length - 1, -1, -1):
            result = self._step_matrix(word[start]) @ result
            self._keep(word[start:], result)
        return result

    def _step_matrix(self, code: int) -> Matrix3[Expr]:
        if (code,) not in self._matrices:
            self._keep((code,), self._steps[code].matrix(self._graph))
        return self._matrices[code,]

    def _keep(self, word: Word, matrix: Matrix3[Expr]) -> None:
        self._matrices[word] = matrix
        self._matrices[backwards(word)] = matrix.T

    def _merge_pair(self, first: int, second: int) -> Word | None:
        """Return the code of two merged steps, no code if they cancel, None if they stay two."""
        if first == -second:
            return ()
        pair = (first, second)
        if pair not in self._merged:
            steps = merge_steps(self._steps[first], self._steps[second])
            self._merged[pair] = None if steps is None else tuple(self._code(step) for step in steps)
        return self._merged[pair]

    def _code(self, step: ElementaryRotation) -> int:
        if step not in self._codes:
            code = next(self._next)
            self._steps[code], self._steps[-code] = step, step.inverse
            self._codes.setdefault(self._steps[-code], -code)
            # The code that another thread entered meanwhile is kept; either is right.
            self._codes.setdefault(step, code)
        return self._codes[step]


def backwards(word: Word) -> Word:
    """Return the word of the inverse rotation."""
    return tuple(-code for code in reversed(word))
