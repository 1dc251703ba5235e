"""Libraries of other platforms, made by zig: they cannot run here, so they are looked at as files."""

from __future__ import annotations

import zipfile
from pathlib import Path

import lief
import pytest

import symbody as sb
from symbody.fmu import binaries
from tests.fmu.importer import VERSIONS, pendulum

pytestmark = pytest.mark.exhaustive
MACHINES = {
    "x86_64-linux": lief.ELF.ARCH.X86_64,
    "linux64": lief.ELF.ARCH.X86_64,
    "aarch64-linux": lief.ELF.ARCH.AARCH64,
    "x86_64-windows": lief.PE.Header.MACHINE_TYPES.AMD64,
    "win64": lief.PE.Header.MACHINE_TYPES.AMD64,
    "x86_64-darwin": lief.MachO.Header.CPU_TYPE.X86_64,
    "darwin64": lief.MachO.Header.CPU_TYPE.X86_64,
    "aarch64-darwin": lief.MachO.Header.CPU_TYPE.ARM64,
}
_LINKER_SYMBOLS = {"__mh_dylib_header", "___dso_handle"}  # of every library of macOS


@pytest.mark.parametrize("version", VERSIONS)
def test_libraries_of_all_platforms(version: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("ziglang")
    monkeypatch.setattr(
        binaries.shutil, "which", lambda name: None
    )  # that zig compiles for this machine, too
    made = sb.save_fmu(pendulum(), tmp_path / "pendulum.fmu", version, platforms="all")  # type: ignore[arg-type]
    with zipfile.ZipFile(made.path) as archive:
        files = {name: archive.read(name) for name in archive.namelist() if name.startswith("binaries/")}
    assert len(files) == (3 if version == "2.0" else 5)
    for name, content in files.items():
        library = lief.parse(list(content))
        assert library is not None
        exported = {each.name for each in library.exported_functions} - _LINKER_SYMBOLS
        names = {each.lstrip("_") for each in exported}
        assert f"fmi{version[0]}DoStep" in names
        assert all(each.startswith(f"fmi{version[0]}") for each in names), names
        check_needs(library, MACHINES[name.split("/")[1]])


def check_needs(library: lief.Binary, machine: object) -> None:
    """Check for which machine a library is, and that it needs nothing but the system."""
    if isinstance(library, lief.ELF.Binary):
        assert library.header.machine_type == machine
        assert set(library.libraries) <= {"libc.so.6", "libm.so.6"}
        versions = {
            symbol.name
            for needed in library.symbols_version_requirement
            for symbol in needed.get_auxiliary_symbols()
        }
        numbers = [tuple(map(int, each.removeprefix("GLIBC_").split("."))) for each in versions]
        assert numbers and max(numbers) <= (2, 17)
    elif isinstance(library, lief.PE.Binary):
        assert library.header.machine == machine
        # the universal C runtime, a part of Windows
        needed = {each.lower() for each in library.libraries}
        assert all(each == "kernel32.dll" or each.startswith("api-ms-win-crt-") for each in needed), needed
    else:
        assert isinstance(library, lief.MachO.Binary)
        assert library.header.cpu_type == machine
        own = {
            command.name
            for command in library.libraries
            if command.command == lief.MachO.LoadCommand.TYPE.ID_DYLIB
        }
        assert {each.name for each in library.libraries} - own == {"/usr/lib/libSystem.B.dylib"}
        if machine == lief.MachO.Header.CPU_TYPE.ARM64:
            assert library.has_code_signature  # without one macOS does not load it
