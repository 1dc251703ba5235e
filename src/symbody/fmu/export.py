"""`save_fmu`: a mechanism as a functional mock-up unit."""

from __future__ import annotations

import hashlib
import os
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from typing import Final

import symbody
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.fmu.binaries import CORE, HEADERS, MAIN, Platform, Version, compile_libraries
from symbody.fmu.descriptions import (
    build_description,
    model_description,
)
from symbody.fmu.model_text import model_text
from symbody.fmu.parameters import fmu_parameters
from symbody.fmu.program import FmuProgram, make_program
from symbody.fmu.variables import FmuVariable, fmu_variables, identifier
from symbody.formats.writing import write_content
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha

_DATE: Final = (1980, 1, 1, 0, 0, 0)  # the first that an archive can hold, so that bytes do not change
_LICENCE: Final = "documentation/licenses/fmi-headers.txt"

# Measured in docs/fmu.md: neither the export nor its stabilizing terms are the cause, but the method.
_ADVICE: Final = (
    "model exchange is as accurate as the importer's integrator: by backward differentiation (CVODE, as in "
    "FMPy) errors are 10 to 1,000 times those of co-simulation at the same tolerance; use co-simulation, or "
    "a tolerance of 1e-10"
)


@dataclass(frozen=True, slots=True)
class Fmu:
    """An FMU that was written.

    Attributes
    ----------
    path : Path
        The archive.
    version : str
        Of the standard.
    platforms : tuple of str
        For which it holds a library.
    variables : tuple of FmuVariable
        In the order of their value references.
    notes : tuple of str
        What was left out, and why.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail]))
    >>> fmu = sb.save_fmu(eqs, "cart.fmu", platforms=())  # doctest: +SKIP
    >>> [variable.name for variable in fmu.variables][:3]  # doctest: +SKIP
    ['time', 'x_dot', 'x']
    """

    path: Path
    version: str
    platforms: tuple[str, ...]
    variables: tuple[FmuVariable, ...]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        where = ", ".join(self.platforms) or "sources only"
        return f"Fmu({str(self.path)!r}, FMI {self.version}): {len(self.variables)} variables, {where}"


@named_after(3)
@checked_arguments
def save_fmu(
    eqs: EquationSet,
    path: str | os.PathLike[str],
    version: Version = "3.0",
    outputs: Iterable[str] = (),
    initial: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    fixed: Iterable[str] = (),
    events: Event | Iterable[Event] = (),
    constraints: Projection | Baumgarte | None = None,
    integrator: Explicit | FixedStep | GeneralizedAlpha | None = None,
    platforms: str | Iterable[str] | None = None,
    sources: bool = True,
) -> Fmu:
    """Write a mechanism as an FMU, for model exchange and for co-simulation.

    Inputs and parameters can be set; `outputs`, the energy and the violation of the constraints are outputs;
    speeds and coordinates are the states. The C inside needs the C library alone.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    path : str or path
        The archive to write, ``name.fmu``.
    version : "3.0" or "2.0"
        Of the FMI standard.
    outputs : iterable of str
        What `compile` computes: numbers, vectors or matrices, which become one variable an entry.
    initial : mapping, optional
        Fixed values of the first state. An importer may set others, and the rest follows inside the FMU.
    parameters : mapping, optional
        Values that differ from the model's.
    fixed : iterable of str
        Parameters that can be set before the motion only; all others are tunable.
    events : Event or iterable of Event
        Event indicators of model exchange; co-simulation finds them by itself.
    constraints : Baumgarte or Projection, optional
        ``Baumgarte(..)`` are the stabilizing terms of model exchange, ``Projection(..)`` how co-simulation
        closes loops. By default both with their own defaults.
    integrator : Explicit, FixedStep or GeneralizedAlpha, optional
        Of co-simulation. With ``GeneralizedAlpha(..)``, for stiff mechanisms, the default tolerance is 1e-5.
    platforms : str or iterable of str, optional
        ``"x86_64-linux"``, ``"aarch64-linux"``, ``"x86_64-windows"``, ``"x86_64-darwin"``,
        ``"aarch64-darwin"``, or ``"all"``; by default this machine's own, or none without a compiler.
    sources : bool
        Whether the C stays in the archive.

    Returns
    -------
    Fmu
        What was written: its variables, platforms and notes.

    Raises
    ------
    UsageError
        If the motion needs Python, or a name is not valid.
    AssemblyError, CompileError, FormatError
        If loops do not close, an output is unknown, or the archive cannot be written.
    EnvironmentFault
        If no compiler makes libraries for a platform that is asked for.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> fmu = sb.save_fmu(eqs, "oscillator.fmu", outputs=["energy"])  # doctest: +SKIP
    """
    file = Path(path)
    _check_path(file)
    shown = (outputs,) if isinstance(outputs, str) else tuple(outputs)
    watched = check_events(events if isinstance(events, Event) else tuple(events), eqs)
    given = fmu_parameters(eqs, parameters or {}, fixed)
    program = make_program(eqs, shown, initial or {}, given, watched, constraints, integrator)
    return _write(program, file, version, platforms, sources)


def _write(
    program: FmuProgram, file: Path, version: Version, platforms: str | Iterable[str] | None, sources: bool
) -> Fmu:
    variables = fmu_variables(program)
    token = _token(program, variables, version)
    text = _source_files(program, variables, token, version)
    libraries, notes = compile_libraries(text, MAIN[version], platforms, version)
    if not libraries and not sources:
        raise UsageError(
            Problem("fmu.empty", "sources", "the archive would hold neither sources nor a library", "",
                    "use sources=True, or name platforms for which there is a compiler")
        )  # fmt: skip
    stem, kept = identifier(file.stem), text if sources else {}
    listed = [MAIN[version]] if kept else []
    about = model_description(program, variables, stem, token, version, listed)
    content = {"modelDescription.xml": about, **_content(stem, kept, libraries, version)}
    write_content(file, _archive(content), keep=False)
    notes += ((_ADVICE,) if len(program.x0) else ()) + program.jumps.notes + _notes_of_inputs(program)
    return Fmu(file, version, tuple(each.name for each in libraries), variables, notes)


def _notes_of_inputs(program: FmuProgram) -> tuple[str, ...]:
    """Return a note for each input that follows a table of the model in `simulate`, and 0 in the FMU."""
    inputs = program.eqs.input_names
    return tuple(
        f"{table.name} is an input: 0 until an importer sets it. The table of this name in the model, which "
        f"defines the input in simulate, is not in the archive; a table with another name that appears in a "
        f"formula would be"
        for table in program.eqs.model.tables if table.name in inputs
    )  # fmt: skip


def _check_path(file: Path) -> None:
    if file.suffix != ".fmu":
        raise UsageError(
            Problem("fmu.path", str(file), f"{file.name} does not end with .fmu",
                    "importers rely on the suffix", f"write {file.stem}.fmu")
        )  # fmt: skip


def _source_files(
    program: FmuProgram, variables: tuple[FmuVariable, ...], token: str, version: str
) -> dict[str, bytes]:
    package = files(__package__)
    made = {name: (package / "core" / name).read_bytes() for name in (MAIN[version], *CORE)}
    made |= {name: (package / "headers" / name).read_bytes() for name in HEADERS[version]}
    return made | {"model.h": model_text(program, variables, token).encode()}


def _content(
    stem: str, text: Mapping[str, bytes], libraries: Mapping[Platform, bytes], version: Version
) -> dict[str, bytes]:
    made = {}
    if text and version == "3.0":
        made["sources/buildDescription.xml"] = build_description(stem, MAIN[version])
    made |= {f"sources/{name}": content for name, content in text.items()}
    for each, content in libraries.items():
        folder = each.name_2 if version == "2.0" else each.name
        made[f"binaries/{folder}/{stem}{each.suffix}"] = content
    if text:
        made[_LICENCE] = (files(__package__) / "headers" / "LICENSE.txt").read_bytes()
    return made


def _archive(content: Mapping[str, bytes]) -> bytes:
    """Return a zip archive whose bytes follow from its content."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, data)
    return buffer.getvalue()


def _token(program: FmuProgram, variables: tuple[FmuVariable, ...], version: str) -> str:
    """Return a word that changes with the interface and with what is computed."""
    words = [symbody.__version__, version, "\n".join(map(repr, variables))]
    words += [str(function.sequence.word) for function in program.functions.values()]
    digest = hashlib.sha256("\n".join(words).encode()).hexdigest()
    return "{" + "-".join([digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32]]) + "}"
