"""SI units of outputs by name, and of parameters by the places where they stand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.dimensions import expression_unit
from symbody.expr.language.formula import Formula
from symbody.expr.language.literals import fold
from symbody.model.constraints import Gear, Stop
from symbody.model.joint import Joint
from symbody.model.loads.gap_laws import GapLaw
from symbody.model.model import Model
from symbody.model.output_names import FRAME_OUTPUT, MOTION_UNITS, kind_of, list_outputs, parse_derivative

_TRANSLATION: Final = ("m", "m/s", "m/s^2")
_ROTATION: Final = ("rad", "rad/s", "rad/s^2")
# What acts along a speed, by the unit of that.
_EFFORTS: Final[Mapping[str, str]] = {"m/s": "N", "rad/s": "N m"}
_GRAVITY: Final = "gravity_forcing"


@dataclass(frozen=True, slots=True, eq=False)
class Units(Mapping[str, str]):
    """Units of known names and, though no list of them ends, of motions of frames and of expressions.

    Attributes
    ----------
    known : mapping of name to str
        What is listed.
    """

    known: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        """Return the unit of an output or an expression, ``""`` of a number; KeyError if it is not known."""
        if name in self.known:
            return self.known[name]
        kind = kind_of(name)
        if kind is not None and kind.word == FRAME_OUTPUT:
            unit: str | None = MOTION_UNITS.get(name.split(maxsplit=2)[1]) or None
        else:
            is_name = kind is not None or name.isidentifier() or parse_derivative(name) is not None
            unit = None if is_name else expression_unit(name, self.get)
        if unit is None:
            raise KeyError(name)
        return unit

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the names that are listed."""
        return iter(self.known)

    def __len__(self) -> int:
        """Return how many names are listed."""
        return len(self.known)

    def __repr__(self) -> str:
        return f"Units({dict(self.known)!r})"


def output_units(formed: EquationsOfMotion) -> Units:
    """Return the units of coordinates, rates, parameters, multipliers, and of outputs that are numbers."""
    scope = formed.topology.output_scope
    units = symbol_units(formed.topology.model) | {"t": "s", "work": "J"}
    for asked in list_outputs(scope):
        if asked.kind.word != FRAME_OUTPUT and asked.is_number and (unit := asked.unit(scope)):
            units[asked.text(scope)] = unit
    for name in formed.angles:
        units |= dict(zip((name, f"{name}_dot", f"{name}_ddot"), _ROTATION, strict=True))
    for joint in formed.topology.joints:
        units |= _joint_units(joint)
    for speed in formed.u:
        if units.get(speed.label) in _EFFORTS:
            units[f"{_GRAVITY} {speed.name}"] = _EFFORTS[units[speed.label]]
    own = {part.name: part.multiplier_unit for part in formed.topology.model.constraints}
    rows = (*formed.rows, *formed.coupled.rows)
    units |= {row.name: own[row.element] for row in rows if own.get(row.element)}
    listed = Units(units)
    units |= _stop_units(formed.topology.model, listed)
    outputs = {signal.name: signal.output for signal in formed.topology.model.signals if signal.output}
    of_signals = {name: listed.get(output, "") for name, output in outputs.items()}
    return Units(units | {name: unit for name, unit in of_signals.items() if unit})


def _stop_units(model: Model, listed: Units) -> dict[str, str]:
    """Return the units of the gaps of stops and of what opens them, where the gap has one."""
    units: dict[str, str] = {}
    for stop in model.constraints:
        unit = expression_unit(stop.gap.text, listed.get) if isinstance(stop, Stop) else None
        for kind in (_TRANSLATION, _ROTATION):
            if isinstance(stop, Stop) and unit == kind[0]:
                gap, force = f"gap {stop.name}", f"opening_effort {stop.name}"
                units |= {gap: unit, force: _EFFORTS[kind[1]], f"lambda_{stop.name}_1": _EFFORTS[kind[1]]}
                units |= {f"gap_dot {stop.name}": kind[1], f"gap_ddot {stop.name}": kind[2]}
    return units


def _joint_units(joint: Joint) -> dict[str, str]:
    units: dict[str, str] = {}
    turning = joint.rotation_coordinates if joint.quaternion is None else ()
    for names, of_kind in ((joint.translation_coordinates, _TRANSLATION), (turning, _ROTATION)):
        for name in names:
            units |= dict(zip((name, f"{name}_dot", f"{name}_ddot"), of_kind, strict=True))
    for speeds, (_, rate, second) in (
        (joint.translation_speeds, _TRANSLATION),
        (joint.rotation_speeds, _ROTATION),
    ):
        for name in speeds.names if speeds else ():
            units |= {name: rate, f"{name}_dot": second}
    return units


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
        yield from _sites_along(joint)
    for gear in (element for element in model.elements if isinstance(element, Gear)):
        if gear.backlash is not None:
            yield from _law_sites(gear.backlash, "backlash", turns=True)


def _sites_along(joint: Joint) -> Iterator[tuple[Formula, str]]:
    """Yield the formulas of drives, limits and motions along coordinates."""
    slides = set(joint.translation_coordinates)
    turns = set(joint.rotation_coordinates if joint.quaternion is None else ())
    for path, coordinate, drive in joint.drives_with_paths():
        if coordinate in slides | turns:
            for site in drive.formula_sites(path):
                yield site.formula, site.unit.split(", ")[coordinate not in slides]
    for path, coordinate, limits in joint.limits_with_paths():
        if coordinate in slides | turns:
            yield from _law_sites(limits, path, coordinate not in slides)
    for coordinate, motion in joint.motion.items():
        if coordinate in slides | turns:
            yield motion, "m" if coordinate in slides else "rad"


def _law_sites(law: GapLaw, path: str, turns: bool) -> Iterator[tuple[Formula, str]]:
    """Yield the formulas of limits or of a backlash with their units; a stiffness has one in a linear law."""
    is_linear = law.normal.exponent.constant() == 1 if not law.rigid else False
    for site in law.formula_sites(path):
        if "," in site.unit and (is_linear or not site.path.endswith("stiffness")):
            yield site.formula, site.unit.split(", ")[turns]
