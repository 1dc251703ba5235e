"""Finished chunks of a sweep in a folder, from which a later call goes on."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import numpy as np

from symbody.errors import EnvironmentFault, Problem, UsageError
from symbody.simulation.inputs.held_law import HeldRecord
from symbody.simulation.results.archive import read_arrays
from symbody.simulation.sweeps.records import CaseDetails, Records
from symbody.storage import move_into_place

_FORMAT: Final = "symbody sweep 6"
_ABOUT: Final = "sweep.json"
_NAME: Final = re.compile(r"cases_(\d+)_(\d+)\.npz")


class Store:
    """A folder with the finished chunks of one sweep.

    Parameters
    ----------
    path : path
        The folder, made where it does not exist.
    digest : str
        Stands for all that results depend on.

    Raises
    ------
    UsageError
        If the folder belongs to another sweep, or to something else.
    EnvironmentFault
        If it cannot be made or read.
    """

    def __init__(self, path: str | os.PathLike[str], digest: str) -> None:
        self._folder = Path(path)
        about = {"format": _FORMAT, "digest": digest}
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            found = self._read_about()
            if found is None:
                _write(self._folder / _ABOUT, json.dumps(about).encode())
        except OSError as error:
            raise self._unwritable(error) from error
        if found is not None and found != about:
            raise UsageError(
                Problem("sweep.store", str(path), "the folder holds parts of another sweep",
                        "its model, cases, times, method or tolerances differ, or the release of symbody",
                        "give another folder, or delete this one")
            )  # fmt: skip

    def read_finished(self, whole: Records) -> Iterable[Records]:
        """Yield what was kept of all cases; what cannot be read, or does not fit, is computed anew."""
        for path in sorted(self._folder.glob("cases_*.npz")):
            name = _NAME.fullmatch(path.name)
            try:
                with open(path, "rb") as file:
                    arrays = read_arrays(file)
                records = Records(
                    int(name[1]) if name else -1,
                    arrays["x"], arrays["codes"], arrays["counts"], arrays["reached"],
                    _read_details(str(arrays["details"])),
                )  # fmt: skip
            except Exception:  # a damaged file breaks zipfile in every way there is
                continue
            if whole.has_room_for(records):
                yield records

    def keep(self, records: Records) -> None:
        """Keep a chunk that is complete.

        Raises
        ------
        EnvironmentFault
            If it cannot be written.
        """
        name = f"cases_{records.first:09d}_{records.first + records.count:09d}.npz"
        own = self._folder / f"{name}.{os.getpid()}.part"
        try:
            with open(own, "wb") as file:
                np.savez(
                    file, x=records.x, codes=records.codes, counts=records.counts, reached=records.reached,
                    details=np.array(_details_text(records)),
                )  # fmt: skip
            move_into_place(own, self._folder / name)
        except OSError as error:
            raise self._unwritable(error) from error

    def _read_about(self) -> object:
        path = self._folder / _ABOUT
        if not path.exists():
            return None
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError):
            return {}

    def _unwritable(self, error: OSError) -> EnvironmentFault:
        what = f"the folder cannot be used: {error.strerror or error}"
        return EnvironmentFault(
            Problem(
                "sweep.store_folder", str(self._folder), what, fix="choose a folder with write permission"
            )
        )


def _details_text(records: Records) -> str:
    cases = range(records.first, records.first + records.count)
    return json.dumps(
        {case: asdict(records.details[case]) for case in cases if case in records.details},
        default=np.ndarray.tolist,
    )


def _read_details(text: str) -> dict[int, CaseDetails]:
    return {
        int(case): CaseDetails(
            str(about["notes"]),
            tuple(about["names"]),
            np.array(about["happened"], dtype=np.float64),
            None if about["work"] is None else np.array(about["work"], dtype=np.float64),
            _held_record(about["modes"]),
            _held_record(about.get("held")),
        )
        for case, about in json.loads(text).items()
    }


def _held_record(about: Mapping[str, Any] | None) -> HeldRecord | None:
    if about is None:
        return None
    values = np.array(about["values"], dtype=np.float64)
    return HeldRecord(tuple(about["names"]), np.array(about["t"], dtype=np.float64), values)


def _write(path: Path, content: bytes) -> None:
    own = path.with_suffix(f".{os.getpid()}.part")
    own.write_bytes(content)
    move_into_place(own, path)
