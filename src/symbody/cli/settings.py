"""What ``symbody simulate --set NAME=VALUE`` means: a parameter, an input, or a value at the start."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest
from symbody.simulation.inputs.tables import Table


@dataclass(frozen=True, slots=True)
class Settled:
    """Texts by name, each where `simulate` expects it."""

    parameters: Mapping[str, str]
    inputs: Mapping[str, str]
    initial: Mapping[str, str]

    @classmethod
    def resolve(
        cls,
        eqs: EquationSet,
        settings: Mapping[str, str],
        inputs: Mapping[str, str],
        initial: Mapping[str, str],
    ) -> Settled:
        """Sort `settings` by what their names are in the model; the others are taken as they come.

        Raises
        ------
        UsageError
            With every name that the model does not have.
        """
        starting = _initial_names(eqs)
        known = {*eqs.parameter_names, *eqs.input_names, *starting}
        problems = [_unknown(name, known) for name in settings if name not in known]
        if problems:
            raise UsageError(*problems)
        return cls(
            {name: text for name, text in settings.items() if name in eqs.parameter_names},
            {**_select(settings, eqs.input_names), **inputs},
            {**_select(settings, starting), **initial},
        )

    def laws(self) -> dict[str, str | Table]:
        """Return the inputs of a motion: formulas, and the tables that files hold.

        Raises
        ------
        ModelError
            If a file holds no such table.
        """
        return {name: read_law(text) for name, text in self.inputs.items()}


def _unknown(name: str, known: Iterable[str]) -> Problem:
    what = f"the model has no {name!r}"
    return Problem("cli.unknown_name", f"--set {name}", what, "", nearest(name, known))


def _select(settings: Mapping[str, str], names: Iterable[str]) -> dict[str, str]:
    return {name: settings[name] for name in names if name in settings}


def _initial_names(eqs: EquationSet) -> list[str]:
    """Return the names that may have a value at the start: coordinates of all joints, rates, speeds."""
    measured = [name for joint in eqs.model.joints for name in joint.coordinates]
    coordinates = [*eqs.coordinate_names, *measured]
    return list(dict.fromkeys([*coordinates, *(f"{name}_dot" for name in coordinates), *eqs.speed_names]))


def read_law(text: str) -> str | Table:
    """Return the law of an input: a formula, or the table that ``@road.csv`` or ``@road.csv[t,z]`` names.

    Raises
    ------
    ModelError
        If the file holds no such table.
    """
    if not text.startswith("@"):
        return text
    path, bracket, columns = text[1:].removesuffix("]").partition("[")
    if not bracket:
        return Table.from_file(path)
    names = [word.strip() for word in columns.split(",")]
    return Table.from_file(path, [int(word) if word.isdigit() else word for word in names])


def read_pairs(pairs: Iterable[str] | None, option: str) -> dict[str, str]:
    """Return ``NAME=VALUE`` texts as a mapping.

    Raises
    ------
    UsageError
        If one is not of that form.
    """
    result = {}
    for pair in pairs or ():
        name, equals, value = pair.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UsageError(
                Problem("cli.assignment", option, f"{pair!r} is not of the form NAME=VALUE", "",
                        f"type for instance {option} k=2.5")
            )  # fmt: skip
        result[name.strip()] = value.strip()
    return result
