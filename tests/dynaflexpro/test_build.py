"""`BuildEQs`: what it takes, what its options do, and how it completes a model."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs, BuildModel, ModelEquations
from symbody.errors import EnvironmentFault, UsageError
from tests.problems.mechanisms import EXAMPLES, model_of

FILE = EXAMPLES / "spring_mass_damper" / "spring_mass_damper.toml"


def test_from_a_path_a_text_and_a_model() -> None:
    built = [BuildEQs(FILE), BuildEQs(str(FILE), []), BuildEQs(sb.load_model(FILE))]
    assert all(isinstance(each, ModelEquations) for each in built)
    assert len({str(each.GetDynEQs()) for each in built}) == 1


def test_simplify_is_accepted_and_changes_nothing() -> None:
    plain, simple = BuildEQs(FILE), BuildEQs(FILE, ["DynSimpType", "Simplify"])
    assert simple.GetDynEQs() == plain.GetDynEQs() and simple.xM == plain.xM
    assert [note for note in simple.notes if note.startswith("DynSimpType")]
    assert not [note for note in plain.notes if note.startswith("DynSimpType")]


@pytest.mark.parametrize(
    ("options", "code", "word"),
    [
        (["DynSimpTyp", "Simplify"], "dynaflexpro.option", "DynSimpType"),
        (["DynSimpType"], "dynaflexpro.option_value", "Simplify"),
        (["DynSimpType", "simplify"], "dynaflexpro.option_value", "Simplify"),
    ],
)
def test_wrong_options_are_told(options: list[str], code: str, word: str) -> None:
    with pytest.raises(UsageError) as caught:
        BuildEQs(FILE, options)
    (problem,) = caught.value.problems
    assert problem.code == code and word in problem.fix


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(sb.FormatError, match="nowhere"):
        BuildEQs(tmp_path / "nowhere.toml")


def test_each_body_without_joint_gets_a_free_one() -> None:
    first, second, held = (sb.Body(name, mass=1, inertia=(1, 2, 3)) for name in "PQR")
    rail = sb.Prismatic("rail", "ground", held, coordinate="h")
    built = BuildEQs(sb.Model("parts", [first, rail, second]))
    assert [joint.name for joint in built.equations.model.joints] == ["rail", "P_free", "Q_free"]
    assert len(built.vQ) == len(built.vP) == 13 and built.equations.degrees_of_freedom == 13
    assert sum("Cardan" in note for note in built.notes) == 2
    turned = built.GetFrameMotion("R", "P")
    alpha, beta, gamma = dynamicsymbols("P_alpha P_beta P_gamma")
    about = [sp.rot_axis1(-alpha), sp.rot_axis2(-beta), sp.rot_axis3(-gamma)]
    assert sp.expand(turned - about[0] * about[1] * about[2]) == sp.zeros(3)


def test_a_complete_model_stays_as_it_is() -> None:
    model = model_of("slider_crank")
    assert BuildEQs(model).equations.model is model


def test_the_tree_may_be_chosen() -> None:
    built = BuildEQs(model_of("slider_crank"), tree="absolute")
    assert len(built.vP) == 18 and len(built.vQ) == 21  # positions and quaternions


def test_the_editor_runs_in_a_process_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[list[str]] = []
    codes = iter((0, 130, 5))

    def run(command: list[str], check: bool) -> subprocess.CompletedProcess[str]:
        calls.append(command)
        return subprocess.CompletedProcess(command, next(codes))

    monkeypatch.setattr(subprocess, "run", run)
    BuildModel()
    BuildModel(FILE)
    assert [call[1:] for call in calls] == [
        ["-m", "symbody", "builder"],
        ["-m", "symbody", "builder", str(FILE)],
    ]
    with pytest.raises(EnvironmentFault) as caught:
        BuildModel(FILE)
    assert caught.value.problems[0].code == "dynaflexpro.build_model"


def test_foreign_files_are_refused_with_a_cure(tmp_path: Path) -> None:
    with pytest.raises(UsageError):
        BuildModel("Examples/SpinTop.mb")
    for name in ("SpinTop.dfp", "SpinTop.MB"):
        with pytest.raises(UsageError) as caught:
            BuildEQs(tmp_path / name)
        (problem,) = caught.value.problems
        assert problem.code == "dynaflexpro.foreign_file" and "BuildEQs" in problem.fix
