"""Outputs about joints: reactions, efforts, and the power of drives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from symbody.equations.dynamics.balance import NO_WRENCH, Wrench
from symbody.equations.dynamics.reactions import effort_on_coordinate, reaction
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.variables import JointRole
from symbody.errors import FormulationError, Problem, nearest
from symbody.expr.expression import Expr, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.model.constraints import Rolling
from symbody.model.contacts.contact import Contact
from symbody.model.output_names import WRENCH
from symbody.spatial.vector import components, cross


def reaction_wrench(
    formed: EquationsOfMotion,
    joint: str,
    on: str = "",
    at: str = "",
    totals: Mapping[str, Wrench] | None = None,
) -> Wrench:
    """Return the reaction of a joint as a formula in u' and the multipliers.

    Raises FormulationError if joint or frame do not exist, or the joint does not act on the body.

    Parameters
    ----------
    on : str, optional
        The body it acts on; the end body by default.
    at : str, optional
        The frame whose origin the moment is about; by default the end frame, or the point of contact.
    totals : mapping of joint to Wrench, optional
        The total wrenches; by default the formulas of those of the motion.
    """
    owner = formed.topology.link(joint)
    if owner is None:
        raise FormulationError(
            Problem("equations.unknown_joint", f"joint {joint}", f"no joint or constraint {joint!r} connects "
                    "two bodies", "", nearest(joint, formed.wrenches))
        )  # fmt: skip
    if isinstance(owner, Contact) and totals is None:
        raise FormulationError(
            Problem("equations.no_reaction", f"contact {joint}", "a contact has no output of this name",
                    "its force acts in its points, friction included", f"write contact_force {joint}")
        )  # fmt: skip
    wrench = (formed.wrenches if totals is None else totals).get(joint, NO_WRENCH)
    if joint not in formed.topology.contacts:
        wrench = reaction(formed.names, formed.kinematics, formed.topology.joint(joint), wrench)
    at = joint if isinstance(owner, Rolling) and not at else at
    if at:
        arm = formed.kinematics.position(formed.frame(at), owner.end.full_name)
        wrench = Wrench(wrench.force, wrench.moment + cross(formed.kinematics.tree, arm, wrench.force))
    if on and on not in (owner.end.body, owner.start.body):
        what = f"the joint does not act on {on!r}"
        fix = f"name {owner.start.body} or {owner.end.body}"
        raise FormulationError(Problem("equations.not_its_body", f"joint {joint}", what, "", fix))
    return Wrench(-wrench.force, -wrench.moment) if on == owner.start.body else wrench


def reaction_axes(formed: EquationsOfMotion, name: str) -> str:
    """Return the frame that a reaction is resolved in: start; of a rolling contact its own frame."""
    link = formed.topology.link(name)
    assert link is not None
    return formed.frame(name) if isinstance(link, Rolling) else link.start.full_name


def reaction_output(formed: EquationsOfMotion, words: Sequence[str]) -> tuple[tuple[int, ...], list[Expr]]:
    """Return the output "reaction J", (6,), or one entry "reaction J Fx"; see `reaction_axes`."""
    name, *entry = filter(None, words)
    if entry and (len(entry) > 1 or entry[0] not in WRENCH):
        text = " ".join(words)
        what = f"{text!r} is not the name of a reaction"
        fix = f'write "reaction JOINT" or "reaction JOINT ENTRY" with one of {", ".join(WRENCH)}'
        raise FormulationError(Problem("equations.reaction_words", f"reaction {text}", what, "", fix))
    values = reaction_entries(formed, name)
    return ((), [values[WRENCH.index(entry[0])]]) if entry else ((6,), values)


def reaction_entries(
    formed: EquationsOfMotion, name: str, totals: Mapping[str, Wrench] | None = None
) -> list[Expr]:
    """Return the six components of a reaction in terms of u' and the multipliers."""
    totals = formed.solved_wrenches if totals is None else totals
    wrench, axes = reaction_wrench(formed, name, totals=totals), reaction_axes(formed, name)
    tree = formed.kinematics.tree
    return [*components(tree, wrench.force, axes), *components(tree, wrench.moment, axes)]


def prescribed_efforts(
    formed: EquationsOfMotion, totals: Mapping[str, Wrench] | None = None
) -> Iterator[tuple[str, str, Expr]]:
    """Return the name of each effort that holds a prescribed coordinate, the coordinate, and the effort."""
    for name, (role, coordinate) in _prescribed_coordinates(formed):
        yield name, coordinate, _holding_effort(formed, role, coordinate, totals)


def effort_output(formed: EquationsOfMotion, words: Sequence[str]) -> tuple[tuple[int, ...], list[Expr]]:
    """Return the output "effort J", or "effort J x" along a coordinate: of its drive or prescribed motion."""
    name = " ".join(filter(None, words))
    found = dict(_prescribed_coordinates(formed))
    if name not in effort_names(formed):
        what = f"there is no driven joint coordinate {name!r}"
        fix = nearest(name, effort_names(formed))
        raise FormulationError(Problem("equations.unknown_effort", f"effort {name}", what, "", fix))
    if name in found:
        return (), [_holding_effort(formed, *found[name])]
    effort = formed.loads.efforts.get(name, Expr(formed.graph, 0))
    for row in formed.rows:
        if row.coordinate and formed.topology.joint(row.element).effort_name(row.coordinate) == name:
            effort = effort + symbol(formed.graph, Symbol(row.name, SymbolKind.MULTIPLIER))
    return (), [effort]


def effort_names(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the names that may follow "effort"."""
    names = [*formed.loads.efforts, *(name for name, _ in _prescribed_coordinates(formed))]
    for row in formed.rows:
        if row.coordinate:
            names.append(formed.topology.joint(row.element).effort_name(row.coordinate))
    return tuple(dict.fromkeys(names))


def total_power(formed: EquationsOfMotion) -> Expr:
    """Return the power of all loads without potential and of prescribed motions [W]."""
    graph, names = formed.graph, formed.names
    total = formed.loads.power
    for _, (role, coordinate) in _prescribed_coordinates(formed):
        total = total + _holding_effort(formed, role, coordinate) * names.value(f"{coordinate}_dot")
    for row in formed.rows:
        if row.coordinate:
            total = total - symbol(
                graph, Symbol(row.name, SymbolKind.MULTIPLIER)
            ) * formed.rest_in_all_speeds(row)
    for row, multiplier in formed.rows_and_multipliers:
        if row.driven is not None and not row.driven.is_zero:
            total = total + multiplier * row.driven
    return total


def _prescribed_coordinates(formed: EquationsOfMotion) -> Iterator[tuple[str, tuple[JointRole, str]]]:
    """Return the prescribed coordinates by the name of their effort."""
    for role in formed.joint_roles:
        for coordinate in role.prescribed_coordinates:
            yield role.joint.effort_name(coordinate), (role, coordinate)


def _holding_effort(
    formed: EquationsOfMotion, role: JointRole, coordinate: str, totals: Mapping[str, Wrench] | None = None
) -> Expr:
    """Return the effort of a prescribed motion: the joint's wrench along it, and that of its rotor."""
    joint, names, kinematics = role.joint, formed.names, formed.kinematics
    total = (formed.solved_wrenches if totals is None else totals)[joint.name]
    effort = effort_on_coordinate(names, kinematics, joint, coordinate, total)
    if coordinate in joint.armature:
        rotor = names.expression(joint.armature[coordinate], f"joint {joint.name}")
        effort = effort + rotor * names.value(f"{coordinate}_ddot")
    for law in formed.friction:
        if law.name == joint.name:
            effort = effort - law.effort
    for row, multiplier in formed.bearing_rows:
        if coordinate in row.shares:
            effort = effort - row.shares[coordinate] * multiplier
    return effort
