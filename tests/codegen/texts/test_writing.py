"""Properties of the texts that need no tool: legal names, widths, exact numbers, the head, messages."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

import symbody as sb
from symbody.cli import run
from symbody.codegen.texts import fortran
from symbody.codegen.texts.languages import TEXTS
from symbody.errors import CompileError
from symbody.expr import opcodes as op
from symbody.expr.sequences.sequence import Input, Operation, Output, Sequence
from tests.codegen.sequences import EXACT, LIBRARY, random_sequence, single
from tests.codegen.texts.test_agreement import NAMES
from tests.codegen.texts.test_c import HOSTILE, named
from tests.problems.mechanisms import EXAMPLES, equations_of

LANGUAGES = sorted(set(TEXTS) - {"c", "python"})  # these have tests of their own


@dataclass(frozen=True, slots=True)
class Table:
    name: str

    def __call__(self, *arguments: float) -> float:
        return 0.0

    def derivative(self, position: int) -> Table:
        return self


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_same_ascii_text_every_time(language: str) -> None:
    sequence, _ = random_sequence(3, 300, (*EXACT, *LIBRARY))
    text = TEXTS[language](sequence, "f", None)
    assert text == TEXTS[language](sequence, "f", None)
    assert text.isascii() and text.endswith("\n") and "\t" not in text


@pytest.mark.parametrize("language", ["jax", "casadi"])
@pytest.mark.parametrize("names", [HOSTILE, NAMES], ids=["of C", "of others"])
def test_python_texts_are_python(language: str, names: tuple[str, ...]) -> None:
    text = TEXTS[language](named(names), "f", None)
    assert compile(text, "made", "exec", dont_inherit=True)  # read, not run


@pytest.mark.parametrize("names", [HOSTILE, NAMES], ids=["of C", "of others"])
def test_fortran_lines_and_names(names: tuple[str, ...]) -> None:
    text = TEXTS["fortran"](named(names), "f", None)
    assert max(map(len, text.splitlines())) <= 132
    declared = [
        word.lower()
        for line in text.splitlines() if line.startswith("    real(dp)")
        for word in re.findall(r"[\w]+", line.split("::")[1].split("(")[0])
    ]  # fmt: skip
    assert len(declared) == len(set(declared)) > len(names)


def test_long_statements_are_continued() -> None:
    operations = [Operation(op.SYMBOL, (), k) for k in range(3)] + [Operation(op.FMA, (0, 1, 2))]
    operations.append(Operation(op.SIGN, (3,)))
    inputs = tuple(Input(letter * 63, "q", k) for k, letter in enumerate("abc"))
    text = fortran.generate(Sequence(inputs, (), (), (), tuple(operations), (Output("y", (), (4,)),)))
    lines = text.splitlines()
    (first,) = (k for k, line in enumerate(lines) if line.startswith("    z3 ="))
    assert lines[first].endswith("&") and lines[first + 1].startswith("        ")
    parts = [lines[first], *(line.strip() for line in lines[first + 1 : first + 3])]
    assert (
        " ".join(part.removesuffix(" &") for part in parts)
        == f"    z3 = ({'a' * 63} * {'b' * 63}) + {'c' * 63}"
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_numbers_are_exact(language: str) -> None:
    values = (0.1, 1 / 3, -2.5e-300, 1.7976931348623157e308, 5e-324, 12345678901234567.0)
    operations = [Operation(op.FLOAT, (), k) for k in range(len(values))]
    places = tuple(range(len(values)))
    sequence = Sequence((), values, (), (), tuple(operations), (Output("y", (len(values),), places),))
    text = TEXTS[language](sequence, "f", None)
    for value in values:
        assert repr(abs(value)) in text
        assert language != "fortran" or f"{abs(value)!r}_dp" in text


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_head_tells_arguments_and_results_in_order(language: str) -> None:
    eqs = equations_of("slider_crank")
    text = sb.generate_code(eqs, ["udot", "mass_matrix", "kinetic_energy"], language)
    one = language in ("fortran", "matlab", "octave", "julia")
    opening, closing = "[]" if language not in ("fortran", "matlab", "octave") else "()"
    place = 0
    for group, names in (("q", eqs.coordinate_names), ("u", eqs.speed_names), ("p", eqs.parameter_names)):
        for k, name in enumerate(names):
            place = text.index(f"{group}{opening}{k + one}{closing}", place)
            assert text[place : text.index("\n", place)].endswith(f'"{name}"')
    assert re.search(
        r'  udot  3  "udot"\n.*mass_matrix  3 x 3  "mass_matrix"\n.*  kinetic_energy  number', text
    )


@pytest.mark.parametrize("language", LANGUAGES)
def test_functions_need_a_name(language: str) -> None:
    for name in (
        "",
        "1f",
        "a b",
        "x" * 42,
        "f;",
        "z1",
        "_f",
        {"casadi": "lambda", "jax": "lambda", "rust": "fn", "javascript": "function"}.get(language, "sin"),
    ):
        with pytest.raises(CompileError, match="cannot be the name") as caught:
            TEXTS[language](single(op.ADD, 2), name, None)
        assert caught.value.problems[0].code == "compile.name"


@pytest.mark.parametrize("language", LANGUAGES)
def test_functions_of_the_user_are_refused(language: str) -> None:
    sequence = replace(single(op.CALL, 1), functions=(Table("table"),))
    with pytest.raises(CompileError, match="cannot call table"):
        TEXTS[language](sequence, "f", None)


@pytest.mark.parametrize("language", LANGUAGES)
def test_nothing_to_compute(language: str) -> None:
    assert TEXTS[language](Sequence((), (), (), (), (), ()), "f", None)


def test_languages_have_names_and_neighbours() -> None:
    eqs = equations_of("spring_mass_damper")
    assert sb.generate_code(eqs, "udot", "MATLAB") == sb.generate_code(eqs, "udot", "octave")
    assert sb.compile(eqs, "udot").source("fortran").startswith("! call f(t, q, u, r, p, udot)")
    for typed, meant in (
        ("fortan", "fortran"),
        ("matlap", "matlab"),
        ("Julai", "julia"),
        ("cassadi", "casadi"),
    ):
        with pytest.raises(CompileError, match=f"did you mean '{meant}'"):
            sb.generate_code(eqs, "udot", typed)


def test_the_command_line_writes_them(tmp_path: Path) -> None:
    model = str(EXAMPLES / "spring_mass_damper" / "spring_mass_damper.toml")
    target = tmp_path / "f.f90"
    assert run(["code", model, "--language", "fortran", "-o", "udot", "--out", str(target)]) == 0
    assert "module symbody_f" in target.read_text(encoding="ascii")
