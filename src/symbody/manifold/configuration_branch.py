"""`explore_branch`: the dimension of the configurations that can be reached from one of them.

The rank of the Jacobian at one configuration bounds the dimension from above only: at change points, in
linkages that only just fit, and in structures that give way to first order, constraints admit directions that
lead nowhere. So the configuration is moved: along random tangents, over a finite length, and back onto the
constraints by Newton's method. Where the ends lie along the tangents, up to curvature, the tangents are those
of a manifold, and their number is its dimension (Muller, Mech. Mach. Theory 44 (2009), 1-9; Wampler,
Hauenstein & Sommese, Mech. Mach. Theory 46 (2011), 1193-1206). Elsewhere the ends are configurations on the
branches that meet there, and are examined in turn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.manifold.manifold import ConstraintManifold

Floats = NDArray[np.float64]

_LENGTHS: Final = (0.2, 0.05, 0.01)  # of moves away from a singular configuration, in sizes
_LENGTH: Final = 0.05  # of moves that compare ends with tangents
_DIRECTIONS: Final = 3
_SHORTER: Final = 4.0
# A move of a quarter of the length leaves its tangent by a quarter of the angle where this is a manifold's,
# by the same angle where it is not.
_CURVED: Final = 0.5
_STRAIGHT: Final = 3e-3
_REACHED: Final = (0.2, 5.0)  # shares of its length over which a move has led somewhere
_TRIALS: Final = 4
_DEPTH: Final = 3
_MOST: Final = 6  # configurations examined at each depth


@dataclass(frozen=True, slots=True, eq=False)
class ConfigurationBranch:
    """The configurations about one that fulfils all constraints.

    Attributes
    ----------
    q : (n,) array
        That one.
    dimension : int
        Of the branch; of the largest where several meet.
    instantaneous : int
        Directions that the constraints admit to first order at the configuration itself.
    dimensions : tuple of int
        Those of all branches that were found to meet there.
    points : tuple of (n,) arrays
        Regular configurations on the branch of this dimension, the nearest first.
    is_decided : bool
        Whether all moves led somewhere, or back; otherwise the dimension may be larger.
    """

    q: Floats
    dimension: int
    instantaneous: int
    dimensions: tuple[int, ...]
    points: tuple[Floats, ...]
    is_decided: bool = True


def explore_branch(manifold: ConstraintManifold, q: Floats) -> ConfigurationBranch:
    """Return the branch on which a configuration (n,) lies that fulfils the constraints."""
    search = _BranchSearch(manifold)
    basis = manifold.tangent(q)
    instantaneous = basis.shape[1]
    ends = search.tangent_ends(q, basis)
    if ends is not None:
        return ConfigurationBranch(q, instantaneous, instantaneous, (instantaneous,), (q, *ends))
    regular, is_decided = search.find_regular(q, basis)
    if not regular:
        return ConfigurationBranch(q, 0, instantaneous, (0,), (q,), is_decided)
    dimensions = sorted({count for count, _ in regular}, reverse=True)
    points = [point for count, point in regular if count == dimensions[0]]
    points.sort(key=lambda point: float(np.linalg.norm((point - q) / manifold.sizes)))
    return ConfigurationBranch(q, dimensions[0], instantaneous, tuple(dimensions), tuple(points), is_decided)


@dataclass(frozen=True, slots=True, eq=False)
class _BranchSearch:
    """Moves on a manifold; random directions are the same at every call."""

    manifold: ConstraintManifold
    random: np.random.Generator = field(default_factory=lambda: np.random.default_rng(1))

    def tangent_ends(self, q: Floats, basis: Floats) -> list[Floats] | None:
        """Return the ends of moves along random tangents; None if one of them leaves its tangent."""
        ends: list[Floats] = []
        if not basis.shape[1]:
            return ends
        for direction in self._directions(basis, _DIRECTIONS):
            shares = []
            for length in (_LENGTH, _LENGTH / _SHORTER):
                end = self.manifold.project(q + length * direction * self.manifold.sizes)
                if not end.is_closed:
                    return None
                move = (end.q - q) / self.manifold.sizes / length
                shares.append(float(np.linalg.norm(move - direction)))
                ends.append(end.q)
            if not shares[1] <= _CURVED * shares[0] + _STRAIGHT:
                return None
        return ends

    def find_regular(self, q: Floats, basis: Floats) -> tuple[list[tuple[int, Floats]], bool]:
        """Return regular configurations about a singular one, each with the dimension of its branch.

        Also whether the search is decided: configurations were found, or all moves led back.
        """
        regular: list[tuple[int, Floats]] = []
        waiting, is_clear = [(q, basis)], True
        for _ in range(_DEPTH):
            singular: list[tuple[Floats, Floats]] = []
            for place, directions in waiting[:_MOST]:
                reached, others_led_back = self._moves(place, directions)
                is_clear = is_clear and others_led_back
                for end in reached:
                    tangents = self.manifold.tangent(end)
                    if self.tangent_ends(end, tangents) is None:
                        singular.append((end, tangents))
                    else:
                        regular.append((tangents.shape[1], end))
            if regular:
                return regular, True
            if not singular:
                return regular, is_clear
            waiting = singular
        return regular, False

    def _moves(self, q: Floats, basis: Floats) -> tuple[list[Floats], bool]:
        """Return configurations to which moves lead, and whether every other move led back."""
        reached: list[Floats] = []
        for length in _LENGTHS:
            is_clear = True
            ways = list(self._directions(basis, _TRIALS))
            for way in (*ways, *(-way for way in ways)):
                end = self.manifold.project(q + length * way * self.manifold.sizes)
                share = float(np.linalg.norm((end.q - q) / self.manifold.sizes)) / length
                if end.is_closed and _REACHED[0] <= share <= _REACHED[1]:
                    reached.append(end.q)
                elif not end.is_closed or share > _REACHED[1]:
                    is_clear = False
            if reached:
                return reached, True
        return reached, is_clear

    def _directions(self, basis: Floats, count: int) -> Iterator[Floats]:
        """Yield random unit vectors in the span of a basis."""
        for _ in range(count):
            vector = self.random.standard_normal(basis.shape[1])
            yield basis @ vector / float(np.linalg.norm(vector))
