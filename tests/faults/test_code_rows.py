"""The fault checklist, G: generated code. One test a row; the number is the row's."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import llvmlite
import numpy as np
import pytest

import symbody as sb
from symbody.codegen.compile import form_sequence
from symbody.codegen.llvm import stored_module
from symbody.codegen.llvm.machine import environment
from symbody.codegen.llvm.native import compile_sequence
from symbody.codegen.texts.languages import TEXTS
from tests.codegen.sequences import EXACT, TRIGONOMETRIC, random_sequence
from tests.codegen.texts.test_c import named
from tests.effort import limited
from tests.faults.test_formulation_rows import chain

ROOT = Path(__file__).parents[2]
MISSING = """
import sys
class Gone:
    def find_spec(self, name, *_):
        if name.partition(".")[0] == {library!r}:
            raise ImportError({library!r} + " is broken\\nsecond line")
sys.meta_path.insert(0, Gone())
from symbody.cli import main
sys.argv = ["symbody", "simulate", {model!r}, "--end", "0.1", "--out", {output!r}]
sys.exit(main())
"""
COMPILED = """
import numpy as np, symbody as sb
from tests.codegen.texts.test_c import named
from tests.faults.test_formulation_rows import chain
f = sb.compile(sb.form_equations(chain(3)), "udot")
print(f(0.0, np.full(3, 0.3), np.full(3, 0.2)).tobytes().hex())
"""


def started(program: str, cwd: Path, **environment: str) -> subprocess.Popen[str]:
    paths = os.pathsep.join([str(ROOT / "src"), str(ROOT)])
    return subprocess.Popen(
        [sys.executable, "-c", program], cwd=cwd, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": paths, **environment},
    )  # fmt: skip


@pytest.mark.parametrize("library", ["llvmlite"])
def test_row_70_a_missing_compiler_is_told_with_the_line_that_mends_it(library: str, tmp_path: Path) -> None:
    model = ROOT / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"
    program = MISSING.format(library=library, model=str(model), output=str(tmp_path / "x.png"))
    process = started(program, tmp_path)
    _, told = process.communicate(timeout=120)
    assert process.returncode == 5
    assert f"{library} is broken" in told and "second line" not in told
    assert re.search(rf"pip install .*{library}", told) and "Traceback" not in told


@pytest.mark.exhaustive
def test_row_71_folders_with_any_name_and_builds_at_once(tmp_path: Path) -> None:
    store, work = tmp_path / "a b ü '$(x)", tmp_path / "unwritable"
    work.mkdir()
    work.chmod(0o555)
    running = [started(COMPILED, work, SYMBODY_CACHE=str(store)) for _ in range(3)]
    told = [process.communicate(timeout=120) for process in running]
    assert all(process.returncode == 0 for process in running), told[0][1]
    assert len({out for out, _ in told}) == 1  # the same bits
    assert list(work.iterdir()) == [] and not list(store.rglob("*.tmp*"))


def test_row_72_another_version_is_another_key(monkeypatch: pytest.MonkeyPatch) -> None:
    sequence, _ = random_sequence(1, 30, EXACT)
    key = stored_module.key_of(sequence, 1)
    assert llvmlite.__version__ in environment() and environment().encode() in key
    monkeypatch.setattr(stored_module, "environment", lambda: "another processor or version")
    assert stored_module.key_of(sequence, 1) != key


def test_row_73_long_sequences_are_cut_into_functions() -> None:
    sequence, _ = random_sequence(3, 30_000, EXACT)
    with limited(6):  # seconds; as one function it takes minutes
        compile_sequence(sequence, quick=True)
    bodies = re.findall(r"^\{\n(.*?)^\}", TEXTS["c"](sequence, "f", None), re.S | re.M)
    assert len(bodies) > 10 and max(body.count("\n") for body in bodies) < 5_000


HOSTILE = (
    "x*/ int main(void){return 1;} /*",
    'a"); system("echo")',
    "a\nb",
    "'''",
    '"""',
    "=#",
    "$(reboot)",
    "%}",
    "\\",
)
# What ends the comments in which texts tell names.
ENDS = {"c": ("*/", "??/"), "python": ('"""',), "jax": ('"""',), "casadi": ('"""',)}


def skeleton(text: str) -> str:
    """Return a text with every word and every string in quotes alike, whatever the lengths of lines."""
    joined = re.sub(r" &\n\s*", " ", text)  # Fortran continues lines, and begins declarations anew
    quoted = re.sub(r'"(\\.|[^"\\\n])*"', '"s"', joined)
    words = re.sub(r"[ ]+", " ", re.sub(r"[A-Za-z_]\w*", "w", quoted))
    return words.replace("\n w(w) :: ", ", ")


@pytest.mark.parametrize("language", sorted(TEXTS))
def test_row_74_names_never_become_code(language: str) -> None:
    """Names change words and strings of the text and nothing else, nor do they end a comment."""
    harmless, hostile = (
        TEXTS[language](named(names), "f", None)
        for names in (tuple(f"h{k}" for k in range(len(HOSTILE))), HOSTILE)
    )
    assert skeleton(hostile) == skeleton(harmless) and hostile.isascii()
    assert all(hostile.count(end) == harmless.count(end) for end in ENDS.get(language, ()))


def test_row_75_arithmetic_keeps_what_is_not_a_number() -> None:
    sequence, _ = random_sequence(5, 200, (*EXACT, *TRIGONOMETRIC))
    text = compile_sequence(sequence, keep_ir=True).ir
    flags = re.compile(r"\bf(?:add|sub|mul|div|neg|cmp)\s+(?:fast|nnan|ninf|nsz|arcp|contract|afn|reassoc)\b")
    assert "fmul" in text and not flags.search(text)
    root = sb.Prismatic("P", "ground", sb.Body("A", mass=1), axis="x", coordinate="x",
                        force=sb.Drive(applied="sqrt(x)"))  # fmt: skip
    udot = sb.compile(sb.form_equations(sb.Model("root", [root])), "udot")
    assert np.isnan(udot(0.0, np.array([-1.0]), np.array([0.0]))).all()


def test_row_76_only_doubles() -> None:
    sequence, _ = form_sequence(sb.form_equations(chain(3)), ["udot"])
    assert "long double" not in TEXTS["c"](sequence, "f", None)
    text = compile_sequence(sequence, keep_ir=True).ir
    assert not re.search(r"\b(x86_fp80|fp128|ppc_fp128|half)\b", text)
