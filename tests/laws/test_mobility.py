"""Law: degrees of freedom of random linkages that are built of parts whose freedoms are known.

On ground and on plates that are there already, cranks are pinned (one freedom more), pairs of bars from two
plates to one point (none), and plates on two or more equal parallel cranks (one more, however many cranks).
Parallel cranks beyond the second are redundant. In a plane that is turned in space, axes are no letters and
three closing equations of every loop are redundant as well.
"""

from __future__ import annotations

from random import Random

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import symbody as sb
from tests.problems.overconstrained import plates
from tests.tiers import cases


def random_linkage(seed: int) -> tuple[sb.Model, int]:
    """A linkage and its degrees of freedom."""
    random = Random(seed)
    points: dict[str, tuple[float, float]] = {}
    words: list[list[str]] = [[]]
    freedoms = 0

    def point(x: float, y: float) -> str:
        name = f"p{len(points)}"
        points[name] = (x, y)
        return name

    def anywhere() -> tuple[float, float]:
        return random.uniform(-1, 1), random.uniform(-1, 1)

    for k in range(random.randint(2, 4)):
        part = random.choice(["crank", "bars", "plate"]) if k else random.choice(["crank", "plate"])
        plate = random.choice(words)
        if part == "crank":
            words.append([pin := point(*anywhere()), point(*anywhere())])
            plate.append(pin)
            freedoms += 1
        elif part == "bars":
            other = random.choice([word for word in words if word is not plate])
            apex = point(*anywhere())
            for base in (plate, other):
                base.append(pin := point(*anywhere()))
                words.append([pin, apex])
        else:
            (x, y), moved = anywhere(), []
            for _ in range(random.randint(2, 4)):
                a, b = anywhere()
                plate.append(low := point(a, b))
                moved.append(high := point(a + x, b + y))
                words.append([low, high])
            words.append(moved)
            freedoms += 1
    turn = Rotation.random(random_state=seed).as_matrix() if random.random() < 0.5 else None
    pinned = {name: place for name, place in points.items() if sum(name in word for word in words) > 1}
    kept = [[name for name in word if name in pinned] for word in words]
    return plates(pinned, kept, turn), freedoms


def check(seed: int) -> None:
    model, freedoms = random_linkage(seed)
    eqs = sb.form_equations(model)
    count = eqs.mobility
    assert count.degrees_of_freedom == freedoms, (seed, count)
    if eqs.multiplier_names:
        found = sb.redundancy(eqs)
        assert found.degrees_of_freedom == freedoms, (seed, found)
        assert len(found.kept) == np.size(eqs.speed_names) - freedoms, (seed, found)


@pytest.mark.parametrize("seed", cases(range(12), fast=[1, 2, 3, 4, 6, 7, 8, 10, 11]))
def test_random_linkages_have_the_freedoms_of_their_parts(seed: int) -> None:
    check(seed)


@pytest.mark.exhaustive
@pytest.mark.parametrize("chunk", range(200))
def test_many_linkages_have_the_freedoms_of_their_parts(chunk: int) -> None:
    for seed in range(10 * chunk, 10 * chunk + 10):
        check(seed)
