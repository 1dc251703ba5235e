"""Equations in which coordinates are driven: each by one more constraint ``coordinate - law(t) = 0``.

So driven motions need no code of their own: their rates and accelerations are those of constraints that
depend on time (Haug 1989, section 3.6; Nikravesh 1988, section 5.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.errors import ExpressionError, Problem, SymbodyError, UsageError, nearest
from symbody.expr.expression import Expr, number
from symbody.expr.graph import SymbolKind
from symbody.expr.language.formula import Formula
from symbody.expr.rewrite import dependence
from symbody.model.declarations.arguments import plain_value

# No element of a model can have this name, which distinguishes rows from the mechanism's own.
DRIVEN: Final = "held "


def drive_coordinates(eqs: EquationSet, laws: Mapping[str, Value | None]) -> EquationSet:
    """Return equations with one more row a coordinate, after those on positions, in the order of `laws`.

    Parameters
    ----------
    laws : mapping of coordinate to formula in t and parameters, or None
        None leaves the law to the caller: the row's value is the coordinate, its rate the coordinate's.
        Coordinates of cut joints are legal, too.

    Raises
    ------
    UsageError
        Naming all that are not coordinates, are prescribed by the model, or have a law in more than t.
    """
    problems: list[Problem] = []
    rows = []
    for name, law in laws.items():
        fault = _not_free(eqs, name)
        if fault is None:
            try:
                rows.append(_row(eqs, name, law))
                continue
            except SymbodyError as error:
                problems.extend(error.problems)
        else:
            problems.append(fault)
    if problems:
        raise UsageError(*problems)
    formed = eqs.formed
    positions = [row for row in formed.rows if row.is_holonomic]
    speeds = [row for row in formed.rows if not row.is_holonomic]
    return EquationSet(eqs.model, formed.with_rows((*positions, *rows, *speeds)), eqs.notes)


def free_coordinates(eqs: EquationSet) -> tuple[str, ...]:
    """Return the names of all coordinates that may be driven: those in q, and those of cut joints."""
    formed = eqs.formed
    measured = (name for role in formed.joint_roles for name in role.joint.coordinates)
    names = dict.fromkeys((*eqs.coordinate_names, *measured))
    driven = {name for role in formed.joint_roles for name in role.prescribed_coordinates}
    return tuple(
        name for name in names if name not in driven and formed.readable_names.node(name) is not None
    )


def joint_of(eqs: EquationSet, name: str) -> str:
    """Return the joint that a coordinate or a speed belongs to; the coordinate itself of frames by hand."""
    for role in eqs.formed.joint_roles:
        labels = {symbol.label for symbol in role.speeds}
        labels.update(f"{coordinate}_dot" for coordinate in role.joint.coordinates)
        if name in labels or name in role.joint.coordinates:
            return role.joint.name
    return name.removesuffix("_dot")


def element_of(eqs: EquationSet, name: str) -> str:
    """Return `joint_of` with its kind: "joint A", or "coordinate s"."""
    joint = joint_of(eqs, name)
    return f"{'joint' if eqs.formed.joint_roles else 'coordinate'} {joint}"


def _not_free(eqs: EquationSet, name: str) -> Problem | None:
    """Return why a name cannot be driven, or None."""
    free = free_coordinates(eqs)
    if name in free:
        return None
    if any(name in role.prescribed_coordinates for role in eqs.formed.joint_roles):
        return Problem(
            "kinematics.prescribed", f"motion {name}", f"the model already prescribes {name}",
            f"{element_of(eqs, name)} already has a prescribed motion",
            "leave it out here, or remove the motion from the model",
        )  # fmt: skip
    if name in eqs.speed_names or name.endswith("_dot"):
        return Problem(
            "kinematics.speed_held", f"motion {name}", f"{name} is a speed, but only coordinates can be "
                f"driven",
            "positions do not follow from speeds without integration",
            "give the coordinate as a function of time, or sb.simulate with an input",
        )  # fmt: skip
    return Problem(
        "kinematics.unknown_coordinate", f"motion {name}",
        f"the equations have no coordinate {name!r} to drive", "", nearest(name, free),
    )  # fmt: skip


def _row(eqs: EquationSet, name: str, law: Value | None) -> ConstraintEquation:
    """Return the row that drives a coordinate.

    Raises
    ------
    ExpressionError
        If the law depends on anything but time and parameters.
    """
    formed, kinematics = eqs.formed, eqs.formed.kinematics
    names = formed.readable_names
    target = number(formed.graph, 0) if law is None else _target(eqs, name, law)
    measured = names.values.get(f"{name}_dot")
    value = names.value(name)
    rate = kinematics.rate(value) if measured is None else measured
    rate = rate - kinematics.rate(target)
    return ConstraintEquation(
        DRIVEN + name,
        DRIVEN + name,
        value - target,
        kinematics.speed_partials(rate),
        kinematics.at_zero_speeds(rate),
        -kinematics.bias(rate),
    )


def _target(eqs: EquationSet, name: str, law: Value) -> Expr:
    where = f"motion {name}"
    target = eqs.formed.names.expression(Formula.from_value(plain_value(law), where=where), where)
    kinds = dependence(eqs.formed.graph, [target.index])[target.index]
    if not kinds <= {SymbolKind.TIME, SymbolKind.PARAMETER}:
        raise ExpressionError(
            Problem("kinematics.motion_law", where, f"{law} depends on more than time and parameters",
                    "a prescribed motion must be known before the mechanism moves",
                    "write it as a formula in t and parameters")
        )  # fmt: skip
    return target
