"""A motion from its file, as the fields of a trajectory."""

from __future__ import annotations

from typing import Any

from symbody.equations.showing.units import Units
from symbody.simulation.events.events import Occurrence
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.archive import Path, check_motion, not_ours, read_archive
from symbody.simulation.results.model_record import provenance_from
from symbody.simulation.status import Status


def motion_fields(path: Path) -> dict[str, Any]:
    """Return what makes the trajectory in a file.

    Raises
    ------
    EnvironmentFault
        If the file cannot be opened.
    FormatError, ModelError
        If it holds no trajectory, or its model is none.
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
