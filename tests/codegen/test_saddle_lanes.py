"""Several systems at once: the bits of one alone where all go the same way, and a word where they do not."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from symbody.codegen.kernels.llvm_kernels import kernel_name
from symbody.codegen.llvm.machine import lanes
from symbody.codegen.llvm.runtime import address
from symbody.codegen.llvm.saddles import saddle_function
from symbody.kernels.linear.solve_saddle import work_size
from tests.codegen.test_saddle_kernels import Arguments, bits, edge_cases, kernel_library, reference
from tests.saddle_systems import System, systems

WIDTH = 4
GUARD = 8  # doubles behind the scratch that have to stay as they are

Kernel = Callable[[list[Arguments]], tuple[int, list[list[float]]]]


@pytest.fixture(scope="module")
def kernel() -> Iterator[Kernel]:
    library = kernel_library(WIDTH)
    pointer = ctypes.POINTER(ctypes.c_double)
    kinds = (ctypes.c_int64, ctypes.c_int64, *[pointer] * 6, ctypes.c_void_p)
    call = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds)(library[kernel_name("solve_saddle", WIDTH)])

    def solved(lanes: list[Arguments]) -> tuple[int, list[list[float]]]:
        n, m = len(lanes[0][2]), len(lanes[0][3])
        given = [np.array([lane[k] for lane in lanes], dtype=float).T.ravel() for k in range(4)]
        arrays = [np.append(array, 0.0) for array in given]
        result = np.zeros((n + m + 1) * WIDTH)
        work = np.full(work_size(n, m) * WIDTH + GUARD, 7.0)
        pointers = [array.ctypes.data_as(pointer) for array in (*arrays, result, work)]
        mixed = np.zeros(1, dtype=np.uint8)
        status = call(n, m, *pointers, mixed.ctypes.data)
        assert (work[-GUARD:] == 7.0).all()
        return max(status, int(mixed[0])), result.reshape(-1, WIDTH).T.tolist()

    yield solved
    del library


def near(system: System, lane: int) -> Arguments:
    """The system with other last digits, which no pivot depends on."""
    factor = 1.0 + 1e-9 * lane
    return replace(system, F=system.F * factor, M=system.M * factor, gamma=system.gamma / factor).arguments


def check(kernel: Kernel, lanes: list[Arguments]) -> bool:
    """Compare with one after the other; return whether all went the same way."""
    status, found = kernel(lanes)
    expected = [reference(arguments) for arguments in lanes]
    if status == 0:
        assert all(alone == 0 for alone, _ in expected)
        assert [bits(result) for result in found] == [bits(result) for _, result in expected]
    return status == 0


def test_systems_that_go_the_same_way_have_the_bits_of_each_alone(kernel: Kernel) -> None:
    # Dependent rows, and masses that rounding alone tells apart, may still send lanes different ways.
    same = [check(kernel, [near(system, lane) for lane in range(WIDTH)]) for system in systems(5, 100)]
    assert sum(same) > 80


def test_systems_that_differ_are_handed_back(kernel: Kernel) -> None:
    by_size: dict[tuple[int, int], list[Arguments]] = {}
    for system in systems(6, 300):
        by_size.setdefault(system.J.shape, []).append(system.arguments)
    groups = [group[:WIDTH] for group in by_size.values() if len(group) >= WIDTH]
    assert groups
    for group in groups:
        check(kernel, group)


def test_ranks_that_differ_are_handed_back(kernel: Kernel) -> None:
    unit = [1.0, 0.0, 0.0, 1.0]
    full, half, none = [1.0, 0.0, 0.0, 1.0], [1.0, 0.0, 2.0, 0.0], [0.0] * 4
    rows = {"full": full, "half": half, "none": none}
    for name, J in rows.items():
        alike: Arguments = (unit, J, [1.0, 2.0], [0.0, 0.0])
        assert check(kernel, [alike] * WIDTH)
        for other in rows.keys() - {name}:
            assert not check(kernel, [alike] * (WIDTH - 1) + [(unit, rows[other], [1.0, 2.0], [0.0, 0.0])])


def test_edge_cases_in_all_lanes_and_in_one(kernel: Kernel) -> None:
    cases = edge_cases()
    for case in cases:
        assert check(kernel, [case] * WIDTH) == (reference(case)[0] == 0)
    for case, other in pairwise(cases):
        if [len(part) for part in case] == [len(part) for part in other]:
            check(kernel, [case] * (WIDTH - 1) + [other])


@pytest.mark.exhaustive
def test_lanes_of_a_known_size_have_the_bits_of_each_alone() -> None:
    """Also where rows depend on others, or one lane goes another way: then lane after lane is computed."""
    width = lanes()
    pointer = ctypes.POINTER(ctypes.c_double)
    for system in systems(9, 60):
        n, m = len(system.F), len(system.gamma)
        cases = [near(system, lane) for lane in range(width)]
        cases[-1] = ([0.0] * (n * n), *cases[-1][1:]) if n % 3 == 0 else cases[-1]
        function = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[pointer] * 3)
        call = function(address(saddle_function(n, m, width)))
        given = np.concatenate([np.array([case[k] for case in cases]).T.ravel() for k in range(4)])
        result = np.zeros((n + m + 1) * width)
        work = np.zeros((n * (n + m + 1) + m + n + m + 1 + work_size(n, m)) * width)
        status = call(n, m, *(array.ctypes.data_as(pointer) for array in (given, result, work)))
        expected = [reference(case) for case in cases]
        assert status == max(alone for alone, _ in expected)
        assert [bits(lane) for lane in result.reshape(-1, width).T.tolist()] == [bits(x) for _, x in expected]
