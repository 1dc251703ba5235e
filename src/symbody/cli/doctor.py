"""``symbody doctor``: what is installed, where results are stored, and whether each part works here.

It needs nothing but Python until a part is tried, so that it runs where a part is broken. No file of the user
is read, and nothing is printed but versions, paths of the installation, and results of the tests.
"""

from __future__ import annotations

import math
import os
import platform
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module, metadata
from pathlib import Path
from re import match
from time import perf_counter
from typing import Any, Final

_THREADS: Final = 4
_CALLS: Final = 64  # of one function by all threads together
_CLOSE: Final = 1e-6
_MEGABYTE: Final = 2**20


def doctor_lines(tests: dict[str, Callable[[], str]] | None = None) -> Iterator[tuple[str, bool]]:
    """Return one line after the other, and whether what it is about works.

    Parameters
    ----------
    tests : mapping of name to callable, optional
        What is tried; each returns a remark, or raises.
    """
    yield from ((line, True) for line in (*_platform_lines(), *_package_lines()))
    yield _cache_line(), True
    yield "self-test:", True
    for name, test in (TESTS if tests is None else tests).items():
        started = perf_counter()
        try:
            remark = test()
        except _AbsentError as error:
            yield f"  {name}: not available, {error}", True
        except Exception as error:  # whatever is broken, the next part may work
            yield f"  {name}: FAILED, {type(error).__name__}: {' '.join(str(error).split())}", False
        else:
            yield f"  {name}: ok, {perf_counter() - started:.2f} s{f', {remark}' if remark else ''}", True


class _AbsentError(Exception):
    """A part that this installation was made without."""


def _platform_lines() -> Iterator[str]:
    yield f"symbody {_version('symbody') or 'without its metadata'} in {Path(__file__).parents[1]}"
    yield f"Python {platform.python_version()} ({platform.python_implementation()}) in {sys.prefix}"
    system = " ".join(filter(None, (platform.system(), platform.release(), platform.machine())))
    yield f"system: {system}, {os.cpu_count()} processors"


def _package_lines() -> Iterator[str]:
    """Return the versions of all dependencies, and the extras that are not there."""
    needed, extras = list[str](), dict[str, list[str]]()
    for line in _requirements():
        package = match(r"[A-Za-z0-9._-]+", line)
        extra = match(r".*extra\s*==\s*['\"](\w+)['\"]", line)
        if package is not None and extra is None:
            needed.append(package[0])
        elif package is not None and extra is not None and extra[1] != "test":
            extras.setdefault(extra[1], []).append(package[0])
    yield f"packages: {', '.join(map(_with_version, needed)) or 'not known'}"
    for word, names in extras.items():
        missing = [name for name in names if _version(name) is None]
        if missing:
            yield f"not installed: {', '.join(missing)}; pip install symbody[{word}]"
        else:
            yield f"extra {word}: {', '.join(f'{name} {_version(name)}' for name in names)}"


def _with_version(name: str) -> str:
    return f"{name} {_version(name) or 'MISSING'}"


def _requirements() -> list[str]:
    try:
        return metadata.requires("symbody") or []
    except metadata.PackageNotFoundError:  # run from a checkout
        return []


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _cache_line() -> str:
    """Return where results are stored, and how much there is."""
    storage = import_module("symbody.storage")
    place: Path | None = storage.folder()
    if place is None:
        return f"cache: off; {storage.VARIABLE} names a folder"
    try:
        sizes = [entry.stat().st_size for entry in os.scandir(place) if entry.is_file()]
    except OSError:
        return f"cache: {place}, not created yet; {storage.VARIABLE} sets another folder"
    right = "" if os.access(place, os.W_OK) else ", CANNOT be written to"
    size = sum(sizes) / _MEGABYTE
    return f"cache: {place}, {len(sizes)} files, {size:.1f} MB of at most {storage.LIMIT // _MEGABYTE}{right}"


def _oscillator() -> Any:
    """Return the equations of a mass on a spring, x = cos(2 t) from x = 1."""
    sb = import_module("symbody")
    drive = sb.Drive(stiffness=4)
    slider = sb.Prismatic("slider", "ground", sb.Body("Mass", mass=1), axis="x", coordinate="x", force=drive)
    return sb.form_equations(sb.Model("self-test", [slider]))


def _equations() -> str:
    text = _oscillator().text()
    return str(text) if text == "x'' + 4 x = 0" else _fail(f"the equations are {text}")


def _object_code() -> str:
    function = import_module("symbody").compile(_oscillator(), "udot")
    value = float(function(0.0, [0.5], [0.0])[0])
    return f"the result is {value}" if value == -2.0 else _fail(f"the result is {value}, not -2")


def _threads() -> str:
    """Call one function from several threads; all results have the same bits."""
    function = import_module("symbody").compile(_oscillator(), "sin(x)*exp(x)")

    def call(k: int) -> float:
        return float(function(0.0, [k / _CALLS], [0.0]))

    with ThreadPoolExecutor(_THREADS) as pool:
        together = list(pool.map(call, range(_CALLS)))
    if together != [call(k) for k in range(_CALLS)]:
        return _fail("results of several threads differ from those of one thread")
    return f"{_THREADS} threads, {_CALLS} calls"


def _stored_results() -> str:
    """Store something and read it again, if results are stored at all."""
    storage = import_module("symbody.storage")
    if storage.folder() is None:
        return "off"
    key, content = b"symbody doctor", os.urandom(32)
    storage.store(key, content)
    if storage.load_stored(key) != content:
        return _fail(
            f"{storage.folder()} cannot be used as a cache: it is not writable, or other users can write to "
            f"it"
        )
    return ""


def _motion() -> str:
    run = import_module("symbody").simulate(_oscillator(), 1.0, {"x": 1.0})
    difference = abs(float(run["x"][-1]) - math.cos(2.0))
    return f"error {difference:.0e}" if difference < _CLOSE else _fail(f"x is off by {difference:g}")


def _picture() -> str:
    sb = import_module("symbody")
    axes = sb.plot(sb.simulate(_oscillator(), 1.0, {"x": 1.0}), "x")
    size = len(axes._repr_png_())
    return f"{size} bytes" if size else _fail("the picture is empty")


def _pages() -> str:
    root = Path(__file__).parents[1]
    pages = ("visual/pages/player.html", "builder/pages/index.html")
    missing = [page for page in pages if not (root / page).is_file()]
    if missing:
        why = import_module("symbody.visual.viewer.built_files").why_no_pages()
        raise _AbsentError(f"{' and '.join(missing)}: {why}; everything else works")
    return ""


def _fail(what: str) -> str:
    raise RuntimeError(what)


TESTS: Final[dict[str, Callable[[], str]]] = {
    "equations": _equations,
    "object code": _object_code,
    "threads": _threads,
    "stored results": _stored_results,
    "motion": _motion,
    "picture": _picture,
    "pages of animations and editor": _pages,
}


def run_doctor() -> int:
    """Print all lines and return the exit code: 0, or 5 where something does not work."""
    works = True
    for line, is_fine in doctor_lines():
        print(line, flush=True)
        works = works and is_fine
    print("everything works" if works else "something does not work: see FAILED above")
    return 0 if works else 5
