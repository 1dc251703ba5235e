"""LLVM functions that compute pieces of a sequence, as text, for one point or several in lanes.

Text, because building and printing through llvmlite's objects takes three times as long. Every value is named
after its number.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from symbody.codegen.llvm.items import ItemPlan, program_lines
from symbody.codegen.llvm.numbers import Words
from symbody.codegen.llvm.pairs.pair_writer import PairWriter
from symbody.codegen.llvm.pairs.signs import NO_PAIRS, PairPlan
from symbody.codegen.llvm.runtime import lane_counts, lane_sincos
from symbody.codegen.llvm.saddles import saddle_function
from symbody.codegen.llvm.trig import SINCOS_NAME
from symbody.codegen.lowering import integer_exponent, power_products
from symbody.codegen.pieces import Piece, Plan, argument_places
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Operation, Sequence

GROUPS: Final = ("t", "q", "u", "r", "p", "c")

# Groups may overlap each other, and `out` or `work` nothing.
PARAMETERS: Final = ", ".join(
    [f"ptr readonly %{g}" for g in GROUPS] + ["ptr noalias %out", "ptr noalias %work"]
)

# The scheduler takes more than linear time on a long block: 20,000 operations in blocks of 50 to 200 compile
# in a third of the time, for code as fast. What joins blocks must not look like falling through, or LLVM
# undoes it; `out` is never null where there is something to compute.
BLOCK: Final = 100
# Pairs make code shorter, and the larger part of it is scheduled together.
_BLOCK_OF_PAIRS: Final = 150


def piece_function(
    sequence: Sequence,
    plan: Plan,
    items: ItemPlan,
    piece: Piece,
    name: str,
    words: Words,
    beside: Words,
    pairs: PairPlan = NO_PAIRS,
) -> str:
    """Return the function that computes one piece; `beside` are the words of items side by side."""
    writer = _LlvmPieceWriter(sequence, plan, items, piece, words, beside, pairs)
    body = "\n".join(writer.lines())
    return f"define i32 @{name}({PARAMETERS}) nounwind {{\n{body}\n}}\n"


class _LlvmPieceWriter:
    """Writes one piece; in lanes, entry k of an array begins at k times the number of lanes."""

    def __init__(
        self,
        sequence: Sequence,
        plan: Plan,
        items: ItemPlan,
        piece: Piece,
        words: Words,
        beside: Words,
        pairs: PairPlan,
    ) -> None:
        self._sequence = sequence
        self._plan = plan
        self._items = items
        self._beside = beside if words.width == 1 else words
        self._piece = piece
        self._words = words
        self._names: dict[int, str] = {}  # how a value is written as an operand
        self._lines: list[str] = []
        self._circles: dict[int, tuple[str, str]] = {}  # of an argument: its sine and cosine
        self._addresses: set[str] = set()
        self._status = "0"  # name of the integer to return
        self._blocks = 0
        # What is written when it is read; beside pairs signs, too, or lanes would be taken apart for them.
        self._later = op.LEAVES | ({op.PICK, op.NEG} if pairs.slots else {op.PICK})
        # Pairs read values without their signs, of which an earlier piece may have left the negative alone.
        negatives = (
            {
                sequence.operations[k].operands[0]: k
                for k in piece.loads
                if sequence.operations[k].op == op.NEG
            }
            if pairs.slots
            else {}
        )
        self._negatives = {k: j for k, j in negatives.items() if k not in piece.loads}
        self._pairs = PairWriter(sequence, pairs, plan.constants, self._operand, self._lines)

    def lines(self) -> list[str]:
        piece, plan, operations = self._piece, self._plan, self._sequence.operations
        done, block = 0, BLOCK if op.NEG not in self._later else _BLOCK_OF_PAIRS
        for k in range(piece.start, piece.stop):
            if not plan.needed[k]:
                continue
            operation = operations[k]
            if operation.op not in self._later and not self._pairs.has(k):
                if self._pairs.begins(k, piece.stop):
                    self._pairs.write(k)
                else:
                    self._operation(k, operation)
                done += 1
                if done % block == 0:
                    self._begin_block()
            self._put_away(k)
        self._lines.append(f"ret i32 {self._status}")
        if self._blocks:
            self._lines.insert(0, "%go = icmp ne ptr %out, null")
            self._lines += ["bail:", "ret i32 0"]
        return self._lines

    def _put_away(self, k: int) -> None:
        """Store a value wherever it is read from: by the caller, by programs, by later pieces."""
        if k not in self._items.put:
            for place in self._plan.outputs.get(k, ()):
                self._store("out", place, self._operand(k))
        for place in self._items.read.get(k, ()):
            self._store("work", place, self._operand(k))
        if k in self._piece.stores:
            self._leave(k, self._piece.stores[k])

    def _begin_block(self) -> None:
        self._blocks += 1
        self._lines.append(f"br i1 %go, label %b{self._blocks}, label %bail\nb{self._blocks}:")

    def _map(self, k: int) -> None:
        items = self._items.maps[k]
        for count, (place, value) in enumerate(items.stores, 1):
            self._store("work", place, self._operand(value))
            if count % BLOCK == 0:
                self._begin_block()
        for place, size in items.zeros:
            address = self._address("work", place)
            self._lines.append(f"store <{size} x double> zeroinitializer, ptr {address}, align 8")
        self._begin_block()
        before, after = f"b{self._blocks}", f"b{self._blocks + 1}"
        self._lines.extend(program_lines(items, f"m{k}", before, after, self._beside, self._words.width))
        self._blocks += 1

    def _operation(self, k: int, operation: Operation) -> None:
        code, operands, datum = operation
        if code == op.MAP:
            self._map(k)
            return
        if code == op.SADDLE:
            self._saddle(k, operands, datum)
        elif code == op.POW and (exponent := integer_exponent(self._sequence, operands[1])) is not None:
            self._power(k, self._operand(operands[0]), exponent)
        elif code in (op.SIN, op.COS):
            if operands[0] not in self._circles:
                self._compute_circles(k)
            self._names[k] = self._circles[operands[0]][code == op.COS]
        else:
            names = [self._operand(j) for j in operands]
            self._names[k] = f"%z{k}"
            if code in self._words.instructions:
                self._lines.append(f"%z{k} = {self._words.instructions[code].format(*names)}")
            else:
                self._lines.extend(line.format(*names, k=f"%z{k}") for line in self._words.composed[code])

    def _operand(self, k: int) -> str:
        """Return how value k is written, reading it first if this piece has not yet."""
        name = self._names.get(k)
        if name is None:
            if self._pairs.has(k):
                name = f"%z{k}"
                self._lines.extend(self._pairs.lane(k))
            else:
                name = self._read_value(k)
            self._names[k] = name
        return name

    def _read_value(self, k: int) -> str:
        code, operands, datum = self._sequence.operations[k]
        name = f"%z{k}"
        if code in (op.RATIONAL, op.FLOAT, op.PI):
            return self._words.constant(self._plan.constants[k])
        if code == op.SYMBOL:
            source = self._sequence.inputs[datum]
            self._load(name, source.group, source.position)
        elif code == op.PICK:
            known = self._items.picks.get(k)
            place = self._plan.results[operands[0]] + datum if known is None else known
            self._load(name, "work", place)
        elif code == op.NEG and k >= self._piece.start:
            self._lines.append(
                f"{name} = {self._words.instructions[code].format(self._operand(operands[0]))}"
            )
        elif code in op.CONDITIONS:
            self._load(f"{name}.d", "work", self._piece.loads[k])
            zero = self._words.constant(0.0)
            self._lines.append(f"{name} = fcmp une {self._words.real} {name}.d, {zero}")
        elif k in self._negatives:
            self._lines.append(f"{name} = fneg {self._words.real} {self._operand(self._negatives[k])}")
        else:
            self._load(name, "work", self._piece.loads[k])
        return name

    def _leave(self, k: int, slot: int) -> None:
        name = self._operand(k)
        if self._sequence.operations[k].op in op.CONDITIONS:
            self._lines.append(f"%z{k}.d = uitofp {self._words.truth} {name} to {self._words.real}")
            name = f"%z{k}.d"
        self._store("work", slot, name)

    def _compute_circles(self, first: int) -> None:
        """Write sine and cosine of all arguments known at operation `first`, several angles in one call."""
        operations, needed = self._sequence.operations, self._plan.needed
        later = (operations[k] for k in range(first, self._piece.stop) if needed[k])
        angles = [operation.operands[0] for operation in later if operation.op in (op.SIN, op.COS)]
        known = [k for k in dict.fromkeys(angles) if k < first and k not in self._circles]
        if self._words.width > 1:
            for k in known:
                self._circle(k, self._operand(k), lane_sincos(self._words.width), self._words.real)
            return
        while len(known) > 1:
            width = next((n for n in lane_counts() if n >= len(known)), lane_counts()[-1])
            self._circles_in_lanes(known[:width], width)
            known = known[width:]
        for k in known:
            self._circle(k, self._operand(k), SINCOS_NAME, "double")

    def _circle(self, k: int, operand: str, function: str, kind: str) -> None:
        self._lines.append(f"%p{k} = call {{{kind}, {kind}}} @{function}({kind} {operand})")
        for entry, word in enumerate("sc"):
            self._lines.append(f"%p{k}.{word} = extractvalue {{{kind}, {kind}}} %p{k}, {entry}")
        self._circles[k] = (f"%p{k}.s", f"%p{k}.c")

    def _circles_in_lanes(self, angles: list[int], width: int) -> None:
        """Write one call for some angles; lanes that are left repeat the last one."""
        kind, before = f"<{width} x double>", "undef"
        for lane, k in enumerate([*angles, *angles[-1:] * (width - len(angles))]):
            name = f"%a{angles[0]}.{lane}"
            self._lines.append(
                f"{name} = insertelement {kind} {before}, double {self._operand(k)}, i32 {lane}"
            )
            before = name
        self._circle(angles[0], before, lane_sincos(width), kind)
        first = angles[0]
        for lane, k in enumerate(angles):
            for word in "sc":
                vector = f"{kind} %p{first}.{word}"
                self._lines.append(f"%p{k}.{word}.{width} = extractelement {vector}, i32 {lane}")
            self._circles[k] = (f"%p{k}.s.{width}", f"%p{k}.c.{width}")

    def _power(self, k: int, base: str, exponent: int) -> None:
        names = [base]
        for first, second in power_products(exponent):
            names.append(f"%z{k}.{len(names)}")
            self._lines.append(f"{names[-1]} = fmul {self._words.real} {names[first]}, {names[second]}")
        self._names[k] = names[-1]

    def _saddle(self, k: int, operands: tuple[int, ...], datum: int) -> None:
        plan, kernel = self._plan, self._sequence.kernels[datum]
        names = [self._operand(operand) for operand in operands]
        zero = self._words.constant(0.0)
        if cleared := 2 * names.count(zero) > len(names):
            # One by one, LLVM takes longer to gather the zeros of large matrices than for all the rest.
            start, size = self._address("work", plan.arguments), 8 * len(names) * self._words.width
            self._lines.append(f"call void @llvm.memset.p0.i64(ptr {start}, i8 0, i64 {size}, i1 false)")
        stored = [(place, x) for place, x in enumerate(names, plan.arguments) if not cleared or x != zero]
        for count, (place, name) in enumerate(stored, 1):
            self._store("work", place, name)
            if count % BLOCK == 0:
                self._begin_block()
        places = [*argument_places(kernel, plan.arguments), plan.results[k], plan.scratch]
        if self._words.width > 1:
            places = [plan.arguments, plan.results[k], plan.scratch]
        arguments = [f"i64 {kernel.n}", f"i64 {kernel.m}"]
        arguments += [f"ptr {self._address('work', place)}" for place in places]
        called = saddle_function(kernel.n, kernel.m, self._words.width)
        self._lines.append(f"%f{k} = call i64 @{called}({', '.join(arguments)})")
        self._lines.append(f"%f{k}.bad = icmp ne i64 %f{k}, 0")
        self._lines.append(f"%f{k}.code = select i1 %f{k}.bad, i32 {datum + 1}, i32 0")
        self._lines.extend(first_status(self._status, f"%f{k}.code", f"%s{k}"))
        self._status = f"%s{k}"

    def _load(self, name: str, array: str, place: int) -> None:
        address = self._address(array, place)
        self._lines.append(f"{name} = load {self._words.real}, ptr {address}, align 8")

    def _store(self, array: str, place: int, name: str) -> None:
        self._lines.append(f"store {self._words.real} {name}, ptr {self._address(array, place)}, align 8")

    def _address(self, array: str, place: int) -> str:
        if not place:
            return f"%{array}"
        name = f"%{array}.{place}"
        if name not in self._addresses:
            self._addresses.add(name)
            offset = place * self._words.width
            self._lines.append(f"{name} = getelementptr double, ptr %{array}, i64 {offset}")
        return name


def first_status(before: str, new: str, name: str) -> Iterator[str]:
    """Yield the lines by which `name` becomes the first of two statuses that is not 0."""
    yield f"{name}.ok = icmp eq i32 {before}, 0"
    yield f"{name} = select i1 {name}.ok, i32 {new}, i32 {before}"
