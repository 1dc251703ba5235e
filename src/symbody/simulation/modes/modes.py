"""Mechanisms whose equations change: joints that stick or slip, ropes that are taut or slack.

Each element has a mode, and there is one set of equations for all of them together, formed and compiled when
it first occurs. At an event the modes are found anew: those in which all that is assumed holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.simulation.events.events import Event
from symbody.simulation.methods.constraints import PROJECTED
from symbody.simulation.task import Task

Floats = NDArray[np.float64]
Modes = tuple[int, ...]

_MOST_TRIED: Final = 81  # modes of four joints at rest


class Kind(Protocol):
    """Elements of one kind, and what their modes are; places count within the kind."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements."""
        ...

    @property
    def seen(self) -> tuple[str, ...]:
        """What has to be known of their positions and rates, whatever the modes."""
        ...

    @property
    def outputs(self) -> tuple[str, ...]:
        """What has to be known of them in some modes, as many rows of outputs as `found` has."""
        ...

    @property
    def default(self) -> int:
        """A mode in which its equations can be formed wherever it is."""
        ...

    def applied(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations with all elements in some modes."""
        ...

    def ways(self, moment: Moment, seen: Floats) -> list[tuple[int, ...]]:
        """Return the modes each element may have, the likeliest first."""
        ...

    def overload(self, modes: Modes, found: Floats) -> Floats:
        """Return by how much each element is loaded beyond what its mode can bear; positive if it is."""
        ...

    def relieved(self, place: int, found: Floats) -> int:
        """Return the mode of an element that was overloaded."""
        ...

    def fits(self, trial: Trial, place: int, at: int, is_open: bool) -> bool:
        """Return whether the mode of an element holds; `at` is its place among all elements.

        `is_open` says that it had a choice, which no event made.
        """
        ...

    def event(self, trial: Trial, place: int, mode: int) -> Event:
        """Return what ends a mode."""
        ...

    def forced(self, trial: Trial, place: int, mode: int) -> Mapping[str, int]:
        """Return what the end of a mode decides about the next one, by name."""
        ...

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        ...


@dataclass(frozen=True, slots=True)
class Mechanism:
    """The equations for all modes, each formed and compiled when it first occurs."""

    task: Task
    kinds: tuple[Kind, ...]
    _tasks: dict[Modes, Task] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all elements, kind by kind."""
        return tuple(name for kind in self.kinds for name in kind.names)

    @property
    def places(self) -> Iterator[tuple[Kind, int]]:
        """The kind of each element, and its place there."""
        return ((kind, place) for kind in self.kinds for place in range(len(kind.names)))

    def parted(self, values: Sequence[Any]) -> list[tuple[Any, ...]]:
        """Return values of all elements kind by kind."""
        rest = iter(values)
        return [tuple(next(rest) for _ in kind.names) for kind in self.kinds]

    def of(self, modes: Modes) -> Task:
        """Return the equations in some modes."""
        if modes not in self._tasks:
            eqs = self.task.eqs
            formed = eqs.formed
            for kind, own in zip(self.kinds, self.parted(modes), strict=True):
                formed = kind.applied(formed, own)
            self._tasks[modes] = replace(self.task, eqs=EquationSet(eqs.model, formed, eqs.notes))
        return self._tasks[modes]

    def seen(self, t: float, x: Floats) -> list[Floats]:
        """Return what is known of each kind whatever the modes: a column an element."""
        return self._values(self.task, [kind.seen for kind in self.kinds], t, x)

    def found(self, modes: Modes, t: float, x: Floats) -> list[Floats]:
        """Return what has to be known of each kind in some modes: a column an element."""
        return self._values(self.of(modes), [kind.outputs for kind in self.kinds], t, x)

    def _values(self, task: Task, names: Sequence[tuple[str, ...]], t: float, x: Floats) -> list[Floats]:
        values = iter(outputs_at(task, [name for own in names for name in own], t, x))
        found = []
        for kind, words in zip(self.kinds, names, strict=True):
            own = np.array([next(values) for _ in words], dtype=np.float64)
            found.append(own.reshape(-1, len(kind.names)))
        return found

    def held(self, modes: Modes, t: float, x: Floats) -> Floats:
        """Return a state whose speeds fit the constraints of some modes."""
        task = self.of(modes)
        if not task.is_closed:
            return x
        result = x.copy()
        result[: len(task.eqs.speed_names)] += outputs_at(task, PROJECTED, t, x)[3]
        return result


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """Modes that are tried at one time."""

    mechanism: Mechanism
    modes: Modes
    t: float
    x: Floats
    moment: Moment | None = None
    _found: list[list[Floats]] = field(default_factory=list)

    def found(self, kind: Kind) -> Floats:
        """Return what is known of a kind, with speeds that fit the modes."""
        if not self._found:
            held = self.mechanism.held(self.modes, self.t, self.x)
            self._found.append(self.mechanism.found(self.modes, self.t, held))
        return next(own for k, own in zip(self.mechanism.kinds, self._found[0], strict=True) if k is kind)

    def other(self, place: int, mode: int) -> Trial:
        """Return the trial with another mode of one element."""
        return replace(self, modes=(*self.modes[:place], mode, *self.modes[place + 1 :]), _found=[])


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """A moment at which modes are looked for.

    Attributes
    ----------
    before : mapping of name to mode
        The modes that ended, as far as they still tell something.
    forced : mapping of name to mode
        What an event decided.
    small : float
        Rates below it are rest: of angles [1/s], of displacements times the length of the mechanism.
    length : float
        The length of the mechanism [m].
    """

    t: float
    x: Floats
    before: Mapping[str, int]
    forced: Mapping[str, int]
    small: float
    length: float


def resolved(mechanism: Mechanism, moment: Moment) -> Modes | None:
    """Return modes in which what is held can be held and what moves does so in its direction; None: none.

    Elements that have a choice are held if they can be.
    """
    t, x = moment.t, moment.x
    kinds = zip(mechanism.kinds, mechanism.seen(t, x), strict=True)
    ways = [way for kind, seen in kinds for way in kind.ways(moment, seen)]
    modes = [way[0] for way in ways]
    for _ in range(len(modes)):  # the one most overloaded first: that often frees or loads the others
        trial = Trial(mechanism, tuple(modes), t, x, moment)
        parts = zip(mechanism.kinds, mechanism.parted(modes), strict=True)
        over = np.concatenate([kind.overload(own, trial.found(kind)) for kind, own in parts])
        over[[len(way) == 1 for way in ways]] = -np.inf
        k = int(np.argmax(over))
        if not over[k] > 0.0:
            break
        kind, place = list(mechanism.places)[k]
        modes[k] = kind.relieved(place, trial.found(kind))
    for candidate in (tuple(modes), *_others(ways)):
        if _is_consistent(Trial(mechanism, candidate, t, x, moment), ways, moment):
            return candidate
    return None


def _others(ways: Sequence[tuple[int, ...]]) -> Iterator[Modes]:
    for tried, candidate in enumerate(product(*ways)):
        if tried == _MOST_TRIED:
            return
        yield candidate


def _is_consistent(trial: Trial, ways: Sequence[tuple[int, ...]], moment: Moment) -> bool:
    for k, (kind, place) in enumerate(trial.mechanism.places):
        is_open = len(ways[k]) > 1 and kind.names[place] not in moment.forced
        if not kind.fits(trial, place, k, is_open):
            return False
    return True


def outputs_at(task: Task, names: Sequence[str], t: float, x: Floats) -> tuple[Any, ...]:
    """Return outputs at one time and state."""
    n_u = len(task.eqs.speed_names)
    q, u = x[n_u:], x[:n_u]
    found = task.compiled(names)(t, q, u, task.laws.at(t, q, u))
    return tuple(found) if len(names) > 1 else (found,)
