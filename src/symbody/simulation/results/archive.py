"""Arrays and a description in one file: NumPy's npz without pickles, the description as JSON."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from os import PathLike
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.errors import EnvironmentFault, FormatError, Problem

Floats = NDArray[np.float64]
Path = str | PathLike[str]
About = dict[str, Any]  # what JSON can say

FORMAT: Final = "symbody trajectory 1"


def write_archive(path: Path, arrays: Mapping[str, Floats], about: About) -> None:
    """Write arrays and a description to exactly `path`.

    Raises
    ------
    EnvironmentFault
        If the file cannot be written.
    """
    text = np.array(json.dumps({"format": FORMAT, **about}))
    try:
        with zipfile.ZipFile(path, "w") as archive:  # np.savez would add a suffix to the name
            for name, array in {"about": text, **arrays}.items():
                with archive.open(f"{name}.npy", "w", force_zip64=True) as file:
                    np.lib.format.write_array(file, array, allow_pickle=False)
    except OSError as error:
        raise unwritable(path, error) from error


def read_archive(path: Path) -> tuple[dict[str, Floats], About]:
    """Return what `write_archive` wrote.

    Raises
    ------
    EnvironmentFault
        If the file cannot be opened.
    FormatError
        If it is none of ours.
    """
    try:
        with open(path, "rb") as file, np.load(file, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        about = json.loads(str(arrays.pop("about")))
    except (ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise not_ours(path) from error
    except OSError as error:
        what = f"the file cannot be read: {error.strerror}"
        fix = "check the name and the folder"
        raise EnvironmentFault(Problem("trajectory.unreadable", str(path), what, fix=fix)) from error
    if not isinstance(about, dict) or about.get("format") != FORMAT:
        raise not_ours(path)
    return arrays, about


def unwritable(path: Path, error: OSError) -> EnvironmentFault:
    """Return the error for a file that cannot be written."""
    what = f"the file cannot be written: {error.strerror}"
    return EnvironmentFault(
        Problem("trajectory.unwritable", str(path), what, fix="choose a folder that exists and is yours")
    )


def not_ours(path: Path) -> FormatError:
    """Return the error for a file that holds no trajectory."""
    what = "the file is not a trajectory of symbody"
    return FormatError(Problem("trajectory.format", str(path), what, fix="load what run.save(path) wrote"))
