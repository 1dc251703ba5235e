"""A motion along which joints stick and slip and gaps close: at an end of a mode it goes on in others.

All else that happens on its way is in `motion_loop`: events and samples come before modes, which are
decided where one has ended, and where an action, a sample or a jump has changed what they follow from.
"""

from __future__ import annotations

from symbody.kernels.block import (
    MODE_FAULT,
    RUNNING,
    TOO_LONG,
    UNDECIDED,
    UNMOVABLE,
    FunctionNumbers,
    Run,
)
from symbody.kernels.events.event_interruptions import watch_again
from symbody.kernels.events.event_location import TOUCHING, add_zero, compute_values
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.features import IMPLICIT, SAMPLES
from symbody.kernels.implicit.implicit_block import ImplicitStep
from symbody.kernels.implicit.new_starts import go_on
from symbody.kernels.language import INFINITY, Function, Reals, part
from symbody.kernels.modes.end_of_shares import find_end_of_shares, shares_hold
from symbody.kernels.modes.mode_problem import HOLDS
from symbody.kernels.modes.mode_state import (
    FUNCTION_FAULT,
    NO_MODES,
    NO_SPEEDS,
    OVERLAP,
    SETTLED,
    forget_modes,
    show_modes,
    slow_rate,
)
from symbody.kernels.modes.mode_switch import ModeSwitch
from symbody.kernels.modes.switch_modes import find_overlap, settle_modes
from symbody.kernels.record_layout import exists
from symbody.kernels.runge_kutta import copy


def show_all_modes(
    modes: ModeSwitch, run: Run, implicit: ImplicitStep, monitor: EventMonitor, Q: FunctionNumbers
) -> None:
    """Write the modes among the inputs of all functions, and what is taken from watched values."""
    show_modes(modes, run.numbers)
    if IMPLICIT != 0:
        show_modes(modes, implicit.rate_numbers)
        show_modes(modes, implicit.derivative_numbers)
    if exists(run.projection):
        show_modes(modes, run.projection.numbers)
    show_modes(modes, monitor.numbers)
    if exists(monitor.actions):
        show_modes(modes, monitor.actions)
    if exists(monitor.closing):
        show_modes(modes, monitor.closing.numbers)
    if SAMPLES != 0:
        show_modes(modes, Q)
    for k in range(modes.count):
        event = monitor.events[modes.first_event + k]
        event.level = modes.elements[k].level


def forget_ends(modes: ModeSwitch, monitor: EventMonitor) -> None:
    """Forget on which side of zero the values were that end modes: others end the next ones."""
    for k in range(modes.count):
        event = monitor.events[modes.first_event + k]
        event.side = 0.0
        event.goes_through = 0.0
        event.just_happened = 0.0
        event.was = 0.0
        event.done = 0.0
        event.waits = 0.0
        event.largest = 0.0


def keep_sides(modes: ModeSwitch, monitor: EventMonitor) -> None:
    """Begin on its own side with what slips on behind an event, however near to rest it may be there.

    Several contacts may stop almost at once; one that has turned back by then ends its mode there.
    """
    for k in range(modes.count):
        if modes.kept[k] > slow_rate(modes, modes.elements[k]):
            monitor.events[modes.first_event + k].goes_through = 1.0


def note_ends(e: Function, modes: ModeSwitch, monitor: EventMonitor, t: float, x: Reals) -> None:
    """Take over from the search for events which modes have ended, and whether an action came before."""
    for k in range(modes.count):
        event = monitor.events[modes.first_event + k]
        modes.elements[k].ended = 0.0
        if monitor.ended == modes.first_event + k + 1 and modes.elements[k].shares == 0.0:
            modes.elements[k].ended = 1.0
        if event.just_happened != 0.0:
            event.just_happened = 0.0
    open_together(e, modes, monitor, t, x)
    monitor.ended = 0
    if monitor.has_acted != 0.0:
        forget_modes(modes)


def open_together(e: Function, modes: ModeSwitch, monitor: EventMonitor, t: float, x: Reals) -> int:
    """Where a gap opens, let others open whose effort has come to zero with it; return how many.

    No event would tell that later.
    """
    count = 0
    place = monitor.ended - modes.first_event - 1
    if place < 0 or place >= modes.count:
        return count
    if modes.elements[place].is_gap == 0.0 or modes.elements[place].mode != HOLDS:
        return count
    compute_values(e, monitor, t, x)
    for k in range(modes.count):
        other = modes.elements[k]
        if other.is_gap != 0.0 and other.mode == HOLDS and other.shares == 0.0:
            event = monitor.events[modes.first_event + k]
            if monitor.values[modes.first_event + k] <= TOUCHING * event.largest:
                other.ended = 1.0
                count = count + 1
    return count


def run_code(code: int) -> int:
    """Return the code of `block` for one of `switch_modes`."""
    if code == NO_MODES:
        return UNDECIDED
    if code == NO_SPEEDS:
        return UNMOVABLE
    if code == OVERLAP:
        return TOO_LONG
    if code == FUNCTION_FAULT:
        return MODE_FAULT
    return RUNNING


def switch_at_cut(
    f: Function, e: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, Q: FunctionNumbers, modes: ModeSwitch, times: Reals, t: Reals, x: Reals,
    breaks: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Go on behind a cut in the modes that are decided there; return a code of `block`."""
    state = monitor.after
    note_ends(e, modes, monitor, monitor.cut, state)
    if monitor.has_acted != 0.0:
        modes.culprit = find_overlap(d, modes, monitor.cut, state)
        if modes.culprit != 0:
            return TOO_LONG
    code = settle_modes(d, w, modes, Z, monitor.cut, state)
    if code != SETTLED:
        return run_code(code)
    show_all_modes(modes, run, implicit, monitor, Q)
    if modes.changed == 0.0:
        monitor.has_acted = 0.0
        return go_on(f, e, run, implicit, monitor, times, t, x, breaks)
    monitor.has_acted = 0.0
    monitor.rate_known = 0.0
    forget_ends(modes, monitor)
    code = go_on(f, e, run, implicit, monitor, times, t, x, breaks)
    for k in range(monitor.event_count):
        monitor.events[k].side = 0.0  # that of the last sample says nothing of this cut
    watch_again(e, run, monitor)
    forget_ends(modes, monitor)
    keep_sides(modes, monitor)
    return code


def have_ended(e: Function, d: Function, run: Run, monitor: EventMonitor, modes: ModeSwitch) -> int:
    """Return 1 if a mode does not last at the present state, else 0."""
    if modes.shares != 0 and shares_hold(d, modes, run.time, run.state_old) == 0:
        return 1
    compute_values(e, monitor, run.time, run.state_old)
    for k in range(modes.count):
        if not monitor.values[modes.first_event + k] > 0.0:
            return 1
    return 0


def switch_at_sample(
    f: Function, e: Function, d: Function, w: Function, run: Run, implicit: ImplicitStep,
    monitor: EventMonitor, Q: FunctionNumbers, modes: ModeSwitch, times: Reals, t: Reals, x: Reals,
    breaks: Reals, Z: Reals,
) -> int:  # fmt: skip
    """Go on behind a sample in the modes that are decided there; return a code of `block`.

    Where modes are decided outside, what jumps through zero at the sample hands over in the next step.
    """
    if have_ended(e, d, run, monitor, modes) == 0:
        return RUNNING
    if monitor.hands_over != 0.0:
        end_shares(modes, monitor, run.time)
        return RUNNING
    code = settle_modes(d, w, modes, Z, run.time, run.state_old)
    if code != SETTLED:
        return run_code(code)
    if modes.changed == 0.0:
        return RUNNING
    return begin_in_modes(f, e, run, implicit, monitor, Q, modes, times, t, x, breaks)


def begin_in_modes(
    f: Function, e: Function, run: Run, implicit: ImplicitStep, monitor: EventMonitor, Q: FunctionNumbers,
    modes: ModeSwitch, times: Reals, t: Reals, x: Reals, breaks: Reals,
) -> int:  # fmt: skip
    """Go on from the present state in other modes; return a code of `block`."""
    show_all_modes(modes, run, implicit, monitor, Q)
    monitor.cut = run.time
    copy(run.states, run.state_old, monitor.after)
    code = go_on(f, e, run, implicit, monitor, times, t, x, breaks)
    watch_again(e, run, monitor)
    forget_ends(modes, monitor)
    return code


def watch_shares(
    d: Function, run: Run, monitor: EventMonitor, modes: ModeSwitch, breaks: Reals, pieces: Reals
) -> None:
    """Let a mode end in the last step where no shares of efforts hold any more."""
    last = run.counts.steps - 1
    if modes.shares == 0 or last < 0 or breaks[last + 1] == monitor.cut:
        return  # no step yet in these modes: the last try was too long
    size = monitor.piece_rows * run.states
    step = part(pieces, last * size, size)
    t = find_end_of_shares(d, modes, monitor.piece_rows, part(breaks, last, 2), step, modes.fitted)
    if t < INFINITY:
        end_shares(modes, monitor, t)


def end_shares(modes: ModeSwitch, monitor: EventMonitor, t: float) -> None:
    """Let the mode of one of the elements that share efforts, if there are any, end at a time."""
    for k in range(modes.count):
        if modes.elements[k].shares != 0.0:
            place = modes.first_event + k
            for i in range(monitor.pending_count):
                if monitor.pending[i].event == place:  # found before in the same step
                    return
            add_zero(monitor, t, place, -1.0)
            return


def note_end_of_shares(
    d: Function, modes: ModeSwitch, rows: int, breaks: Reals, piece: Reals, found: Reals
) -> int:
    """Store when shares of efforts no longer hold in one step; see `find_end_of_shares`."""
    found[0] = find_end_of_shares(d, modes, rows, breaks, piece, modes.fitted)
    return 0
