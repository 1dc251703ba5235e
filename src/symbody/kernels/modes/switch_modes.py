"""Which joints and contacts stick and which gaps are closed at a state of a motion, and its speeds behind it.

Impacts come first; then modes are decided, and the speeds changed to fit them.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.events.event_location import sign
from symbody.kernels.language import Function, Reals, is_finite
from symbody.kernels.modes.fill_problem import (
    acceleration_of,
    fill_problem,
    slight_acceleration,
    slight_effort,
)
from symbody.kernels.modes.find_modes import BALANCED, CANCELLED, NOT_FOUND, ONE, TWO, find_modes
from symbody.kernels.modes.impacts import are_struck, rest_of_impacts, strike_gaps
from symbody.kernels.modes.mode_problem import HOLDS, LOOSE
from symbody.kernels.modes.mode_shares import note_shares, solve_modes
from symbody.kernels.modes.mode_state import (
    AT_LENGTH,
    FUNCTION_FAULT,
    NO_MODES,
    NO_SPEEDS,
    SETTLED,
    energy_of,
    forget_modes,
    head,
    is_closed,
    measure,
    mode_input,
    note_rates,
    record,
    show_modes,
    slow_rate,
    speed_of,
    was_closed,
)
from symbody.kernels.modes.mode_switch import DECIDED, ModeSwitch, SwitchingElement
from symbody.kernels.modes.mode_trial import SOLVED
from symbody.kernels.runge_kutta import call, copy

NEVER: Final = 1e100  # a value that does not come to zero
UNCERTAIN: Final = 1e3  # times as fast as at rest
FAST: Final = 1e6  # ends that approach so many times faster than at rest do not come back at once


def settle_modes(d: Function, w: Function, modes: ModeSwitch, Z: Reals, t: float, x: Reals) -> int:
    """Let gaps strike and decide the modes at a state x = (u, q, s, work); return one of the codes above.

    Speeds are changed to fit the modes; by what the energy changes is work. Z has room for two more rows.
    """
    modes.changed = 0.0
    if measure(d, modes, t, x) != 0:
        return FUNCTION_FAULT
    note_rates(modes, x)
    is_struck = are_struck(modes)
    code = SETTLED
    if is_struck == 1:
        code = strike_and_measure(d, modes, Z, t, x)
    copy(modes.states, x, modes.fitted)
    is_new = 0
    t_rest = t
    wrong = 1  # gaps that close change the speeds: what slips may slip the other way then
    for turn in range(modes.count + 2):
        if wrong == 1 and code == SETTLED:
            code = decide_at_speeds(modes)
            if code == SETTLED:
                if take_modes(modes) == 1:
                    is_new = 1
                if is_struck == 1 and turn == 0:
                    t_rest = t + rest_of_impacts(modes)
                note_slips(modes)
                code = fit_speeds(d, w, modes, t, x)
                wrong = slip_back(modes)
    if code == SETTLED and wrong == 1:
        return NO_SPEEDS
    if code == SETTLED and is_new == 1:
        record(modes, Z, DECIDED, t_rest, modes.fitted, 0.0)
    return code


def strike_and_measure(d: Function, modes: ModeSwitch, Z: Reals, t: float, x: Reals) -> int:
    """Let gaps that close strike, and measure the state behind it; modes so far do not matter there."""
    code = strike_gaps(d, modes, Z, t, x)
    if code == SETTLED:
        if measure(d, modes, t, x) != 0:
            return FUNCTION_FAULT
        forget_modes(modes)
    return code


def decide_at_speeds(modes: ModeSwitch) -> int:
    """Decide the modes at the speeds that were measured last."""
    open_elements(modes, 0)
    choose_direction(modes)
    verdict = decide(modes)
    if modes.gaps > 0 and verdict == ONE and open_elements(modes, 1) == 1:
        verdict = decide(modes)
    modes.verdict = verdict
    if verdict == ONE or verdict == TWO:
        note_shares(modes)
    if modes.verdict != ONE:
        return NO_MODES
    return SETTLED


def note_slips(modes: ModeSwitch) -> None:
    """Note how fast each element slips along its mode before the speeds are changed to fit the modes."""
    for k in range(modes.count):
        modes.kept[k] = slip_along(modes.elements[k])


def slip_back(modes: ModeSwitch) -> int:
    """Return 1 if something slips against its mode because the speeds were changed, else 0."""
    for k in range(modes.count):
        element = modes.elements[k]
        slow = slow_rate(modes, element)
        if slip_along(element) < -slow and not modes.kept[k] < -slow:
            return 1
    return 0


def slip_along(element: SwitchingElement) -> float:
    """Return how fast an element slips as its mode says; 0 for one that does not slip."""
    if element.is_gap != 0.0 or element.mode == HOLDS or element.absent != 0.0:
        return 0.0
    if element.rows == 2:
        return element.rate * element.ahead + element.across * element.aside
    return float(element.mode) * element.rate


def find_overlap(d: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Return which element is a gap below zero at a state that was set, from 1; 0 for none."""
    if modes.gaps == 0 or measure(d, modes, t, x) != 0:
        return 0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_gap != 0.0 and element.width < -AT_LENGTH * element.length:
            return k + 1
    return 0


def open_elements(modes: ModeSwitch, again: int) -> int:
    """Say what is known of each element before modes are decided; return 1 if that differs from before.

    What moves has its mode. A gap is open if it is above zero or grows; `again` if the mode
    problem holds accelerations of a first decision.
    """
    differs = 0
    for back in range(modes.count):
        k = modes.count - 1 - back  # gaps before the friction in them
        element = modes.elements[k]
        opens = HOLDS
        is_decided = 0.0
        element.absent = 0.0
        if element.gap > 0:
            element.absent = modes.elements[element.gap - 1].is_decided
        if element.is_gap != 0.0:
            if is_open(modes, element, again) == 1:
                opens = LOOSE
                is_decided = 1.0
        elif element.absent != 0.0:
            opens = LOOSE
            is_decided = 1.0
        elif has_turned(modes, element) == 0 and speed_of(element) > slow_rate(modes, element):
            opens = int(sign(element.rate))
            if element.rows == 2:
                opens = LOOSE
                head(modes, k, element.rate, element.across)
            is_decided = 1.0
        if again == 0 or element.is_gap != 0.0 or element.gap > 0:
            if opens != element.opens or is_decided != element.is_decided:
                differs = 1
            element.opens = opens
            element.is_decided = is_decided
    return differs


def has_turned(modes: ModeSwitch, element: SwitchingElement) -> int:
    """Return 1 if what slipped until an event turns back: it came to rest a little before, else 0.

    A contact that slips across its heading by then has not come to rest, unless that is as slow as a state
    between the ends of a step is uncertain.
    """
    along = float(element.mode) * element.rate
    if element.rows == 2:
        along = float(element.mode) * (element.rate * element.ahead + element.across * element.aside)
        aside = abs(element.across * element.ahead - element.rate * element.aside)
        if aside > UNCERTAIN * slow_rate(modes, element):
            return 0
    if element.ended != 0.0 and element.before != 0.0 and along < 0.0 and element.absent == 0.0:
        return 1
    return 0


def is_open(modes: ModeSwitch, element: SwitchingElement, again: int) -> int:
    """Return 1 if a gap is open whatever efforts are, else 0.

    One that closes again before it has measurably grown stays closed.
    """
    if element.ended != 0.0 and was_closed(element) == 1:
        return 1
    if is_closed(element) == 0:
        return 1
    rate = element.rate
    if was_closed(element) == 1:
        rate = 0.0
    slow = slow_rate(modes, element)
    if rate > slow:
        back = 0.0
        if again == 1:
            back = -acceleration_of(modes, element.candidate)
        if rate > FAST * slow or not rate * rate <= 2.0 * back * AT_LENGTH * element.length:
            return 1
    return 0


def choose_direction(modes: ModeSwitch) -> None:
    """Let a joint that breaks away slip against the effort that held it."""
    broken = find_broken(modes)
    if broken < 0:
        return
    for k in range(modes.count):
        element = modes.elements[k]
        modes.kept[k] = float(element.opens)
        if element.is_decided == 0.0:
            element.opens = element.mode
    fill_problem(modes, 0)
    status = solve_modes(modes.problem)
    for k in range(modes.count):
        modes.elements[k].opens = int(modes.kept[k])
    joint = modes.elements[broken]
    for k in range(modes.problem.rows):
        if int(modes.acting[k]) == joint.candidate and status == SOLVED:
            joint.opens = int(-sign(modes.problem.efforts[k]))
            if joint.rows == 2:
                joint.opens = LOOSE
                head(modes, broken, -modes.problem.efforts[k], -modes.problem.efforts[k + 1])
            joint.is_decided = 1.0


def find_broken(modes: ModeSwitch) -> int:
    """Return the joint at rest whose sticking an event has ended, -1 if there is none."""
    broken = -1
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_gap == 0.0 and element.ended != 0.0 and element.before != 0.0:
            if element.mode == HOLDS and element.is_decided == 0.0:
                broken = k
    return broken


def decide(modes: ModeSwitch) -> int:
    """Return the verdict of `find_modes` on what is known of the elements."""
    fill_problem(modes, 0)
    problem = modes.problem
    for i in range(problem.rows):
        if not is_finite(problem.offsets[i]):
            return NOT_FOUND
        for j in range(problem.rows):
            if not is_finite(problem.responses[i * problem.rows + j]):
                return NOT_FOUND
    return find_modes(problem)


def take_modes(modes: ModeSwitch) -> int:
    """Take the modes that were found; return 1 if some differ, or are the first."""
    is_new = int(1.0 - modes.known)
    for back in range(modes.count):
        k = modes.count - 1 - back  # gaps before the friction in them
        element = modes.elements[k]
        mode = found_mode(modes, k)
        if element.gap > 0:
            element.absent = 0.0
            if modes.elements[element.gap - 1].mode != HOLDS:
                element.absent = 1.0
                mode = LOOSE
        if mode != element.mode:
            modes.changed = 1.0
        element.mode = mode
        value = mode_input(modes, k)  # what slips on along another heading is written down, too
        if value != element.written:
            is_new = 1
        element.written = value
        element.before = 1.0
        element.ended = 0.0
    modes.known = 1.0
    if is_new == 1:
        modes.changed = 1.0
    return is_new


def found_mode(modes: ModeSwitch, place: int) -> int:
    """Return the mode of an element that was found, and let a contact slip as it begins to."""
    problem = modes.problem
    element = modes.elements[place]
    mode = LOOSE
    if element.is_decided != 0.0:
        mode = element.opens
    for j in range(problem.count):
        other = problem.elements[j]
        if int(modes.acting[other.row]) == element.candidate:
            mode = other.mode
            if element.rows == 2 and mode != HOLDS:
                head(modes, place, other.first, other.second)
    return mode


def project_speeds(w: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Give a state speeds that fit the rows that hold, by the least kinetic energy; return the status."""
    n = modes.speeds
    status = call(w, n, modes.projection, t, x, modes.moves)
    if status == 0:
        first = modes.moves_size - n
        for i in range(n):
            x[i] = x[i] + modes.moves[first + i]
    return status


def fit_speeds(d: Function, w: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Give a state speeds that fit the modes, and note what ends these."""
    energy = energy_of(modes)
    show_modes(modes, modes.projection)
    for k in range(modes.count):
        element = modes.elements[k]
        if element.rows == 2 and element.is_decided == 0.0:
            modes.projection.inputs[modes.first_input + k] = 0.0  # it begins to slip with no speed aside
    if project_speeds(w, modes, t, x) != 0:
        return NO_SPEEDS
    moved = 0
    for i in range(modes.speeds):
        if x[i] != modes.fitted[i]:
            moved = 1
    if moved == 1:
        modes.changed = 1.0
        set_levels(modes)
        if measure(d, modes, t, x) != 0:
            return FUNCTION_FAULT
        n = modes.states
        x[n - 1] = x[n - 1] + (energy_of(modes) - energy)
    else:
        set_levels(modes)
    return SETTLED


def set_levels(modes: ModeSwitch) -> None:
    """Note what is taken from the values that end modes.

    An open gap that is zero up to rounding, or has come below, is exactly there; one that stays there while
    others are closed ends its mode only when it is measurably below. A closed one without effort but for
    rounding has none. The value of an element that shares its effort says nothing, and never falls to zero.
    """
    for k in range(modes.count):
        element = modes.elements[k]
        element.level = 0.0
        if element.shares != 0.0 or element.absent != 0.0:
            element.level = -NEVER
        elif element.is_gap != 0.0:
            if element.mode != HOLDS:
                if element.width <= AT_LENGTH * element.length:
                    element.level = element.width
                    if stays_at_zero(modes, element) == 1:
                        element.level = element.width - AT_LENGTH * element.length
            else:
                element.level = CANCELLED / BALANCED * slight_effort(modes, element)


def stays_at_zero(modes: ModeSwitch, element: SwitchingElement) -> int:
    """Return 1 if an open gap stays where it is at first, but for rounding, while others are closed, else 0.

    They may keep it there, as those of three corners do with that of the fourth, or let it close soon.
    """
    if abs(element.rate) > slow_rate(modes, element):
        return 0
    if abs(acceleration_of(modes, element.candidate)) > slight_acceleration(modes, element.candidate):
        return 0
    for k in range(modes.count):
        if modes.elements[k].is_gap != 0.0 and modes.elements[k].mode == HOLDS:
            return 1
    return 0


def slight_value(modes: ModeSwitch, place: int) -> float:
    """Return what is rounding of the value that ends the mode of an element, once modes have been decided."""
    element = modes.elements[place]
    if element.mode == HOLDS:
        return slight_effort(modes, element)
    if element.is_gap != 0.0:
        return AT_LENGTH * element.length
    return slow_rate(modes, element)
