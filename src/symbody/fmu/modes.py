"""Joints that stick and slip, and ropes that slacken, as one set of equations with their modes as arguments.

While a joint sticks a row holds it, and a taut rope is a row as well. Here all these rows are always there,
with zeros in their place where they do not hold: the solver drops a row of zeros, and its multiplier is 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.naming import Names
from symbody.equations.solving.ropes import rope_row, ropes
from symbody.equations.solving.solution import resistance
from symbody.equations.solving.sticking import holding_row, switching_joints
from symbody.expr.expression import Expr, number, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS, LT, SELECT

# What is computed of each element, in the order of `core/modes.h`.
MEASURES: Final = ("slack", "rate", "length", "force", "acceleration", "limit")


@dataclass(frozen=True, slots=True)
class SwitchingElement:
    """A joint with dry friction, or a rope.

    Attributes
    ----------
    name : str
        In the model.
    is_rope : bool
    is_angle : bool
        Whether its rate is one of an angle.
    """

    name: str
    is_rope: bool
    is_angle: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class ModalEquations:
    """Equations whose modes are arguments.

    Attributes
    ----------
    eqs : EquationSet
        With all rows; those of `arguments` are parameters of it.
    elements : tuple of SwitchingElement
        Joints, then ropes.
    arguments : tuple of str
        Of each joint the direction of slip, -1, 0 or 1, and 1 while it is held; of each rope 1 while taut.
    measures : tuple of str
        Outputs: `MEASURES` of each element.
    words : mapping of output to output
        What stands for outputs about friction that the equations of one mode alone compute.
    """

    eqs: EquationSet
    elements: tuple[SwitchingElement, ...] = ()
    arguments: tuple[str, ...] = ()
    measures: tuple[str, ...] = ()
    words: Mapping[str, str] = field(default_factory=dict)

    def outputs(self, names: Iterable[str]) -> tuple[str, ...]:
        """Return outputs for all modes."""
        return tuple(self.words.get(name, name) for name in names)

    def plain_name(self, output: str) -> str:
        """Return the name of the user for an output."""
        return next((name for name, word in self.words.items() if word == output), output)


def modal_equations(eqs: EquationSet) -> ModalEquations:
    """Return equations whose modes are arguments; those given where nothing switches."""
    formed = eqs.formed
    joints, lines = switching_joints(formed), ropes(formed)
    if not joints and not lines:
        return ModalEquations(eqs)
    arguments = _free_names(
        formed,
        [f"{word}_{name}" for name in joints for word in ("slip", "hold")]
        + [f"taut_{name}" for name in lines],
    )
    symbols = {name: Symbol(name, SymbolKind.PARAMETER) for name in arguments}
    names = Names(formed.names.graph, {**formed.names.symbols, **symbols}, formed.names.values)
    modal = _with_modes(formed, joints, lines, [symbol(formed.graph, each) for each in symbols.values()])
    modal = replace(modal, names=names, parameters=(*formed.parameters, *symbols.values()))
    values = _measures(formed, modal, joints, lines) | _friction_words(modal, joints)
    words = dict(zip(values, _free_names(modal, [f"measure_{k}" for k in range(len(values))]), strict=True))
    modal = replace(modal, names=names.with_values({words[name]: value for name, value in values.items()}))
    laws = {law.joint.name: law for law in formed.friction}
    elements = (
        *(
            SwitchingElement(name, False, laws[name].coordinate in laws[name].joint.rotation_coordinates)
            for name in joints
        ),
        *(SwitchingElement(name, True) for name in lines),
    )
    count = len(MEASURES) * len(elements)
    shown = {name: words[name] for name in list(values)[count:]}
    measures = tuple(words[name] for name in list(values)[:count])
    return ModalEquations(EquationSet(eqs.model, modal, eqs.notes), elements, arguments, measures, shown)


def _free_names(formed: EquationsOfMotion, wanted: list[str]) -> tuple[str, ...]:
    """Return names that formulas can contain and that are not taken."""
    taken = {*formed.names.symbols, *formed.names.values}
    made = []
    for name in wanted:
        word = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in name)
        while word in taken:
            word += "_"
        taken.add(word)
        made.append(word)
    return tuple(made)


def _with_modes(
    formed: EquationsOfMotion, joints: tuple[str, ...], lines: tuple[str, ...], modes: list[Expr]
) -> EquationsOfMotion:
    slips = dict(zip(joints, modes[: 2 * len(joints) : 2], strict=True))
    holds = dict(zip(joints, modes[1 : 2 * len(joints) : 2], strict=True))
    taut = dict(zip(lines, modes[2 * len(joints) :], strict=True))
    rows = [_scale_row(row, taut[row.element]) if row.element in taut else row for row in formed.rows]
    laws = []
    for law in formed.friction:
        name = law.joint.name
        if name in slips:
            rows.append(_scale_row(holding_row(formed, law), holds[name]))
            law = replace(law, slip=slips[name], switches=False)
        laws.append(law)
    return replace(formed.with_rows(tuple(rows)), friction=tuple(laws))


def _scale_row(row: ConstraintEquation, share: Expr) -> ConstraintEquation:
    """Return a row that holds where the share is 1, and is 0 = 0 where it is 0.

    A choice, not a product: the direction of a slack rope whose ends coincide is no number.
    """
    zero = number(share.graph, 0)
    holds = zero.apply(LT, share)

    def choose(value: Expr) -> Expr:
        return holds.apply(SELECT, value, zero)

    return replace(
        row, value=choose(row.value), drift=choose(row.drift), gamma=choose(row.gamma),
        jacobian={u: choose(slope) for u, slope in row.jacobian.items()},
        force=row.force.map(choose), moment=row.moment.map(choose),
    )  # fmt: skip


def _measures(
    formed: EquationsOfMotion, modal: EquationsOfMotion, joints: tuple[str, ...], lines: tuple[str, ...]
) -> dict[str, Expr]:
    """Return what is measured of each element, in the order of `MEASURES`."""
    graph, zero = formed.graph, number(formed.graph, 0)
    normals = resistance(modal).normals if joints else []
    made: list[Expr] = []
    for law, normal in zip(modal.friction, normals, strict=bool(joints)):
        if law.joint.name in joints:
            held = _multiplier(modal, law.holding_effort)
            row = holding_row(formed, law)
            _, rate, acceleration = _slackness(formed, row)
            made += [zero, -rate, zero + 1, held, -acceleration, law.limit * normal]
    for name in lines:
        row = rope_row(formed, name)
        size = row.gamma.apply(ABS)
        for u, speed in zip(formed.u, formed.kinematics.speeds, strict=True):
            slope = row.jacobian.get(speed, zero)
            size = size + (slope * symbol(graph, u.derivative)).apply(ABS)
        rod = formed.topology.contacts[name]
        length = formed.names.expression(next(iter(rod.formula_sites())).formula, f"constraint {name}")
        slack, rate, acceleration = _slackness(formed, row)
        made += [slack, rate, length, -_multiplier(modal, row.name), acceleration, size + rate**2 / length]
    names = [f"{word} {name}" for name in (*joints, *lines) for word in MEASURES]
    return dict(zip(names, made, strict=True))


def _slackness(formed: EquationsOfMotion, row: ConstraintEquation) -> tuple[Expr, Expr, Expr]:
    """Return the negative value of a row, with its first and second rate."""
    graph, zero = formed.graph, number(formed.graph, 0)
    rate, acceleration = -row.drift, row.gamma
    for node, slope in row.jacobian.items():
        rate = rate - slope * Expr(graph, node)
    for u, speed in zip(formed.u, formed.kinematics.speeds, strict=True):
        acceleration = acceleration - row.jacobian.get(speed, zero) * symbol(graph, u.derivative)
    return -row.value, rate, acceleration


def _friction_words(modal: EquationsOfMotion, joints: tuple[str, ...]) -> dict[str, Expr]:
    """Return the outputs about friction with what holds joints that stick."""
    if not joints:
        return {}
    made: dict[str, Expr] = {}
    for law, normal in zip(modal.friction, resistance(modal).normals, strict=True):
        if law.joint.name in joints:
            effort = law.effort + _multiplier(modal, law.holding_effort)
            made[f"friction {law.joint.name}"] = effort
            made[f"friction_reserve {law.joint.name}"] = law.limit * normal - effort.apply(ABS)
    return made


def _multiplier(formed: EquationsOfMotion, name: str) -> Expr:
    return symbol(formed.graph, Symbol(name, SymbolKind.MULTIPLIER))
