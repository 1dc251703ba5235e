"""All public functions at once in one process that has done nothing before; exits with an error if two differ.

Run as ``python -X dev -m tests.threads.every_call THREADS CALLS``: each thread makes so many of the calls, all
begin with a simulation and go on with different ones. Half of the threads share one set of equations, the others
form their own.
"""

from __future__ import annotations

import faulthandler
import os
import sys
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ["MPLBACKEND"] = "Agg"

import symbody as sb  # noqa: E402

EXAMPLES = Path(__file__).parents[2] / "examples"
SHARED = threading.Lock()
sys.setswitchinterval(1e-4)  # threads meet more often
SLIDER_CRANK = EXAMPLES / "slider_crank" / "slider_crank.toml"
OSCILLATOR = EXAMPLES / "spring_mass_damper" / "spring_mass_damper.toml"
ROBOT = EXAMPLES / "robot_arm" / "robot_arm.urdf"

Call = Callable[[sb.EquationSet], Any]


def loop() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(SLIDER_CRANK))


def oscillator() -> sb.EquationSet:
    return sb.form_equations(sb.load_model(OSCILLATOR))


def _batch(eqs: sb.EquationSet) -> Any:
    f = sb.compile(eqs, "udot", lanes=True)
    q = [[0.3 + 0.01 * k, -0.1, 1.3][: len(eqs.coordinate_names)] for k in range(40)]
    return f(0.0, q, [[0.1] * len(eqs.speed_names)] * 40, [[0.0] * len(eqs.input_names)] * 40)


def _point(eqs: sb.EquationSet) -> Any:
    f = sb.compile(eqs, ["mass_matrix", "forcing"])
    state = sb.assemble(eqs, {"theta": 0.6}, guess={"s": 4})
    q, u = list(state.q.values()), list(state.u.values())
    return [part.tolist() for _ in range(20) for part in f(0.0, q, u, [0.0])][-2:]


def _events(eqs: sb.EquationSet) -> Any:
    run = sb.simulate(eqs, 0.4, initial={"theta": 0.5}, guess={"s": 4}, events=[sb.Event("theta - 0.2")])
    return [run["theta"][-1], run["energy"][-1], len(run.events), run.at(0.1)["theta"]]


def _urdf(_: sb.EquationSet) -> Any:
    eqs = sb.form_equations(sb.load_urdf(ROBOT))
    n_q, n_u, n_r = len(eqs.coordinate_names), len(eqs.speed_names), len(eqs.input_names)
    return sb.compile(eqs, "d udot/d(q, u)")(0.0, [0.1] * n_q, [0.2] * n_u, [0.0] * n_r)


def _files(eqs: sb.EquationSet) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "model.toml")
        sb.save_model(eqs.model, path)
        run = sb.simulate(eqs, 0.05, initial={"theta": 0.5}, guess={"s": 4})
        sb.save_plot(sb.plot(run, "theta"), Path(folder, "motion.svg"))
        run.save(Path(folder, "run.npz"))
        return [sb.load_model(path).name, sb.Trajectory.load(Path(folder, "run.npz"))["theta"][-1]]


def _inverse(eqs: sb.EquationSet) -> Any:
    return sb.inverse_dynamics(eqs, {"theta": "0.5 + t"}, "F", [0.0, 0.1], guess={"s": 4})["F"]


CALLS: dict[str, Call] = {
    "simulate": lambda eqs: sb.simulate(eqs, 0.3, initial={"theta": 0.5}, guess={"s": 4})["theta"][-1],
    "point": _point,
    "batch": _batch,
    "stiff": lambda eqs: sb.simulate(eqs, 0.1, initial={"theta": 0.5}, guess={"s": 4}, integrator=sb.Stiff())[
        "theta"][-1],
    "events": _events,
    "partition": lambda eqs: sb.simulate(eqs, 0.1, initial={"theta": 0.5}, guess={"s": 4},
                                         constraints=sb.Partition())["theta"][-1],
    "sweep": lambda eqs: sb.sweep(eqs, 0.1, {"m1": [1.0, 1.5, 2.0]}, initial={"theta": 0.5}, guess={"s": 4})[
        "theta"][:, -1],
    "formulas": lambda eqs: [str(eqs.mass_matrix), str(eqs.dynamic_equations()), str(eqs.A.shape)],
    "texts": lambda eqs: [sb.generate_code(eqs, "udot", word) for word in ("c", "python", "julia", "matlab")],
    "assemble": lambda eqs: list(sb.assemble(eqs, {"theta": 0.6}, guess={"s": 4}).q.values()),
    "linearize": lambda _: sb.linearize(oscillator()).A,
    "equilibrium": lambda _: sb.find_equilibrium(oscillator()).verdict,
    "freedoms": lambda eqs: [eqs.degrees_of_freedom, str(sb.redundancy(eqs)), str(eqs.independent_speeds)],
    "ratios": lambda eqs: sb.velocity_ratios(eqs, "theta").at(sb.assemble(eqs, {"theta": 0.6}, guess={"s": 4})),
    "trace": lambda eqs: sb.trace_positions(eqs, {"theta": [0.1, 0.2]}, guess={"s": 4})["s"],
    "singular": lambda eqs: len(sb.singular_configurations(eqs, "theta", {"theta": (0.1, 1.0)}, guess={"s": 4})),
    "inverse": _inverse,
    "urdf": _urdf,
    "files": _files,
    "others": lambda _: str([getattr(sb, name) for name in sb.__all__]),
}  # fmt: skip
# Those that only read what others may have made already are also called for equations that all share.
OWN_MODEL = {"linearize", "equilibrium", "urdf", "others"}


def main(threads: int, calls: int) -> int:
    """Make `calls` calls in each of the threads and compare what they give."""
    begin = threading.Barrier(threads)
    shared: list[sb.EquationSet] = []
    found: list[dict[str, str]] = [{} for _ in range(threads)]
    faults: list[str] = []

    def work(place: int) -> None:
        first, *others = CALLS
        names = [first, *others[place % len(others) :], *others[: place % len(others)]][:calls]
        begin.wait()
        with SHARED:  # formed by the first; what it gives is made by all at once
            if not shared:
                shared.append(loop())
        for name in names:
            eqs = shared[0] if place % 2 or name in OWN_MODEL else loop()
            try:
                found[place][name] = repr(CALLS[name](eqs))
            except BaseException as error:
                faults.append(f"{name} in thread {place}: {type(error).__name__}: {error}")

    workers = [threading.Thread(target=work, args=(place,)) for place in range(threads)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    for name in CALLS:
        values = {results[name] for results in found if name in results}
        if len(values) > 1:
            faults.append(f"{name} differs: {values}"[:400])
    print("\n".join(faults) or "all equal")
    return len(faults)


if __name__ == "__main__":
    faulthandler.enable()
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2])))
