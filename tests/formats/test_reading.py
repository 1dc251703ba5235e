"""Files that are no text: each refused with its cause, none waits, none is read for ever."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from symbody.errors import FormatError
from symbody.formats.reading import MAX_BYTES, read_text
from tests.effort import limited


def fault_of(path: object) -> tuple[str, str]:
    with limited(2), pytest.raises(FormatError) as caught:  # the limit promised for any input
        read_text(path)
    (problem,) = caught.value.problems
    assert problem.fix and problem.where
    return problem.code, problem.what + problem.fix


FILES: dict[str, tuple[Callable[[Path], object], str]] = {
    "nothing": (lambda path: None, "file.missing"),
    "empty": (lambda path: path.write_bytes(b""), "file.empty"),
    "blank": (lambda path: path.write_bytes(b" \r\n\t\n"), "file.empty"),
    "only a byte order mark": (lambda path: path.write_bytes(b"\xef\xbb\xbf"), "file.empty"),
    "Latin-1": (lambda path: path.write_bytes("name = 'Käfer'".encode("latin-1")), "file.encoding"),
    "UTF-16": (lambda path: path.write_bytes("name = 'a'".encode("utf-16")), "file.encoding"),
    "all bytes": (lambda path: path.write_bytes(bytes(range(256)) * 10), "file.binary"),
    "program": (lambda path: path.write_bytes(b"\x7fELF\0\0\0"), "file.binary"),
    "huge": (lambda path: path.write_bytes(b"#" * (MAX_BYTES + 1)), "file.too_large"),
    "directory": (lambda path: path.mkdir(), "file.directory"),
    "pipe": (os.mkfifo, "file.not_a_file"),
    "link to itself": (lambda path: path.symlink_to(path), "file.link_loop"),
    "link to a device": (lambda path: path.symlink_to("/dev/zero"), "file.not_a_file"),
    "link to nothing": (lambda path: path.symlink_to("nowhere"), "file.missing"),
}


@pytest.mark.parametrize("kind", FILES)
def test_refused(tmp_path: Path, kind: str) -> None:
    make, code = FILES[kind]
    path = tmp_path / "model.toml"
    make(path)
    assert fault_of(path)[0] == code


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("/dev/zero", "file.not_a_file"),
        ("a\0b", "file.bad_path"),
        ("x" * 5000, "file.bad_path"),
        ("/no/such/place.toml", "file.missing"),
        (b"/no/such/bytes.toml", "file.missing"),
        ("", "file.missing"),
    ],
)
def test_bad_paths(path: object, code: str) -> None:
    assert fault_of(path)[0] == code


def test_file_used_as_directory(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("name = 'a'")
    assert fault_of(tmp_path / "a.toml" / "b.toml")[0] == "file.missing"


@pytest.mark.parametrize(
    ("number", "code"),
    [(errno.EACCES, "file.denied"), (errno.EIO, "file.unreadable"), (errno.EPERM, "file.denied")],
)
def test_refusals_of_the_system(monkeypatch: pytest.MonkeyPatch, number: int, code: str) -> None:
    # The superuser is denied nothing, so the refusal is played.
    def refuse(*arguments: object) -> int:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "open", refuse)
    assert fault_of("model.toml")[0] == code


def test_line_of_a_byte_that_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "model.toml"
    path.write_bytes(b"name = 'a'\n# caf\xe9\n")
    with pytest.raises(FormatError, match=r"model\.toml:2: byte 0xE9 in line 2"):
        read_text(path)


def test_similar_names_are_offered(tmp_path: Path) -> None:
    (tmp_path / "crank.toml").write_text("")
    assert "'crank.toml'" in fault_of(tmp_path / "cranc.toml")[1]


def test_mark_and_line_ends_are_taken_off(tmp_path: Path) -> None:
    path = tmp_path / "ä ö.toml"
    path.write_bytes(b"\xef\xbb\xbfname = 'a'\r\nx = 1\n")
    assert read_text(path) == "name = 'a'\nx = 1\n"
    assert read_text(str(path)) == read_text(os.fsencode(path))


def test_largest_file(tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_bytes(b"#" * MAX_BYTES)
    assert len(read_text(path)) == MAX_BYTES
