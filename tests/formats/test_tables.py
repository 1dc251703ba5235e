"""Tables in files of values: what is read, what is refused, and where a model uses them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import symbody as sb
from symbody.cli.commands import app
from symbody.errors import SymbodyError
from symbody.formats.native import from_data, model_from_toml, model_to_toml, to_data
from symbody.formats.python_script import model_to_script

MODEL = """\
name = "post"
{head}
[parameters]
k = 1000.0
[[body]]
name = "B"
mass = 10.0
[[joint]]
name = "J"
type = "prismatic"
between = ["ground", "B"]
coordinate = "x"
force = {{ applied = "{force}" }}
[[table]]
name = "road"
file = "road.csv"
{table}
"""
ROAD = "# measured\nt; z; z2\n0; 0; 1\n500; 20; 1\n\n500; 40; 1\n1000; 0; 1\n"  # ms and mm; a jump at 0.5 s
TIMES = np.linspace(0.0, 1.2, 7)
HEIGHTS = np.array([0.0, 8.0, 16.0, 32.0, 16.0, 0.0, 0.0]) / 1e3


def write(folder: Path, road: str = ROAD, *, head: str = "", force: str = "k*(road - x) - 50*x_dot",
          table: str = 'columns = ["t", "z"]\nunits = ["ms", "mm"]') -> Path:  # fmt: skip
    (folder / "road.csv").write_text(road, encoding="utf-8")
    path = folder / "post.toml"
    path.write_text(MODEL.format(head=head, force=force, table=table), encoding="utf-8")
    return path


def test_a_table_stands_in_formulas_by_its_name(tmp_path: Path) -> None:
    model = sb.load_model(write(tmp_path))
    assert model.tables[0].points == ((0.0, 0.0), (0.5, 0.02), (0.5, 0.04), (1.0, 0.0))
    run = sb.simulate(sb.form_equations(model), 1.2, times=TIMES)
    np.testing.assert_allclose(run["road"], HEIGHTS, atol=1e-15)
    by_law = sb.Model(
        "post",
        [sb.Body("B", mass=10), sb.Prismatic("J", "ground", "B", coordinate="x",
                                             force=sb.Drive("k*(z - x) - 50*x_dot"))],
        parameters={"k": 1000}, inputs=["z"],
    )  # fmt: skip
    law = sb.Table.from_file(tmp_path / "road.csv", ["t", "z"], ["ms", "mm"])
    other = sb.simulate(sb.form_equations(by_law), 1.2, times=TIMES, inputs={"z": law})
    np.testing.assert_allclose(run["x"], other["x"], rtol=1e-7, atol=1e-10)


def test_a_table_with_the_name_of_an_input_is_its_law(tmp_path: Path) -> None:
    model = sb.load_model(write(tmp_path, head='inputs = ["road"]'))
    eqs = sb.form_equations(model)
    run = sb.simulate(eqs, 1.2, times=TIMES)
    np.testing.assert_allclose(run["road"], HEIGHTS, atol=1e-15)
    assert not any("road has no value" in note for note in run.notes)
    np.testing.assert_allclose(sb.simulate(eqs, 1.2, times=TIMES, inputs={"road": "t"})["road"], TIMES)
    assert sb.linearize(eqs).input_names == ("road",)
    swept = sb.sweep(eqs, 1.2, {"k": [500.0, 1000.0]}, times=TIMES)
    np.testing.assert_allclose(swept["x"][1], run["x"], rtol=1e-6, atol=1e-9)
    stepper = sb.Stepper(eqs, 0.1)
    for _ in range(3):
        stepper.step()
    assert stepper["road"] == pytest.approx(0.012, rel=1e-12)
    with pytest.raises(SymbodyError, match=r"table.law.*road, argument"):
        sb.load_model(write(tmp_path, head='inputs = ["road"]', table='argument = "2*t"'))


def test_a_table_moves_joints_and_reads_coordinates(tmp_path: Path) -> None:
    hill = sb.Lookup("hill", points=[[-1, 1], [0, 0], [1, 1]], argument="x/2", outside="slope")
    ramp = sb.Lookup("ramp", points=[[0, 0], [2, 6]])
    model = sb.Model(
        "two",
        [
            sb.Prismatic(
                "J", "ground", sb.Body("B", mass=1), axis="x", coordinate="x", force=sb.Drive("-hill")
            ),
            sb.Prismatic("K", "ground", sb.Body("C", mass=1), axis="y", coordinate="y", motion="ramp"),
            hill,
            ramp,
        ],
        initial={"x": 3},
    )
    run = sb.simulate(sb.form_equations(model), 0.1, times=[0.0, 0.1])
    assert run["hill"][0] == pytest.approx(1.5)  # the end slope goes on
    np.testing.assert_allclose(run["y"], [0.0, 0.3])
    np.testing.assert_allclose(run["y_dot"], 3.0)
    with pytest.raises(SymbodyError, match=r"(?s)names.not_here.*'hill' is a table of states"):
        sb.Model("no", [sb.Prismatic("J", "ground", sb.Body("B", mass=1), coordinate="x"),
                        sb.Prismatic("K", "ground", "B2", coordinate="y", motion="hill"),
                        sb.Body("B2", mass=1), hill])  # fmt: skip
    smooth = sb.Lookup("s", points=[[0, 0], [1, 1], [2, 0], [2, 5], [3, 6]], interpolation="pchip")
    eqs = sb.form_equations(
        sb.Model("s", [sb.Prismatic("J", "ground", sb.Body("B", mass=1), force=sb.Drive("s")), smooth])
    )
    law = sb.Table(*np.transpose(smooth.points), "pchip")
    times = np.linspace(-0.5, 3.5, 33)
    np.testing.assert_allclose(sb.simulate(eqs, (-0.5, 3.5), times=times)["s"], law.at(times), atol=1e-12)


def test_saving_keeps_the_file_and_trajectories_hold_the_points(tmp_path: Path) -> None:
    model = sb.load_model(write(tmp_path))
    sb.save_model(model, tmp_path / "copy.toml")
    assert 'file = "road.csv"' in (tmp_path / "copy.toml").read_text(encoding="utf-8")
    assert sb.load_model(tmp_path / "copy.toml") == model
    (tmp_path / "inner").mkdir()
    with pytest.raises(SymbodyError, match=r"file.outside.*copy the file|outside the folder"):
        sb.save_model(model, tmp_path / "inner" / "copy.toml")
    assert model_from_toml(model_to_toml(model, is_alone=True)).tables[0].points == model.tables[0].points
    assert from_data(to_data(model), folder=str(tmp_path)) == model
    assert 'sb.Lookup("road", points=[' in model_to_script(model)
    sb.simulate(sb.form_equations(model), 1.2, times=TIMES).save(tmp_path / "run.npz")
    (tmp_path / "road.csv").unlink()
    np.testing.assert_allclose(sb.Trajectory.load(tmp_path / "run.npz")["road"], HEIGHTS, atol=1e-15)


@pytest.mark.parametrize(
    ("road", "table", "code", "place"),
    [
        ("t,z\n0,1\n1,\n", "", "table.value", "road.csv:3"),
        ("t,z\n0,1\n1,nan\n", "", "table.value", "road.csv:3"),
        ("t,z\n0,1\n1,high\n", "", "table.value", "road.csv:3"),
        ("t;z\n0;1,5\n", "", "table.value", "road.csv:2"),
        ("0,1\n2,1\n1,1\n", "", "table.order", "road.csv:3"),
        ("0,1\n1,1\n1,2\n1,3\n", "", "table.order", "road.csv:4"),
        ("0,1\n0,2\n", "", "table.order", "road.csv:1"),
        ("0,1\n", "", "table.short", "road.csv"),
        ("# nothing\n\n", "", "table.empty", "road.csv"),
        ('0,"1\n', "", "table.csv", "road.csv"),
        ("t,z\n0,1\n1,1\n", 'columns = ["t", "y"]', "table.column", "road.csv:1"),
        ("t,z,z\n0,1,1\n1,1,1\n", 'columns = ["t", "z"]', "table.column", "road.csv:1"),
        ("t,z\n0,1\n1,1\n", "columns = [1, 3]", "table.column", "road.csv:1"),
        ("0,1\n1,1\n", 'units = ["s", "furlong"]', "table.unit", "road.csv"),
        ("0,1\n1,1\n", 'units = ["s"]', "file.wrong_length", "post.toml:17"),
        ("0,1\n1,1\n", 'interpolation = "cubic"', "model.curve_kind", "post.toml:17"),
        ("0,1\n1,1\n", 'argument = "road"', "names.not_here", "post.toml:17"),
        ("0,1\n1,1\n", 'argument = "2*foo"', "names.unknown", "post.toml:17"),
    ],
)
def test_faults_name_file_and_line(tmp_path: Path, road: str, table: str, code: str, place: str) -> None:
    with pytest.raises(SymbodyError) as caught:
        sb.load_model(write(tmp_path, road, table=table))
    problem = caught.value.problems[0]
    assert problem.code == code
    assert place in problem.where
    assert "post.toml" in problem.where
    assert problem.fix


@pytest.mark.parametrize(
    ("file", "code"),
    [
        ("/etc/hosts", "file.outside"),
        ("../road.csv", "file.outside"),
        ("inner/../../road.csv", "file.outside"),
        ("C:/road.csv", "file.outside"),
        ("https://example.org/road.csv", "file.outside"),
        ("link.csv", "file.outside"),
        ("raod.csv", "file.missing"),
        ("inner", "file.not_a_file"),
        ("inner\\\\road.csv", "file.bad_path"),
    ],
)
def test_paths_stay_inside_the_folder(tmp_path: Path, file: str, code: str) -> None:
    folder = tmp_path / "model"
    (folder / "inner").mkdir(parents=True)
    (tmp_path / "road.csv").write_text("0,0\n1,1\n")
    (folder / "link.csv").symlink_to(tmp_path / "road.csv")
    path = write(folder)
    path.write_text(path.read_text().replace('"road.csv"', f'"{file}"'))
    with pytest.raises(SymbodyError) as caught:
        sb.load_model(path)
    assert caught.value.problems[0].code == code
    assert caught.value.problems[0].fix


def test_arguments_that_are_no_table() -> None:
    for arguments, code in (
        ({}, "table.one_of"),
        ({"points": [[0, 1]]}, "table.short"),
        ({"points": [[0, 1], [1, 2, 3]]}, "table.point"),
        ({"points": [[0, 1], [-1, 2]]}, "table.order"),
        ({"points": [[0, 1], [1, 2]], "columns": "tz"}, "model.not_a_list"),
        ({"points": [[0, 1], [1, 2]], "columns": [1.5, 2]}, "table.columns"),
        ({"points": [[0, 1], [1, 2]], "units": [1, 2]}, "table.units"),
    ):
        with pytest.raises(SymbodyError) as caught:
            sb.Lookup("road", **arguments)
        assert caught.value.problems[0].code == code
    long = sb.Lookup("road", points=[[k, k] for k in range(501)])
    model = sb.Model("long", [sb.Body("B", mass=1), sb.Force("f", "B", ["road", 0, 0]), long])
    with pytest.raises(SymbodyError, match=r"(?s)equations.long_table.*inputs = \['road'\]"):
        sb.form_equations(model)


def test_the_command_line_reads_laws_from_files(tmp_path: Path) -> None:
    path = write(tmp_path, head='inputs = ["z"]', force="k*(z - x)")
    seconds = tmp_path / "seconds.csv"
    seconds.write_text("t,a,z\n0,0,0\n1,0,0.1\n")
    table, runner = tmp_path / "run.csv", CliRunner()
    words = ["simulate", str(path), "-t", "1", "--samples", "3", "-s", "z", "--csv", str(table)]
    result = runner.invoke(app, [*words, "-i", f"z=@{seconds}[t,z]"])
    assert result.exit_code == 0, result.output
    rows = np.genfromtxt(table, delimiter=",", names=True)
    np.testing.assert_allclose(rows["z"], [0.0, 0.05, 0.1], atol=1e-15)
    result = runner.invoke(app, [*words, "--force", "-i", f"z=@{tmp_path / 'none.csv'}"])
    assert isinstance(result.exception, SymbodyError | SystemExit)


def test_a_slip_in_the_first_row_is_no_header(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("0.O;1\n0.5;2\n1;3\n", encoding="utf-8")
    with pytest.raises(SymbodyError) as caught:
        sb.Lookup("a", file="a.csv", folder=str(tmp_path))
    assert caught.value.problems[0].code == "table.value" and "a.csv:1" in caught.value.problems[0].where


@pytest.mark.parametrize("arguments", [{"units": "mm"}, {"columns": "tz"}])
def test_one_text_is_no_pair(tmp_path: Path, arguments: dict[str, str]) -> None:
    path = tmp_path / "a.csv"
    path.write_text("t,z\n0,1\n1,2\n", encoding="utf-8")
    with pytest.raises(SymbodyError, match="give two columns and two units"):
        sb.Table.from_file(path, **arguments)  # type: ignore[arg-type]
