"""`generate_simulation`: a motion as a program that stands alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.simulation.events.events import Event, check_events
from symbody.simulation.inputs.input_laws import Law, input_laws, laws_of_tables
from symbody.simulation.methods.constraints import Baumgarte, Projection
from symbody.simulation.methods.explicit import Explicit
from symbody.simulation.methods.fixed_step import FixedStep
from symbody.simulation.methods.implicit.generalized_alpha import GeneralizedAlpha
from symbody.simulation.programs.main_texts import LANGUAGES, program_text
from symbody.simulation.programs.motion_request import (
    MotionRequest,
    pose_motion,
    reason_for_program,
    with_modes,
)
from symbody.simulation.programs.prepared_motion import prepare_motion

_SAMPLES = 101


@named_after(3)
@checked_arguments
def generate_simulation(
    eqs: EquationSet, t_end: float | tuple[float, float], language: str = "c",
    initial: Mapping[str, Value] | None = None, guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None, inputs: Mapping[str, Law] | None = None,
    times: ArrayLike | None = None, integrator: Explicit | FixedStep | GeneralizedAlpha | None = None,
    constraints: Projection | Baumgarte | None = None, events: Event | Sequence[Event] = (), *,
    rtol: float = 1e-8, atol: float | None = None,
    scales: Mapping[str, float] | None = None, max_steps: int = 1_000_000,
) -> str:  # fmt: skip
    """Return a program that computes a motion as `simulate` does, and needs nothing else.

    It holds the equations, the integrator with its projection, and the first state, and prints the samples:
    time, speeds, coordinates, work. Joints stick and slip, gaps close and open, as in `simulate`. Events are
    listed on the error output, name and time in each line. The
    programs in all languages print the same numbers to the last bit, as long as the equations use no function
    beyond sine, cosine, roots and whole powers, which languages compute in their own ways. They agree with
    `simulate` to the tolerance.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    t_end : float or (t0, t_end)
        End time [s], or both ends.
    language : str
        "c" for C99 (to be compiled with ``-ffp-contract=off``), "javascript" for Node and browsers, where
        ``simulate()`` returns the samples and what happened, or "python", without any package.
    initial, guess : mapping of name to number or formula, optional
        The first state, as for `simulate`.
    parameters, inputs : mapping, optional
        Values and laws that are written into the program, as for `simulate`.
    times : array, optional
        The samples; by default 101 from the first to the last time.
    integrator, constraints : optional
        ``Explicit(..)``, ``FixedStep(..)`` or, for stiff mechanisms without samples, dry friction and gaps,
        ``GeneralizedAlpha(..)``; ``Projection(..)`` or ``Baumgarte(..)``.
    events : Event or sequence of Event
        What is looked for, as for `simulate`.
    rtol, atol, scales, max_steps : optional
        Tolerances and the limit of steps, as for `simulate`.

    Returns
    -------
    str
        The text of the program.

    Raises
    ------
    UsageError
        An unknown language, or a motion that `simulate` computes in part by Python: inputs that are
        functions.
    CompileError, AssemblyError
        As `simulate`.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> program = sb.generate_simulation(eqs, 1.0, language="python")
    >>> "def simulate" in program
    True
    """
    if language not in LANGUAGES:
        fix = f"choose one of {', '.join(LANGUAGES)}"
        what = f"programs cannot be generated in {language!r}"
        raise UsageError(Problem("simulation.language", "language", what, "", fix))
    span = t_end if isinstance(t_end, tuple) else (0.0, t_end)
    watched = check_events(events, eqs)
    laws = input_laws(eqs.input_names, {**laws_of_tables(eqs), **(inputs or {})}, span)
    reason = reason_for_program(eqs, laws, integrator, constraints)
    if reason:
        fix = "give inputs as formulas, or use simulate"
        raise UsageError(
            Problem(
                "simulation.program", "", f"this motion cannot be generated as a program: {reason}", "", fix
            )
        )
    request = MotionRequest(
        initial or {}, parameters or {}, inputs or {}, integrator=integrator, constraints=constraints,
        rtol=rtol, atol=atol, span=span, last=span[1], is_pulled=False, guess=guess, scales=scales,
        max_steps=max_steps, times=np.linspace(*span, _SAMPLES) if times is None else times, events=watched,
    )  # fmt: skip
    motion = prepare_motion(with_modes(pose_motion(eqs, request, laws)))
    return program_text(motion, LANGUAGES[language], eqs.model.name)
