"""A user's script over the whole of symbody, checked by mypy --strict without any Any; it runs, too.

``reveal_type`` lines are compared with the comments behind them by `test_user_script`.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import symbody as sb

Floats = NDArray[np.float64]


def crank_model() -> sb.Model:
    """A crank with a slider on a spring, driven by a torque."""
    crank = sb.Body(
        "Crank",
        mass="m1",
        inertia=(0, 0, "m1*L1^2/12"),
        frames={"O": sb.Frame(at=("-L1/2", 0, 0)), "P": sb.Frame(at=("L1/2", 0, 0))},
    )
    slider = sb.Body("Slider", mass="m2", shapes=[sb.Box(size=(0.1, 0.1, 0.1)), sb.Sphere(radius=0.05)])
    pin = sb.Revolute(
        "pin", "ground", "Crank.O", axis="z", coordinate="theta", torque=sb.Drive(applied="T", damping=0.1)
    )
    rail = sb.Prismatic("rail", "ground", slider, axis="x", coordinate="s")
    rod = sb.Distance("rod", "Crank.P", "Slider", "L2")
    spring = sb.SpringDamper("spring", "ground", "Slider", stiffness="k", free=1)
    push = sb.Force("push", "Slider", vector=["F", 0, 0])
    return sb.Model(
        "crank",
        [crank, slider, pin, rail, rod, spring, push],
        gravity=(0, "-9.81", 0),
        parameters={"m1": 1, "m2": 2, "L1": 0.5, "L2": 1.5, "k": 100},
        inputs=["T", "F"],
        initial={"theta": 0.3, "s": 1.9},
    )


def show_formulas(eqs: sb.EquationSet) -> int:
    """Formulas are SymPy objects."""
    mass = eqs.mass_matrix
    reveal_type(mass)  # SympyMatrix
    reveal_type(mass[0, 0])  # SympyExpr
    reveal_type(mass.shape)  # tuple[int, int]
    reveal_type(mass.T * eqs.forcing)  # SympyMatrix
    reveal_type(eqs.kinetic_energy)  # SympyExpr
    reveal_type(eqs.dynamic_equations()[0].lhs)  # SympyExpr
    reveal_type(eqs.coordinates)  # tuple[SympyExpr, ...]
    reveal_type(eqs.reaction("pin").force)  # SympyMatrix
    reveal_type(eqs.state_names)  # tuple[str, ...]
    reveal_type(eqs.outputs())  # OutputTable
    reveal_type(eqs.outputs().search("energy")[0].unit)  # str
    reveal_type(str(eqs))  # str
    return eqs.degrees_of_freedom


def compute_numbers(eqs: sb.EquationSet, model: sb.Model) -> None:
    """Values, compiled functions, configurations."""
    values = model.values({"L1": 0.4})
    reveal_type(values)  # dict[str, float]
    reveal_type(float(model.bodies[0].mass) if model.bodies[0].mass.is_number else 0.0)  # float
    state = sb.assemble(eqs, {"theta": 0.5})
    reveal_type(state)  # State
    reveal_type(state["s"])  # float | ndarray[tuple[int, ...], dtype[float64]]
    reveal_type(state.moved)  # Mapping[str, float]
    rest = sb.find_equilibrium(eqs)
    reveal_type(rest)  # Equilibrium
    linear = sb.linearize(eqs, rest)
    reveal_type(linear.A)  # ndarray[tuple[Any, ...], dtype[float64]]
    reveal_type(linear.modes[0])  # Mode
    found = sb.redundancy(eqs)
    reveal_type(found.degrees_of_freedom)  # int
    ratios = sb.velocity_ratios(eqs, "theta")
    reveal_type(ratios.tau)  # SympyMatrix
    path = sb.trace_positions(eqs, {"theta": np.linspace(0.0, 1.0, 5)})
    reveal_type(path["s"])  # ndarray[tuple[Any, ...], dtype[float64]]
    f = sb.compile(eqs, "xdot")
    reveal_type(f)  # CompiledFunction
    reveal_type(f.operations)  # int
    reveal_type(sb.generate_code(eqs, ["udot"], language="c"))  # str


def torque(t: float, q: Floats, u: Floats) -> float:
    """A law of control as a function."""
    return float(1.0 - 0.1 * u[0])


def move(eqs: sb.EquationSet) -> sb.Trajectory:
    """Motions with events, tables and laws in Python."""
    turn = sb.Event("sin(theta)", direction=1, action="record", name="turn")
    pulse = sb.Table([0.0, 0.1, 1.0], [0.0, 1.0, 0.0])
    run = sb.simulate(
        eqs, 1.0, {"theta_dot": 1.0}, inputs={"T": torque, "F": pulse}, events=turn,
        times=np.linspace(0.0, 1.0, 21), integrator=sb.Explicit(order=5), constraints=sb.Projection(), rtol=1e-6,
    )  # fmt: skip
    reveal_type(run)  # Trajectory
    reveal_type(run["theta"])  # ndarray[tuple[Any, ...], dtype[float64]]
    reveal_type(run.outputs("s", "energy"))  # dict[str, ndarray[tuple[Any, ...], dtype[float64]]]
    reveal_type(run.outputs())  # OutputTable
    reveal_type(run.status)  # Status
    reveal_type(run.success)  # bool
    reveal_type(run.events[0].t if run.events else 0.0)  # float
    reveal_type(run.energy_drift)  # float
    reveal_type(run.at(0.5))  # Trajectory
    reveal_type(run.notes)  # tuple[str, ...]
    stiff = sb.simulate(
        eqs, 0.1, inputs={"T": "-0.1*theta_dot"}, integrator=sb.Stiff(), constraints=sb.Baumgarte()
    )
    assert run.success and stiff.status is sb.Status.SUCCESS
    several = sb.sweep(eqs, 0.1, {"k": [50.0, 100.0]}, times=[0.0, 0.1])
    reveal_type(several)  # Sweep
    reveal_type(several.trajectory(0))  # Trajectory
    back = sb.inverse_dynamics(eqs, {"theta": "0.3 + t"}, "T", [0.0, 0.1])
    reveal_type(back)  # Trajectory
    stepper = sb.Stepper(eqs, 0.01)
    reveal_type(stepper)  # Stepper
    return run


def draw(run: sb.Trajectory, eqs: sb.EquationSet, folder: Path) -> None:
    """Pages and pictures."""
    page = sb.animate(run, folder / "crank.html")
    reveal_type(page)  # Animation
    ax = sb.plot(run, "theta", "s")
    sb.save_plot(ax, folder / "crank.png")
    run.save(folder / "crank.npz")
    reveal_type(sb.Trajectory.load(folder / "crank.npz"))  # Trajectory
    sb.save_model(crank_model(), folder / "crank.toml")
    reveal_type(sb.load_model(folder / "crank.toml"))  # Model


def live(eqs: sb.EquationSet, run: sb.Trajectory) -> None:
    """What else `animate` returns."""
    reveal_type(sb.animate(eqs, "live.html", sliders=["k"]))  # LivePage
    reveal_type(sb.animate(eqs))  # LiveAnimation
    reveal_type(sb.animate(run, live=True))  # LiveAnimation


def try_wrong() -> tuple[str, ...]:
    """Errors have problems with a code and a cure."""
    try:
        sb.simulate(sb.form_equations(crank_model()), -1.0, {"tehta": 1.0})
    except sb.UsageError as error:
        return tuple(problem.code for problem in error.problems)
    except (sb.AssemblyError, sb.CallError, sb.ModelError, sb.ResourceError, sb.SymbodyError) as error:
        problem: sb.Problem = error.problems[0]
        reveal_type(problem.fix)  # str
        return (problem.code,)
    return ()


def main() -> None:
    """Run all of it."""
    model = crank_model()
    eqs = sb.form_equations(model, sb.VirtualWork())
    assert show_formulas(eqs) == 1
    compute_numbers(eqs, model)
    with tempfile.TemporaryDirectory() as folder:
        draw(move(eqs), eqs, Path(folder))
    assert try_wrong()


if __name__ == "__main__":
    main()
