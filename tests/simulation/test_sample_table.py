"""A motion as a mapping of names, and as tables: columns, CSV, MATLAB, xarray."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import symbody as sb
from tests.display.test_views import oscillator


@pytest.fixture(scope="module")
def run() -> sb.Trajectory:
    return sb.simulate(sb.form_equations(oscillator()), 0.5, {"x": 1.0})


def test_a_motion_is_a_mapping_of_what_is_stored(run: sb.Trajectory) -> None:
    assert list(run) == list(run.keys()) == ["t", "x", "x_dot", "work"]
    assert len(run) == 4 and "x" in run and "energy" not in run and 3 not in run
    assert (
        dict(run)["x"] is not None
        and {name: values.shape for name, values in run.items()}["t"] == run.t.shape
    )
    np.testing.assert_array_equal(dict(run)["x_dot"], run["x_dot"])


def test_components_are_named_as_outputs_on_demand(run: sb.Trajectory, tmp_path: Path) -> None:
    names = [f"reaction slider {word}" for word in ("Fx", "Fy", "Fz", "Mx", "My", "Mz")]
    columns = run.columns("reaction slider", "frame r Mass", names="outputs")
    assert list(columns) == [*names, "frame r Mass x", "frame r Mass y", "frame r Mass z"]
    for name, values in columns.items():
        np.testing.assert_array_equal(values, run[name])
    assert list(run.columns("reaction slider"))[0] == "reaction slider [0]"  # as before, for one release
    run.to_csv(tmp_path / "run.csv", "reaction slider", names="outputs")
    with open(tmp_path / "run.csv", newline="") as file:
        assert next(csv.reader(file)) == ["t", *names]
    with pytest.raises(sb.UsageError, match="names = 'others'"):
        run.columns("x", names="others")  # type: ignore[arg-type]


@pytest.mark.parametrize("moment", [False, True])
def test_matlab_data(run: sb.Trajectory, moment: bool, tmp_path: Path) -> None:
    chosen = run.at(0.25) if moment else run
    chosen.to_mat(tmp_path / "run.mat", "x", "reaction slider")
    data = loadmat(tmp_path / "run.mat")
    np.testing.assert_array_equal(
        data["reaction_slider_Fx"][:, 0], np.atleast_1d(chosen["reaction slider Fx"])
    )
    assert [str(cell[0]) for cell in data["variables"].ravel()][:3] == ["t", "x", "reaction_slider_Fx"]
    assert [str(cell[0]) for cell in data["units"].ravel()][:3] == ["s", "m", "N"]
    with pytest.raises(sb.EnvironmentFault, match=r"folder|directory"):
        run.to_mat(tmp_path / "nowhere" / "run.mat")


@pytest.mark.parametrize(("name", "cure"), [("o.mat", "to_mat"), ("o.CSV", "to_csv"), ("o.nc", "to_netcdf")])
def test_save_refuses_the_endings_of_tables(run: sb.Trajectory, name: str, cure: str, tmp_path: Path) -> None:
    with pytest.raises(sb.UsageError, match=cure) as caught:
        run.save(tmp_path / name)
    assert caught.value.problems[0].code == "trajectory.ending"
    assert not (tmp_path / name).exists()


def test_xarray(run: sb.Trajectory) -> None:
    pytest.importorskip("xarray")
    data = run.to_xarray("x", "reaction slider", "frame R Mass")
    assert dict(data.sizes) == {"t": run.t.size, "wrench": 6, "xyz": 3, "xyz1": 3}
    assert data["x"].attrs["units"] == "m"
    np.testing.assert_array_equal(data["frame R Mass"].values, run["frame R Mass"])


def test_axes_of_xarray_are_named_by_what_they_are() -> None:
    pytest.importorskip("xarray")
    bodies = [sb.Body(f"B{k}", mass=1) for k in range(6)]
    slides = [
        sb.Prismatic(f"S{k}", "ground", body, axis="x", coordinate=f"s{k}") for k, body in enumerate(bodies)
    ]
    run = sb.simulate(sb.form_equations(sb.Model("m", slides, (0, 0, -10))), 0.1)
    data = run.to_xarray("udot", "mass_matrix", "reaction S0", "frame r B0 ground ground")
    assert data["udot"].dims == ("axis of 6", "t")  # accelerations are no wrench
    assert data["mass_matrix"].dims == ("axis of 6", "axis of 6, second", "t")
    assert data["reaction S0"].sel(wrench="Fz").values == pytest.approx(10.0)
    assert data["frame r B0 ground ground"].sel(xyz="z").values == pytest.approx(0.0)


def test_without_xarray_it_says_what_to_install(run: sb.Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "xarray", None)
    with pytest.raises(sb.EnvironmentFault, match=r"symbody\[sweep\]"):
        run.to_xarray()
