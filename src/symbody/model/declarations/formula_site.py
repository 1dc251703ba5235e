"""Where formulas stand in a model, and which names each place allows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import StrEnum
from typing import NamedTuple

from symbody.expr.language.formula import Formula

Triple = tuple[Formula, Formula, Formula]


class Scope(StrEnum):
    """The names a formula may contain; the value says it in words."""

    CONSTANT = "parameters"
    PRESCRIBED = "parameters and t"
    LOAD = "parameters, inputs, t, coordinates, their rates, speeds, and signals"
    MOTION = "parameters, t, coordinates, their rates, and speeds"
    ARGUMENT = "parameters, t, coordinates, rates of these, and speeds"
    POINT = "x, y, z of the point, parameters and t"
    SURFACE = "x and y of the point and parameters"
    COORDINATE = "the name of a joint's coordinate"


class FormulaSite(NamedTuple):
    """One formula of an element.

    Attributes
    ----------
    path : str
        Where in the element, in the words of the model file: ``"frames.tip.at[1]"``.
    local_names : tuple of str
        Names that mean something in this formula alone.
    unit : str
        Of its value, as its role has it: "" if that says none, several with commas.
    """

    path: str
    formula: Formula
    scope: Scope
    local_names: tuple[str, ...] = ()
    unit: str = ""


def component_sites(
    path: str, formulas: Iterable[Formula], scope: Scope, unit: str = ""
) -> Iterator[FormulaSite]:
    """Return the uses of the formulas of a list."""
    return (FormulaSite(f"{path}[{k}]", formula, scope, (), unit) for k, formula in enumerate(formulas))
