"""A limit on work that holds on any processor, however busy the machine is."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

SLOWEST = 10.0  # how much slower than today's a processor may be, with a debugging interpreter on it


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Fail if this process computes far longer than the seconds promised, as where work grows without bound."""
    start = time.process_time()
    yield
    assert time.process_time() - start < SLOWEST * seconds
