"""The lengths of a model: what tolerances and starts of searches are measured by."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.model.constraint import ConstraintElement
from symbody.model.contacts.contact import Contact
from symbody.model.element import Element
from symbody.model.joint import Joint
from symbody.model.loads.curve import Curve, Law
from symbody.model.loads.forces import Bushing, SpringDamper
from symbody.model.model import Model

# Formulas of a constraint that are lengths, if its multiplier is a force.
_LENGTHS: Final = ("value", "radius", "radii", "offset")


def model_lengths(model: Model) -> Iterator[Formula]:
    """Yield the formulas of all lengths [m] that can be computed from parameters, at t = 0."""
    known = {*model.parameters, "t", "pi"}
    frames = [*model.ground.values(), *(frame for body in model.bodies for frame in body.frames.values())]
    yield from (x for frame in frames for x in frame.at)
    for element in model.elements:
        yield from (formula for formula in _own_lengths(element) if known.issuperset(formula.names))


def _own_lengths(element: Element) -> Iterator[Formula]:
    if isinstance(element, ConstraintElement) and element.multiplier_unit == "N":
        yield from (
            site.formula for site in element.formula_sites() if site.path.partition("[")[0] in _LENGTHS
        )
    elif isinstance(element, Joint):
        yield from element.constants.values()
        for drive in element.force.values():
            yield from _law_lengths(drive.free, drive.law)
        lengths = set(element.translation_coordinates) - set(element.rotation_coordinates)
        for name, limits in element.limits.items():
            yield from limits.ends if name in lengths else ()
    elif isinstance(element, SpringDamper):
        yield from _law_lengths(element.free, element.law)
    elif isinstance(element, Bushing):
        yield from element.free[:3]
    elif isinstance(element, Contact):
        yield from (size for shape in element.shapes for size in shape.sizes)


def _law_lengths(free: Formula, law: Law) -> Iterator[Formula]:
    yield free
    if isinstance(law, Curve):
        yield from law.x
