"""A motion in a file: NumPy's npz without pickles, the description as JSON."""

from __future__ import annotations

import io
import json
import math
import os
import stat
import zipfile
from collections.abc import Mapping
from os import PathLike
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from symbody.arguments import fits
from symbody.equations.outputs.units import Units
from symbody.errors import EnvironmentFault, FormatError, Problem
from symbody.simulation.events.events import Occurrence
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.provenance import provenance_from
from symbody.simulation.status import Status

Floats = NDArray[np.float64]
Path = str | PathLike[str]
About = dict[str, Any]  # what JSON can say

FORMAT: Final = "symbody trajectory 1"
_SUFFIX: Final = ".npy"
_KINDS: Final[Mapping[str, object]] = {
    "coordinate_names": list[str], "speed_names": list[str], "signal_state_names": list[str], "status": str,
    "stored": list[str],
    "statistics": dict[str, int | float | None], "units": dict[str, str], "notes": list[str], "name": str,
    "events": list[list[Any]],
}  # fmt: skip


def write_archive(path: Path, arrays: Mapping[str, Floats], about: About) -> None:
    """Write arrays and a description to exactly `path`.

    Raises EnvironmentFault if the file cannot be written.
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

    Raises EnvironmentFault if the file cannot be opened; FormatError if it is none of ours, or damaged.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise _unreadable(path, "it is not an ordinary file")
        file = open(path, "rb")  # closed below
    except (OSError, ValueError) as error:
        raise _unreadable(path, getattr(error, "strerror", None) or str(error)) from error
    with file:
        try:
            arrays: dict[str, Any] = read_arrays(file)
            about = json.loads(str(arrays.pop("about")))
            if not isinstance(about, dict) or about.get("format") != FORMAT:
                raise ValueError("another format")
            if any(array.dtype != np.float64 for array in arrays.values()):
                raise ValueError("no floats")
        except Exception as error:  # a damaged file breaks zipfile and json in every way there is
            raise not_ours(path) from error
    return arrays, about


def motion_fields(path: Path) -> dict[str, Any]:
    """Return what makes the trajectory in a file.

    Raises EnvironmentFault if the file cannot be opened; FormatError, ModelError if it holds no trajectory,
    or its model is none.
    """
    arrays, about = read_archive(path)
    try:
        check_motion(arrays, about)
        record = about.get("model")
        return {
            "t": arrays["t"],
            "q": arrays["q"],
            "u": arrays["u"],
            "coordinate_names": tuple(about["coordinate_names"]),
            "speed_names": tuple(about["speed_names"]),
            "signal_state_names": tuple(about.get("signal_state_names", ())),
            "s": arrays.get("s", np.zeros((0, 0))),
            "status": Status[about["status"]],
            "statistics": Statistics(**about["statistics"]),
            "dense_output": DenseOutput(arrays["breaks"], arrays["pieces"]) if "breaks" in arrays else None,
            "stored": {name: arrays[f"stored_{k}"] for k, name in enumerate(about["stored"])},
            "units": Units(about["units"]),
            "notes": tuple(about["notes"]),
            "name": about["name"],
            "events": tuple(Occurrence(*event) for event in about.get("events", ())),
            "provenance": None if record is None else provenance_from(record, arrays, str(path)),
        }
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise not_ours(path) from error


def check_motion(arrays: Mapping[str, Floats], about: About) -> None:
    """Compare the description of a motion in a file with the arrays in it.

    Raises ValueError, KeyError where they do not fit together.
    """
    for name, kind in _KINDS.items():
        if not fits(kind, about.get(name, [])):
            raise ValueError(f"{name} has another type")
    names = [*about["coordinate_names"], *about["speed_names"], *about.get("signal_state_names", ())]
    samples = arrays["t"].size
    events = about.get("events", [])
    stored = [arrays[f"stored_{k}"] for k in range(len(about["stored"]))]
    right = [
        arrays["t"].ndim == 1,
        len({*names}) == len(names) and "t" not in names,
        all(array.ndim > 0 and array.shape[-1] == samples for array in stored),
        all(len(event) == 3 and fits(tuple[str, float, dict[str, float]], tuple(event)) for event in events),
        ("breaks" in arrays) == ("pieces" in arrays),
    ]
    if "breaks" in arrays:
        breaks, pieces = arrays["breaks"], arrays["pieces"]
        steps = np.diff(breaks)
        right += [
            breaks.ndim == 1 and breaks.size > 1 and pieces.ndim == 3,
            pieces.shape[0] == breaks.size - 1 and pieces.shape[1] > 0 and pieces.shape[2] == len(names),
            bool((steps >= 0.0).all() or (steps <= 0.0).all()),
        ]
    if not all(right):
        raise ValueError("arrays and names do not match")


def read_arrays(file: BinaryIO) -> dict[str, NDArray[Any]]:
    """Return the arrays of an npz file that is not compressed, in the memory that the file itself takes.

    Sizes are compared with the file's before anything is read: what is packed small cannot grow large. Raises
    ValueError, KeyError, OSError, zipfile.BadZipFile and others: whatever a damaged file leads to.
    """
    size = os.fstat(file.fileno()).st_size
    arrays: dict[str, NDArray[Any]] = {}
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        if sum(member.file_size for member in members) > size:
            raise ValueError("the unpacked data is larger than the file declares")
        for member in members:
            if member.compress_type != zipfile.ZIP_STORED or not member.filename.endswith(_SUFFIX):
                raise ValueError(f"{member.filename} uses an unsupported compression")
            with archive.open(member) as content:
                arrays[member.filename.removesuffix(_SUFFIX)] = _array(content.read())
    return arrays


def _array(content: bytes) -> NDArray[Any]:
    """Return an array of numbers or text from the bytes of an npy file."""
    file = io.BytesIO(content)
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, by_columns, kind = read(file)
    data = content[file.tell() :]
    if kind.kind not in "fiuU" or math.prod(shape) * kind.itemsize != len(data) or min(shape, default=0) < 0:
        raise ValueError(f"{shape} entries of type {kind} are not {len(data)} bytes")
    array: NDArray[Any] = np.frombuffer(data, kind).reshape(shape, order="F" if by_columns else "C")
    return array.astype(kind.newbyteorder("="))


def unwritable(path: Path, error: OSError) -> EnvironmentFault:
    """Return the error for a file that cannot be written."""
    what = f"the file cannot be written: {error.strerror}"
    return EnvironmentFault(
        Problem(
            "trajectory.unwritable", str(path), what, fix="choose an existing folder with write permission"
        )
    )


def _unreadable(path: Path, why: str) -> EnvironmentFault:
    what = f"the file cannot be read: {why}"
    return EnvironmentFault(
        Problem("trajectory.unreadable", str(path), what, fix="check the name and the folder")
    )


def not_ours(path: Path) -> FormatError:
    """Return the error for a file that holds no trajectory."""
    what = "the file is not a trajectory of symbody, or it is damaged"
    return FormatError(Problem("trajectory.format", str(path), what, fix="load what run.save(path) wrote"))
