"""The benchmarks at tiny size and without peers: that the tables come, and that they are right."""

from __future__ import annotations

import importlib.util
import math
import re
import time
from collections.abc import Iterator
from io import StringIO

import numpy as np
import pytest
import sympy
from rich.console import Console

from benchmarks import derivation, evaluation, expressions, motion, nodes, overhead, rooms, trajectories
from benchmarks.__main__ import BENCHMARKS, main
from benchmarks.engines import around, moving
from benchmarks.engines.algebra import Floats, Scalar
from benchmarks.engines.counting import count_operations
from benchmarks.engines.engine import Engine
from benchmarks.engines.ours import Engine as Ours
from benchmarks.expressions import relative_difference
from benchmarks.mechanisms import Mechanism, pendulum_on_cart, spatial_chain
from benchmarks.problems import Problem, pendulum, random_operations, random_program, serial_chain
from benchmarks.process import Process, Step, Task
from benchmarks.table import Table, difference_text, ratio_text, seconds_text, show
from benchmarks.timing import Settings, in_turns, medians, rotated, seconds_per_call

ONCE = Settings(limit=60.0, rounds=1)


class Sleeper(Ours):
    def inputs(self, count: int) -> list[Scalar]:
        time.sleep(60.0)
        return []


class Refuser(Ours):
    def sin(self, x: Scalar) -> Scalar:
        raise ArithmeticError("no sines here")


class Wrong(Ours):
    def cos(self, x: Scalar) -> Scalar:
        return Ours.cos(self, x) * 1.001


def engine(name: str, package: str = "symbody") -> Engine:
    return Engine(name, package, __name__, name)


def sleepy() -> Task:
    def task(word: str) -> Iterator[Step]:
        yield Step(f"{word} begun")
        time.sleep(60.0)
        yield Step(f"{word} done")

    return task


def values_of(problem: Problem, points: Floats) -> Floats:
    algebra = Ours()
    x = algebra.inputs(problem.inputs)
    return algebra.compile(problem.differentiate(algebra, x, problem.build(algebra, x))).many(points)


@pytest.mark.exhaustive
def test_nodes_table_has_all_figures() -> None:
    (table,) = nodes.tables(ONCE, count=500)
    assert len(table.rows) == 1 + 2 * 4
    for name, measured, *_ in table.rows:
        assert float(measured.split()[0]) > 0, name
    bars = [row[2] for row in table.rows if row[2]]
    assert bars == ["4 us", "250 bytes"] * 2


def test_grown_graphs_have_about_the_size_asked_for() -> None:
    for grow in (nodes.grow_random, nodes.grow_chain):
        assert len(grow(10_000)().graph) == pytest.approx(10_000, rel=0.05)


@pytest.mark.exhaustive
def test_expressions_tables_are_complete_for_symbody() -> None:
    problems = [serial_chain(1), random_operations(20), pendulum(1)]
    tables = list(expressions.tables(ONCE, problems, [engine("Absent", "no_such_package")]))
    assert [table.title for table in tables] == [problem.name for problem in problems]
    for table in tables:
        (ours,) = table.rows
        assert all(ours[:-1]), "a figure is missing"
        assert table.notes == ("Absent: left out, no_such_package is not installed",)


@pytest.mark.exhaustive
def test_a_peer_stands_beside_symbody_with_its_difference() -> None:
    (table,) = expressions.tables(ONCE, [serial_chain(1)], [engine("Wrong")])
    wrong = dict(zip(table.columns, table.rows[1], strict=True))
    assert all("x)" in wrong[name] for name in ("all three", "operations", "one call", "in a loop"))
    assert 1e-5 < float(wrong["difference"]) < 1e-2


@pytest.mark.exhaustive
def test_who_hangs_or_fails_is_named_and_the_others_go_on() -> None:
    settings = Settings(limit=3.0, rounds=2)
    (table,) = expressions.tables(settings, [serial_chain(1)], [engine("Sleeper"), engine("Refuser")])
    ours, sleeper, refuser = (dict(zip(table.columns, row, strict=True)) for row in table.rows)
    assert ours["all three"]
    assert sleeper["build"] == refuser["build"] == "not done"
    assert sleeper["all three"].startswith("> 3 s (> ")
    assert table.notes == ("Sleeper, build: > 3 s", "Refuser, build: ArithmeticError: no sines here")


@pytest.mark.exhaustive
def test_derivation_tables_compare_equal_mechanisms() -> None:
    families = {"some": [pendulum_on_cart(2), spatial_chain(2), *derivation.FAMILIES["examples"]]}
    files, compared = derivation.tables(ONCE, ["spring_mass_damper"], families)
    ((name, *cells),) = files.rows
    assert name == "spring_mass_damper" and all(cells)
    assert compared.title == "some" and len(compared.rows) == 2 * len(families["some"])
    assert len(compared.notes) == 1, "something was stopped"
    rows = [dict(zip(compared.columns, row, strict=True)) for row in compared.rows]
    for ours, peer in zip(rows[::2], rows[1::2], strict=True):
        assert ours["engine"] == "symbody" and peer["engine"] == "SymPy"
        assert all(cell for column, cell in ours.items() if column != "difference")
        for column in ("form", "count", "both", "M and F", "udot"):
            assert peer[column].endswith("x)"), column
        # a few roundings, of systems of a condition below a hundred
        assert float(peer["difference"]) < 1e-12


def fails() -> object:
    raise ArithmeticError("no equations here")


@pytest.mark.exhaustive
def test_a_peer_that_fails_is_not_asked_for_larger_mechanisms() -> None:
    small, large = pendulum_on_cart(1), pendulum_on_cart(2)
    members = [Mechanism(small.name, small.model, fails), large]
    _, table = derivation.tables(ONCE, [], {"pendulum": members})
    assert [row[1] for row in table.rows] == ["symbody", "SymPy", "symbody"]
    assert dict(zip(table.columns, table.rows[1], strict=True))["both"] == "not done"
    assert table.notes[1:] == (
        f"{small.name}, SymPy: ArithmeticError: no equations here",
        "SymPy is not asked for larger ones",
    )


@pytest.mark.exhaustive
def test_a_process_is_ended_at_its_limit_and_what_it_said_is_kept() -> None:
    start = time.monotonic()
    with Process(sleepy) as process:
        answer = process.ask("one", limit=0.3)
        again = process.ask("two", limit=60.0)
    assert [step.name for step in answer.steps] == ["one begun"]
    assert answer.stopped == again.stopped == "> 0.3 s"
    assert not again.steps
    assert time.monotonic() - start < 30.0


def test_pendulum_of_one_link_is_the_textbook_one() -> None:
    problem = pendulum(1)
    points = problem.points(5)
    angle, _, mass, length, gravity = points.T
    # about 10 roundings of 1e-16 each
    assert values_of(problem, points)[:, 0] == pytest.approx(mass * length**2, rel=2e-15)
    assert values_of(problem, points)[:, 1] == pytest.approx(
        mass * gravity * length * np.sin(angle), rel=2e-15
    )


@pytest.mark.parametrize("links", [2, 3])
def test_mass_matrix_of_the_pendulum_is_symmetric_and_positive(links: int) -> None:
    problem = pendulum(links)
    for row in values_of(problem, problem.points(5)):
        M = row[: links * links].reshape(links, links)
        assert pytest.approx(M.T, rel=1e-14) == M
        assert np.linalg.eigvalsh(M).min() > 0


@pytest.mark.parametrize(("problem", "results"), [(serial_chain(3), 12), (random_operations(60), 6)])
def test_jacobian_agrees_with_differences(problem: Problem, results: int) -> None:
    point = problem.points(1)[0]
    columns = (len(values_of(problem, point[None])[0]) - results) // results
    step = 1e-5
    slopes = values_of(problem, point[None])[0, results:].reshape(results, columns)
    for k in range(columns):
        shift = step * np.eye(problem.inputs)[k]
        above, below = values_of(problem, np.stack([point + shift, point - shift]))[:, :results]
        # truncation: step^2 times third derivatives, below 100 here; rounding: 1e-16 / step
        assert slopes[:, k] == pytest.approx((above - below) / (2 * step), abs=1e-8)


def test_transform_of_the_chain_is_a_rotation() -> None:
    problem = serial_chain(2)
    R = values_of(problem, problem.points(1))[0, :12].reshape(3, 4)[:, :3]
    assert pytest.approx(np.eye(3), abs=1e-15) == R @ R.T  # entries at most 1, each of three products
    assert np.linalg.det(R) > 0


def test_every_operation_of_a_random_program_reaches_an_output() -> None:
    steps, inputs, lanes = random_program(200, 8, 10), 8, 10
    used = {value for step in steps for value in (step.a, step.b)}
    ends = set(range(inputs + len(steps) - lanes, inputs + len(steps)))
    assert set(range(inputs, inputs + len(steps))) <= used | ends
    assert steps == random_program(200, 8, 10)


def test_operations_of_trees_are_counted_as_symbody_counts() -> None:
    x, y, z = sympy.symbols("x y z")
    counts = {
        x: 0, -x: 0, x - y: 1, x * y + z: 2, 2 * x**3: 3, x / y: 1, 1 / x: 1, x**-2: 2,
        sympy.sin(x) - y: 2, sympy.sqrt(x): 1, x * y / z: 2,
    }  # fmt: skip
    for tree, count in counts.items():
        assert count_operations([tree]) == count, tree
    assert count_operations(counts) == sum(counts.values())


def test_difference_is_relative_to_the_largest_result_of_a_point() -> None:
    reference = np.array([[1.0, 100.0], [1e-6, 1e-3]])
    assert relative_difference(reference, reference) == 0
    assert relative_difference(reference + [[0.0, 1.0], [0.0, 0.0]], reference) == pytest.approx(
        0.01, rel=1e-12
    )
    assert relative_difference(reference + [[0.0, 0.0], [1e-4, 0.0]], reference) == pytest.approx(
        0.1, rel=1e-12
    )
    assert math.isnan(relative_difference(reference * [[math.nan], [1.0]], reference))
    assert difference_text(math.nan) == "nan"


def test_figures_are_written_to_three_digits() -> None:
    assert [seconds_text(x) for x in (2.5e-8, 1.234e-4, 0.0567, 61.2)] == [
        "25.0 ns",
        "123 us",
        "56.7 ms",
        "61.2 s",
    ]
    assert [ratio_text(x, 2.0) for x in (0.5, 3.0, 19.94, 40.0)] == [
        " (0.25x)", " (1.5x)", " (10x)", " (20x)",
    ]  # fmt: skip
    assert ratio_text(1.0, None) == ""


@pytest.mark.exhaustive
def test_turns_interleave_and_medians_ignore_one_slow_round() -> None:
    order: list[str] = []

    def task(name: str, figure: float) -> float:
        order.append(name)
        return figure if len(order) > 2 else 100 * figure

    samples = in_turns({"a": lambda: task("a", 1.0), "b": lambda: task("b", 2.0)}, rounds=3)
    assert order == ["a", "b", "b", "a", "a", "b"]
    assert medians(samples) == {"a": 1.0, "b": 2.0}
    assert rotated([], 3) == []


def test_a_call_is_timed_over_many() -> None:
    assert seconds_per_call(lambda: time.sleep(0.002), at_least=0.01) >= 0.002


def test_tables_print_every_cell_and_note() -> None:
    table = Table(
        "a title", ("engine", "time"), (("symbody", "1 us"), ("peer", "3 us [3x]")), ("left out [x]",)
    )
    console = Console(width=80, file=StringIO(), record=True)
    show(table, console)
    text = console.export_text()
    for written in (table.title, *table.columns, *table.rows[0], *table.rows[1], *table.notes):
        assert written in text


def test_command_names_the_benchmarks_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["nodez"])
    assert stopped.value.code == 2
    assert f"there are {', '.join(BENCHMARKS)}" in capsys.readouterr().err
    for wrong in (["--rounds", "0"], ["--limit", "0"]):
        with pytest.raises(SystemExit):
            main(wrong)


@pytest.mark.exhaustive
def test_rooms_table_counts_files_and_functions() -> None:
    table, sizes = rooms.tables(ONCE)
    assert all(len(row) == len(sizes.columns) for row in sizes.rows)
    assert table.columns == ("", "Model", "form_equations", "mass_matrix", "compile", "simulate")
    (_, *functions), (_, *files), *counts = table.rows
    assert all(0 < int(few) <= int(many) for few, many in zip(files, functions, strict=True))
    for k, total in enumerate(files, 1):
        assert sum(int(row[k] or 0) for row in counts) == int(total)
    assert not any("benchmarks" in row[0] for row in counts)


@pytest.mark.exhaustive
def test_evaluation_table_compares_lanes_with_points_one_by_one() -> None:
    table = evaluation.evaluations(Settings(rounds=1), ["spinning_top"], [2])
    assert [row[0] for row in table.rows] == ["spinning_top", "chain, 2 bodies"]
    assert all(len(row) == len(table.columns) and row[-1].endswith("x)") for row in table.rows)


@pytest.mark.exhaustive
def test_motion_table_compares_evaluations() -> None:
    table = motion.motions(Settings(rounds=1), [("spinning_top", 0.5, 1e-8), ("slider_crank", 2.0, 1e-6)])
    assert [row[0] for row in table.rows] == ["spinning_top", "slider_crank"]
    for row in table.rows:
        share = float(row[2].partition("(")[2].rstrip(")"))
        assert 0.8 < share < 1.25  # the same method with the same control of steps


@pytest.mark.exhaustive
def test_trajectories_of_equal_accuracy() -> None:
    """Whatever engines are installed, all that step the same function reach the same angles."""
    loose, tight = trajectories.tables(Settings(rounds=1), 2, 0.5)
    for table, bound in ((loose, 1e-4), (tight, 1e-8)):
        rows = {row[0]: row for row in table.rows}
        assert float(rows["symbody"][2]) <= bound and rows["symbody"][3].split()[1] in ("us", "ms")
        assert float(rows["SciPy's DOP853, our function"][2]) <= bound
        assert all("not installed" in note for note in table.notes[2:])


@pytest.mark.exhaustive
def test_overhead_tables_stand_beside_whatever_is_installed() -> None:
    table = overhead.chain(ONCE, 2, processes=False)
    assert table.columns[1] == "symbody" and "SciPy, our function" in table.columns
    assert len(table.rows) == 3 and all(len(row) == len(table.columns) for row in table.rows)
    loop = overhead.closed_loop(ONCE)
    assert [row[0] for row in loop.rows] == [row[0] for row in table.rows]
    calls = overhead.inside(ONCE, points=1000, bounces=3)
    assert [len(row) for row in calls.rows] == [3] * (4 + len(overhead.LANES))


def test_engines_of_the_overhead_reach_the_same_angles() -> None:
    start = around.start_angles(2)
    ours, theirs = around.ours(2)(start, 1.5, 0.2), around.scipy_around_ours(2)(start, 1.5, 0.2)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-7)
    if importlib.util.find_spec("mujoco"):  # another method, with steps of its own
        np.testing.assert_allclose(ours, around.mujoco(2)(start, 1.5, 0.2), rtol=0, atol=1e-5)


def test_chain_of_mujoco_has_the_masses_of_ours() -> None:
    text = moving.mujoco_text(3)
    assert text.count("<body ") == text.count("</body>") == 3
    assert re.findall(r'axis="([01 ]+)"', text) == ["0 1 0", "0 0 1", "1 0 0"]
    assert set(re.findall(r'mass="([^"]+)"', text)) == {str(moving.parameters(3)["m2"])}


@pytest.mark.exhaustive
def test_a_peer_that_cannot_be_used_is_left_out_with_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(links: int, end: float) -> moving.Engine:
        raise ImportError("no Cython\nhere")

    others = (("Broken", ("sys",), broken), ("Absent", ("no_such_package",), broken))
    monkeypatch.setattr(moving, "ENGINES", (*moving.ENGINES[:1], *others))
    notes = next(iter(trajectories.tables(Settings(rounds=1), 2, 0.2))).notes
    assert any(note == "Broken: left out, ImportError: no Cython here" for note in notes)
    assert any(note == "Absent: not installed" for note in notes)
