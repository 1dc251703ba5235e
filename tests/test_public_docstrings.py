"""Docstrings of public names are whole: every parameter, what is returned, an example that runs."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any

import pytest
from numpydoc.validate import Validator, validate

import symbody as sb

# Codes of numpydoc's validation: parameters that are missing, unknown, without type or description; no return
# value; no example; no summary.
CHECKED = {
    "GL08", "SS01", "PR01", "PR02", "PR04", "PR07", "RT01", "RT03", "YD01", "EX01",
}  # fmt: skip


def public_names() -> Iterator[tuple[str, Any]]:
    for name in sb.__all__:
        thing = getattr(sb, name)
        if callable(thing) and not (inspect.isclass(thing) and issubclass(thing, Exception)):
            yield f"{inspect.unwrap(thing).__module__}.{thing.__qualname__}", thing


def offences(path: str) -> list[str]:
    return [f"{code} {text}" for code, text in validate(path)["errors"] if code in CHECKED]


@pytest.mark.parametrize("path", sorted({path for path, _ in public_names()}))
def test_a_public_docstring_is_whole(path: str) -> None:
    assert offences(path) == []
    assert ">>>" in Validator(__import__("numpydoc.docscrape", fromlist=["x"]).get_doc_object(
        Validator._load_obj(path))).raw_doc
