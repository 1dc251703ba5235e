"""Engines as a user's loop calls them: a motion of the spatial chain from given angles, with a given mass.

``python -m benchmarks.engines.around LABEL SECONDS`` makes an engine in a process of its own, moves once, and
prints the processor time of the process from its beginning, with that of the compilers it called.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
# Takes angles at the beginning, the mass of the first body and the end [s]; returns the angles there.
Move = Callable[[Floats, float, float], Floats]

RTOL, ATOL = 1e-8, 1e-10
STEP: Final = 0.002  # of MuJoCo [s], its default


def ours(links: int) -> Move:
    """Return `simulate`, as a user calls it."""
    sb, moving = import_module("symbody"), import_module("benchmarks.engines.moving")
    mechanisms = import_module("benchmarks.mechanisms")
    eqs = sb.form_equations(mechanisms.spatial_chain(links).model())
    given = moving.parameters(links)

    def move(start: Floats, mass: float, end: float) -> Floats:
        first = dict(zip(eqs.coordinate_names, start.tolist(), strict=True))
        values = given | {"m0": mass}
        run = sb.simulate(eqs, end, first, times=[0.0, end], parameters=values, rtol=RTOL, atol=ATOL)
        return np.asarray(run.q[:, -1])

    return move


def scipy_around_ours(links: int) -> Move:
    """Return SciPy's DOP853 around symbody's function, the mass of the first body its free parameter."""
    sb, moving = import_module("symbody"), import_module("benchmarks.engines.moving")
    mechanisms, solve_ivp = (
        import_module("benchmarks.mechanisms"),
        import_module("scipy.integrate").solve_ivp,
    )
    eqs = sb.form_equations(mechanisms.spatial_chain(links).model())
    f = sb.compile(eqs, "xdot", parameters=moving.parameters(links), free=["m0"])

    def move(start: Floats, mass: float, end: float) -> Floats:
        p, r = np.array([mass]), np.zeros(0)
        x = np.concatenate([np.zeros(links), start])
        done = solve_ivp(
            lambda t, x: f.of_state(t, x, r, p), (0.0, end), x, "DOP853", [end], rtol=RTOL, atol=ATOL
        )
        return np.asarray(done.y[links:, -1])

    return move


def mujoco(links: int) -> Move:
    """Return MuJoCo's Runge-Kutta method of order 4, stepped from Python."""
    library, moving = import_module("mujoco"), import_module("benchmarks.engines.moving")
    model = library.MjModel.from_xml_string(moving.mujoco_text(links))
    model.opt.timestep = STEP
    data = library.MjData(model)

    def move(start: Floats, mass: float, end: float) -> Floats:
        library.mj_resetData(model, data)
        model.body_mass[1] = mass
        library.mj_setConst(model, data)
        data.qpos[:] = start
        for _ in range(round(end / STEP)):
            library.mj_step(model, data)
        return np.array(data.qpos)

    return move


def pydy(links: int) -> Move:
    """Return PyDy: KanesMethod, compiled by Cython, moved by SciPy's odeint."""
    moving, mechanisms = import_module("benchmarks.engines.moving"), import_module("benchmarks.mechanisms")
    system = import_module("pydy.system").System(mechanisms.spatial_chain(links).kane(), times=[0.0, 1.0])
    names = {str(symbol): symbol for symbol in system.constants_symbols}
    given = moving.parameters(links)
    system.constants = {names[name]: value for name, value in given.items() if name in names}
    system.generate_ode_function(generator="cython")

    def move(start: Floats, mass: float, end: float) -> Floats:
        states = [*system.coordinates, *system.speeds]
        system.initial_conditions = dict(zip(states, [*start, *np.zeros(links)], strict=True))
        system.constants[names["m0"]] = mass
        system.times = np.array([0.0, end])
        done = system.integrate(rtol=RTOL, atol=ATOL, mxstep=10**6)
        return np.asarray(done[-1, :links])

    return move


OURS: Final = "symbody"
# Label, package that has to be installed, maker.
AROUND: Final[Sequence[tuple[str, str, Callable[[int], Move]]]] = (
    (OURS, "symbody", ours),
    ("SciPy, our function", "scipy", scipy_around_ours),
    ("MuJoCo, steps of 2 ms", "mujoco", mujoco),
    ("PyDy", "pydy", pydy),
)


def available() -> Iterator[tuple[str, Callable[[int], Move] | None]]:
    """Yield the engines by label, None for one that is missing."""
    for label, package, maker in AROUND:
        yield label, maker if find_spec(package) else None


def start_angles(links: int) -> Floats:
    """Return where the chain begins, at rest."""
    return 0.3 + 0.1 * np.arange(links, dtype=float)


def process_seconds(label: str, links: int, cache: str) -> float:
    """Return the processor time of a process that makes one engine and moves once for a second."""
    command = [sys.executable, "-m", "benchmarks.engines.around", label, str(links)]
    variables = os.environ | {"SYMBODY_CACHE": cache}
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=variables)
    return float(done.stdout.split()[-1])


def main(label: str, links: int) -> None:
    """Move once, and print the processor time of this process and of those that it called."""
    (maker,) = (maker for name, _, maker in AROUND if name == label)
    maker(links)(start_angles(links), 1.0, 1.0)
    spent = os.times()
    print(spent.user + spent.system + spent.children_user + spent.children_system)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]))
