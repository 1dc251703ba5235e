"""Every model in the corpus obeys all laws; and the shrinker, which adds to it, keeps the elements it is given."""

from __future__ import annotations

from pathlib import Path

import pytest

import symbody as sb
from tests.laws import model_laws
from tests.laws.mechanisms import random_mechanism
from tests.laws.model_failures import written_failure
from tests.laws.model_files import model_with_state
from tests.laws.model_laws import ASSEMBLED, POWER, errors_of, worst
from tests.laws.model_states import equations_of, points
from tests.laws.shrinking import CORPUS, Shrinker, shrunk, write_to_corpus
from tests.laws.tally import Tally
from tests.tiers import cases

FILES = sorted(CORPUS.glob("*.toml"))
# Seeds with springs and revolute joints among much else, in a tree, a planar and a spatial loop.
SHRUNK = (3, 6)


# Of models of many bodies the ways in which they once failed; the exhaustive tier goes all ways.
LARGE = {
    "assembled_speeds_near_dependent", "cuts_of_screw_and_telescope", "gear_on_a_cut_coordinate",
    "projection_planar_bodies", "projection_planar_loops", "reactions_ill_conditioned",
}  # fmt: skip
FEW = {POWER, ASSEMBLED, "absolute", "joints", "generated code"}
# Seconds each; what they once broke is in the exhaustive tier, the speeds of the first one below, too.
SLOW = {
    "assembled_speeds_near_dependent",
    "projection_planar_loops",
    "reactions_ill_conditioned",
    "rows_rounding",
}


@pytest.mark.parametrize(
    "path", cases(FILES, fast=lambda path: path.stem not in SLOW), ids=lambda path: path.stem
)
def test_the_corpus_obeys_all_laws(path: Path) -> None:
    model = sb.load_model(path)
    found = errors_of(model, FEW if path.stem in LARGE else (), states=1)
    print(worst(found), found.left_out)
    assert not found.broken
    # Something was compared: with absolute coordinates at least, and with every other formulation.
    others = ("Newton-Euler", "Lagrange") if path.stem not in LARGE else ()
    assert {f"{way}: accelerations" for way in ("absolute", "generated code", *others)} <= set(found.errors)


def test_the_corpus_is_small_and_says_what_failed() -> None:
    assert 10 <= len(FILES) <= 16
    for path in FILES:
        assert path.read_text(encoding="utf-8").startswith("# "), path.name


def test_speeds_assembled_from_guesses_fit_the_constraints() -> None:
    model = sb.load_model(CORPUS / "assembled_speeds_near_dependent.toml")
    assert not errors_of(model, only={ASSEMBLED}, states=2).broken


@pytest.mark.exhaustive
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_the_corpus_obeys_all_laws_at_more_states(path: Path) -> None:
    assert not errors_of(sb.load_model(path), states=5).broken


def contains_spring_and_revolute(model: sb.Model) -> bool:
    has_spring = any(isinstance(element, sb.SpringDamper) for element in model.elements)
    return has_spring and any(isinstance(joint, sb.Revolute) for joint in model.joints)


@pytest.mark.parametrize("seed", cases(SHRUNK, fast=SHRUNK[:1]))
def test_what_is_not_needed_is_removed(seed: int) -> None:
    model = model_with_state(random_mechanism(seed))
    assert contains_spring_and_revolute(model)
    small = shrunk(model, contains_spring_and_revolute, seconds=20.0)
    assert contains_spring_and_revolute(small)
    # A spring, a revolute joint, the bodies at their ends and at most one more to hang one of them on.
    assert len(small.elements) <= 6 < len(model.elements)
    assert not small.parameters and not small.initial
    assert all(body.mass.text == "0" for body in small.bodies)


def heavy(model: sb.Model) -> bool:
    """A predicate on numbers: a mass above 2, and a frame turned by more than a radian."""
    turned = [turn for body in model.bodies for frame in body.frames.values() for turn in frame.rotate]
    values = [float(body.mass.constant() or 0) for body in model.bodies]
    angles = [turn[1].constant() for turn in turned]
    return any(value > 2 for value in values) and any(a is None or float(a) > 1 for a in angles)


def test_numbers_become_simple_and_angles_quarter_turns() -> None:
    body = sb.Body("B", mass=3.2718, inertia=(1.1, 1.2, 1.3), frames={"P": sb.Frame(rotate=[("z", 1.4321)])})
    joint = sb.Revolute("J", "ground", "B.P", axis=(0.36, 0.48, 0.8), coordinate="theta")
    model = sb.Model("turned", [body, joint], gravity=(0, 0, -9.81), initial={"theta": 0.3})
    assert heavy(model)
    small = shrunk(model, heavy, seconds=20.0)
    assert small.body("B").mass.text == "3"
    assert [turn[1].text for turn in small.body("B").frames["P"].rotate] == ["pi/2"]
    assert not small.initial and small.gravity == sb.Model("", []).gravity


def test_shrinking_ends_when_its_time_is_up() -> None:
    model = model_with_state(random_mechanism(6))
    shrinker = Shrinker(model, contains_spring_and_revolute, seconds=0.0)
    assert shrinker.shrink() == model and shrinker.tried == 0


def test_a_broken_law_is_written_to_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model_laws, "_power_error", lambda way, point: 7.0 * len(way.eqs.model.bodies))
    model = model_with_state(random_mechanism(20))
    path = written_failure(model, "random 20", seconds=5.0, folder=tmp_path)
    assert path is not None and path.name == f"{POWER.replace(' ', '_')}_random_20.toml"
    assert path.read_text(encoding="utf-8").startswith("# power balance were off by 7 times")
    assert len(sb.load_model(path).bodies) == 1


def test_a_law_that_files_do_not_show_is_told() -> None:
    tally = Tally()
    tally.enter(20, "artificial", 1e9)
    with pytest.raises(AssertionError, match="does not show at the level of a model file"):
        tally.close("artificial")


def test_a_saved_failure_is_the_model(tmp_path: Path) -> None:
    model = model_with_state(random_mechanism(3))
    path = write_to_corpus(model, "Some law", "what: 3", "first line\nsecond", tmp_path)
    assert path.name == "some_law_what_3.toml"
    assert path.read_text(encoding="utf-8").splitlines()[:2] == ["# first line", "# second"]
    assert sb.load_model(path) == model
    first, *_ = points(equations_of(sb.form_equations(model)), 1)
    assert first.known["t"] == 0.0
