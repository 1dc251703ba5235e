"""Lines of keys: every key of any TOML text, on the line where it stands."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator

import pytest
import tomlkit
from hypothesis import given
from hypothesis import strategies as st

from symbody.formats.places import Path, find_line, key_lines

TEXT = '''# a comment with name = "no"
name = "quoted \\" [x] # no comment"   # comment
a.b."c d".'e.f' = 1.5e-3
[parameters]
g = 9.81
list = [
  1.0, # one
  [2, """two
lines"""], {k = 1979-05-27 07:32:00, "z.w" = ']', n.m = [-0.5]},
]
"es\\u0041cape" = true
[[body]]
name = 'first'
[body.frames]
tip = { at = ["0", 1,
  "3"], rotate = [["z", "pi"]] }
[[body]]
[body.frames.top]
at = []
empty = {}
[[body.part]]
x = 1
[[body.part]]
x = 2
'''


def paths(value: object, path: Path = ()) -> Iterator[Path]:
    """All keys and list places of parsed data."""
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from paths(item, (*path, key))


def test_every_key_has_a_line() -> None:
    assert set(key_lines(TEXT)) == set(paths(tomllib.loads(TEXT)))


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("name",), 2),
        (("a", "b", "c d", "e.f"), 3),
        (("parameters", "g"), 5),
        (("parameters", "list"), 6),
        (("parameters", "list", 0), 7),
        (("parameters", "list", 1, 1), 8),
        (("parameters", "list", 2, "z.w"), 9),
        (("parameters", "list", 2, "n", "m", 0), 9),
        (("parameters", "esAcape"), 11),
        (("body", 0), 12),
        (("body", 0, "frames", "tip", "at", 2), 16),
        (("body", 0, "frames", "tip", "rotate", 0, 1), 16),
        (("body", 1), 17),
        (("body", 1, "frames"), 18),
        (("body", 1, "frames", "top", "empty"), 20),
        (("body", 1, "part", 0, "x"), 22),
        (("body", 1, "part", 1, "x"), 24),
    ],
)
def test_line_of_a_key(path: Path, line: int) -> None:
    assert key_lines(TEXT)[path] == line


def test_what_is_missing_is_found_at_what_holds_it() -> None:
    lines = key_lines(TEXT)
    assert find_line(lines, ("body", 1, "mass", 3)) == 17
    assert find_line(lines, ("joint", 0)) is None


SCALARS = st.one_of(st.integers(), st.booleans(), st.floats(allow_nan=False, allow_infinity=False), st.text())
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=12,
)


@given(st.dictionaries(st.text(), VALUES, max_size=5))
def test_every_key_of_any_text(data: dict[str, object]) -> None:
    try:
        text = tomlkit.dumps(data)
        parsed = tomllib.loads(text)
    except (ValueError, KeyError):  # keys and texts tomlkit writes wrongly
        return
    assert set(key_lines(text)) == set(paths(parsed))
