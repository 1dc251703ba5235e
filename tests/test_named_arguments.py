"""Public functions take their first arguments by place, and all others by name."""

from __future__ import annotations

import inspect

import pytest

import symbody as sb

KINDS = inspect.Parameter
# One more, as times say for when the motion is given.
LONGER = {"inverse_dynamics": 4}


def places(function: object) -> list[str]:
    signature = inspect.signature(function)  # type: ignore[arg-type]
    return [each.name for each in signature.parameters.values() if each.kind is KINDS.POSITIONAL_OR_KEYWORD]


@pytest.mark.parametrize("name", sorted(sb.__all__))
def test_at_most_three_arguments_are_given_by_place(name: str) -> None:
    public = getattr(sb, name)
    if inspect.isfunction(public) or public in (sb.Stepper, sb.LaneStepper):
        assert len(places(public)) <= LONGER.get(name, 3), places(public)


def oscillator() -> sb.EquationSet:
    rail = sb.Prismatic(
        "rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
        force=sb.Drive(applied="F", stiffness="k"),
    )  # fmt: skip
    return sb.form_equations(
        sb.Model("oscillator", [rail], parameters={"k": 8}, inputs=["F"], initial={"x": 0.1})
    )


def test_others_are_taken_by_place_with_a_warning_that_says_their_names() -> None:
    eqs = oscillator()
    with pytest.warns(DeprecationWarning, match="simulate: give guess=, parameters= by name") as told:
        run = sb.simulate(eqs, 1.0, {"x": 0.2}, {}, {"k": 18})
    assert told[0].filename == __file__
    expected = sb.simulate(eqs, 1.0, {"x": 0.2}, parameters={"k": 18})
    assert run["x"][-1] == expected["x"][-1]
    with pytest.warns(DeprecationWarning, match="Stepper: give initial= by name"):
        stepper = sb.Stepper(eqs, 0.1, {"k": 18}, {"x": 0.2})
    assert stepper["x"] == 0.2


def test_too_many_arguments_and_twice_the_same_are_faults() -> None:
    eqs = oscillator()
    with pytest.raises(sb.CallError, match="multiple values"), pytest.warns(DeprecationWarning):
        sb.simulate(eqs, 1.0, {}, {}, guess={})  # type: ignore[misc]
    with pytest.raises(sb.CallError, match="it takes"):
        sb.velocity_ratios(eqs, "x", None, {}, 1, 2)  # type: ignore[call-arg,arg-type]
