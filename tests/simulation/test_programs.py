"""Whole simulations as programs: they stand alone, and give the same bits in every language."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody.codegen.llvm.kernel_library import compile_trees
from symbody.simulation.native.run import NativeRun, fresh_record
from symbody.simulation.programs import generate_simulation as generation
from symbody.simulation.programs.generate_simulation import PreparedMotion
from symbody.simulation.programs.program_function import PROJECTION, RIGHT_HAND_SIDE
from tests.simulation.loops import example

Floats = NDArray[np.float64]
COMMANDS = {
    "c": ("m.c", [["gcc", "-std=c99", "-O2", "-ffp-contract=off", "m.c", "-o", "m", "-lm"], ["./m"]]),
    "javascript": ("m.js", [["node", "m.js"]]),
    "python": ("m.py", [[sys.executable, "-I", "m.py"]]),
}
# Example, last time, options.
MOTIONS = {
    "slider_crank": (1.0, {}),
    "spinning_top": (1.0, {}),
    "bicycle": (0.2, {}),
    "four_bar": (0.5, {"integrator": sb.Explicit(order=5), "rtol": 1e-6}),
    "rr_robot": (1.0, {"integrator": sb.FixedStep(0.05)}),
    "spring_mass_damper": (
        3.0,
        {"integrator": sb.FixedStep(0.05, "semi-implicit"), "inputs": {"F": "sin(3*t)"}},
    ),
}


def samples(folder: Path, language: str, text: str) -> Floats:
    """What a program prints, away from everything of ours."""
    file, commands = COMMANDS[language]
    (folder / file).write_text(text)
    for command in commands:
        if shutil.which(command[0]) is None and not command[0].startswith("./"):
            pytest.skip(f"needs {command[0]}")
        run = subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=300,
            env={"PATH": "/usr/bin:/bin:/usr/local/bin"},
        )
        assert run.returncode == 0 and run.stderr == "", run.stderr
    return np.array([[float(word) for word in line.split(",")] for line in run.stdout.split("\n")[1:-1]])


def machine_samples(motion: PreparedMotion) -> Floats:
    """The same kernels as machine code, without fused operations."""
    places = compile_trees({name: tree for name, tree in motion.kernels.items()})
    projection = places[PROJECTION] if motion.is_projected else 0
    run = NativeRun(places[RIGHT_HAND_SIDE], projection, motion.block.copy())
    record = fresh_record(run, motion.times, dense=False)
    code = run.begin(record)
    while code == 0:
        code = run.advance(record, 1000)
    assert code == 2
    stored = motion.times.size  # a record has room for both states of an event beyond that
    return np.column_stack([record.t[:stored], record.x[:stored]])


QUICK = {"rr_robot"}


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.exhaustive) for name in MOTIONS]
)
def test_programs_give_the_bits_of_machine_code_in_every_language(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    end, options = MOTIONS[name]
    eqs, times = example(name), np.linspace(0.0, end, 8)
    motions: list[PreparedMotion] = []
    usual = generation.program_text
    monkeypatch.setattr(
        generation, "program_text", lambda motion, *rest: motions.append(motion) or usual(motion, *rest)
    )
    texts = {
        language: sb.generate_simulation(eqs, end, language, times=times, **options) for language in COMMANDS
    }
    expected = machine_samples(motions[0])
    for language, text in texts.items():
        np.testing.assert_array_equal(samples(tmp_path, language, text), expected, err_msg=language)
    run = sb.simulate(eqs, end, times=times, **options)
    np.testing.assert_array_equal(expected[:, 0], run.t)
    scale = max(1.0, float(np.abs(expected[:, 1:-1]).max()))
    np.testing.assert_allclose(expected[:, 1:-1].T, np.vstack([run.u, run.q]), atol=1e-7 * scale)


def test_a_program_says_how_it_ended(tmp_path: Path) -> None:
    text = sb.generate_simulation(example("slider_crank"), 1.0, "python", max_steps=3)
    (tmp_path / "m.py").write_text(text)
    run = subprocess.run(
        [sys.executable, "-I", str(tmp_path / "m.py")], capture_output=True, text=True, check=False
    )
    assert run.returncode == 1 and run.stdout.startswith("t,")


def test_what_cannot_be_a_program_is_refused() -> None:
    eqs = example("spring_mass_damper")
    with pytest.raises(
        sb.UsageError, match="programs cannot be generated in 'cobol'\n.*c, javascript, python"
    ):
        sb.generate_simulation(eqs, 1.0, "cobol")
    with pytest.raises(sb.UsageError, match="inputs F are computed in Python\n.*give inputs as formulas"):
        sb.generate_simulation(eqs, 1.0, inputs={"F": lambda t, q, u: 1.0})
