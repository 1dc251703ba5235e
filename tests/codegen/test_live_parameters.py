"""Parameters are arguments of the code: one compilation for all values, and what values decide is decided anew."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.codegen import shared_code

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture
def compilations(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """The outputs of everything that was compiled in a test."""
    names: list[str] = []
    compile_code = shared_code.SharedCode.__init__

    def counted(self: shared_code.SharedCode, sequence: object, **choices: object) -> None:
        names.append(", ".join(output.name for output in sequence.outputs))
        compile_code(self, sequence, **choices)

    monkeypatch.setattr(shared_code.SharedCode, "__init__", counted)
    yield names


@cache
def example(name: str) -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))


def point(eqs: sb.EquationSet, seed: int = 1) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [
        rng.uniform(0.1, 0.9, len(names))
        for names in (eqs.coordinate_names, eqs.speed_names, eqs.input_names)
    ]


def agree(eqs: sb.EquationSet, values: dict[str, float | str], outputs: str = "udot") -> None:
    """Compiled for all values, and for these alone, gives the same to rounding."""
    q, u, r = point(eqs)
    live, alone = (
        sb.compile(eqs, outputs, values, specialize=choice)(0.3, q, u, r) for choice in (False, True)
    )
    np.testing.assert_allclose(live, alone, rtol=1e-9, atol=1e-9 * np.abs(alone).max())


def test_other_values_share_the_code(compilations: list[str]) -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / "four_bar" / "four_bar.toml"))
    for k in range(100):
        f = sb.compile(eqs, "udot", {"m2": 1.0 + 0.01 * k, "L2": 0.4 + 0.001 * k})
        assert np.isfinite(f(0.0, *point(eqs))).all()
    assert compilations == ["udot"]
    agree(eqs, {"m2": 1.99, "L2": 0.499})


def test_a_four_bar_becomes_a_parallelogram_and_what_it_was() -> None:
    """Redundant rows, a zero and a pivot change with the values; each time the code fits."""
    eqs = example("four_bar")
    for values in (
        {}, {"L2": 0.5, "L1": 0.3, "L3": 0.3, "L4": 0.5}, {"L1": 0.5}, {"H": 0}, {"L1": 0.4, "L3": 0.4}, {"m2": 0},
        {"m2": 0, "I2": 0}, {"m2": 1e-300}, {},
    ):  # fmt: skip
        agree(eqs, values)
        agree(eqs, values, "mass_matrix")


def test_a_slider_crank_with_equal_lengths_and_without_a_mass() -> None:
    eqs = example("slider_crank")
    for values in ({"L1": 1.0, "L2": 1.0}, {"m3": 0}, {"m2": 0, "I2": 0}, {"m2": 2}, {"G": 0}, {}):
        agree(eqs, values)


def test_a_spring_without_a_free_length_and_ends_that_meet() -> None:
    """0 times infinity is no number; a spring of no stiffness pulls with no force where its ends meet."""
    body = sb.Body("Body", mass="m")
    rail = sb.Prismatic("rail", "ground", body, coordinate="x", axis="x")
    spring = sb.SpringDamper("spring", "ground", "Body", stiffness="k", free="l")
    eqs = sb.form_equations(sb.Model("spring", [rail, spring], parameters={"m": 2, "k": 8, "l": 0.5}))
    for values, expected in (({}, -2.0), ({"l": 0}, -4.0), ({"k": 0}, 0.0), ({"l": 0.25}, -3.0), ({}, -2.0)):
        f = sb.compile(eqs, "udot", values)
        assert f(0.0, [1.0], [0.0]) == pytest.approx([expected], rel=1e-14, abs=0)
    assert sb.compile(eqs, "udot", {"k": 0})(0.0, [0.0], [0.0]) == [0.0]


def test_exact_angles_keep_what_is_exact_about_them() -> None:
    frames = {"tip": sb.Frame(at=(0, 1, 0), rotate=[("x", "a")])}
    arm = sb.Body("Arm", mass=1, inertia=(0.1, 0.1, 0.1), frames=frames)
    hand = sb.Body("Hand", mass=0, inertia=(0, 0, "I"))
    joints = [
        sb.Revolute("shoulder", "ground", arm, axis="z", coordinate="p"),
        sb.Revolute("wrist", "Arm.tip", hand, axis="z", coordinate="w"),
    ]
    eqs = sb.form_equations(sb.Model("wrist", [*joints], parameters={"a": "pi/2", "I": 0.2}))
    for angle in ("pi/2", 0.3, "pi/2", "pi/6", 1.1):
        live = sb.compile(eqs, "mass_matrix", {"a": angle})(0.0, [0.3, 0.2], [0.0, 0.0])
        alone = sb.compile(eqs, "mass_matrix", {"a": angle}, specialize=True)(0.0, [0.3, 0.2], [0.0, 0.0])
        np.testing.assert_allclose(live, alone, rtol=1e-14, atol=0.0 if isinstance(angle, str) else 1e-15)


def test_impossible_values_are_refused_each_time() -> None:
    eqs = example("slider_crank")
    for _ in range(2):
        for values in (
            {"m2": -1.0},
            {"mm": 1.0},
            {"m2": float("nan")},
            {"m2": "L1 - 1"},
            {"m2": "zz"},
            {"m2": True},
        ):
            with pytest.raises(sb.SymbodyError):
                sb.compile(eqs, "udot", values)
        agree(eqs, {"m2": "L1 + 1"})


def test_formulas_of_free_parameters_follow_them() -> None:
    eqs = example("slider_crank")
    q, u, r = point(eqs)
    f = sb.compile(eqs, "udot", {"L2": "2*L1 + 0.2", "m1": 3.0}, free=["L1", "G"])
    for length, g in ((0.4, 9.81), (0.3, 1.6), (0.3, 0.0)):
        values = {"L1": length, "L2": 2 * length + 0.2, "m1": 3.0, "G": g}
        expected = sb.compile(eqs, "udot", values, specialize=True)(0.0, q, u, r)
        assert f(0.0, q, u, r, np.array([length, g])) == pytest.approx(expected, rel=1e-12, abs=1e-12)
        assert f.bind([length, g])(0.0, q, u, r) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    with pytest.raises(sb.CompileError):
        f(0.0, q, u, r, np.array([0.4]))


def test_direct_calls_with_parameters_have_the_bits_of_a_batch() -> None:
    eqs = example("slider_crank")
    q, u, r = point(eqs)
    f = sb.compile(eqs, "udot", free=["m2", "L1"])
    rng = np.random.default_rng(4)
    sets = rng.uniform(0.3, 0.6, (20, 2))
    batch = f(0.0, q, u, r, sets)
    for _ in range(2):
        for p, expected in zip(sets, batch, strict=True):
            for _ in range(2):
                np.testing.assert_array_equal(f(0.0, q, u, r, p), expected)
    np.testing.assert_array_equal(f(0.0, q, u, r, sets[0]), batch[0])


def test_bound_values_are_pickled_and_written_into_source_text() -> None:
    eqs = example("slider_crank")
    q, u, r = point(eqs)
    f = sb.compile(eqs, "udot", {"m2": 2.75})
    again = pickle.loads(pickle.dumps(f))
    np.testing.assert_array_equal(again(0.1, q, u, r), f(0.1, q, u, r))
    assert again.signature == f.signature and again.inputs == f.inputs
    assert again.source("c") == f.source("c") == sb.generate_code(eqs, "udot", "c", parameters={"m2": 2.75})


def test_functions_with_other_values_do_not_disturb_each_other() -> None:
    eqs = example("slider_crank")
    q, u, r = point(eqs)
    functions = [sb.compile(eqs, "udot", {"m2": 1.0 + k}) for k in range(5)]
    expected = [f(0.0, q, u, r) for f in functions]
    for _ in range(3):
        for f, result in zip(functions, expected, strict=True):
            np.testing.assert_array_equal(f(0.0, q, u, r), result)
    assert len({tuple(result) for result in expected}) == 5
