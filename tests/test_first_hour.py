"""What new users stumbled over: each is right at the first try now, or says what to write."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import sympy

import symbody as sb
from symbody.equations.equation_set import EquationSet
from symbody.equations.outputs.output_roots import frame_cure


@pytest.fixture(scope="module")
def oscillator() -> EquationSet:
    mass = sb.Body("Mass", "m", frames={"tip": sb.Frame(at=(1, 0, 0))})
    spring = sb.Drive(applied="F", stiffness="k")
    slider = sb.Prismatic("s", "ground", mass, axis="x", coordinate="x", force=spring)
    return sb.form_equations(sb.Model("oscillator", [slider], inputs=["F"], parameters={"m": 1, "k": 4}))


def cure(call: Callable[[], object]) -> str:
    with pytest.raises(sb.SymbodyError) as caught:
        call()
    return caught.value.problems[0].fix


@pytest.mark.parametrize(
    ("name", "fix"),
    [
        ("position tip", "did you mean 'frame r Mass.tip'?"),
        ("velocity Mass", "did you mean 'frame v Mass'?"),
        ("angular velocity Mass", "did you mean 'frame w Mass'?"),
        ("Mass.tip", "did you mean 'frame r Mass.tip'?"),
        ("acceleration tipp", "write 'frame vdot END' with a body or frame for END: known names: Mass, "),
        ("reacton s", "did you mean 'reaction s'"),
    ],
)
def test_outputs_of_frames_in_everyday_words(oscillator: EquationSet, name: str, fix: str) -> None:
    assert cure(lambda: sb.compile(oscillator, name)).startswith(fix)


def test_events_take_sympy() -> None:
    x, rate = sympy.symbols("x x_dot")
    event = sb.Event(x**2 - 1, action={rate: -rate / 2})
    assert event == sb.Event("x**2 - 1", action={"x_dot": "-x_dot/2"})


def test_a_frame_of_two_bodies_is_not_guessed() -> None:
    assert frame_cure("position tip", ["A.tip", "B.tip"]).startswith("write 'frame r END'")
    assert frame_cure("energy", ["A.tip"]) == ""


def test_one_name_is_a_list_of_one(oscillator: EquationSet, tmp_path: Path) -> None:
    run = sb.simulate(oscillator, 0.1, {"x": 1})
    page = sb.animate(run, tmp_path / "a.html", traces="Mass.tip", curves="x")
    assert page is not None and (tmp_path / "a.html").exists()
    assert sb.compile(oscillator, "udot", free="m")(0.0, [1.0], [0.0], [0.0], [2.0])[0] == -2.0
    assert len(sb.plot(run, "x", "x_dot", "energy", "work", "x", "x_dot", panels=True).figure.axes) > 1
    assert sb.plot(run, "x", labels="way [m]").get_ylabel().startswith("way")


def test_an_undamped_mode_has_no_rounding_in_it() -> None:
    links = [
        sb.Body(
            name, 1, (0, 0, 0.1), frames={"base": sb.Frame(at=(0, 0.5, 0)), "tip": sb.Frame(at=(0, -0.5, 0))}
        )
        for name in ("A", "B")
    ]
    joints = [sb.Revolute("a", "ground", "A.base"), sb.Revolute("b", "A.tip", "B.base")]
    linear = sb.linearize(sb.form_equations(sb.Model("pendulum", [*links, *joints], (0, -9.81, 0))))
    assert linear.verdict == "marginal"
    for mode in linear.modes:
        assert mode.damping_ratio == 0.0
        assert str(mode).startswith("Mode of eigenvalue 0 ") and "eigenvalue 0 " in mode._repr_html_()
    assert "e-1" not in str(linear.modes)


def test_notes_of_a_motion_are_printed_with_it(oscillator: EquationSet) -> None:
    run = sb.simulate(oscillator, 0.1, {"x": 1})
    assert str(run).splitlines()[1:] == [f"  note: {note}" for note in run.notes] != []


def test_missing_parameters_say_how_in_a_file_and_in_python(oscillator: EquationSet) -> None:
    fix = cure(lambda: sb.Model("m", [sb.Prismatic("s", "ground", sb.Body("B", "m"))]))
    assert "[parameters] m = .. in a file" in fix and 'parameters={"m": ..} in Python' in fix
    model = sb.Model("m", [sb.Prismatic("s", "ground", sb.Body("B", "m"))], parameters={"m": None})
    eqs = sb.form_equations(model)
    assert cure(lambda: sb.simulate(eqs, 1.0)) == "give parameters={'m': ..}"
    assert "free=[..]" in cure(lambda: sb.compile(eqs, "udot"))


def test_a_bode_diagram_is_where_plot_says(oscillator: EquationSet) -> None:
    assert "bode_plot(run.to_control())" in cure(lambda: sb.plot(sb.linearize(oscillator)))  # type: ignore[arg-type]


def test_a_drive_as_text_says_which_table(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(
        'name = "m"\ninputs = ["T"]\n[[body]]\nname = "B"\nmass = 1\ninertia = [1, 1, 1]\n'
        '[[joint]]\nname = "a"\ntype = "revolute"\nbetween = ["ground", "B"]\ntorque = "T"\n'
    )
    assert cure(lambda: sb.load_model(path)) == 'write torque = { applied = "T" }'


def test_degrees_in_formulas_of_a_model() -> None:
    arm = sb.Body("Arm", 1, (0, 0, 1))
    spring = sb.Drive(applied="-k*(phi - 30 deg)")
    pin = sb.Revolute("pin", "ground", arm, coordinate="phi", torque=spring)
    model = sb.Model("arm", [pin], parameters={"k": 2.0}, initial={"phi": "20 deg + 10 deg"})
    run = sb.simulate(sb.form_equations(model), 1.0)
    assert run["phi"] == pytest.approx(0.5235987755982988)
    led = sb.Revolute("pin", "ground", arm, coordinate="phi", motion="30 deg + 0.5*t")
    assert sb.simulate(sb.form_equations(sb.Model("arm", [led])), 1.0)["phi"][-1] == pytest.approx(
        1.0235987756
    )
    slider = sb.Prismatic("s", "ground", sb.Body("B", 1), coordinate="x", motion="2*30 deg")
    assert cure(lambda: sb.Model("slide", [slider])) == "write the value in SI units"
