"""`modelDescription.xml` of both standards with units of base units, and `buildDescription.xml`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Final
from xml.etree import ElementTree as xml

import symbody
from symbody.equations.outputs.dimensions import read_unit
from symbody.fmu.binaries import Version
from symbody.fmu.program import SPAN, FmuProgram
from symbody.fmu.variables import FmuVariable

CATEGORIES: Final = {
    "logStatusError": "what went wrong, and what to do", "logEvents": "events as they happen",
}  # fmt: skip
# What each standard says of both kinds of use.
_KINDS: Final[Mapping[Version, Mapping[str, Mapping[str, str]]]] = {
    "2.0": {
        "ModelExchange": {"completedIntegratorStepNotNeeded": "false"},
        "CoSimulation": {"canHandleVariableCommunicationStepSize": "true", "canInterpolateInputs": "false"},
    },
    "3.0": {
        "ModelExchange": {"needsCompletedIntegratorStep": "true"},
        "CoSimulation": {
            "canHandleVariableCommunicationStepSize": "true", "hasEventMode": "false",
            "canReturnEarlyAfterIntermediateUpdate": "false", "providesIntermediateUpdate": "false",
        },
    },
}  # fmt: skip
DEGREES: Final = 180.0 / math.pi
# Shown in degrees; the values stay in radians.
DISPLAYED: Final[Mapping[str, str]] = {"rad": "deg", "rad/s": "deg/s"}
Attributes = dict[str, str]


def model_description(
    program: FmuProgram, variables: Sequence[FmuVariable], identifier: str, token: str, version: Version,
    sources: Sequence[str],
) -> bytes:  # fmt: skip
    """Return modelDescription.xml; FMI 2.0 lists in it the `sources` to compile."""
    is_2, name = version == "2.0", program.eqs.model.name
    root = xml.Element("fmiModelDescription", {
        "fmiVersion": version, "modelName": name, "guid" if is_2 else "instantiationToken": token,
        "description": f"multibody model {name}", "generationTool": f"symbody {symbody.__version__}",
        "variableNamingConvention": "structured",
        **({"numberOfEventIndicators": str(program.indicator_count)} if is_2 else {}),
    })  # fmt: skip
    state, plural = ("state", "") if is_2 else ("State", "s")
    common = {
        "modelIdentifier": identifier, f"canGetAndSetFMU{state}": "true", f"canSerializeFMU{state}": "true",
        f"providesDirectionalDerivative{plural}": "true" if "derivatives" in program.functions else "false",
    }  # fmt: skip
    for word, further in _KINDS[version].items():
        kind = xml.SubElement(root, word, {**common, **further})
        if is_2 and sources:
            listed = xml.SubElement(kind, "SourceFiles")
            for file in sources:
                xml.SubElement(listed, "File", {"name": file})
    _units(root, variables)
    group = xml.SubElement(root, "LogCategories")
    for category, text in CATEGORIES.items():
        xml.SubElement(group, "Category", {"name": category, "description": text})
    experiment = {
        "startTime": "0.0",
        "stopTime": repr(SPAN),
        "tolerance": repr(program.motion.integration.rtol),
    }
    xml.SubElement(root, "DefaultExperiment", experiment)
    scalars = variables[: len(variables) - program.indicator_count]
    group = xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(scalars if is_2 else variables):
        head, real = _head(variable, reference), _real(variable)
        if variable.derivative is not None:
            real["derivative"] = str(variable.derivative + is_2)
        if is_2:
            xml.SubElement(xml.SubElement(group, "ScalarVariable", head), "Real", real)
        else:
            xml.SubElement(group, "Float64", head | real)
    _structure(xml.SubElement(root, "ModelStructure"), variables, len(scalars), is_2=is_2)
    return _document(root)


def _structure(
    structure: xml.Element, variables: Sequence[FmuVariable], scalar_count: int, *, is_2: bool
) -> None:
    """Add outputs, rates, what follows at the end of initialization, and in FMI 3.0 event indicators."""
    outputs = [k for k, variable in enumerate(variables) if variable.causality == "output"]
    rates = [k for k, variable in enumerate(variables) if variable.derivative is not None]
    unknowns = [k for k, variable in enumerate(variables) if variable.initial == "calculated"]
    kinds = {"Output": outputs, "ContinuousStateDerivative": rates, "InitialUnknown": unknowns}
    if is_2:
        kinds = {"Outputs": outputs, "Derivatives": rates, "InitialUnknowns": unknowns}
    else:
        kinds["EventIndicator"] = list(range(scalar_count, len(variables)))
    for word, references in kinds.items():
        group = xml.SubElement(structure, word) if is_2 and references else structure
        for k in references:
            reference = {"index": str(k + 1)} if is_2 else {"valueReference": str(k)}
            depends = {} if references is unknowns else _dependencies(variables[k], int(is_2))
            xml.SubElement(group, "Unknown" if is_2 else word, reference | depends)


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


def _units(root: xml.Element, variables: Iterable[FmuVariable]) -> None:
    powers = known_units(variable.unit for variable in variables)
    if not powers:
        return
    group = xml.SubElement(root, "UnitDefinitions")
    for unit, exponents in powers.items():
        entry = xml.SubElement(group, "Unit", {"name": unit})
        xml.SubElement(entry, "BaseUnit", {name: str(power) for name, power in exponents.items()})
        if unit in DISPLAYED:
            xml.SubElement(entry, "DisplayUnit", {"name": DISPLAYED[unit], "factor": repr(DEGREES)})


def _document(root: xml.Element) -> bytes:
    xml.indent(root)
    text: bytes = xml.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


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
