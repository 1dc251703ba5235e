"""Whether the arguments of `simulate` are of the kinds that it takes."""

from __future__ import annotations

from numbers import Real
from typing import get_args

from symbody.analysis.named_values import checked_mappings
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.simulation.methods.integration import Constraints, Integrator


def check_arguments(
    eqs: object, t_end: object, integrator: object, constraints: object, **by_name: object
) -> None:
    """Refuse arguments of `simulate` of other kinds than it takes; those `by_name` are mappings.

    Raises
    ------
    UsageError
        With every such argument.
    """
    problems = []
    if not isinstance(eqs, EquationSet):
        what = f"{type(eqs).__name__} is no set of equations"
        problems.append(Problem("simulation.not_equations", "eqs", what, "", "write form_equations(model)"))
    ends = t_end if isinstance(t_end, tuple) and len(t_end) == 2 else (t_end,)
    if not all(isinstance(end, Real) for end in ends):
        what = f"{t_end!r} is no time"
        problems.append(
            Problem("simulation.not_a_time", "t_end", what, "", "give seconds: 10.0, or (2.0, 10.0)")
        )
    for name, given, kinds in [
        ("integrator", integrator, get_args(Integrator)),
        ("constraints", constraints, get_args(Constraints)),
    ]:
        if given is not None and not isinstance(given, kinds):
            known = ", ".join(f"{kind.__name__}(..)" for kind in kinds)
            what = f"{given!r} means nothing"
            problems.append(Problem("simulation.not_a_method", name, what, "", f"write one of {known}"))
    if problems:
        raise UsageError(*problems)
    checked_mappings(**by_name)
