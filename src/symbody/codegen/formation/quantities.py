"""Lengths, gravity, masses and moments of inertia of a model with values of its parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from collections.abc import Sequence as Items
from itertools import islice
from typing import Final, NamedTuple

from symbody.codegen.formation.formula_values import FormulaValues
from symbody.equations.equation_set import EquationSet
from symbody.model.body import Body
from symbody.model.inertia import is_possible_inertia
from symbody.model.joint import Joint
from symbody.model.lengths import model_lengths
from symbody.model.model import Model
from symbody.model.numeric_checks import DemandList
from symbody.model.signals.block import SignalBlock
from symbody.model.signals.signal import Signal

_THREE: Final = 3


class Quantities(NamedTuple):
    """Numbers of a model at t = 0 [m, m/s^2, kg, kg m^2].

    Attributes
    ----------
    lengths : list of float
        All lengths of the model.
    gravity : list of float
        Components of the acceleration of free fall.
    masses, moments : list of float
        One mass and three moments of inertia a body.
    """

    lengths: list[float]
    gravity: list[float]
    masses: list[float]
    moments: list[float]

    @property
    def are_plainly_possible(self) -> bool:
        """Whether no mass is negative, and moments of inertia without products are those of bodies."""
        if not all(map(math.isfinite, (*self.lengths, *self.masses, *self.moments))):
            return False
        triples = zip(*(islice(self.moments, k, None, _THREE) for k in range(_THREE)), strict=True)
        return all(mass >= 0.0 for mass in self.masses) and all(map(_is_possible, triples))


class QuantityPlan:
    """Computes the quantities of a model for values of its parameters.

    Attributes
    ----------
    judged : set of str
        Parameters that are read by what plain quantities do not show to be possible: axes, rotations, joints,
        products of inertia, arguments of blocks, and what has a domain, as a restitution.
    """

    def __init__(self, eqs: EquationSet) -> None:
        bodies = eqs.model.bodies
        moments = [moment for body in bodies for moment in body.inertia]
        groups = [[*model_lengths(eqs.model)], [*eqs.model.gravity], [body.mass for body in bodies], moments]
        self._formulas = FormulaValues(eqs, [formula for group in groups for formula in group], timed=True)
        self._sizes = [len(group) for group in groups]
        self.judged: Set[str] = frozenset(_names_to_judge(eqs.model))

    def quantities(self, values: Mapping[str, float]) -> Quantities:
        """Return the quantities with values of all parameters."""
        numbers = iter(self._formulas.numbers(values))
        lengths, gravity, masses, moments = (list(islice(numbers, size)) for size in self._sizes)
        return Quantities(lengths, gravity, masses, moments)


def quantity_plan(eqs: EquationSet) -> QuantityPlan:
    """Return what computes the quantities of the model of some equations."""
    plan: QuantityPlan = eqs.plans.get("quantities", lambda: QuantityPlan(eqs))
    return plan


def _names_to_judge(model: Model) -> Iterator[str]:
    """Yield the parameters of joints, signals, blocks and bodies with products, and of what has a domain."""
    found = DemandList()
    for element in model.elements:
        if isinstance(element, Joint | Signal | SignalBlock) or (
            isinstance(element, Body) and _is_special(element)
        ):
            for use in element.formula_sites():
                yield from use.formula.names
        elif not isinstance(element, Body):
            element.check_numbers(found, "")
    for demand in found.demands:
        yield from demand.formula.names


def _is_special(body: Body) -> bool:
    return (
        body.unphysical
        or any(product.constant() != 0 for product in body.products)
        or any(frame.rotate or frame.matrix is not None for frame in body.frames.values())
    )


def _is_possible(moments: Items[float]) -> bool:
    is_planar = min(moments) >= 0.0 and sum(map(bool, moments)) <= 1
    return is_planar or is_possible_inertia(moments, [0.0] * _THREE)
