"""The immutable mapping."""

from __future__ import annotations

import copy
import pickle

import pytest

from symbody.model.frozen_mapping import FrozenMapping


def test_it_is_a_copy_in_order() -> None:
    source = {"b": 1, "a": 2}
    table = FrozenMapping(source)
    source["c"] = 3
    assert list(table) == ["b", "a"]
    assert dict(table) == {"b": 1, "a": 2} and len(table) == 2


def test_it_compares_like_a_mapping_and_cannot_change() -> None:
    table = FrozenMapping({"a": 1})
    assert table == {"a": 1} and table == FrozenMapping({"a": 1}) and table != FrozenMapping({"a": 2})
    with pytest.raises(TypeError):
        table["a"] = 2
    with pytest.raises(KeyError):
        table["z"]


def test_it_pickles_and_copies() -> None:
    table = FrozenMapping({"a": (1, 2)})
    assert pickle.loads(pickle.dumps(table)) == table
    assert copy.deepcopy(table) == table


def test_empty() -> None:
    assert not FrozenMapping() and repr(FrozenMapping({"a": 1})) == "{'a': 1}"
