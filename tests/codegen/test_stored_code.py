"""Code kept on the disk: found again, never trusted when changed or in the wrong hands, bounded."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from symbody import storage
from symbody.codegen.llvm import machine, runtime, stored_module
from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.llvm.runtime import lane_counts, lane_sincos
from symbody.codegen.llvm.trig import SINCOS_NAME
from symbody.storage import VARIABLE, folder, load_stored, store
from tests.codegen.native import call
from tests.codegen.sequences import EXACT, TRIGONOMETRIC, random_sequence, same_bits


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "code"))
    return tmp_path / "code"


def test_what_is_stored_is_found_under_its_key_alone(place: Path) -> None:
    assert load_stored(b"key") is None and not place.exists()
    store(b"key", b"code")
    assert load_stored(b"key") == b"code"
    assert load_stored(b"another") is None
    assert [path.suffix for path in place.iterdir()] == [".stored"]


def test_all_that_forms_sequences_and_writes_code_is_in_the_key() -> None:
    """Else a mend of one of these files would leave what is on the disk as it was."""
    codegen = Path(stored_module.__file__).parent.parent
    files = stored_module.writing_files()
    assert {codegen / "llvm/pairs/signs.py", codegen / "formation/sequences.py"} <= set(files)
    assert codegen.parent / "expr/fingerprints/shapes.py" in files


@pytest.mark.parametrize("damage", [b"", b"short", None])
def test_a_damaged_file_is_made_again(place: Path, damage: bytes | None) -> None:
    store(b"key", b"code" * 100)
    (path,) = place.iterdir()
    content = path.read_bytes()
    path.write_bytes(content[:-1] + b"x" if damage is None else damage)
    assert load_stored(b"key") is None
    assert not path.exists()
    store(b"key", b"code")
    assert load_stored(b"key") == b"code"


def test_a_file_under_the_name_of_another_is_not_taken(place: Path) -> None:
    store(b"one", b"code")
    (path,) = place.iterdir()
    store(b"two", b"other")
    (other,) = set(place.iterdir()) - {path}
    os.replace(path, other)
    assert load_stored(b"two") is None


def test_compiling_again_needs_no_compiler(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sequence, inputs = random_sequence(1, 100, (*EXACT, *TRIGONOMETRIC))
    first = call(compile_sequence(sequence), sequence, inputs)
    monkeypatch.setattr(machine, "_object_code", None)
    again = call(compile_sequence(sequence), sequence, inputs)
    assert first[0] == again[0] and same_bits(first[1], again[1])
    with pytest.raises(TypeError):  # other code is other code
        compile_sequence(sequence, quick=True)


def test_a_damaged_file_is_compiled_again(place: Path) -> None:
    sequence, inputs = random_sequence(2, 50, EXACT)
    first = call(compile_sequence(sequence), sequence, inputs)
    for path in place.iterdir():
        path.write_bytes(path.read_bytes()[:100])
    again = call(compile_sequence(sequence), sequence, inputs)
    assert same_bits(first[1], again[1])


def test_another_processor_or_version_is_another_key(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sequence, _ = random_sequence(3, 50, EXACT)
    compile_sequence(sequence)
    before = set(place.iterdir())
    monkeypatch.setattr(stored_module, "environment", lambda: "another")
    compile_sequence(sequence)
    assert len(set(place.iterdir()) - before) >= 1


def test_folders_open_to_others_are_not_used(place: Path) -> None:
    if sys.platform == "win32":
        pytest.skip("folders have no such modes there")
    store(b"key", b"code")
    assert place.stat().st_mode & 0o777 == 0o700
    place.chmod(0o777)
    assert load_stored(b"key") is None
    store(b"other", b"code")
    assert len(list(place.iterdir())) == 1


def test_a_folder_that_cannot_be_made_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv(VARIABLE, str(blocked / "code"))
    store(b"key", b"code")
    assert load_stored(b"key") is None
    sequence, inputs = random_sequence(4, 30, EXACT)
    assert call(compile_sequence(sequence), sequence, inputs)[0] == 0


@pytest.mark.parametrize("word", ["off", "OFF", "0", "no"])
def test_it_can_be_switched_off(word: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, word)
    assert folder() is None
    store(b"key", b"code")
    assert load_stored(b"key") is None


def test_the_folder_is_where_the_system_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert folder() == Path("/somewhere/symbody")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert folder() is None


def test_what_was_used_longest_ago_goes_first(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(storage, "LIMIT", 1000)
    monkeypatch.setattr(storage, "EVERY", 1)
    keys = [b"%d" % k for k in range(8)]
    for age, key in enumerate(keys):
        store(key, bytes(168))  # 200 bytes with its hash
        if (path := storage._path(place, key)).exists():
            os.utime(path, (age, age))
    found = [load_stored(key) is not None for key in keys]
    assert found[-1] and not found[0]
    assert sum(path.stat().st_size for path in place.iterdir()) <= 1000


def test_the_folder_is_looked_through_now_and_then(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not at each file: that would take longer the more there are; and still it stays near its bound."""
    looks: list[Path] = []
    evict = storage._evict
    monkeypatch.setattr(storage, "LIMIT", 20_000)
    monkeypatch.setattr(storage, "_evict", lambda where: (looks.append(where), evict(where)))
    for k in range(1000):
        store(b"%d" % k, bytes(168))  # 200 bytes with its hash
    assert 10 < len(looks) < 100
    assert sum(path.stat().st_size for path in place.iterdir()) < 4 * 20_000


def test_many_at_once_do_not_meet(place: Path) -> None:
    def work(k: int) -> bytes | None:
        store(b"key", b"code" * 1000)
        return load_stored(b"key")

    with ThreadPoolExecutor(8) as pool:
        assert set(pool.map(work, range(100))) == {b"code" * 1000}
    assert len(list(place.iterdir())) == 1


def test_the_next_process_finds_it(place: Path) -> None:
    program = (
        "from symbody.codegen.llvm import machine\n"
        "from symbody.codegen.llvm.native import compile_sequence\n"
        "from tests.codegen.sequences import EXACT, TRIGONOMETRIC, random_sequence\n"
        "machine._object_code = None\n"
        "compile_sequence(random_sequence(5, 60, (*EXACT, *TRIGONOMETRIC))[0])\n"
    )
    command = [sys.executable, "-c", program]
    assert subprocess.run(command, capture_output=True, check=False).returncode != 0
    sequence, _ = random_sequence(5, 60, (*EXACT, *TRIGONOMETRIC))
    compile_sequence(sequence)
    for name in (SINCOS_NAME, *map(lane_sincos, lane_counts())):
        runtime._module(name)  # in this process they may have been made before this test
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
