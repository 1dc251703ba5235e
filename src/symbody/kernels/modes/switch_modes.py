"""Which joints stick and which ropes are taut at a state of a motion, and the speeds with which it goes on.

Ropes strike first: where the ends of ropes at their length move apart, those speeds are taken at which they
do not and to which the change has the least kinetic energy [Moreau, Unilateral contact and dry friction in
finite freedom dynamics, 1988]. That is the problem of the modes of ropes with rates in the place of
accelerations. Friction is finite and transmits nothing in an instant.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.block import FunctionNumbers
from symbody.kernels.events.event_location import sign
from symbody.kernels.language import Function, Reals, is_finite, part, sqrt
from symbody.kernels.modes.find_modes import BALANCED, CANCELLED, NOT_FOUND, ONE, find_modes
from symbody.kernels.modes.mode_problem import BOUNDED, CONE, HOLDS, LOOSE, UNILATERAL, ModeElement
from symbody.kernels.modes.mode_shares import note_shares
from symbody.kernels.modes.mode_switch import DECIDED, SHOCK, ModeSwitch, SwitchingElement
from symbody.kernels.modes.mode_trial import SOLVED, solve_modes
from symbody.kernels.runge_kutta import call, copy

# What `settle_modes` returns.
SETTLED: Final = 0
NO_MODES: Final = 1  # that fit all laws, or more than one; see `verdict`
NO_SPEEDS: Final = 2  # that keep the ropes taut
FUNCTION_FAULT: Final = 3
LONG_ROPE: Final = 4  # an action left a rope longer than it can be

AT_REST: Final = 1e-9  # of the largest rates so far, `symbody.tolerances`
AT_LENGTH: Final = 2e-9  # of its length: a rope that is closer to it is taut
GAP_NUMBERS: Final = 4  # gap, rate, scale, restitution
LEAST_SHARE: Final = 1e-3  # of restitution
NEVER: Final = 1e100  # a value that does not come to zero
UNWRITTEN: Final = 2  # no mode: the next one is written down
FAST: Final = 1e6  # ends that approach so many times faster than at rest do not come back at once


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


def settle_modes(d: Function, w: Function, modes: ModeSwitch, Z: Reals, t: float, x: Reals) -> int:
    """Let ropes strike and decide the modes at a state x = (u, q, s, work); return one of the codes above.

    Speeds are changed to fit the modes; by what the energy changes is work. Z has room for two more rows.
    """
    modes.changed = 0.0
    if measure(d, modes, t, x) != 0:
        return FUNCTION_FAULT
    note_rates(modes, x)
    is_struck = are_struck(modes)
    if is_struck == 1:
        code = strike_gaps(d, modes, Z, t, x)
        if code != SETTLED:
            return code
        if measure(d, modes, t, x) != 0:
            return FUNCTION_FAULT
        forget_modes(modes)
    copy(modes.states, x, modes.fitted)
    open_elements(modes, 0)
    choose_direction(modes)
    code = decide(modes)
    if modes.ropes > 0 and code == ONE and open_elements(modes, 1) == 1:
        code = decide(modes)
    modes.verdict = code
    if code != ONE:
        return NO_MODES
    note_shares(modes)
    is_new = take_modes(modes)
    rest = 0.0
    if is_struck == 1:
        rest = rest_of_impacts(modes)
    code = fit_speeds(d, w, modes, t, x)
    if code == SETTLED and is_new == 1:
        record(modes, Z, DECIDED, t + rest, modes.fitted, 0.0)
    return code


def rest_of_impacts(modes: ModeSwitch) -> float:
    """Return how long gaps that close at an impact would go on to bounce, too low to be seen [s].

    Flights last ``2 v/a`` with speeds v that fall by the restitution, a geometric series.
    """
    problem = modes.problem
    longest = 0.0
    for k in range(problem.count):
        i = problem.elements[k].row
        place = int(modes.places[int(modes.acting[i])])
        if place >= 0 and problem.elements[k].mode == HOLDS:
            element = modes.elements[place]
            back = problem.responses[i * problem.rows + i] * problem.efforts[i]
            left = 1.0 - element.restitution
            if element.is_rope != 0.0 and element.impulse > 0.0 and element.rate > 0.0 and back * left > 0.0:
                longest = max(longest, 2.0 * element.rate / (back * left))
    return longest


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
    size = modes.rates + GAP_NUMBERS * modes.ropes
    motion = part(modes.out, modes.out_size - 1 - size, size)
    place = 0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_rope != 0.0:
            gap = modes.rates + k - (modes.count - modes.ropes)
            element.slackness = motion[gap]
            element.rate = motion[gap + modes.ropes]
            element.length = motion[gap + 2 * modes.ropes]
            if element.length == 0.0:
                element.length = element.unit
            element.restitution = motion[gap + 3 * modes.ropes]
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


def was_taut(element: SwitchingElement) -> int:
    """Return 1 if a rope was taut in the mode that still matters, else 0."""
    if element.before != 0.0 and element.mode == HOLDS:
        return 1
    return 0


def is_tight(element: SwitchingElement) -> int:
    """Return 1 if a rope is at its length: one that was taut is, whatever drift there is."""
    if was_taut(element) == 1 or element.slackness <= AT_LENGTH * element.length:
        return 1
    return 0


def find_long_rope(d: Function, modes: ModeSwitch, t: float, x: Reals) -> int:
    """Return which element is a rope longer than it can be at a state that was set, from 1; 0 for none."""
    if modes.ropes == 0 or measure(d, modes, t, x) != 0:
        return 0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_rope != 0.0 and element.slackness < -AT_LENGTH * element.length:
            return k + 1
    return 0


def are_struck(modes: ModeSwitch) -> int:
    """Return 1 if the ends of a rope at its length move apart that was not taut, else 0."""
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_rope != 0.0 and was_taut(element) == 0 and is_tight(element) == 1:
            if element.rate < -slow_rate(modes, element):
                return 1
    return 0


def strike_gaps(d: Function, modes: ModeSwitch, Z: Reals, t: float, x: Reals) -> int:
    """Change the speeds to those behind the impact of gaps that close."""
    energy = energy_of(modes)
    if find_impulses(modes) != ONE:
        return NO_SPEEDS
    copy(modes.states, x, modes.fitted)
    add_impulses(modes, x)
    if measure(d, modes, t, x) != 0:
        return FUNCTION_FAULT
    n = modes.states
    x[n - 1] = x[n - 1] + (energy_of(modes) - energy)
    record(modes, Z, SHOCK, t, modes.fitted, modes.lost)
    modes.changed = 1.0
    return SETTLED


def find_impulses(modes: ModeSwitch) -> int:
    """Find with which impulses gaps at zero keep from closing; return the verdict of `find_modes`.

    Poisson's hypothesis with friction: impulses that end the approach, then their share of restitution, then
    those that end what approaches still; those across are within friction of those along the normals, in
    both phases [Glocker & Pfeiffer, Multiple impacts with friction in rigid multibody systems, Nonlinear
    Dynamics 7, 1995]. If the energy would rise the shares are lowered [Glocker, Energetic consistency
    conditions for standard impacts, Multibody Syst. Dyn. 29, 2013].
    """
    for k in range(modes.count):
        element = modes.elements[k]
        element.impulse = 0.0
        element.opens = HOLDS
        element.is_decided = 0.0
        if element.is_rope != 0.0 and is_tight(element) == 0:
            element.opens = LOOSE
            element.is_decided = 1.0
    for k in range(modes.count):
        rubbing = modes.elements[k]
        if rubbing.gap > 0:
            rubbing.absent = modes.elements[rubbing.gap - 1].is_decided
    verdict = compress(modes)
    share = 1.0
    while verdict == ONE and share > LEAST_SHARE:
        verdict = expand(modes, share)
        share = 0.5 * share
        if verdict == ONE and not modes.lost < 0.0:
            share = 0.0
        if share > LEAST_SHARE and verdict == ONE:
            verdict = compress(modes)
    settle_impulses(modes)
    return verdict


def compress(modes: ModeSwitch) -> int:
    """Find the impulses that end the approach of gaps."""
    for k in range(modes.candidates):
        modes.impulses[k] = 0.0
    for k in range(modes.components):
        modes.shocks[k] = 0.0
    fill_problem(modes, 1)
    verdict = find_modes(modes.problem)
    add_efforts(modes)
    return verdict


def add_efforts(modes: ModeSwitch) -> None:
    """Add the efforts that were found to the impulses."""
    problem = modes.problem
    for i in range(problem.rows):
        candidate = int(modes.acting[i])
        modes.impulses[candidate] = modes.impulses[candidate] + problem.efforts[i]


def expand(modes: ModeSwitch, share: float) -> int:
    """Let gaps open with a share of their restitution, and end what approaches still."""
    problem = modes.problem
    shares = part(problem.room, 0, problem.rows)
    most = 0.0
    for i in range(problem.rows):
        candidate = int(modes.acting[i])
        place = int(modes.places[candidate])
        struck = modes.elements[place]
        shares[i] = 0.0
        if struck.is_rope != 0.0:
            shares[i] = share * struck.restitution * modes.impulses[candidate]
        most = max(most, shares[i])
    verdict = ONE
    if most > 0.0:
        for k in range(modes.components):
            for i in range(problem.rows):
                modes.shocks[k] = modes.shocks[k] + problem.reactions[k * problem.rows + i] * shares[i]
        for i in range(problem.rows):
            candidate = int(modes.acting[i])
            modes.impulses[candidate] = modes.impulses[candidate] + shares[i]
        fill_problem(modes, 1)
        verdict = find_modes(problem)
        add_efforts(modes)
    modes.lost = lost_energy(modes)
    return verdict


def row_rate(modes: ModeSwitch, i: int) -> float:
    """Return the rate along a row of the mode problem before an impact."""
    candidate = int(modes.acting[i])
    place = int(modes.places[candidate])
    element = modes.elements[place]
    if candidate > element.candidate:
        return element.across
    return element.rate


def rate_behind(modes: ModeSwitch, i: int) -> float:
    """Return the rate along a row of the mode problem that the impulses so far leave."""
    count = modes.candidates
    first = 3 * (count - modes.ropes) + count
    responses = part(modes.out, first + int(modes.acting[i]) * count, count)
    rate = row_rate(modes, i)
    for j in range(modes.problem.rows):
        candidate = int(modes.acting[j])
        rate = rate + responses[candidate] * modes.impulses[candidate]
    return rate


def lost_energy(modes: ModeSwitch) -> float:
    """Return the energy that the impulses so far lose: work at the mean of the rates before and behind."""
    lost = 0.0
    size = 0.0
    for i in range(modes.problem.rows):
        impulse = modes.impulses[int(modes.acting[i])]
        work = 0.5 * impulse * (row_rate(modes, i) + rate_behind(modes, i))
        lost = lost - work
        size = size + abs(0.5 * impulse * row_rate(modes, i))
    if abs(lost) < BALANCED * size:
        return 0.0
    return lost


def settle_impulses(modes: ModeSwitch) -> None:
    """Note which gaps an impact strikes; others keep their modes."""
    largest = 0.0
    for k in range(modes.count):
        element = modes.elements[k]
        if element.is_rope != 0.0:
            element.impulse = modes.impulses[element.candidate]
            largest = max(largest, element.impulse)
    for k in range(modes.count):
        struck = modes.elements[k]
        if struck.is_rope != 0.0:
            if struck.impulse > BALANCED * largest:
                struck.mode = HOLDS
                struck.written = UNWRITTEN
            else:
                struck.impulse = 0.0


def add_impulses(modes: ModeSwitch, x: Reals) -> None:
    """Add to speeds what the impulses change them by."""
    first = 3 * (modes.candidates - modes.ropes) + candidate_block(modes) + modes.candidates
    for k in range(modes.candidates):
        column = part(modes.out, first + k * modes.speeds, modes.speeds)
        for i in range(modes.speeds):
            x[i] = x[i] + column[i] * modes.impulses[k]


def open_elements(modes: ModeSwitch, again: int) -> int:
    """Say what is known of each element before modes are decided; return 1 if that differs from before.

    What moves has its mode. A rope is slack if it is shorter or its ends approach; `again` if the mode
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
        if element.is_rope != 0.0:
            if is_slack(modes, element, again) == 1:
                opens = LOOSE
                is_decided = 1.0
        elif element.absent != 0.0:
            opens = LOOSE
            is_decided = 1.0
        elif has_turned(element) == 0 and speed_of(element) > slow_rate(modes, element):
            opens = int(sign(element.rate))
            if element.rows == 2:
                opens = LOOSE
                head(modes, k, element.rate, element.across)
            is_decided = 1.0
        if again == 0 or element.is_rope != 0.0 or element.gap > 0:
            if opens != element.opens or is_decided != element.is_decided:
                differs = 1
            element.opens = opens
            element.is_decided = is_decided
    return differs


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


def has_turned(element: SwitchingElement) -> int:
    """Return 1 if what slipped until an event turns back: it came to rest a little before, else 0."""
    along = float(element.mode) * element.rate
    if element.rows == 2:
        along = float(element.mode) * (element.rate * element.ahead + element.across * element.aside)
    if element.ended != 0.0 and element.before != 0.0 and along < 0.0 and element.absent == 0.0:
        return 1
    return 0


def is_slack(modes: ModeSwitch, element: SwitchingElement, again: int) -> int:
    """Return 1 if a rope is slack whatever efforts are, else 0.

    One that is taut again before its ends have measurably approached stays taut.
    """
    if element.ended != 0.0 and was_taut(element) == 1:
        return 1
    if is_tight(element) == 0:
        return 1
    rate = element.rate
    if was_taut(element) == 1:
        rate = 0.0
    slow = slow_rate(modes, element)
    if rate > slow:
        back = 0.0
        if again == 1:
            back = -acceleration_of(modes, element.candidate)
        if rate > FAST * slow or not rate * rate <= 2.0 * back * AT_LENGTH * element.length:
            return 1
    return 0


def acceleration_of(modes: ModeSwitch, candidate: int) -> float:
    """Return the acceleration along the row of a candidate with the efforts that were found."""
    problem = modes.problem
    count = modes.candidates
    total = modes.out[3 * (count - modes.ropes) + candidate]
    responses = part(modes.out, 3 * (count - modes.ropes) + count + candidate * count, count)
    for k in range(problem.rows):
        if int(modes.acting[k]) == candidate:
            return problem.accelerations[k]
        total = total + responses[int(modes.acting[k])] * problem.efforts[k]
    return total


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
        if element.is_rope == 0.0 and element.ended != 0.0 and element.before != 0.0:
            if element.mode == HOLDS and element.is_decided == 0.0:
                broken = k
    return broken


def fill_problem(modes: ModeSwitch, is_shock: int) -> None:
    """Write what decides into the mode problem; ropes that are slack whatever efforts are take no part.

    At length 0 these have no direction. Of a shock, ropes at their length alone, with rates in the place of
    accelerations.
    """
    problem = modes.problem
    candidates = modes.candidates
    count = 0
    rows = 0
    normal = 0
    for k in range(candidates):
        place = int(modes.places[k])
        normals = int(modes.normals[k])
        if takes_part(modes, place, is_shock) == 1:
            if is_second(modes, k, place) == 0:
                element = problem.elements[count]
                element.row = rows
                element.normal = normal
                element.normals = normals
                fill_element(modes, element, k, place, is_shock)
                count = count + 1
            modes.acting[rows] = float(k)
            rows = rows + 1
        normal = normal + normals
    problem.count = count
    problem.rows = rows
    problem.columns = rows + 1
    problem.components = modes.components
    copy_responses(modes, is_shock)


def is_second(modes: ModeSwitch, candidate: int, place: int) -> int:
    """Return 1 if a candidate is the second direction of a contact, else 0."""
    if place < 0:
        return 0
    if candidate > modes.elements[place].candidate:
        return 1
    return 0


def takes_part(modes: ModeSwitch, place: int, is_shock: int) -> int:
    """Return 1 if a candidate is part of the mode problem, else 0."""
    if place < 0:
        return 1 - is_shock
    element = modes.elements[place]
    if element.is_rope == 0.0:
        if is_shock == 1 and element.gap == 0:
            return 0
        return 1 - int(element.absent)
    if element.is_decided != 0.0:
        return 0
    return 1


def fill_element(modes: ModeSwitch, element: ModeElement, candidate: int, place: int, is_shock: int) -> None:
    """Write one candidate into the mode problem."""
    joints = modes.candidates - modes.ropes
    size = modes.out[3 * joints + candidate_block(modes) + candidate]
    element.law = BOUNDED
    element.scale = modes.units[candidate]
    element.rounding = BALANCED * size + CANCELLED * element.scale / (modes.time * modes.time)
    element.sliding = 0.0
    element.static = 0.0
    element.moves = 0.0
    element.mode = HOLDS
    element.first = 0.0
    element.second = 0.0
    if is_shock == 1:
        element.rounding = 0.0
    if candidate >= joints:
        element.law = UNILATERAL
    else:
        element.sliding = modes.out[3 * candidate + 1]
        element.static = modes.out[3 * candidate + 2]
        if place < 0:
            element.first = modes.out[3 * candidate]
            element.moves = 1.0
            element.mode = LOOSE
            if element.first < 0.0:
                element.mode = -LOOSE
    if place >= 0:
        own = modes.elements[place]
        element.mode = own.opens
        element.moves = own.is_decided
        element.first = float(own.opens)
        if own.rows == 2:
            element.law = CONE
            element.first = own.ahead
            element.second = own.aside


def candidate_block(modes: ModeSwitch) -> int:
    """Return how many numbers lie between the laws and the sizes of accelerations."""
    n = modes.candidates
    return n + n * n + modes.components + modes.components * n


def copy_responses(modes: ModeSwitch, is_shock: int) -> None:
    """Write the responses of the candidates that take part into the mode problem."""
    problem = modes.problem
    n = modes.candidates
    count = problem.rows
    first = 3 * (n - modes.ropes)
    offsets = part(modes.out, first, n)
    responses = part(modes.out, first + n, n * n)
    loads = part(modes.out, first + n + n * n, modes.components)
    reactions = part(modes.out, first + n + n * n + modes.components, modes.components * n)
    for i in range(count):
        row = int(modes.acting[i])
        problem.offsets[i] = offsets[row]
        if is_shock == 1:
            problem.offsets[i] = rate_behind(modes, i)
        for j in range(count):
            problem.responses[i * count + j] = responses[row * n + int(modes.acting[j])]
    for i in range(problem.components):
        problem.loads[i] = loads[i]
        if is_shock == 1:
            problem.loads[i] = modes.shocks[i]
        for j in range(count):
            problem.reactions[i * count + j] = reactions[i * n + int(modes.acting[j])]


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
        if mode != element.written:
            is_new = 1
        element.mode = mode
        element.written = mode
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

    A slack rope that is at its length up to rounding is exactly there, and one without tension but for
    rounding has none. The value of an element that shares its effort says nothing, and never falls to zero.
    """
    for k in range(modes.count):
        element = modes.elements[k]
        element.level = 0.0
        if element.shares != 0.0 or element.absent != 0.0:
            element.level = -NEVER
        elif element.is_rope != 0.0:
            if element.mode != HOLDS:
                if abs(element.slackness) <= AT_LENGTH * element.length:
                    element.level = element.slackness
            else:
                element.level = CANCELLED / BALANCED * slight_effort(modes, element)


def slight_effort(modes: ModeSwitch, element: SwitchingElement) -> float:
    """Return the effort of an element that is rounding; 0 if it accelerates nothing."""
    n = modes.candidates
    joints = n - modes.ropes
    c = element.candidate
    response = modes.out[3 * joints + n + c * n + c]
    size = modes.out[3 * joints + candidate_block(modes) + c]
    rounding = BALANCED * size + CANCELLED * element.unit / (modes.time * modes.time)
    if response > 0.0:
        return rounding / response
    return 0.0


def slight_value(modes: ModeSwitch, place: int) -> float:
    """Return what is rounding of the value that ends the mode of an element, once modes have been decided."""
    element = modes.elements[place]
    if element.mode == HOLDS:
        return slight_effort(modes, element)
    if element.is_rope != 0.0:
        return AT_LENGTH * element.length
    return slow_rate(modes, element)


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
        element.mode = HOLDS
        if abs(Z[size * last + 3 + k]) > 0.5:
            element.mode = int(sign(Z[size * last + 3 + k]))
        element.written = element.mode
        element.ended = 0.0
    modes.recorded = last + 1
