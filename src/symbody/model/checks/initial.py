"""Initial values: each of something that moves freely, and quaternions that are rotations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from symbody.errors import Problem, nearest
from symbody.expr.language.formula import Formula
from symbody.model.checks.symbols import Symbols
from symbody.model.joint import Joint
from symbody.model.numeric_checks import NumericChecks

_WORDS: Final = ("coordinate", "rate", "speed")
_NORM: Final = 1e-6


def initial_problems(
    initial: Mapping[str, Formula], symbols: Symbols, joints: Iterable[Joint]
) -> list[Problem]:
    """Return a problem for each initial value of what has none."""
    legal = [name for name, meaning in symbols.meanings.items() if meaning.word in _WORDS]
    prescribed = {
        f"{name}{suffix}": joint
        for joint in joints
        if not joint.as_constraint
        for name in joint.motion
        for suffix in ("", "_dot")
    }
    states = [name for name, meaning in symbols.meanings.items() if meaning.word == "signal"]
    problems = []
    for name in initial:
        if name in prescribed:
            problems.append(_prescribed_problem(name, prescribed[name]))
        elif name in states:
            problems.append(_signal_problem(name, symbols.meanings[name].where))
        elif name not in legal:
            problems.append(_unknown_problem(name, legal))
    return problems


def check_initial(check: NumericChecks, initial: Mapping[str, Formula], joints: Iterable[Joint]) -> None:
    """Check the values; four that form a quaternion must not all be zero."""
    values = {name: check.value(formula, f"model, initial.{name}") for name, formula in initial.items()}
    for joint in joints:
        names = joint.quaternion or ()
        numbers = [value for name in names if (value := values.get(name)) is not None]
        if len(numbers) == 4:
            _check_quaternion(check, joint.name, names, numbers)


def _check_quaternion(
    check: NumericChecks, joint: str, names: Sequence[str], values: Sequence[float]
) -> None:
    listed = ", ".join(names)
    norm = math.hypot(*values)
    if norm == 0:
        what = f"{listed} are all zero"
        why = "a quaternion of norm zero is not a rotation"
        fix = f"write 1 for {names[0]}, or leave all four out: no rotation"
        check.refuse("initial.zero_quaternion", f"model, initial.{names[0]}", what, why, fix)
    elif abs(norm - 1) > _NORM:
        check.note(f"joint {joint}: the initial quaternion {listed} of norm {norm:g} is normalized")


def _unknown_problem(name: str, known: Iterable[str]) -> Problem:
    what = f"there is no coordinate, rate or speed {name!r}"
    why = "initial values can be set for coordinates, their rates x_dot, and speeds"
    return Problem("initial.unknown", f"model, initial.{name}", what, why, nearest(name, known))


def _signal_problem(name: str, where: str) -> Problem:
    why = "the initial value of a signal with a rate is part of the signal"
    fix = f'write [[signal]] name = "{name}", rate = .., initial = ..'
    return Problem("signal.initial", f"model, initial.{name}", f"{name} is a signal ({where})", why, fix)


def _prescribed_problem(name: str, joint: Joint) -> Problem:
    what = f"the prescribed motion of joint {joint.name} determines {name}"
    why = "a prescribed coordinate is not an unknown and starts where its motion starts"
    fix = "remove the initial value or the motion"
    return Problem("initial.prescribed", f"model, initial.{name}", what, why, fix)
