"""Models as Python scripts: each script, run by a Python of its own, builds the same model."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import symbody as sb
from symbody.errors import SymbodyError
from symbody.formats.model_files import examples_folder
from symbody.formats.native import to_data
from symbody.formats.python_script import model_to_script

TESTS = Path(__file__).parents[1]
RUN = """
import json, runpy, sys
from symbody.formats.native import to_data
print(json.dumps([to_data(runpy.run_path(path)["model"], is_alone=True) for path in sys.argv[1:]]))
"""


def models() -> list[sb.Model]:
    found = []
    for path in sorted([*examples_folder().glob("*/*.toml"), *TESTS.glob("corpus/**/*.toml")]):
        try:
            found.append(sb.load_model(path))
        except SymbodyError:  # a file that is meant to be refused
            continue
    return found


def test_scripts_build_the_same_models(tmp_path: Path) -> None:
    drives = sb.Model(
        'a "quoted" \\ name\nand more',
        [
            sb.Body("A", mass="1.50", shapes=[sb.Box([1, 2, 3], color="#123456")], frames={"law": sb.Frame(at=[1, 0, 0])}),
            sb.Cylindrical("c", "ground", "A", torque={"c_1": sb.Drive(stiffness=2, law="c_1^3")},
                           coordinates=["c_1", "law"], force={"law": sb.Drive(law=sb.Curve([0, 1], [0, 2]))}),
            sb.SpringDamper("a spring", "ground", "A.law", stiffness=1e-7, damping=3),
        ],
        parameters={"a": None, "b": "a*2"},
    )  # fmt: skip
    written = [*models(), drives]
    paths = []
    for k, model in enumerate(written):
        path = tmp_path / f"model_{k}.py"
        path.write_text(model_to_script(model), encoding="utf-8")
        paths.append(str(path))
    done = subprocess.run([sys.executable, "-c", RUN, *paths], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [to_data(model, is_alone=True) for model in written]
    assert len(written) > 15


def test_nothing_of_a_model_becomes_code(tmp_path: Path) -> None:
    name = '"""\nimport os; os.abort()\n"""'
    path = tmp_path / "model.py"
    path.write_text(
        model_to_script(
            sb.Model(name, [sb.Body("'); import os; os.abort() #".replace("'", "").replace(".", " "))])
        )
    )
    done = subprocess.run([sys.executable, str(path)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
