"""Modelica models: all examples in a Modelica compiler, names, choices, refusals, the command line."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import symbody as sb
from symbody.cli import run
from symbody.codegen.texts.modelica import Declaration, ModelDeclarations, model_text
from symbody.errors import SymbodyError
from symbody.expr import opcodes as op
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Output
from tests.codegen.sequences import EXACT, LIBRARY, random_sequence
from tests.problems.mechanisms import EXAMPLES, equations_of
from tests.problems.test_mobility import parallelograms_inside

rumoca = pytest.importorskip("rumoca", reason="needs the package rumoca")

NAMES = sorted(f"{path.parent.name}/{path.stem}" for path in EXAMPLES.glob("*/*.toml") if path.stem != "leg")
# Minutes of compiling on a slow machine.
LARGE = {"four_legs/four_legs", "stewart_platform/stewart_platform", "bicycle/bicycle"}
CASES = [pytest.param(n, marks=[pytest.mark.exhaustive] if n in LARGE else []) for n in NAMES]


def simulate(text: str, inputs: dict[str, float], end: float, start: float = 0.0) -> Any:
    """Return a motion by the Modelica compiler; inputs are constants of a model around the model."""
    name = text.split()[1]
    assert [d.message for d in rumoca.validate_source(text) if d.level == "error"] == []
    if inputs:
        values = ", ".join(f"{word} = {value!r}" for word, value in inputs.items())
        text += f"model Driven\n  {name} m({values});\nend Driven;\n"
    model = rumoca.Session().loads(text, model="Driven" if inputs else name)
    config = rumoca.SimConfig(rtol=1e-9, atol=1e-11)
    return model.simulate(t=(start, end), dt=(end - start) / 10, config=config)


@pytest.mark.parametrize("name", CASES)
def test_examples_move_as_in_simulate(name: str) -> None:
    eqs = sb.form_equations(sb.load_model(EXAMPLES / f"{name}.toml"))
    if eqs.model.held_signals:
        with pytest.raises(SymbodyError) as caught:
            sb.generate_code(eqs, "energy", "modelica")
        assert caught.value.problems[0].code == "signal.sampled"
        return
    inputs = {word: 0.3 + 0.1 * k for k, word in enumerate(eqs.input_names)}
    result = simulate(sb.generate_code(eqs, "energy", "modelica"), inputs, 1.0)
    ours = sb.simulate(eqs, 1.0, inputs=dict(inputs), times=np.asarray(result.time), rtol=1e-10)
    before = "m." if inputs else ""
    for word in (*eqs.state_names, "energy"):
        size = max(1.0, float(np.abs(ours[word]).max()))
        assert np.asarray(result[f"{before}{word}"]) == pytest.approx(ours[word], abs=3e-6 * size), word


def test_another_length_closes_the_loop_anew() -> None:
    eqs = equations_of("slider_crank")
    text = sb.generate_code(eqs, [], "modelica")
    length = next(word for word in eqs.parameter_names if re.search(rf"\b{word}\(unit=\"m\"\)", text))
    (number,) = re.findall(rf"\b{length}\(unit=\"m\"\) = ([^;]+);", text)
    value = 1.05 * float(number)
    changed = re.sub(rf"(\b{length}\(unit=\"m\"\)) = [^;]+;", rf"\1 = {value!r};", text)
    result = simulate(changed, {"F": 0.0}, 0.5)
    assert np.abs(np.asarray(result["m.constraints[1]"])).max() < 1e-6
    chosen = dict(re.findall(r"Real (\w+)\(unit=\"[^\"]+\", start=([^,]+), fixed=true", text))
    ours = sb.simulate(
        eqs, 0.5, {word: float(start) for word, start in chosen.items()}, parameters={length: value},
        times=np.asarray(result.time), rtol=1e-10,
    )  # fmt: skip
    assert len(chosen) == 2
    for word in eqs.coordinate_names:
        assert np.asarray(result[f"m.{word}"]) == pytest.approx(ours[word], abs=1e-5)


@pytest.mark.parametrize("seed", range(12))
def test_text_equals_graph(seed: int) -> None:
    codes = tuple(code for code in (*EXACT, *LIBRARY) if code != op.SADDLE)
    sequence, point = random_sequence(seed, 60, codes)
    start = point["t"][0]
    rate = Output("xdot", (1,), sequence.outputs[0].values[:1])
    sequence = replace(sequence, outputs=(rate, *sequence.outputs))
    parameters = [
        Declaration(entry.name, "", point[entry.group][entry.position])
        for entry in sequence.inputs if entry.group != "t"
    ]  # fmt: skip
    declared = ModelDeclarations("random", parameters, [], [Declaration("state", "", 0.0)], {})
    result = simulate(model_text(sequence, declared), {}, start + 1e-3, start)
    values = evaluate_sequence(sequence, point)
    for output, numbers in zip(sequence.outputs[1:], values[1:], strict=True):
        for place, number in enumerate(numbers):
            indices = [str(k + 1) for k in np.unravel_index(place, output.shape)] if output.shape else []
            word = output.name + (f"[{','.join(indices)}]" if indices else "")
            assert result[word][0] == pytest.approx(number, rel=1e-12, abs=1e-12), word


def block(force: str, coordinate: str = "x", **more: float) -> sb.EquationSet:
    body = sb.Body("Block", mass="m")
    rail = sb.Prismatic(
        "rail", "ground", "Block", axis="x", coordinate=coordinate, force=sb.Drive(applied=force)
    )
    model = sb.Model("block", [body, rail], (0, 0, 0), {"m": 2.0, **more}, initial={coordinate: 0.0})
    return sb.form_equations(model)


def test_choices_are_events_and_are_computed_where_they_are_made() -> None:
    eqs = block("if(x < 0.25, 1 + sqrt(0.25 - x), -1/(x + 0.5))")
    text = sb.generate_code(eqs, "energy", "modelica")
    assert re.search(r"if noEvent\(.*\) then sqrt\(", text)  # its value where x is larger is nowhere needed
    assert re.search(r"= .*\(if x < 0\.25 then ", text)  # without noEvent: the tool locates the change
    result = simulate(text, {}, 2.0)
    ours = sb.simulate(eqs, 2.0, times=np.asarray(result.time), rtol=1e-10)
    assert ours["x"].max() > 0.3
    assert np.asarray(result["x"]) == pytest.approx(ours["x"], abs=2e-6)


def test_words_of_the_language_stand_between_quotes() -> None:
    eqs = block("flow - der", coordinate="der", flow=3.0)
    text = sb.generate_code(eqs, "2*der + flow", "modelica")
    assert re.search(r"parameter Real 'flow'(\(.*\))? = 3.0;", text) and "Real 'der'(unit=\"m\"" in text
    assert "der('der') = der_dot;" in text and "output Real '2*der + flow'" in text
    result = simulate(text, {}, 1.0)
    assert result["'2*der + flow'"][0] == pytest.approx(3.0)


def test_names_like_those_of_values() -> None:
    eqs = block("z4 - z7*x", z4=1.0, z7=2.0)
    text = sb.generate_code(eqs, "z4 + x^2", "modelica")
    declared = re.findall(r"(?<!')\bz+\d+\b", text.split("equation")[0])
    assert len(declared) == len(set(declared)) and simulate(text, {}, 1.0)


def test_units_and_values() -> None:
    text = sb.generate_code(equations_of("slider_crank"), [], "modelica")
    assert 'unit="kg.m2"' in text and 'unit="rad/s"' in text and "parameter Real" in text
    assert "parameter" not in sb.generate_code(equations_of("slider_crank"), [], "modelica", parameters={})
    assert text == sb.generate_code(equations_of("slider_crank"), [], "Modelica") and text.isascii()
    assert max(map(len, text.splitlines())) <= 110


def test_motions_that_change_their_equations_are_refused() -> None:
    rail = sb.Prismatic(
        "rail", "ground", "Block", axis="x", coordinate="x", friction=sb.Friction(force="3.0")
    )
    model = sb.Model("block", [sb.Body("Block", mass=1.0), rail], (0, 0, 0))
    with pytest.raises(SymbodyError) as caught:
        sb.generate_code(sb.form_equations(model), [], "modelica")
    assert caught.value.problems[0].code == "modelica.motion"
    assert "joints stick and slip" in caught.value.problems[0].what


def test_constraints_that_follow_from_others_are_refused() -> None:
    with pytest.raises(SymbodyError) as caught:
        sb.generate_code(sb.form_equations(parallelograms_inside()), [], "modelica")
    assert caught.value.problems[0].code == "modelica.constraints"


def test_a_compiled_function_is_no_model() -> None:
    function = sb.compile(equations_of("cart_pole"), "udot")
    with pytest.raises(SymbodyError, match="generate_code"):
        function.source("modelica")


def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(EXAMPLES / "cart_pole" / "cart_pole.toml")
    out = tmp_path / "CartPole.mo"
    assert run(["code", file, "--language", "modelica", "--out", str(out)]) == 0
    assert out.read_text(encoding="utf-8") == sb.generate_code(equations_of("cart_pole"), [], "modelica")


@pytest.mark.parametrize("name", ["real", "Boolean", "string"])
def test_models_named_like_types(name: str) -> None:
    body, rail = sb.Body("Block", mass=1), sb.Prismatic("rail", "ground", "Block", coordinate="x")
    text = sb.generate_code(sb.form_equations(sb.Model(name, [body, rail])), [], "modelica")
    assert simulate(text, {}, 0.1)
