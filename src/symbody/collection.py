"""Work that makes many values which stay: Python's search for cyclic garbage waits until it is done."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_collection() -> Iterator[None]:
    """Switch the search for cyclic garbage off, and on again if it was on; also a decorator.

    It looks through all values that live, again and again while their number grows, and would find nothing:
    the elements, nodes and operations of large mechanisms stay and form no cycles. It takes half the time of
    reading a file of 1000 bodies, a fifth of forming their equations and a tenth of their code.

    Of several threads in here the one that switched it off switches it on, at the latest when all are done.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
