"""Values that a user gives by name: ``{"theta": "30 deg", "s": "2*L"}``, of quaternions with unit norm."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from symbody.codegen.formation.names import Value
from symbody.codegen.formation.values import constant_values
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, UsageError, nearest
from symbody.expr.language.formula import Formula


def check_mappings(**given: object) -> None:
    """Refuse arguments that are not mappings of names.

    Raises
    ------
    UsageError
        Naming each argument.
    """
    problems = [
        Problem("assembly.not_a_mapping", name, f"{value!r} is not a mapping of names to values", "",
                f'write {name}={{"NAME": VALUE}}')
        for name, value in given.items() if value is not None and not isinstance(value, Mapping)
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def check_pairs(ranges: Mapping[str, tuple[Value, Value]]) -> None:
    """Refuse ranges that are not pairs.

    Raises
    ------
    UsageError
        Naming each.
    """
    problems = [
        Problem("assembly.not_a_range", f"ranges {name}", f"{pair!r} is not a range", "",
                f'write ranges={{"{name}": (LOWER, UPPER)}}')
        for name, pair in ranges.items() if not isinstance(pair, tuple | list) or len(pair) != 2
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)


def positions_and_rates(eqs: EquationSet) -> frozenset[str]:
    """Return the names of everything that has a value in a configuration or a motion from it.

    Coordinates of cut joints, their rates and their speeds are among them where they can be measured.
    """
    names: frozenset[str] = eqs.plans.get("names of states", lambda: _positions_and_rates(eqs))
    return names


def _positions_and_rates(eqs: EquationSet) -> frozenset[str]:
    formed, topology = eqs.formed, eqs.formed.topology
    names = formed.readable_names
    coordinates = {name for joint in topology.joints for name in joint.coordinates}
    coordinates.update(topology.model.coordinates, eqs.coordinate_names)
    speeds = {name for joint in topology.joints for name in joint.quasi_speed_names}
    all_names = coordinates | speeds | {f"{name}_dot" for name in coordinates} | {*eqs.speed_names}
    all_names |= {*eqs.signal_state_names}
    return frozenset(name for name in all_names if name in names.symbols or name in names.values)


def refuse_unknown(eqs: EquationSet, given: Iterable[str]) -> None:
    """Refuse names that are neither positions nor rates, saying where what they name is given.

    Raises
    ------
    AssemblyError
        Naming each.
    """
    names = positions_and_rates(eqs)
    problems = [_unknown(eqs, name) for name in dict.fromkeys(given) if name not in names]
    if problems:
        raise AssemblyError(*problems)


def _unknown(eqs: EquationSet, name: str) -> Problem:
    meaning, place = _describe_name(eqs, name)
    if meaning:
        what = f"{name!r} is {meaning}, not a coordinate or a speed"
        return Problem(
            "assembly.no_state", name, what, "a state consists of coordinates, their rates and speeds", place
        )
    cure = nearest(name, (*eqs.coordinate_names, *eqs.speed_names, *eqs.signal_state_names))
    return Problem("assembly.unknown_name", name, f"there is no coordinate or speed {name!r}", "", cure)


def _describe_name(eqs: EquationSet, name: str) -> tuple[str, str]:
    """Return the meaning of a name that is not a state, and the argument for it; empty without a meaning."""
    if name in eqs.parameter_names:
        return "a parameter", f"give it in parameters={{{name!r}: ...}}"
    if name in eqs.input_names:
        return "an input", f"give it in inputs={{{name!r}: ...}}"
    if name == "t":
        return "the time", "give it as t= or t_end=(t0, t_end)"
    if name in eqs.acceleration_names or (name.endswith("_ddot") and _is_known(eqs, name)):
        return "an acceleration", "it follows from positions, speeds and forces; give a force, or a motion"
    if name in eqs.multiplier_names:
        return "a multiplier", "it follows from positions, speeds and forces"
    return "", ""


def _is_known(eqs: EquationSet, name: str) -> bool:
    names = eqs.formed.readable_names
    return name in names.symbols or name in names.values


def angle_names(eqs: EquationSet) -> frozenset[str]:
    """Return the names of all coordinates that are angles."""

    def find_names() -> frozenset[str]:
        joints = (*eqs.model.joints, *eqs.model.free_joints)
        return frozenset(name for joint in joints for name in joint.angle_coordinates)

    names: frozenset[str] = eqs.plans.get("names of angles", find_names)
    return names


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
    if not formulas:
        return {}
    refuse_unknown(eqs, [name for name in formulas if name in strict])
    names = positions_and_rates(eqs)
    read = {name: read_value(eqs, name, value) for name, value in formulas.items() if name in names}
    return constant_values(eqs, read, parameters)


def read_value(eqs: EquationSet, name: str, value: Value, where: str = "") -> Value:
    """Return the value of a coordinate or rate, a text as a formula.

    Raises
    ------
    UsageError
        If it is in degrees, and the name is none of an angle.
    """
    if not isinstance(value, str):
        return value
    formula = Formula.from_value(value, where=where or name)
    if formula.is_in_degrees and name not in angle_names(eqs):
        raise UsageError(
            Problem("model.not_an_angle", where or name, f"{value} belongs to {name}, which is not an angle",
                    "deg is allowed for angles only",
                    f"write the value in SI units, for instance {value.replace(' deg', '*pi/180')} for a "
                    f"rate in degrees per second")
        )  # fmt: skip
    return formula


def unit_quaternions(
    quaternions: Sequence[Sequence[str]], fixed: Mapping[str, float], guess: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return fixed values and guesses with which every quaternion that has fixed components is a unit.

    Four fixed components are divided by their norm. Where fewer are fixed they stay, and the others are
    guessed so that the norm is 1.

    Raises
    ------
    AssemblyError
        If fixed components are all 0, or some of them exceed a unit.
    """
    values, guesses = dict(fixed), dict(guess)
    for names in quaternions:
        fixed_names = [name for name in names if name in fixed]
        square = sum(fixed[name] ** 2 for name in fixed_names)
        free = [name for name in names if name not in fixed]
        if not fixed_names:
            continue
        if not free:
            if square == 0.0:
                raise AssemblyError(_problem(fixed_names, "is zero", "its four components cannot all be 0"))
            values.update((name, fixed[name] / math.sqrt(square)) for name in fixed_names)
            continue
        if square > 1.0 + 1e-9:
            raise AssemblyError(
                _problem(
                    fixed_names, "is longer than 1", "no values of the other components give it unit norm"
                )
            )
        left = math.sqrt(max(1.0 - square, 0.0))
        norm = math.hypot(*(guess.get(name, 0.0) for name in free))
        for k, name in enumerate(free):
            share = guess.get(name, 0.0) / norm if norm > 0.0 else float(k == 0)
            guesses[name] = left * share
    return values, guesses


def _problem(names: Sequence[str], what: str, why: str) -> Problem:
    return Problem(
        "assembly.quaternion", ", ".join(names), f"the quaternion of {', '.join(names)} {what}", why,
        "give a unit quaternion, scalar first, or leave components out",
    )  # fmt: skip
