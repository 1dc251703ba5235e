"""What `simulate`, `form_equations` and `plot` say to arguments of other kinds than they take."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

import symbody as sb

BODY = sb.Body("Block", mass=1)
MODEL = sb.Model("block", [BODY, sb.Prismatic("slider", "ground", BODY, coordinate="x")])
EQS = sb.form_equations(MODEL)

CASES: Mapping[str, tuple[Callable[[], object], str]] = {
    "equations.not_a_model": (lambda: sb.form_equations(_as_any("x.toml")), "load_model('x.toml')"),
    "simulation.not_equations": (lambda: sb.simulate(_as_any(MODEL), 1.0), "form_equations"),
    "simulation.not_a_time": (lambda: sb.simulate(EQS, _as_any("10")), "seconds"),
    "simulation.not_a_method": (lambda: sb.simulate(EQS, 1.0, integrator=_as_any("RK45")), "Explicit(..)"),
    "assembly.not_a_mapping": (lambda: sb.simulate(EQS, 1.0, initial=_as_any([0, 1])), "initial={"),
    "plot.not_a_motion": (lambda: sb.plot(_as_any(EQS), "x"), "simulate"),
}


def _as_any(value: object) -> Any:
    return value


@pytest.mark.parametrize("code", CASES)
def test_arguments_of_other_kinds_are_told_with_a_cure(code: str) -> None:
    asked, cure = CASES[code]
    with pytest.raises(sb.UsageError) as caught:
        asked()
    (problem,) = caught.value.problems
    assert problem.code == code and cure in problem.fix


def test_classes_in_place_of_methods_are_told() -> None:
    with pytest.raises(sb.UsageError) as caught:
        sb.simulate(EQS, 1.0, integrator=_as_any(sb.Stiff), constraints=_as_any("Baumgarte"))
    assert [problem.where for problem in caught.value.problems] == ["integrator", "constraints"]
