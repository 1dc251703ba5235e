"""Results depend on nothing that the scratch held, and no word of it is read before it was written."""

from __future__ import annotations

import struct
import subprocess
from collections.abc import Sequence as Items
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.codegen.llvm import native
from symbody.codegen.llvm.machine import lanes
from symbody.codegen.llvm.native import NativeFunction, compile_sequence
from symbody.codegen.texts.c import generate
from symbody.expr.sequences.program import written_out
from symbody.expr.sequences.sequence import Sequence
from tests.codegen.native import BATCH, GROUPS, SIGNATURE, doubles
from tests.codegen.scratch_reads import Watched, watched
from tests.codegen.sequences import EXACT, TRIGONOMETRIC, Inputs, random_sequence
from tests.codegen.test_items import points, random_programs
from tests.codegen.texts.test_c import PLAIN, STRICT, load, needs_gcc
from tests.equations.test_columns import random_tree
from tests.tiers import cases

# Of quiet and of signalling NaNs, the least subnormal number, those of whole numbers and of addresses, the greatest.
PATTERNS = (
    0, 0x7FF8000000000000, 0x7FF0000000000001, 1, 7, 0x7F3812345678, 0x7FEFFFFFFFFFFFFF, 0xFFFFFFFFFFFFFFFF
)  # fmt: skip
WIDTHS = tuple(width for width in (2, 4, 8) if width <= lanes())

Case = tuple[Sequence, Inputs]


def programs(seed: int) -> Case:
    """Programs of random items, one point."""
    return random_programs(seed), {"q": points(seed, 1)[0]}


def plain(seed: int) -> Case:
    """Every operation, linear systems among them."""
    return random_sequence(seed, 150, (*EXACT, *TRIGONOMETRIC))


def derivatives(seed: int) -> Case:
    """Derivatives of the accelerations of a random tree of bodies."""
    eqs = sb.form_equations(random_tree(seed, 2 + seed % 6, floating=bool(seed % 2)))
    source = np.random.default_rng(seed)
    f = sb.compile(eqs, ["udot", "d udot/d(q, u, r)"])
    sizes = {"q": eqs.coordinate_names, "u": eqs.speed_names, "r": eqs.input_names, "t": ("t",)}
    given = {group: list(map(float, source.uniform(-1, 1, len(names)))) for group, names in sizes.items()}
    return f.sequence, given


CASES = {"programs": programs, "plain": plain, "derivatives": derivatives}


def fill(work: Items[float], pattern: int) -> None:
    size = len(work)
    memory = memoryview(work).cast("B")  # type: ignore[arg-type]
    memory[:] = struct.pack("<Q", pattern) * size


def called(
    function: NativeFunction | Watched, sequence: Sequence, given: Inputs, work: Items[float]
) -> bytes:
    """What a call at one point, or in lanes at equal points, writes."""
    out = doubles([0.0] * (sequence.output_size * function.width))
    one = {group: doubles(values) for group, values in given.items()}
    if function.width == 1:
        status = SIGNATURE(function.address)(*(one.get(group) for group in GROUPS), out, work)
    else:
        rows = [x for group in GROUPS for x in (one.get(group, doubles([0.0])), 0)]
        status = BATCH(function.batch_address)(1, *rows, out, sequence.output_size, work)
    assert status == 0
    return bytes(out)


def check_patterns(case: Case, *, in_lanes: bool, quick: bool = False, piece_size: int = 2000) -> None:
    sequence, given = case
    function = compile_sequence(sequence, in_lanes=in_lanes, quick=quick, piece_size=piece_size)
    work = doubles([0.0] * function.work_size)
    found = set()
    for pattern in PATTERNS:
        fill(work, pattern)
        found.add(called(function, sequence, given, work))
    assert len(found) == 1


def check_reads(case: Case, *, in_lanes: bool, piece_size: int = 2000) -> None:
    function = watched(case[0], in_lanes=in_lanes, piece_size=piece_size)
    called(function, *case, function.work)
    assert function.unwritten == []


@pytest.mark.parametrize("kind", CASES)
@pytest.mark.parametrize("seed", cases(range(2), fast=[0]))
def test_what_the_scratch_held_changes_no_bit(kind: str, seed: int) -> None:
    case = CASES[kind](seed)
    check_patterns(case, in_lanes=False, quick=bool(seed))
    check_patterns(case, in_lanes=True)


@pytest.mark.parametrize("kind", cases(CASES, fast=["programs", "derivatives"]))
@pytest.mark.parametrize("width", cases(WIDTHS, fast=WIDTHS[:1]))
def test_no_word_is_read_before_it_is_written(kind: str, width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "lanes", lambda: width)  # numbers in a register
    for seed in range(2):
        check_reads(CASES[kind](seed), in_lanes=False, piece_size=(2000, 60)[seed])


@pytest.mark.parametrize("kind", cases(CASES, fast=["programs", "plain"]))
def test_no_word_is_read_before_it_is_written_in_lanes(kind: str) -> None:
    check_reads(CASES[kind](5), in_lanes=True, piece_size=100)


def test_the_watch_sees_what_is_read_too_early() -> None:
    """Without the zeros behind the rows, programs read what nothing wrote."""
    case = programs(0)
    function = watched(case[0], leave_out="zeroinitializer, ptr %work")
    called(function, *case, function.work)
    assert function.unwritten and function.reads[0] > 0


@needs_gcc
@pytest.mark.parametrize("kind", cases(["plain", "programs"], fast=["programs"]))
def test_c_text_depends_on_nothing_that_memory_held(kind: str, tmp_path: Path) -> None:
    """Neither on the caller's scratch, nor on what its own variables were before: gcc fills these."""
    version = subprocess.run(["gcc", "-dumpversion"], capture_output=True, text=True, check=True).stdout
    if int(version.partition(".")[0]) < 12:
        pytest.skip("gcc 12 is the first that fills variables")
    sequence, given = CASES[kind](3)
    found = set()
    for init in ("pattern", "zero"):
        (tmp_path / init).mkdir()
        text = generate(written_out(sequence), piece_size=100)
        library = load(text, tmp_path / init, *STRICT, *PLAIN, f"-ftrivial-auto-var-init={init}")
        work = doubles([0.0] * library.f_work_size())
        groups = [doubles(given[group]) if group in given else None for group in GROUPS]
        for pattern in PATTERNS:
            fill(work, pattern)
            out = doubles([0.0] * sequence.output_size)
            assert SIGNATURE(("f", library))(*groups, out, work) == 0
            found.add(bytes(out))
    assert len(found) == 1


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(20))
@pytest.mark.parametrize("kind", CASES)
def test_many_functions_read_and_depend_on_nothing_else(
    kind: str, chunk: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 5 if kind == "derivatives" else 40
    for seed in range(100 + chunk * count, 100 + (chunk + 1) * count):
        case, piece_size = CASES[kind](seed), (50, 200, 2000)[seed % 3]
        for width in WIDTHS:
            with monkeypatch.context() as patch:
                patch.setattr(native, "lanes", lambda width=width: width)
                check_reads(case, in_lanes=False, piece_size=piece_size)
        check_reads(case, in_lanes=True, piece_size=piece_size)
        for in_lanes in (False, True):
            check_patterns(case, in_lanes=in_lanes, piece_size=piece_size)
