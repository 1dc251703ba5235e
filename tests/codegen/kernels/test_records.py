"""Records of the kernel language: names of entries of arrays, in Python and as the reader sees them."""

import ctypes
import inspect

import numpy as np
import pytest
from numpy.typing import NDArray

from symbody.codegen.call_arguments import address
from symbody.codegen.kernels.reader import read_text
from symbody.codegen.kernels.source import KernelError
from symbody.codegen.kernels.tree import Apply, ArrayEntry, KernelTree, Literal, Part, Return, Type, Variable
from symbody.codegen.llvm.kernel_library import compile_kernels
from symbody.kernels.block import Run
from symbody.kernels.events.event_monitor import EventMonitor, MonitoredEvent, Zero
from symbody.kernels.language import Reals
from symbody.kernels.pack import pack
from symbody.kernels.record_layout import RecordLayout, exists, inline, pointer
from symbody.kernels.samples.sample_hold import SampleHold

HEAD = """
from symbody.kernels.events.event_monitor import EventMonitor, MonitoredEvent
from symbody.kernels.language import Reals
from symbody.kernels.record_layout import RecordLayout, exists, inline, pointer
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


class Pair(RecordLayout):
    count: int
    values: Reals = pointer("count")


class Nested(RecordLayout):
    first: Pair
    second: Pair
    own: Reals = pointer(2)
    other: Pair = pointer()


class Aligned(RecordLayout):
    alignment = 8
    pair: Pair
    values: Reals = pointer(3)
    more: Reals = pointer(3)


def test_what_records_in_line_store_lies_behind_the_whole() -> None:
    first, second = pack(Pair, count=2, values=[1.0, 2.0]), pack(Pair, count=1, values=[3.0])
    numbers = pack(
        Nested, first=first, second=second, own=[4.0, 5.0], other=pack(Pair, count=1, values=[6.0])
    )
    for entries in (np.concatenate([np.zeros(3), numbers]), [0.0] * 3 + numbers.tolist()):
        nested = Nested(entries, 3)
        assert [nested.first.values[k] for k in range(2)] == [1.0, 2.0]
        assert (nested.second.values[0], nested.own[1], nested.other.values[0]) == (3.0, 5.0, 6.0)
    inner = pack(Nested, first=first)
    assert Nested(inner).second.values.size == 0 and not exists(Nested(inner).other)  # type: ignore[attr-defined]
    assert dict(Nested.layout) == {
        "first.count": 0, "first.values": 1, "second.count": 2, "second.values": 3, "own": 4, "other": 5,
    }  # fmt: skip


class Filled(RecordLayout):
    before: float
    rates: Reals = inline(3)
    after: float


def test_reals_in_line_are_part_of_the_record() -> None:
    numbers = pack(Filled, before=1.0, rates=[2.0, 3.0], after=5.0)
    assert numbers.tolist() == [1.0, 2.0, 3.0, 0.0, 5.0]
    for entries in (numbers, numbers.tolist()):
        Filled(entries).rates[2] = 4.0
        assert entries[3] == 4.0 and Filled(entries).after == 5.0
    with pytest.raises(ValueError, match="rates has room for 3 reals, not for 4"):
        pack(Filled, rates=np.zeros(4))


def test_reals_in_line_lie_at_a_fixed_place() -> None:
    text = "from symbody.kernels.block import Run\ndef f(run: Run, k: int) -> float:\n    return run.method.nodes[k]\n"
    (end,) = read(text).body
    assert isinstance(end, Return) and isinstance(end.value, ArrayEntry)
    place = Literal(Run.layout["method.nodes"], Type.INTEGER)
    assert end.value.index == Apply("+", (place, Variable("k", Type.INTEGER)), Type.INTEGER)


def test_arrays_of_a_record_begin_at_multiples_of_its_alignment() -> None:
    numbers = pack(
        Aligned, pair=pack(Pair, count=1, values=[7.0]), values=[1.0, 2.0, 3.0], more=[4.0, 5.0, 6.0]
    )
    assert numbers.size % 8 == 0
    assert [int(numbers[Aligned.layout[name]]) for name in ("pair.values", "values", "more")] == [8, 16, 24]
    assert Aligned(numbers).pair.values[0] == 7.0 and Aligned(numbers).more[2] == 6.0


def sum_of_pairs(pairs: Reals, size: int, count: int) -> float:
    """Sum the sides of records that lie one behind the other, and count them in each."""
    total = 0.0
    for k in range(count):
        event = MonitoredEvent.view(pairs, k * size)
        event.recent_count = MonitoredEvent.size
        total = total + event.level + MonitoredEvent.view(pairs, k * size).way
    return total


def test_a_record_begins_at_a_place_of_an_array() -> None:
    size = MonitoredEvent.size + 2
    by_machine = np.zeros(3 * size)
    for k in range(3):
        by_machine[k * size :][: MonitoredEvent.size] = pack(MonitoredEvent, level=0.5, way=float(k))
    by_python = Reals(by_machine.tolist())
    compiled = compile_kernels(HEAD + inspect.getsource(sum_of_pairs), "kernels/case.py")["sum_of_pairs"]
    call = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64)(compiled)
    assert call(address(by_machine), size, 3) == sum_of_pairs(by_python, size, 3) == 4.5
    assert by_machine.tolist() == by_python.entries
    assert MonitoredEvent(by_machine, size).recent_count == MonitoredEvent.size


def test_a_record_of_an_array_is_a_view() -> None:
    numbers = pack(SampleHold, count=2, groups=1, start=0.5, values=[3.0, 4.0], steps=[0.1])
    hold = SampleHold(numbers)
    hold.next, np.asarray(hold.values)[:] = 0.25, [5.0, 6.0]
    again = SampleHold(numbers.copy())
    assert (again.start, again.next, again.count) == (0.5, 0.25, 2)
    assert np.asarray(again.values).tolist() == [5.0, 6.0] and len(np.asarray(again.new)) == 2
    assert not exists(EventMonitor(make_monitor()).closing)
