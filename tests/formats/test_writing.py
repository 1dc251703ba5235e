"""Saving: all or nothing, with the old content kept."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest

import symbody as sb
from symbody.errors import FormatError, ModelError
from symbody.formats.writing import write_text


def content(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def test_new_file(tmp_path: Path) -> None:
    write_text(tmp_path / "a.toml", "name = 'ä'\n")
    assert (tmp_path / "a.toml").read_bytes() == "name = 'ä'\n".encode()
    assert content(tmp_path).keys() == {"a.toml"}


def test_new_file_has_the_usual_permissions(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_text(tmp_path / "a.toml", "x")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "a.toml").stat().st_mode) == 0o640


def test_permissions_of_other_threads_stay_what_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Files that another thread creates while this one asks had the permissions 0o666.
    monkeypatch.setattr(os, "umask", lambda mask: pytest.fail(f"umask({mask}) holds for all threads"))
    write_text(tmp_path / "a.toml", "x")
    assert (tmp_path / "a.toml").read_text() == "x"


def test_old_content_and_permissions_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    path.write_text("old")
    path.chmod(0o604)
    write_text(path, "new")
    write_text(path, "newer")
    assert content(tmp_path) == {"a.toml": "newer", "a.toml.bak": "new"}
    assert stat.S_IMODE(path.stat().st_mode) == 0o604


def test_saving_the_same_text_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.toml"
    write_text(path, "text")
    before = path.stat().st_mtime_ns, path.stat().st_ino
    write_text(path, "text")
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == before
    assert content(tmp_path).keys() == {"a.toml"}


def test_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "real.toml").write_text("old")
    link = tmp_path / "link.toml"
    link.symlink_to("real.toml")
    write_text(link, "new")
    assert link.is_symlink()
    assert (tmp_path / "real.toml").read_text() == "new"


@pytest.mark.parametrize("step", ["fsync", "replace"])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EACCES])
def test_a_failing_step_leaves_the_old_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, number: int
) -> None:
    path = tmp_path / "a.toml"
    path.write_text("old")

    def fail(*arguments: object) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(FormatError) as caught:
        write_text(path, "new")
    (problem,) = caught.value.problems
    assert problem.code == "file.not_saved" and problem.fix
    assert content(tmp_path) == {"a.toml": "old"}


def test_a_crash_while_writing_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.toml"
    path.write_text("old")

    def interrupt(descriptor: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_text(path, "new")
    assert content(tmp_path) == {"a.toml": "old"}


@pytest.mark.parametrize("name", ["", "no/such/folder/a.toml", "a\0b", "x" * 300])
def test_impossible_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(FormatError) as caught:
        write_text(name, "text")
    assert caught.value.problems[0].fix
    assert not content(tmp_path)


def test_text_that_no_encoding_holds(tmp_path: Path) -> None:
    with pytest.raises(FormatError):
        write_text(tmp_path / "a.toml", "\ud800")
    assert not content(tmp_path)


def test_a_file_that_cannot_be_read_is_not_replaced(tmp_path: Path) -> None:
    """Its comments would be lost, which saving promises to keep."""
    model = sb.Model("m", [sb.Body("B", mass=1)])
    for name, old in (
        ("latin.toml", "# Länge\n".encode("latin-1")),
        ("wide.toml", "# note\n".encode("utf-16")),
    ):
        path = tmp_path / name
        path.write_bytes(old)
        with pytest.raises(FormatError, match=r"file\.(encoding|binary)"):
            sb.save_model(model, path)
        assert path.read_bytes() == old
    (tmp_path / "empty.toml").touch()
    sb.save_model(model, tmp_path / "empty.toml")
    assert sb.load_model(tmp_path / "empty.toml") == model


def test_a_urdf_in_capitals_is_named_as_one(tmp_path: Path) -> None:
    (tmp_path / "robot.URDF").write_text("<robot name='r'><link name='a'/></robot>")
    with pytest.raises(FormatError, match="load_urdf") as caught:
        sb.load_model(tmp_path / "robot.URDF")
    assert caught.value.problems[0].code == "file.urdf"


def test_names_with_a_semicolon_keep_their_lines(tmp_path: Path) -> None:
    """Two places of one message stand behind each other with the same mark."""
    path = tmp_path / "m.toml"
    path.write_text(
        'name = "m"\n[[body]]\nname = "a; b"\nmass = -1\n[[body]]\nname = "a"\nmass = 1\n'
        '[[body]]\nname = "a"\nmass = 1\n'
    )
    with pytest.raises(ModelError) as caught:
        sb.load_model(path)
    places = {problem.code: problem.where for problem in caught.value.problems}
    assert places.pop("model.negative_mass") == f"{path}:4, body a; b, mass"
    (twice,) = places.values()
    assert twice.count("; ") == 1 and f"{path}:6" in twice and f"{path}:9" in twice
