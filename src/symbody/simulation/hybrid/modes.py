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
from symbody.simulation.simulation_problem import OutputName, SimulationProblem

Floats = NDArray[np.float64]
Modes = tuple[int, ...]

_MOST_TRIED: Final = 81  # modes of four joints at rest


class SwitchingElements(Protocol):
    """Elements of one kind, and what their modes are; places count within the kind."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the elements."""
        ...

    @property
    def motion_outputs(self) -> tuple[str, ...]:
        """Outputs that give their positions and rates, whatever the modes."""
        ...

    @property
    def outputs(self) -> tuple[str, ...]:
        """Outputs that decide whether modes hold, one row after the other, in the equations of some modes."""
        ...

    @property
    def default(self) -> int:
        """A mode in which its equations can be formed wherever it is."""
        ...

    def apply_modes(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations with all elements in some modes."""
        ...

    def candidates(self, state: HybridState, motion: Floats) -> list[tuple[int, ...]]:
        """Return the modes each element may have, the likeliest first."""
        ...

    def violation(self, modes: Modes, values: Floats) -> Floats:
        """Return by how much each element is loaded beyond what its mode can bear; positive if it is."""
        ...

    def next_mode(self, place: int, values: Floats) -> int:
        """Return the mode of an element that was overloaded."""
        ...

    def is_consistent(self, trial: ModeTrial, place: int, element: int, is_open: bool) -> bool:
        """Return whether the mode of an element holds; `element` is its place among those of all kinds.

        `is_open`: it had several candidates, and no event decided between them.
        """
        ...

    def end_event(self, trial: ModeTrial, place: int, mode: int) -> Event:
        """Return what ends a mode."""
        ...

    def forced_modes(self, trial: ModeTrial, place: int, mode: int) -> Mapping[str, int]:
        """Return what the end of a mode decides about the next one, by name."""
        ...

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        ...


@dataclass(frozen=True, slots=True)
class HybridMechanism:
    """The equations for all modes, each formed and compiled when it first occurs."""

    problem: SimulationProblem
    kinds: tuple[SwitchingElements, ...]
    _problems: dict[Modes, SimulationProblem] = field(default_factory=dict)

    @property
    def elements(self) -> Iterator[tuple[SwitchingElements, int]]:
        """The kind of each element, and its place there."""
        return ((kind, place) for kind in self.kinds for place in range(len(kind.names)))

    def split_by_kind(self, values: Sequence[Any]) -> list[tuple[Any, ...]]:
        """Return values of all elements kind by kind."""
        remaining = iter(values)
        return [tuple(next(remaining) for _ in kind.names) for kind in self.kinds]

    def problem_in(self, modes: Modes) -> SimulationProblem:
        """Return the problem with the equations of some modes."""
        if modes not in self._problems:
            eqs = self.problem.eqs
            # Kept with the equations: the next motion has the same modes.
            in_modes = eqs.plans.get(("modes", modes), lambda: self._form(modes))
            self._problems[modes] = replace(self.problem, eqs=in_modes)
        return self._problems[modes]

    def _form(self, modes: Modes) -> EquationSet:
        eqs = self.problem.eqs
        formed = eqs.formed
        for kind, kind_modes in zip(self.kinds, self.split_by_kind(modes), strict=True):
            formed = kind.apply_modes(formed, kind_modes)
        return EquationSet(eqs.model, formed, eqs.notes)

    def motion_values(self, t: float, x: Floats) -> list[Floats]:
        """Return the motion outputs of each kind: a column an element."""
        return self._values(self.problem, [kind.motion_outputs for kind in self.kinds], t, x)

    def values(self, modes: Modes, t: float, x: Floats) -> list[Floats]:
        """Return the outputs of each kind in some modes: a column an element."""
        return self._values(self.problem_in(modes), [kind.outputs for kind in self.kinds], t, x)

    def _values(
        self, problem: SimulationProblem, names: Sequence[tuple[str, ...]], t: float, x: Floats
    ) -> list[Floats]:
        all_names = tuple(name for kind_names in names for name in kind_names)
        flat = iter(evaluate_outputs(problem, (all_names,), t, x)[0])
        arrays = []
        for kind, kind_names in zip(self.kinds, names, strict=True):
            values = np.array([next(flat) for _ in kind_names], dtype=np.float64)
            arrays.append(values.reshape(-1, len(kind.names)))
        return arrays

    def fit_speeds(self, modes: Modes, t: float, x: Floats) -> Floats:
        """Return a state whose speeds fit the constraints of some modes."""
        problem = self.problem_in(modes)
        if not problem.is_closed:
            return x
        result = x.copy()
        result[: len(problem.eqs.speed_names)] += evaluate_outputs(problem, PROJECTED, t, x)[3]
        return result


@dataclass(frozen=True, slots=True, eq=False)
class ModeTrial:
    """Modes that are tried at one time."""

    mechanism: HybridMechanism
    modes: Modes
    t: float
    x: Floats
    state: HybridState | None = None
    _values: list[list[Floats]] = field(default_factory=list)

    def values(self, kind: SwitchingElements) -> Floats:
        """Return the outputs of a kind, with speeds that fit the modes."""
        if not self._values:
            x = self.mechanism.fit_speeds(self.modes, self.t, self.x)
            self._values.append(self.mechanism.values(self.modes, self.t, x))
        pairs = zip(self.mechanism.kinds, self._values[0], strict=True)
        return next(values for other, values in pairs if other is kind)

    def with_mode(self, element: int, mode: int) -> ModeTrial:
        """Return the trial with another mode of one element."""
        modes = (*self.modes[:element], mode, *self.modes[element + 1 :])
        return replace(self, modes=modes, _values=[])


@dataclass(frozen=True, slots=True, eq=False)
class HybridState:
    """A state at which modes are looked for.

    Attributes
    ----------
    before : mapping of name to mode
        The modes that ended, as far as they still matter.
    forced_modes : mapping of name to mode
        What an event decided.
    small : float
        Rates below it are rest: of angles [1/s], of displacements times the length of the mechanism.
    length : float
        The length of the mechanism [m].
    """

    t: float
    x: Floats
    before: Mapping[str, int]
    forced_modes: Mapping[str, int]
    small: float
    length: float


def find_modes(mechanism: HybridMechanism, state: HybridState) -> Modes | None:
    """Return modes in which all constraints can hold, and what moves does so in its direction; None: none.

    Elements with several candidates are held if they can be.
    """
    t, x = state.t, state.x
    kinds = zip(mechanism.kinds, mechanism.motion_values(t, x), strict=True)
    candidates = [some for kind, motion in kinds for some in kind.candidates(state, motion)]
    trial = ModeTrial(mechanism, tuple(some[0] for some in candidates), t, x, state)
    is_open = any(len(some) > 1 for some in candidates)
    # the one most overloaded first: that often frees or loads the others
    for _ in range(len(candidates) if is_open else 0):
        parts = zip(mechanism.kinds, mechanism.split_by_kind(trial.modes), strict=True)
        excess = np.concatenate([kind.violation(some, trial.values(kind)) for kind, some in parts])
        excess[[len(some) == 1 for some in candidates]] = -np.inf
        k = int(np.argmax(excess))
        if not excess[k] > 0.0:
            break
        kind, place = list(mechanism.elements)[k]
        trial = trial.with_mode(k, kind.next_mode(place, trial.values(kind)))
    if _is_consistent(trial, candidates, state):
        return trial.modes
    trials = (ModeTrial(mechanism, modes, t, x, state) for modes in _combinations(candidates))
    return next((trial.modes for trial in trials if _is_consistent(trial, candidates, state)), None)


def _combinations(candidates: Sequence[tuple[int, ...]]) -> Iterator[Modes]:
    for count, modes in enumerate(product(*candidates)):
        if count == _MOST_TRIED:
            return
        yield modes


def _is_consistent(trial: ModeTrial, candidates: Sequence[tuple[int, ...]], state: HybridState) -> bool:
    for k, (kind, place) in enumerate(trial.mechanism.elements):
        is_open = len(candidates[k]) > 1 and kind.names[place] not in state.forced_modes
        if not kind.is_consistent(trial, place, k, is_open):
            return False
    return True


def evaluate_outputs(
    problem: SimulationProblem, names: Sequence[OutputName], t: float, x: Floats
) -> tuple[Any, ...]:
    """Return outputs at one time and state x = (u, q); those of a tuple of names as one array."""
    n_u = len(problem.eqs.speed_names)
    q, u = x[n_u:], x[:n_u]
    values = problem.compile_outputs(names)(t, q, u, problem.laws.evaluate(t, q, u))
    return tuple(values) if len(names) > 1 else (values,)
