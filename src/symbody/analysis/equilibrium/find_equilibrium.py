"""`find_equilibrium`: configurations at which nothing moves, the nearest to a guess first.

Newton steps of least length (Nocedal & Wright 2006, section 10.3) on the forces that multipliers cannot
balance together with the constraints, from the guess and from starts about it, the same at every call.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.assembly import CLOSED, assemble
from symbody.analysis.closure import Closure, closure
from symbody.analysis.equilibrium.balance import Balance, Rest, balance
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.linearize import linearize
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments
from symbody.codegen.compile import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, SimulationError, nearest
from symbody.single_flight import SingleFlight

Floats = NDArray[np.float64]

_STARTS: Final = 24
_STEPS: Final = 60
# How often a step is halved: what does not help by then ends in a valley without equilibrium; where all
# equations hold to rounding, steps only polish.
_HALVINGS: Final = 12
_POLISHED: Final = 1e-12
_POLISHINGS: Final = 2
_DECREASE: Final = 1e-3  # of what a full step promises (Nocedal & Wright 2006, equation 3.4)
_MOVING: Final = 1e-9
_SMALL: Final = 1e-10  # of the largest singular value: directions in which nothing changes
_FLAT: Final = 1e-8  # the same, at an equilibrium
_VERDICTS: Final = {"stable": True, "unstable": False}


@dataclass(frozen=True, slots=True, eq=False)
class Equilibrium(State):
    """A state at rest.

    Attributes
    ----------
    notes : tuple of str
        What should be known about it.
    """

    notes: tuple[str, ...] = ()
    _linear: SingleFlight[None, Linearization] = field(default_factory=SingleFlight, repr=False)

    @property
    def linearization(self) -> Linearization:
        """The equations of small deviations from it."""
        return self._linear.get(None, lambda: linearize(self.eqs, self))

    @property
    def verdict(self) -> str:
        """What linear equations say: "stable", "unstable", "drifting" or "marginal"; see `Linearization`."""
        return self.linearization.verdict

    @property
    def stable(self) -> bool | None:
        """True if all small deviations die out, False if some grow, None if linear equations do not tell."""
        return _VERDICTS.get(self.verdict)


@checked_arguments
def find_equilibrium(
    eqs: EquationSet,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    unknowns: str | Sequence[str] = (),
    fixed: Mapping[str, Value] | None = None,
    t: float = 0.0,
    *,
    scales: Mapping[str, float] | None = None,
) -> Equilibrium:
    """Return the equilibrium nearest to a guess, with others found as its ``branches``.

    Parameters
    ----------
    guess : mapping of name to number or formula
        Coordinates near which to look; by default the model's initial values, then 0. Where equilibria form a
        continuum, the one that is reached by the shortest steps is taken, with a note.
    inputs : mapping of name to number or formula
        Constant, by default 0; formulas may read the state.
    unknowns : str or sequence of str
        Inputs that take whatever value holds the mechanism; they are in ``inputs`` of the result.
    fixed : mapping of name to number or formula
        Coordinates that keep these values, as a rule with inputs unknown.
    t : float
        Time at which motions and forces that depend on it are frozen [s].
    scales : mapping of "length", "time", "mass" to float, optional
        What counts as large [m, s, kg]; by default it follows from the model, see `assemble`.

    Raises
    ------
    AssemblyError
        If the loops do not close, a motion in time leaves no rest, or forces balance nowhere near the guess:
        with what is left of them at the best configuration, and along which speed.
    """
    first = assemble(eqs, fixed, guess, parameters, dict(inputs or {}), t, scales=scales)
    unknowns = (unknowns,) if isinstance(unknowns, str) else unknowns
    _check(eqs, unknowns, fixed or {})
    known = mechanism_scales(eqs, dict(parameters or {}), scales, first.q)
    task = closure(eqs, dict(parameters or {}), dict(inputs or {}), t, known)
    search = _Search(balance(task, unknowns), np.array(list(first.q.values())), frozenset(fixed or ()))
    search.check_at_rest()
    found = search.equilibria()
    states = [_state(search, rest, unknowns) for rest in found]
    return replace(states[0], _others=partial(tuple, states[1:]))


def _check(eqs: EquationSet, unknowns: Sequence[str], fixed: Mapping[str, Value]) -> None:
    problems = [
        Problem("equilibrium.unknown_name", name, f"there is no {word} {name!r}", "", nearest(name, known))
        for word, names, known in (
            ("input", unknowns, eqs.input_names),
            ("coordinate in q", fixed, eqs.coordinate_names),
        )
        for name in names
        if name not in known
    ]
    if problems:
        raise AssemblyError(*problems)


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Where to look for equilibria from."""

    balance: Balance
    start: Floats
    fixed: frozenset[str]

    @property
    def task(self) -> Closure:
        """The constraints."""
        return self.balance.task

    def check_at_rest(self) -> None:
        """Refuse constraints that demand motion.

        Raises
        ------
        AssemblyError
            Naming the rows.
        """
        task = self.task
        drift = task.velocity_rows(self.start, {})[1] / task.mechanism.constraints(task.eqs)
        fast = _MOVING / task.mechanism.time
        moving = [name for name, b in zip(task.eqs.multiplier_names, drift, strict=True) if abs(b) > fast]
        if moving:
            raise AssemblyError(
                Problem("equilibrium.moving", ", ".join(moving), "these constraints demand motion",
                        f"they depend on time, at t = {task.t:g} s with rates", "give a t at which they rest")
            )  # fmt: skip

    def equilibria(self) -> list[Rest]:
        """Return different equilibria, the nearest first.

        Raises
        ------
        AssemblyError
            If there is none.
        """
        largest = self.balance.largest(self.start)
        attempts = [self._newton(q, largest) for q in self._starts()]
        turned = [self._unwound(rest, largest) for rest in attempts if self._is_good(rest)]
        good = sorted(filter(self._is_regular, turned), key=self._distance)
        if turned and not good:
            raise AssemblyError(_singular(self.task, turned[0].q))
        if not good:
            raise AssemblyError(self._why(attempts, largest))
        found = [good[0]]
        for rest in good[1:]:
            isolated = self.free_directions(rest).shape[1] == 0
            if isolated and all(self.task.differs(rest.q, other.q) for other in found):
                found.append(rest)
        return found

    def free_directions(self, rest: Rest) -> Floats:
        """Return the directions of q in which equilibria continue, as columns."""
        rows = rest.rows[:, self.task.free(dict.fromkeys(self.fixed, 0.0))]
        if not rows.shape[1]:
            return rows[:0]
        singular, right = np.linalg.svd(rows)[1:]
        count = int((singular > _FLAT * singular.max(initial=1e-300)).sum())
        return np.asarray(right[count:].T)

    def _is_good(self, rest: Rest) -> bool:
        opened = np.abs(rest.values[rest.left.size :]).max(initial=0.0)
        return rest.is_balanced and opened <= CLOSED * self.task.size and self.task.is_aligned(rest.q)

    def _is_regular(self, rest: Rest) -> bool:
        """Return whether accelerations exist: where angles are singular, forces along them vanish anyway."""
        still = np.zeros(len(self.task.eqs.speed_names))
        try:
            return bool(np.isfinite(self.task.function("udot")(self.task.t, rest.q, still)).all())
        except SimulationError:
            return False

    def _unwound(self, rest: Rest, largest: float) -> Rest:
        """Return an equilibrium without full turns from the guess, unless springs tell these apart."""
        angles = [name in self.task.angles for name in self.task.eqs.coordinate_names]
        turns = np.where(angles, np.round((rest.q - self.start) / (2 * np.pi)), 0.0)
        if not turns.any():
            return rest
        moved = self.balance.rest(rest.q - 2 * np.pi * turns, rest.inputs, largest)
        return moved if self._is_good(moved) else rest

    def _starts(self) -> list[Floats]:
        random = np.random.default_rng(1)
        free = self.task.free(dict.fromkeys(self.fixed, 0.0))
        starts = [self.start]
        for k in range(1, _STARTS):
            moved = self.start.copy()
            moved[free] += 0.1 * 1.2**k * random.standard_normal(int(free.sum())) * self.task.sizes[free]
            starts.append(self.task.normalized(moved))
        return starts

    def _newton(self, q: Floats, largest: float) -> Rest:
        """Return where steps of least length lead."""
        free = self.task.free(dict.fromkeys(self.fixed, 0.0))
        sizes = self.task.sizes
        rest = self.balance.rest(q, np.zeros(self.balance.unknowns), largest)
        for _ in range(_STEPS):
            if not (np.isfinite(rest.merit) and np.isfinite(rest.rows).all()) or rest.merit == 0.0:
                break
            step = np.linalg.lstsq(rest.rows[:, free], -rest.values, rcond=_SMALL)[0]
            share = min(1.0, 1.0 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
            for _ in range(_HALVINGS if rest.merit > _POLISHED else _POLISHINGS):
                moved = rest.q.copy()
                moved[free] += share * step * sizes[free]
                tried = self.balance.rest(self.task.normalized(moved), rest.inputs, largest)
                if tried.merit < (1.0 - _DECREASE * share) * rest.merit:
                    break
                share /= 2.0
            else:
                break
            rest = tried
        return rest

    def _distance(self, rest: Rest) -> float:
        """Return how far an equilibrium is from the guess, the same way for both signs of a quaternion."""
        apart = (rest.q - self.start) / self.task.sizes
        for places in self.task.quaternions():
            if rest.q[places] @ self.start[places] < 0.0:
                apart[places] = rest.q[places] + self.start[places]
        return float(np.linalg.norm(apart))

    def _why(self, attempts: list[Rest], largest: float) -> Problem:
        """Say what is left of the forces where least is left."""
        finite = [rest for rest in attempts if np.isfinite(rest.merit)]
        eqs = self.task.eqs
        if not finite:
            what = "the forces are not finite"
        else:
            best = min(finite, key=lambda rest: rest.merit)
            k = int(np.argmax(np.abs(best.left))) if best.left.size else 0
            name = eqs.speed_names[k]
            unit = "N" if eqs.units.get(name) == "m/s" else "N m"
            force = best.left[k] * largest / self.balance.sizes[k]
            place = ", ".join(f"{q} = {x:.4g}" for q, x in zip(eqs.coordinate_names, best.q, strict=True))
            what = f"along {name} {force:.4g} {unit} are not balanced, where least is left ({place})"
        return Problem(
            "equilibrium.none", eqs.model.name, what, f"{_STARTS} starts about the guess were tried",
            "hold what moves by a joint, a spring or an unknown input, or give guess= nearer to a balance",
        )  # fmt: skip


def _singular(task: Closure, q: Floats) -> Problem:
    place = ", ".join(f"{name} = {x:.4g}" for name, x in zip(task.eqs.coordinate_names, q, strict=True))
    return Problem(
        "equilibrium.singular", task.eqs.model.name, "forces balance only where no acceleration exists",
        f"at {place} angles are singular, or no mass resists some motion",
        "take a quaternion or other angles, give mass to what moves, or give guess= nearer to a balance",
    )  # fmt: skip


def _state(search: _Search, rest: Rest, unknowns: Sequence[str]) -> Equilibrium:
    task, eqs = search.task, search.task.eqs
    order = [name for name in eqs.input_names if name in unknowns]
    held = dict(zip(order, rest.inputs.tolist(), strict=True))
    if held:
        task = closure(eqs, task.parameters, {**task.inputs, **held}, task.t, task.mechanism)
    state = task.state(rest.q, np.zeros(len(eqs.speed_names)), search.start, {})
    notes = list(task.mechanism.notes(eqs))
    loose = search.free_directions(rest)
    if loose.shape[1]:
        free = [name for name in eqs.coordinate_names if name not in search.fixed]
        shares = np.abs(loose).max(axis=1)
        names = [name for name, share in zip(free, shares, strict=True) if share > _FLAT * shares.max()]
        notes.append(
            f"equilibria form a continuum of {loose.shape[1]} dimension(s) along {', '.join(names)}: "
            "the one nearest to the guess by the shortest steps is given"
        )
    if search.balance.timed:
        notes.append(f"forces or motions depend on time: they are frozen at t = {task.t:g} s")
    if eqs.formed.friction:
        notes.append("friction is 0 at rest: sticking holds more configurations than this")
    known = {entry.name: getattr(state, entry.name) for entry in fields(State)}
    return Equilibrium(**known, notes=tuple(notes))
