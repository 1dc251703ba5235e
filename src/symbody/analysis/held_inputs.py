"""Sampled signals in analyses of smooth equations: there they are inputs, or continuous."""

from __future__ import annotations

from collections.abc import Container

from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.model.model import Model


def refuse_held(eqs: EquationSet, work: str, given: Container[str] = ()) -> None:
    """Refuse equations with sampled signals that are not among the inputs that are `given`.

    Parameters
    ----------
    work : str
        What cannot be done, as "a linear model".

    Raises
    ------
    UsageError
        Naming them.
    """
    held = eqs.model.held_signals if isinstance(eqs.model, Model) else ()
    names = [signal.name for signal in held if signal.name not in given]
    if names:
        as_inputs = "" if isinstance(given, tuple) else f", or give them in inputs={{{names[0]!r}: ..}}"
        raise UsageError(
            Problem("signal.sampled", f"signal {names[0]}", f"{work} does not sample {', '.join(names)}",
                    "only simulate, Stepper, sweep and FMUs update sampled values at their sample times",
                    f"form the equations of sb.without_sampling(model){as_inputs}")
        )  # fmt: skip
