"""Which way a stepper takes its steps."""

from __future__ import annotations

from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import switches
from symbody.errors import Problem, SimulationError
from symbody.simulation.hybrid.rate_jumps import may_jump
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.stepper.compiled_steps import CompiledSteps, Ending, Steps
from symbody.simulation.stepper.fmu_steps import FmuSteps
from symbody.simulation.stepper.hybrid_steps import HybridSteps
from symbody.simulation.stepper.numbers import StepNumbers
from symbody.simulation.stepper.separate_motions import SeparateMotions, why_separate
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


def has_instants(eqs: EquationSet) -> bool:
    """Return whether more than smooth motion may happen: samples, changes of modes, jumps of rates."""
    return bool(held_later(eqs)) or switches(eqs.formed) or eqs.plans.get("may jump", lambda: may_jump(eqs))


def broken_off(t: float, ending: Ending) -> SimulationError:
    """Return what to say about a step that did not come to its end."""
    return SimulationError(
        Problem("stepper.broke_off", f"t = {t:.9g} s", f"the step was aborted: {ending.note}",
                ending.status.value, "reset() the stepper, or restore() a state saved before")
    )  # fmt: skip
