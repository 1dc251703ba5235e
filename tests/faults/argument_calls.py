"""Calls of every public function with arguments that fit, and values that fit nothing, to put in their place."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import symbody as sb
from symbody.model.model import KINDS
from symbody.model.registry import element_types
from symbody.model.shapes.shape import shape_types
from tests.formulations import FORMULATIONS

ROOT = Path(__file__).parents[2]

# What every constructor of an element may need.
ELEMENT: dict[str, Any] = {
    "name": "n", "start": "ground", "end": "B", "radius": 1, "on": "B", "vector": (1, 0, 0),
    "coupled": ["a", "b"], "ratio": 2, "radii": (1, 2), "curve": ("s", "0", "0"), "parameter": "s",
    "equations": "x - 1", "x": (0, 1), "y": (0, 1), "value": 1, "axes": ("x", "y"), "rotation": (),
    "translation": (), "pitch": 1, "step": 0.1, "expression": "x", "t": [0, 1], "values": [0, 1],
    "law": "uniform", "first": 0, "second": 1, "size": (1, 1, 1), "length": 1, "path": "part.stl",
}  # fmt: skip
ELEMENTS = [each.__name__ for kind in KINDS for each in element_types(kind).values()]
CONSTRUCTORS = (
    *ELEMENTS,
    *(each.__name__ for each in shape_types().values()),
    *"Backlash Baumgarte Curve Drive Event Explicit FixedStep Frame Friction Limits Model NormalForce".split(),
    *"Partition Projection Samples".split(),
    *"FmuInput GeneralizedAlpha Include Initial MoreauJean Stiff Table Trees".split(),
    *(type(each).__name__ for each in FORMULATIONS if inspect.signature(type(each)).parameters),
)
# Classes that take nothing, are made by functions, or are faults; and functions whose words are variadic.
NOT_CALLED = {
    "GGL", "CompiledFunction", "EquationSet", "Equilibrium",
    *(type(each).__name__ for each in FORMULATIONS if not inspect.signature(type(each)).parameters),
    "IndexOneSolution", "IndexReduction", "Linearization", "Mode", "PositionSolutions", "Positions",
    "Redundancy", "Separation", "SingularConfiguration", "State", "Status", "Sweep", "Trajectory",
    "VelocityRatios", "Problem", "Animation", "Fmu", "FmuVariable",
}  # fmt: skip


class Call(NamedTuple):
    """A function with arguments that fit."""

    function: Callable[..., object]
    arguments: Mapping[str, Any]


def model() -> sb.Model:
    mass = sb.Body("Mass", mass="m")
    spring = sb.Drive(applied="F", stiffness="k", damping="d")
    slider = sb.Prismatic("slider", "ground", mass, axis="x", coordinate="x", force=spring)
    values = {"m": 1.0, "d": 0.5, "k": 1.0}
    return sb.Model("p", [mass, slider], inputs=["F"], parameters=values, initial={"x": 1.0})


def calls(folder: Path) -> dict[str, Call]:
    """Every public function and the methods of what they return."""
    found: dict[str, Call] = {}

    def put(label: str, function: Callable[..., object], /, **arguments: Any) -> None:
        found[label] = Call(function, arguments)

    for name in CONSTRUCTORS:
        kind = getattr(sb, name)
        parameters = inspect.signature(kind).parameters.values()
        given = {p.name: ELEMENT.get(p.name) if p.default is p.empty else p.default for p in parameters}
        if name == "Differential":
            given["coupled"] = ["a", "b", "c"]
        if name == "Lookup":
            given["points"] = [[0, 0], [1, 1]]
        if name == "FmuInput":
            given |= {"path": "controller.fmu", "output": "F", "step": 0.1}
        if name == "Include":
            given |= {"part": model(), "prefix": "P"}
        put(name, kind, **given)
    pendulum = sb.load_model(ROOT / "examples" / "slider_crank" / "slider_crank.toml")
    eqs, loop = sb.form_equations(model()), sb.form_equations(pendulum)
    _put_files(put, folder)
    _put_functions(put, eqs, loop)
    _put_motions(put, eqs)
    _put_results(put, eqs, loop, folder)
    return found


def _put_files(put: Callable[..., None], folder: Path) -> None:
    sb.save_model(model(), folder / "m.toml")
    put("load_model", sb.load_model, path=folder / "m.toml")
    put("save_model", sb.save_model, model=model(), path=folder / "m2.toml")
    put("load_urdf", sb.load_urdf, path=folder / "no.urdf", floating_base=False, symbolic=(),
        gravity=(0, 0, -9.81), snap_angles=0, loops=None)  # fmt: skip
    put("save_urdf", sb.save_urdf, model=model(), path=folder / "o.urdf", parameters={})


def _put_functions(put: Callable[..., None], eqs: sb.EquationSet, loop: sb.EquationSet) -> None:
    none = {"parameters": None, "guess": None}
    put("form_equations", sb.form_equations, model=model(), formulation=None, tree=None,
        dependent_speeds=None, time_limit=None)  # fmt: skip
    put("reduce_index", sb.reduce_index, equations=eqs, unknowns=None)
    put("separate_derivatives", sb.separate_derivatives, equations=[], derivatives=[])
    put("compile", sb.compile, eqs=eqs, outputs="udot", parameters=None, free=(), quick=True, lanes=None,
        time_limit=None)  # fmt: skip
    put("generate_code", sb.generate_code, eqs=eqs, outputs="udot", language="c", parameters=None)
    put("assemble", sb.assemble, eqs=loop, fixed=None, inputs=None, t=0.0, ranges=None, **none)
    put("redundancy", sb.redundancy, eqs=loop, **none)
    put("solve_positions", sb.solve_positions, constraints=loop, dependent=["s", "beta"], seconds=0.01)
    put("find_equilibrium", sb.find_equilibrium, eqs=eqs, inputs=None, unknowns=(), fixed=None, t=0.0, **none)
    put("linearize", sb.linearize, eqs=eqs, at=None, parameters=None, inputs=None, outputs=(),
        independent=None, cyclic=(), t=0.0)  # fmt: skip
    put("singular_configurations", sb.singular_configurations, eqs=loop, independent="theta",
        over={"theta": (0.1, 0.2)}, **none)  # fmt: skip
    put("trace_positions", sb.trace_positions, eqs=loop, over={"theta": [0, 0.1]}, t=0.0, **none)
    put("velocity_ratios", sb.velocity_ratios, eqs=loop, independent="theta", at=None, parameters=None)
    put("solve_index_1", sb.solve_index_1, equations=eqs, derivatives=(), reactions=(), parameters=None)


def _put_motions(put: Callable[..., None], eqs: sb.EquationSet) -> None:
    usual: dict[str, Any] = {"eqs": eqs, "t_end": 0.1, "initial": None, "guess": None, "inputs": None,
             "integrator": None, "constraints": None, "events": (), "rtol": 1e-8, "atol": 1e-10,
             "max_steps": 100}  # fmt: skip
    put("simulate", sb.simulate, parameters=None, times=None, progress=None, **usual)
    put("sweep", sb.sweep, parameters={"k": [1, 2]}, times=[0.1], combine="product", samples=None, seed=0,
        executor=None, threads=1, part=None, lanes=None, store=None, key=None, progress=False, patience=1.0,
        **usual)  # fmt: skip
    put("Stepper", sb.Stepper, eqs=eqs, dt=0.01, parameters=None, initial=None, guess=None, inputs=None,
        integrator=None, constraints=None, events=(), rtol=1e-8, atol=1e-10)  # fmt: skip
    put("LaneStepper", sb.LaneStepper, eqs=eqs, dt=0.01, lanes=2, parameters=None, initial=None, guess=None,
        inputs=None, integrator=None, constraints=None, events=(), rtol=1e-8, atol=1e-10)  # fmt: skip
    put("generate_simulation", sb.generate_simulation, eqs=eqs, t_end=0.1, language="c")
    put("inverse_dynamics", sb.inverse_dynamics, eqs=eqs, motion={"x": "sin(t)"}, unknowns="F",
        times=[0, 0.1], parameters=None, inputs=None, guess=None)  # fmt: skip


def _animated(usual: Path, **arguments: Any) -> object:
    """A page, never a browser."""
    path = usual if arguments["path"] is None else arguments["path"]
    return sb.animate(arguments.pop("run"), **{**arguments, "path": path})


def _put_results(put: Callable[..., None], eqs: sb.EquationSet, loop: sb.EquationSet, folder: Path) -> None:
    run = sb.simulate(eqs, 0.2)
    run.save(folder / "r.npz")
    motions = sb.sweep(eqs, 0.1, {"k": [1.0, 2.0]}, times=[0.1], threads=1)
    ax = sb.plot(run, "x")
    put("plot", lambda expression, **k: sb.plot(k.pop("run"), expression, **k), run=run, expression="x",
        ax=ax, x="t", title=None, labels=None, equal=None, panels=False)  # fmt: skip
    put("save_plot", sb.save_plot, ax=ax, path=folder / "p.png")
    put("animate", partial(_animated, folder / "a.html"), run=run, path=folder / "b.html", curves=None,
        vectors=None, traces=(), times=None, title=None, model=None, view="auto", theme="auto", speed=1.0,
        live=False, sliders=())  # fmt: skip
    put("save_animation", sb.save_animation, run=run, path=folder / "a.png", times=0.1, view=None,
        size=(64, 64), fps=10.0, speed=1.0, traces=(), labels=False, vectors=(), frames=False, dark=False,
        ghosts=0.3, title=None, progress=None)  # fmt: skip
    put("save_report", sb.save_report, eqs=eqs, path=folder / "r.html", run=None, sections=["parameters"],
        parameters=None, title=None)  # fmt: skip
    put("without_sampling", sb.without_sampling, model=eqs.model)
    put("save_fmu", sb.save_fmu, eqs=eqs, path=folder / "a.fmu", version="3.0", outputs=(), initial=None,
        parameters=None, fixed=(), events=(), constraints=None, integrator=None, platforms=(),
        sources=True)  # fmt: skip
    put("run.outputs", lambda name: run.outputs(name, "energy"), name="x")
    put("run.of_model", run.of_model, model=None)
    one, some = sb.compile(eqs, "udot"), sb.compile(eqs, ["udot", "energy"], free=["k"])
    point: dict[str, Any] = {"t": 0.0, "q": [1.0], "u": [0.0], "r": [0.0]}
    put("f", one, p=(), out=None, threads=1, **point)
    put("f of a batch", one, p=(), out=None, threads=1, **{**point, "q": [[1.0], [2.0]]})
    put("f of parameters", some, p=[1.0], out=None, threads=1, **point)
    put("f.of_state", one.of_state, t=0.0, x=[0, 1.0], r=[0.0], p=())
    put("f.bind", some.bind, p=[1.0])
    put("f.constants", some.constants, p=[1.0])
    put("f bound", some.bind([1.0]), **point)
    put("f.source", one.source, language="c")
    put("run[]", run.__getitem__, name="x")
    put("run.at", run.at, t=0.1)
    put("run.columns", lambda name: run.columns(name), name="x")
    put("run.reaction", run.reaction, joint="slider")
    put("run.save", lambda path, name: run.save(path, name), path=folder / "r2.npz", name="energy")
    put("run.load", sb.Trajectory.load, path=folder / "r.npz")
    put("run.to_csv", lambda path, name: run.to_csv(path, name), path=folder / "r.csv", name="x")
    put("sweep[]", motions.__getitem__, name="x")
    put("sweep.trajectory", motions.trajectory, case=0)
    state = sb.assemble(loop)
    put("state[]", state.__getitem__, name="s")
    put("eqs.frame_motion", eqs.frame_motion, kind="r", end="Mass", reference="ground", resolved_in="ground")
    put("eqs.operation_count", partial(_counted, eqs), output="udot")
    put("eqs.reaction", eqs.reaction, joint="slider", on="", at="", frame="")
    put("model.body", model().body, name="Mass")
    put("model.joint", model().joint, name="slider")
    put("linear.recover", sb.linearize(eqs).recover, deviations={"x": 1.0})
    ratios = sb.velocity_ratios(loop, "theta")
    put("ratios.at", ratios.at, state=state)
    put("ratios.speeds", ratios.speeds, state=state, rates={"theta_dot": 1.0})
    put("ratios.accelerations", ratios.accelerations, state=state, rates={"theta_dot": 1.0},
        accelerations={"theta_ddot": 0.0})  # fmt: skip
    put("ratios.generalized_forces", ratios.generalized_forces, state=state)
    put("ratios.holding", ratios.holding, unknown="F")


def _counted(eqs: sb.EquationSet, output: str) -> int:
    return eqs.operation_count(output)


class Strange:
    """What nothing was made for."""

    def __init__(self, *given: object) -> None:
        """Take anything."""


def strange_values() -> Iterator[object]:
    """Values of every kind that somebody might give by mistake, new ones each time."""
    yield from (None, True, 0, -1, 3, 1.5, float("nan"), float("inf"), 1e300, 10**400, 1j)
    yield from ("", "x", "(", "no such name", "\x00", b"b")
    yield from ([], [1], [1, 2, 3], ["a", 1], [[1, 2], [3]], [None], (), (1, 2), {1, 2}, range(3), iter([]))
    yield from ({}, {"a": 1}, {1: 2}, {"x": object()}, {"x": [1, "a"]}, {"x": None}, {"x": {}})
    yield from ({"k": float("nan")}, {"x": "("}, {None: 1})
    yield from (np.array([1.0, 2.0]), np.array("a"), np.array([object()]), np.zeros((2, 2)), np.float64(2))
    yield from (np.zeros(0), np.int64(3), np.zeros(3, dtype=bool), np.array([1j]))
    yield from (object(), Strange, Strange(), lambda *given: 0, sb.Body("Q", mass=1), model())
