"""Files that are damaged, or made to do harm: every reader ends in a result or in a fault of this package."""

from __future__ import annotations

import io
import json
import os
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb
from symbody.simulation.sweeps.records import Store
from tests.faults.argument_calls import ROOT, model

KEEPS = 4 * 2**20  # bytes: a thousand times the files here


@pytest.fixture(scope="module")
def motion() -> bytes:
    """A trajectory as `save` writes it, with events, stored outputs and the motion between samples."""
    run = sb.simulate(sb.form_equations(model()), 0.3, events=sb.Event("t - 0.1", name="tenth"))
    path = Path(os.environ.get("TMPDIR", "/tmp")) / f"motion_{os.getpid()}.npz"
    run.save(path, "energy", "frame r Mass")
    content = path.read_bytes()
    path.unlink()
    return content


def outcome(path: Path, read: Callable[[Path], object]) -> str:
    """How reading ends; anything but a result or a fault of ours fails, and so does memory without measure."""
    tracemalloc.start()
    try:
        try:
            run = read(path)
            if isinstance(run, sb.Trajectory):
                run.columns()
                run.at(float(run.t[0]))
            found = "read"
        except (sb.FormatError, sb.EnvironmentFault) as error:
            assert error.problems[0].fix
            found = "refused"
        assert tracemalloc.get_traced_memory()[1] < KEEPS
    finally:
        tracemalloc.stop()
    return found


def damaged(content: bytes, count: int, seed: int) -> list[bytes]:
    """Cut, with bits turned over, bytes lost, put in twice, or replaced."""
    random = np.random.default_rng(seed)
    found = []
    for k in range(count):
        place, other = sorted(random.integers(0, len(content), 2).tolist())
        changed = bytearray(content)
        if k % 5 == 0:
            changed = changed[:place]
        elif k % 5 == 1:
            changed[place] ^= 1 << int(random.integers(8))
        elif k % 5 == 2:
            del changed[place : place + 1 + int(random.integers(64))]
        elif k % 5 == 3:
            changed[place:place] = changed[place : min(other, place + 64)]
        else:
            changed[place : place + 8] = random.bytes(8)
        found.append(bytes(changed))
    return found


def test_damaged_motions_are_told(tmp_path: Path, motion: bytes) -> None:
    path = tmp_path / "m.npz"
    path.write_bytes(motion)
    assert outcome(path, sb.Trajectory.load) == "read"
    ends = []
    for content in damaged(motion, 200, seed=1):
        path.write_bytes(content)
        ends.append(outcome(path, sb.Trajectory.load))
    # What stands in no array, as the time a member was written, does not matter.
    assert ends.count("refused") > 150


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", range(10))
def test_many_damaged_motions_are_told(tmp_path: Path, motion: bytes, seed: int) -> None:
    path = tmp_path / "m.npz"
    for content in damaged(motion, 500, seed=100 + seed):
        path.write_bytes(content)
        outcome(path, sb.Trajectory.load)
    for place in range(seed, len(motion), 10 * 37):  # cut everywhere
        path.write_bytes(motion[:place])
        assert outcome(path, sb.Trajectory.load) == "refused"


def npy(header: str, data: bytes = b"") -> bytes:
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + data


def saved(array: object) -> bytes:
    file = io.BytesIO()
    np.save(file, np.asarray(array), allow_pickle=True)
    return file.getvalue()


def with_member(motion: bytes, name: str, content: bytes, packed: int = zipfile.ZIP_STORED) -> bytes:
    """The same file with one member exchanged, or put in."""
    file = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(motion)) as old, zipfile.ZipFile(file, "w", packed) as new:
        for member in {*old.namelist(), name}:
            new.writestr(member, content if member == name else old.read(member))
    return file.getvalue()


FLOAT = "{'descr': '<f8', 'fortran_order': False, 'shape': %s, }"
WRONG_MEMBERS = {
    "pickle": ("t.npy", saved(np.array([Path("a")], dtype=object))),
    "text": ("q.npy", saved(["a", "b"])),
    "integers": ("q.npy", saved([[1, 2]])),
    "complex": ("q.npy", saved([[1j]])),
    "records": ("q.npy", saved(np.zeros(2, dtype=[("a", "f8")]))),
    "two axes of time": ("t.npy", saved(np.zeros((2, 2)))),
    "no axis of time": ("t.npy", saved(1.0)),
    "other length": ("u.npy", saved(np.zeros((1, 3)))),
    "huge": ("t.npy", npy(FLOAT % "(100000000000,)")),
    "huge product": ("t.npy", npy(FLOAT % "(4294967296, 4294967296, 4294967296)")),
    "negative": ("t.npy", npy(FLOAT % "(-1,)", b"\xff" * 8)),
    "two negative": ("t.npy", npy(FLOAT % "(-1, -1)", b"\xff" * 8)),
    "header that is no header": ("t.npy", npy("{" * 100)),
    "header that computes": ("t.npy", npy(FLOAT % "(9**9**9,)")),
    "no array": ("t.npy", b"hello"),
    "empty": ("t.npy", b""),
    "pieces of another size": ("pieces.npy", saved(np.zeros((2, 2, 2)))),
    "breaks in no order": ("breaks.npy", saved([0.0, 2.0, 1.0])),
    "stored without time": ("stored_0.npy", saved(1.0)),
    "about that is no JSON": ("about.npy", saved("{")),
    "about that is deep": ("about.npy", saved("[" * 100_000)),
    "about that is a list": ("about.npy", saved("[]")),
    "another suffix": ("q.txt", b""),
}


@pytest.mark.parametrize("name", WRONG_MEMBERS)
def test_members_of_another_kind_are_refused(tmp_path: Path, motion: bytes, name: str) -> None:
    path = tmp_path / "m.npz"
    path.write_bytes(with_member(motion, *WRONG_MEMBERS[name]))
    assert outcome(path, sb.Trajectory.load) == "refused"


def described(motion: bytes) -> dict[str, object]:
    with zipfile.ZipFile(io.BytesIO(motion)) as archive:
        found: dict[str, object] = json.loads(str(np.load(io.BytesIO(archive.read("about.npy")))))
    return found


WORDS = ("coordinate_names speed_names status statistics stored units notes name events").split()
VALUES: list[object] = [None, 1, 1.5, "x", [], [1], ["x"], [["x"]], {}, {"x": 1}, {"x": {}}, [["x", "y", "z"]],
          ["t"], ["x", "x"], [[]], {"accepted": []}]  # fmt: skip


def test_descriptions_of_another_kind_are_told(tmp_path: Path, motion: bytes) -> None:
    path, about = tmp_path / "m.npz", described(motion)
    for word in WORDS:
        for value in VALUES:
            text = json.dumps({**about, word: value})
            path.write_bytes(with_member(motion, "about.npy", saved(text)))
            end = outcome(path, sb.Trajectory.load)
            assert end == "refused" or isinstance(value, type(about[word])), (word, value)
        rest = json.dumps({key: value for key, value in about.items() if key != word})
        path.write_bytes(with_member(motion, "about.npy", saved(rest)))
        assert outcome(path, sb.Trajectory.load) == "refused" or word == "events"


def test_bombs_are_not_expanded(tmp_path: Path, motion: bytes) -> None:
    """A gigabyte of zeros in a megabyte, and a member that says it is larger than its file."""
    path = tmp_path / "m.npz"
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("t.npy", "w") as member:
        member.write(npy(FLOAT % "(8388608,)"))
        for _ in range(64):
            member.write(bytes(2**20))
    path.write_bytes(file.getvalue())
    assert outcome(path, sb.Trajectory.load) == "refused"
    place = motion.rfind(b"PK\x01\x02")  # a record of the directory: its sizes stand at 20 and 24
    grown = bytearray(motion)
    grown[place + 20 : place + 28] = (2**31).to_bytes(4, "little") * 2
    path.write_bytes(bytes(grown))
    assert outcome(path, sb.Trajectory.load) == "refused"


def test_what_is_no_file_is_told(tmp_path: Path) -> None:
    assert outcome(tmp_path, sb.Trajectory.load) == "refused"
    assert outcome(tmp_path / "none.npz", sb.Trajectory.load) == "refused"
    if hasattr(os, "mkfifo"):  # reading it would wait for ever
        os.mkfifo(tmp_path / "pipe")
        assert outcome(tmp_path / "pipe", sb.Trajectory.load) == "refused"


def test_damaged_parts_of_sweeps_are_computed_anew(tmp_path: Path) -> None:
    eqs = sb.form_equations(model())
    usual = sb.sweep(eqs, 0.1, {"k": [1.0, 2.0, 3.0]}, times=[0.1], threads=1, part=1, store=tmp_path)
    parts = sorted(tmp_path.glob("cases_*.npz"))
    assert len(parts) == 3
    content = parts[0].read_bytes()
    wrong = [*damaged(content, 20, seed=5), b"", saved([1.0])]
    wrong += [with_member(content, "x.npy", saved(np.zeros(shape))) for shape in ((1, 1, 9), (2, 1, 2), ())]
    wrong += [with_member(content, "codes.npy", saved(["text"])), with_member(content, "x.npy", b"")]
    for changed in wrong:
        parts[0].write_bytes(changed)
        again = sb.sweep(eqs, 0.1, {"k": [1.0, 2.0, 3.0]}, times=[0.1], threads=1, part=1, store=tmp_path)
        assert again.status == usual.status
        np.testing.assert_array_equal(again.x, usual.x)
    # A part of cases that there are not is left alone.
    parts[1].rename(tmp_path / "cases_000000007_000000008.npz")
    again = sb.sweep(eqs, 0.1, {"k": [1.0, 2.0, 3.0]}, times=[0.1], threads=1, part=1, store=tmp_path)
    np.testing.assert_array_equal(again.x, usual.x)
    (tmp_path / "sweep.json").write_text("[" * 100_000)
    with pytest.raises(sb.UsageError, match="another sweep"):
        Store(tmp_path, "none")


@pytest.mark.parametrize("name", ["slider_crank/slider_crank.toml", "robot_arm"])
def test_damaged_models_are_told(tmp_path: Path, name: str) -> None:
    source = ROOT / "examples" / name
    source = source if source.is_file() else next(iter(sorted(source.glob("*.urdf"))), source)
    if not source.is_file():
        pytest.skip("there is no such example")
    read = sb.load_urdf if source.suffix == ".urdf" else sb.load_model
    path = tmp_path / source.name
    for content in damaged(source.read_bytes(), 100, seed=3):
        path.write_bytes(content)
        try:
            read(path)
        except sb.SymbodyError as error:
            assert error.problems
