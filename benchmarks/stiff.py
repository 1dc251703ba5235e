"""Work beside precision of stiff motions: elastic segments and a bushing, by all integrators."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import symbody as sb
from benchmarks.table import Table, ratio_text, seconds_text
from benchmarks.timing import Settings, processor_seconds
from symbody.simulation.methods.state_jacobian import STATE_JACOBIAN, with_state_jacobian

Floats = NDArray[np.float64]

# The beam of Kane, Ryan and Banerjee 1987, hinged and released level: 10 m, 1.2 kg/m, 14 kN m^2.
_LENGTH: Final = 10.0
_MASS: Final = 12.0
_BENDING: Final = 1.4e4
_GRAVITY: Final = 9.81
_END: Final = 2.0
_MOST_STEPS: Final = 20_000  # of compiled loops; those of CVODE pass through Python
_MOST_OF_CVODE: Final = 5_000


class Problem(NamedTuple):
    """A motion of `_END` seconds, and the places [m] or angles at its end by which it is judged."""

    name: str
    eqs: sb.EquationSet
    places: Callable[[Floats], Floats]


class Point(NamedTuple):
    """What one setting of a method costs [s of processor time] and how far its end is off [m or rad]."""

    method: str
    setting: str
    error: float
    seconds: float


Run = Callable[[], Floats]


def problems() -> Iterator[Problem]:
    """Yield the motions, their equations formed."""
    for count in (8, 16, 32):
        yield segments(count, 0.0)
    yield segments(16, 2e-3)
    yield bushing()


def segments(count: int, delay: float) -> Problem:
    """Return a beam of rigid segments with springs, damped by so many seconds times their stiffness."""
    length, mass = _LENGTH / count, _MASS / count
    inertia = (1e-6, mass * length**2 / 12.0, mass * length**2 / 12.0)
    ends = {"a": sb.Frame(at=(-0.5 * length, 0, 0)), "b": sb.Frame(at=(0.5 * length, 0, 0))}
    stiffness = _BENDING / length
    parts: list[Any] = []
    before = "ground"
    for k in range(count):
        parts.append(sb.Body(f"S{k}", mass=mass, inertia=inertia, frames=ends))
        torque = sb.Drive(stiffness=stiffness, damping=delay * stiffness) if k else None
        parts.append(sb.Revolute(f"j{k}", before, f"S{k}.a", axis="z", coordinate=f"q{k}", torque=torque))
        before = f"S{k}.b"
    eqs = sb.form_equations(sb.Model("beam", parts, gravity=(0, -_GRAVITY, 0)))

    def tip(q: Floats) -> Floats:
        angles = np.cumsum(q)
        return length * np.array([np.cos(angles).sum(), np.sin(angles).sum()])

    return Problem(f"{count} segments{', damped' if delay else ''}", eqs, tip)


def bushing() -> Problem:
    """Return a pendulum of 2 kg whose pivot is a bushing of 1e7 N/m and 1e4 N s/m."""
    arm = sb.Body("Arm", mass=2, inertia=(0, 0, 0.5), frames={"pivot": sb.Frame(at=(0, 1, 0))})
    rubber = sb.Drive(stiffness=1e7, damping=1e4)
    force = {"x": rubber, "y": rubber}
    mount = sb.Planar("mount", "ground", "Arm.pivot", coordinates=["x", "y", "theta"], force=force)
    model = sb.Model("bushing", [arm, mount], gravity=(0, -_GRAVITY, 0), initial={"theta": 1.5})
    return Problem("bushing", sb.form_equations(model), lambda q: q[2:])


def methods(problem: Problem) -> Iterator[tuple[str, Sequence[tuple[str, Run]]]]:
    """Yield every method with its settings, the loosest first."""
    rtols = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    steps = (8e-3, 4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4)
    yield "Explicit", [(f"rtol {r:.0e}", _simulate(problem, sb.Explicit(), r)) for r in (*rtols, 1e-7)]
    yield (
        "GeneralizedAlpha(step=h)",
        [(f"h {1e3 * h:g} ms", _simulate(problem, sb.GeneralizedAlpha(step=h), 1e-5)) for h in steps],
    )
    yield (
        "GeneralizedAlpha",
        [(f"rtol {r:.0e}", _simulate(problem, sb.GeneralizedAlpha(), r)) for r in rtols],
    )
    yield "Stiff (CVODE)", [(f"rtol {r:.0e}", _simulate(problem, sb.Stiff(), r)) for r in rtols]
    yield "SciPy Radau", [(f"rtol {r:.0e}", _radau(problem, r)) for r in rtols]


def _simulate(problem: Problem, integrator: Any, rtol: float) -> Run:
    """Return a motion by symbody; absolute tolerances in rad, m and per second."""

    def run() -> Floats:
        motion = sb.simulate(
            problem.eqs,
            _END,
            times=[_END],
            integrator=integrator,
            rtol=rtol,
            atol=rtol,
            max_steps=_MOST_OF_CVODE if isinstance(integrator, sb.Stiff) else _MOST_STEPS,
        )
        return problem.places(motion.q[:, -1]) if motion.success else np.full(2, np.nan)

    return run


def _radau(problem: Problem, rtol: float) -> Run:
    """Return the same by SciPy, with compiled slopes and derivatives."""
    eqs = with_state_jacobian(problem.eqs, {}, ())
    slopes, derivatives = sb.compile(eqs, "xdot"), sb.compile(eqs, STATE_JACOBIAN, quick=True)
    n_u = len(eqs.speed_names)
    first = sb.simulate(problem.eqs, 0.0)
    start = np.concatenate([first.u[:, 0], first.q[:, 0]])

    def run() -> Floats:
        found = solve_ivp(
            lambda t, x: slopes(t, x[n_u:], x[:n_u]), (0.0, _END), start, "Radau", rtol=rtol, atol=rtol,
            jac=lambda t, x: derivatives(t, x[n_u:], x[:n_u]),
        )  # fmt: skip
        return problem.places(found.y[n_u:, -1]) if found.success else np.full(2, np.nan)

    return run


def measure(problem: Problem, settings: Settings) -> list[Point]:
    """Return all points of a problem; a method is left when one run takes longer than the limit."""
    best = _best(problem)
    points = []
    for method, runs in methods(problem):
        for setting, run in runs:
            end = run()  # the first compiles
            spent = [processor_seconds(run)]
            if spent[0] < 0.5:
                spent += [processor_seconds(run) for _ in range(settings.rounds - 1)]
            error = float(np.abs(end - best).max())
            if np.isfinite(error):
                points.append(Point(method, setting, error, sorted(spent)[len(spent) // 2]))
            if spent[0] > settings.limit:
                break
    return points


def _best(problem: Problem) -> Floats:
    """Return the places of a motion far more exact than all others."""
    motion = sb.simulate(problem.eqs, _END, times=[_END], integrator=sb.Explicit(), rtol=1e-11, atol=1e-12)
    return problem.places(motion.q[:, -1])


def measurements(settings: Settings) -> Mapping[str, list[Point]]:
    """Return the points of all problems."""
    return {problem.name: measure(problem, settings) for problem in problems()}


def table(name: str, points: Sequence[Point]) -> Table:
    """Return the table of one problem."""
    rows = []
    for point in points:
        rivals = [other.seconds for other in points if other.error <= point.error]
        time = seconds_text(point.seconds) + ratio_text(point.seconds, min(rivals))
        rows.append((point.method, point.setting, f"{point.error:.1e}", time))
    notes = (f"processor time of a whole call for {_END:g} s; in brackets over the fastest that is as exact",)
    return Table(f"stiff: {name}", ("integrator", "setting", "error [m, rad]", "time"), tuple(rows), notes)


def tables(settings: Settings) -> Iterator[Table]:
    """Yield a table for each problem."""
    for problem in problems():
        yield table(problem.name, measure(problem, settings))
