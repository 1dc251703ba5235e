"""Sliders of pages on the command line."""

from __future__ import annotations

import pytest

from symbody.cli.pages import read_sliders
from symbody.errors import UsageError


def test_sliders_have_bounds_or_none() -> None:
    assert read_sliders(["m2=0.5:3", "theta"]) == {"m2": (0.5, 3.0), "theta": None}
    assert read_sliders(None) == {}


@pytest.mark.parametrize("text", ["m2=3", "m2=a:b", "=1:2", ""])
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_sliders([text])
    assert caught.value.problems[0].code == "cli.slider"
