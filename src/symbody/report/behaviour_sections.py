"""The end of a report: equilibria and modes, a motion, the code, and what all was computed with."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator
from hashlib import sha256
from typing import Final

import numpy as np

import symbody
from symbody.analysis.equilibrium.find_equilibrium import find_equilibrium
from symbody.analysis.linear.linearize import linearize
from symbody.analysis.linear.modes import Mode, eigenvalue_on_axes
from symbody.equations.equation_set import EquationSet
from symbody.errors import SymbodyError
from symbody.expr.fingerprints.fingerprint import fingerprints
from symbody.report.document import (
    Block,
    Cell,
    Figure,
    Name,
    Notes,
    Paragraph,
    ReportSection,
    TextTable,
    Unit,
)
from symbody.report.pictures import motion_picture
from symbody.report.setting import Setting, reason
from symbody.simulation.programs.generate_code import generate_code
from symbody.simulation.results.trajectory import Trajectory

_MOST_CURVES: Final = 8
_MOST_SPEEDS: Final = 100  # of an equilibrium and its modes, whose time grows with the cube
_MOST_OPERATIONS: Final = 20_000  # of code whose size is measured by writing it
_COUNTED: Final = (
    "mass_matrix",
    "forcing",
    "jacobian",
    "gamma",
    "constraints",
    "kinetic_energy",
    "udot",
    "xdot",
)
_LANGUAGES: Final = ("c", "python", "fortran", "matlab", "julia", "rust")


def equilibrium_section(setting: Setting) -> ReportSection:
    """Return an equilibrium near the initial values, and the modes about it."""
    return ReportSection("equilibrium", "Equilibrium and modes", tuple(_equilibrium(setting)))


def _equilibrium(setting: Setting) -> Iterator[Block]:
    eqs = setting.eqs
    if isinstance(setting.start, str):
        yield Paragraph(f"No search was made: {setting.start}")
        return
    if len(eqs.speed_names) > _MOST_SPEEDS:
        yield Paragraph(
            f"No search was made, because there are {len(eqs.speed_names)} speeds; use find_equilibrium(eqs)."
        )
        return
    try:
        balance = find_equilibrium(eqs, parameters=setting.parameters)
    except SymbodyError as error:
        yield Paragraph(f"No equilibrium was found near the initial values: {reason(error)}")
        return
    yield Paragraph("Near the initial values:")
    rows: list[tuple[Cell, ...]] = [
        (Name(name), _round_off(value), Unit(eqs.units.get(name, ""))) for name, value in balance.q.items()
    ]
    yield TextTable(("coordinate", "value", "unit"), tuple(rows))
    names = frozenset((*eqs.state_names, *eqs.input_names))
    yield Notes(balance.notes, names)
    try:
        linear = linearize(eqs, balance)
    except SymbodyError as error:
        yield Paragraph(f"The equations cannot be linearized: {reason(error)}")
        return
    yield Paragraph(f"Small motions are {linear.verdict}.")
    yield Notes(tuple(note for note in linear.notes if note not in balance.notes), names)
    shown = [mode for mode in linear.modes if mode.eigenvalue.imag >= 0.0]
    zeros = sum(map(_is_zero, shown))
    modes = tuple(_mode_row(mode) for mode in shown if not _is_zero(mode))
    if zeros:  # one row for all
        times = f" ({zeros} times)" if zeros > 1 else ""
        modes = (*modes, (f"0{times}", 0.0, math.nan, math.inf))
    heading = ("eigenvalue [1/s]", "frequency [rad/s]", "damping ratio", "time constant [s]")
    yield TextTable(heading, modes)


def _is_zero(mode: Mode) -> bool:
    """Return whether an eigenvalue is zero but for rounding."""
    return bool(mode.frequency <= mode.tolerance)


def _mode_row(mode: Mode) -> tuple[Cell, ...]:
    value = eigenvalue_on_axes(mode)
    pair = "\u00b1" if value.imag else ""
    shown = f"{value.real:.5g} {pair} {abs(value.imag):.5g} i" if pair else f"{value.real:.5g}"
    return (shown.replace("-", "\u2212"), mode.frequency, mode.damping_ratio, mode.time_constant)


def _round_off(value: float) -> float:
    return 0.0 if abs(value) < 1e-12 else value


def motion_section(setting: Setting) -> ReportSection:
    """Return a motion as pictures, with its energy and the violation of the constraints."""
    if setting.run is None:
        return ReportSection("motion", "Motion")
    return ReportSection("motion", "Motion", tuple(_motion(setting.run, bool(setting.eqs.multiplier_names))))


def _motion(run: Trajectory, has_constraints: bool) -> Iterator[Block]:
    yield Paragraph(f"From t = {run.t[0]:g} s to {run.t[-1]:g} s, {run.t.size} samples: {run.status.value}.")
    names = run.coordinate_names
    if names:
        yield Figure(
            "motion", "Coordinates over time", lambda kind: motion_picture(run, names[:_MOST_CURVES], kind)
        )
    if len(names) > _MOST_CURVES:
        yield Paragraph(f"The first {_MOST_CURVES} of {len(names)} coordinates are shown.")
    energies = ("kinetic_energy", "potential_energy", "energy")
    yield Figure("energy", "Energies over time", lambda kind: motion_picture(run, energies, kind))
    energy = np.asarray(run["energy"])
    yield Paragraph(f"Energy: {energy[0]:.6g} J at the start, {energy[-1]:.6g} J at the end.")
    if has_constraints:
        worst = float(np.max(run.constraint_violation, initial=0.0))
        yield Paragraph(f"Largest constraint error: {worst:.2g} of the mechanism's size.")
    rows = tuple((f"{event.t:.9g}", event.name) for event in run.events[:30])
    yield TextTable(("t [s]", "event"), rows)
    yield Notes(run.notes)


def code_section(setting: Setting) -> ReportSection:
    """Return the operations of each output, and the size of the state's rates as code of each language."""
    eqs = setting.eqs
    count = eqs.operation_count("xdot")
    without_constraints = ("jacobian", "gamma", "constraints")
    counted = [name for name in _COUNTED if eqs.multiplier_names or name not in without_constraints]
    blocks: list[Block] = [
        Paragraph("Operations of each output, shared parts once, parameters as symbols:"),
        TextTable(
            ("output", "operations"), tuple((name, str(eqs.operation_count(name))) for name in counted)
        ),
    ]
    if count > _MOST_OPERATIONS:
        return ReportSection("code", "Code", blocks)
    blocks.append(Paragraph("The rates of the state, xdot, as code:"))
    rows: list[tuple[Cell, ...]] = []
    for language in _LANGUAGES:
        try:
            text = generate_code(eqs, "xdot", language)
        except SymbodyError as error:
            rows.append((language, "none", reason(error)))
        else:
            rows.append((language, str(text.count("\n")), f"{len(text) / 1000:.1f} kB"))
    blocks.append(TextTable(("language", "lines", "size"), tuple(rows)))
    return ReportSection("code", "Code", blocks)


def origin_section(setting: Setting) -> ReportSection:
    """Return versions and a fingerprint: reports of the same equations have the same."""
    rows = (
        ("symbody", symbody.__version__),
        ("Python", platform.python_version()),
        ("numpy", np.__version__),
        ("equations, by their fingerprint", _fingerprint(setting.eqs)),
    )
    return ReportSection("origin", "Versions", (TextTable(("computed with", "version"), rows),))


def _fingerprint(eqs: EquationSet) -> str:
    """Return the same text for equations that are equal as functions, however they are written."""
    graph = eqs.formed.graph
    nodes = [node for name in ("mass_matrix", "forcing", "constraints") for node in eqs.roots(name).nodes]
    values = fingerprints(graph, list(graph.reachable(nodes)))
    words = [
        *eqs.coordinate_names,
        *eqs.speed_names,
        *(f"{a:x} {b:x}" for a, b in (values[node] for node in nodes)),
    ]
    return sha256("\n".join(words).encode()).hexdigest()[:16]
