"""The same mechanism in another wording moves the same way; the same bytes in every process."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable

import pytest

import symbody as sb
from tests.laws.building import build_model
from tests.laws.invariance import TRANSFORMS, errors_of
from tests.laws.mechanisms import random_mechanism
from tests.laws.tally import Tally, chunks, name_of

# One of each family, small enough to be generated in a second.
GENERATED = (11, 38, 7)


def check(seeds: Iterable[int], each: int) -> None:
    """Apply `each` transformations, in turn, to every mechanism."""
    tally = Tally()
    words = list(TRANSFORMS)
    for seed in seeds:
        chosen = [words[(each * seed + k) % len(words)] for k in range(each)]
        for word, error in errors_of(random_mechanism(seed), chosen).items():
            tally.enter(seed, word, error)
    tally.close("other wordings")


@pytest.mark.parametrize("seeds", chunks(3), ids=name_of)  # each transformation once
def test_other_wordings_move_the_same_way(seeds: range) -> None:
    check(seeds, 2)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(300), ids=name_of)
def test_other_wordings_move_the_same_way_often(seeds: range) -> None:
    check(seeds, len(TRANSFORMS))


def generated() -> str:
    """C text of a few mechanisms."""
    outputs = ["xdot", "constraints", "reaction J1"]
    return "\n".join(
        sb.generate_code(sb.form_equations(build_model(random_mechanism(seed))), outputs, parameters={})
        for seed in GENERATED
    )


@pytest.mark.exhaustive
def test_every_process_generates_the_same_bytes() -> None:
    script = "from tests.laws.test_invariance import generated; print(generated())"
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONHASHSEED": seed, "SYMBODY_CACHE": "off"},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("0", "1", "4711")
    ]
    texts = {run.communicate()[0] for run in runs}
    assert len(texts) == 1 and texts.pop().count("Written by symbody") == len(GENERATED)
