"""`EquilibriumSearch`: equilibria of one set of equations, from starts about a guess.

Newton steps of least length (Nocedal & Wright 2006, section 10.3) on the forces that multipliers cannot
balance together with the constraints. About a configuration at which branches cross the constraints have
other directions off the manifold than on any branch of it, by as little as the square root of what they are
closed to, and multipliers beyond all bounds balance whatever force there. So a configuration counts as what
it is up to that: loads with singular values below the root of what is open bear nothing, and forces must do
no work along any direction that is left.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.analysis.equilibrium.static_balance import StaticBalance, StaticResidual
from symbody.errors import AssemblyError, Problem, SimulationError
from symbody.manifold import descend, explore_branch, least_step, null_space
from symbody.tolerances import ASSEMBLED, AT_REST, BEARING, EXACT, RANK, SHARP_RANK

Floats = NDArray[np.float64]

_GROWTH: Final = 1.2  # of the distances of starts
_PATIENCE: Final = 8  # steps, with states of signals
# Constraints open by e have the Jacobian of a place sqrt(2 e / K) beside; K, their curvature, is of order 1.
_BESIDE: Final = 10.0
_SAME_CROSSING: Final = 1e-3
_CLOSINGS: Final = 3  # of Newton's steps, from constraints closed to 1e-10
_MOST_BESIDE: Final = 4  # starts beside a crossing
_STEP: Final = 0.05  # in sizes: finite, so that terms of higher order show
_STAYED: Final = 0.5  # of the step: equilibria go on where Newton's method leads back by less
_LISTED: Final = 1e-6  # of the largest component


@dataclass(frozen=True, slots=True, eq=False)
class EquilibriumSearch:
    """A search for equilibria from a guess.

    Attributes
    ----------
    balance : StaticBalance
        The forces.
    start : (n_q,) array
        The guess.
    fixed : frozenset of str
        Coordinates that keep their values.
    """

    balance: StaticBalance
    start: Floats
    fixed: frozenset[str]
    # Crossings that starts ended at, and the count of independent loads.
    _crossings: list[Floats] = field(default_factory=list, repr=False)
    _generic: list[int | None] = field(default_factory=list, repr=False)

    @property
    def evaluator(self) -> ConstraintEvaluator:
        """The constraints."""
        return self.balance.evaluator

    @property
    def free(self) -> NDArray[np.bool_]:
        """Mask of the coordinates that may move."""
        return self.evaluator.free_coordinates(dict.fromkeys(self.fixed, 0.0))

    def check_at_rest(self) -> None:
        """Refuse constraints that demand motion.

        Raises
        ------
        AssemblyError
            Naming the rows.
        """
        evaluator = self.evaluator
        drift = evaluator.velocity_rows(self.start, {})[1] / evaluator.mechanism.constraints(evaluator.eqs)
        fast = AT_REST / evaluator.mechanism.time
        moving = [
            name for name, b in zip(evaluator.eqs.multiplier_names, drift, strict=True) if abs(b) > fast
        ]
        if moving:
            raise AssemblyError(
                Problem("equilibrium.moving", ", ".join(moving), "these constraints require motion",
                        f"they depend on time and have nonzero rates at t = {evaluator.t:g} s",
                        "give a t at which their rates are zero")
            )  # fmt: skip

    def starts(self) -> list[Floats]:
        """Return the guess and starts about it, the same at every call."""
        return list(self.evaluator.starts(self.start, dict.fromkeys(self.fixed, 0.0), _GROWTH))

    def descend(self, q: Floats, bearing: int | None = None) -> StaticResidual:
        """Return the end of steps of least length; `bearing` as of `Balance.rest`."""
        free, sizes, balance = self.free, self.evaluator.sizes, self.balance
        largest = balance.largest_term(self.start)

        def move(place: StaticResidual, step: Floats) -> StaticResidual:
            q = place.q.copy()
            q[free] += step * sizes[free]
            return balance.residual(self.evaluator.normalize(q), place.inputs, largest, bearing)

        def step(values: Floats, slopes: Floats) -> Floats:
            return least_step(values, slopes[:, free])

        start = balance.residual(q, balance.first_inputs, largest, bearing)
        curved = self.evaluator.manifold(dict.fromkeys(self.fixed, 0.0)).curved
        # Controllers at their limits have no slope, and starts crawl along them.
        return descend(
            start, move, step, patience=_PATIENCE if self.evaluator.signals.size else None,
            limited=None if curved is None else (curved | balance.curved)[free],
        )  # fmt: skip

    def attempts(self, q: Floats) -> list[StaticResidual]:
        """Return the ends of a start: equilibria, or places with the least unbalanced forces.

        A start that ends at a crossing of branches without balance goes on from places beside it.
        """
        end = self.descend(q, self._count_generic_loads())
        rest = self._confirm(end)
        if rest is end or self.is_good(rest) or self._is_repeated(end):
            return [rest]
        ends = [rest]
        for place in self._regular_neighbours(end.q)[:_MOST_BESIDE]:
            place[~self.free] = self.start[~self.free]
            ends.append(self._confirm(self.descend(place, self._count_loads(place))))
        return ends

    def _confirm(self, rest: StaticResidual) -> StaticResidual:
        """Return an end of Newton's method with the loads that stay bounded about it."""
        if not self._is_closed(rest):
            return rest
        if ((rest.shares > BEARING) & (rest.shares < _SAME_CROSSING)).any():
            rest = self._close(rest)
        cut = _BESIDE * float(np.sqrt(max(rest.largest_gap, EXACT)))
        bearing = rest.shares[rest.shares > BEARING] if rest.bearing is None else rest.shares[: rest.bearing]
        if (bearing >= cut).all():
            return rest
        return self.descend(rest.q, int((bearing >= cut).sum()))

    def _close(self, place: StaticResidual) -> StaticResidual:
        """Return the same place with its constraints closed to rounding.

        Where singular values fall to s, constraints open by e turn the loads by e / s, which balances forces
        that nothing balances at the place itself.
        """
        q, free, sizes = place.q.copy(), self.free, self.evaluator.sizes
        for _ in range(_CLOSINGS):
            _, values, rows = self.evaluator.manifold().constraints(q)
            q[free] += least_step(values, rows[:, free]) * sizes[free]
        closed = self.balance.residual(
            self.evaluator.normalize(q), place.inputs, self.balance.largest_term(self.start), place.bearing
        )
        return closed if closed.largest_gap < place.largest_gap else place

    def _is_repeated(self, rest: StaticResidual) -> bool:
        """Return whether starts beside this crossing were tried already."""
        if any(not self.evaluator.differs(rest.q, other, _SAME_CROSSING) for other in self._crossings):
            return True
        self._crossings.append(rest.q)
        return False

    def _regular_neighbours(self, q: Floats) -> list[Floats]:
        """Return regular configurations of the mechanism beside one."""
        end = self.evaluator.manifold().project(q)
        points = explore_branch(self.evaluator.manifold(), end.q).points if end.is_closed else ()
        return [point.copy() for point in points]

    def _count_loads(self, q: Floats) -> int:
        """Return the number of independent loads at a regular configuration."""
        rest = self.balance.residual(q, self.balance.first_inputs, 1.0)
        return int((rest.shares > RANK).sum())

    def _count_generic_loads(self) -> int | None:
        """Return the number of independent loads on the branch of the guess; None where it is not closed."""
        if not self._generic:
            places = [] if self.evaluator.is_tree else self._regular_neighbours(self.start)
            self._generic.append(max(map(self._count_loads, places), default=None))
        return self._generic[0]

    def is_good(self, rest: StaticResidual) -> bool:
        """Return whether forces balance at a configuration of the mechanism."""
        return rest.is_balanced and self._is_closed(rest)

    def is_crossing(self, rest: StaticResidual) -> bool:
        """Return whether other directions are open at an equilibrium than on the branches through it."""
        if self.evaluator.is_tree:
            return False
        branch = explore_branch(self.evaluator.manifold(), rest.q)
        return branch.instantaneous != branch.dimension or len(branch.dimensions) > 1

    def is_regular(self, rest: StaticResidual) -> bool:
        """Return whether accelerations exist: where angles are singular, forces along them vanish anyway."""
        still = np.zeros(len(self.evaluator.eqs.speed_names))
        udot, signals = self.evaluator.compile("udot"), rest.inputs[self.balance.unknowns :]
        try:
            return bool(np.isfinite(udot(self.evaluator.t, rest.q, still, s=signals)).all())
        except SimulationError:
            return False

    def unwind(self, rest: StaticResidual) -> StaticResidual:
        """Return an equilibrium without full turns from the guess, unless springs distinguish these."""
        angles = [name in self.evaluator.angles for name in self.evaluator.eqs.coordinate_names]
        turns = np.where(angles, np.round((rest.q - self.start) / (2 * np.pi)), 0.0)
        if not turns.any():
            return rest
        largest = self.balance.largest_term(self.start)
        moved = self.balance.residual(rest.q - 2 * np.pi * turns, rest.inputs, largest, rest.bearing)
        return moved if self.is_good(moved) else rest

    def distance(self, rest: StaticResidual) -> float:
        """Return the distance of an equilibrium from the guess, the same for both signs of a quaternion."""
        apart = (rest.q - self.start) / self.evaluator.sizes
        for places in self.evaluator.quaternions():
            if rest.q[places] @ self.start[places] < 0.0:
                apart[places] = rest.q[places] + self.start[places]
        return float(np.linalg.norm(apart))

    def flat_directions(self, rest: StaticResidual) -> Floats:
        """Return the directions of free coordinates, in sizes, in which no force changes, as columns."""
        count = rest.unbalanced.size
        slopes, rows = rest.slopes[:count, self.free], rest.slopes[count:, self.free]
        tangent = null_space(rows, SHARP_RANK)
        _, singular, right = np.linalg.svd(slopes @ tangent)
        stiff = int((singular > SHARP_RANK * np.linalg.norm(slopes)).sum())
        return np.asarray(tangent @ right[stiff:].T)

    def _is_closed(self, rest: StaticResidual) -> bool:
        return rest.largest_gap <= ASSEMBLED and self.evaluator.is_aligned(rest.q)

    def undetermined_multipliers(self, rest: StaticResidual) -> Floats:
        """Return the changes of multipliers that change no force, as columns (n_c, k)."""
        rows = self.evaluator.velocity_rows(rest.q, {})[0] * self.evaluator.speed_sizes
        scales = self.balance.scales[:, np.newaxis]
        return np.asarray(null_space((rows / scales).T, SHARP_RANK) / scales)


@dataclass(frozen=True, slots=True)
class Neighbourhood:
    """The surroundings of an equilibrium.

    Attributes
    ----------
    doubt : str
        "critical" where the stiffness vanishes without further equilibria, "undecided" where branches cross,
        else empty.
    notes : tuple of str
        The same in sentences.
    """

    doubt: str
    notes: tuple[str, ...]


def examine_neighbourhood(search: EquilibriumSearch, equilibrium: StaticResidual) -> Neighbourhood:
    """Return whether other equilibria lie about one."""
    if search.is_crossing(equilibrium):
        note = (
            "branches of the motion cross at this configuration: forces do no work along any of them, so "
            "linear equations do not show whether it is stable"
        )
        return Neighbourhood("undecided", (note,))
    flat = search.flat_directions(equilibrium)
    if not flat.shape[1]:
        return Neighbourhood("", ())
    going, left = _split_directions(search, equilibrium, flat)
    notes = []
    if going.shape[1]:
        notes.append(
            f"equilibria form a continuum of {going.shape[1]} dimension(s) along "
            f"{_names(search, going)}; the result is the one closest to the guess"
        )
    if left.shape[1]:
        notes.append(
            f"the equilibrium is critical: its stiffness vanishes along {_names(search, left)}, but no "
            f"other equilibria lie near it; terms of higher order decide whether it is stable"
        )
    return Neighbourhood("critical" if left.shape[1] else "", tuple(notes))


def _split_directions(
    search: EquilibriumSearch, equilibrium: StaticResidual, flat: Floats
) -> tuple[Floats, Floats]:
    """Return the flat directions in which equilibria go on, and the others.

    From a step along each, Newton steps of least length lead to an equilibrium; across equilibria that go on
    they leave the step as it is, and back along directions in which a force of higher order stands.
    """
    free, sizes = search.free, search.evaluator.sizes
    moves = []
    for direction in flat.T:
        q = equilibrium.q.copy()
        q[free] += _STEP * direction * sizes[free]
        end = search.descend(search.evaluator.normalize(q), equilibrium.bearing)
        move = (end.q - equilibrium.q)[free] / sizes[free] / _STEP
        moves.append(flat.T @ move if search.is_good(end) else np.zeros(flat.shape[1]))
    left, singular, _ = np.linalg.svd(np.array(moves).T)
    count = int((singular > _STAYED).sum())
    return flat @ left[:, :count], flat @ left[:, count:]


def _names(search: EquilibriumSearch, directions: Floats) -> str:
    free = [name for name in search.evaluator.eqs.coordinate_names if name not in search.fixed]
    shares = np.abs(directions).max(axis=1)
    return ", ".join(n for n, share in zip(free, shares, strict=True) if share > _LISTED * shares.max())
