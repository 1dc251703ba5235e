"""Times of Pinocchio's recursions in C++, over given states."""

from __future__ import annotations

import statistics
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PinocchioCalls:
    """The program with a robot and its states.

    Attributes
    ----------
    program : Path
        What `build.program` made of calls.cpp.
    model, states : Path
        Files it reads.
    n_v : int
        Speeds.
    """

    program: Path
    model: Path
    states: Path
    n_v: int

    @classmethod
    def of(cls, program: Path, folder: Path, model: Any, q: Floats, v: Floats, x: Floats) -> PinocchioCalls:
        """Return the program with its files in a folder; x are efforts for aba, accelerations for rnea."""
        found = cls(program, folder / "model.txt", folder / "states.bin", v.shape[1])
        model.saveToText(str(found.model))
        head = np.array([len(q), q.shape[1], v.shape[1]], dtype=float)
        np.concatenate([head, np.hstack([q, v, x]).ravel()]).tofile(found.states)
        return found

    def nanoseconds(self, repeats: int) -> dict[str, float]:
        """Return the time of a call of each recursion [ns], the median of so many passes over the states."""
        text = self._run(repeats)
        found: dict[str, list[float]] = {}
        for line in text.splitlines():
            name, value = line.split()
            found.setdefault(name, []).append(float(value))
        return {name: statistics.median(values) for name, values in found.items()}

    def results(self) -> tuple[Floats, Floats]:
        """Return the accelerations of aba for the efforts x, and the efforts of rnea for accelerations x."""
        self._run(0)
        both = np.fromfile(self._results).reshape(-1, 2, self.n_v)
        return both[:, 0], both[:, 1]

    @property
    def _results(self) -> Path:
        return self.states.with_name("results.bin")

    def _run(self, repeats: int) -> str:
        files = (self.model, self.states, str(repeats), self._results)
        done = subprocess.run([self.program, *files], capture_output=True, text=True, check=True)
        return done.stdout
