"""Every analysis without a result refuses with the reason, the element and a cure."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

import symbody as sb
from tests.analysis.test_assembly import slider_crank
from tests.simulation.test_inverse_dynamics import FOUR_BAR
from tests.tiers import cases


@cache
def crank() -> sb.EquationSet:
    return sb.form_equations(slider_crank())


@cache
def far() -> sb.EquationSet:
    """The slider's line is 5 m off, out of reach of 1 m + 3 m; the joint cut is C."""
    elements = [one for one in slider_crank().elements if one.name != "D"]
    line = sb.Prismatic("D", "ground.line", "Slider", coordinate="s", force=sb.Drive(applied="F"))
    return sb.form_equations(
        sb.Model("far", [*elements, line], parameters={"L1": 1, "L2": 3}, inputs=["F"],
                 ground={"line": sb.Frame(at=(0, 5, 0))})
    )  # fmt: skip


def falling() -> sb.EquationSet:
    slide = sb.Prismatic("slide", "ground", sb.Body("B", mass=2), axis="x", coordinate="x")
    return sb.form_equations(sb.Model("falling", [slide], gravity=(-9.81, 0, 0)))


def against_the_loop() -> object:
    """Crank and rocker, closed at first, at rates that the coupler does not allow."""
    start = sb.assemble(FOUR_BAR, {"theta": 0.4}).q["phi"]
    motion = {"theta": "0.4 + 0.1*t", "phi": f"{start} + 0.1*t"}
    return sb.inverse_dynamics(FOUR_BAR, motion, ["T", "U"], [0.0, 1.0], guess={"theta": 0.4})


Question = Callable[[], object]
# An unreachable closure: all name the joint that stays open, and by how much.
OPEN: dict[str, Question] = {
    "assemble": lambda: sb.assemble(far()),
    "trace_positions": lambda: sb.trace_positions(far(), {"theta": [0, 1]}),
    "velocity_ratios": lambda: sb.velocity_ratios(far(), "theta").at({"theta": 0.5}),
    "velocity_ratios of its own choice": lambda: sb.velocity_ratios(far()),
    "singular_configurations": lambda: sb.singular_configurations(far(), "theta", {"theta": (0, 1)}),
    "find_equilibrium": lambda: sb.find_equilibrium(far()),
    "linearize": lambda: sb.linearize(far()),
    "inverse_dynamics": lambda: sb.inverse_dynamics(far(), {"theta": "t"}, "F", [0.0, 1.0]),
    "simulate": lambda: sb.simulate(far(), 1.0),
    "assemble in ranges": lambda: sb.assemble(far(), ranges={"s": (0, 4)}),
}


@pytest.mark.parametrize(
    "analysis",
    cases(
        OPEN, fast=["trace_positions", "velocity_ratios", "find_equilibrium", "inverse_dynamics", "simulate"]
    ),
)
def test_a_closure_out_of_reach(analysis: str) -> None:
    with pytest.raises(sb.AssemblyError) as caught:
        OPEN[analysis]()
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("assembly.open", "joint C")
    assert "joint C cannot be closed: a gap of" in problem.what and "lengths and frames" in problem.fix


# Code, the element or the coordinates it tells of, and a word of the cure.
Refusal = tuple[str, str, str, Question]
OTHERS: dict[str, Refusal] = {
    # a wrong number of independent coordinates
    "ratios by two": ("kinematics.independent_count", "1 degree of freedom", "name 1 of theta_dot",
                      lambda: sb.velocity_ratios(crank(), ["theta", "s"])),
    "ratios by none": ("kinematics.independent_count", "0 speeds", "name 1 of theta_dot",
                       lambda: sb.velocity_ratios(crank(), [])),
    "singular places by two": ("kinematics.independent_count", "2 speeds", "name 1 of theta_dot",
                               lambda: sb.singular_configurations(crank(), ["theta", "s"], {"theta": (0, 1)})),
    "linear by two": ("linearize.independent", "theta, s", "name 1 of theta, beta, s",
                      lambda: sb.linearize(crank(), {"theta": 0.5}, independent=["theta", "s"])),
    "closed form of one": ("positions.number", "2 constraints", "name 2 of theta, beta, s",
                           lambda: sb.solve_positions(crank(), ["beta"])),
    "traced by none": ("kinematics.values", "no coordinate is driven", "over={",
                       lambda: sb.trace_positions(crank(), {})),
    "inverse with freedoms left": ("inverse.no_motion", "motion", "motion",
                                   lambda: sb.inverse_dynamics(FOUR_BAR, {}, "T", [0.0, 1.0])),
    # tau where it is singular
    "ratios at the dead centre": ("kinematics.singular", "joint D", "other independent speeds",
                                  lambda: sb.velocity_ratios(crank(), "s").at({"theta": 0.0, "s": 4})),
    "linear at the dead centre": ("linearize.singular_choice", "not all other states are determined by s", "leave independent out",
                                  lambda: sb.linearize(crank(), {"theta": 0}, independent=["s"])),
    "speeds at the dead centre": ("assembly.velocity_conflict", "s_dot = 1", "leave one of them",
                                  lambda: sb.assemble(crank(), {"theta": 0, "s_dot": 1.0}, {"s": 4})),
    # no equilibrium, no rest
    "weight without hold": ("equilibrium.none", "along x_dot, -19.62 N", "spring", lambda: sb.find_equilibrium(falling())),
    # motions that break constraints
    "traced against the loop": ("assembly.conflict", "theta = 0.1, s = 3.9", "guess=",
                                lambda: sb.trace_positions(crank(), {"theta": [0.1, 1], "s": [3.9, 3.8]})),
    "started against the loop": ("assembly.conflict", "theta = 0.3, s = 3", "guess=",
                                 lambda: sb.simulate(crank(), 1.0, {"theta": 0.3, "s": 3.0})),
    "inverse against the loop": ("inverse.motion_conflict", "t = 0 s", "motion", against_the_loop),
}  # fmt: skip


@pytest.mark.parametrize("question", OTHERS)
def test_what_has_no_answer(question: str) -> None:
    code, told, cure, ask = OTHERS[question]
    with pytest.raises(sb.SymbodyError) as caught:
        ask()
    (problem,) = caught.value.problems
    assert problem.code == code
    assert told in f"{problem.where}: {problem.what} {problem.why}", str(problem)
    assert cure in problem.fix, str(problem)


def test_a_limit_of_a_table_is_no_error() -> None:
    """What can be led part of the way is, and the joint is named."""
    table = sb.trace_positions(crank(), {"s": np.linspace(3.9, 4.1, 5)}, {"theta": 0.4})
    assert not table.success and table.limits["s"] == pytest.approx(4.0, abs=1e-9)
    assert table.notes[0].startswith("joint ")
