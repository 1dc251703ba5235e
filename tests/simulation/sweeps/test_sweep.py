"""Sweeps: the same bits whoever computes them, a record for every case, whatever happens to others."""

from __future__ import annotations

import concurrent.futures
import functools
import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import symbody as sb

EXAMPLES = Path(__file__).parents[3] / "examples"
MASSES = [0.9, 1.0, 1.1]
RATES = [8.0, 10.0, 12.0, 14.0]


@functools.cache
def equations(name: str) -> sb.EquationSet:
    return sb.form_equations(sb.load_model(EXAMPLES / name / f"{name}.toml"))


def tops(**options: object) -> sb.Sweep:
    return sb.sweep(
        equations("spinning_top"),
        1.0,
        {"m": MASSES},
        initial={"xi_dot": RATES},
        times=[0.0, 0.5, 1.0],
        **options,
    )


def cranks(**options: object) -> sb.Sweep:
    """Closed loops, with lengths that change where they close."""
    return sb.sweep(
        equations("slider_crank"),
        0.5,
        {"L1": [0.4, 0.45, 0.5]},
        initial={"theta_dot": [4.0, 5.0]},
        times=[0.0, 0.25, 0.5],
        **options,
    )


def same_bits(a: sb.Sweep, b: sb.Sweep) -> bool:
    return (
        a.x.tobytes() == b.x.tobytes()
        and a.status == b.status
        and a.counts.tobytes() == b.counts.tobytes()
        and a.reached.tobytes() == b.reached.tobytes()
    )


def test_cases_are_those_of_simulate() -> None:
    # Parameters that stay symbols round otherwise than numbers: 1e3 times the tolerance covers how errors of
    # 1e-8 grow over a second.
    result = tops()
    assert result.success and len(result) == 12
    for case in (0, 5, 11):
        values = {name: float(column[case]) for name, column in result.cases.items()}
        run = sb.simulate(
            equations("spinning_top"),
            1.0,
            {"xi_dot": values["xi_dot"]},
            parameters={"m": values["m"]},
            times=result.t,
        )
        np.testing.assert_allclose(result["eta"][case], run["eta"], atol=1e-5)
        np.testing.assert_allclose(result["energy"][case], run["energy"], rtol=1e-5)


def test_closed_loops_start_and_stay_closed_in_every_case() -> None:
    result = cranks()
    assert result.success
    for case in range(len(result)):
        values = {name: float(column[case]) for name, column in result.cases.items()}
        run = sb.simulate(
            equations("slider_crank"),
            0.5,
            {"theta_dot": values["theta_dot"]},
            parameters={"L1": values["L1"]},
            times=result.t,
        )
        np.testing.assert_allclose(result["s"][case], run["s"], atol=1e-6)
    assert np.abs(result["constraints"]).max() < 1e-9  # atol times a mechanism of about 1 m, ten times


@pytest.mark.parametrize("made", [tops, cranks])
@pytest.mark.parametrize("options", [{"threads": 1}, {"threads": 3, "part": 1}, {"part": 5}, {"part": 100}])
def test_results_do_not_depend_on_threads_and_parts(
    made: Callable[..., sb.Sweep], options: dict[str, int]
) -> None:
    assert same_bits(made(), made(**options))


def test_cases_do_not_depend_on_their_neighbours() -> None:
    whole = tops()
    last = sb.sweep(
        equations("spinning_top"), 1.0, {"m": [1.1]}, initial={"xi_dot": [14.0]}, times=[0.0, 0.5, 1.0]
    )
    assert last.x[0].tobytes() == whole.x[-1].tobytes()


def test_results_do_not_depend_on_the_executor() -> None:
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        assert same_bits(tops(), tops(executor=pool, part=5, threads=2))


@pytest.mark.exhaustive
def test_results_do_not_depend_on_processes() -> None:
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        assert same_bits(tops(), tops(executor=pool, part=2))
        assert same_bits(cranks(), cranks(executor=pool, part=2))


class Losing(concurrent.futures.Executor):
    """Loses some parts the first time they are given out, like a worker that is killed."""

    def __init__(self, lost: Callable[[int, int], bool]) -> None:
        self.asked: dict[int, int] = {}
        self._lost = lost

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        task: concurrent.futures.Future[object] = concurrent.futures.Future()
        first = arguments[1].first
        self.asked[first] = self.asked.get(first, 0) + 1
        if self._lost(first, self.asked[first]):
            task.set_exception(ConnectionError("worker closed"))
        else:
            task.set_result(function(*arguments, **named))
        return task


def test_lost_parts_are_given_out_again() -> None:
    executor = Losing(lambda first, time: time == 1 and first % 2 == 0)
    assert same_bits(tops(), tops(executor=executor, part=1))
    assert set(executor.asked.values()) == {1, 2}


def test_a_case_that_kills_every_worker_is_told_and_costs_no_other() -> None:
    usual = tops()
    executor = Losing(lambda first, time: first <= 6 < first + sizes[first])
    sizes = {first: 4 for first in (0, 4, 8)}
    submit = executor.submit

    def submitted(function, payload, part, threads):  # type: ignore[no-untyped-def]
        sizes[part.first] = part.count
        return submit(function, payload, part, threads)

    executor.submit = submitted  # type: ignore[method-assign]
    result = tops(executor=executor, part=4)
    assert [k for k, status in enumerate(result.status) if not status.success] == [6]
    assert result.status[6] is sb.Status.WORKER_LOST
    assert "ConnectionError: worker closed" in result.case_notes[6]
    others = [k for k in range(12) if k != 6]
    assert result.x[others].tobytes() == usual.x[others].tobytes()


def test_an_executor_that_can_compute_nothing_is_an_error() -> None:
    with pytest.raises(sb.EnvironmentFault, match="sweep.no_worker") as fault:
        tops(executor=Losing(lambda first, time: True))
    assert "worker closed" in str(fault.value)


@pytest.mark.exhaustive
def test_a_killed_process_costs_its_pool_and_no_finished_case(tmp_path: Path) -> None:
    def call(**options: object) -> sb.Sweep:
        return sb.sweep(
            equations("spinning_top"), 5.0, {"m": MASSES * 40}, times=[5.0], part=1, store=tmp_path, **options
        )

    spawn = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, spawn) as pool:
        told: list[float] = []

        def kill(share: float) -> None:
            if share > 0.0 and not told:
                told.append(share)
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        result = call(executor=pool, progress=kill)
    assert told and 0 < result.succeeded.sum() < len(result)
    assert any("the executor broke (BrokenProcessPool" in note for note in result.notes)
    lost = [k for k, status in enumerate(result.status) if status is sb.Status.WORKER_LOST]
    assert lost and all("BrokenProcessPool" in result.case_notes[k] for k in lost)
    with concurrent.futures.ProcessPoolExecutor(2, spawn) as pool:
        rest = call(executor=pool)
    assert same_bits(sb.sweep(equations("spinning_top"), 5.0, {"m": MASSES * 40}, times=[5.0]), rest)


@pytest.mark.exhaustive
def test_a_dask_worker_killed_in_the_middle_loses_no_case() -> None:
    distributed = pytest.importorskip("distributed")
    values = np.linspace(0.9, 1.1, 4000)
    eqs = equations("spinning_top")
    usual = sb.sweep(eqs, 10.0, {"m": values}, times=[5.0, 10.0])
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = list(client.run(os.getpid).values())
        told: list[float] = []

        def kill(share: float) -> None:
            if share > 0.0 and not told:
                told.append(share)
                os.kill(pids[0], signal.SIGKILL)

        result = sb.sweep(
            eqs,
            10.0,
            {"m": values},
            times=[5.0, 10.0],
            executor=client.get_executor(),
            part=100,
            progress=kill,
        )
    assert told[0] < 1.0
    assert result.success and same_bits(usual, result)


def test_failing_cases_keep_what_they_reached_and_spoil_no_other() -> None:
    # x' = x^2 from 1 runs to infinity at t = 1, from -1 it does not
    model = sb.Model(
        "runaway",
        [
            sb.Body("B", mass=1),
            sb.Prismatic("slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive("2*k*x**3")),
        ],
        gravity=(0, 0, 0),
        parameters={"k": 1.0},
    )
    eqs = sb.form_equations(model)
    result = sb.sweep(
        eqs, 2.0, {"k": [-1.0, 1.0, 0.0]}, initial={"x": 1.0, "x_dot": 1.0}, times=[0.0, 0.5, 0.9, 1.5, 2.0]
    )
    assert [status.success for status in result.status] == [True, False, True]
    np.testing.assert_allclose(result["x"][1, :3], [1.0, 2.0, 10.0], rtol=1e-5)  # 1/(1 - t)
    assert np.isnan(result["x"][1, 3:]).all()
    np.testing.assert_allclose(result["x"][2], [1.0, 1.5, 1.9, 2.5, 3.0])
    assert result.reached[1] == pytest.approx(1.0, abs=1e-3)
    assert "known up to t = " in result.case_notes[1]
    run = result.trajectory(1)
    assert run.t.tolist() == [0.0, 0.5, 0.9] and not run.success
    assert np.isnan(result["energy"][1, 3:]).all()


def test_cases_that_cannot_be_assembled_are_told() -> None:
    result = sb.sweep(
        equations("slider_crank"), 0.2, {"L2": [1.0, 0.05]}, initial={"theta": 1.0}, times=[0.2]
    )
    assert result.status[1] is sb.Status.NOT_STARTED
    assert "assembly" in result.case_notes[1]
    assert result.status[0].success


def test_a_stored_sweep_goes_on_where_it_ended(tmp_path: Path) -> None:
    usual = tops()
    half = tops(executor=AtMost(3), part=2, store=tmp_path, progress=until(0.5))
    assert [status.success for status in half.status] == [True] * 6 + [False] * 6
    assert half.x[:6].tobytes() == usual.x[:6].tobytes()
    rest = AtMost(12)
    assert same_bits(usual, tops(executor=rest, part=4, store=tmp_path))
    assert rest.cases == [4, 2]
    again = AtMost(12)
    assert same_bits(usual, tops(executor=again, store=tmp_path))
    assert not again.cases


def test_a_store_of_another_sweep_is_refused_and_damage_is_computed_anew(tmp_path: Path) -> None:
    usual = tops(store=tmp_path)
    next(tmp_path.glob("cases_*.npz")).write_bytes(b"PK\x03\x04 half a file")
    assert same_bits(usual, tops(store=tmp_path))
    with pytest.raises(sb.UsageError, match="parts of another sweep"):
        tops(store=tmp_path, rtol=1e-9)


@pytest.mark.parametrize("integrator", [None, sb.Stiff()])
def test_stiff_integration_is_swept_one_by_one_events_are_not(integrator: object) -> None:
    given = {"times": [0.0, 1.0], "events": sb.Event("eta - 2", action="stop"), "integrator": integrator}
    result = sb.sweep(equations("spinning_top"), 1.0, {"m": MASSES}, initial={"xi_dot": 0.0}, **given)
    assert result.status == (sb.Status.STOPPED,) * 3
    assert any("one after the other" in note for note in result.notes) == (integrator is not None)
    run = sb.simulate(equations("spinning_top"), 1.0, {"xi_dot": 0.0}, parameters={"m": 0.9}, **given)
    np.testing.assert_allclose(result.trajectory(0).q, run.q, rtol=1e-9)


def until(end: float) -> Callable[[float], bool]:
    """Progress that ends a sweep at a share of it, and that fails rather than wait for what never comes."""
    last = time.monotonic() + 60.0

    def goes_on(share: float) -> bool:
        assert time.monotonic() < last, f"nothing more comes after a share of {share}"
        return share < end

    return goes_on


class AtMost(concurrent.futures.Executor):
    """Computes so many parts and leaves the others waiting."""

    def __init__(self, parts: int) -> None:
        self.cases: list[int] = []
        self._parts = parts

    def submit(self, function, /, *arguments, **named):  # type: ignore[no-untyped-def]
        task: concurrent.futures.Future[object] = concurrent.futures.Future()
        if len(self.cases) < self._parts:
            self.cases.append(arguments[1].count)
            task.set_result(function(*arguments, **named))
        return task


@pytest.mark.parametrize("options", [{}, {"executor": True}])
def test_ctrl_c_keeps_finished_cases(options: dict[str, bool]) -> None:
    usual = tops()

    waits = until(1.0)

    def press(share: float) -> None:
        waits(share)
        if share > 0.0:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        if options:
            result = tops(executor=AtMost(5), part=1, progress=press)
        else:
            result = sb.sweep(
                equations("spinning_top"),
                (0.0, 1e4),
                {"m": MASSES * 20},
                times=[1e4],
                threads=1,
                part=1,
                progress=press,
            )
    finally:
        signal.signal(signal.SIGINT, before)
    done = result.succeeded
    assert 0 < done.sum() < len(result)
    assert {result.status[k] for k in np.flatnonzero(~done)} == {sb.Status.INTERRUPTED}
    if options:
        assert result.x[done].tobytes() == usual.x[done].tobytes()


def test_too_many_samples_are_refused_before_anything_is_computed() -> None:
    with pytest.raises(sb.SimulationError, match="sweep.memory") as fault:
        sb.sweep(
            equations("spinning_top"),
            1.0,
            {"m": sb.Samples("uniform", 1, 2)},
            samples=10**6,
            times=np.linspace(0, 1, 10**6),
        )
    assert "times=[t_end]" in str(fault.value)


def test_all_faults_of_a_call_are_told_at_once() -> None:
    eqs = equations("spinning_top")
    with pytest.raises(sb.UsageError) as fault:
        sb.sweep(eqs, 1.0, {"m": [1.0, np.nan], "L": []}, initial={"eta": ["a"]}, samples=3, combine="lists")  # type: ignore[arg-type]
    text = str(fault.value)
    assert len(fault.value.problems) == 5 and all(
        word in text for word in ("m", "L", "eta", "samples", "lists")
    )
    with pytest.raises(sb.CompileError) as wrong:
        sb.sweep(eqs, 1.0, {"mm": [1.0], "M": 2.0})
    assert {problem.where for problem in wrong.value.problems} == {"mm", "M"}
    with pytest.raises(sb.AssemblyError) as unknown:
        sb.sweep(eqs, 1.0, {"m": [1.0]}, initial={"etta": [1.0], "zeto_dot": 0.1})
    assert len(unknown.value.problems) == 2
    with pytest.raises(sb.UsageError, match="not an Executor"):
        sb.sweep(eqs, 1.0, {"m": [1.0]}, executor="dask")  # type: ignore[arg-type]


def test_stiff_cases_are_handed_to_simulate() -> None:
    model = sb.Model(
        "damper",
        [
            sb.Body("B", mass=1),
            sb.Prismatic(
                "slide", "ground", "B", axis="x", coordinate="x", force=sb.Drive(stiffness="1", damping="d")
            ),
        ],
        gravity=(0, 0, 0),
        parameters={"d": 1.0},
    )
    eqs = sb.form_equations(model)
    result = sb.sweep(eqs, 100.0, {"d": [1.0, 1e5]}, initial={"x": 1.0}, times=[100.0])
    assert result.success
    assert "stiff" in result.case_notes[1]
    # overdamped: x = exp(-t/d) but for 1/d^2
    np.testing.assert_allclose(result["x"][1, -1], np.exp(-100.0 / 1e5), rtol=1e-7)


def test_a_data_set_names_its_axes(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    result = tops()
    data = result.to_xarray("energy", "frame r Top.CoM ground ground")
    assert data["x"].dims == ("case", "state", "time")
    assert data["energy"].dims == ("case", "time")
    np.testing.assert_array_equal(data["x"].sel(state="eta"), result["eta"])
    assert data["m"].dims == ("case",)
    assert set(data["status"].values) == {"SUCCESS"}


@pytest.mark.exhaustive
@pytest.mark.parametrize("form", ["netcdf", "zarr"])
def test_a_data_set_survives_its_file(form: str, tmp_path: Path) -> None:
    xarray = pytest.importorskip("xarray")
    data = tops().to_xarray()
    if form == "zarr":
        pytest.importorskip("zarr")
        data.to_zarr(tmp_path / "tops.zarr", consolidated=False)
        back = xarray.open_zarr(tmp_path / "tops.zarr", consolidated=False).load()
    else:
        data.to_netcdf(tmp_path / "tops.nc")
        back = xarray.load_dataset(tmp_path / "tops.nc")
    assert back["x"].values.tobytes() == data["x"].values.tobytes()
    assert [str(name) for name in back["state"].values] == list(data["state"].values)
