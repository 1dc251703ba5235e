"""Units of parameters and inputs, from the places of the model where they stand."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from symbody.expr.language.formula import Formula
from symbody.expr.language.literals import fold
from symbody.model.model import Model


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
    """Yield formulas with the unit of their role; along a coordinate it follows the kind of this."""
    yield from ((formula, "m/s^2") for formula in model.gravity)
    frames = (frame.formula_sites(name) for name, frame in model.ground.items())
    for sites in (*frames, *(element.formula_sites() for element in model.elements)):
        yield from ((site.formula, site.unit) for site in sites if site.unit and "," not in site.unit)
    for joint in model.joints:
        slides = set(joint.translation_coordinates)
        turns = set(joint.rotation_coordinates if joint.quaternion is None else ())
        for path, coordinate, drive in joint.drives_with_paths():
            if coordinate in slides | turns:
                for site in drive.formula_sites(path):
                    yield site.formula, site.unit.split(", ")[coordinate not in slides]
        for coordinate, motion in joint.motion.items():
            if coordinate in slides | turns:
                yield motion, "m" if coordinate in slides else "rad"
