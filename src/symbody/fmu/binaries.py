"""Libraries of an FMU, by the compiler of this machine or by zig for other platforms."""

from __future__ import annotations

import importlib.util
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from symbody.errors import CompileError, EnvironmentFault, Problem, UsageError, nearest

FLAGS: Final = (
    "-std=c99",
    "-ffp-contract=off",
    "-shared",
    "-fvisibility=hidden",
    "-Werror=implicit-function-declaration",
)
# Above this size of the text [bytes] compilers take minutes for what -O2 adds to -O1: the same numbers sooner
_LARGE: Final = 1_000_000
_OLDEST_GLIBC: Final = "2.17"
INSTALL: Final = 'pip install "symbody[fmu]"'


@dataclass(frozen=True, slots=True)
class Platform:
    """Where a library runs.

    Attributes
    ----------
    name : str
        As FMI 3.0 calls it.
    name_2 : str
        As FMI 2.0 calls it; empty where that standard has no name for it.
    target : str
        As zig calls it.
    suffix : str
        Of its libraries.
    """

    name: str
    name_2: str
    target: str
    suffix: str


PLATFORMS: Final[Mapping[str, Platform]] = {
    each.name: each
    for each in (
        Platform("x86_64-linux", "linux64", f"x86_64-linux-gnu.{_OLDEST_GLIBC}", ".so"),
        Platform("aarch64-linux", "", f"aarch64-linux-gnu.{_OLDEST_GLIBC}", ".so"),
        Platform("x86_64-windows", "win64", "x86_64-windows-gnu", ".dll"),
        Platform("x86_64-darwin", "darwin64", "x86_64-macos", ".dylib"),
        Platform("aarch64-darwin", "", "aarch64-macos", ".dylib"),
    )
}


def own_platform() -> Platform | None:
    """Return the platform of this machine, if it is one of them."""
    machine = {"AMD64": "x86_64", "arm64": "aarch64", "ARM64": "aarch64"}.get(
        platform.machine(), platform.machine()
    )
    return PLATFORMS.get(f"{machine}-{platform.system().lower()}")


def choose_platforms(asked: str | Iterable[str] | None, version: str) -> tuple[Platform, ...]:
    """Return the platforms to compile for: by default this machine's own.

    Raises UsageError if a name is unknown, or the version of the standard has no name for it.
    """
    if asked is None:
        own = own_platform()
        usable = own is not None and (version != "2.0" or own.name_2)
        return (own,) if own is not None and usable else ()
    possible = {name: p for name, p in PLATFORMS.items() if version != "2.0" or p.name_2}
    named = (asked,) if isinstance(asked, str) else tuple(asked)
    names = tuple(possible) if named == ("all",) else named
    problems = [
        Problem("fmu.platform", "platforms", f"FMI {version} has no platform {name!r}", "",
                f"{nearest(name, possible)}; there are {', '.join(possible)}, or \"all\"")
        for name in names if name not in possible
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    return tuple(possible[name] for name in dict.fromkeys(names))


def compile_libraries(
    sources: Mapping[str, bytes], main: str, asked: str | Iterable[str] | None, version: str
) -> tuple[dict[Platform, bytes], tuple[str, ...]]:
    """Return the library of each platform, and notes on what could not be made.

    Raises UsageError, EnvironmentFault if a platform is asked for that is unknown, or that no compiler here
    makes; CompileError if a compiler refuses the text.

    Parameters
    ----------
    sources : mapping of file name to content
    main : str
        The file that includes all others.
    """
    chosen = choose_platforms(asked, version)
    commands = {each: compiler_for(each) for each in chosen}
    missing = [each.name for each, command in commands.items() if not command]
    if missing and asked is not None:
        raise EnvironmentFault(
            Problem("fmu.compiler", "platforms",
                    f"no compiler here builds libraries for {', '.join(missing)}", "",
                    f"{INSTALL} installs one that compiles for all of them, or leave platforms out")
        )  # fmt: skip
    libraries = {
        each: _compile(sources, main, each, command) for each, command in commands.items() if command
    }
    notes: tuple[str, ...] = ()
    if not libraries:
        reason = f", since there is no C compiler; {INSTALL} installs one" if missing else ""
        notes = (f"the archive holds sources and no library{reason}: importers that compile can use it",)
    return libraries, notes


def compiler_for(target: Platform) -> tuple[str, ...]:
    """Return the beginning of a command that compiles for a platform; empty without one."""
    if target == own_platform() and target.suffix != ".dll":
        for name in ("cc", "gcc", "clang"):
            if path := shutil.which(name):
                return (path, "-fPIC", *(("-Wl,--build-id=none",) if target.suffix == ".so" else ()))
    if importlib.util.find_spec("ziglang") is not None:
        return (sys.executable, "-m", "ziglang", "cc", "-target", target.target, "-fPIC", "-s")
    return ()


def _compile(sources: Mapping[str, bytes], main: str, target: Platform, command: tuple[str, ...]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        for name, content in sources.items():
            (Path(folder) / name).write_bytes(content)
        library = f"library{target.suffix}"
        level = "-O2" if sum(map(len, sources.values())) < _LARGE else "-O1"
        flags = [flag for flag in FLAGS if not (target.suffix == ".dll" and "visibility" in flag)]
        done = subprocess.run(
            [*command, level, *flags, main, "-o", library, "-lm"], cwd=folder, capture_output=True, text=True,
            errors="replace", check=False,
        )  # fmt: skip
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "error" in line] or done.stderr.splitlines()
            raise CompileError(
                Problem("fmu.compile", target.name, "the compiler rejected the source of the FMU",
                        lines[0] if lines else f"{command[0]} gave no message",
                        "try another compiler, or platforms=() for an archive of sources")
            )  # fmt: skip
        return (Path(folder) / library).read_bytes()


Version = Literal["2.0", "3.0"]

# The file of C that includes all others.
MAIN: Final[Mapping[str, str]] = {"2.0": "fmi2.c", "3.0": "fmi3.c"}
CORE: Final = (
    "motion.h",
    "conditions.h",
    "results.h",
    "modes.h",
    "events.h",
    "samples.h",
    "steps.h",
    "instance.h",
)
HEADERS: Final[Mapping[str, tuple[str, ...]]] = {
    "2.0": ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    "3.0": ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
