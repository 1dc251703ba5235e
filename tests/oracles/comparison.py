"""Numbers of a model by name, and how far solutions of linear systems may differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

import symbody as sb

Floats = NDArray[np.float64]

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, slots=True)
class Compiled:
    """Outputs of a model by compiled code, at states given by the names of coordinates, speeds and inputs."""

    function: sb.CompiledFunction
    outputs: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]

    @property
    def speed_names(self) -> tuple[str, ...]:
        return self.groups[1]

    def __call__(self, values: Mapping[str, float]) -> dict[str, Floats]:
        found = self.function(0.0, *([values[name] for name in names] for names in self.groups))
        listed = [found] if len(self.outputs) == 1 else found
        return {name: np.array(value) for name, value in zip(self.outputs, listed, strict=True)}


def compiled(model: sb.Model, *outputs: str) -> Compiled:
    """The outputs of a model."""
    eqs = sb.form_equations(model)
    groups = (eqs.coordinate_names, eqs.speed_names, eqs.input_names)
    return Compiled(sb.compile(eqs, outputs), outputs, groups)


def computed(
    model: sb.Model, values: Mapping[str, float], *outputs: str
) -> tuple[dict[str, Floats], tuple[str, ...]]:
    """The outputs of a model at one state, and the names of its speeds."""
    code = compiled(model, *outputs)
    return code(values), code.speed_names


def sensitivity(M: ArrayLike, F: ArrayLike, x: ArrayLike) -> float:
    """Change of the solution of ``M x = F``, relative to its largest entry, for entries of M and F changed by 1.

    ``max |M^-1| (|M| |x| + |F|) / max |x|`` [Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.,
    section 7.2]: times eps, what one rounding of each entry does.
    """
    matrix, size = np.abs(np.array(M, float)), np.abs(np.array(x, float))
    inverse = np.abs(np.linalg.inv(np.array(M, float)))
    change = inverse @ (matrix @ size + np.abs(np.array(F, float)))
    return float(change.max() / size.max())
