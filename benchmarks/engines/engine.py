"""The engines there are, and how each is brought into a process."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Final

from benchmarks.engines.algebra import Algebra


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine by name.

    Attributes
    ----------
    label : str
        What tables call it.
    package : str
        What has to be installed.
    module, maker : str
        Where to find the callable that returns a new algebra.
    """

    label: str
    package: str
    module: str
    maker: str

    @property
    def installed(self) -> bool:
        """Whether the package is there."""
        return find_spec(self.package) is not None

    def new(self) -> Algebra:
        """Return the engine with nothing in it."""
        made: Algebra = getattr(import_module(self.module), self.maker)()
        return made


OURS: Final = Engine("symbody", "symbody", "benchmarks.engines.ours", "Engine")
PEERS: Final = (
    Engine("SymPy", "sympy", "benchmarks.engines.with_sympy", "Engine"),
    Engine("SymEngine", "symengine", "benchmarks.engines.with_symengine", "Engine"),
    Engine("CasADi SX", "casadi", "benchmarks.engines.with_casadi", "interpreted"),
    Engine("CasADi SX, C", "casadi", "benchmarks.engines.with_casadi", "through_c"),
)
