"""Joints that stick and slip, and gaps that open and close, as one set of equations: modes are inputs.

While a joint sticks a row holds it, and a closed gap is a row as well, be it of a taut rope. Here all these
rows are always among the equations, with zeros in place of those that do not hold: the solver leaves a row
of zeros out, and its multiplier is 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.friction import STILL, FrictionLaw
from symbody.equations.solving.sticking import holding_row, switching_joints
from symbody.equations.solving.unilateral import open_gaps, unilateral_elements
from symbody.expr.expression import Expr, number, sqrt, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS, LT, SELECT


@dataclass(frozen=True, slots=True, eq=False)
class ModalEquations:
    """Equations whose modes are inputs.

    Attributes
    ----------
    eqs : EquationSet
        With all rows; its last inputs are the modes.
    joints, gaps : tuple of str
        The elements, in the order of their modes.
    modes : tuple of str
        Names of the inputs: 0 while an element holds, 1 or -1 as the direction in which a joint slips, 1 for
        an open gap.
    """

    eqs: EquationSet
    joints: tuple[str, ...] = ()
    gaps: tuple[str, ...] = ()
    modes: tuple[str, ...] = ()

    def row_names(self, element: str) -> tuple[str, ...]:
        """Return the multipliers of the rows of an element."""
        rows = self.eqs.formed.rows
        if element in self.gaps:
            return tuple(row.name for row in rows if row.gap == element)
        return tuple(law.holding_effort for law in self.laws if law.element == element)

    @property
    def laws(self) -> tuple[FrictionLaw, ...]:
        """The friction of joints and contacts, in their order."""
        return tuple(law for name in self.joints for law in self.laws_of(name))

    def laws_of(self, element: str) -> tuple[FrictionLaw, ...]:
        """Return the friction of an element: of a contact along one direction or two."""
        return tuple(law for law in self.eqs.formed.friction if law.element == element)

    @property
    def names(self) -> tuple[str, ...]:
        """All elements."""
        return (*self.joints, *self.gaps)


def switches(formed: EquationsOfMotion) -> bool:
    """Return whether equations change on the way: joints stick and slip, gaps open and close."""
    return bool(switching_joints(formed) or unilateral_elements(formed))


def modal_equations(eqs: EquationSet) -> ModalEquations:
    """Return equations whose modes are inputs; those given where nothing switches."""
    if not switches(eqs.formed):
        return ModalEquations(eqs)
    made: ModalEquations = eqs.plans.get("modal equations", lambda: _modal_equations(eqs))
    return made


def permanent_equations(eqs: EquationSet) -> EquationSet:
    """Return equations without the rows that hold in some modes only; those given where there are none."""
    lines = unilateral_elements(eqs.formed)

    def make() -> EquationSet:
        return EquationSet(eqs.model, open_gaps(eqs.formed, lines), eqs.notes)

    return eqs.plans.get("permanent equations", make) if lines else eqs


def _modal_equations(eqs: EquationSet) -> ModalEquations:
    formed = eqs.formed
    joints, lines = switching_joints(formed), unilateral_elements(formed)
    inputs = [Symbol(name, SymbolKind.INPUT) for name in free_names(formed, (*joints, *lines), "mode_")]
    modes = dict(zip((*joints, *lines), (symbol(formed.graph, each) for each in inputs), strict=True))
    modal = _with_modes(formed, joints, modes)
    symbols = {**formed.names.symbols, **{each.name: each for each in inputs}}
    names = Names(formed.names.graph, symbols, formed.names.values)
    modal = replace(modal, names=names, inputs=(*formed.inputs, *inputs))
    made = EquationSet(eqs.model, modal, eqs.notes)
    return ModalEquations(made, joints, lines, tuple(each.name for each in inputs))


def free_names(formed: EquationsOfMotion, elements: Iterable[str], first: str) -> list[str]:
    """Return a name for what is input of each element, that formulas can contain and that is not taken."""
    taken = {*formed.names.symbols, *formed.names.values}
    made = []
    for name in elements:
        word = first + "".join(c if c.isalnum() and c.isascii() else "_" for c in name)
        while word in taken:
            word += "_"
        taken.add(word)
        made.append(word)
    return made


def _with_modes(
    formed: EquationsOfMotion, joints: tuple[str, ...], modes: dict[str, Expr]
) -> EquationsOfMotion:
    """Return equations with the rows of all elements, each where its mode is 0."""
    lines = {name: mode for name, mode in modes.items() if name not in joints}  # cut joints have rows, too
    rows = [_row_in_mode(row, lines[row.gap]) if row.gap in lines else row for row in formed.rows]
    switching = [law for name in joints for law in formed.friction if law.element == name]
    rows += [_row_in_mode(holding_row(formed, law), modes[law.element]) for law in switching]
    friction = tuple(
        _slip_in_mode(law, _partner(formed, law), modes[law.element]) if law.switches else law
        for law in formed.friction
    )
    whole = tuple(row for row in formed.rows if row.gap in lines)
    return replace(
        formed.with_rows(tuple(rows)), friction=friction, slack=(*formed.slack, *whole), modes=lines
    )


def _partner(formed: EquationsOfMotion, law: FrictionLaw) -> FrictionLaw | None:
    """Return the friction of a contact along the other direction."""
    others = (other for other in formed.friction if other.element == law.element and other != law)
    return next(others, None)


def _slip_in_mode(law: FrictionLaw, partner: FrictionLaw | None, mode: Expr) -> FrictionLaw:
    """Return a law that slips as its mode says.

    In two directions it slips along its velocity, and from rest along the heading that is in its mode. The
    velocity counts with the sign of what it has along the heading, so that the law goes on smoothly through
    rest, where the mode ends.
    """
    if partner is None:
        return replace(law, slip=mode, switches=False, may_stick=True)
    zero, one = number(mode.graph, 0), number(mode.graph, 1)
    ahead, across = mode_heading(mode)
    if law.name.endswith("y"):
        ahead, across = across, ahead
    along = law.rate * ahead + partner.rate * across
    square = law.rate * law.rate + partner.rate * partner.rate
    moves = (one * STILL**2).apply(LT, square)
    back = along.apply(LT, zero)
    length = sqrt(moves.apply(SELECT, square, one))
    slip = moves.apply(SELECT, law.rate / back.apply(SELECT, -length, length), ahead)
    slip = _is_held(mode).apply(SELECT, zero, slip)
    return replace(law, slip=slip, switches=False, may_stick=True, heading=ahead)


def _is_held(mode: Expr) -> Expr:
    """Return the condition that an element holds."""
    return mode.apply(ABS).apply(LT, number(mode.graph, 1) / 2)


def mode_heading(mode: Expr) -> tuple[Expr, Expr]:
    """Return the unit vector that the mode of a contact contains: 1 + p/8, p along a square in (-2, 2].

    The square ``abs(x) + abs(y) = 1`` is passed once: ``x = 1 - abs(p)``, and y is p where x is positive.
    """
    one = number(mode.graph, 1)
    p = (mode - 1) * 8
    size = p.apply(ABS)
    x = 1 - size
    rest = 2 - size
    y = size.apply(LT, one).apply(SELECT, p, p.apply(LT, one * 0).apply(SELECT, -rest, rest))
    length = sqrt(x * x + y * y)
    return x / length, y / length


def _row_in_mode(row: ConstraintEquation, mode: Expr) -> ConstraintEquation:
    """Return a row that holds where the mode is 0, and is 0 = 0 elsewhere.

    A choice, not a product: the direction of a slack rope whose ends coincide is no number.
    """
    zero = number(mode.graph, 0)
    holds = _is_held(mode)

    def choose(value: Expr) -> Expr:
        return holds.apply(SELECT, value, zero)

    return replace(
        row, value=choose(row.value), drift=choose(row.drift), gamma=choose(row.gamma),
        jacobian={u: choose(slope) for u, slope in row.jacobian.items()},
        force=row.force.map(choose), moment=row.moment.map(choose),
    )  # fmt: skip
