"""What importers do with an FMU, by FMPy: instances by hand, whole simulations, mechanisms to export."""

from __future__ import annotations

import ctypes
import shutil
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import xmlschema
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.validation import validate_fmu

import symbody as sb

EXAMPLES = Path(__file__).parents[2] / "examples"
# Models of their own: a file of another name is a part of one.
NAMES = sorted(path.stem for path in EXAMPLES.glob("*/*.toml") if path.stem.startswith(path.parent.name))
KINDS = ("ModelExchange", "CoSimulation")
VERSIONS = ("2.0", "3.0")
CLASSES = {
    ("2.0", "ModelExchange"): FMU2Model,
    ("2.0", "CoSimulation"): FMU2Slave,
    ("3.0", "ModelExchange"): FMU3Model,
    ("3.0", "CoSimulation"): FMU3Slave,
}


SCHEMA_FOLDER = Path(fmpy.__file__).parent / "schema"
# What the schemas of the standards describe, by its place in an archive.
SCHEMAS = {
    "2.0": {"modelDescription.xml": "fmi2/fmi2ModelDescription.xsd"},
    "3.0": {
        "modelDescription.xml": "fmi3/fmi3ModelDescription.xsd",
        "sources/buildDescription.xml": "fmi3/fmi3BuildDescription.xsd",
    },
}


def check_archive(path: Path, version: str) -> None:
    """Check an archive by FMPy's validator, and its descriptions against the schemas of the standard."""
    assert validate_fmu(str(path)) == []
    with zipfile.ZipFile(path) as archive:
        described = [name for name in archive.namelist() if name.endswith(".xml")]
        assert sorted(described) == sorted(SCHEMAS[version])  # no terminals, no icons
        for name in described:
            schema = xmlschema.XMLSchema(str(SCHEMA_FOLDER / SCHEMAS[version][name]))
            schema.validate(archive.read(name).decode())


def pendulum() -> sb.EquationSet:
    rod = sb.Body("Rod", mass="m", inertia=(0, 0, "m*l^2/12"), frames={"pin": sb.Frame(at=("-l/2", 0, 0))})
    pin = sb.Revolute("pin", "ground", "Rod.pin", coordinate="theta", torque=sb.Drive(applied="T"))
    values = {"m": 2.0, "l": 1.5, "g": 9.81}
    return sb.form_equations(sb.Model("pendulum", [rod, pin], (0, "-g", 0), values, ["T"], {"theta": 0.3}))


class Instance:
    """An instance of an FMU with variables by name."""

    def __init__(self, path: Path, kind: str, folder: Path) -> None:
        described = fmpy.read_model_description(path)
        self.version = described.fmiVersion
        fmpy.extract(path, folder)
        interface = described.modelExchange if kind == "ModelExchange" else described.coSimulation
        self.references = {v.name: v.valueReference for v in described.modelVariables}
        self.fmu = CLASSES[self.version, kind](
            guid=described.guid, unzipDirectory=str(folder), modelIdentifier=interface.modelIdentifier,
            instanceName="test",
        )  # fmt: skip
        self.fmu.instantiate()

    def initialize(self, start: Mapping[str, float] | None = None, tolerance: float | None = None) -> None:
        if self.version == "2.0":
            self.fmu.setupExperiment(tolerance=tolerance, startTime=0.0)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=0.0)
        for name, value in (start or {}).items():
            self.set(name, value)
        self.fmu.exitInitializationMode()

    def set(self, name: str, value: float) -> None:
        setter = self.fmu.setReal if self.version == "2.0" else self.fmu.setFloat64
        setter([self.references[name]], [value])

    def get(self, *names: str) -> list[float]:
        getter = self.fmu.getReal if self.version == "2.0" else self.fmu.getFloat64
        return list(getter([self.references[name] for name in names]))

    def set_states(self, x: Sequence[float]) -> None:
        self.fmu.setContinuousStates((ctypes.c_double * len(x))(*x), len(x))

    def derivative(self, unknowns: Sequence[str], known: str) -> list[float]:
        return list(
            self.fmu.getDirectionalDerivative(
                [self.references[name] for name in unknowns], [self.references[known]], [1.0]
            )
        )

    def steps(self, times: Sequence[float]) -> None:
        for start, end in zip(times, times[1:], strict=False):
            self.fmu.doStep(start, end - start)


@contextmanager
def instance(path: Path, kind: str) -> Iterator[Instance]:
    folder = path.with_name(f"{path.stem}_{kind}_{len(list(path.parent.iterdir()))}")
    made = Instance(path, kind, folder)
    try:
        yield made
    finally:
        made.fmu.freeInstance()
        shutil.rmtree(folder, ignore_errors=True)


def simulate(path: Path, kind: str, end: float, names: Sequence[str], tolerance: float, **more: Any) -> Any:
    """Return the variables (n, 21) at times evenly over the motion."""
    result = fmpy.simulate_fmu(
        str(path), stop_time=end, output_interval=end / 20, relative_tolerance=tolerance, fmi_type=kind,
        output=list(names), record_events=False, **more,
    )  # fmt: skip
    return np.array([result[name] for name in names])


def states(run: sb.Trajectory) -> Any:
    return np.concatenate([run.u, run.q, run.s])
