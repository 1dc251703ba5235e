"""What runs in a worker: one task after the other, named on a pipe, until the pipe or its parent is gone."""

from __future__ import annotations

import json
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from types import MappingProxyType
from typing import Any, Final

from symbody.builder.page_problems import fault_problem, page_problems
from symbody.builder.task_failure import Report, TaskFailure
from symbody.errors import SymbodyError
from symbody.expr.deadline import watch_stages
from symbody.memory import memory_size

_SHARE: Final = 0.8  # of the memory, for the data of one process
# Where each task is: modules that are loaded by workers only.
_TASKS: Final = MappingProxyType(
    {
        "check": "symbody.builder.tasks.check:check_model",
        "redraw": "symbody.builder.tasks.redraw:redraw_model",
        "pose": "symbody.builder.tasks.pose:find_pose",
        "drag": "symbody.builder.tasks.drag:drag_body",
        "equations": "symbody.builder.tasks.equations:derive_equations",
        "equation_tab": "symbody.builder.tasks.equations:equation_tab",
        "simulate": "symbody.builder.tasks.simulation:simulate_model",
        "outputs": "symbody.builder.tasks.simulation:more_curves",
        "equilibrium": "symbody.builder.tasks.analyses:equilibrium",
        "modes": "symbody.builder.tasks.analyses:modes",
        "singular": "symbody.builder.tasks.analyses:singular_positions",
        "ratios": "symbody.builder.tasks.transmission:ratios",
        "torque": "symbody.builder.tasks.transmission:torque",
        "inverse": "symbody.builder.tasks.analyses:inverse",
        "sweep": "symbody.builder.tasks.sweeps:sweep_parameter",
        "export": "symbody.builder.tasks.exports:export_model",
    }
)

# Their results go to the page as they are: written as JSON here, the server hands on bytes.
_AS_JSON: Final = frozenset({"check", "redraw", "pose", "drag"})


def run_worker(pipe: Connection) -> None:
    """Run tasks until there are no more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the parent, which ends its workers
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _limit_memory()
    import_module("symbody.builder.tasks.check")  # the slow part, while nobody waits yet
    pipe.send(("ready",))
    while True:
        try:
            name, payload = pipe.recv()
        except (EOFError, OSError):
            return

        def report(stage: str, percent: int | None, /) -> None:
            pipe.send(("stage", stage, percent))

        pipe.send(_outcome(name, payload, report))


def _outcome(name: str, payload: dict[str, Any], report: Report) -> tuple[str, Any]:
    """Return what became of a task: nothing that a task raises ends the worker."""
    try:
        module, _, function = _TASKS[name].partition(":")
        with _report_stages(report):
            result = getattr(import_module(module), function)(payload, report)
            return "done", _json(result) if name in _AS_JSON else result
    except TaskFailure as failure:
        return "failed", failure.problems
    except SymbodyError as error:
        return "failed", page_problems(error.problems, payload.get("data") or {})
    except Exception as error:  # a fault of ours: it is told without the insides of the server
        return "failed", [fault_problem(error)]


def _json(value: Any) -> bytes:
    return json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


@contextmanager
def _report_stages(report: Report) -> Iterator[None]:
    with watch_stages(lambda stage: report(stage, None)):
        yield


def _limit_memory() -> None:
    """Let a model that is too large for this computer fail here, before the whole computer stands still."""
    memory = memory_size()
    with suppress(ImportError, AttributeError, ValueError, OSError):  # not everywhere
        resource = import_module("resource")
        _, highest = resource.getrlimit(resource.RLIMIT_DATA)
        if memory is not None:
            resource.setrlimit(resource.RLIMIT_DATA, (int(_SHARE * memory), highest))


def _end_with_parent() -> None:
    """End this process when its parent has ended, however that happened and whatever is being computed."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
