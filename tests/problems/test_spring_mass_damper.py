"""Spring-mass-damper: checklist D-20 .. D-23, from file and from script, under any names.

Reference values: closed form of ``m x'' + d x' + k x = F`` (Rao, Mechanical Vibrations, sections 2.6, 3.4).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from sympy.physics.vector import dynamicsymbols

import symbody as sb

FILE = Path(__file__).parents[2] / "examples" / "spring_mass_damper" / "spring_mass_damper.toml"
T = dynamicsymbols._t
# Names that languages reserve or SymPy gives a meaning, one for each symbol of the file.
STRANGE = {"m": "lambda", "d": "I", "k": "E", "F": "S", "x": "N"}


def script(names: Mapping[str, str] | None = None) -> sb.Model:
    n = {name: name for name in "mdkFx"} | dict(names or {})
    mass = sb.Body("Mass", mass=n["m"])
    drive = sb.Drive(applied=n["F"], stiffness=n["k"], damping=n["d"])
    slider = sb.Prismatic("slider", "ground", mass, axis="x", coordinate=n["x"], force=drive)
    return sb.Model(
        "spring-mass-damper",
        [mass, slider],
        parameters={n["m"]: 1, n["d"]: 0.5, n["k"]: 1},
        inputs=[n["F"]],
        initial={n["x"]: 1},
    )


def renamed_file(names: Mapping[str, str], folder: Path) -> sb.Model:
    text = FILE.read_text(encoding="utf-8")
    path = folder / "renamed.toml"
    keys = "|".join(names)
    # Whole words that are names: keys of parameters and initial, and text in quotes that is one word.
    text = re.sub(rf'(?<!axis = )"({keys})"', lambda match: f'"{names[match.group(1)]}"', text)
    text = re.sub(
        rf"(?m)(^|[{{,]\s*)({keys})(?=\s*=)", lambda match: match.group(1) + names[match.group(2)], text
    )
    path.write_text(text, encoding="utf-8")
    return sb.load_model(path)


@pytest.fixture(params=["file", "script", "renamed file", "renamed script"])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[sb.EquationSet, dict[str, str]]:
    plain = {name: name for name in "mdkFx"}
    models = {
        "file": lambda: (sb.load_model(FILE), plain),
        "script": lambda: (script(), plain),
        "renamed file": lambda: (renamed_file(STRANGE, tmp_path), STRANGE),
        "renamed script": lambda: (script(STRANGE), STRANGE),
    }
    model, names = models[request.param]()
    return sb.form_equations(model), names


def test_one_linear_equation_of_second_order(case: tuple[sb.EquationSet, dict[str, str]]) -> None:
    eqs, n = case
    x = dynamicsymbols(n["x"])
    m, d, k = sp.symbols([n["m"], n["d"], n["k"]])
    (equation,) = eqs.dynamic_equations()
    residual = equation.lhs - equation.rhs
    force = dynamicsymbols(n["F"])
    assert sp.expand(residual - (m * x.diff(T, 2) + d * x.diff(T) + k * x - force)) == 0
    assert eqs.mass_matrix == sp.Matrix([[m]])
    assert eqs.coordinates == (x,) and eqs.speeds == (x.diff(T),)
    assert eqs.states == (x.diff(T), x)
    assert eqs.kinetic_energy == m * x.diff(T) ** 2 / 2
    assert eqs.potential_energy == k * x**2 / 2
    assert eqs.degrees_of_freedom == 1


def test_unforced_motion(case: tuple[sb.EquationSet, dict[str, str]]) -> None:
    eqs, n = case
    run = sb.simulate(eqs, 10.0, times=[0, 1, 5, 10], rtol=1e-11, atol=1e-13)
    assert run.success
    # The global error of rtol 1e-11 over ten damped seconds stays far below the 8 printed digits.
    expected = [1.0, 0.60705485, -0.03655079, -0.08477596]
    assert run[n["x"]] == pytest.approx(expected, abs=5e-9)
    a = np.sqrt(15) / 4
    t = np.array([0, 1, 5, 10])
    closed = np.exp(-t / 4) * (np.cos(a * t) + np.sin(a * t) / np.sqrt(15))
    assert run[n["x"]] == pytest.approx(closed, abs=1e-10)


def test_closed_form_by_dsolve_from_the_equations() -> None:
    eqs = sb.form_equations(sb.load_model(FILE))
    x, force = dynamicsymbols("x F")
    values = {sp.Symbol("m"): 1, sp.Symbol("d"): sp.Rational(1, 2), sp.Symbol("k"): 1}
    omega = sp.Symbol("omega", positive=True)
    for drive, expected in (
        (sp.Integer(0), {1: 0.60705485, 5: -0.03655079, 10: -0.08477596}),
        (sp.sin(omega * T), {1: 0.740559936, 5: -0.676976733, 10: 1.423815171}),
    ):
        equation = eqs.dynamic_equations()[0].subs(values).subs(force, drive)
        solution = sp.dsolve(equation, x, ics={x.subs(T, 0): 1, x.diff(T).subs(T, 0): 0}).rhs
        for time, value in expected.items():
            found = complex(solution.subs(omega, 1).subs(T, time).evalf(20))
            assert found.real == pytest.approx(value, abs=5e-9)
            assert abs(found.imag) < 1e-12


@pytest.mark.parametrize(
    ("omega", "expected"),
    [
        (1, [0.740559936, -0.676976733, 1.423815171]),
        (10, [0.680040132, -0.063982735, -0.082332817]),
    ],
)
def test_forced_responses(
    case: tuple[sb.EquationSet, dict[str, str]], omega: int, expected: list[float]
) -> None:
    eqs, n = case
    run = sb.simulate(
        eqs, 10.0, inputs={n["F"]: f"sin({omega}*t)"}, times=[0, 1, 5, 10], rtol=1e-11, atol=1e-13
    )
    assert run[n["x"]][1:] == pytest.approx(expected, abs=5e-9)


def test_fast_force_adds_only_a_ripple() -> None:
    eqs = sb.form_equations(sb.load_model(FILE))
    times = np.linspace(0, 10, 2001)
    free = sb.simulate(eqs, 10.0, times=times)
    forced = sb.simulate(eqs, 10.0, inputs={"F": "sin(10*t)"}, times=times)
    assert np.abs(forced["x"] - free["x"]).max() == pytest.approx(0.080, abs=1e-3)


def test_energy_balance_along_the_motion(case: tuple[sb.EquationSet, dict[str, str]]) -> None:
    eqs, n = case
    run = sb.simulate(eqs, 10.0, inputs={n["F"]: "sin(2*t)"}, rtol=1e-10, atol=1e-12)
    # Drift of T + V - W is the integration error alone, accumulated over about a hundred steps.
    assert run.energy_drift < 1e-8
    assert run["effort slider"][0] == pytest.approx(-1.0, abs=1e-15)


def test_separate_parameters_override_the_file() -> None:
    eqs = sb.form_equations(sb.load_model(FILE))
    run = sb.simulate(eqs, 10.0, parameters={"d": 2}, times=[0, 1, 10], rtol=1e-11, atol=1e-13)
    t = run.t
    assert run["x"] == pytest.approx((1 + t) * np.exp(-t), abs=1e-10)  # critical damping


def test_spring_damper_and_force_may_stand_apart() -> None:
    """D-05: three connections between the same bodies in place of one drive that holds all of them."""
    mass = sb.Body("Mass", mass="m")
    parts = [
        mass, sb.Prismatic("slider", "ground", mass, axis="x", coordinate="x"),
        sb.SpringDamper("spring", "ground.post", mass, stiffness="k", free=2),
        sb.SpringDamper("damper", "ground.post", mass, damping="d"),
        sb.Force("push", mass, ("F", 0, 0)),
    ]  # fmt: skip
    post = {"post": sb.Frame(at=(-2, 0, 0))}
    model = sb.Model("apart", parts, parameters={"m": 1, "d": 0.5, "k": 1}, inputs=["F"], ground=post)
    apart, together = (sb.compile(sb.form_equations(each), "udot") for each in (model, script()))
    for x, v, force in np.random.default_rng(3).uniform(-1.5, 1.5, (20, 3)):
        # The length x + 2 is a root of a square: a few more roundings of numbers up to 4.
        assert apart(0.0, [x], [v], [force]) == pytest.approx(together(0.0, [x], [v], [force]), abs=1e-14)
    run = sb.simulate(sb.form_equations(model), 10.0, {"x": 1}, times=[1, 5, 10], rtol=1e-11, atol=1e-13)
    assert run["x"] == pytest.approx([0.60705485, -0.03655079, -0.08477596], abs=5e-9)
