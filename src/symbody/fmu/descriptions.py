"""`modelDescription.xml` of both standards with units of base units, and `buildDescription.xml`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final
from xml.etree import ElementTree as xml

import symbody
from symbody.equations.outputs.dimensions import read_unit
from symbody.fmu.variables import FmuVariable

CATEGORIES: Final = {
    "logStatusError": "what went wrong, and what to do", "logEvents": "events as they happen",
}  # fmt: skip
Attributes = dict[str, str]


@dataclass(frozen=True, slots=True)
class Described:
    """What a description says of an FMU.

    Attributes
    ----------
    name, description : str
        Of the model.
    identifier : str
        Beginning of file names.
    token : str
        What an importer hands back at instantiation.
    variables : tuple of FmuVariable
        In the order of their value references.
    event_count : int
        How many of the last variables are event indicators.
    stop : float
        End of the default experiment [s].
    tolerance : float
        Of the default experiment.
    has_derivatives : bool
        Whether directional derivatives are there.
    """

    name: str
    description: str
    identifier: str
    token: str
    variables: tuple[FmuVariable, ...]
    event_count: int
    stop: float
    tolerance: float
    has_derivatives: bool

    @property
    def scalar_variables(self) -> tuple[FmuVariable, ...]:
        """The variables without event indicators."""
        return self.variables[: len(self.variables) - self.event_count]

    @property
    def initial_unknowns(self) -> list[int]:
        """Value references of what follows at the end of initialization."""
        return [
            k for k, variable in enumerate(self.variables)
            if variable.initial == "calculated"
        ]  # fmt: skip


def description_3(model: Described) -> bytes:
    """Return modelDescription.xml of FMI 3.0."""
    root = xml.Element("fmiModelDescription", {
        "fmiVersion": "3.0", "modelName": model.name, "instantiationToken": model.token,
        "description": model.description, "generationTool": f"symbody {symbody.__version__}",
        "variableNamingConvention": "structured",
    })  # fmt: skip
    common = {
        "modelIdentifier": model.identifier,
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    common |= {"providesDirectionalDerivatives": _word(model.has_derivatives)}
    xml.SubElement(root, "ModelExchange", common | {"needsCompletedIntegratorStep": "true"})
    xml.SubElement(root, "CoSimulation", common | {
        "canHandleVariableCommunicationStepSize": "true", "hasEventMode": "false",
        "canReturnEarlyAfterIntermediateUpdate": "false", "providesIntermediateUpdate": "false",
    })  # fmt: skip
    _units(root, model)
    _categories(root, "name")
    _experiment(root, model)
    variables = xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.variables):
        attributes = _head(variable, reference) | _real(variable)
        if variable.derivative is not None:
            attributes["derivative"] = str(variable.derivative)
        xml.SubElement(variables, "Float64", attributes)
    _structure_3(root, model)
    return _document(root)


def _structure_3(root: xml.Element, model: Described) -> None:
    structure = xml.SubElement(root, "ModelStructure")
    kinds = [
        ("Output", [k for k, v in enumerate(model.variables) if v.causality == "output"]),
        ("ContinuousStateDerivative", [k for k, v in enumerate(model.variables) if v.derivative is not None]),
    ]
    for word, references in kinds:
        for k in references:
            xml.SubElement(structure, word, {"valueReference": str(k)} | _dependencies(model.variables[k], 0))
    for k in model.initial_unknowns:
        xml.SubElement(structure, "InitialUnknown", {"valueReference": str(k)})
    for k in range(len(model.scalar_variables), len(model.variables)):
        attributes = {"valueReference": str(k)} | _dependencies(model.variables[k], 0)
        xml.SubElement(structure, "EventIndicator", attributes)


def description_2(model: Described, sources: Iterable[str]) -> bytes:
    """Return modelDescription.xml of FMI 2.0; `sources` are the files to compile."""
    root = xml.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": model.name, "guid": model.token, "description": model.description,
        "generationTool": f"symbody {symbody.__version__}", "variableNamingConvention": "structured",
        "numberOfEventIndicators": str(model.event_count),
    })  # fmt: skip
    common = {
        "modelIdentifier": model.identifier,
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    common |= {"providesDirectionalDerivative": _word(model.has_derivatives)}
    files = tuple(sources)
    for word, further in (
        ("ModelExchange", {"completedIntegratorStepNotNeeded": "false"}),
        ("CoSimulation", {"canHandleVariableCommunicationStepSize": "true", "canInterpolateInputs": "false"}),
    ):
        kind = xml.SubElement(root, word, common | further)
        if files:
            listed = xml.SubElement(kind, "SourceFiles")
            for file in files:
                xml.SubElement(listed, "File", {"name": file})
    _units(root, model)
    _categories(root, "name")
    _experiment(root, model)
    variables = xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.scalar_variables):
        entry = xml.SubElement(variables, "ScalarVariable", _head(variable, reference))
        attributes = _real(variable)
        if variable.derivative is not None:
            attributes["derivative"] = str(variable.derivative + 1)
        xml.SubElement(entry, "Real", attributes)
    _structure_2(root, model)
    return _document(root)


def _structure_2(root: xml.Element, model: Described) -> None:
    structure = xml.SubElement(root, "ModelStructure")
    kinds = [
        ("Outputs", [k for k, v in enumerate(model.scalar_variables) if v.causality == "output"]),
        ("Derivatives", [k for k, v in enumerate(model.scalar_variables) if v.derivative is not None]),
    ]
    for word, references in kinds:
        if references:
            group = xml.SubElement(structure, word)
            for k in references:
                xml.SubElement(group, "Unknown", {"index": str(k + 1)} | _dependencies(model.variables[k], 1))
    if model.initial_unknowns:
        group = xml.SubElement(structure, "InitialUnknowns")
        for k in model.initial_unknowns:
            xml.SubElement(group, "Unknown", {"index": str(k + 1)})


def build_description(identifier: str, file: str) -> bytes:
    """Return sources/buildDescription.xml of FMI 3.0."""
    root = xml.Element("fmiBuildDescription", {"fmiVersion": "3.0"})
    build = xml.SubElement(root, "BuildConfiguration", {"modelIdentifier": identifier})
    files = xml.SubElement(build, "SourceFileSet", {"language": "C99"})
    xml.SubElement(files, "SourceFile", {"name": file})
    return _document(root)


def _head(variable: FmuVariable, reference: int) -> Attributes:
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
    }
    attributes |= {"causality": variable.causality, "variability": variable.variability}
    if variable.initial:
        attributes["initial"] = variable.initial
    return attributes


def _real(variable: FmuVariable) -> Attributes:
    attributes = {}
    if variable.unit in known_units([variable.unit]):
        attributes["unit"] = variable.unit
        if variable.unit in DISPLAYED:
            attributes["displayUnit"] = DISPLAYED[variable.unit]
    if variable.nominal is not None:
        attributes["nominal"] = repr(variable.nominal)
    if variable.start is not None:
        attributes["start"] = repr(variable.start)
    return attributes


def _dependencies(variable: FmuVariable, shift: int) -> Attributes:
    if variable.dependencies is None:
        return {}
    references = " ".join(str(reference + shift) for reference, _ in variable.dependencies)
    return {
        "dependencies": references,
        "dependenciesKind": " ".join(kind for _, kind in variable.dependencies),
    }


def _units(root: xml.Element, model: Described) -> None:
    powers = known_units(variable.unit for variable in model.variables)
    if not powers:
        return
    group = xml.SubElement(root, "UnitDefinitions")
    for unit, exponents in powers.items():
        entry = xml.SubElement(group, "Unit", {"name": unit})
        xml.SubElement(entry, "BaseUnit", {name: str(power) for name, power in exponents.items()})
        if unit in DISPLAYED:
            xml.SubElement(entry, "DisplayUnit", {"name": DISPLAYED[unit], "factor": repr(DEGREES)})


def _categories(root: xml.Element, word: str) -> None:
    group = xml.SubElement(root, "LogCategories")
    for name, text in CATEGORIES.items():
        xml.SubElement(group, "Category", {word: name, "description": text})


def _experiment(root: xml.Element, model: Described) -> None:
    attributes = {"startTime": "0.0", "stopTime": repr(model.stop), "tolerance": repr(model.tolerance)}
    xml.SubElement(root, "DefaultExperiment", attributes)


def _word(value: bool) -> str:
    return "true" if value else "false"


def _document(root: xml.Element) -> bytes:
    xml.indent(root)
    text: bytes = xml.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def interface_of(variables: Sequence[FmuVariable]) -> str:
    """Return a text that is the same for the same interface."""
    return "\n".join(repr(variable) for variable in variables)


DEGREES: Final = 180.0 / math.pi
# Shown in degrees; the values stay in radians.
DISPLAYED: Final[Mapping[str, str]] = {"rad": "deg", "rad/s": "deg/s"}


def unit_exponents(unit: str) -> Mapping[str, int] | None:
    """Return the exponents of kg, m, s, rad in a unit; None where it is not a product of whole powers.

    >>> dict(unit_exponents("N m"))
    {'kg': 1, 'm': 2, 's': -2}
    """
    dimension = read_unit(unit)
    if dimension is None:
        return None
    if dimension.kg or dimension.m:  # radians count in pure angles and their rates only
        dimension = dimension.without_angle
    powers = {"kg": dimension.kg, "m": dimension.m, "s": dimension.s, "rad": dimension.rad}
    if any(power.denominator != 1 for power in powers.values()):
        return None
    return {name: int(power) for name, power in powers.items() if power}


def known_units(units: Iterable[str]) -> dict[str, Mapping[str, int]]:
    """Return the exponents of each unit that has them, in the order of the names."""
    made = {unit: unit_exponents(unit) for unit in sorted(set(units)) if unit}
    return {unit: powers for unit, powers in made.items() if powers is not None}
