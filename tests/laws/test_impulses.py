"""Law: where prescribed rates jump, speeds jump by what the joints transmit, whoever holds the constraints.

Random mechanisms run into corners and steps of their motions. The speeds with which they arrive are those they
come from, as exactly as errors on the way allow. The jump has no such errors: from the state in fact reached it
is that of `tests.laws.impulses` to rounding, and the energy that comes is the work done. A motion with rounded
corners comes the closer to the struck one the sharper they are.
"""

from __future__ import annotations

import random
from collections.abc import Iterable

import numpy as np
import pytest

import symbody as sb
from symbody.graph.trees import TreeChoice
from symbody.model import resolve_parameters
from tests.laws.agreement import random_trees
from tests.laws.evaluation import EPS
from tests.laws.impulses import Struck, struck
from tests.laws.motions import FRAMES
from tests.laws.rotations import Array
from tests.laws.scaling import factor
from tests.laws.tally import BOUND, chunks, name_of
from tests.tiers import cases

BEFORE, BEHIND = 0.1, 0.05  # shares of the mechanism's unit of time
HAIR = 1e-12
RTOL = 1e-9
# What the errors of all steps leave, as a share of the largest rate and energy. Backward differentiation
# controls the last correction instead of the error, which is some hundred times less exact.
ALLOWED = {"explicit": 1e-8, "implicit": 1e-6}
# By which the start is disturbed, to see how errors on the way grow.
DISTURBED = 1e-6
# By how much projected positions may be open, whatever rtol is, as a share of the mechanism's size.
CLOSED = sb.Projection().tolerance
WIDTHS = (1e-3, 1e-4)  # of rounded corners, in the unit of time
Way = dict[str, object]


def ways(time: float) -> list[tuple[str, Way]]:
    """Integrators and ways to hold constraints, in the mechanism's unit of time."""
    return [
        ("explicit", {}),
        ("explicit", {"integrator": sb.Explicit(order=5)}),
        ("explicit", {"integrator": sb.FixedStep(BEFORE * time / 200)}),
        ("explicit", {"constraints": sb.Partition()}),
        ("explicit", {"constraints": sb.Baumgarte(alpha=5.0 / time, beta=5.0 / time)}),
        ("implicit", {"integrator": sb.Stiff()}),
        ("implicit", {"constraints": sb.GGL()}),
    ]


def tree_of(case: Struck, rng: random.Random) -> TreeChoice:
    """The automatic choice, absolute coordinates or, for loops, any pair of trees."""
    choices: list[TreeChoice] = [None, "absolute"]
    if case.mechanism.loops:
        choices.append(random_trees(case.mechanism, rng))
    return rng.choice(choices)


def formed(case: Struck, tree: TreeChoice, width: float = 0.0) -> sb.EquationSet:
    """The equations, without rows that are only rounding at the values of the parameters."""
    eqs = sb.form_equations(case.model(width), tree=tree)
    values = {name: float(value) for name, value in resolve_parameters(eqs.model).items()}
    return eqs.for_values(values) if eqs.multiplier_names else eqs


def start(eqs: sb.EquationSet, case: Struck) -> tuple[float, dict[str, float]]:
    """Where the motion that arrives at the pose comes from: backwards from a hair before the corner.

    Where a driven mechanism cannot have been so far back, it is where it was half of the way.
    """
    t, time = case.mechanism.t, case.mechanism.units.time
    names = (*eqs.coordinate_names, *eqs.speed_names)
    known = {name: case.before.known[name] for name in names}
    span = (t - HAIR * time, t - BEFORE * time)
    run = sb.simulate(eqs, span, guess=known, inputs=case.mechanism.inputs, rtol=RTOL)
    if not run.success:
        assert breaks_off(case, eqs, span, known, run, run.u[:, 0]), run.notes
        span = (span[0], span[0] + 0.5 * float(run.t[-1] - span[0]))
        run = sb.simulate(eqs, span, guess=known, inputs=case.mechanism.inputs, rtol=RTOL)
        assert run.success, run.notes
    return float(run.t[-1]), {name: float(run[name][-1]) for name in names}


def corner(case: Struck, run: sb.Trajectory) -> slice:
    """The last sample before the corner and the first behind it."""
    place = int(np.argmin(np.abs(run.t - case.mechanism.t)))
    apart = np.diff(run.t[place - 1 : place + 2])
    place += int(np.argmin(apart)) - 1
    assert run.t[place + 1] - run.t[place] < 1e-7 * case.mechanism.units.time
    return slice(place, place + 2)


def sides(eqs: sb.EquationSet, case: Struck, run: sb.Trajectory) -> dict[str, Array]:
    """Speeds, energy and work before and behind the corner, (2,)."""
    return {name: run[name][corner(case, run)] for name in (*eqs.speed_names, "energy", "work")}


def arrived(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> Struck:
    """What the corners do to the state that the motion has in fact when it comes to them."""
    k = corner(case, run).start
    bodies = [body.name for body in case.mechanism.bodies]
    words = [word.format(name) for name in bodies for word in FRAMES]
    inputs = list(case.mechanism.inputs.values())
    found = iter(sb.compile(eqs, words)(run.t[k], run.q[:, k], run.u[:, k], inputs))
    places, twists = {"ground": case.before.places["ground"]}, {}
    for name in bodies:
        places[name] = (next(found), next(found))
        twists[name] = (next(found), next(found))
    return case.at(places, twists)


def openness(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> float:
    """How far joints, constraints and the norms of quaternions are open at the corner, as a share.

    Methods without projection keep norms within their tolerance; rotations are off by twice as much.
    """
    place = corner(case, run)
    norms = [np.linalg.norm([run[name][place] for name in names], axis=0) for names in eqs.quaternions]
    largest = [2.0 * np.abs(norm - 1.0).max() for norm in norms]
    return float(max([run["constraint_violation"][place].max(), *largest]))


def arrival_error(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> float:
    """How far speeds before the corner are from those that the motion comes from, as a share."""
    found = sides(eqs, case, run)
    errors = [
        abs(found[name][0] - case.before.known[name]) / unit(case, eqs, name) for name in eqs.speed_names
    ]
    return float(max(errors))


def jump_error(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> float:
    """How far speeds on both sides of the corner, energy and work are from the balance there, as a share."""
    found = sides(eqs, case, run)
    both = [[state.known[name] for state in (case.before, case.behind)] for name in eqs.speed_names]
    errors = [
        np.abs(found[name] - pair).max() / unit(case, eqs, name)
        for name, pair in zip(eqs.speed_names, both, strict=True)
    ]
    errors += [abs(float(np.diff(found[name])[0]) - case.gained) / case.energy for name in ("energy", "work")]
    return float(max(errors))


def unit(case: Struck, eqs: sb.EquationSet, name: str) -> float:
    """The largest rate, in the unit of a speed."""
    return case.speed * factor(eqs.units.get(name), case.mechanism.units)


def growth(case: Struck, eqs: sb.EquationSet, t: float, at: dict[str, float]) -> float:
    """How much larger than relative errors of the start their effects are before the corner, as shares."""
    rng = random.Random(f"growth {case.mechanism.seed}")
    span = (t, case.mechanism.t - HAIR * case.mechanism.units.time)
    signs = {name: rng.choice((-1.0, 1.0)) for name in at}
    speeds = []
    for side in (-1.0, 1.0):
        start = {name: x * (1.0 + side * DISTURBED * signs[name]) for name, x in at.items()}
        run = sb.simulate(eqs, span, guess=start, inputs=case.mechanism.inputs, rtol=RTOL, times=span[1:])
        assert run.success, run.notes
        speeds.append(np.array([run[name][-1] / unit(case, eqs, name) for name in eqs.speed_names]))
    return float(np.abs(speeds[1] - speeds[0]).max()) / (2.0 * DISTURBED)


def ends(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> Array:
    """Coordinates and speeds at the end, in the mechanism's units."""
    names = (*eqs.coordinate_names, *eqs.speed_names)
    return np.array([run[name][-1] / factor(eqs.units.get(name), case.mechanism.units) for name in names])


def rounded_errors(
    case: Struck, tree: TreeChoice, span: tuple[float, float], at: dict[str, float], last: Array
) -> list[float]:
    """How far motions with rounded corners end from the struck one."""
    found = []
    for width in WIDTHS:
        eqs = formed(case, tree, width * case.mechanism.units.time)
        run = sb.simulate(eqs, span, guess=at, inputs=case.mechanism.inputs, rtol=RTOL)
        assert run.success, run.notes
        found.append(float(np.abs(ends(case, eqs, run) - last).max()))
    return found


def breaks_off(
    case: Struck, eqs: sb.EquationSet, span: tuple[float, float], at: dict[str, float], run: sb.Trajectory,
    usual: Array,
) -> bool:  # fmt: skip
    """Whether a driven mechanism has no motion beyond the end of a run: rates grow as it comes near.

    Then another integrator, with the speeds chosen anew at each step, ends there too.
    """
    other = sb.simulate(
        eqs, span, guess=at, inputs=case.mechanism.inputs, rtol=RTOL, constraints=sb.Partition()
    )
    apart = abs(float(other.t[-1] - run.t[-1]))
    grown = float(np.abs(run.u[:, -1]).max() / np.abs(usual).max())
    return not other.success and apart < 0.01 * BEHIND * case.mechanism.units.time and grown > 5


def sides_at(case: Struck, eqs: sb.EquationSet, run: sb.Trajectory) -> Array:
    """All speeds on both sides of the corner."""
    both = sides(eqs, case, run)
    return np.array([both[name] for name in eqs.speed_names])


def check(seed: int, rounded: bool) -> float | None:
    """Return the largest error as a share of what is allowed; None where there is nothing to strike."""
    case = struck(seed)
    if case is None:
        return None
    rng, time = random.Random(f"struck {seed}"), case.mechanism.units.time
    tree, (kind, way) = tree_of(case, rng), rng.choice(ways(time))
    eqs = formed(case, tree)
    t, at = start(eqs, case)
    span = (t, case.mechanism.t + BEHIND * time)
    run = sb.simulate(eqs, span, guess=at, inputs=case.mechanism.inputs, rtol=RTOL, **way)  # type: ignore[arg-type]
    passed = run.success or breaks_off(case, eqs, span, at, run, sides_at(case, eqs, run))
    assert passed, (seed, way, run.notes)
    assert any("prescribed rates jump" in note for note in run.notes), (seed, run.notes)
    late = arrival_error(case, eqs, run) / (ALLOWED[kind] + CLOSED * case.magnified)
    if late >= 1:
        late /= max(1.0, growth(case, eqs, t, at))
    open_by = max(CLOSED, openness(case, eqs, run))
    there = arrived(case, eqs, run)
    jump = jump_error(there, eqs, run) / (BOUND * EPS * there.condition + open_by * there.magnified)
    assert max(late, jump) < 1, (seed, way, late, jump)
    if rounded and run.success:
        first, second = rounded_errors(case, tree, span, at, ends(case, eqs, run))
        assert second < 0.2 * first + ALLOWED[kind] * case.speed, (seed, way, first, second)
    return max(late, jump)


def check_all(seeds: Iterable[int]) -> None:
    shares = [share for seed in seeds if (share := check(seed, rounded=seed % 8 == 0)) is not None]
    print(f"{len(shares)} struck, with at most {max(shares, default=0.0):.2g} of the errors allowed")


# In 105 there are rows in t that always hold: their rounding is no jump. 146 locks up behind the corner; 162
# cannot have come from farther away than six tenths of the way.
@pytest.mark.parametrize("seed", cases([0, 6, 9, 11, 105, 146], fast=[0, 9]))
def test_speeds_jump_by_what_the_joints_transmit(seed: int) -> None:
    check_all([seed])


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(2000), ids=name_of)
def test_speeds_jump_by_what_the_joints_transmit_often(seeds: range) -> None:
    check_all(seeds)
