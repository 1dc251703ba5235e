"""`FmuUnit`: one instance of an FMU that takes its steps beside a motion; FMPy loads it."""

from __future__ import annotations

import importlib
import math
import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Final

from symbody.errors import Problem, SimulationError, UsageError, nearest
from symbody.simulation.inputs.fmu_input import FmuInput

# Statuses of calls beyond which an instance must not be ended in the usual way.
_ERROR: Final = 3
_FATAL: Final = 4
_REALS: Final = frozenset({"Real", "Float64"})


@contextmanager
def open_unit(inputs: Mapping[str, FmuInput], start: float, values: Sequence[float]) -> Iterator[FmuUnit]:
    """Give an instance of an FMU that is initialized; it ends with the block, whatever happens there.

    Parameters
    ----------
    inputs : mapping of str to FmuInput
        Inputs by one instance, which differ in their outputs alone.
    start : float
        The time [s].
    values : sequence of float
        Of what it reads, at the start.

    Raises
    ------
    UsageError
        If FMPy or variables are missing, or the file is not an FMU for co-simulation on this machine.
    SimulationError
        If the FMU does not initialize.
    """
    where = ", ".join(f"input {name}" for name in inputs)
    law = next(iter(inputs.values()))
    fmpy = _fmpy(where)
    description = _read_description(fmpy, law, where)
    outputs = [each.output for each in inputs.values()]
    places = variable_places(description, law, outputs, where)
    is_third = description.fmiVersion.startswith("3.")
    with tempfile.TemporaryDirectory(prefix="symbody-fmu-", ignore_cleanup_errors=True) as folder:
        fmu = _load(fmpy, description, law, folder, where)
        keeps = bool(description.coSimulation.canSerializeFMUstate)
        unit = FmuUnit(fmu, law, where, places, is_third=is_third, keeps_states=keeps)
        try:
            unit.begin(start, values)
            yield unit
        finally:
            unit.end()


class FmuUnit:
    """An instance of an FMU.

    Parameters
    ----------
    fmu : object
        FMPy's, not yet instantiated.
    places : mapping of str to int
        Value references of all variables that are set or read.
    is_third : bool
        Whether it is of FMI 3.0.
    keeps_states : bool
        Whether its states can be saved.
    """

    def __init__(
        self, fmu: Any, law: FmuInput, where: str, places: Mapping[str, int], *, is_third: bool,
        keeps_states: bool,
    ) -> None:  # fmt: skip
        self._keeps_states = keeps_states
        self._fmu = fmu
        self._law = law
        self._where = where
        self._places = places
        self._reads = [places[name] for name in law.reads]
        self._parameters = [places[name] for name in law.parameters]
        self._time = 0.0
        self._is_alive = False
        self._worst = 0
        self._is_third = is_third
        self._set = fmu.setFloat64 if is_third else fmu.setReal
        self._get = fmu.getFloat64 if is_third else fmu.getReal

    def begin(self, start: float, values: Sequence[float]) -> None:
        """Instantiate and initialize at a time.

        Raises
        ------
        SimulationError
            If the FMU refuses.
        """
        self._time = start
        with self._refusals("initialize"):
            self._fmu.instantiate(loggingOn=False)
            self._is_alive = True
            if self._parameters:
                self._set(self._parameters, [float(value) for value in self._law.parameters.values()])
            if self._is_third:
                self._fmu.enterInitializationMode(startTime=start)
            else:
                self._fmu.setupExperiment(startTime=start)
                self._fmu.enterInitializationMode()
            self._give(values)
            self._fmu.exitInitializationMode()

    def step(self, values: Sequence[float], t: float, duration: float) -> None:
        """Take one step with values that are held during it.

        Raises
        ------
        SimulationError
            If the FMU refuses.
        """
        self._time = t
        with self._refusals("take its step"):
            self._give(values)
            self._fmu.doStep(t, duration)

    def output(self, name: str) -> float:
        """Return a variable at present.

        Raises
        ------
        SimulationError
            If the FMU refuses, or it is not a finite number.
        """
        with self._refusals(f"compute {name}"):
            value = float(self._get([self._places[name]])[0])
        if not math.isfinite(value):
            raise _failure(self._where, self._time, f"{name} of the FMU is {value}")
        return value

    def save(self) -> bytes:
        """Return the state of the instance.

        Raises
        ------
        UsageError
            If the FMU cannot save it.
        SimulationError
            If it refuses.
        """
        self._check_keeping()
        with self._refusals("save its state"):
            state = self._fmu.getFMUState()
            try:
                return bytes(self._fmu.serializeFMUState(state))
            finally:
                self._fmu.freeFMUState(state)

    def restore(self, saved: bytes) -> None:
        """Go on from a state that `save` returned, of this instance or of another.

        Raises
        ------
        UsageError, SimulationError
            As `save`.
        """
        self._check_keeping()
        with self._refusals("restore its state"):
            state = self._fmu.deserializeFMUState(saved)
            self._fmu.setFMUState(state)
            self._fmu.freeFMUState(state)

    def _check_keeping(self) -> None:
        if not self._keeps_states:
            raise UsageError(
                Problem("fmu_input.no_state", self._where, f"{self._law.path} cannot save its state",
                        "its description lacks canSerializeFMUState",
                        "restart the stepper with reset(), or export the FMU with states")
            )  # fmt: skip

    def end(self) -> None:
        """End the instance, as its status allows."""
        if not self._is_alive:
            return
        self._is_alive = False
        with self._silence():
            if self._worst < _ERROR:
                self._fmu.terminate()
        with self._silence():
            if self._worst < _FATAL:
                self._fmu.freeInstance()

    def _give(self, values: Sequence[float]) -> None:
        if self._reads:
            self._set(self._reads, list(values))

    @contextmanager
    def _refusals(self, purpose: str) -> Iterator[None]:
        try:
            yield
        except Exception as error:  # FMPy raises plain exceptions
            self._worst = max(self._worst, getattr(error, "status", _ERROR))
            raise _failure(self._where, self._time, f"the FMU did not {purpose}: {error}") from error

    @contextmanager
    def _silence(self) -> Iterator[None]:
        try:
            yield
        except Exception as error:  # noqa: BLE001  # the motion is over
            self._worst = max(self._worst, getattr(error, "status", _ERROR))


def _fmpy(where: str) -> Any:
    try:
        return importlib.import_module("fmpy")
    except ImportError as error:
        raise UsageError(
            Problem("fmu_input.no_fmpy", where, "the package FMPy, which runs FMUs, is not installed", "",
                    'pip install "symbody[fmu]"')
        ) from error  # fmt: skip


def _read_description(fmpy: Any, law: FmuInput, where: str) -> Any:
    """Return the description of an FMU that can be stepped on this machine."""
    try:
        with open(law.path, "rb") as file:  # FMPy leaves a file open that it refuses
            description = fmpy.read_model_description(file)
            platforms = fmpy.supported_platforms(file)
    except (OSError, zipfile.BadZipFile, KeyError) as error:
        raise UsageError(
            Problem("fmu_input.file", where, f"{law.path} cannot be read as an FMU: {error}", "",
                    "give the path of a file that ends in .fmu")
        ) from error  # fmt: skip
    except Exception as error:  # FMPy's own words for a description against the schema
        raise UsageError(
            Problem("fmu_input.description", where, f"{law.path} has no valid model description",
                    str(error).split("\n")[0], "export it again; `fmpy validate` lists the faults")
        ) from error  # fmt: skip
    if description.coSimulation is None or not description.fmiVersion.startswith(("2.", "3.")):
        kinds = "model exchange" if description.modelExchange is not None else "another kind"
        raise UsageError(
            Problem("fmu_input.kind", where,
                    f"{law.path} is an FMU of FMI {description.fmiVersion} for {kinds}",
                    "an FMU used as an input must take its own steps",
                    "export it for co-simulation, FMI 2.0 or 3.0")
        )  # fmt: skip
    if not {fmpy.platform, fmpy.platform_tuple} & {*platforms}:
        there = ", ".join(platforms) or "none"
        raise UsageError(
            Problem("fmu_input.platform", where, f"{law.path} has no library for {fmpy.platform_tuple}",
                    f"available: {there}",
                    "export it for this platform, or build its sources, if included, with `fmpy compile`")
        )  # fmt: skip
    return description


def variable_places(description: Any, law: FmuInput, outputs: Sequence[str], where: str) -> dict[str, int]:
    """Return the value references of what is read and set.

    Raises
    ------
    UsageError
        With every variable that is not there, or is not a real number.
    """
    variables = {variable.name: variable for variable in description.modelVariables}
    reals = {
        name for name, variable in variables.items() if variable.type in _REALS and not variable.dimensions
    }
    purposes = (("output", outputs), ("reads", [*law.reads]), ("parameters", [*law.parameters]))
    problems = []
    for purpose, names in purposes:
        usual = {"output": "output", "reads": "input", "parameters": "parameter"}[purpose]
        likely = sorted(name for name in reals if variables[name].causality == usual) or sorted(reals)
        for name in names:
            if name in reals:
                continue
            what = f"{name} is not a real number" if name in variables else f"no variable {name}"
            problems.append(
                Problem("fmu_input.variable", f"{where}, {purpose}", f"{what}", _hint(law, name, reals),
                        nearest(name, likely))
            )  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return {name: variables[name].valueReference for _, names in purposes for name in names}


def _hint(law: FmuInput, name: str, reals: set[str]) -> str:
    """Return what is wrong where names were given the wrong way round."""
    if law.reads.get(name) in reals:
        return "in reads=, the FMU's variable comes first: {VARIABLE: OUTPUT OF THE MECHANISM}"
    return f"it is not among the variables of {law.path}"


def _load(fmpy: Any, description: Any, law: FmuInput, folder: str, where: str) -> Any:
    """Return FMPy's object of an FMU whose library is loaded from a folder."""
    here = os.getcwd()
    try:
        fmpy.extract(law.path, folder)
        return _instance(description, folder)
    except Exception as error:  # what the archive or the library is missing
        raise UsageError(
            Problem("fmu_input.load", where, f"the library of {law.path} cannot be loaded", str(error),
                    "install what it needs, or export an FMU that needs nothing else")
        ) from error  # fmt: skip
    finally:
        os.chdir(here)  # FMPy stays in the folder of a library that does not load


def _instance(description: Any, folder: str) -> Any:
    is_third = description.fmiVersion.startswith("3.")
    module = importlib.import_module("fmpy.fmi3" if is_third else "fmpy.fmi2")
    kind = module.FMU3Slave if is_third else module.FMU2Slave
    return kind(
        guid=description.guid, unzipDirectory=folder, instanceName="input",
        modelIdentifier=description.coSimulation.modelIdentifier,
    )  # fmt: skip


def _failure(where: str, t: float, what: str) -> SimulationError:
    return SimulationError(
        Problem("fmu_input.failed", where, f"at t = {t:.9g} s {what}", "",
                "check its inputs, its parameters and its step in the tool that exported it")
    )  # fmt: skip
