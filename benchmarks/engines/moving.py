"""Engines that move the spatial chain of `benchmarks.mechanisms` from rest, each at a setting of accuracy.

All have the same masses, lengths and moments of inertia, and begin at the same angles.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from time import process_time
from typing import Any, Final

import numpy as np
import scipy
from numpy.typing import NDArray

import symbody as sb
from benchmarks.mechanisms import spatial_chain

Floats = NDArray[np.float64]

MASS, LENGTH, INERTIA, GRAVITY = 1.0, 0.5, (0.05, 0.04, 0.02), 9.81
_LADDER: Final = tuple(10.0**-k for k in range(4, 13))
_ATOL: Final = 1e-13


@dataclass(frozen=True, slots=True)
class Motion:
    """What an engine answers: how long the motion took [s], and the angles at its end.

    Seconds are those of the processor, which other work on it hardly changes; of symbody, whose loop is too
    short to be interrupted, those of the clock.
    """

    seconds: float
    angles: Floats


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine for one chain.

    Attributes
    ----------
    settings : tuple of float
        From coarse to fine: relative tolerances, or steps.
    move : callable
        Takes a setting.
    """

    settings: tuple[float, ...]
    move: Callable[[float], Motion]


def start_angles(links: int) -> Floats:
    """Return where all begin, at rest."""
    return 0.3 + 0.1 * np.arange(links, dtype=float)


def parameters(links: int) -> dict[str, float]:
    """Return the values of the chain's parameters."""
    found = {"g": GRAVITY}
    for k in range(links):
        found |= {
            f"m{k}": MASS,
            f"l{k}": LENGTH,
            **dict(zip((f"a{k}", f"b{k}", f"c{k}"), INERTIA, strict=True)),
        }
    return found


def ours(links: int, end: float) -> Engine:
    """Return symbody's loop, order 8."""
    eqs = sb.form_equations(spatial_chain(links).model())
    guess = dict(zip(eqs.coordinate_names, start_angles(links).tolist(), strict=True))
    given = parameters(links)

    def move(rtol: float) -> Motion:
        run = sb.simulate(eqs, end, times=[0.0, end], guess=guess, parameters=given, rtol=rtol, atol=_ATOL,
                          integrator=sb.Explicit())  # fmt: skip
        return Motion(run.statistics.loop_seconds, run.q[:, -1])

    return Engine(_LADDER, move)


def scipy_around_ours(links: int, end: float) -> Engine:
    """Return SciPy's DOP853 around symbody's compiled function."""
    rates, x = _our_function(links)

    def move(rtol: float) -> Motion:
        began = process_time()
        found = scipy.integrate.solve_ivp(rates, (0.0, end), x, "DOP853", [end], rtol=rtol, atol=_ATOL)
        return Motion(process_time() - began, found.y[links:, -1])

    return Engine(_LADDER, move)


def sundials_around_ours(links: int, end: float) -> Engine:
    """Return CVODE's Adams method around symbody's compiled function."""
    solver = import_module("sksundae.cvode").CVODE
    rates, x = _our_function(links)

    def rhs(t: float, y: Floats, yp: Floats) -> None:
        yp[:] = rates(t, y)

    def move(rtol: float) -> Motion:
        began = process_time()
        found = solver(rhs, method="Adams", rtol=rtol, atol=_ATOL, max_num_steps=10**6).solve(
            np.array([0.0, end]), x
        )
        return Motion(process_time() - began, found.y[-1, links:])

    return Engine(_LADDER, move)


def _our_function(links: int) -> tuple[Callable[[float, Floats], Floats], Floats]:
    eqs = sb.form_equations(spatial_chain(links).model())
    f = sb.compile(eqs, "xdot", parameters=parameters(links))
    return f.of_state, np.concatenate([np.zeros(links), start_angles(links)])


def mujoco(links: int, end: float) -> Engine:
    """Return MuJoCo's Runge-Kutta method of order 4, steps in its own loop."""
    library, rollout = import_module("mujoco"), import_module("mujoco.rollout")
    model = library.MjModel.from_xml_string(mujoco_text(links))
    data = library.MjData(model)
    first = np.concatenate([[0.0], start_angles(links), np.zeros(links)])

    def move(step: float) -> Motion:
        model.opt.timestep = step
        count = round(end / step)
        began = process_time()
        state, _ = rollout.rollout(model, data, first, nstep=count)
        return Motion(process_time() - began, state[0, -1, 1 : 1 + links])

    return Engine(tuple(0.02 / 2**k for k in range(10)), move)


def mujoco_text(links: int) -> str:
    """Return the chain in MuJoCo's XML, without contacts, damping and armature."""
    head = f'<mujoco><option gravity="0 0 {-GRAVITY}" integrator="RK4"/><worldbody>'
    bodies = ""
    for k in range(links):
        axis = " ".join("1" if place == (k + 1) % 3 else "0" for place in range(3))
        bodies += f'<body pos="0 0 {LENGTH if k else 0}"><joint type="hinge" axis="{axis}"/>'
        moments = " ".join(map(str, INERTIA))
        bodies += f'<inertial pos="0 0 {LENGTH / 2}" mass="{MASS}" diaginertia="{moments}"/>'
    return head + bodies + "</body>" * links + "</worldbody></mujoco>"


def pydy(links: int, end: float) -> Engine:
    """Return PyDy: KanesMethod, compiled by Cython, moved by SciPy's odeint."""
    system = import_module("pydy.system").System(spatial_chain(links).kane(), times=np.array([0.0, end]))
    names = {str(symbol): symbol for symbol in system.constants_symbols}
    system.constants = {names[name]: value for name, value in parameters(links).items() if name in names}
    # SymPy orders coordinates as the chain was written.
    states = zip([*system.coordinates, *system.speeds], [*start_angles(links), *np.zeros(links)], strict=True)
    system.initial_conditions = dict(states)
    system.generate_ode_function(generator="cython")

    def move(rtol: float) -> Motion:
        began = process_time()
        found = system.integrate(rtol=rtol, atol=_ATOL, mxstep=10**6)
        return Motion(process_time() - began, found[-1, :links])

    return Engine(_LADDER, move)


OURS: Final = "symbody"
# Label, packages that have to be installed, maker.
ENGINES: Final[Sequence[tuple[str, tuple[str, ...], Callable[[int, float], Engine]]]] = (
    (OURS, ("symbody",), ours),
    ("SciPy's DOP853, our function", ("scipy",), scipy_around_ours),
    ("SUNDIALS' Adams, our function", ("sksundae",), sundials_around_ours),
    ("MuJoCo, Runge-Kutta 4", ("mujoco",), mujoco),
    ("PyDy, Cython and odeint", ("pydy", "Cython", "setuptools"), pydy),
)


def installed() -> Iterator[tuple[str, Callable[[int, float], Engine] | None]]:
    """Yield the engines by label, None for one that is missing."""
    for label, packages, maker in ENGINES:
        yield label, maker if all(map(find_spec, packages)) else None


def worst(a: Any, b: Any) -> float:
    """Return the largest difference of angles [rad]."""
    return float(np.abs(np.asarray(a) - np.asarray(b)).max())
