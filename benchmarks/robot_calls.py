"""The tasks on robots, and who does them: by compiled loops, or called from Python.

A round of an engine gives the time of one call of each task over all states, in processor time. What
generates code for one robot says what that took, also in processor time: from the model to a function that
can be called, with the compilers it started.
"""

from __future__ import annotations

import ctypes
import os
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
from benchmarks.engines.call_loops.loops import Floats, c_compiler, compiled_c, nanoseconds_a_call
from benchmarks.engines.pinocchio_cpp.build import CALLS, GENERATE, program
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
LONGEST: Final = 12_000
# XLA compiles straight lines of more operations for minutes.
LONGEST_JAX: Final = 3_000


class Caller(Protocol):
    """An engine at given states."""

    @property
    def name(self) -> str:
        """What stands in the table."""
        ...

    @property
    def prepared(self) -> Mapping[str, float]:
        """What it took to generate and compile the function of each task [s]; empty for a library."""
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


def spent() -> float:
    """Return the processor time of this process and of those that it called [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class Compiled:
    """Symbody's functions of all tasks, by address."""

    name = "symbody"

    def __init__(self, states: States) -> None:
        self.states = states
        self.functions, self.prepared = {}, {}
        for name, task in TASKS.items():
            start = spent()
            self.functions[name] = sb.compile(states.fresh(), task.outputs, lanes=False)
            self.prepared[name] = spent() - start

    def inputs(self, task: str) -> tuple[Floats, Floats, Floats]:
        """Return q, u, and r as the function of a task takes it."""
        states = self.states
        return states.q, states.u, states.r_and_udot if TASKS[task].inverse else states.r

    def results(self, task: str) -> list[Floats]:
        """Return the outputs of a task at all states."""
        found = self.functions[task](0.0, *self.inputs(task))
        return [np.asarray(x) for x in (found if len(TASKS[task].outputs) > 1 else [found])]

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        return {
            name: median_of_passes(partial(self._pass, name), len(self.states.q)) for name in self.functions
        }

    def _pass(self, task: str) -> float:
        f = self.functions[task]
        out = sum(len(output.values) for output in f.sequence.outputs)
        return nanoseconds_a_call(
            f.address, *self.inputs(task), out=out, work=f.work_size, constants=f.constants()
        )


class OurC:
    """The C that `generate_code` writes, by the machine's compiler."""

    name = "symbody's C"

    def __init__(self, ours: Compiled, folder: Path) -> None:
        self._ours = ours
        self.functions: dict[str, tuple[Any, int, int]] = {}
        self.prepared = {}
        for name in [name for name, f in ours.functions.items() if f.operations <= LONGEST]:
            f = ours.functions[name]
            start = spent()
            text = sb.generate_code(ours.states.fresh(), TASKS[name].outputs, "c", parameters={})
            library, _ = compiled_c(text, f"ours_{name.split()[0]}", folder)
            self.prepared[name] = spent() - start
            size = sum(len(output.values) for output in f.sequence.outputs)
            self.functions[name] = (library.f, size, int(library.f_work_size()))

    def results(self, task: str, states: int) -> list[Floats]:
        """Return the outputs of a task at the first states, flat and side by side."""
        address, size, work = self.functions[task]
        found = np.zeros((states, size))
        scratch, pointer = np.zeros(max(1, work)), ctypes.c_void_p
        t = np.zeros(1)
        for k in range(states):
            groups = [t, *(np.ascontiguousarray(x[k]) for x in self._ours.inputs(task))]
            addresses = [pointer(x.ctypes.data) for x in groups]
            address(*addresses, None, None, pointer(found[k].ctypes.data), pointer(scratch.ctypes.data))
        return [found]

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        count = len(self._ours.states.q)
        return {name: median_of_passes(partial(self._pass, name), count) for name in self.functions}

    def _pass(self, task: str) -> float:
        function, size, work = self.functions[task]
        address = ctypes.cast(function, ctypes.c_void_p).value
        return nanoseconds_a_call(address, *self._ours.inputs(task), out=size, work=work)


class InCpp:
    """Pinocchio's program: the recursion and the convention that is faster here."""

    name = "Pinocchio C++"
    prepared: Mapping[str, float] = MappingProxyType({})

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
    """Pinocchio's algorithms of the robot as C that CasADi writes."""

    name = "Pinocchio by CasADi"

    def __init__(self, states: States, generator: Path, model: Path, folder: Path) -> None:
        module = import_module("benchmarks.engines.casadi_calls")
        self._states = states
        self.calls: dict[str, Any] = {}
        self.prepared, self.long = {}, {}
        for name in TASKS:
            word = name.replace(" ", "_")
            start = spent()
            length = module.instructions(generator, model, word, folder)
            if length > LONGEST:
                self.long[name] = length
                continue
            self.calls[name] = module.CasadiCalls(folder / f"{word}.c")
            self.prepared[name] = spent() - start

    def inputs(self, task: str) -> tuple[Floats, Floats, Floats]:
        """Return Pinocchio's q, v, and efforts or accelerations."""
        states = self._states
        return states.pin_q, states.pin_v, states.pin_a if TASKS[task].inverse else states.pin_tau

    def round(self) -> dict[str, float]:
        """Return the time of one call of each task [ns]."""
        count = len(self._states.q)
        return {
            name: median_of_passes(partial(calls.nanoseconds, *self.inputs(name)), count)
            for name, calls in self.calls.items()
        }

    def from_python(self) -> FromPython:
        """Return the same functions as they are called from Python."""
        calls = {name: f.from_python(*self.inputs(name)) for name, f in self.calls.items()}
        return FromPython(self.name, calls, len(self._states.q), self.prepared)


class InMujoco:
    """mj_forward and mj_inverse, which compute all positions, and more than is asked here."""

    name = "MuJoCo"
    prepared: Mapping[str, float] = MappingProxyType({})

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

    def __init__(
        self,
        name: str,
        calls: Mapping[str, Callable[[int], object]],
        count: int,
        prepared: Mapping[str, float] = MappingProxyType({}),
    ) -> None:
        self.name, self.prepared = name, prepared
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

    return FromPython("symbody", {name: calls(name) for name in TASKS}, len(ours.states.q), ours.prepared)


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
    found, why = program(CALLS)
    if found is None:
        return None, why
    calls = PinocchioCalls.of(found, folder, states.pin_model, states.pin_q, states.pin_v, states.pin_tau)
    return InCpp(calls), ""


def casadi_c(states: States, folder: Path) -> tuple[InC | None, str]:
    """Return CasADi's C of Pinocchio's algorithms, or why there is none."""
    if states.pin_model is None or find_spec("casadi") is None:
        return None, "Pinocchio by CasADi is left out: pin or casadi is not installed"
    if c_compiler() is None:
        return None, "Pinocchio by CasADi is left out: there is no C compiler"
    found, why = program(GENERATE)
    if found is None:
        return None, why
    model = folder / "model.txt"
    states.pin_model.saveToText(str(model))
    peer = InC(states, found, model, folder)
    long = ", ".join(f"{name} {length}" for name, length in peer.long.items())
    return peer, f"CasADi's C longer than {LONGEST} instructions is not compiled: {long}" if long else ""


def jax_calls(ours: Compiled, mujoco: InMujoco | None) -> tuple[list[FromPython], str]:
    """Return forward dynamics by the JAX that `generate_code` writes, and by MJX, compiled by XLA."""
    if find_spec("jax") is None or mujoco is None or find_spec("mujoco.mjx") is None:
        return [], "JAX and MJX are left out: jax or mujoco-mjx is not installed, or MuJoCo left out"
    module = import_module("benchmarks.engines.jax_calls")
    found = [FromPython("MJX", *module.mjx(mujoco.calls))]
    if ours.functions["forward dynamics"].operations > LONGEST_JAX:
        return found, f"symbody's JAX is not compiled beyond {LONGEST_JAX} operations: XLA takes minutes"
    return [FromPython("symbody's JAX", *module.ours(ours.states)), *found], ""


def mujoco_calls(states: States, floating: bool) -> tuple[InMujoco | None, str]:
    """Return MuJoCo, or why there is none."""
    if find_spec("mujoco") is None:
        return None, "MuJoCo is left out: mujoco is not installed"
    module = import_module("benchmarks.engines.mujoco_calls")
    try:
        return InMujoco(module.MujocoCalls(states, floating), len(states.q)), ""
    except (ValueError, KeyError) as error:
        return None, f"MuJoCo does not read the robot: {str(error).splitlines()[0]}"
