"""The workflow of the manual's first pages: checklist D-07 .. D-18, on its own examples."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from matplotlib.image import imread
from scipy.integrate import solve_ivp
from sympy.physics.vector import dynamicsymbols

import symbody as sb
from symbody.dynaflexpro import BuildEQs, BuildSimCode, ModelEquations
from symbody.formats.native import from_data
from tests.problems.mechanisms import EXAMPLES, data_of, equations_of, random_values, state_of

T = dynamicsymbols._t
NAMES = ("spring_mass_damper", "projectile", "rr_robot", "spinning_top", "spinning_top_omega", "slider_crank")
PARA_SUBS = {"L": 1, "m": 1, "A": 2, "C": 1, "G": 9.8}
TOP_ICS = [0, 0, 10, 0, np.pi / 2, 0]  # speeds, then angles


def built(name: str, *options: str) -> ModelEquations:
    return BuildEQs(EXAMPLES / name / f"{name}.toml", list(options))


@pytest.mark.parametrize("name", NAMES)
def test_one_call_builds_a_module_with_all_exports(name: str) -> None:
    """D-07 .. D-09: with and without the option, the names of the manual and the equations they hold."""
    Model, simple = built(name), built(name, "DynSimpType", "Simplify")
    assert Model.GetDynEQs() == simple.GetDynEQs() and len(Model.GetDynEQs()) == Model.vP.rows
    assert isinstance(Model.GetDynEQs()[0], sp.Eq)
    assert Model.xM.shape == (Model.vP.rows, Model.vP.rows) and Model.vF.shape == Model.vP.shape
    assert [equation.lhs for equation in Model.GetKinTrans()] == list(Model.vQdot)
    body = Model.equations.model.bodies[0].name
    assert Model.GetFrameMotion("r", f"{body}.CoM", "Ground", "Ground").shape == (3, 1)


@pytest.mark.parametrize("name", NAMES)
def test_form_of_the_dynamics(name: str) -> None:
    """D-10, D-12: xM symmetric and positive definite; the states are speeds, then coordinates."""
    Model, eqs = built(name), equations_of(name)
    assert Model.xM == Model.xM.T
    assert (
        list(Model.vX) == [*Model.vP, *Model.vQ] and eqs.state_names == eqs.speed_names + eqs.coordinate_names
    )
    state = state_of(eqs, random_values(eqs, np.random.default_rng(8)))
    M, F, udot = sb.compile(eqs, ["mass_matrix", "forcing", "udot"])(0.0, state.q, state.u, state.r)
    assert np.linalg.eigvalsh(M).min() > 0
    if not Model.vLambda.rows:
        # A solution by elimination: some eps of the largest force, times few equations.
        assert np.abs(M @ udot - F).max() < 1e-13 * max(1.0, np.abs(F).max())


@pytest.mark.parametrize("name", ["spinning_top", "spinning_top_omega"])
def test_procedure_and_options_of_the_manual(name: str) -> None:
    """D-11, D-13: pXdot in an integrator with the manual's tolerances, relative 1e-7 and absolute 1e-8."""
    Model = built(name)
    pXdot = BuildSimCode(Model, {"Xdot"}, "MapleProc", "Optimize", [sp.Eq(sp.Symbol(k), v) for k, v in PARA_SUBS.items()])  # fmt: skip
    assert callable(pXdot) and pXdot.__name__ == "pXdot"
    solution = solve_ivp(pXdot, (0, 10), TOP_ICS, method="DOP853", rtol=1e-7, atol=1e-8, dense_output=True)
    eta = list(Model.vX).index(dynamicsymbols("eta"))
    assert eta == 4
    # Nine nods of a second each at 1e-7: some 1e-5 rad at most.
    assert np.degrees(solution.sol(10.0)[eta]) == pytest.approx(101.361144, abs=1e-3)


def test_timing() -> None:
    """D-14: ten seconds of the top in far less, and less work in the angular velocity."""
    runs = [sb.simulate(equations_of(name), 10.0) for name in ("spinning_top", "spinning_top_omega")]
    assert all(0 < run.statistics.loop_seconds < 1.0 for run in runs)  # measured: 1 ms
    work = [
        sb.compile(equations_of(name), "xdot").operations for name in ("spinning_top", "spinning_top_omega")
    ]
    assert work[1] < work[0]


def test_plots_of_the_manual(tmp_path: Path) -> None:
    """D-15, D-22, D-32: histories, a path with view limits and equal scaling, a curve in space."""
    flight = sb.simulate(equations_of("projectile"), 1.0)
    ax = sb.plot(flight, ("X", "Y"), title="Path")
    ax.set(adjustable="box", xlim=(0, 10), ylim=(0, 2))
    assert ax.get_aspect() == 1.0 and (ax.get_xlim(), ax.get_ylim()) == ((0, 10), (0, 2))
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_title()) == ("$X$ [m]", "$Y$ [m]", "Path")
    top = sb.plot(sb.simulate(equations_of("spinning_top"), 2.0), ("frame r Top.CoM",))
    x, y, z = top.lines[0].get_data_3d()
    assert x**2 + y**2 + z**2 == pytest.approx(1.0, abs=1e-12)  # on the sphere of radius L
    spring = sb.simulate(equations_of("spring_mass_damper"), 10.0)
    history = sb.plot(spring, "x", "x_dot", labels=["displacement", "speed"], title="Unforced", panels=False)
    legend = history.get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["displacement [m]", "speed [m/s]"]
    assert history.get_xlim() == (0.0, 10.0)
    for k, axes in enumerate((ax, top, history)):
        sb.save_plot(axes, tmp_path / f"{k}.png")
        pixels = imread(tmp_path / f"{k}.png")[..., :3]
        assert np.ptp(pixels, axis=2).max() > 0.5  # coloured lines


def test_products_of_sines_are_combined() -> None:
    """D-16: what map(combine, ...) makes of the robot's tip, by itself."""
    b1, b2 = dynamicsymbols("beta_1 beta_2")
    for entry in built("rr_robot").GetFrameMotion("r", "P", "Ground", "Ground")[:2]:
        assert entry.atoms(sp.sin, sp.cos) <= {f(a) for f in (sp.sin, sp.cos) for a in (b1, b1 + b2)}
        assert sp.expand(sp.expand_trig(entry) - sp.expand_trig(sp.simplify(entry))) == 0


def test_the_inertia_may_be_called_I() -> None:
    """D-17: a parameter I is a moment of inertia, not the imaginary unit."""
    data = data_of("projectile")
    data["parameters"]["I"] = data["parameters"].pop("Inertia")
    data["body"][0]["inertia"] = ["0", "0", "I"]
    eqs = sb.form_equations(from_data(data))
    assert eqs.mass_matrix[2, 2] == sp.Symbol("I") and not eqs.mass_matrix.has(sp.I)
    assert sb.simulate(eqs, 1.0)["theta"][-1] == pytest.approx(10.0, abs=1e-12)


@pytest.mark.parametrize("joint", ["free", "none"])
def test_a_body_alone_has_six_freedoms(joint: str) -> None:
    """D-18."""
    data = data_of("projectile/projectile_free")
    data.pop("initial")
    if joint == "none":
        data.pop("joint")
    Model = BuildEQs(from_data(data))
    assert Model.equations.degrees_of_freedom == len(Model.vQ) == len(Model.vP) == 6
