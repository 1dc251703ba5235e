"""The fault checklist, A: row 14, a chain of a thousand bodies."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from symbody.codegen.compile import compile
from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.graph.topology import choose_topology
from symbody.model import Body, Drive, Frame, Model, Prismatic


def chain(count: int) -> Model:
    """Sliders one on the other."""
    parts: list[Body | Prismatic] = []
    place = "ground"
    for k in range(count):
        parts.append(Body(f"B{k}", mass="m", frames={"tip": Frame(at=("L", 0, 0))}))
        parts.append(Prismatic(f"j{k}", place, f"B{k}", axis="x", coordinate=f"x{k}", force=Drive(f"F{k}")))
        place = f"B{k}.tip"
    inputs = [f"F{k}" for k in range(count)]
    return Model("chain", parts, parameters={"m": 2, "L": 1}, inputs=inputs)


def calls(attempt: Callable[[], object]) -> int:
    """How often anything was called, which unlike time is the same in every run."""
    count = 0

    def hook(frame: object, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(hook)
    try:
        attempt()
    finally:
        sys.setprofile(before)
    return count


@contextmanager
def depth(limit: int) -> Iterator[None]:
    """Let calls nest by at most `limit` from here."""
    here, frame = 0, sys._getframe()
    while frame is not None:
        here, frame = here + 1, frame.f_back
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(here + limit)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def test_row_14_a_thousand_bodies() -> None:
    with depth(150):
        model = chain(1000)
        topology = choose_topology(model)
    assert len(topology.rotation.branches) == len(topology.translation.branches) == 1000


def test_row_14_a_model_grows_linearly() -> None:
    # Every body costs the same; 1.1 leaves room for what is done once and for growing tables.
    small, large = calls(lambda: chain(100)), calls(lambda: chain(400))
    assert large < 1.1 * 4 * small


def check_chain(count: int) -> EquationSet:
    """Each slider carries all that follow it: forces that accelerate the first alone are m, 0, 0, ..."""
    with depth(75):
        eqs = form_equations(chain(count))
    zeros = np.zeros(count)
    first = compile(eqs, "forcing")(0.0, zeros, zeros, np.eye(count)[0])
    assert np.array_equal(first, np.eye(count)[0])
    mass = compile(eqs, "mass_matrix")(0.0, zeros, zeros, zeros)
    rest = count - np.arange(count)
    assert np.array_equal(mass, 2.0 * np.minimum.outer(rest, rest))
    return eqs


@pytest.mark.exhaustive
def test_row_14_equations_of_a_chain_need_no_recursion() -> None:
    # One call more a body would nest deeper than the 75 that are allowed.
    assert len(check_chain(80).speed_names) == 80


@pytest.mark.exhaustive
def test_row_14_equations_of_300_bodies() -> None:
    assert len(check_chain(300).speed_names) == 300
