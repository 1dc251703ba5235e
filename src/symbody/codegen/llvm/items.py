"""Programs for several items in LLVM: where their numbers lie, and the loop that computes some items at once.

Row by row of the numbers that items have, the items stand side by side in the work array, so that a register
takes several of them. What one program leaves is read by the next where it lies. Where a function computes
several points at once, its lanes are points, and items come one after the other.

The last register of a row reaches over its end. What it reads there decides nothing but how long arithmetic
takes, which is long where the caller's memory holds subnormal numbers: it is set to zero before.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from collections.abc import Sequence as Numbers
from dataclasses import dataclass
from typing import Final

from symbody.codegen.llvm.numbers import Words
from symbody.codegen.llvm.order import order_operations
from symbody.codegen.lowering import constant_values, integer_exponent, power_products
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Sequence

# Operations in one block: what all items share is read again in each, which spares registers.
BLOCK: Final = 60
# The widest registers; so many numbers may be read past the end of a row.
_ROOM: Final = 8
# What is read where it lies.
_GIVEN: Final = op.LEAVES | {op.PICK}


@dataclass(frozen=True, slots=True)
class Items:
    """One MAP and its places in the work array.

    Attributes
    ----------
    shared, own : sequence of int
        Place of each number that all items share, and of the first item's of each row.
    results : int
        Where the first row of results begins.
    room : int
        From one row of results to the next.
    stores : sequence of (place, value)
        What has to be put in place before, but for computed values, which are put there at once.
    zeros : sequence of (place, size)
        What registers read over the ends of rows, and nothing before has written.
    outputs : mapping of row to place
        Rows of results that are wanted nowhere but, as they are, from such a place on in the output.
    """

    program: Sequence
    count: int
    shared: Numbers[int]
    own: Numbers[int]
    results: int
    room: int
    stores: Numbers[tuple[int, int]]
    zeros: Numbers[tuple[int, int]]
    outputs: Mapping[int, int]


@dataclass(frozen=True, slots=True)
class ItemPlan:
    """All programs of a sequence.

    Attributes
    ----------
    maps : mapping of value to Items
        Each MAP.
    picks : mapping of value to int
        The place of each of their PICKs in the work array.
    read : mapping of value to places
        Where computed values go because programs read them there.
    put : frozenset of int
        Those PICKs that programs put into the output themselves.
    end : int
        Of the work array.
    """

    maps: Mapping[int, Items]
    picks: Mapping[int, int]
    read: Mapping[int, Numbers[int]]
    put: frozenset[int]
    end: int


def plan_items(
    sequence: Sequence, needed: Numbers[bool], outputs: Mapping[int, Numbers[int]], start: int, width: int
) -> ItemPlan:
    """Return places from `start` on for what the programs of a sequence read and leave.

    Parameters
    ----------
    outputs : mapping of value to places in the output
    width : int
        Items in a register; 1 where registers hold points.
    """
    planner = _Planner(sequence, start, width, *_put_out(sequence, needed, outputs))
    for k, operation in enumerate(sequence.operations):
        if needed[k] and operation.op == op.MAP:
            planner.place(k)
        elif needed[k] and operation.op == op.PICK and operation.operands[0] in planner.maps:
            items = planner.maps[operation.operands[0]]
            row, item = divmod(operation.datum, items.count)
            planner.picks[k] = items.results + row * items.room + item
    end = planner.end + (_ROOM if planner.maps else 0)
    return ItemPlan(planner.maps, planner.picks, planner.read, planner.put, end)


def _put_out(
    sequence: Sequence, needed: Numbers[bool], outputs: Mapping[int, Numbers[int]]
) -> tuple[dict[int, dict[int, int]], frozenset[int]]:
    """Return for each MAP its rows that go to the output as they are, with their places, and their PICKs."""
    operations = sequence.operations
    read = {j for k, operation in enumerate(operations) if needed[k] for j in operation.operands}
    rows: dict[tuple[int, int], dict[int, tuple[int, int]]] = {}
    for k, (code, operands, datum) in enumerate(operations):
        places = outputs.get(k, ())
        if code == op.PICK and operations[operands[0]].op == op.MAP and len(places) == 1 and k not in read:
            row, item = divmod(datum, sequence.item_count(operations[operands[0]]))
            rows.setdefault((operands[0], row), {})[item] = (places[0], k)
    found: dict[int, dict[int, int]] = {}
    put: set[int] = set()
    for (node, row), items in rows.items():
        count = sequence.item_count(operations[node])
        starts = {place - item for item, (place, _) in items.items()}
        if len(items) == count and len(starts) == 1:
            found.setdefault(node, {})[row] = starts.pop()
            put.update(k for _, k in items.values())
    return found, frozenset(put)


class _Planner:
    """Gives each number one place, whoever reads it."""

    def __init__(
        self,
        sequence: Sequence,
        start: int,
        width: int,
        rows: Mapping[int, Mapping[int, int]],
        put: frozenset[int],
    ) -> None:
        self._outputs = rows
        self._width = width
        self._written: set[int] = set()
        self.put = put
        self._sequence = sequence
        self._rows: dict[tuple[int, ...], int] = {}
        self._programs: dict[int, Sequence] = {}
        self.maps: dict[int, Items] = {}
        self.read: dict[int, list[int]] = {}
        self.picks: dict[int, int] = {}
        self.end = -(-start // _ROOM) * _ROOM

    def place(self, k: int) -> None:
        operation = self._sequence.operations[k]
        program, count = self._sequence.programs[operation.datum], self._sequence.item_count(operation)
        if operation.datum not in self._programs:
            self._programs[operation.datum] = order_operations(program)
        start = program.group_size("p")
        operands = operation.operands
        stores: list[tuple[int, int]] = []
        shared = [self._row((value,), 1, stores) for value in operands[:start]]
        room = -(-count // _ROOM) * _ROOM
        own_places = [
            self._row(operands[first : first + count], room, stores)
            for first in range(start, len(operands), count)
        ]
        zeros = [gap for first in own_places for gap in self._unwritten(first, self._in_registers(count))]
        self._align()
        # The last register of a part of the last row may reach over its end.
        results = self._reserve(program.output_size * room + _ROOM)
        for first in range(results, results + program.output_size * room, room):
            self._written.update(range(first, first + self._in_registers(count)))
        self.maps[k] = Items(
            self._programs[operation.datum],
            count,
            shared,
            own_places,
            results,
            room,
            stores,
            zeros,
            self._outputs.get(k, {}),
        )

    def _row(self, values: tuple[int, ...], room: int, stores: list[tuple[int, int]]) -> int:
        """Return where numbers lie side by side; what has to be put there is added to `stores`."""
        places = [self.picks.get(value) for value in values]
        first = places[0]
        if first is not None and places == list(range(first, first + len(values))):
            return first
        if values not in self._rows:
            if room > 1:
                self._align()
            self._rows[values] = start = self._reserve(room)
            self._written.update(range(start, start + len(values)))
            for place, value in enumerate(values, start):
                if self._sequence.operations[value].op in _GIVEN:
                    stores.append((place, value))
                else:
                    self.read.setdefault(value, []).append(place)
        return self._rows[values]

    def _in_registers(self, count: int) -> int:
        """Return how many numbers are read or written with a row of so many."""
        return -(-count // self._width) * self._width

    def _unwritten(self, first: int, size: int) -> Iterator[tuple[int, int]]:
        """Yield the places, run by run, that were not written; they count as written from now on."""
        start = first
        for place in range(first, first + size + 1):
            if place == first + size or place in self._written:
                if place > start:
                    yield start, place - start
                start = place + 1
        self._written.update(range(first, first + size))

    def _align(self) -> None:
        self.end = -(-self.end // _ROOM) * _ROOM

    def _reserve(self, size: int) -> int:
        start = self.end
        self.end += size
        return start


def program_lines(
    items: Items, name: str, before: str, after: str, words: Words, points: int
) -> Iterator[str]:
    """Yield the loop over the items, from block `before` to block `after`.

    Parameters
    ----------
    name : str
        What its values are named after.
    words : Words
        Of so many items at once, or of the lanes of a function for several `points`.
    """
    size = items.count * points if points > 1 else -(-items.count // words.width) * words.width
    body = _Body(items, name, words, points)
    lines = list(body.lines())
    yield f"br label %{name}.loop\n{name}.loop:"
    yield f"%{name}.i = phi i64 [0, %{before}], [%{name}.next, %{body.block}]"
    yield from lines
    yield f"%{name}.next = add i64 %{name}.i, {words.width}"
    yield f"%{name}.more = icmp slt i64 %{name}.next, {size}"
    yield f"br i1 %{name}.more, label %{name}.loop, label %{after}\n{after}:"


class _Body:
    """Writes the operations of a program once."""

    def __init__(self, items: Items, name: str, words: Words, points: int) -> None:
        self._items = items
        self._name = name
        self._words = words
        self._points = points
        # The last register may reach over the end of a row of the output.
        self._has_rest = points == 1 and items.count % words.width > 0
        self._constants = constant_values(items.program)
        self._names: dict[int, str] = {}
        self.block = f"{name}.loop"  # the one being written

    def lines(self) -> Iterator[str]:
        if self._has_rest:
            yield from self._mask()
        program = self._items.program
        left: dict[int, list[int]] = {}
        for row, value in enumerate(program.outputs[0].values):
            left.setdefault(value, []).append(row)
        done = 0
        for k, operation in enumerate(program.operations):
            if not self._is_cheap(k):
                yield from self._operation(k, operation)
                done += 1
                if done % BLOCK == 0:
                    yield from self._begin_block(done)
            for row in left.get(k, ()):
                yield from self._load_value(k)
                yield from self._leave(row, self._names[k])

    def _is_cheap(self, k: int) -> bool:
        """Return whether a value is what all items share, or its opposite: read again rather than kept."""
        code, operands, datum = self._items.program.operations[k]
        if code == op.SYMBOL:
            return self._items.program.inputs[datum].group == "p"
        return k in self._constants or (code == op.NEG and self._is_cheap(operands[0]))

    def _begin_block(self, done: int) -> Iterator[str]:
        self.block = f"{self._name}.b{done}"
        yield f"br i1 %go, label %{self.block}, label %bail\n{self.block}:"
        self._names = {k: name for k, name in self._names.items() if not self._is_cheap(k)}

    def _load_value(self, k: int) -> Iterator[str]:
        """Yield the lines that make a value known in this block, if it is not."""
        if k in self._names:
            return
        code, operands, datum = self._items.program.operations[k]
        name = f"%{self.block}.{k}"
        if k in self._constants:
            name = self._words.constant(self._constants[k])
        elif code == op.NEG:
            yield from self._load_value(operands[0])
            yield f"{name} = {self._words.instructions[code].format(self._names[operands[0]])}"
        else:
            yield from self._load(name, "p", self._items.program.inputs[datum].position)
        self._names[k] = name

    def _operation(self, k: int, operation: Operation) -> Iterator[str]:
        program, words = self._items.program, self._words
        code, operands, datum = operation
        for j in operands:
            yield from self._load_value(j)
        name = self._names[k] = f"%{self._name}.{k}"
        given = [self._names[j] for j in operands]
        if code == op.SYMBOL:
            yield from self._load(name, "q", program.inputs[datum].position)
        elif code == op.POW and (exponent := integer_exponent(program, operands[1])) is not None:
            powers = given[:1]
            for first, second in power_products(exponent):
                powers.append(f"{name}.{len(powers)}")
                yield f"{powers[-1]} = fmul {words.real} {powers[first]}, {powers[second]}"
            self._names[k] = powers[-1]
        elif code in words.instructions:
            yield f"{name} = {words.instructions[code].format(*given)}"
        else:
            yield from (line.format(*given, k=name) for line in words.composed[code])

    def _leave(self, row: int, name: str) -> Iterator[str]:
        address, kind, width = f"%{self._name}.r{row}", self._words.real, self._words.width
        place = self._items.outputs.get(row)
        if place is None:
            yield from self._address(address, self._items.results + row * self._items.room, moving=True)
        else:
            yield from self._address(address, place, moving=True, array="out")
        if place is None or not self._has_rest:
            yield f"store {kind} {name}, ptr {address}, align 8"
        else:
            arguments = f"{kind} {name}, ptr {address}, i32 8, <{width} x i1> %{self._name}.here"
            yield f"call void @llvm.masked.store.v{width}f64.p0({arguments})"

    def _mask(self) -> Iterator[str]:
        """Yield the lines that compute which items of a register exist."""
        name, width = self._name, self._words.width
        kind, numbers = f"<{width} x i64>", ", ".join(f"i64 {k}" for k in range(width))
        yield f"%{name}.put = insertelement {kind} poison, i64 %{name}.i, i64 0"
        mask = f"<{width} x i32> zeroinitializer"
        yield f"%{name}.all = shufflevector {kind} %{name}.put, {kind} poison, {mask}"
        yield f"%{name}.numbers = add {kind} %{name}.all, <{numbers}>"
        yield f"%{name}.here = icmp slt {kind} %{name}.numbers, splat (i64 {self._items.count})"

    def _load(self, name: str, group: str, position: int) -> Iterator[str]:
        kind, address = self._words.real, f"{name}.at"
        if group == "q":
            yield from self._address(address, self._items.own[position], moving=True)
            yield f"{name} = load {kind}, ptr {address}, align 8"
            return
        yield from self._address(address, self._items.shared[position], moving=False)
        if self._points > 1 or self._words.width == 1:
            yield f"{name} = load {kind}, ptr {address}, align 8"
            return
        yield f"{name}.one = load double, ptr {address}, align 8"
        yield f"{name}.put = insertelement {kind} poison, double {name}.one, i64 0"
        mask = f"<{self._words.width} x i32> zeroinitializer"
        yield f"{name} = shufflevector {kind} {name}.put, {kind} poison, {mask}"

    def _address(self, name: str, place: int, *, moving: bool, array: str = "work") -> Iterator[str]:
        offset = place * self._points
        if not moving:
            yield f"{name} = getelementptr double, ptr %{array}, i64 {offset}"
            return
        yield f"{name}.row = getelementptr double, ptr %{array}, i64 {offset}"
        yield f"{name} = getelementptr double, ptr {name}.row, i64 %{self._name}.i"
