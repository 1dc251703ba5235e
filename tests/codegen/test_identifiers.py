"""Names as identifiers: legal, distinct, stable."""

from __future__ import annotations

import json
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symbody.codegen.identifiers import MAX_LENGTH, assign_identifiers, quote_name

RESERVED = frozenset({"for", "double", "e"})

names = st.lists(
    st.one_of(st.text(max_size=8), st.text("ab_ 1'θ", max_size=3), st.sampled_from(sorted(RESERVED)))
)


@given(names)
def test_identifiers_are_legal_and_distinct(wanted: list[str]) -> None:
    words = assign_identifiers(wanted, RESERVED.__contains__)
    assert len(words) == len(wanted)
    assert len({word.lower() for word in words}) == len(wanted)
    for word in words:
        assert re.fullmatch(r"[A-Za-z]([A-Za-z0-9]|_(?!_|$))*", word)
        assert len(word) <= MAX_LENGTH
        assert word not in RESERVED
    assert words == assign_identifiers(wanted, RESERVED.__contains__)


@given(st.lists(st.from_regex(r"\A[a-df-z][a-z]{0,5}[0-9]{0,2}\Z"), unique=True))
def test_identifiers_keep_themselves_whatever_else_is_named(words: list[str]) -> None:
    kept = [word for word in words if word not in RESERVED]
    found = assign_identifiers([f"{word}'" for word in kept] + kept, RESERVED.__contains__)
    assert found[len(kept) :] == kept


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("theta", "theta"),
        ("θ₁", "theta1"),
        ("Θ", "Theta"),
        ("ω_AB", "omega_AB"),
        ("é", "e_"),
        ("x_{1}", "x_1"),
        ("q1'", "q1"),
        ("2nd", "x2nd"),
        ("", "x"),
        ("\U0001f600", "x"),
        ("a\u202eb", "a_b"),
        ("a  b", "a_b"),
        ("__init__", "init"),
        ("for", "x_for"),
        ("n" * 200, "n" * MAX_LENGTH),
    ],
)
def test_the_nearest_word(name: str, word: str) -> None:
    assert assign_identifiers([name], {"for"}.__contains__) == [word.rstrip("_")]


def test_many_equal_names_stay_distinct() -> None:
    words = assign_identifiers(["a"] * 2000 + ["n" * 99] * 2000, RESERVED.__contains__)
    assert len(set(words)) == 4000
    assert max(len(word) for word in words) <= MAX_LENGTH


@given(st.text())
def test_quoted_names_are_harmless_and_can_be_read_back(name: str) -> None:
    text = quote_name(name)
    assert text.isascii()
    assert text.isprintable()
    assert "*/" not in text
    assert "/*" not in text
    assert "??" not in text
    assert text[0] == text[-1] == '"'
    assert json.loads(text) == name


def test_names_that_differ_in_case_end_even_where_all_numbered_forms_are_reserved() -> None:
    # C reserves every M_...: mass m and mass M of one model must still get two identifiers.
    found = assign_identifiers(["m", "M"], lambda word: word.startswith("M_"))
    assert found == ["m", "x_M_2"]
