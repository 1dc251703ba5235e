"""Kernels written out for known sizes: the same results, no loops and calls, and what cannot be written out."""

from __future__ import annotations

import ctypes
import itertools

import llvmlite.binding as binding
import pytest

from symbody.codegen.kernels.llvm_kernels import kernel_name, llvm_text
from symbody.codegen.kernels.reader import read_text
from symbody.codegen.kernels.tree import Call, Count, KernelTree, walk
from symbody.codegen.kernels.unrolling import unroll_kernel
from symbody.codegen.llvm.machine import light_code, target_machine
from tests.tiers import cases

HEAD = "from symbody.kernels.language import Reals, part\n"
# Returns inside loops, integers that only a choice at run time decides, parts of scratch, a parameter whose
# source is overwritten, and results of two calls in one expression.
TEXT = (
    HEAD
    + """
def first_above(n: int, start: int, x: Reals, bound: float) -> int:
    for k in range(start, n):
        if x[k] > bound:
            return k
    return -1


def replace(x: Reals, k: int, value: float) -> float:
    x[k] = 10.0
    return value + x[k]


def both(n: int, given: Reals, out: Reals, work: Reals) -> int:
    head = part(work, 0, n)
    tail = part(work, n, n)
    for k in range(n):
        head[k] = given[k]
        tail[n - 1 - k] = given[k] * 2.0
    count = 0
    place = first_above(n, 1, head, 0.5)
    if place >= 0 and n > 2:
        count = count + place
        mark = 1
    else:
        mark = 2
    for k in range(n - 1, -1, -1):
        if tail[k] < 0.0:
            count = count + 10
            if mark == 1 or k == 0:
                count = count + 100
    out[0] = replace(head, 0, head[0]) + head[0]
    out[1] = replace(tail, 1, tail[1]) * replace(tail, 0, tail[0])
    out[2] = float(count)
    out[3] = float(max(place, 0) + mark)
    if count == 0:
        return place
    if place < 0:
        out[3] = out[3] - float(n)
    return count
"""
)
REFUSED = {
    "while": "def f(n: int, work: Reals) -> int:\n    k = n\n    while k > 0:\n        k = k - 1\n    return k\n",
    "end of a loop": "def f(n: int, x: Reals) -> int:\n    for k in range(int(x[0])):\n        x[k] = 1.0\n    return n\n",
    "index of work": "def f(n: int, x: Reals, work: Reals) -> int:\n    work[int(x[0])] = 1.0\n    return n\n",
}


def run(tree: KernelTree, given: tuple[float, ...]) -> tuple[int, list[float]]:
    code = light_code(llvm_text({tree.name: tree}, [tree.name]))
    name = kernel_name(tree.name)
    builder = binding.JITLibraryBuilder().add_object_img(code).export_symbol(name)
    library = builder.link(binding.create_lljit_compiler(target_machine(), use_jit_link=True), "unrolled")
    pointer = ctypes.POINTER(ctypes.c_double)
    call = ctypes.CFUNCTYPE(ctypes.c_int64, pointer, pointer)(library[name])
    out = (ctypes.c_double * 4)()
    return call((ctypes.c_double * len(given))(*given), out), list(out)


def by_hand(given: tuple[float, ...]) -> tuple[int, list[float]]:
    """What `both` does, in Python."""
    n = len(given)
    place = next((k for k in range(1, n) if given[k] > 0.5), -1)
    count, mark = (place, 1) if place >= 0 and n > 2 else (0, 2)
    tail = [2.0 * x for x in reversed(given)]
    for k in reversed(range(n)):
        if tail[k] < 0.0:
            count += 10 + 100 * (mark == 1 or k == 0)
    out = [
        given[0] + 10.0 + 10.0,
        (tail[1] + 10.0) * (tail[0] + 10.0),
        float(count),
        float(max(place, 0) + mark),
    ]
    if count and place < 0:
        out[3] -= n
    return place if count == 0 else count, out


@pytest.mark.parametrize("n", cases([2, 3, 4], fast=[3]))
def test_a_kernel_for_one_size_does_the_same(n: int) -> None:
    kernels = read_text(TEXT, "kernels/case.py")
    tree = unroll_kernel(kernels, "both", {"n": n}, "work", f"both_{n}")
    assert not [node for node in walk(tree.body) if isinstance(node, Count | Call)]
    assert [p.name for p in tree.parameters] == ["given", "out"]
    for given in itertools.product((-1.0, 0.25, 2.0), repeat=n):
        assert run(tree, given) == by_hand(given)


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_follow_from_the_sizes_is_refused(case: str) -> None:
    kernels = read_text(HEAD + REFUSED[case], "kernels/case.py")
    with pytest.raises(ValueError, match="follow"):
        unroll_kernel(kernels, "f", {"n": 3}, "work", "f_3")
