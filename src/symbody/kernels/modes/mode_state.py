"""What is known of the elements of a `ModeSwitch` at a state, and the record of their modes."""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.events.event_location import sign
from symbody.kernels.language import Function, Reals, part, sqrt
from symbody.kernels.modes.mode_problem import HOLDS
from symbody.kernels.modes.mode_switch import SHOCK, ModeSwitch, SwitchingElement
from symbody.kernels.runge_kutta import call, copy

# What deciding and striking return.
SETTLED: Final = 0
NO_MODES: Final = 1  # that fit all laws, or more than one; see `verdict`
NO_SPEEDS: Final = 2  # that keep gaps from closing further
FUNCTION_FAULT: Final = 3
OVERLAP: Final = 4  # an action left parts that overlap, or a rope longer than it can be

AT_REST: Final = 1e-9  # of the largest rates so far, `symbody.tolerances`
AT_LENGTH: Final = 2e-9  # of its length: a gap below that is closed
GAP_NUMBERS: Final = 4  # gap, rate, scale, restitution
UNWRITTEN: Final = 2.0  # no mode: the next one is written down


def forget_modes(modes: ModeSwitch) -> None:
    """Let the modes so far not matter any more where others are decided."""
    for k in range(modes.count):
        modes.elements[k].before = 0.0
        modes.elements[k].ended = 0.0


def measure(d: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Compute what decides at a state; return the status of the function."""
    status = call(d, modes.speeds, modes.numbers, t, x, modes.out)
    if status != 0:
        modes.fault = status
        return status
    size = modes.rates + GAP_NUMBERS * modes.gaps
    motion = part(modes.out, modes.out_size - 1 - size, size)
    place = 0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_gap != 0.0:
            gap = modes.rates + k - (modes.count - modes.gaps)
            element.width = motion[gap]
            element.rate = motion[gap + modes.gaps]
            element.length = motion[gap + 2 * modes.gaps]
            if element.length == 0.0:
                element.length = element.unit
            element.restitution = motion[gap + 3 * modes.gaps]
        else:
            element.rate = motion[place]
            element.across = 0.0
            if element.rows == 2:
                element.across = motion[place + 1]
            place = place + element.rows
    return 0


def energy_of(modes: ModeSwitch) -> float:
    """Return the energy at the state that was measured last [J]."""
    return modes.out[modes.out_size - 1]


def note_rates(modes: ModeSwitch, x: Reals) -> None:
    """Note how fast the mechanism is, in its size a second."""
    for i in range(modes.speeds):
        modes.fastest = max(modes.fastest, abs(x[i]) / modes.sizes[i])


def slow_rate(modes: ModeSwitch, element: SwitchingElement) -> float:
    """Return the rate below which an element is at rest."""
    return AT_REST * modes.fastest * element.unit


def was_closed(element: SwitchingElement) -> int:
    """Return 1 if a gap was closed in the mode that still matters, else 0."""
    if element.before != 0.0 and element.mode == HOLDS:
        return 1
    return 0


def is_closed(element: SwitchingElement) -> int:
    """Return 1 if a gap is at zero: one that was closed is, whatever drift there is."""
    if was_closed(element) == 1 or element.width <= AT_LENGTH * element.length:
        return 1
    return 0


def speed_of(element: SwitchingElement) -> float:
    """Return how fast an element slips."""
    if element.rows == 2:
        return sqrt(element.rate * element.rate + element.across * element.across)
    return abs(element.rate)


def head(modes: ModeSwitch, place: int, x: float, y: float) -> None:
    """Let a contact slip along a vector."""
    element = modes.elements[place]
    size = sqrt(x * x + y * y)
    if size > 0.0:
        element.ahead = x / size
        element.aside = y / size


def show_modes(modes: ModeSwitch, numbers: FunctionNumbers) -> None:
    """Write the modes among the inputs of a function."""
    for k in range(modes.count):
        numbers.inputs[modes.first_input + k] = mode_input(modes, k)


def mode_input(modes: ModeSwitch, place: int) -> float:
    """Return the input for a mode; the heading of a contact is a place on a square behind the 1 of its slip.

    See `symbody.equations.solving.modal_equations.mode_heading`.
    """
    element = modes.elements[place]
    size = abs(element.ahead) + abs(element.aside)
    if element.rows < 2 or element.mode == HOLDS or not size > 0.0:
        return float(element.mode)
    if element.aside < 0.0:
        return 1.0 - 0.125 * (1.0 - element.ahead / size)
    return 1.0 + 0.125 * (1.0 - element.ahead / size)


def take_mode(modes: ModeSwitch, place: int, value: float) -> None:
    """Give an element the mode, and the heading, that a value of `mode_input` stands for."""
    element = modes.elements[place]
    element.mode = HOLDS
    if abs(value) > 0.5:
        element.mode = int(sign(value))
    if element.rows == 2 and element.mode != HOLDS:
        side = 8.0 * (value - 1.0)
        aside = side
        if abs(side) > 1.0:
            aside = (2.0 - abs(side)) * sign(side)
        head(modes, place, 1.0 - abs(side), aside)


def record(modes: ModeSwitch, Z: Reals, kind: float, t: float, x: Reals, lost: float) -> None:
    """Write down modes or impulses, and the state before."""
    n = modes.states
    m = modes.count
    size = 3 + m + n
    row = part(Z, size * modes.recorded, size)
    if modes.recorded > 0:
        if Z[size * modes.recorded - size + 1] > t:  # that of a series of impacts which this one ends
            Z[size * modes.recorded - size + 1] = t
    row[0] = kind
    row[1] = t
    row[2] = lost
    for k in range(m):
        row[3 + k] = mode_input(modes, k)
        if kind == SHOCK:
            row[3 + k] = modes.elements[k].impulse
    copy(n, x, part(row, 3 + m, n))
    modes.recorded = modes.recorded + 1


def forget_rows(modes: ModeSwitch, Z: Reals) -> None:
    """Keep of the record the last modes alone, which make room for more."""
    size = 3 + modes.count + modes.states
    last = modes.recorded - 1
    while last > 0 and Z[size * last] == SHOCK:
        last = last - 1
    if last > 0:
        copy(size, part(Z, size * last, size), Z)
    modes.recorded = min(modes.recorded, 1)


def rewind_modes(modes: ModeSwitch, Z: Reals, t: float) -> None:
    """Go back to the modes at a time from which a motion goes on anew, as far as they are recorded."""
    size = 3 + modes.count + modes.states
    last = modes.recorded - 1
    while last > 0 and (Z[size * last + 1] > t or Z[size * last] == SHOCK):
        last = last - 1
    if last < 0:
        return
    for k in range(modes.count):
        element = modes.elements[k]
        element.written = Z[size * last + 3 + k]
        element.ended = 0.0
        take_mode(modes, k, element.written)
    modes.recorded = last + 1
