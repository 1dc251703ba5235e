"""Law: what an action sets holds, in every loop, and no other way to the same equations changes what follows."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.errors import SymbodyError
from symbody.tolerances import CLOSED
from tests.laws.building import build_model
from tests.laws.holding import MOVES, movable, settings_of
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
# Couplings, of which every third has several leaders; small ones in the fast tier.
COUPLED = 60
QUICK_SEEDS = (1,)
# Loops count as closed when they are open by this share of their sizes, and rates that move at all do so by
# at least a twentieth of that: so far apart two closed states may be.
APART = CLOSED / MOVES
# An action adds to the value of a motion, and rounds once: a part in 1e15 of what is added to.
EXACT = 1e-14


def check(eqs: sb.EquationSet, rounds: int, seed: int) -> int:
    """Check that every state that can be set reads back what was set; count them."""
    names = movable(eqs, sb.assemble(eqs))
    if not names:
        return 0
    size = mechanism_scales(eqs, {}).length  # [m], and rad are numbers of order one
    run, settings = settings_of(eqs, names, rounds, seed)
    if run.status is sb.Status.NOT_FINITE and run.t.size == 1:
        return 0  # no acceleration follows from the model's own values: no motion in which anything could act
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
    """How far states are apart after each action with and without substitution, in their sizes."""
    model = build_model(coupled_mechanism(seed))
    both = sb.form_equations(model), sb.form_equations(model, substitute=True)
    try:
        state = sb.assemble(both[0])
    except SymbodyError:
        return []
    coupled = both[1].formed.coupled.leaders
    names = [
        name for name in movable(both[0], state)
        if name in both[1].state_names
        or (name.endswith("_dot") and name.removesuffix("_dot") in coupled)  # places of these: docs/limits.md
    ]  # fmt: skip
    if not names:
        return []
    (full, settings), (less, others) = (settings_of(eqs, names, 1, seed, state) for eqs in both)
    assert full.success and less.success and len(settings) == len(others)
    sizes = state_sizes(both[0], state)
    return [
        max(abs(float(full[name][one.sample] - less[name][other.sample])) / sizes[name] for name in sizes)
        for one, other in zip(settings, others, strict=True)
    ]


def state_sizes(eqs: sb.EquationSet, state: sb.State) -> dict[str, float]:
    """What counts as a large change of each coordinate and rate."""
    scales = mechanism_scales(eqs, {}, None, state.q)
    units = {"m": scales.length, "m/s": scales.length / scales.time, "rad/s": 1.0 / scales.time}
    return {name: units.get(eqs.units.get(name, ""), 1.0) for name in (*state.u, *state.q)}


@pytest.mark.parametrize(
    "seed",
    [pytest.param(k, marks=() if k in QUICK_SEEDS else pytest.mark.exhaustive) for k in range(COUPLED)],
)
def test_substitution_changes_nothing(seed: int) -> None:
    for difference in differences(seed):
        assert difference < APART


def led_mechanism(*, with_loop: bool) -> sb.Model:
    """Three shafts of which one turns as two of the others want, free or two of them the cranks of five bars."""
    parts = [
        sb.Body(name, mass=mass, inertia=(0.0, 0.0, moment), frames={"tip": sb.Frame((length, 0.0, 0.0))})
        for name, mass, moment, length in (
            ("A", 1.0, 0.4, 0.3), ("B", 2.0, 0.7, 0.4), ("C", 1.5, 1.1, 0.35), ("D", 0.5, 0.2, 0.5), ("E", 0.7, 0.3, 0.5),
        )
    ]  # fmt: skip
    parts += [
        sb.Revolute("JA", "ground", "A", coordinate="a"),
        sb.Revolute("JB", "ground", "B", coordinate="b"),
        sb.Revolute("JC", "ground.right", "C", coordinate="c"),
        sb.Revolute("JD", "B.tip", "D", coordinate="d"),
        sb.Revolute("JE", "C.tip", "E", coordinate="e"),
        sb.Constraint("K", "a - k*b - c"),
    ]
    if with_loop:
        parts.append(sb.Revolute("JF", "D.tip", "E.tip", coordinate="f"))
    return sb.Model(
        "shafts", parts, (0.0, -9.81, 0.0), {"k": 1.5}, ground={"right": sb.Frame((0.6, 0.0, 0.0))},
        initial={"b": 1.9, "c": 1.1, "d": -1.2, "e": 1.3, "a": 3.9},
    )  # fmt: skip


def lanes(eqs: sb.EquationSet, events: list[sb.Event]) -> list[sb.LaneStepper | sb.Stepper]:
    """Steppers in which values are first values, are set by actions, and follow a parameter."""
    alone = sb.Stepper(eqs, 0.02, initial={"b_dot": 0.5}, events=events)
    many = sb.LaneStepper(eqs, 0.02, 2, initial={"b_dot": [0.5, -0.5]}, events=events)
    for stepper in (alone, many):
        for _ in range(3):
            stepper.step()
    changed = alone.copy().set(k=1.4)
    again = alone.copy().reset(c=1.15, c_dot=0.2)
    return [alone, many, changed, again]


@pytest.mark.parametrize("with_loop", [False, True])
def test_a_coupling_of_several_leaders_is_closed_alike_when_it_is_substituted(with_loop: bool) -> None:
    model = led_mechanism(with_loop=with_loop)
    both = sb.form_equations(model), sb.form_equations(model, substitute=True)
    assert "a" not in both[1].coordinate_names
    events = [
        sb.Event("t - 0.01", action={"b_dot": "b_dot - 1"}, name="rate"),
        sb.Event("t - 0.03", action={"c": "c + 0.02"}, name="place"),
    ]
    sizes = state_sizes(both[0], sb.assemble(both[0]))
    first, second = (
        [
            sb.assemble(eqs, {"b_dot": -1.0}),
            sb.assemble(eqs, {"b": 1.95}),
            *lanes(eqs, events),
            sb.simulate(eqs, 0.05, initial={"c_dot": 1.0}, events=events).at(0.05),
            sb.sweep(eqs, 0.05, initial={"c": [1.1, 1.12]}, events=events, times=[0.0, 0.05]),
        ]
        for eqs in both
    )
    for one, other in zip(first, second, strict=True):
        for name, size in sizes.items():
            assert np.abs(np.asarray(one[name]) - np.asarray(other[name])).max() < APART * size, name


def test_the_others_share_what_a_leader_is_set_to() -> None:
    """With moments 1 and 3 of a and c, and a - b - c = 0, the least energy for b' = -1 is a' = -3/4, c' = 1/4."""
    bodies = [sb.Body(name, inertia=(0, 0, moment)) for name, moment in (("A", 1), ("B", 5), ("C", 3))]
    joints = [sb.Revolute(f"J{x}", "ground", x, coordinate=x.lower()) for x in "ABC"]
    model = sb.Model("shafts", [*bodies, *joints, sb.Constraint("K", "a - b - c")])
    for substitute in (False, True):
        eqs = sb.form_equations(model, substitute=substitute)
        run = sb.simulate(eqs, 0.2, events=sb.Event("t - 0.1", action={"b_dot": -1}))
        found = [run[name][-1] for name in ("a_dot", "b_dot", "c_dot")]
        np.testing.assert_allclose(found, [-0.75, -1.0, 0.25], rtol=0.0, atol=1e-14)
        state = sb.assemble(eqs, {"b": 0.2})
        np.testing.assert_allclose([state["a"], state["c"]], [0.1, -0.1], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_states_of_the_gallery_hold(path: Path) -> None:
    eqs = sb.form_equations(sb.load_model(path))
    if eqs.multiplier_names and eqs.speed_names and not eqs.formed.friction:
        check(eqs, 1, 0)
