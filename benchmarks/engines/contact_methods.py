"""Laws of contact by the engines that have them: each gives a body's places for each of its settings.

No two engines have the same law. Each law has a reference of its own, with steps far shorter than all that
are compared, and how far a coarser one is from it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import symbody as sb
from benchmarks.contact_problems import Falling, Floats, height_and_way, model_of

_TOLERANCES: Final = tuple(10.0**-k for k in range(3, 11))
_LOOSE: Final = tuple(10.0**-k for k in range(2, 6))
_RIGID: Final = (1e-4, 1e-8)
_STEPS: Final = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5)
_ACCURACIES: Final = tuple(10.0**-k for k in range(2, 7))
_STEPS_OF_SAP: Final = (4e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4)

Move = Callable[[str, float], Floats]


class Law(NamedTuple):
    """A law of contact.

    Attributes
    ----------
    make : callable
        Takes a body that falls, gives what moves it by a method with a setting, and raises where that fails.
    methods : mapping
        Settings of each method, the coarsest first.
    reference, second : tuple of str and float
        A method and its setting; one that is coarser.
    package : str
        That has it.
    """

    make: Callable[[Falling], Move]
    methods: Mapping[str, tuple[float, ...]]
    reference: tuple[str, float]
    second: tuple[str, float]
    package: str = "symbody"

    @property
    def is_installed(self) -> bool:
        """Whether the package of the law is there."""
        return find_spec(self.package) is not None


def _ours(problem: Falling, *, rigid: bool) -> Move:
    """Return motions by symbody; absolute tolerances in m, rad and per second."""
    eqs, rows = sb.form_equations(model_of(problem, rigid=rigid)), list(height_and_way(problem))
    integrators: dict[str, Any] = {
        "order 8": sb.Explicit(), "order 5": sb.Explicit(order=5), "alpha": sb.GeneralizedAlpha(),
    }  # fmt: skip

    def move(method: str, rtol: float) -> Floats:
        motion = sb.simulate(
            eqs, problem.end, times=problem.times, integrator=integrators[method], rtol=rtol, atol=rtol,
            max_steps=10**7,
        )  # fmt: skip
        if not motion.success:
            raise RuntimeError(f"{motion.status.name} at {motion.t[-1]:.3g} s")
        return motion.q[rows]

    return move


def _stepped(problem: Falling) -> Move:
    """Return motions by symbody in steps over impacts."""
    eqs, rows = sb.form_equations(model_of(problem, rigid=True)), list(height_and_way(problem))

    def move(method: str, step: float) -> Floats:
        integrator = sb.MoreauJean(step=step, tolerance=float(method))
        motion = sb.simulate(eqs, problem.end, times=problem.times, integrator=integrator, max_steps=10**7)
        return motion.q[rows]

    return move


def _mujoco(problem: Falling) -> Move:
    from benchmarks.engines.contact_mujoco import motion

    return motion(problem)


def _drake(problem: Falling) -> Move:
    from benchmarks.engines.contact_drake import motion

    return motion(problem)


COMPLIANT: Final = "symbody"
LAWS: Final[Mapping[str, Law]] = MappingProxyType(
    {
        COMPLIANT: Law(
            lambda problem: _ours(problem, rigid=False),
            {"order 8": _TOLERANCES, "order 5": _TOLERANCES[:-2], "alpha": _LOOSE},
            ("order 8", 1e-13), ("order 5", 1e-12),
        ),
        "symbody, rigid": Law(
            lambda problem: _ours(problem, rigid=True), {"order 8": _RIGID},
            ("order 8", 1e-12), ("order 8", 1e-10),
        ),
        "symbody, MoreauJean": Law(
            _stepped, {"1e-6": _STEPS}, ("1e-10", 2e-6), ("1e-10", 5e-6),
        ),
        "MuJoCo": Law(
            _mujoco, {"Euler": _STEPS, "RK4": _STEPS, "implicitfast": _STEPS},
            ("RK4", 5e-6), ("RK4", 1e-5), "mujoco",
        ),
        "Drake": Law(
            _drake, {"Runge-Kutta 3": _ACCURACIES},
            ("Runge-Kutta 3", 1e-9), ("Runge-Kutta 3", 1e-8), "pydrake",
        ),
        "Drake, SAP": Law(_drake, {"SAP": _STEPS_OF_SAP}, ("SAP", 2e-5), ("SAP", 5e-5), "pydrake"),
    }
)  # fmt: skip
