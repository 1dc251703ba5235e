"""What ``symbody linearize`` and ``symbody equilibrium`` print, as lines or as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.equilibrium.find_equilibrium import Equilibrium
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.modes import Mode


def linear_lines(lin: Linearization) -> list[str]:
    """Return the matrices, modes, verdict and notes."""
    return [
        f"states: {', '.join(lin.state_names)}",
        *([f"inputs: {', '.join(lin.input_names)}"] if lin.input_names else []),
        *([f"outputs: {', '.join(lin.output_names)}"] if lin.output_names else []),
        *(line for name, matrix in zip("ABCD", lin, strict=True) for line in _matrix(name, matrix)),
        *_modes(lin.modes),
        f"verdict: {lin.verdict}",
        *(f"note: {note}" for note in lin.notes),
    ]


def linear_json(lin: Linearization) -> str:
    """Return the same as JSON."""
    entries = {name: matrix.tolist() for name, matrix in zip("ABCD", lin, strict=True)}
    names = {"states": lin.state_names, "inputs": lin.input_names, "outputs": lin.output_names}
    values = [[value.real, value.imag] for value in lin.eigenvalues.tolist()]
    rest = {"affine": lin.affine.tolist(), "stationary": lin.is_stationary, "eigenvalues": values}
    return json.dumps({**entries, **names, **rest, "verdict": lin.verdict, "notes": lin.notes})


def equilibrium_lines(found: Equilibrium) -> list[str]:
    """Return an equilibrium, the others found, and what they are."""
    places = [found, *(state for state in found.branches if isinstance(state, Equilibrium))]
    return [
        *(f"{_values(place.q)}: {place.verdict}" for place in places),
        *([f"multipliers: {_values(found.multipliers)}"] if found.multipliers else []),
        *([f"inputs: {_values(found.inputs)}"] if found.inputs else []),
        *(f"note: {note}" for note in found.notes),
    ]


def equilibrium_json(found: Equilibrium) -> str:
    """Return the same as JSON."""
    places = [found, *(state for state in found.branches if isinstance(state, Equilibrium))]
    states = [
        {"q": dict(p.q), "multipliers": dict(p.multipliers), "verdict": p.verdict, "notes": p.notes}
        for p in places
    ]
    return json.dumps({"equilibria": states, "inputs": {k: str(v) for k, v in found.inputs.items()}})


def _values(named: Mapping[str, object]) -> str:
    return ", ".join(f"{name} = {_short(value)}" for name, value in named.items())


def _short(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _matrix(name: str, matrix: NDArray[np.float64]) -> Iterator[str]:
    if matrix.size:
        cells = [[f"{x:.6g}" for x in row] for row in matrix]
        width = max(len(cell) for row in cells for cell in row)
        yield f"{name}:"
        yield from ("  " + "  ".join(cell.rjust(width) for cell in row) for row in cells)


def _modes(modes: Sequence[Mode]) -> Iterable[str]:
    for mode in modes:
        value = mode.eigenvalue
        if value.imag >= 0.0:
            pair = f" +- {value.imag:.6g}i" if value.imag > 0.0 else ""
            facts = [f"eigenvalue {value.real:.6g}{pair} 1/s"]
            if pair:
                damping = mode.damping_ratio + 0.0  # no minus before 0
                facts.append(f"frequency {mode.frequency:.6g} rad/s, damping ratio {damping:.4g}")
            elif math.isfinite(mode.time_constant):
                facts.append(f"time constant {mode.time_constant:.6g} s")
            yield ": ".join(facts)
