"""Law: what an action sets holds, in every loop, and no other way to the same equations changes what follows."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.errors import SymbodyError
from symbody.tolerances import CLOSED
from tests.laws.building import build_model
from tests.laws.holding import movable, settings_of
from tests.laws.mechanisms import coupled_mechanism, random_mechanism
from tests.laws.tally import chunks, name_of

GALLERY = Path(__file__).parents[2] / "examples" / "gallery"
# Small mechanisms with loops: the fast tier spends its time on settings, not on compiling.
SMALL = (13, 16, 19, 21)
ROUNDS = 5
NUMBER = 2000  # settings of the exhaustive tier
SEEDS = 320  # seven settings each on the average
QUICK = {"crank_rocker", "planetary_gear"}
FILES = [
    path if path.stem in QUICK else pytest.param(path, marks=pytest.mark.exhaustive)
    for path in sorted(GALLERY.glob("*/*.toml"))
]
# An action adds to the value of a motion, and rounds once: a part in 1e15 of what is added to.
EXACT = 1e-14


def check(eqs: sb.EquationSet, rounds: int, seed: int) -> int:
    """Check that every state that can be set reads back what was set; count them."""
    names = movable(eqs, sb.assemble(eqs))
    if not names:
        return 0
    size = mechanism_scales(eqs, {}).length  # [m], and rad are numbers of order one
    run, settings = settings_of(eqs, names, rounds, seed)
    assert run.success, run.notes
    assert len(settings) == rounds * len(names)
    # Where `Partition` keeps a mechanism on its branch, it solves for dependent coordinates once more.
    share = CLOSED if any("sb.Partition()" in note for note in run.notes) else EXACT
    for setting in settings:
        found = float(run[setting.name][setting.sample])
        assert abs(found - setting.asked) <= share * max(size, abs(setting.asked)), setting
    return len(settings)


def equations(seed: int) -> sb.EquationSet | None:
    """The equations of a random mechanism with a loop; None where its model's own values cannot start it."""
    try:
        eqs = sb.form_equations(build_model(random_mechanism(seed)))
        sb.assemble(eqs)
    except SymbodyError:
        return None
    return eqs if eqs.multiplier_names and eqs.speed_names else None


def check_seeds(seeds: Iterable[int], rounds: int) -> int:
    found = ((seed, equations(seed)) for seed in seeds)
    return sum(check(eqs, rounds, seed) for seed, eqs in found if eqs is not None)


def test_states_of_random_loops_hold() -> None:
    assert check_seeds(SMALL, ROUNDS) >= 200


@pytest.mark.exhaustive
@pytest.mark.parametrize("seeds", chunks(SEEDS), ids=name_of)
def test_states_of_all_random_loops_hold(seeds: range) -> None:
    assert check_seeds(seeds, 1) * SEEDS >= NUMBER * len(seeds) / 4  # chunks differ


def differences(seed: int) -> list[float]:
    """How far speeds are apart after each action with and without substitution, in their sizes."""
    model = build_model(coupled_mechanism(seed))
    both = sb.form_equations(model), sb.form_equations(model, substitute=True)
    try:
        state = sb.assemble(both[0])
    except SymbodyError:
        return []
    coupled = both[1].formed.coupled.leaders
    names = [
        name for name in movable(both[0], state)
        if name in both[0].speed_names and (name in both[1].state_names or name.removesuffix("_dot") in coupled)
    ]  # fmt: skip
    if not names:
        return []
    (full, settings), (less, others) = (settings_of(eqs, names, 1, seed, state) for eqs in both)
    assert full.success and less.success and len(settings) == len(others)
    scales = mechanism_scales(both[0], {}, None, state.q)
    units = {name: scales.length if both[0].units[name] == "m/s" else 1.0 for name in state.u}
    return [
        max(
            abs(float(full[name][one.sample] - less[name][other.sample])) * scales.time / units[name]
            for name in state.u
        )
        for one, other in zip(settings, others, strict=True)
    ]


@pytest.mark.parametrize(
    "seed", [pytest.param(k, marks=() if k in (1, 3) else pytest.mark.exhaustive) for k in range(20)]
)
def test_substitution_changes_nothing(seed: int) -> None:
    for difference in differences(seed):
        assert difference < 1e-9


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_states_of_the_gallery_hold(path: Path) -> None:
    eqs = sb.form_equations(sb.load_model(path))
    if eqs.multiplier_names and eqs.speed_names and not eqs.formed.friction:
        check(eqs, 1, 0)
