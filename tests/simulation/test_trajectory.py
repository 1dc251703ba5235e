"""A motion with names: reading, outputs, times between samples, files."""

from __future__ import annotations

import csv
import json
import pickle
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from symbody.errors import EnvironmentFault, FormatError, SymbodyError, UsageError
from symbody.simulation.native.run import Statistics
from symbody.simulation.results.trajectory import Trajectory
from symbody.simulation.status import Status
from tests.simulation.right_hand_sides import oscillator, run

Floats = NDArray[np.float64]


class Outputs:
    """Outputs of an oscillator of mass and stiffness 1, as the equations would give them."""

    def __call__(self, name: str, t: Floats, q: Floats, u: Floats) -> Floats:
        assert (t.ndim, q.shape, u.shape) == (1, (1, t.size), (1, t.size))
        known = {
            "v_dot": -q[0],
            "energy": (q[0] ** 2 + u[0] ** 2) / 2.0,
            "work": 0.0 * t,
            "constraint_violation": 0.0 * t,
            "frame r": np.array([q[0], 0.0 * t, t]),
            "frame R": np.einsum("ij,n->ijn", np.eye(3), t),
            "pair": np.array([t, -t]),
        }
        if name not in known:
            raise UsageError()
        return known[name]


def trajectory(**changes: Any) -> Trajectory:
    raw = run(oscillator, 1, 1, [0.0, 1.0], (0.0, 5.0))
    parts: dict[str, Any] = {
        "coordinate_names": ("x",),
        "speed_names": ("v",),
        "evaluate": Outputs(),
        "stored": {"F": 2.0 * raw.t},
        "units": {"x": "m", "v": "m/s"},
        "notes": ("input F has no value and is 0",),
        "name": "swing",
        "status": raw.status,
        "statistics": raw.statistics,
        "dense_output": raw.dense_output,
    }
    return Trajectory(raw.t, raw.x[1:], raw.x[:1], **{**parts, **changes})


def test_names_read_rows_stored_arrays_and_outputs() -> None:
    swing = trajectory()
    assert swing.names == ("t", "x", "v", "F")
    np.testing.assert_array_equal(swing["t"], swing.t)
    np.testing.assert_array_equal(swing["x"], swing.q[0])
    np.testing.assert_array_equal(swing["v"], swing.u[0])
    np.testing.assert_array_equal(swing["F"], 2.0 * swing.t)
    np.testing.assert_array_equal(swing["v_dot"], -swing.q[0])
    assert swing["frame r"].shape == (3, swing.t.size)
    assert swing.success
    assert swing.status.value == "the motion was computed to the end"
    assert repr(swing).startswith("<Trajectory 'swing': ")
    assert repr(swing).endswith(" (t = 0 to 5 s), 1 coordinate, 1 speed, SUCCESS>")


def test_an_unknown_name_is_told_the_nearest_ones() -> None:
    with pytest.raises(UsageError, match="no 'xx'.*\n.*save.*\n.*did you mean 'x'"):
        trajectory(evaluate=None)["xx"]
    with pytest.raises(UsageError):
        trajectory()["xx"]


def test_samples_cannot_be_changed_by_accident() -> None:
    swing = trajectory()
    for name in swing.names:
        with pytest.raises(ValueError, match="read-only"):
            swing[name][0] = 7.0


def test_shapes_must_fit_the_names() -> None:
    with pytest.raises(ValueError, match=r"u has shape \(1, .*, not \(2, "):
        trajectory(speed_names=("v", "w"))


def test_between_samples_the_motion_is_as_accurate_as_at_them() -> None:
    swing = trajectory()
    times = np.linspace(0.0, 5.0, 1001)
    # closed form x = cos t; local errors of 1e-8 over some tens of steps
    np.testing.assert_allclose(swing.at(times)["x"], np.cos(times), rtol=0.0, atol=30.0 * 1e-8)
    np.testing.assert_allclose(swing.at(swing.t)["x"], swing["x"], rtol=0.0, atol=4e-16)
    assert swing.at(times).t.shape == (1001,)
    np.testing.assert_array_equal(swing.at(times)["v_dot"], -swing.at(times)["x"])


def test_a_single_time_gives_numbers() -> None:
    moment = trajectory().at(1.0)
    assert moment["x"].shape == ()
    assert float(moment["x"]) == pytest.approx(np.cos(1.0), abs=30.0 * 1e-8)
    assert float(moment["v_dot"]) == -float(moment["x"])
    assert moment["frame r"].shape == (3,)
    assert moment.at(2.0).t == 2.0
    assert list(moment.columns("x", "frame r")) == ["x", "frame r x", "frame r y", "frame r z"]
    assert "1 sample (t = 1 to 1 s)" in repr(moment)


def test_times_that_are_not_in_the_motion_are_refused() -> None:
    with pytest.raises(UsageError, match="outside the motion, which runs from 0 to 5"):
        trajectory().at(5.5)
    with pytest.raises(UsageError, match="more than one axis"):
        trajectory().at([[1.0]])
    with pytest.raises(UsageError, match="between the samples was not stored.*\n.*times="):
        trajectory(dense_output=None).at(1.0)


def test_energy_and_its_drift() -> None:
    swing = trajectory()
    np.testing.assert_array_equal(swing.energy, swing["energy"])
    assert swing.energy_drift == np.abs(swing.energy - swing.energy[0]).max()
    assert 0.0 < swing.energy_drift < 30.0 * 1e-8
    assert swing.at(1.0).energy_drift == 0.0
    assert not swing.work.any()
    assert not swing.constraint_violation.any()


def test_columns_split_what_has_components() -> None:
    swing = trajectory()
    assert list(swing.columns()) == ["x", "v"]
    names = ["frame r x", "frame r y", "frame r z"]
    assert list(swing.columns("frame r")) == names
    np.testing.assert_array_equal(list(swing.columns("frame r").values()), swing["frame r"])
    assert list(swing.columns("frame R"))[:4] == ["frame R xx", "frame R xy", "frame R xz", "frame R yx"]
    assert list(swing.columns("pair")) == ["pair [0]", "pair [1]"]


def test_pandas(monkeypatch: pytest.MonkeyPatch) -> None:
    pandas = pytest.importorskip("pandas")
    table = trajectory().to_pandas("x", "v_dot")
    assert list(table.columns) == ["x", "v_dot"]
    assert table.index.name == "t"
    np.testing.assert_array_equal(table["v_dot"], -table["x"])
    assert isinstance(table, pandas.DataFrame)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(EnvironmentFault, match=r"pip install symbody\[pandas\]"):
        trajectory().to_pandas()


def test_csv_reads_back_exactly(tmp_path: Path) -> None:
    swing = trajectory()
    swing.to_csv(tmp_path / "swing.csv", "x", "frame r")
    with open(tmp_path / "swing.csv", newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head == ["t", "x", "frame r x", "frame r y", "frame r z"]
    np.testing.assert_array_equal(np.array(rows, dtype=float).T[:2], [swing.t, swing["x"]])
    swing.at(1.0).to_csv(tmp_path / "moment.csv")
    assert (tmp_path / "moment.csv").read_text().startswith("t,x,v\n1.0,0.54030")


def test_a_file_keeps_all_but_the_equations(tmp_path: Path) -> None:
    swing = trajectory()
    swing.save(tmp_path / "swing.run", "v_dot", "frame r", "x")
    loaded = Trajectory.load(tmp_path / "swing.run")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["swing.run"]
    assert loaded.names == ("t", "x", "v", "F", "v_dot", "frame r")
    for name in loaded.names:
        np.testing.assert_array_equal(loaded[name], swing[name])
    np.testing.assert_array_equal(loaded.at([0.3, 4.0]).q, swing.at([0.3, 4.0]).q)
    assert repr(loaded) == repr(swing)
    for attribute in ("statistics", "units", "notes", "name", "coordinate_names"):
        assert getattr(loaded, attribute) == getattr(swing, attribute)
    with pytest.raises(UsageError, match="has stored names only"):
        loaded["energy"]


def test_a_failed_run_without_dense_output_is_kept_as_well(tmp_path: Path) -> None:
    failed = Trajectory(
        np.zeros(0),
        np.zeros((1, 0)),
        np.zeros((1, 0)),
        ("x",),
        ("v",),
        Status.SINGULAR,
        Statistics(0, 0, 1, 0.0),
    )
    failed.save(tmp_path / "failed")
    loaded = Trajectory.load(tmp_path / "failed")
    assert loaded.status is Status.SINGULAR
    assert not loaded.success
    assert repr(loaded).startswith("<Trajectory 0 samples (none stored)")


def damaged(path: Path, **about: object) -> Path:
    """A file of the right kind with other words in its description."""
    trajectory().save(path)
    with zipfile.ZipFile(path) as archive, archive.open("about.npy") as file:
        text = json.loads(str(np.lib.format.read_array(file)))
    arrays = {"about": np.array(json.dumps({**text, **about})), "t": np.zeros(1)}
    with open(path, "wb") as file:
        np.savez(file, **arrays)
    return path


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("t,x\n0,1\n")
    np.save(tmp_path / "array.npy", np.zeros(3))
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    np.savez(tmp_path / "pickle.npz", about=np.array([{}], dtype=object))
    (tmp_path / "empty").write_bytes(b"")
    paths = [tmp_path / name for name in ("text", "array.npy", "other.npz", "pickle.npz", "empty")]
    paths += [damaged(tmp_path / "version", format="symbody trajectory 9"), damaged(tmp_path / "no_q")]
    for path in paths:
        with pytest.raises(FormatError, match="not a trajectory of symbody"):
            Trajectory.load(path)


def test_files_that_cannot_be_reached_are_named(tmp_path: Path) -> None:
    missing = tmp_path / "missing" / "run"
    attempts = (Trajectory.load, trajectory().save, trajectory().to_csv)
    for attempt in attempts:
        with pytest.raises(EnvironmentFault, match="No such file or directory") as caught:
            attempt(missing)
        assert isinstance(caught.value, SymbodyError)
        assert caught.value.problems[0].where == str(missing)


def test_a_trajectory_travels_between_processes() -> None:
    swing = trajectory()
    copy = pickle.loads(pickle.dumps(swing))
    np.testing.assert_array_equal(copy["v_dot"], swing["v_dot"])
    np.testing.assert_array_equal(copy.at(1.5).q, swing.at(1.5).q)
