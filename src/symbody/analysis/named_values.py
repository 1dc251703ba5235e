"""Values that a user gives by name: ``{"theta": "30 deg", "s": "2*L"}``."""

from __future__ import annotations

from collections.abc import Mapping

from symbody.codegen.compile import Value, constant_values
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, UsageError, nearest
from symbody.expr.parser import parse_angle


def checked_mappings(**given: object) -> None:
    """Refuse what is no mapping of names.

    Raises
    ------
    UsageError
        Naming each argument.
    """
    problems = [
        Problem("assembly.not_a_mapping", name, f"{value!r} is no mapping of names to values", "",
                f'write {name}={{"NAME": VALUE}}')
        for name, value in given.items() if value is not None and not isinstance(value, Mapping)
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def checked_pairs(ranges: Mapping[str, tuple[Value, Value]]) -> None:
    """Refuse ranges that are no pairs.

    Raises
    ------
    UsageError
        Naming each.
    """
    problems = [
        Problem("assembly.not_a_range", f"ranges {name}", f"{pair!r} is no range", "",
                f'write ranges={{"{name}": (LOWER, UPPER)}}')
        for name, pair in ranges.items() if not isinstance(pair, tuple | list) or len(pair) != 2
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def named_values(
    eqs: EquationSet,
    formulas: Mapping[str, Value],
    parameters: Mapping[str, Value] | None,
    strict: set[str],
) -> dict[str, float]:
    """Return the values of named formulas; names that mean nothing are refused where the user gave them.

    Angles may be texts such as ``"30 deg"``, as in a model file.

    Raises
    ------
    AssemblyError
        Naming each unknown name, with the nearest ones.
    """
    names = eqs.formed.readable_names
    known = {*names.symbols, *names.values}
    problems = [
        Problem("assembly.unknown_name", name, f"there is no coordinate or speed {name!r}", "",
                nearest(name, (*eqs.coordinate_names, *eqs.speed_names)))
        for name in formulas if name in strict and name not in known
    ]  # fmt: skip
    if problems:
        raise AssemblyError(*problems)
    joints = (*eqs.model.joints, *eqs.model.free_joints)
    angles = {name for joint in joints for name in joint.angle_coordinates}
    read = {
        name: parse_angle(value, where=name) if name in angles and isinstance(value, str) else value
        for name, value in formulas.items()
        if name in known
    }
    return constant_values(eqs, read, parameters)
