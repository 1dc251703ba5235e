"""The content of models as bytes: the same for the same, and nothing for what is not ours."""

from __future__ import annotations

import pickle
from collections import OrderedDict
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import pytest

import symbody as sb
from symbody.expr.language.formula import Formula
from symbody.model.content import content_bytes


@dataclass(frozen=True)
class Foreign:
    mass: float = 1.0


class Name(str):
    """A text that may say something else tomorrow."""


def test_equal_values_have_equal_content() -> None:
    body = [sb.Body("B", mass="m", frames={"P": sb.Frame(at=(0, 1, "l"))}) for _ in range(2)]
    assert content_bytes(body[0]) == content_bytes(body[1]) != b""


def test_whatever_differs_has_other_content() -> None:
    things: list[object] = [
        0, 1, 1.0, -0.0, True, False, None, "1", "None", "f'1'", Formula.from_value("1"), Formula.from_value("1.0"), Fraction(1, 3),
        (), [], {}, (1,), (1, 2), ((1,), 2), ((1, 2),), {"a": 1}, {"a": 1, "b": 2}, {"b": 2, "a": 1}, ("a", 1),
        "a\nb", ("a", "b"), "é", "\udc80", sb.Body("A"), sb.Body("A", mass=1), sb.Body("B"), sb.VirtualWork(),
        sb.Lagrange(), sb.Trees(["a"], ["b"]), sb.Trees(["a", "b"], []),
    ]  # fmt: skip
    found = [content_bytes(thing) for thing in things]
    assert all(found)
    assert all(a != b for a, b in combinations(found, 2))


@pytest.mark.parametrize(
    "thing", [Foreign(), Foreign, len, lambda: 1, object(), Name("x"), 1j, OrderedDict(a=1)]
)
def test_what_is_not_ours_has_none(thing: object) -> None:
    assert content_bytes(thing) == b""
    assert content_bytes(("a", {"b": (1, thing)})) == b""


def test_depth_is_no_matter() -> None:
    deep: object = 1
    for _ in range(100_000):
        deep = (deep,)
    assert content_bytes(deep).endswith(b"1")


def test_tables_by_which_a_model_finds_its_parts_are_no_content() -> None:
    """They follow from its elements, and would be written once more."""
    model = sb.Model("one", [sb.Body("lonely")])
    shown = content_bytes(model.elements, model.bodies, model.notes)
    assert content_bytes(model).count(b"lonely") == shown.count(b"lonely")
    assert pickle.loads(pickle.dumps(model)).body("lonely") == model.body("lonely")
