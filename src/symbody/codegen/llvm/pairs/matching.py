"""Which operations are done two at a time.

Starting from inputs that correspond, operations become ready when all they read is settled. Two of the same
kind that read the same pairs, one in each lane, become a pair. Those that find no partner wait for one
until nothing else is ready; then constants and what is not paired may differ, and in the end the earliest
goes alone. As both of a pair were ready when it was made, the pairs can be computed in some order.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

from symbody.codegen.llvm.pairs.inputs import corresponding_inputs
from symbody.codegen.llvm.pairs.terms import Terms
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Sequence

# Constants that differ by less are the same but for how they were measured.
_SAME: Final = 0.02
# The part of the instructions that has to be saved: less gains nothing.
_WORTH: Final = 0.23
# Shorter functions wait for results, not for instructions.
_SHORTEST: Final = 300
# Longer ones are derivatives and mechanisms of hundreds of bodies: the search takes more than it gains.
_LONGEST: Final = 30_000
# One of so many that wait goes alone at a time.
_PORTION: Final = 16

_Key = tuple[int, tuple[tuple[int, int], ...]]
_Side = dict[int, list[float]]
_Candidate = tuple[bool, int, int, float, int, int]


def find_pairs(sequence: Sequence) -> dict[int, int]:
    """Return for some values the one that is computed with it; nothing where that saves too little."""
    terms = Terms(sequence)
    work = sum(map(terms.is_work, range(len(sequence.operations))))
    seeds = corresponding_inputs(sequence, terms) if _SHORTEST <= work <= _LONGEST else []
    if not seeds:
        return {}
    pairs = _Matcher(sequence, terms).match(seeds)
    return pairs if _count_saved(terms, pairs) >= _WORTH * work else {}


def _count_saved(terms: Terms, pairs: dict[int, int]) -> int:
    """Return how many instructions are saved: one a pair, less those that join lanes or take them apart."""
    computed = {first: second for first, second in pairs.items() if terms.can_pair(terms.operations[first])}
    places = {k: (first, lane) for first, second in pairs.items() for lane, k in enumerate((first, second))}
    paired = {*computed, *computed.values()}
    packed: set[tuple[int, int]] = set()
    for first, second in computed.items():
        both = zip(terms.align_terms(first, places), terms.align_terms(second, places), strict=True)
        packed.update((a, b) for (_, (a, _)), (_, (b, _)) in both if computed.get(a) != b)
    packed = {(a, b) for a, b in packed if a not in terms.constants}
    apart = {k for pair in packed for k in pair}
    for k, operation in enumerate(terms.operations):
        if k not in paired and terms.is_work(k):
            apart.update(map(terms.base, operation.operands))
    return len(computed) - len(packed) - len(apart & paired)


class _Matcher:
    def __init__(self, sequence: Sequence, terms: Terms) -> None:
        self._terms = terms
        self._places: dict[int, tuple[int, int]] = {}
        self._pairs: dict[int, int] = {}
        self._uses: dict[int, Counter[object]] = {}
        self._readers: list[list[int]] = [[] for _ in sequence.operations]
        self._missing = [0] * len(sequence.operations)
        self._ready: list[int] = []
        self._waiting: dict[_Key, tuple[_Side, _Side]] = {}
        self._keys: dict[int, tuple[_Key, int]] = {}
        for k, operation in enumerate(sequence.operations):
            if terms.is_work(k):
                read = {terms.base(j) for j in operation.operands}
                read = {j for j in read if terms.is_work(j)}
                self._missing[k] = len(read)
                for j in read:
                    self._readers[j].append(k)
                if not read:
                    self._ready.append(k)

    def match(self, seeds: list[tuple[int, int]]) -> dict[int, int]:
        """Return the pairs that grow from some inputs and their circles, these among them."""
        for first, second in seeds:
            self._places[first], self._places[second] = (first, 0), (first, 1)
            self._pairs[first] = second
        while self._ready or self._keys:
            if not self._ready:
                self._relax()
            batch, self._ready = self._ready, []
            for key in dict.fromkeys([key for k in batch if (key := self._place(k)) is not None]):
                alike = [c for c in self._candidates(*self._waiting[key]) if not c[0]]
                self._pair_up(alike, len(alike))
        return self._pairs

    def _settle(self, k: int) -> None:
        for reader in self._readers[k]:
            self._missing[reader] -= 1
            if not self._missing[reader]:
                self._ready.append(reader)

    def _place(self, k: int) -> _Key | None:
        """Let operation k wait for a partner, or settle it if it can have none."""
        operation = self._terms.operations[k]
        terms = self._terms.align_terms(k, self._places)
        lanes = {self._places[value][1] for (kind, _), (value, _) in terms if kind == 0}
        if len(lanes) != 1 or not self._terms.can_pair(operation):
            self._settle(k)
            return None
        lane = lanes.pop()
        key = op.ADD if operation.op == op.SUB else operation.op, tuple([kind for kind, _ in terms])
        constants = [abs(self._terms.constants[value]) for (kind, _), (value, _) in terms if kind == 1]
        self._keys[k] = key, lane
        self._waiting.setdefault(key, ({}, {}))[lane][k] = constants
        return key

    def _candidates(self, left: _Side, right: _Side) -> list[_Candidate]:
        """Return what can be paired; what sorts first is most alike."""
        several = len(left) + len(right) > 2
        return [
            (
                (difference := _difference(first, second)) > _SAME,
                self._unlike(i, j),
                self._strangeness(i, j) if several else 0,
                difference,
                i,
                j,
            )
            for i, first in left.items()
            for j, second in right.items()
        ]

    def _pair_up(self, candidates: list[_Candidate], most: int) -> None:
        """Pair the first candidates, as far as both are still waiting."""
        for *_, i, j in sorted(candidates):
            if most and i in self._keys and j in self._keys:
                self._pairs[i] = j
                self._places[i], self._places[j] = (i, 0), (i, 1)
                self._leave(i)
                self._leave(j)
                most -= 1

    def _leave(self, k: int) -> None:
        key, lane = self._keys.pop(k)
        del self._waiting[key][lane][k]
        self._settle(k)

    def _relax(self) -> None:
        """Pair what differs in constants or in what is not paired, a few at a time; else some go alone."""
        loose: dict[_Key, tuple[_Side, _Side]] = {}
        for k, ((code, kinds), lane) in self._keys.items():
            looser = code, tuple([(kind, 0 if kind == 2 else number) for kind, number in kinds])
            loose.setdefault(looser, ({}, {}))[lane][k] = self._waiting[code, kinds][lane][k]
        candidates = [candidate for sides in loose.values() for candidate in self._candidates(*sides)]
        portion = 1 + len(self._keys) // _PORTION
        if candidates:
            self._pair_up(candidates, portion)
            return
        for k in sorted(self._keys)[:portion]:
            self._leave(k)

    def _strangeness(self, i: int, j: int) -> int:
        """Return how many uses of the one value, and of what reads it, have no like at the other."""
        a, b = self._wider_uses(i), self._wider_uses(j)
        return (a - b).total() + (b - a).total()

    def _unlike(self, i: int, j: int) -> int:
        """Return how many operands differ that are not paired."""
        kinds = zip(self._keys[i][0][1], self._keys[j][0][1], strict=True)
        return sum([a != b for a, b in kinds])

    def _wider_uses(self, k: int) -> Counter[object]:
        if k not in self._uses:
            uses: Counter[object] = Counter()
            for reader in self._readers[k]:
                uses[self._use(reader)] += 1
                uses.update((1, self._use(other)) for other in self._readers[reader])
            self._uses[k] = uses
        return self._uses[k]

    def _use(self, k: int) -> object:
        code, operands, _ = self._terms.operations[k]
        constants = self._terms.constants
        numbers = sorted(f"{abs(constants[j]):.2g}" for j in operands if j in constants)
        return op.ADD if code == op.SUB else code, tuple(numbers)


def _difference(first: list[float], second: list[float]) -> float:
    """Return the largest relative difference of constants."""
    pairs = zip(first, second, strict=True)
    return max([abs(a - b) / (a + b) if a != b else 0.0 for a, b in pairs], default=0.0)
