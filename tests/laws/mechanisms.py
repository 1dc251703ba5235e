"""Random mechanisms: trees, planar and spatial loops of all joints, a third with constraints; always assembled.

Scale rule: a mechanism is made of numbers of order one and of masses over three decades, in its own units of
length, mass and time, each log-uniform over six decades. So parameters span six decades and more, while the
conditioning depends on the mechanism and not on the units; a threshold that is not relative shows.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from tests.laws.conditions import add_conditions, add_couplings
from tests.laws.drafts import Draft, Rejection
from tests.laws.draws import Draws
from tests.laws.loads import add_loads
from tests.laws.loops import MOST_BODIES, add_loops
from tests.laws.parts import Mechanism, Units

FAMILIES = ("tree",) * 28 + ("planar",) * 27 + ("spatial",) * 45
ATTEMPTS = 30
# Joints that bodies are hung on by, as often as they stand here.
_FLAT = ("revolute",) * 6 + ("prismatic",) * 2 + ("planar", "pin_slot", "rectangular")
_RARE = ("screw", "cylindrical", "universal", "constant_velocity", "pin_slot", "rectangular", "cartesian", "gimbal",
         "bearing", "telescoping")  # fmt: skip
_TREE = ("revolute",) * 4 + ("prismatic", "planar", "spherical") * 2 + ("free", "weld", "none", *_RARE)
_SPATIAL = ("revolute",) * 4 + ("prismatic", "planar", "free") + ("spherical",) * 5 + _RARE
_HANGERS = ("revolute", "prismatic", "spherical", "weld", "planar", "free", "none", *_RARE[::2])


def random_mechanism(seed: int, units: Units | None = None) -> Mechanism:
    """The mechanism of a seed; `units` replaces its own, with all ratios kept."""
    return _accepted(seed, f"{seed}", units, _attempt)


def turning_mechanism(seed: int, units: Units | None = None) -> Mechanism:
    """A small mechanism in which at least one body turns in any direction, in every parametrization of rotations.

    One or two bodies, a third of them with a loop, and loads and constraints as everywhere.
    """
    return _accepted(seed, f"turning {seed}", units, _turning)


def coupled_mechanism(seed: int) -> Mechanism:
    """A mechanism as `random_mechanism` makes them, with couplings of first degree between its joints."""
    return _accepted(seed, f"coupled {seed}", None, lambda seed, draws: _attempt(seed, draws, coupled=True))


def _accepted(
    seed: int, name: str, units: Units | None, attempt: Callable[[int, Draws], Mechanism]
) -> Mechanism:
    rejected: list[str] = []
    for number in range(ATTEMPTS):
        rng = random.Random(f"{name}/{number}")
        own = Units(*(10 ** rng.uniform(-3, 3) for _ in range(3)))
        try:
            return replace(attempt(seed, Draws(rng, units or own)), rejected=tuple(rejected))
        except Rejection as reason:
            rejected.append(str(reason))
    raise AssertionError(f"{name}: {Counter(rejected)}")


def _turning(seed: int, draws: Draws) -> Mechanism:
    rng = draws.rng
    draft = Draft(draws, t=draws.number(0.1, 2.0) * draws.units.time)
    draft.add_body(rng.choice(["spherical", "spherical", "free", "none"]))
    if draws.chance(0.5):
        draft.add_body(rng.choice(["spherical", "free", "revolute"]))
    loops = int(bool(draft.joints) and draws.chance(0.5))
    return _loaded(add_loops(draft, loops) if loops else draft.finished(), seed, "turning", draws)


def _loaded(found: Mechanism, seed: int, family: str, draws: Draws, *, coupled: bool = False) -> Mechanism:
    """The mechanism under gravity, with drives, springs, loads and constraints."""
    x, y, z = (draws.number() * draws.units.acceleration if draws.chance(0.85) else 0.0 for _ in range(3))
    found = replace(found, seed=seed, family=family, gravity=(x, y, z), symbolic=draws.chance(0.5))
    found = add_loads(found, draws)
    if coupled:
        found = add_couplings(found, draws)
        if not found.couplings:
            raise Rejection("no coupling fits")
    return add_conditions(found, draws)


def _attempt(seed: int, draws: Draws, *, coupled: bool = False) -> Mechanism:
    rng = draws.rng
    family = rng.choice(FAMILIES)
    loops = 0 if family == "tree" else rng.choice([1, 2, 2])
    draft = Draft(draws, t=draws.number(0.1, 2.0) * draws.units.time)
    if family == "planar":
        draft.normal = rng.choice("xyz")
        for _ in range(min(MOST_BODIES, 2 * loops + 1 + rng.choice([0, 0, 0, 1, 1, 2]))):
            draft.add_body(rng.choice(_FLAT))
    else:
        kinds = {"tree": _TREE, "spatial": _SPATIAL}[family]
        least = 1 + loops
        for _ in range(max(least, rng.choice([1, 1, 2, 2, 3, 3, 4, 4, 5, 6, 7]))):
            draft.add_body(rng.choice(kinds))
    found = add_loops(draft, loops) if loops else draft.finished()
    draft.normal = ""
    for _ in range(rng.choice([0, 0, 1, 2]) if loops and len(draft.bodies) < MOST_BODIES - 1 else 0):
        draft.add_body(rng.choice(_HANGERS))
        found = replace(draft.finished(), loops=found.loops, redundant=found.redundant)
    return _loaded(found, seed, family, draws, coupled=coupled)


def report(mechanisms: Iterable[Mechanism]) -> dict[str, float]:
    """Shares and counts of a set: loops, joint types, prescribed motions, rejections by reason."""
    listed = list(mechanisms)
    number = len(listed)
    kinds = Counter(joint.kind for m in listed for joint in m.joints)
    kinds["none"] = sum(len(m.placed) for m in listed)
    found = {f"joints {kind}": float(count) for kind, count in sorted(kinds.items())}
    found |= {
        f"closing {k}": float(n)
        for k, n in sorted(Counter(j.kind for m in listed for j in m.joints if j.closing).items())
    }
    found |= {f"family {k}": n / number for k, n in sorted(Counter(m.family for m in listed).items())}
    found["share with a loop"] = float(np.mean([m.loops >= 1 for m in listed]))
    found["share with two loops"] = float(np.mean([m.loops >= 2 for m in listed]))
    conditions = Counter(kind for m in listed for _, kind in m.constrained)
    found |= {f"constraints {kind}": float(count) for kind, count in sorted(conditions.items())}
    found["share with constraints"] = float(np.mean([bool(m.constrained) for m in listed]))
    found["share that moves"] = float(np.mean([m.freedoms >= 1 for m in listed]))
    found["share redundant"] = float(np.mean([m.redundant >= 1 for m in listed]))
    found["share with a motion"] = float(np.mean([any(j.motions for j in m.joints) for m in listed]))
    found["sequences"] = float(len({j.sequence for m in listed for j in m.joints if j.sequence}))
    reasons = Counter(reason for m in listed for reason in m.rejected)
    found |= {
        f"rejected: {reason}": count / (number + reasons.total()) for reason, count in sorted(reasons.items())
    }
    found["rejected"] = reasons.total() / (number + reasons.total())
    return found
