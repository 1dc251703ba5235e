"""`simulate`: from equations and initial values to a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.codegen.compile import Value, form_sequence
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, SimulationError, nearest
from symbody.simulation.explicit import Explicit, integrate
from symbody.simulation.trajectory import Trajectory

Floats = NDArray[np.float64]
