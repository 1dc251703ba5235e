"""Units of parameters and inputs, from the places of the model where they stand."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Final

from symbody.expr.language.formula import Formula
from symbody.expr.language.literals import fold
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.loads.forces import Force, SpringDamper, Torque
from symbody.model.loads.springs import TorsionSpring
from symbody.model.model import Model

_LINEAR: Final = {"stiffness": "N/m", "damping": "N s/m", "free": "m", "applied": "N", "motion": "m"}
_ANGULAR: Final = {
    "stiffness": "N m/rad", "damping": "N m s/rad", "free": "rad", "applied": "N m", "motion": "rad",
}  # fmt: skip
_VECTOR: Final = re.compile(r"vector\[\d\]")
# Place in a body or on the ground -> unit.
_PLACES: Final = (
    (re.compile(r"mass"), "kg"),
    (re.compile(r"(inertia|products)\[\d\]"), "kg m^2"),
    (re.compile(r"frames\..*\.at\[\d\]"), "m"),
    (re.compile(r"frames\..*\.rotate\[\d+\]\[1\]"), "rad"),
)


def symbol_units(model: Model) -> dict[str, str]:
    """Return the units of those parameters and inputs whose places leave no doubt.

    A place gives its unit to the names that stand there alone, or added, doubled, halved: the length in
    ``-L/2``. Names whose places differ in their units are left out.
    """
    symbols = {*model.parameters, *model.inputs}
    units: dict[str, set[str]] = {}
    for formula, unit in _sites(model):
        for name in linear_names(formula):
            if name in symbols:
                units.setdefault(name, set()).add(unit)
    return {name: next(iter(several)) for name, several in units.items() if len(several) == 1}


def linear_names(formula: Formula) -> frozenset[str]:
    """Return the names in a formula that have its unit, as far as that is plain to see."""
    stack: list[frozenset[str] | Fraction | None] = []
    for step in formula.program:
        if step.kind == "name":
            stack.append(frozenset({str(step.payload)}))
        elif step.kind == "number":
            stack.append(Fraction(step.payload))
        else:
            operands = stack[-step.arity :]
            del stack[-step.arity :]
            stack.append(_combine(str(step.payload), operands))
    return stack[0] if isinstance(stack[0], frozenset) else frozenset()


def _combine(name: str, operands: list[frozenset[str] | Fraction | None]) -> frozenset[str] | Fraction | None:
    numbers = [each for each in operands if isinstance(each, Fraction)]
    names = [each for each in operands if isinstance(each, frozenset)]
    if len(numbers) == len(operands):
        try:
            value = fold(name, *numbers)
        except (ArithmeticError, ValueError):  # in a branch that is never taken
            return None
        return None if value is None else Fraction(value)
    if len(numbers) + len(names) < len(operands):
        return None
    if name in ("add", "sub", "neg"):
        return frozenset().union(*names)
    is_scaled = name == "mul" or (name == "div" and isinstance(operands[1], Fraction))
    # Greater numbers than those of textbooks may change the unit.
    is_plain = len(numbers) == 1 and abs(numbers[0].numerator) <= 4 and numbers[0].denominator <= 4
    return names[0] if is_scaled and is_plain else None


def _sites(model: Model) -> Iterator[tuple[Formula, str]]:
    """Yield formulas with the unit of their place."""
    yield from ((formula, "m/s^2") for formula in model.gravity)
    yield from _frame_sites(model.ground.items())
    for body in model.bodies:
        yield from _match((site.path, site.formula) for site in body.formula_sites())
    for joint in model.joints:
        yield from _joint_sites(joint)
    for element in model.elements:
        if isinstance(element, Force | Torque):
            unit = "N" if isinstance(element, Force) else "N m"
            yield from (
                (site.formula, unit) for site in element.formula_sites() if _VECTOR.fullmatch(site.path)
            )
        elif isinstance(element, SpringDamper | TorsionSpring):
            units = _LINEAR if isinstance(element, SpringDamper) else _ANGULAR
            yield from (
                (site.formula, units[site.path]) for site in element.formula_sites() if site.path in units
            )


def _frame_sites(frames: Iterable[tuple[str, Frame]]) -> Iterator[tuple[Formula, str]]:
    for name, frame in frames:
        yield from _match((site.path, site.formula) for site in frame.formula_sites(f"frames.{name}"))


def _match(sites: Iterable[tuple[str, Formula]]) -> Iterator[tuple[Formula, str]]:
    for path, formula in sites:
        for place, unit in _PLACES:
            if place.fullmatch(path):
                yield formula, unit


def _joint_sites(joint: Joint) -> Iterator[tuple[Formula, str]]:
    """Yield the formulas of drives and prescribed motions."""
    slides = set(joint.translation_coordinates)
    turns = set(joint.rotation_coordinates if joint.quaternion is None else ())
    for path, coordinate, drive in joint.drives_with_paths():
        units = _LINEAR if coordinate in slides else _ANGULAR if coordinate in turns else {}
        for site in drive.formula_sites(path):
            word = site.path.removeprefix(f"{path}.")
            if word in units:
                yield site.formula, units[word]
    for coordinate, motion in joint.motion.items():
        if coordinate in slides | turns:
            yield motion, (_LINEAR if coordinate in slides else _ANGULAR)["motion"]
