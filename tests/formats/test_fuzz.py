"""Mutated files: whatever is done to a model file, it is read, or refused in our own words."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symbody.errors import SymbodyError
from symbody.formats import from_data, load_model, model_from_toml, model_to_toml
from symbody.model import Model

ROOT = Path(__file__).parents[1]
SEEDS = [
    path.read_text(encoding="utf-8")
    for path in [
        *sorted(ROOT.parent.glob("examples/*/*.toml")),
        *sorted((ROOT / "faults" / "model_files").glob("*.toml")),
    ]
]
PIECES = [
    "",
    "[",
    "]",
    "[[",
    "{",
    "}",
    "=",
    '"',
    "'",
    '"""',
    "\n",
    "#",
    ".",
    ",",
    "nan",
    "-inf",
    "true",
    "1e999",
    "0x1F",
    "1979-05-27",
    "\\u0000",
    "\0",
    "\ufeff",
    "é",
    "\u202e",
    "[[joint]]\n",
    'type = "weld"\n',
    "name = 1\n",
    "**",
    "()",
    "ground",
    "t",
    "theta_dot",
    '"(" * 9',
    "9" * 30,
]
EDITS = st.lists(
    st.tuples(st.floats(0, 1), st.integers(0, 30), st.sampled_from(PIECES) | st.text(max_size=5)),
    min_size=1,
    max_size=4,
)


def mutated(text: str, edits: list[tuple[float, int, str]]) -> str:
    """Replace stretches of the text, given by place (0 to 1) and length."""
    for place, length, piece in edits:
        start = int(place * len(text))
        text = text[:start] + piece + text[start + length :]
    return text


def read_or_refused(text: str) -> Model | None:
    try:
        return model_from_toml(text, where="fuzz.toml")
    except SymbodyError as error:
        assert error.problems
        assert all(problem.code and problem.what and problem.where for problem in error.problems)
        assert str(error)
        return None


@given(st.sampled_from(SEEDS), EDITS)
@settings(max_examples=300)
def test_mutated_texts(seed: str, edits: list[tuple[float, int, str]]) -> None:
    model = read_or_refused(mutated(seed, edits))
    if model is not None:
        assert model_from_toml(model_to_toml(model)) == model


@pytest.mark.exhaustive
@given(st.sampled_from(SEEDS), EDITS)
@settings(max_examples=20_000)
def test_many_mutated_texts(seed: str, edits: list[tuple[float, int, str]]) -> None:
    model = read_or_refused(mutated(seed, edits))
    if model is not None:
        assert model_from_toml(model_to_toml(model)) == model


@given(st.sampled_from(SEEDS), st.data())
def test_truncated_files(seed: str, data: st.DataObject) -> None:
    read_or_refused(seed[: data.draw(st.integers(0, len(seed)))])


@given(st.binary(max_size=300), st.sampled_from(SEEDS), st.floats(0, 1))
def test_files_with_foreign_bytes(
    tmp_path_factory: pytest.TempPathFactory, noise: bytes, seed: str, place: float
) -> None:
    path = tmp_path_factory.mktemp("fuzz") / "model.toml"
    content = seed.encode()
    start = int(place * len(content))
    path.write_bytes(content[:start] + noise + content[start:])
    try:
        load_model(path)
    except SymbodyError as error:
        assert all(problem.fix for problem in error.problems)


LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    st.sampled_from(["ground", "A", "x", "A.f"]),
)
KEYS = st.sampled_from(
    [
        "name",
        "type",
        "between",
        "body",
        "joint",
        "frames",
        "ground",
        "at",
        "rotate",
        "matrix",
        "force",
        "torque",
        "spring",
        "axis",
        "mass",
        "inertia",
        "parameters",
        "initial",
        "inputs",
        "gravity",
        "layout",
        "version",
        "tree",
        "angles",
        "armature",
        "as_constraint",
        "coordinates",
        "motion",
        "on",
        "speed_names",
        "speeds",
        "vector",
    ]
) | st.text(max_size=3)
DATA = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(KEYS, inner, max_size=5),
    max_leaves=25,
)


@given(st.dictionaries(KEYS, DATA, max_size=8))
def test_any_data(data: dict[str, object]) -> None:
    try:
        model = from_data({"name": "fuzz", **data})
    except SymbodyError as error:
        assert all(problem.code and problem.what for problem in error.problems)
    else:
        json.dumps(model_to_toml(model))
