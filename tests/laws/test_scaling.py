"""The scaling law: from a nanometre to 1,000 km, tolerances follow the mechanism and not its units."""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from tests.laws.parts import Units
from tests.laws.rotations import Array
from tests.laws.scaled_analyses import ANALYSES, SAME_BITS, Answer, Question, answer
from tests.laws.scaling import ONE, formed, has_massless, is_scalable, scaled_sweep
from tests.laws.tally import chunks, name_of

SHARE = 0.3  # of the mechanism's unit of time
RTOL = 1e-8
# As in `test_motion`: what each step adds, RTOL of quantities of order one, grows by exp(3 SHARE) to the end.
GROWTH = float(np.exp(3 * SHARE))


# Their derivatives by up to a hundred absolute coordinates take minutes to compile.
HEAVY = ("linearize", "find_equilibrium", "GGL", "GeneralizedAlpha", "Stiff")


def powers_of_two(rng: random.Random) -> Units:
    """Factors that change no digit: of masses the solver takes square roots, so they are powers of four."""
    return Units(2.0 ** rng.randint(-9, 9), 4.0 ** rng.randint(-9, 9), 2.0 ** rng.randint(-18, 18))


def powers_of_ten(rng: random.Random) -> Units:
    """From 1 nm to 1,000 km, from 1 mg to 1,000 t, from 1 us to 10,000 s."""
    return Units(10.0 ** rng.randint(-9, 6), 10.0 ** rng.randint(-6, 6), 10.0 ** rng.randint(-6, 4))


def assert_alike(seed: int, *motions: tuple[sb.Sweep, Array]) -> None:
    """Ends in the first units are apart by what the errors of all steps explain, unless both stopped on the way."""
    (first, x), (other, y) = motions
    if first.status[0].success:
        steps = first.counts[0, 0] + other.counts[0, 0]
        apart = float(np.abs(y - x).max() / max(1.0, np.abs(x).max()))
        assert apart <= GROWTH * RTOL * steps, (seed, apart)


def check(seeds: Iterable[int]) -> int:
    """Scale each mechanism by powers of two and of ten; return how many there were.

    Powers of two change no bit, but where coordinates have no mass: whether a tiny entry of J couples them or is
    rounding of zero is decided against rows that mix lengths and angles, so that entries within the ratio of
    units of that bound may count in one unit and not in another; the motion stays.
    """
    count = 0
    for seed in filter(is_scalable, seeds):
        rng = random.Random(f"scaling {seed}")
        eqs, lanes = formed(seed, rng.choice([None, "absolute"])), rng.random() < 0.1
        first, x = scaled_sweep(eqs, seed, ONE, SHARE, lanes=lanes, rtol=RTOL)
        same, y = scaled_sweep(eqs, seed, powers_of_two(rng), SHARE, rtol=RTOL)
        assert same.status == first.status, seed
        if np.array_equal(y, x):
            np.testing.assert_array_equal(same.counts, first.counts, err_msg=f"{seed}")
        else:
            assert has_massless(eqs, seed), (seed, np.abs(y - x).max())
            assert_alike(seed, (first, x), (same, y))
        other, z = scaled_sweep(eqs, seed, powers_of_ten(rng), SHARE, rtol=RTOL)
        assert other.status == first.status, seed
        assert_alike(seed, (first, x), (other, z))
        count += 1
    return count


@pytest.mark.exhaustive
def test_a_tiny_coupling_of_coordinates_without_mass() -> None:
    # Entries of J near 5e-12 beside ones: other bits in units half as long, the same motion.
    assert check((350, 368)) == 2


def test_scaled_mechanisms_move_as_before() -> None:
    # A spatial loop in joint coordinates, a tree in absolute ones.
    assert check((5, 14)) == 2


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_scaled_mechanisms_move_as_before_often(seeds: range) -> None:
    check(seeds)


def difference(first: Answer, other: Answer) -> float:
    """How far the numbers of two answers are apart, as a share of what is allowed."""
    if not first.numbers.size:
        return 0.0
    apart = np.abs(other.numbers - first.numbers).max() / max(1.0, np.abs(first.numbers).max())
    return float(apart) / first.allowed


def check_analysis(seed: int, name: str) -> float:
    """Ask one question in three units; return the larger difference, as a share of what is allowed."""
    rng = random.Random(f"scaled {name} {seed}")
    eqs = formed(seed, None if name in HEAVY else rng.choice([None, "absolute"]))
    first = answer(ANALYSES[name], Question(eqs, seed, ONE))
    found = []
    for units in (powers_of_two(rng), powers_of_ten(rng)):
        other = answer(ANALYSES[name], Question(eqs, seed, units))
        assert other.words == first.words, (seed, name, units)
        assert other.numbers.shape == first.numbers.shape, (seed, name, units)
        found.append(difference(first, other))
        if not found[1:] and name in SAME_BITS:
            np.testing.assert_array_equal(other.numbers, first.numbers, err_msg=f"{seed} {name}")
    assert max(found) <= 1.0, (seed, name, found)
    return max(found)


def check_analyses(seeds: Iterable[int]) -> None:
    """Ask each mechanism one question, drawn from all."""
    for seed in filter(is_scalable, seeds):
        check_analysis(seed, random.Random(f"question {seed}").choice(list(ANALYSES)))


@pytest.mark.parametrize(
    ("seed", "name"),
    [
        (30, "inverse_dynamics"),
        (31, "assemble"),
        (30, "Baumgarte"),
        pytest.param(5, "GeneralizedAlpha", marks=pytest.mark.exhaustive),
        pytest.param(5, "Baumgarte", marks=pytest.mark.exhaustive),
        pytest.param(84, "Baumgarte", marks=pytest.mark.exhaustive),
        pytest.param(202, "GGL", marks=pytest.mark.exhaustive),
    ],
)
def test_scaled_mechanisms_have_the_same_answers(seed: int, name: str) -> None:
    check_analysis(seed, name)


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_scaled_mechanisms_have_the_same_answers_often(seeds: range) -> None:
    check_analyses(seeds)
