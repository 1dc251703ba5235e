"""From a `ModeSwitch` to the `ModeProblem` of those of its elements that may hold or not."""

from __future__ import annotations

from symbody.kernels.language import part, sqrt
from symbody.kernels.modes.find_modes import BALANCED, CANCELLED
from symbody.kernels.modes.mode_problem import BOUNDED, CONE, HOLDS, LOOSE, UNILATERAL, ModeElement
from symbody.kernels.modes.mode_state import slow_rate
from symbody.kernels.modes.mode_switch import ModeSwitch, SwitchingElement


def fill_problem(modes: ModeSwitch, is_shock: int) -> None:
    """Write what decides into the mode problem; gaps that are open whatever efforts are take no part.

    A rope of length 0 has no direction. Of a shock, gaps at zero alone and friction in them, with rates in
    the place of accelerations.
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
    if element.is_gap == 0.0:
        if is_shock == 1 and element.gap == 0:
            return 0
        return 1 - int(element.absent)
    if element.is_decided != 0.0:
        return 0
    return 1


def fill_element(modes: ModeSwitch, element: ModeElement, candidate: int, place: int, is_shock: int) -> None:
    """Write one candidate into the mode problem."""
    joints = modes.candidates - modes.gaps
    element.law = BOUNDED
    element.scale = modes.units[candidate]
    element.rounding = slight_acceleration(modes, candidate)
    element.sliding = 0.0
    element.static = 0.0
    element.moves = 0.0
    element.mode = HOLDS
    element.first = 0.0
    element.second = 0.0
    if is_shock == 1:
        element.rounding = slow_rate(modes, modes.elements[place])
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
            head_along(element, own, is_shock)


def head_along(element: ModeElement, slipping: SwitchingElement, is_shock: int) -> None:
    """Write along what a contact slips: its heading, or its velocity once that has turned from it."""
    element.first = slipping.ahead
    element.second = slipping.aside
    along = slipping.rate * slipping.ahead + slipping.across * slipping.aside
    if slipping.is_decided != 0.0 and is_shock == 0 and along > 0.0:
        size = sqrt(slipping.rate * slipping.rate + slipping.across * slipping.across)
        element.first = slipping.rate / size
        element.second = slipping.across / size


def candidate_block(modes: ModeSwitch) -> int:
    """Return how many numbers lie between the laws and the sizes of accelerations."""
    n = modes.candidates
    return n + n * n + modes.components + modes.components * n


def copy_responses(modes: ModeSwitch, is_shock: int) -> None:
    """Write the responses of the candidates that take part into the mode problem."""
    problem = modes.problem
    n = modes.candidates
    count = problem.rows
    first = 3 * (n - modes.gaps)
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
    first = 3 * (count - modes.gaps) + count
    responses = part(modes.out, first + int(modes.acting[i]) * count, count)
    rate = row_rate(modes, i)
    for j in range(modes.problem.rows):
        candidate = int(modes.acting[j])
        rate = rate + responses[candidate] * modes.impulses[candidate]
    return rate


def acceleration_of(modes: ModeSwitch, candidate: int) -> float:
    """Return the acceleration along the row of a candidate with the efforts that were found."""
    problem = modes.problem
    count = modes.candidates
    total = modes.out[3 * (count - modes.gaps) + candidate]
    responses = part(modes.out, 3 * (count - modes.gaps) + count + candidate * count, count)
    for k in range(problem.rows):
        if int(modes.acting[k]) == candidate:
            return problem.accelerations[k]
        total = total + responses[int(modes.acting[k])] * problem.efforts[k]
    return total


def slight_acceleration(modes: ModeSwitch, candidate: int) -> float:
    """Return the acceleration along the row of a candidate that is rounding."""
    size = modes.out[3 * (modes.candidates - modes.gaps) + candidate_block(modes) + candidate]
    return BALANCED * size + CANCELLED * modes.units[candidate] / (modes.time * modes.time)


def slight_effort(modes: ModeSwitch, element: SwitchingElement) -> float:
    """Return the effort of an element that is rounding; 0 if it accelerates nothing."""
    n = modes.candidates
    c = element.candidate
    response = modes.out[3 * (n - modes.gaps) + n + c * n + c]
    if response > 0.0:
        return slight_acceleration(modes, c) / response
    return 0.0
