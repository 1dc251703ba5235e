"""`decide`: which elements hold and which are loose, on numbers; the call of the kernel `find_modes`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.kernels.modes.mode_problem import BACK, CONE, HOLDS, LOOSE, ModeElement, ModeProblem
from symbody.kernels.pack import pack
from symbody.single_flight import once

Floats = NDArray[np.float64]


class ModeVerdict(IntEnum):
    """How many solutions there are; codes of `kernels.modes.find_modes`."""

    ONE = 0
    NONE = 1
    TWO = 2
    NOT_FOUND = 3


@dataclass(frozen=True, slots=True)
class ModeCandidate:
    """An element that may hold or be loose.

    Attributes
    ----------
    kind : int
        ``UNILATERAL``, ``BOUNDED`` or ``CONE``.
    scale : float
        Of displacements along its rows, so that an effort times it is a work.
    normals : int
        How many components the reaction has that multiplies its strengths; 0 if they are efforts.
    sliding, static : float
        Strengths.
    moves : bool
        Whether it is loose because it moves, along `slip`; its mode is open otherwise.
    mode : int
        Where the search begins.
    slip : pair of float
        Direction.
    rounding : float
        Accelerations that are rounding.
    """

    kind: int
    scale: float = 1.0
    normals: int = 0
    sliding: float = 0.0
    static: float = 0.0
    moves: bool = False
    mode: int = HOLDS
    slip: tuple[float, float] = (0.0, 0.0)
    rounding: float = 0.0

    @property
    def rows(self) -> int:
        """How many rows it has."""
        return 2 if self.kind == CONE else 1

    def with_slip(self, slip: float, *, moves: bool) -> ModeCandidate:
        """Return the element with a slip, of one that holds 0; a unilateral one that moves is open."""
        mode = LOOSE if slip > 0.0 else BACK if slip < 0.0 else HOLDS
        return replace(
            self, mode=mode if mode != HOLDS or not moves else LOOSE, moves=moves, slip=(slip, 0.0)
        )


class Responses(NamedTuple):
    """Accelerations of all rows without efforts and their change by a unit of each; the same of reactions.

    Attributes
    ----------
    offsets, matrix : (n,) and (n, n) array
    loads, reactions : (c,) and (c, n) array
        Components of the reactions that bounds read, in the order of the elements.
    """

    offsets: Floats
    matrix: Floats
    loads: Floats
    reactions: Floats

    def of_rows(self, places: Sequence[int]) -> Responses:
        """Return the responses without the other rows, whose efforts are 0."""
        chosen = np.array(places, dtype=np.int64)
        return Responses(
            self.offsets[chosen], self.matrix[np.ix_(chosen, chosen)], self.loads, self.reactions[:, chosen]
        )


class ModeSolution(NamedTuple):
    """What was decided; modes, efforts and accelerations mean nothing where no solution was found.

    Attributes
    ----------
    verdict : ModeVerdict
    modes : tuple of int
    efforts, accelerations : (n,) array
    slip : (elements, 2) array
        Directions in which loose elements slip.
    normals : (elements,) array
        Norms of the reactions that bounds read.
    """

    verdict: ModeVerdict
    modes: tuple[int, ...]
    efforts: Floats
    accelerations: Floats
    slip: Floats
    normals: Floats


def decide(candidates: Sequence[ModeCandidate], responses: Responses) -> ModeSolution:
    """Return which elements hold, and with which efforts; none are found where responses are no numbers."""
    problem = mode_problem(candidates, responses)
    if not np.isfinite(problem).all():
        return mode_solution(problem, ModeVerdict.NOT_FOUND)
    verdict = ModeVerdict(_kernel()(problem.ctypes.data))
    return mode_solution(problem, verdict)


def mode_problem(candidates: Sequence[ModeCandidate], responses: Responses) -> Floats:
    """Return the block of the kernel."""
    elements, row, normal = [], 0, 0
    for one in candidates:
        elements.append(
            pack(
                ModeElement,
                law=one.kind,
                row=row,
                normal=normal,
                normals=one.normals,
                sliding=one.sliding,
                static=one.static,
                scale=one.scale,
                rounding=one.rounding,
                moves=one.moves,
                mode=one.mode,
                first=one.slip[0],
                second=one.slip[1],
            )  # fmt: skip
        )
        row, normal = row + one.rows, normal + one.normals
    return pack(
        ModeProblem, count=len(candidates), rows=row, components=normal, columns=row + 1, elements=elements,
        responses=responses.matrix, offsets=responses.offsets, reactions=responses.reactions,
        loads=responses.loads,
    )  # fmt: skip


def mode_solution(block: Floats, verdict: ModeVerdict) -> ModeSolution:
    """Return what the kernel left in its block."""
    problem = ModeProblem(block)
    elements = list(problem.elements)
    return ModeSolution(
        verdict,
        tuple(one.mode for one in elements),
        np.array(problem.efforts),
        np.array(problem.accelerations),
        np.array([(one.first, one.second) for one in elements]).reshape(-1, 2),
        np.array([one.normal_load for one in elements]),
    )


@once
def _kernel() -> Callable[[int], int]:
    address = load_kernels("find_modes", ("find_modes",), light=True)["find_modes"]
    return ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p)(address)
