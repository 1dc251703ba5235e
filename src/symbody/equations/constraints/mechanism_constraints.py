"""All constraints of a mechanism; those that hold identically are set apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from symbody.equations.constraints.constraint_elements import constraint_equations
from symbody.equations.constraints.integrability import is_integrable
from symbody.equations.constraints.loop_closure import loop_closure_equations, motion_equations
from symbody.equations.elimination.coupled_coordinates import NONE_COUPLED, CoupledCoordinates
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.expr.fingerprints.fingerprint import find_zeros
from symbody.expr.graph import Graph, SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence, tree_size
from symbody.graph.topology import Topology

_SHORT: Final = 40
# Of the largest offset of a frame; sums of lengths typed with 17 digits are far below, gaps far above.
_ROUNDING: Final = 1e-14


class MechanismConstraints(NamedTuple):
    """The constraints of a mechanism.

    Attributes
    ----------
    rows : list of ConstraintEquation
        Without those that hold identically, holonomic ones first.
    redundant : list of ConstraintEquation
        Those that hold identically, without slopes: nothing follows from them, but they bear loads.
    notes : tuple of str
    coupled : CoupledCoordinates
        Coordinates that are substituted, with the rows that give them.
    """

    rows: list[ConstraintEquation]
    redundant: list[ConstraintEquation]
    notes: tuple[str, ...]
    coupled: CoupledCoordinates = NONE_COUPLED


def form_constraints(
    topology: Topology,
    names: Names,
    kinematics: Kinematics,
    roles: Sequence[JointRole],
    coupled: CoupledCoordinates = NONE_COUPLED,
) -> MechanismConstraints:
    """Return the constraints of a mechanism, without couplings that give coordinates.

    Raises
    ------
    FormulationError
        If a row is a constant other than zero, so that the loop can never close; if it depends on time
        alone; if an equation is not of first degree in the speeds; if a symbol has a multiplier's name.
    """
    rows = [
        row
        for role in roles
        for row in (
            *loop_closure_equations(names, kinematics, role),
            *motion_equations(names, kinematics, role),
        )
    ]
    for condition in topology.model.constraints:
        rows += constraint_equations(names, kinematics, condition)
    coupled, rows = coupled.take_rows(rows)
    rows.sort(key=lambda row: not row.is_holonomic)
    rounding = _ROUNDING * _size(topology)
    gone = [
        zero or _is_rounding(row, rounding)
        for row, zero in zip(rows, _find_identities(kinematics.graph, rows), strict=True)
    ]
    kept = [row for row, zero in zip(rows, gone, strict=True) if not zero]
    problems = list(_impossible_problems(topology, kinematics.graph, kept, roles))
    problems += [
        Problem("equations.name_clash", f"element {row.element}", f"{row.name} is defined twice",
                "it is a symbol of the model, and the multiplier of a constraint", "rename the symbol")
        for row in rows if row.name in names.symbols
    ]  # fmt: skip
    if problems:
        raise FormulationError(*problems)
    lost = [row for row, zero in zip(rows, gone, strict=True) if zero]
    zero = Expr(kinematics.graph, 0)
    redundant = [replace(row, jacobian={}, drift=zero, gamma=zero) for row in lost]
    notes = (*_identity_notes(topology, lost), *_integrable_notes(kinematics, kept))
    return MechanismConstraints(kept, redundant, notes, coupled)


def _find_identities(graph: Graph, rows: Sequence[ConstraintEquation]) -> list[bool]:
    """Return which rows hold identically: by their value, or by all that makes up their rate."""
    parts = [[row.value] if row.is_holonomic else [row.drift, *row.jacobian.values()] for row in rows]
    zero = iter(find_zeros(graph, [x.index for group in parts for x in group]))
    return [all([next(zero) for _ in group]) for group in parts]


def _is_rounding(row: ConstraintEquation, rounding: float) -> bool:
    """Return whether a closing equation is a constant that is 0 but for the digits lengths are typed with."""
    number = row.value.number
    limit = _ROUNDING if row.force.is_zero else rounding
    return isinstance(number, float) and row.is_holonomic and abs(number) <= limit


def _size(topology: Topology) -> float:
    """Return the largest offset of a frame that is a number [m]."""
    model = topology.model
    frames = [*model.ground.values(), *(frame for body in model.bodies for frame in body.frames.values())]
    offsets = (x.constant() for frame in frames for x in frame.at)
    return max((abs(float(x)) for x in offsets if x is not None), default=0.0)


def _impossible_problems(
    topology: Topology, graph: Graph, rows: Sequence[ConstraintEquation], roles: Sequence[JointRole]
) -> Iterator[Problem]:
    """Return a problem for each row that no motion fulfils.

    A constraint on parameters alone is checked with their values: `check_parameter_constraints`.
    """
    kinds = dependence(graph, [row.value.index for row in rows])
    driven = ", ".join(name for role in roles for name in role.prescribed_coordinates)
    for row, is_idle in zip(rows, _find_speedless(graph, rows), strict=True):
        where = f"{_kind(topology, row)} {row.element}"
        inside = kinds[row.value.index]
        if is_own(topology, row):
            if is_idle and not (
                row.is_holonomic and row.value.number is None and inside == {SymbolKind.PARAMETER}
            ):
                yield _contradiction_problem(graph, row, where, driven)
        elif row.value.number is not None:
            yield _never_closed_problem(row, where)
        elif SymbolKind.TIME in inside and SymbolKind.COORDINATE not in inside:
            yield Problem(
                "equations.over_driven", where,
                f"its closing equation {row.name} depends on time only: every joint of its loop is driven",
                f"prescribed are {driven or 'none'}, more than the loop has degrees of freedom",
                "leave one of these coordinates free, or give it a drive instead of a prescribed motion",
            )  # fmt: skip


def _find_speedless(graph: Graph, rows: Sequence[ConstraintEquation]) -> list[bool]:
    """Return which rows no speed is in: those whose slopes vanish identically."""
    zero = iter(find_zeros(graph, [slope.index for row in rows for slope in row.jacobian.values()]))
    return [all([next(zero) for _ in row.jacobian]) for row in rows]


def _never_closed_problem(row: ConstraintEquation, where: str) -> Problem:
    return Problem(
        "equations.never_closed", where,
        f"its closing equation {row.name} is the constant {row.value.number} for all values of the "
        f"coordinates",
        "the frames it connects are apart in a direction in which neither can move",
        "move the frames together, or let the loop move in this direction",
    )  # fmt: skip


def _contradiction_problem(graph: Graph, row: ConstraintEquation, where: str, driven: str) -> Problem:
    """Return the problem of a constraint without a coordinate or speed that is not 0 = 0."""
    left = row.value if row.is_holonomic else row.drift
    number = left.number
    if number is None and tree_size(graph, left.index) > _SHORT:
        said = "without a coordinate or speed"
    else:
        said = f"{number if number is not None else to_text(graph, left.index)}, regardless of the motion"
    why = "what it constrains does not move" + (
        f", or contains prescribed coordinates only ({driven})" if driven else ""
    )
    return Problem(
        "equations.never_closed", where, f"its equation {row.name} has the left-hand side {said}", why,
        "leave it out, or free what it constrains",
    )  # fmt: skip


def _identity_notes(topology: Topology, rows: Sequence[ConstraintEquation]) -> Iterator[str]:
    lost: dict[str, list[str]] = {}
    for row in rows:
        lost.setdefault(f"{_kind(topology, row)} {row.element}", []).append(row.name)
    for where, names in lost.items():
        count = "1 equation holds" if len(names) == 1 else f"{len(names)} equations hold"
        are = "is" if len(names) == 1 else "are"
        if where.startswith("joint"):
            count, are = f"{len(names)} closing equations hold", "are"
        yield f"{where}: {count} identically and {are} dropped ({', '.join(names)})"


def _integrable_notes(kinematics: Kinematics, rows: Sequence[ConstraintEquation]) -> Iterator[str]:
    for row in rows:
        if not row.is_holonomic and is_integrable(kinematics, row):
            yield (
                f"constraint {row.element}: {row.name} constrains velocities, but is the time derivative of "
                f"a position constraint; write it in coordinates, so that positions do not drift"
            )


def _kind(topology: Topology, row: ConstraintEquation) -> str:
    return "constraint" if is_own(topology, row) else "joint"


def is_own(topology: Topology, row: ConstraintEquation) -> bool:
    """Return whether a row belongs to a constraint beside the joints."""
    return any(part.name == row.element for part in topology.model.constraints)
