"""What a stepper is made from, checked."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError, nearest
from symbody.simulation.events.events import Event
from symbody.simulation.inputs.fmu_input import FmuInput
from symbody.simulation.inputs.held_law import held_later
from symbody.simulation.inputs.input_laws import Law, laws_of_tables
from symbody.simulation.inputs.tables import Table
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.integration import DEFAULT, Constraints, Integrator

# What depends on time alone is looked at for so many steps ahead.
WINDOW: Final = 1000


@dataclass(frozen=True, slots=True, eq=False)
class StepperSettings:
    """What stays the same while a stepper moves.

    Attributes
    ----------
    eqs, moving : EquationSet
        The equations as given, and with the stabilizing terms of `Baumgarte`.
    initial, guess : mapping of name to number or formula
        Values at the start, as for `simulate`.
    t_start : float
        When that is [s].
    held : tuple of str
        Inputs that are constant in each step: those that steps give, and those that FMUs compute.
    laws : mapping of name to law
        Of other inputs; those without one are 0.
    max_steps : int
        How many steps of the integrator one step may take.
    """

    eqs: EquationSet
    moving: EquationSet
    dt: float
    initial: Mapping[str, Value]
    guess: Mapping[str, Value]
    t_start: float
    held: tuple[str, ...]
    laws: Mapping[str, Law]
    integrator: Integrator | None
    constraints: Constraints | None
    events: tuple[Event, ...]
    rtol: float
    atol: float | None
    scales: Mapping[str, float] | None
    max_steps: int
    fmus: Mapping[str, FmuInput] = field(default_factory=dict)

    @property
    def inputs_of_steps(self) -> tuple[str, ...]:
        """Inputs that steps give."""
        return tuple(name for name in self.held if name not in self.fmus)

    @property
    def bounded_tables(self) -> dict[str, Table]:
        """Inputs by tables that no step may leave."""
        laws = {name: Table(*law) if isinstance(law, tuple) else law for name, law in self.laws.items()}
        tables = {name: law for name, law in laws.items() if isinstance(law, Table)}
        return {name: table for name, table in tables.items() if table.outside == "error"}

    @property
    def method(self) -> Explicit | FixedStep:
        """The integrator of the compiled loop."""
        return self.integrator if isinstance(self.integrator, Explicit | FixedStep) else DEFAULT

    @property
    def projection(self) -> Projection | None:
        """What closes loops after each of its steps; None where `Baumgarte` holds them."""
        if isinstance(self.constraints, Baumgarte):
            return None
        return self.constraints if isinstance(self.constraints, Projection) else Projection()

    @property
    def silent(self) -> tuple[str, ...]:
        """Inputs that are 0 because nobody gives them."""
        return tuple(name for name in self.eqs.input_names if name not in self.held and name not in self.laws)


def split_inputs(
    eqs: EquationSet, inputs: Mapping[str, Law] | Iterable[str] | None
) -> tuple[tuple[str, ...], Mapping[str, Law], Mapping[str, FmuInput]]:
    """Return the inputs that steps hold, in the order of the equations, the laws of others, and FMUs.

    Raises
    ------
    UsageError
        If it is neither a mapping nor names, or a name is unknown.
    """
    laws: Mapping[str, Law] = inputs if isinstance(inputs, Mapping) else {}
    sampled = held_later(eqs)
    open_names = tuple(name for name in eqs.input_names if name not in sampled)
    named: object = open_names if inputs is None else inputs
    names: tuple[object, ...] = tuple(named) if isinstance(named, Iterable) else (named,)
    if isinstance(named, str):
        names = (named,)
    problems = [
        Problem("stepper.inputs", "inputs", f"{name!r} is not the name of an input", "",
                'give laws, as {"F": "sin(t)"}, or names, as ["F"]')
        for name in names if not isinstance(name, str)
    ] or [
        unknown_name("input", str(name), open_names) for name in names if name not in open_names
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
    if isinstance(inputs, Mapping):
        fmus = {name: law for name, law in laws.items() if isinstance(law, FmuInput)}
        kept = {name: law for name, law in laws.items() if name not in fmus}
        tables = {name: law for name, law in laws_of_tables(eqs).items() if name not in laws}
        laws = {**tables, **kept, **sampled}
        return tuple(name for name in eqs.input_names if name not in laws), laws, fmus
    tables = {name: law for name, law in laws_of_tables(eqs).items() if inputs is None or name not in names}
    held = tuple(name for name in eqs.input_names if name in names and name not in tables)
    return held, {**tables, **sampled}, {}


def unknown_name(kind: str, name: str, names: Iterable[str], why: str = "") -> Problem:
    """Return what to say about a name that a stepper does not have."""
    return Problem("stepper.unknown_name", name, f"there is no {kind} {name!r}", why, nearest(name, names))


def checked_duration(name: str, value: object) -> float:
    """Return the length of a step [s].

    Raises
    ------
    UsageError
        If it is not a positive finite number.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
        raise UsageError(
            Problem("stepper.dt", name, f"{name} = {value!r} is not a valid step size",
                    "steps advance by a finite positive time", "give seconds, such as 0.001")
        )  # fmt: skip
    return float(value)


def checked_start(t: object) -> float:
    """Return the time at the start [s].

    Raises
    ------
    UsageError
        If it is not a finite number.
    """
    if isinstance(t, bool) or not isinstance(t, int | float) or not math.isfinite(t):
        raise UsageError(
            Problem("stepper.t", "t", f"t = {t!r} is not a valid time", "", "give finite seconds")
        )
    return float(t)
