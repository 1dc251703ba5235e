"""Joints that stick and slip, ropes and stops, along a motion: `kernels.modes` with functions and numbers."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.modes.reduced_modes import ModeVerdict
from symbody.analysis.scales import Scales
from symbody.codegen.call_arguments import address
from symbody.codegen.function import CompiledFunction
from symbody.codegen.llvm.kernel_library import load_kernels
from symbody.codegen.native_call import check_status
from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.outputs.output_roots import OF_MODES
from symbody.equations.solving.modal_equations import (
    ModalEquations,
    modal_equations,
    permanent_equations,
    switches,
)
from symbody.equations.solving.mode_responses import candidate_laws, reaction_sizes
from symbody.equations.solving.unilateral import unilateral_row
from symbody.errors import Problem, UsageError
from symbody.kernels import block as run_at
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.modes.mode_problem import HOLDS, LOOSE, ModeElement, ModeProblem
from symbody.kernels.modes.mode_state import FUNCTION_FAULT, NO_MODES, SETTLED
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch, SwitchingElement
from symbody.kernels.pack import pack
from symbody.simulation.events.events import ModeEnd
from symbody.simulation.hybrid.mode_record import ModeRecord, modal_elements
from symbody.simulation.hybrid.rate_jumps import struck_friction
from symbody.simulation.inputs.held_law import HeldLaw
from symbody.simulation.inputs.input_laws import CallbackFunction
from symbody.simulation.methods.constraints import PROJECTED
from symbody.simulation.native.blocks import function_numbers, function_sizes, write_numbers
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.description import NO_TABLES
from symbody.simulation.simulation_problem import OutputName, SimulationProblem
from symbody.simulation.status import Status
from symbody.single_flight import once

Floats = NDArray[np.float64]

_POINTER: Final = ctypes.c_void_p
_UNDETERMINED: Final = MappingProxyType(
    {
        ModeVerdict.NONE: "no combination of sticking and slipping is consistent with the friction of the "
        "joints",
        ModeVerdict.TWO: "two combinations of sticking and slipping, with different accelerations, are "
        "consistent with the friction of the joints",
        ModeVerdict.NOT_FOUND: "no combination of sticking and slipping was found that is consistent with "
        "the friction of the joints",
    }
)
_STUCK: Final = "no speeds were found that keep ropes taut and gaps closed"
_SMOOTH: Final = (
    "give friction a v0, replace ropes by springs that only pull, and give limits, backlash and "
    "contacts a stiffness instead of rigid: their laws are smooth then"
)


class DeadEndError(Exception):
    """A motion cannot go on.

    Attributes
    ----------
    t : float
        When [s].
    status : Status
        The verdict.
    why : str
        In words, to stand behind the time.
    """

    def __init__(self, t: float, status: Status, why: str) -> None:
        super().__init__(why)
        self.t, self.status, self.why = t, status, why


class SettledState(NamedTuple):
    """A state (u, q, s) whose speeds fit the modes, the work done by that, and whether it was an impact."""

    x: Floats
    work: float
    is_struck: bool


class SwitchingModes:
    """The modes of the joints that stick and slip, of ropes and of stops, along a motion.

    Parameters
    ----------
    problem : SimulationProblem
        What moves, its modes left open.

    Attributes
    ----------
    modal : ModalEquations
        The equations for all modes.
    record : ModeRecord
        The modes so far.
    ends : tuple of Event
        What ends modes, in the order of the elements.
    """

    feature = "MODES"

    def __init__(self, problem: SimulationProblem) -> None:
        eqs = problem.eqs
        self.modal: ModalEquations = modal_equations(eqs)
        self._source = problem
        self._block = self._make_block(problem)
        states = eqs.state_names
        self.record = ModeRecord(self.modal.modes, modal_elements(self.modal), states, self.switch)
        self.ends = mode_ends(self.modal)
        self.use(problem)

    @property
    def switch(self) -> ModeSwitch:
        """What the kernels read and change."""
        return ModeSwitch(self._block)

    def use(self, problem: SimulationProblem) -> None:
        """Go on with other values of inputs."""
        self._source = problem
        laws = problem.laws.with_held({name: HeldLaw(self.record, name) for name in self.modal.modes})
        self.problem = replace(problem, eqs=self.modal.eqs, laws=laws, permanent=self._permanent(problem))
        function, self._callback, self._decides = self._deciding_function(problem)
        self._functions = function, self.problem.compile_outputs(PROJECTED)
        self._show_inputs()
        numbers, tables = self.switch.numbers, problem.laws.table_numbers()
        if tables.size:
            np.asarray(numbers.tables)[: tables.size] = tables

    def _show_inputs(self) -> None:
        """Write the values that inputs have at present, held ones among them, where modes are decided."""
        np.asarray(self.switch.numbers.inputs)[:] = self._source.laws.held_now()

    def _permanent(self, problem: SimulationProblem) -> SimulationProblem:
        """Return the problem without what holds in some modes only."""
        return replace(problem, eqs=permanent_equations(problem.eqs)) if self.modal.gaps else problem

    def _deciding_function(
        self, problem: SimulationProblem
    ) -> tuple[CompiledFunction, CallbackFunction | None, int]:
        """Return the function of what decides, with what calls laws in Python, and where it lies."""
        function = problem.compile_outputs(deciding_outputs(self.modal))
        if not problem.laws.need_python:
            return function, None, function.address
        callback = CallbackFunction(function, problem.laws)
        return function, callback, callback.address

    def _make_block(self, problem: SimulationProblem) -> Floats:
        moving = replace(problem, eqs=self.modal.eqs, laws=problem.laws.with_held(loose_modes(self.modal)))
        deciding, projecting = (
            problem.compile_outputs(deciding_outputs(self.modal)), moving.compile_outputs(PROJECTED)
        )  # fmt: skip
        numbers = problem.numbers(deciding), moving.numbers(projecting)._replace(tables=NO_TABLES)
        sizes = _size(deciding), _size(projecting)

        def make() -> Floats:
            shapes = [(function_numbers(each), size) for each, size in zip(numbers, sizes, strict=True)]
            return mode_block(self.modal, problem.eqs, problem.scales, len(problem.laws.callbacks), *shapes)

        key = "modes", sizes, *map(function_sizes, numbers)
        block: Floats = deciding.kept_with_code(key, make).copy()
        switch = ModeSwitch(block)
        place_scales(switch, problem.scales, problem.eqs)
        write_numbers(switch.numbers, numbers[0])
        write_numbers(switch.projection, numbers[1])
        return block

    @property
    def functions(self) -> tuple[CompiledFunction, CompiledFunction]:
        """What decides about modes, and what projects speeds."""
        return self._functions

    @property
    def idle_rows(self) -> frozenset[str]:
        """The multipliers of rows that do not hold at present."""
        pairs = zip(self.modal.names, self.switch.elements, strict=True)
        loose = [name for name, element in pairs if element.mode != HOLDS]
        return frozenset(row for name in loose for row in self.modal.row_names(name))

    def snapshot(self) -> Floats:
        """Return what `resume` goes on from."""
        return self._block.copy()

    def resume(self, kept: Floats) -> None:
        """Go back to a snapshot."""
        self._block[:] = kept
        self.switch.room = len(self.record.rows)

    def save(self) -> tuple[Floats, Floats]:
        """Return all modes, present and past."""
        return self._block.copy(), self.record.rows.copy()

    def put_back(self, saved: tuple[Floats, Floats]) -> None:
        """Return to what was saved."""
        self._block[:], self.record.rows = saved

    def forget(self) -> None:
        """Let the modes so far not matter any more: the state has been changed."""
        for element in self.switch.elements:
            element.before = element.ended = 0.0

    def release(self) -> None:
        """Let no joint stick and no gap be closed, until modes are decided."""
        for element in self.switch.elements:
            element.mode = LOOSE

    def settle(self, t: float, x: Floats) -> SettledState:
        """Let ropes and stops strike and decide the modes.

        Raises
        ------
        DeadEndError
            If there are no modes, or no speeds.
        SimulationError
            If a function fails.
        """
        state = np.append(x, 0.0)
        self._make_room()
        self._show_inputs()  # the loop may have taken samples
        first = self.switch.recorded
        code = _kernel("settle_modes")(
            self._decides, self._functions[1].address, address(self._block), address(self.record.rows), t,
            address(state),
        )  # fmt: skip
        if code == FUNCTION_FAULT:
            self.raise_fault()
        if code != SETTLED:
            raise self._dead_end(t, code)
        struck = self.record.rows[first : self.switch.recorded, 0] == SHOCK
        return SettledState(state[:-1], float(state[-1]), bool(struck.any()))

    def end_of_shares(self, motion: DenseOutput) -> float | None:
        """Return when no shares hold any more of joints that hold together, in a motion in present modes [s].

        None if they do to its end. The compiled loop looks for that by itself.
        """
        if not self.switch.shares or motion.breaks[0] == motion.breaks[-1]:
            return None
        laws = self._source.laws
        steps, rows, n = motion.pieces.shape
        pieces = np.zeros((steps, rows, n + 1))  # the work is the last state
        pieces[:, :, :n] = motion.pieces
        found = np.full(1, np.inf)
        for k in range(steps):
            breaks = motion.breaks[k : k + 2].copy()
            for place, law in laws.held_laws.items():
                self.switch.numbers.inputs[place] = float(law.values_at(breaks.mean(keepdims=True))[0])
            arrays = map(address, (breaks, pieces[k], found))
            _kernel("note_end_of_shares")(self._decides, address(self._block), rows, *arrays)
            if np.isfinite(found[0]):
                return float(found[0])
        return None

    def _dead_end(self, t: float, code: int) -> DeadEndError:
        """Return why a motion ends, for a code of `switch_modes`."""
        if code == NO_MODES:
            return DeadEndError(t, Status.FRICTION, _UNDETERMINED[ModeVerdict(self.switch.verdict)])
        return DeadEndError(t, Status.SINGULAR, _STUCK)

    def _out_of_reach(self, label: str) -> str:
        name = self.modal.names[self.switch.culprit - 1]
        if unilateral_row(self.modal.eqs.formed, name).sense > 0:
            return (
                f"the action of event {label!r} makes the gap of {name} negative; set coordinates at which "
                f"it is open or closed"
            )
        return (
            f"the action of event {label!r} moves the ends of {name} farther apart than the rope is long; "
            f"set coordinates within its length"
        )

    def ending_note(self, code: int, actor: str) -> str:
        """Return why a motion ended, for a code of `kernels.block`; empty for other ends.

        `actor` is the event that has acted last.
        """
        if code == run_at.UNDECIDED:
            return _UNDETERMINED[ModeVerdict(self.switch.verdict)]
        if code == run_at.TOO_LONG:
            return self._out_of_reach(actor)
        return _STUCK if code == run_at.UNMOVABLE else ""

    def check_gaps(self, t: float, x: Floats, actor: str) -> None:
        """Refuse a state, set by an event, in which a rope is longer than it can be or a gap negative.

        Raises
        ------
        DeadEndError
            See above.
        """
        state = np.append(x, 0.0)
        place = _kernel("find_overlap")(self._decides, address(self._block), t, address(state))
        if place:
            self.switch.culprit = place
            raise DeadEndError(t, Status.UNMET_ACTION, self._out_of_reach(actor))

    def prepare(self, watch: Floats) -> None:
        """Tell a search for events where modes stand among inputs, and what is taken from watched values."""
        monitor, switch = EventMonitor(watch), self.switch
        monitor.mode_count, monitor.first_mode = switch.count, switch.first_input
        switch.first_event = monitor.event_count - switch.count
        for k, element in enumerate(switch.elements):
            monitor.events[switch.first_event + k].level = element.level

    def note_ends(self, watch: Floats, values: int) -> bool:
        """Take over which modes have ended where a search for events handed over; return whether one has.

        `values` is the address of the function of its values.
        """
        monitor = EventMonitor(watch)
        for k, element in enumerate(self.switch.elements):
            element.ended = float(monitor.ended == self.switch.first_event + k + 1)
        arrays = address(self._block), address(watch)
        _kernel("open_together")(values, *arrays, monitor.cut, address(np.array(monitor.before)))
        return bool(monitor.ended)

    def arguments(self, block: Floats) -> Mapping[str, int | Floats]:
        """Return the functions that decide and project, the modes, and their record."""
        self._make_room()
        projecting = self._functions[1].address
        return {"d": self._decides, "w": projecting, "modes": self._block, "Z": self.record.rows}

    def answer(self, code: int) -> None:
        """Raise a fault if the code of a loop says so; room is made before each call."""
        if code == run_at.MODE_FAULT:
            self.raise_fault()

    def _make_room(self) -> None:
        if self.switch.recorded + 4 > len(self.record.rows):
            self.record.grow()
        self.switch.room = len(self.record.rows)

    def raise_fault(self) -> None:
        """Raise what a law of an input raised, or what the status of the function means.

        Raises
        ------
        SimulationError
            See above.
        """
        if self._callback is not None and self._callback.error is not None:
            raise self._callback.error
        check_status(self.switch.fault)


def deciding_outputs(modal: ModalEquations) -> tuple[OutputName, ...]:
    """Return what decides about modes, outputs of the equations whose modes are open; see `ModeSwitch`."""
    words = ("row_gap", "gap_dot", "gap_scale", "restitution")
    rates = [f"friction_rate {law.name}" for law in modal.laws]
    return OF_MODES, (*rates, *(f"{word} {name}" for word in words for name in modal.gaps)), "energy"


def mode_ends(modal: ModalEquations) -> tuple[ModeEnd, ...]:
    """Return what ends the mode of each element: no reserve or no rate; no tension or its length."""
    joints = []
    for mode, name in zip(modal.modes, modal.joints, strict=False):
        laws = modal.laws_of(name)
        slip = f"'slip_along {name}'" if len(laws) > 1 else f"{mode}*'friction_rate {laws[0].name}'"
        joints.append((mode, name, f"'friction_reserve {name}'", slip))
    lines = [
        (mode, name, f"'opening_effort {name}'", f"'row_gap {name}'")
        for mode, name in zip(modal.modes[len(joints) :], modal.gaps, strict=True)
    ]
    return tuple(
        ModeEnd(f"if(abs({mode}) < 1/2, {held}, {loose})", -1, "stop", f"mode of {name}")
        for mode, name, held, loose in (*joints, *lines)
    )


def mode_block(
    modal: ModalEquations, eqs: EquationSet, scales: Scales, first_input: int, deciding: tuple[Floats, int],
    projecting: tuple[Floats, int],
) -> Floats:  # fmt: skip
    """Return the array of a `ModeSwitch` along whose motion no modes have been decided yet.

    Parameters
    ----------
    eqs : EquationSet
        Whose modes are open.
    first_input : int
        The place of the modes among the inputs of all functions.
    deciding, projecting : (array, int)
        Numbers of the function of `deciding_outputs`, and of what projects states in `modal`; how many
        numbers each writes.
    """
    laws = candidate_laws(eqs.formed)
    counts: list[int] = eqs.plans.get("reaction sizes", lambda: reaction_sizes(eqs.formed))
    gaps, length = len(modal.gaps), scales.length
    n, components = len(laws) + gaps, sum(counts)
    turning = [law.turns for law in laws] + [eqs.units.get(f"gap {name}") == "rad" for name in modal.gaps]
    units = [1.0 if turns else length for turns in turning]
    elements, owners = _elements(modal, laws, units)
    problem = pack(
        ModeProblem, count=n, rows=n, components=components, columns=n + 1,
        elements=[pack(ModeElement) for _ in range(n)],
    )  # fmt: skip
    return pack(
        ModeSwitch, count=len(modal.names), gaps=gaps, rates=len(modal.laws), candidates=n,
        components=components, states=len(eqs.state_names) + 1, speeds=len(eqs.speed_names),
        out_size=deciding[1], moves_size=projecting[1], first_input=first_input, length=length,
        time=scales.time, fastest=1.0 / scales.time, elements=elements, places=owners,
        normals=[*counts, *[0] * gaps], units=units, are_lengths=[float(not turns) for turns in turning],
        sizes=scales.displacements(eqs), problem=problem, numbers=deciding[0],
        projection=projecting[0],
    )  # fmt: skip


def place_scales(switch: ModeSwitch, scales: Scales, eqs: EquationSet) -> None:
    """Write the sizes of a mechanism over those with which `mode_block` was called."""
    switch.length, switch.time, switch.fastest = scales.length, scales.time, 1.0 / scales.time
    units = np.where(np.asarray(switch.are_lengths) != 0.0, scales.length, 1.0)
    np.asarray(switch.units)[:] = units
    np.asarray(switch.sizes)[:] = scales.displacements(eqs)
    for element in switch.elements:
        element.unit = float(units[element.candidate])


def _elements(
    modal: ModalEquations, laws: Sequence[FrictionLaw], units: Sequence[float]
) -> tuple[list[Floats], list[int]]:
    """Return the elements of a `ModeSwitch`, and the element of each candidate, -1 for smooth friction."""
    names, owners, elements = [law.element for law in laws], [-1] * len(units), []
    formed = modal.eqs.formed
    places = {unilateral_row(formed, name).name: k for k, name in enumerate(modal.gaps)}
    for place, name in enumerate(modal.joints):
        first, rows = names.index(name), names.count(name)
        touch = laws[first].touch
        gap = 0 if touch is None else len(modal.joints) + places[touch.row] + 1
        elements.append(
            pack(SwitchingElement, candidate=first, rows=rows, gap=gap, unit=units[first], mode=LOOSE)
        )
        owners[first : first + rows] = [place] * rows
    for k in range(len(modal.gaps)):
        candidate = len(laws) + k
        elements.append(
            pack(SwitchingElement, candidate=candidate, rows=1, is_gap=1.0, unit=units[candidate], mode=LOOSE)
        )
        owners[candidate] = len(modal.joints) + k
    return elements, owners


def _size(function: CompiledFunction) -> int:
    return sum(len(output.values) for output in function.outputs)


def loose_modes(modal: ModalEquations) -> dict[str, HeldLaw]:
    """Return laws of the modes by which nothing holds."""
    return {name: HeldLaw(_Loose(), name) for name in modal.modes}


class _Loose:
    """Modes in which nothing holds."""

    def current(self, name: str) -> float:
        """Return the mode."""
        return float(LOOSE)

    def values_at(self, name: str, t: Floats) -> Floats:
        """Return the mode at times (N,)."""
        return np.full(np.shape(t), float(LOOSE))


def switching_modes(problem: SimulationProblem) -> SwitchingModes | None:
    """Return the modes of a mechanism; None where nothing switches."""
    return SwitchingModes(problem) if switches(problem.eqs.formed) else None


def check_backwards(span: tuple[float, float]) -> None:
    """Refuse motions that run backwards.

    Raises
    ------
    UsageError
        See above.
    """
    if span[1] < span[0]:
        raise UsageError(
            Problem("simulation.stick_slip_backwards", "t_end", "the motion runs backwards",
                    "how long joints stick and gaps are closed depends on the motion before", _SMOOTH)
        )  # fmt: skip


def check_strike(formed: EquationsOfMotion, t: float) -> None:
    """Refuse a jump of prescribed rates under friction that grows with reactions, which are infinite then.

    Raises
    ------
    UsageError
        See above.
    """
    names = struck_friction(formed, switches=True)
    if names:
        raise UsageError(
            Problem("simulation.struck_friction", "motion", f"prescribed rates jump at t = {t:.9g} s",
                    f"the reactions on which the friction of {', '.join(names)} depends are infinite there",
                    "prescribe a motion without corners, for instance with smoothstep; or give friction as a "
                    "force, or a v0")
        )  # fmt: skip


@once
def _library() -> Mapping[str, Callable[..., int]]:
    real, integer = ctypes.c_double, ctypes.c_int64
    kinds: dict[str, list[Any]] = {
        "settle_modes": [*[_POINTER] * 4, real, _POINTER],
        "find_overlap": [_POINTER, _POINTER, real, _POINTER],
        "open_together": [*[_POINTER] * 3, real, _POINTER],
        "note_end_of_shares": [*[_POINTER] * 2, integer, *[_POINTER] * 3],
    }
    addresses = load_kernels("switching_motion", tuple(kinds), light=True)
    return {name: ctypes.CFUNCTYPE(integer, *kind)(addresses[name]) for name, kind in kinds.items()}


def _kernel(name: str) -> Callable[..., int]:
    return _library()[name]
