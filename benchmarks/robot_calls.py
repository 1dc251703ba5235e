"""The tasks on robots, and who does them: by compiled loops, or called from Python.

A round of an engine gives the time of one call of each task over all states, in processor time.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from time import process_time
from types import MappingProxyType
from typing import Any, Final, Protocol

import numpy as np

import symbody as sb
from benchmarks.engines.call_loops.loops import Floats, c_compiler, nanoseconds_a_call
from benchmarks.engines.pinocchio_cpp.build import program
from benchmarks.engines.pinocchio_cpp.calls import PinocchioCalls
from benchmarks.robot_states import States


@dataclass(frozen=True, slots=True)
class Task:
    """What is computed: symbody's outputs, and words of Pinocchio's program, of which the fastest counts."""

    outputs: tuple[str, ...]
    words: tuple[str, ...]
    inverse: bool = False


TASKS: Final[Mapping[str, Task]] = MappingProxyType(
    {
        "forward dynamics": Task(("udot",), ("aba_world", "aba_local")),
        "inverse dynamics": Task(("inverse_dynamics",), ("rnea",), inverse=True),
        "mass matrix": Task(("mass_matrix",), ("crba_world", "crba_local")),
        "derivatives": Task(("udot", "d udot/d(q, u, r)"), ("derivatives",)),
    }
)

# A round of a task takes at least so long together, in so many passes over the states [s].
_ENOUGH: Final = 0.02
_PASSES: Final = 3
# Longer functions take C compilers minutes.
_LONG: Final = 12_000


class Caller(Protocol):
    """An engine at given states."""

    @property
    def name(self) -> str:
        """What stands in the table."""
        ...

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task it does [ns]."""
        ...


def median_of_passes(passed: Callable[[], float], states: int) -> float:
    """Return the median of the times of passes over the states, each given as time a call [ns]."""
    found: list[float] = []
    while len(found) < _PASSES or sum(found) * states < 1e9 * _ENOUGH:
        found.append(passed())
    return statistics.median(found)


class Compiled:
    """Symbody's functions of all tasks, by address."""

    name = "symbody"

    def __init__(self, states: States) -> None:
        self.states = states
        self.functions = {
            name: sb.compile(states.eqs, task.outputs, lanes=False) for name, task in TASKS.items()
        }

    def inputs(self, task: str) -> tuple[Floats, Floats, Floats]:
        """Return q, u, and r as the function of a task takes it."""
        states = self.states
        return states.q, states.u, states.r_and_udot if TASKS[task].inverse else states.r

    def results(self, task: str) -> list[Floats]:
        """Return the outputs of a task at all states."""
        found = self.functions[task](0.0, *self.inputs(task))
        return [np.asarray(x) for x in (found if len(TASKS[task].outputs) > 1 else [found])]

    def round(self, scratch: float = 0.0) -> dict[str, float]:
        """Return the time of one call of each task [ns]; `scratch` fills the scratch before."""
        count = len(self.states.q)
        return {
            name: median_of_passes(partial(nanoseconds_a_call, f, *self.inputs(name), scratch), count)
            for name, f in self.functions.items()
        }


class OnSubnormals:
    """Symbody's functions with the least number there is in their scratch, which slows arithmetic down."""

    name = "scratch of 5e-324"

    def __init__(self, ours: Compiled) -> None:
        self._ours = ours

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        return self._ours.round(5e-324)


class InCpp:
    """Pinocchio's program: the recursion and the convention that is faster here."""

    name = "Pinocchio C++"

    def __init__(self, calls: PinocchioCalls, passes: int = 15) -> None:
        self._calls, self._passes = calls, passes
        self.seen: dict[str, str] = {}

    def results(self) -> tuple[Floats, Floats]:
        """Return accelerations for the efforts of the states, and efforts for accelerations of that size."""
        return self._calls.results()

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]; `seen` tells which recursion was faster."""
        took = self._calls.nanoseconds(self._passes)
        self.seen = {name: min(task.words, key=took.__getitem__) for name, task in TASKS.items()}
        return {name: took[word] for name, word in self.seen.items()}


class InC:
    """C that CasADi writes from symbody's text."""

    name = "CasADi's C"

    def __init__(self, ours: Compiled) -> None:
        module = import_module("benchmarks.engines.casadi_calls")
        self._ours = ours
        short = [name for name, f in ours.functions.items() if f.operations <= _LONG]
        self.calls = {name: module.CasadiCalls(ours.states.eqs, list(TASKS[name].outputs)) for name in short}

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        count = len(self._ours.states.q)
        return {
            name: median_of_passes(partial(calls.nanoseconds, *self._ours.inputs(name)), count)
            for name, calls in self.calls.items()
        }


class InMujoco:
    """mj_forward and mj_inverse, which compute all positions, and more than is asked here."""

    name = "MuJoCo"

    def __init__(self, calls: Any, count: int) -> None:
        self.calls, self._count = calls, count

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        return {
            name: median_of_passes(partial(self.calls.nanoseconds, inverse), self._count)
            for name, inverse in (("forward dynamics", False), ("inverse dynamics", True))
        }


class FromPython:
    """An engine called from Python state by state; `calls` gives a function of the number of a state."""

    def __init__(self, name: str, calls: Mapping[str, Callable[[int], object]], count: int) -> None:
        self.name = name
        self.calls, self._count = calls, count

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        return {name: median_of_passes(partial(self._pass, f), self._count) for name, f in self.calls.items()}

    def _pass(self, call: Callable[[int], object]) -> float:
        start = process_time()
        for k in range(self._count):
            call(k)
        return 1e9 * (process_time() - start) / self._count


def python_symbody(ours: Compiled) -> FromPython:
    """Return symbody as a user calls it: rows of arrays."""

    def calls(task: str) -> Callable[[int], object]:
        f = ours.functions[task]
        q, u, r = (list(group) for group in ours.inputs(task))
        return lambda k: f(0.0, q[k], u[k], r[k])

    return FromPython("symbody", {name: calls(name) for name in TASKS}, len(ours.states.q))


def python_pinocchio(states: States) -> FromPython:
    """Return Pinocchio as a user calls it."""
    pin: Any = import_module("pinocchio")
    model = states.pin_model
    data = model.createData()
    q, v, tau, a = (list(x) for x in (states.pin_q, states.pin_v, states.pin_tau, states.pin_a))
    return FromPython(
        "Pinocchio",
        {
            "forward dynamics": lambda k: pin.aba(model, data, q[k], v[k], tau[k]),
            "inverse dynamics": lambda k: pin.rnea(model, data, q[k], v[k], a[k]),
            "mass matrix": lambda k: pin.crba(model, data, q[k]),
            "derivatives": lambda k: pin.computeABADerivatives(model, data, q[k], v[k], tau[k]),
        },
        len(q),
    )


def python_mujoco(peer: InMujoco) -> FromPython:
    """Return MuJoCo as a user calls it, with results copied as the others return new arrays."""
    calls = peer.calls
    return FromPython(
        "MuJoCo",
        {
            "forward dynamics": lambda k: calls.result(k),
            "inverse dynamics": lambda k: calls.result(k, inverse=True),
        },
        len(calls.q),
    )


def cpp_program(states: States, folder: Path) -> tuple[InCpp | None, str]:
    """Return Pinocchio's program at the states, or why there is none."""
    if states.pin_model is None:
        return None, "Pinocchio is left out: pin is not installed"
    found, why = program()
    if found is None:
        return None, why
    calls = PinocchioCalls.of(found, folder, states.pin_model, states.pin_q, states.pin_v, states.pin_tau)
    return InCpp(calls), ""


def casadi_c(ours: Compiled) -> tuple[InC | None, str]:
    """Return CasADi's C, or why there is none."""
    if find_spec("casadi") is None:
        return None, "CasADi is left out: casadi is not installed"
    if c_compiler() is None:
        return None, "CasADi is left out: there is no C compiler"
    return InC(ours), f"CasADi's C of functions longer than {_LONG} operations is not compiled"


def mujoco_calls(states: States, floating: bool) -> tuple[InMujoco | None, str]:
    """Return MuJoCo, or why there is none."""
    if find_spec("mujoco") is None:
        return None, "MuJoCo is left out: mujoco is not installed"
    module = import_module("benchmarks.engines.mujoco_calls")
    try:
        return InMujoco(module.MujocoCalls(states, floating), len(states.q)), ""
    except (ValueError, KeyError) as error:
        return None, f"MuJoCo does not read the robot: {str(error).splitlines()[0]}"
