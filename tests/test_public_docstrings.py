"""Docstrings of public functions and classes are whole, by numpydoc's validation."""

from __future__ import annotations

import dataclasses
import inspect
from typing import Any

import pytest
from numpydoc.docscrape import get_doc_object
from numpydoc.validate import validate

import symbody as sb

# What the validation must not find: no docstring or summary, parameters that are missing, unknown, or without type
# or description, no word on what is returned, no example.
CHECKED = frozenset({"GL08", "SS01", "PR01", "PR02", "PR04", "PR07", "RT01", "RT03", "YD01", "EX01"})
FUNCTIONS = [name for name in sb.__all__ if inspect.isfunction(getattr(sb, name))]
CLASSES = [name for name in sb.__all__ if inspect.isclass(getattr(sb, name))]


def address(thing: Any) -> str:
    return f"{inspect.unwrap(thing).__module__}.{thing.__qualname__}"


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_says_all_its_parameters_and_shows_an_example(name: str) -> None:
    found = validate(address(getattr(sb, name)))["errors"]
    assert [error for error in found if error[0] in CHECKED] == []
    assert ">>>" in getattr(sb, name).__doc__


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_says_all_that_it_is_made_of(name: str) -> None:
    kind = getattr(sb, name)
    documentation = get_doc_object(kind)
    documented = {each.strip().lstrip("*") for part in ("Parameters", "Attributes")
                  for entry in documentation[part] for each in entry.name.split(",")}  # fmt: skip
    if dataclasses.is_dataclass(kind):
        own = [each for each in dataclasses.fields(kind) if each.init and each.name in kind.__annotations__]
        fields = {each.name for each in own if not each.name.startswith("_")}
        assert fields <= documented | OF_THE_PACKAGE
    assert documentation["Summary"]
    assert documentation["Examples"], "no example"
    assert "EX01" not in {code for code, _ in validate(address(kind))["errors"]}
    assert ">>>" in kind.__doc__


# Fields of results that later stages keep in them, which no user reads.
OF_THE_PACKAGE = frozenset({"plans", "variants"})


def test_a_docstring_with_gaps_is_found() -> None:
    codes = {code for code, _ in validate("tests.test_public_docstrings.address")["errors"]}
    assert {"GL08"} & codes
