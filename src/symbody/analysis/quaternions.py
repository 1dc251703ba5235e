"""Fixed values of quaternions: brought to unit norm, or refused."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from symbody.errors import AssemblyError, Problem


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
                _problem(fixed_names, "is longer than 1", "no values of the others give it unit norm")
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
