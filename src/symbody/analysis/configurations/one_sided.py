"""`settle`: which gaps are closed and which dry joints stick at a state, so that all that is assumed holds.

A gap that is closed stays so by an effort, or opens; a joint at rest is held within its static limit, or
slips in its direction; this is decided as in `simulate`. Whatever follows from its equations holds for small
deviations, unless an element stands at the edge between two modes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.configurations.closed_gaps import AT_LENGTH, gap_shares, with_closed_gaps
from symbody.analysis.configurations.gap_words import gap_words
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.modes.mode_decision import OPEN, UNDECIDED, Opening, mode_numbers
from symbody.analysis.modes.reduced_modes import ModeVerdict
from symbody.analysis.state import State
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import OF_MODES
from symbody.equations.solving.sticking import STICKS, set_modes, switching_joints
from symbody.equations.solving.unilateral import element_words, unilateral_elements
from symbody.errors import AssemblyError, SimulationError
from symbody.kernels.modes.mode_problem import HOLDS, LOOSE
from symbody.tolerances import AT_REST, BALANCED

Floats = NDArray[np.float64]
Modes = dict[str, int]

_OPEN: Final = 2  # beside the modes of joints: sticking and the signs of slipping
_CLOSED: Final = 3


@dataclass(frozen=True, slots=True, eq=False)
class OneSidedState:
    """The modes of ropes, stops and dry joints at a state.

    Attributes
    ----------
    eqs : EquationSet
        With the constraints of closed gaps and joints that stick.
    state : State
        With their accelerations and multipliers.
    notes : tuple of str
        The mode of each element.
    edges : tuple of str
        Elements that could do either: what holds on one side of the state does not hold on the other.
    """

    eqs: EquationSet
    state: State
    notes: tuple[str, ...] = ()
    edges: tuple[str, ...] = ()


def settle(eqs: EquationSet, state: State) -> OneSidedState:
    """Return the modes of ropes, stops and dry joints at a state of these equations."""
    search = _search(eqs, state)
    if all(opening.is_decided and name not in search.gaps for name, opening in search.openings.items()):
        return OneSidedState(eqs, state)
    modes = search.decide()
    found = None if modes is None else search.state_in(modes)
    if found is not None:
        return found
    held = {name: search.mode_of(name, HOLDS) for name in search.openings if search.is_open(name)}
    kept = search.state_in(held) or OneSidedState(eqs, state)
    names = tuple(search.openings)
    which = "closed and open gaps, sticking and slipping"
    note = f"{', '.join(names)}: no combination of {which} holds at this state"
    return OneSidedState(kept.eqs, kept.state, (note,), names)


@dataclass(frozen=True, slots=True, eq=False)
class _ModeSearch:
    """The elements of a state and what is known of their modes; joints that move keep their own laws."""

    eqs: EquationSet
    state: State
    q: Floats
    u: Floats
    length: float
    gaps: Mapping[str, float]  # sizes of the gaps, by element
    openings: Mapping[str, Opening]

    def decide(self) -> Modes | None:
        """Return the modes of ropes and stops and of joints at rest, None where there are none."""
        state = self.state
        evaluator = constraint_evaluator(
            self.eqs, state.parameters, state.inputs, state.t, signals=self._signals()
        )
        values = evaluator.compile(OF_MODES)(evaluator.t, self.q, self.u, s=evaluator.signals)
        numbers = mode_numbers(self.eqs, values, evaluator.mechanism)
        found = numbers.decide(self.openings)
        if found.verdict is not ModeVerdict.ONE:
            return None
        modes = dict(zip(numbers.names, found.modes, strict=True))
        chosen = [name for name in self.openings if name in self.gaps or self.is_open(name)]
        return {name: self.mode_of(name, modes.get(name, LOOSE)) for name in chosen}

    def is_open(self, name: str) -> bool:
        """Return whether forces decide about an element."""
        return not self.openings[name].is_decided

    def mode_of(self, name: str, kernel_mode: int) -> int:
        """Return the mode of an element for one of `kernels.modes`."""
        if name in self.gaps:
            return _CLOSED if kernel_mode == HOLDS else _OPEN
        return kernel_mode

    def _signals(self) -> Floats:
        return np.array(list(self.state.s.values()), dtype=np.float64)

    def state_in(self, modes: Modes) -> OneSidedState | None:
        """Return the state in some modes; None where no accelerations exist."""
        held = self._equations(modes)
        state = self.state
        evaluator = constraint_evaluator(
            held, state.parameters, state.inputs, state.t, signals=self._signals()
        )
        try:
            state = complete_state(evaluator, self.q, self.u, self.q, {})
        except (AssemblyError, SimulationError):
            return None
        scales = self._scales(evaluator, state)
        values = self._deciding_values(held, state, modes)
        if not np.isfinite(list(values.values())).all():
            return None
        notes, edges = [], []
        for name, mode in modes.items():
            limit = BALANCED * (scales[0] / self.unit(name) if mode in (STICKS, _CLOSED) else
                             scales[1] * self.unit(name))  # fmt: skip
            value = values[name] if abs(values[name]) > limit else 0.0
            surplus, note = self._surplus(value, name, mode)
            notes.append(note)
            if self.is_open(name) and abs(surplus) <= limit:
                edges.append(name)
                notes.append(f"{self._element(name)} switches at this state: statements about small "
                             f"deviations hold on one side of it at most")  # fmt: skip
        return OneSidedState(held, state, tuple(notes), tuple(edges))

    def _equations(self, modes: Modes) -> EquationSet:
        """Return the equations in some modes."""
        held = with_closed_gaps(self.eqs, [name for name in self.gaps if modes.get(name) == _CLOSED])
        joints = {name: mode for name, mode in modes.items() if name not in self.gaps}
        if not joints:
            return held
        # Kept with the equations, as their code is: who linearizes looks at the same modes again.
        settled: EquationSet = held.plans.get(
            ("modes of joints", tuple(joints.items())),
            lambda: EquationSet(held.model, set_modes(held.formed, joints), held.notes),
        )
        return settled

    def _deciding_values(self, held: EquationSet, state: State, modes: Modes) -> dict[str, float]:
        """Return the value of each element that decides whether its mode holds."""
        outputs = {name: self._deciding_output(name, mode) for name, mode in modes.items() if mode != STICKS}
        # Reserves are one output: each by itself would be computed from the accelerations of all bodies.
        contacts = [name for name, mode in modes.items() if mode == STICKS and self.is_contact(name)]
        reserves = ("friction_reserve",) if len(outputs) + len(contacts) < len(modes) else ()
        both = [f"friction_reserve {name}" for name in contacts]
        values = state.values_of((*outputs.values(), *reserves, *both))
        deciding = {name: float(values[output]) for name, output in outputs.items()}
        if reserves:
            names = [law.name for law in held.formed.friction]
            by_joint = dict(zip(names, np.ravel(values["friction_reserve"]).tolist(), strict=True))
            stuck = [name for name, mode in modes.items() if mode == STICKS and name not in contacts]
            deciding |= {name: by_joint[name] for name in stuck}
        deciding |= {name: float(values[output]) for name, output in zip(contacts, both, strict=True)}
        return deciding

    def _deciding_output(self, name: str, mode: int) -> str:
        """Return the output whose value decides whether a closed or open gap, or a joint that slips, does."""
        if mode in (_CLOSED, _OPEN):
            return f"opening_effort {name}" if mode == _CLOSED else f"gap_ddot {name}"
        if self.is_contact(name):
            return f"friction_normal {name}"  # it slips along its acceleration, whatever that is
        return f"{self.coordinate(name)}_ddot"

    def _surplus(self, value: float, name: str, mode: int) -> tuple[float, str]:
        """Return a number that is positive where a mode holds, and the mode in a sentence."""
        if mode == _CLOSED:
            words = gap_words(self.eqs, name)
            return value, f"{words.with_effort(value)}: it constrains small deviations"
        if mode == _OPEN:
            words = gap_words(self.eqs, name)
            return value, f"{words.subject} is {words.open}: it constrains nothing"
        if mode == STICKS:
            return value, (
                f"{self._subject(name)} sticks, {value:.6g} below its static limit: it does not move, and "
                f"every position where it sticks is an equilibrium of this joint"
                if not self.is_contact(name)
                else f"{self._subject(name)} sticks, {value:.6g} below its static limit"
            )
        if self.is_contact(name):
            return value, f"{self._subject(name)} begins to slip"
        way = "forward" if mode > 0 else "backward"
        return mode * value, f"{self._subject(name)} begins to slip {way}"

    def unit(self, name: str) -> float:
        """Return the size of displacements of an element: a length, or 1 for an angle."""
        if name in self.gaps:
            return self.gaps[name]
        slides = self.is_contact(name) or self.eqs.units.get(self.coordinate(name)) == "m"
        return self.length if slides else 1.0

    def is_contact(self, name: str) -> bool:
        """Return whether an element is the friction of a contact."""
        return any(law.element == name and law.touch is not None for law in self.eqs.formed.friction)

    def _subject(self, name: str) -> str:
        return " ".join(element_words(self.eqs.formed, name))

    def coordinate(self, joint: str) -> str:
        """Return the coordinate along which a joint slips."""
        return next(law.coordinate for law in self.eqs.formed.friction if law.name == joint)

    def _element(self, name: str) -> str:
        subject = self._subject(name)
        return subject if name in self.gaps else f"the friction of {subject}"

    @staticmethod
    def _scales(evaluator: ConstraintEvaluator, state: State) -> tuple[float, float]:
        """Return the largest work of a force [J] and the largest acceleration [1/s^2], in sizes."""
        work = np.abs(np.ravel(state["forcing"])) * evaluator.speed_sizes
        reactions = np.abs(list(state.multipliers.values())) * evaluator.mechanism.constraints(evaluator.eqs)
        rates = np.abs(list(state.udot.values())) / evaluator.speed_sizes
        return max(work.max(initial=0.0), reactions.max(initial=0.0)), float(rates.max(initial=0.0))


def _search(eqs: EquationSet, state: State) -> _ModeSearch:
    """Return the elements of a state, each with what its position and rate decide."""
    q, u = (np.array(list(values.values())) for values in (state.q, state.u))
    unilateral, joints = unilateral_elements(eqs.formed), switching_joints(eqs.formed)
    openings: dict[str, Opening] = {}
    if not unilateral and not joints:
        return _ModeSearch(eqs, state, q, u, 1.0, {}, openings)
    evaluator = constraint_evaluator(with_closed_gaps(eqs, ()), state.parameters, state.inputs, state.t)
    small = AT_REST * float(np.abs(u / evaluator.speed_sizes).max(initial=1.0 / evaluator.mechanism.time))
    sizes = {name: evaluator.mechanism.gap(evaluator.eqs, name) for name in unilateral}
    if unilateral:
        rows = {row.gap for row in eqs.formed.rows}
        for name, share in gap_shares(evaluator, q).items():
            rate = float(evaluator.compile(f"gap_dot {name}")(evaluator.t, q, u))
            at_length = name in rows and share <= AT_LENGTH and abs(rate) <= small * sizes[name]
            openings[name] = UNDECIDED if at_length else OPEN
    search = _ModeSearch(eqs, state, q, u, evaluator.mechanism.length, sizes, openings)
    for name in joints:
        if search.is_contact(name):
            openings[name] = _contact_opening(search, evaluator, name, small)
            continue
        rate = float(state[f"{search.coordinate(name)}_dot"])
        rests = abs(rate) <= small * search.unit(name)
        openings[name] = UNDECIDED if rests else Opening(int(np.sign(rate)), is_decided=True)
    return search


def _contact_opening(search: _ModeSearch, evaluator: ConstraintEvaluator, name: str, small: float) -> Opening:
    """Return what is known of the friction of a contact: none while its gap is open.

    While it slips, it goes on.
    """
    laws = [law for law in search.eqs.formed.friction if law.element == name]
    rows = (*search.eqs.formed.rows, *search.eqs.formed.slack)
    gap = next(row.gap for row in rows for law in laws if law.touch is not None and law.touch.row == row.name)
    rates = [evaluator.compile(f"friction_rate {law.name}")(evaluator.t, search.q, search.u) for law in laws]
    if search.openings[gap].is_decided or np.linalg.norm(rates) > small * search.length:
        return Opening(LOOSE, is_decided=True)
    return UNDECIDED
