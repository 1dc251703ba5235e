"""Outputs about friction, ropes and stops: efforts, gaps, and how far sticking is from its end."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.loads.contacts import centre_of_pressure
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.solving.friction_solution import normal_load
from symbody.equations.solving.solution import resistance
from symbody.equations.solving.unilateral import (
    effort_of,
    gap_of,
    gap_scale,
    row_number,
    unilateral_elements,
    unilateral_row,
)
from symbody.errors import FormulationError, Problem, nearest
from symbody.expr.expression import Expr, number, sqrt, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS

Output = tuple[tuple[int, ...], list[Expr]]


def friction_effort(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "friction J": the effort on the end body along the positive coordinate."""
    _, law = _find_law(formed, words)
    return (), [_effort(law)]


def friction_normal(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "friction_normal J": the magnitude of the reaction that friction comes from."""
    k, _ = _find_law(formed, words)
    return (), [resistance(formed).normals[k]]


def friction_reserve(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "friction_reserve J": the effort up to which it sticks, less the present one."""
    if words == ("",):
        laws, normals = formed.friction, resistance(formed).normals
        return (len(laws),), [_reserve(law, normal) for law, normal in zip(laws, normals, strict=True)]
    k, law = _find_law(formed, words)
    return (), [_reserve(law, resistance(formed).normals[k], *_others(formed, law))]


def friction_rate(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "friction_rate J": the rate that friction is against."""
    return (), [_find_law(formed, words)[1].rate]


def slip_along(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "slip_along C": the slip of a contact along the heading that is in its mode."""
    _, law = _find_law(formed, words)
    total = number(formed.graph, 0)
    for one in (law, *_others(formed, law)):
        total = total + (one.rate if one.heading is None else one.rate * one.heading)
    return (), [total]


def _others(formed: EquationsOfMotion, law: FrictionLaw) -> list[FrictionLaw]:
    """Return the friction along the other direction of a contact that slips in two."""
    return [other for other in formed.friction if other.element == law.element and other is not law]


def _reserve(law: FrictionLaw, normal: Expr, *others: FrictionLaw) -> Expr:
    if not others:
        return law.limit * normal - _effort(law).apply(ABS)
    efforts = [_effort(one) for one in (law, *others)]
    return law.limit * normal - sqrt(sum((x * x for x in efforts[1:]), efforts[0] * efforts[0]))


def friction_equations(formed: EquationsOfMotion) -> list[tuple[Expr, Expr]]:
    """Return the law of each effort, and the reaction N where the law reads it."""
    equations = []
    for law in formed.friction:
        normal = law.normal
        equations.append((law.effort, -(law.slip * law.strength * normal)))
        if law.reads_reaction:
            equations.append((normal, _magnitude(normal_load(formed, law))))
    return equations


def _magnitude(parts: list[Expr]) -> Expr:
    acting = [part for part in parts if not part.is_zero] or parts[:1]
    if len(acting) == 1:
        return acting[0].apply(ABS)
    return sqrt(sum((part**2 for part in acting[1:]), acting[0] ** 2))


def friction_names(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the joints with friction."""
    return tuple(law.name for law in formed.friction)


def _effort(law: FrictionLaw) -> Expr:
    if not (law.sticks or law.may_stick):
        return law.effort
    held = symbol(law.rate.graph, Symbol(law.holding_effort, SymbolKind.MULTIPLIER))
    return held if law.sticks else law.effort + held


def _find_law(formed: EquationsOfMotion, words: Sequence[str]) -> tuple[int, FrictionLaw]:
    """Return the place and the law that a name means; a FormulationError with the nearest names if none."""
    names, text = friction_names(formed), " ".join(words)
    elements = [law.element for law in formed.friction]
    if text in elements:
        names = (*elements,)
    if text in names:
        return names.index(text), formed.friction[names.index(text)]
    what = f"there is no joint {text!r} with friction"
    fix = nearest(text, names)
    raise FormulationError(Problem("equations.unknown_friction", f"friction {text}", what, "", fix))


def mode_output(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "mode J": the direction in which a joint slips, 0 while it sticks; 1 for closed gaps.

    Outside of motions it is the sign of the joint's rate, and gaps are closed: ropes are taut.
    """
    element = " ".join(words)
    if element in [law.element for law in formed.friction]:
        law = _find_law(formed, words)[1]
        return (), [law.slip if law.touch is None else formed.modes.get(element, law.slip)]
    row = _find_row(formed, words)
    closed = row.name in formed.given or any(row.name == other.name for other in formed.rows)
    return (), [number(formed.graph, int(closed)) - formed.modes.get(row.gap, number(formed.graph, 0))]


def opening_effort(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "contact_force E" or "rope_tension R": what opens the gap; 0 where it is open."""
    row = _find_row(formed, words)
    if row.name in formed.given:
        return (), [formed.given[row.name] * row.sense]
    if all(row.name != other.name for other in formed.rows):
        return (), [number(formed.graph, 0)]
    return (), [effort_of(row)]


def rigid_force(formed: EquationsOfMotion, contact: str) -> list[Expr]:
    """Return the force of a rigid contact on its end, in all its points, in the axes of its frame."""
    force = [number(formed.graph, 0)] * 3
    for law in formed.friction:
        if law.owner == contact:
            place = "xy".index(law.name[-1])
            force[place] = force[place] + _effort(law)
    for _, effort in _acting_rows(formed, contact):
        force[2] = force[2] + effort
    return force


def _acting_rows(formed: EquationsOfMotion, contact: str) -> list[tuple[ConstraintEquation, Expr]]:
    """Return the rows of a rigid contact that act, each with the force along the normal."""
    own = [(row, effort_of(row)) for row in formed.rows if row.element == contact and row.sense]
    return own + [(row, effort * row.sense) for row, effort in formed.given_rows if row.element == contact]


def rigid_point(formed: EquationsOfMotion, contact: str) -> list[Expr]:
    """Return where the force of a rigid contact acts, from start's origin in its axes."""
    measures = formed.loads.measures
    pressing = _acting_rows(formed, contact)
    return [
        centre_of_pressure(
            [effort for _, effort in pressing],
            [measures[f"touch {contact} {row_number(row.name)} {letter}"] for row, _ in pressing],
            measures[f"touch {contact} {letter}"],
        )
        for letter in "xyz"
    ]


def gap(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gap E" or "rope_slack R": the length of a rope less the distance of its ends."""
    return (), [gap_of(_find_row(formed, words))]


def gap_rate(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gap_dot E" or "rope_slack_dot R"."""
    row = _find_row(formed, words)
    total = row.drift
    for u, slope in row.jacobian.items():
        total = total + slope * Expr(formed.graph, u)
    return (), [total * row.sense]


def gap_acceleration(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gap_ddot E" or "rope_slack_ddot R"."""
    row = _find_row(formed, words)
    total = -row.gamma
    for slope, rate in _terms(formed, row):
        total = total + slope * rate
    return (), [total * row.sense]


def gap_acceleration_size(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "rope_size R": what cancels in its second rate: its rounding is a share of it."""
    row = _find_row(formed, words)
    total, speed = row.gamma.apply(ABS), number(formed.graph, 0)
    for slope, rate in _terms(formed, row):
        total = total + (slope * rate).apply(ABS)
    for u, slope in row.jacobian.items():
        speed = speed + (slope * Expr(formed.graph, u)).apply(ABS)
    scale = gap_scale(formed, row)
    return (), [total if scale.is_zero else total + speed**2 / scale]


def gap_scale_output(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "gap_scale E" or "rope_length R": of the rope itself."""
    return (), [gap_scale(formed, _find_row(formed, words))]


def gap_restitution(formed: EquationsOfMotion, words: Sequence[str]) -> Output:
    """Return the output "restitution E"."""
    row = _find_row(formed, words)
    return (), [number(formed.graph, 0) if row.restitution is None else row.restitution]


def _terms(formed: EquationsOfMotion, row: ConstraintEquation) -> list[tuple[Expr, Expr]]:
    """Return the slopes of a row with the accelerations they belong to."""
    graph, zero = formed.graph, number(formed.graph, 0)
    speeds = zip(formed.u, formed.kinematics.speeds, strict=True)
    return [(row.jacobian.get(node, zero), symbol(graph, u.derivative)) for u, node in speeds]


def _find_row(formed: EquationsOfMotion, words: Sequence[str]) -> ConstraintEquation:
    """Return the row of the gap that a name means; a FormulationError with the nearest if there is none."""
    names, text = unilateral_elements(formed), " ".join(words)
    if text in names:
        return unilateral_row(formed, text)
    what = f"there is no rope, stop or rigid contact {text!r}"
    why = (
        "ropes are constraints of type distance with rope = true, stops are of type stop; rigid contacts "
        'have normal = "rigid"'
    )
    raise FormulationError(Problem("equations.unknown_rope", f"rope {text}", what, why, nearest(text, names)))
