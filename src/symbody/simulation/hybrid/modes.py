"""Mechanisms whose equations change: joints that stick or slip, ropes that are taut or slack.

Each element has a mode, and there is one set of equations for all of them together, formed and compiled when
it first occurs. At an event the modes are found anew: those in which all that is assumed holds.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.mode_decision import ModeNumbers, Opening, mode_numbers
from symbody.analysis.modes.reduced_modes import ModeVerdict
from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.output_roots import OF_MODES
from symbody.simulation.events.events import Event
from symbody.simulation.methods.constraints import PROJECTED
from symbody.simulation.simulation_problem import OutputName, SimulationProblem

Floats = NDArray[np.float64]
Modes = tuple[int, ...]


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
        """Outputs in the equations of some modes, row by row; NaN where these have no solution."""
        ...

    @property
    def default(self) -> int:
        """A mode in which its equations can be formed wherever it is."""
        ...

    @property
    def free(self) -> int:
        """A mode in which it holds nothing."""
        ...

    def apply_modes(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations with all elements in some modes."""
        ...

    def openings(
        self, state: HybridState, motion: Floats, accelerations: Mapping[str, float]
    ) -> dict[str, Opening]:
        """Return what is known of each element before modes are decided.

        Accelerations are those of a first decision, empty before there is one.
        """
        ...

    def mode_of(self, kernel_mode: int) -> int:
        """Return the mode for one of `kernels.modes`."""
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

    def numbers(self, t: float, x: Floats) -> ModeNumbers:
        """Return what decides about modes at a state."""
        problem = self.problem
        values = evaluate_outputs(problem, (OF_MODES,), t, x)[0]
        return mode_numbers(problem.eqs, values, problem.scales)

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
    _values: list[list[Floats]] = field(default_factory=list)

    def values(self, kind: SwitchingElements) -> Floats:
        """Return the outputs of a kind, with speeds that fit the modes."""
        if not self._values:
            x = self.mechanism.fit_speeds(self.modes, self.t, self.x)
            self._values.append(self.mechanism.values(self.modes, self.t, x))
        pairs = zip(self.mechanism.kinds, self._values[0], strict=True)
        return next(values for other, values in pairs if other is kind)


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


def find_modes(mechanism: HybridMechanism, state: HybridState) -> tuple[Modes | None, ModeVerdict]:
    """Return modes in which all constraints can hold, and what moves does so in its direction; None: none."""
    t, x = state.t, state.x
    kinds = list(zip(mechanism.kinds, mechanism.motion_values(t, x), strict=True))
    numbers = mechanism.numbers(t, x)
    first = _openings(kinds, state, {})
    found = numbers.decide(first)
    again = _openings(kinds, state, dict(zip(numbers.names, found.accelerations.tolist(), strict=True)))
    if again != first:
        found = numbers.decide(again)
    if found.verdict is not ModeVerdict.ONE:
        return None, found.verdict
    by_name = dict(zip(numbers.names, found.modes, strict=True))
    elements = [(kind, kind.names[place]) for kind, place in mechanism.elements]
    modes = tuple(kind.mode_of(by_name[name]) for kind, name in elements)
    trial = ModeTrial(mechanism, modes, t, x)
    # the equations of these modes say where friction has no one solution although all efforts are known here
    holds = all(np.isfinite(trial.values(kind)).all() for kind, _ in kinds)
    return (modes, ModeVerdict.ONE) if holds else (None, ModeVerdict.NOT_FOUND)


def _openings(
    kinds: Sequence[tuple[SwitchingElements, Floats]], state: HybridState, accelerations: Mapping[str, float]
) -> dict[str, Opening]:
    found: dict[str, Opening] = {}
    for kind, motion in kinds:
        found |= kind.openings(state, motion, accelerations)
    return found


def evaluate_outputs(
    problem: SimulationProblem, names: Sequence[OutputName], t: float, x: Floats
) -> tuple[Any, ...]:
    """Return outputs at one time and state x = (u, q); those of a tuple of names as one array."""
    n_u = len(problem.eqs.speed_names)
    q, u = x[n_u:], x[:n_u]
    values = problem.compile_outputs(names)(t, q, u, problem.laws.evaluate(t, q, u))
    return tuple(values) if len(names) > 1 else (values,)
