"""`steps_of`: in the compiled loop where it can take them, else each as a motion of its own."""

from __future__ import annotations

from dataclasses import replace

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import permanent_equations, switches
from symbody.errors import Problem, SimulationError
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.methods.closed_loops.overconstrained import is_overconstrained
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.methods.implicit.stiff import Stiff
from symbody.simulation.stepper.compiled_steps import CompiledSteps, Ending, Steps
from symbody.simulation.stepper.fmu_steps import FmuSteps
from symbody.simulation.stepper.hybrid_steps import HybridSteps
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.separate_motions import SeparateMotions
from symbody.simulation.stepper.step_problem import StepProblem


def steps_of(problem: StepProblem, numbers: StepNumbers) -> tuple[Steps, tuple[str, ...]]:
    """Return what takes the steps of a problem, and a note on why they are slow where they are."""
    steps, notes = _plain_steps(problem, numbers)
    return (FmuSteps(steps, problem, numbers) if problem.settings.fmus else steps), notes


def _plain_steps(problem: StepProblem, numbers: StepNumbers) -> tuple[Steps, tuple[str, ...]]:
    reason = why_separate(problem, numbers)
    if reason:
        return SeparateMotions(problem, numbers), (
            f"each step is a separate simulation, which is slow: {reason}",
        )
    if problem.settings.events or has_instants(problem.settings.moving):
        return HybridSteps(problem, numbers), ()
    return CompiledSteps(problem, numbers), ()


def why_separate(problem: StepProblem, numbers: StepNumbers) -> str:
    """Return why steps have to be motions of their own, empty where the compiled loop can take them."""
    settings = problem.settings
    eqs = settings.moving
    if isinstance(settings.integrator, Stiff | GeneralizedAlpha):
        return f"sb.{type(settings.integrator).__name__}() restarts in each step"
    if not isinstance(settings.constraints, Projection | Baumgarte | None):
        return f"sb.{type(settings.constraints).__name__}() restarts in each step"
    if eqs.formed.elimination is not None:
        return "pivots of dependent speeds are monitored"
    always = replace(problem.problem, eqs=permanent_equations(eqs))  # gaps may be open
    if settings.constraints is None and is_overconstrained(always, numbers.t, numbers.x[:-1].copy()):
        return "some constraints are redundant only where all loops are closed"
    return ""


def has_instants(eqs: EquationSet) -> bool:
    """Return whether more than smooth motion may happen: samples, changes of modes, jumps of rates."""
    return bool(held_later(eqs)) or switches(eqs.formed) or eqs.plans.get("may jump", lambda: may_jump(eqs))


def broken_off(t: float, ending: Ending) -> SimulationError:
    """Return what to say about a step that did not come to its end."""
    return SimulationError(
        Problem("stepper.broke_off", f"t = {t:.9g} s", f"the step was aborted: {ending.note}",
                ending.status.value, "reset() the stepper, or restore() a state saved before")
    )  # fmt: skip
