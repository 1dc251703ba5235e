"""Integrators of stiff motions, by name: each gives the places at the end for each of its settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from types import MappingProxyType
from typing import Any, Final, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.stiff_problems import Floats, Stiff, model_of, places
from symbody.simulation.methods.implicit.state_jacobian import STATE_JACOBIAN, with_state_jacobian

END: Final = 2.0  # s of motion
_START: Final = 1e-6  # s, for which a function is compiled
_STEPS: Final = tuple(8e-3 / 2**k for k in range(8))
_STEPS_OF_PEERS: Final = tuple(8e-3 / 4**k for k in range(5))
_LOOSE: Final = tuple(10.0**-k for k in range(2, 7))
_TIGHT: Final = tuple(10.0**-k for k in range(2, 9))
_TIGHTEST: Final = tuple(10.0**-k for k in range(2, 13, 2))
_REFERENCE: Final = 1e-13

Run = Callable[[float], Floats]


class Method(NamedTuple):
    """A method: its settings, the loosest first, what a setting is called, and what makes its runs.

    A run gives the places at the end for a setting, and raises where it does not get there.
    """

    settings: tuple[float, ...]
    label: Callable[[float], str]
    make: Callable[[Stiff], Run]
    package: str = "symbody"

    @property
    def is_installed(self) -> bool:
        """Whether the package of the method is there."""
        return find_spec(self.package) is not None


def rtol_label(rtol: float) -> str:
    """Return how a relative tolerance is written.

    >>> rtol_label(1e-4)
    'rtol 1e-04'
    """
    return f"rtol {rtol:.0e}"


def step_label(step: float) -> str:
    """Return how a length of steps is written.

    >>> step_label(0.0005)
    'h 0.5 ms'
    """
    return f"h {1e3 * step:.3g} ms"


def exact_places(problem: Stiff) -> tuple[Floats, float]:
    """Return the places at the end, and how far those of another order and tolerance are from them."""
    one, other = (
        _ours(problem, lambda rtol, order=order: sb.Explicit(order=order))(rtol)
        for order, rtol in ((8, _REFERENCE), (5, 10.0 * _REFERENCE))
    )
    return one, float(np.abs(one - other).max())


def _ours(problem: Stiff, integrator: Callable[[float], Any], rtol: float | None = None) -> Run:
    """Return motions by symbody; absolute tolerances in rad, m and per second."""
    eqs, of_q = sb.form_equations(model_of(problem)), places(problem)

    def run(setting: float, end: float = END) -> Floats:
        tolerance = setting if rtol is None else rtol
        motion = sb.simulate(
            eqs, end, times=[end], integrator=integrator(setting), rtol=tolerance, atol=tolerance,
            max_steps=10**8,
        )  # fmt: skip
        if not motion.success:
            raise RuntimeError(motion.status.name)
        return of_q(motion.q[:, -1])

    run(1e-6, _START)
    return run


def _radau(problem: Stiff) -> Run:
    """Return motions by SciPy, with compiled slopes and derivatives."""
    formed, of_q = sb.form_equations(model_of(problem)), places(problem)
    eqs = with_state_jacobian(formed, {}, ())
    slopes, derivatives = sb.compile(eqs, "xdot"), sb.compile(eqs, STATE_JACOBIAN, quick=True)
    n_u = len(eqs.speed_names)
    first = sb.simulate(formed, 0.0)
    start = np.concatenate([first.u[:, 0], first.q[:, 0]])

    def run(rtol: float) -> Floats:
        motion = solve_ivp(
            lambda t, x: slopes(t, x[n_u:], x[:n_u]), (0.0, END), start, "Radau", rtol=rtol, atol=rtol,
            jac=lambda t, x: derivatives(t, x[n_u:], x[:n_u]),
        )  # fmt: skip
        if not motion.success:
            raise RuntimeError(motion.message)
        return of_q(motion.y[n_u:, -1])

    return run


def _exudyn(problem: Stiff) -> Run:
    from benchmarks.engines.stiff_exudyn import motion

    return _then_places(problem, motion(problem, END))


def _mujoco(problem: Stiff, integrator: str) -> Run:
    from benchmarks.engines.stiff_mujoco import motion

    return _then_places(problem, motion(problem, END, integrator))


def _then_places(problem: Stiff, move: Run) -> Run:
    of_q = places(problem)
    return lambda step: of_q(move(step))


EXPLICIT: Final = "Explicit"
METHODS: Final[Mapping[str, Method]] = MappingProxyType(
    {
        EXPLICIT: Method(_TIGHTEST, rtol_label, lambda problem: _ours(problem, lambda rtol: sb.Explicit())),
        "GeneralizedAlpha(step=h)": Method(
            _STEPS, step_label, lambda problem: _ours(problem, _steps_of_one_length, rtol=1e-5)
        ),
        "GeneralizedAlpha": Method(
            _LOOSE, rtol_label, lambda problem: _ours(problem, lambda rtol: sb.GeneralizedAlpha())
        ),
        "Stiff (CVODE)": Method(_TIGHT, rtol_label, lambda problem: _ours(problem, lambda rtol: sb.Stiff())),
        "SciPy Radau": Method(_TIGHT, rtol_label, _radau),
        "Exudyn": Method(_STEPS_OF_PEERS, step_label, _exudyn, "exudyn"),
        "MuJoCo RK4": Method(
            _STEPS_OF_PEERS, step_label,
            lambda problem: _mujoco(problem, "RK4"), "mujoco",
        ),
        "MuJoCo implicitfast": Method(
            _STEPS_OF_PEERS, step_label,
            lambda problem: _mujoco(problem, "implicitfast"), "mujoco",
        ),
    }
)  # fmt: skip


def _steps_of_one_length(step: float) -> sb.GeneralizedAlpha:
    return sb.GeneralizedAlpha(step=step)
