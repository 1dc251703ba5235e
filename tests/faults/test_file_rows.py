"""The fault checklist, J: model files. One test a row; the number is the row's.

Faults of contents lie in ``model_files``; how files are read and written is tested in full with the formats.
"""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from symbody.errors import FormatError
from symbody.formats import load_model, model_from_toml, save_model
from symbody.formats.native import from_data
from symbody.model import Model
from tests.effort import limited
from tests.faults.refusals import refused, refused_file


def text_refused(text: str | bytes, folder: Path) -> list[tuple[str, str]]:
    """What is wrong with the text of a file, which stays alone in its folder and as it was."""
    path = folder / "a.toml"
    content = text.encode() if isinstance(text, str) else text
    path.write_bytes(content)
    with limited(2):  # the limit promised for any input
        found = refused(lambda: load_model(path), FormatError)
    assert [entry.name for entry in folder.iterdir()] == ["a.toml"] and path.read_bytes() == content
    return [(code, where.replace(str(path), "a.toml")) for code, where in found]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('name = "a"\nname = "b"\n', 2),
        ('name = "a"\n[parameters]\nm = 1\nm = 2\n', 4),
        ('name = "a"\n[parameters]\nm = 1\n[parameters]\nk = 2\n', 4),
        ('name = "a"\n[ground.frames]\nN = { at = [0, 0, 0], at = [1, 0, 0] }\n', 3),
    ],
)
def test_row_105_keys_given_twice(text: str, line: int, tmp_path: Path) -> None:
    assert text_refused(text, tmp_path) == [("file.duplicate_key", f"a.toml:{line}")]
    refused_file("duplicate_key", "file.duplicate_key")


def test_row_106_unknown_keys_with_the_nearest() -> None:
    for name in ("unknown_key", "unknown_table", "unknown_drive_key"):
        refused_file(name, "file.unknown_key")
    text = 'name = "a"\n[[body]]\nname = "A"\nmas = 1\n'
    refused(lambda: model_from_toml(text), words="did you mean 'mass'?")


def test_row_106_wrong_types_with_path_and_what_is_expected() -> None:
    text = 'name = "a"\n[[body]]\nname = "A"\ninertia = [1, true, 1]\n'
    found = refused(lambda: model_from_toml(text, where="a.toml"), words="a number or an expression")
    assert found == [("file.wrong_type", "a.toml:4, body A, inertia[1]")]
    names = ("wrong_type_name", "wrong_type_table", "version_text", "parameter_bool", "parameter_date",
             "as_constraint_text", "gravity_text", "tree_text")  # fmt: skip
    for name in names:
        refused_file(name, "file.wrong_type")


@pytest.mark.parametrize(
    "text",
    [
        "!!python/object/apply:os.getpid []\n",
        'a: &a ["x","x"]\nb: &b [*a,*a]\nc: &c [*b,*b]\nd: [*c,*c]\n',
        "name: a\nbody:\n  - name: A\n",
    ],
)
def test_row_107_yaml_is_not_read(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.partition(".")[0] == "yaml"]:
        monkeypatch.delitem(sys.modules, name)  # other tests import it
    assert text_refused(text, tmp_path) == [("file.syntax", "a.toml:1")]
    assert "yaml" not in sys.modules


def test_row_108_numbers_that_json_lets_through() -> None:
    text = '{"name": "a", "body": [{"name": "A", "mass": NaN}], "parameters": {"m": 1e400, "k": -Infinity}}'
    assert refused(lambda: from_data(json.loads(text))) == [
        ("file.not_finite", "#/parameters/m, parameters.m"),
        ("file.not_finite", "#/parameters/k, parameters.k"),
        ("file.not_finite", "#/body/0/mass, body A, mass"),
    ]


@pytest.mark.parametrize(
    ("value", "code"),
    [("nan", "file.not_finite"), ("-inf", "file.not_finite"), ("1e400", "expression.number")],
)
def test_row_108_numbers_that_toml_lets_through(value: str, code: str) -> None:
    text = f'name = "a"\n[parameters]\nm = {value}\n'
    ((found, where),) = refused(lambda: model_from_toml(text, where="a.toml"))
    assert found == code and where.startswith("a.toml:3, ")


@pytest.mark.parametrize("opening", ["x = " + "[" * 20_000 + "]" * 20_000, "x = " + "{a=" * 20_000])
def test_row_109_deep_nesting_in_toml(opening: str, tmp_path: Path) -> None:
    assert text_refused(f'name = "a"\n{opening}\n', tmp_path) == [("file.too_complex", "a.toml")]


@pytest.mark.parametrize(
    "path", [("body",), ("body", "entry"), ("gravity", "entry"), ("parameters", "m"), ("version",), ("name",)]
)
def test_row_109_deep_nesting_in_data(path: tuple[str, ...]) -> None:
    deep: dict[str, object] = {}
    for _ in range(5000):
        deep = {"a": deep}
    wrapped: object = deep
    for part in path[:0:-1]:
        wrapped = [wrapped] if part == "entry" else {part: wrapped}
    for code, where in refused(lambda: from_data({"name": "a", path[0]: wrapped})):
        assert code.startswith("file.") and where.startswith(f"#/{path[0]}")


def test_row_109_whole_numbers_of_5000_digits(tmp_path: Path) -> None:
    digits = "9" * 5000
    assert text_refused(f'name = "a"\n[parameters]\nm = {digits}\n', tmp_path) == [
        ("file.too_complex", "a.toml")
    ]
    for data in ({"name": 10**5000}, {"name": "a", "version": 10**5000}, {"name": "a", "gravity": 10**5000}):
        refused(lambda data=data: from_data(data), FormatError)
    assert refused(lambda: from_data({"name": "a", "parameters": {"m": 10**5000}})) == [
        ("expression.number", "#/parameters/m, parameters.m")
    ]


@pytest.mark.parametrize(
    ("content", "code", "place"),
    [
        ("name = 'Käfer'".encode("latin-1"), "file.encoding", "a.toml:1"),
        ("name = 'a'".encode("utf-16"), "file.encoding", "a.toml"),
        (b"", "file.empty", "a.toml"),
        (b"\xef\xbb\xbf \r\n", "file.empty", "a.toml"),
        (b"\x7fELF\0\0\0", "file.binary", "a.toml"),
        (b'name = "a"\nx = [1,\n', "file.syntax", "a.toml:3"),
        (b"#" * 10_000_001, "file.too_large", "a.toml"),
    ],
    ids=["latin-1", "utf-16", "empty", "mark alone", "binary", "truncated", "10 MB"],
)
def test_row_110_contents_that_are_no_model(content: bytes, code: str, place: str, tmp_path: Path) -> None:
    assert text_refused(content, tmp_path) == [(code, place)]
    refused_file("truncated", "file.syntax")


def test_row_110_byte_order_mark_and_line_ends_of_windows(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_bytes(b'\xef\xbb\xbfname = "a"\r\n[parameters]\r\nm = 1\r\n')
    assert load_model(path) == Model("a", parameters={"m": 1})


PLACES: dict[str, tuple[Callable[[Path], object], str]] = {
    "directory": (lambda path: path.mkdir(), "file.directory"),
    "pipe": (os.mkfifo, "file.not_a_file"),
    "link to itself": (lambda path: path.symlink_to(path), "file.link_loop"),
    "endless device": (lambda path: path.symlink_to("/dev/zero"), "file.not_a_file"),
    "nothing": (lambda path: None, "file.missing"),
}


@pytest.mark.parametrize("kind", PLACES)
def test_row_110_places_that_are_no_files(kind: str, tmp_path: Path) -> None:
    make, code = PLACES[kind]
    path = tmp_path / "a.toml"
    make(path)
    assert refused(lambda: load_model(path)) == [(code, str(path))]


def test_row_110_permission_denied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The superuser is denied nothing, so the refusal is played.
    def deny(*arguments: object) -> int:
        raise PermissionError(errno.EACCES, "Permission denied")

    path = tmp_path / "a.toml"
    path.write_text('name = "a"\n')
    monkeypatch.setattr(os, "open", deny)
    assert refused(lambda: load_model(path)) == [("file.denied", str(path))]


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_row_110_a_full_disk_costs_nothing(
    step: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.toml"
    save_model(Model("old"), path)
    old = path.read_bytes()

    def fail(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, step, fail)
        found = refused(lambda: save_model(Model("new"), path), words="free some space")
    assert found == [("file.not_saved", str(path))]
    assert {entry.name: entry.read_bytes() for entry in tmp_path.iterdir()} == {"a.toml": old}
    save_model(Model("new"), path)
    assert (tmp_path / "a.toml.bak").read_bytes() == old
    assert load_model(path) == Model("new")
