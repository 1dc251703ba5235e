"""Records of the kernel language: names of entries of arrays, in Python and as the reader sees them."""

from __future__ import annotations

import ctypes
import inspect

import numpy as np
import pytest
from numpy.typing import NDArray

from symbody.codegen.kernels.reader import read_text
from symbody.codegen.kernels.source import KernelError
from symbody.codegen.kernels.tree import Apply, ArrayEntry, KernelTree, Literal, Part, Return, Type, Variable
from symbody.codegen.llvm.kernel_library import compile_kernels
from symbody.kernels.events.event_monitor import EventMonitor, MonitoredEvent, Zero
from symbody.kernels.language import Reals
from symbody.kernels.pack import pack
from symbody.kernels.record import exists
from symbody.kernels.samples.sample_hold import SampleHold
from symbody.simulation.native.machine import address

HEAD = """
from symbody.kernels.events.event_monitor import EventMonitor, MonitoredEvent
from symbody.kernels.language import Reals
from symbody.kernels.record import exists
from symbody.kernels.samples.sample_hold import SampleHold
"""
HOLD = Variable("hold", Type.ARRAY)


def read(text: str) -> KernelTree:
    return read_text(HEAD + text, "kernels/case.py")["f"]


def result(expression: str, kind: str = "float") -> object:
    """The tree of what a kernel of a `SampleHold` returns."""
    (end,) = read(f"def f(hold: SampleHold, k: int) -> {kind}:\n    return {expression}\n").body
    assert isinstance(end, Return)
    return end.value


def entry(place: int) -> ArrayEntry:
    return ArrayEntry(HOLD, Literal(place, Type.INTEGER))


def whole(value: ArrayEntry) -> Apply:
    return Apply("integer", (value,), Type.INTEGER)


def test_fields_are_entries() -> None:
    assert result("hold.start") == entry(3)
    assert result("hold.groups", "int") == whole(entry(1))
    index = Apply("+", (whole(entry(8)), Variable("k", Type.INTEGER)), Type.INTEGER)
    assert result("hold.values[k]") == ArrayEntry(HOLD, index)


def test_stores_convert_whole_numbers() -> None:
    (store, _) = read(
        "def f(hold: SampleHold) -> int:\n    hold.recorded = hold.recorded + 1\n    return 0\n"
    ).body
    one = Apply("+", (whole(entry(5)), Literal(1, Type.INTEGER)), Type.INTEGER)
    assert (store.index, store.value) == (entry(5).index, Apply("real", (one,), Type.REAL))  # type: ignore[union-attr]


def test_a_stored_array_is_a_part_of_its_size() -> None:
    tree = read("def f(hold: SampleHold) -> float:\n    steps = hold.steps\n    return steps[0]\n")
    assert tree.body[0].value == Part(HOLD, whole(entry(11)), whole(entry(1)))  # type: ignore[union-attr]


REFUSALS = {
    "field": ("hold.stop", "has no field stop"),
    "no record": ("k.start", "k is no record"),
    "rows": ("hold.start.x", "hold.start is no record"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_what_is_no_field_is_rejected(case: str) -> None:
    expression, words = REFUSALS[case]
    with pytest.raises(KernelError, match=words):
        result(expression)


CALLED = "def g(event: MonitoredEvent) -> float:\n    return event.way\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            f"{CALLED}def f(hold: SampleHold) -> float:\n    return g(hold)\n",
            "event is a record MonitoredEvent",
        ),
        (
            "def f(monitor: EventMonitor) -> int:\n    monitor.values = 1\n    return 0\n",
            "values is no number",
        ),
        ("def f(monitor: EventMonitor) -> float:\n    return monitor.events\n", "take one of them"),
        ("def f(hold: SampleHold) -> int:\n    hold.room = 1.5\n    return 0\n", "float stands where int"),
        (
            "class Own:\n    x: float\ndef f(own: Own) -> float:\n    return own.x\n",
            "type is not in the kernel",
        ),
    ],
)
def test_what_does_not_fit_is_rejected(text: str, words: str) -> None:
    with pytest.raises(KernelError, match=words):
        read(text)


def walk_events(monitor: EventMonitor, out: Reals) -> int:
    """Count the events, mark each, and sum the times of what waits."""
    total = 0.0
    for k in range(monitor.event_count):
        event = monitor.events[k]
        event.hit = float(k) + event.level
        monitor.values[k] = event.hit
        total = total + monitor.pending[2 * k + 1].time
    monitor.happened = monitor.happened + monitor.event_count
    out[0] = total
    if exists(monitor.closing) or not exists(monitor.numbers):
        return -1
    return monitor.events[1].set_count


def make_monitor() -> NDArray[np.float64]:
    events = [pack(MonitoredEvent, level=0.5 + k, set_count=4 + k) for k in range(3)]
    waiting = [pack(Zero, time=10.0 + k, event=k) for k in range(24)]
    return pack(
        EventMonitor, event_count=3, states=2, happened=7, events=events, pending=waiting, numbers=[1.0]
    )


def test_python_and_machine_code_read_and_change_the_same_entries() -> None:
    by_machine, out = make_monitor(), np.zeros(1)
    by_python, sums = EventMonitor(make_monitor().tolist()), Reals.zeros(1)
    compiled = compile_kernels(HEAD + inspect.getsource(walk_events), "kernels/case.py")["walk_events"]
    call = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(compiled)
    assert call(address(by_machine), address(out)) == walk_events(by_python, sums) == 5
    assert by_machine.tolist() == by_python.entries
    assert out[0] == sums[0] == 11.0 + 13.0 + 15.0


def test_a_record_of_an_array_is_a_view() -> None:
    numbers = pack(SampleHold, count=2, groups=1, start=0.5, values=[3.0, 4.0], steps=[0.1])
    hold = SampleHold(numbers)
    hold.next, np.asarray(hold.values)[:] = 0.25, [5.0, 6.0]
    again = SampleHold(numbers.copy())
    assert (again.start, again.next, again.count) == (0.5, 0.25, 2)
    assert np.asarray(again.values).tolist() == [5.0, 6.0] and len(np.asarray(again.new)) == 2
    assert not exists(EventMonitor(make_monitor()).closing)
