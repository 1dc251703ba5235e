"""Results as lines of plain text, and elements as the calls that make them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import symbody as sb
from tests.display.test_views import cells, oscillator, shown

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").rglob("*.toml"))
NAMES: dict[str, Any] = {name: getattr(sb, name) for name in sb.__all__}


def test_states_are_one_line_with_units() -> None:
    eqs = sb.form_equations(oscillator())
    assert str(sb.assemble(eqs, {"x": 1 / 3})) == "State at t = 0 s: x = 0.333333 m; x_dot = 0 m/s"
    assert str(sb.find_equilibrium(eqs)) == "Equilibrium, stable: x = 0 m"


def test_linear_equations_have_a_table_of_their_modes() -> None:
    linear = sb.find_equilibrium(sb.form_equations(oscillator())).linearization
    head, columns, row = str(linear).splitlines()
    assert (
        head
        == repr(linear)
        == ("Linearization of 'oscillator' at t = 0 s: stable, 2 states, 1 input, 0 outputs")
    )
    assert columns.split("  ")[0] == "eigenvalue [1/s]" and columns.endswith("shape")
    real, sign, imaginary, *_ = row.split()
    assert sign == "+-" and imaginary.endswith("i")
    assert complex(float(real), float(imaginary[:-1])) == pytest.approx(linear.modes[0].eigenvalue, rel=1e-4)
    assert str(linear.modes) == f"{columns}\n{row}"
    assert str(linear.modes[0]).startswith("Mode of eigenvalue ") and "damping ratio" in str(linear.modes[0])
    assert isinstance(linear.modes, tuple) and linear.modes[:1] == (linear.modes[0],)
    assert "A = \\begin{bmatrix}" in (linear._repr_latex_() or "")


def test_bodies_and_joints_are_one_line() -> None:
    model = oscillator()
    (slider,) = model.joints
    assert str(model.bodies[0]) == "Body Mass: mass m"
    assert repr(model.bodies[0]) == "Body('Mass', mass='m')"
    assert str(slider) == "Prismatic slider: ground -> Mass, x"
    body = sb.Body("B", inertia=(1, 1, "I"), products=(0, 1, 0), frames={"tip": sb.Frame(at=("L", 0, 0))})
    assert str(body) == "Body B: mass 0, inertia (1, 1, I), products (0, 1, 0), frames tip"


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_elements_are_shown_as_the_calls_that_make_them(path: Path) -> None:
    for element in sb.load_model(path).elements:
        assert eval(repr(element), NAMES) == element


def test_elements_show_what_was_given_with_units() -> None:
    (slider,) = oscillator().joints
    rows = cells(shown(slider))
    assert ["force applied", "F", "N"] in rows and ["force damping", "d", "N·s/m"] in rows
    assert not any("free" in row[0] for row in rows)
    body = sb.Body("<b>", mass="2*m", frames={"tip": sb.Frame(at=(0, "L", 0), rotate=[("z", "pi/2")])})
    assert "<b>" in "".join(shown(body).itertext())
    assert ["frames tip at", "(0, L, 0)", "m"] in cells(shown(body))


def test_all_forms_for_notebooks() -> None:
    eqs = sb.form_equations(oscillator())
    forms = eqs._repr_mimebundle_()
    assert forms["text/plain"] == eqs.text()
    assert sorted(forms) == ["text/html", "text/latex", "text/plain"]
    assert sorted(sb.assemble(eqs)._repr_mimebundle_()) == ["text/html", "text/plain"]
