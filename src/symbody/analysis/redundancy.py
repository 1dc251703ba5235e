"""`redundancy`: which constraints say what others say already, on the branch of configurations they leave.

The loops are closed near a guess, and the branch through this configuration is explored; see
`symbody.manifold`. At a regular configuration on it a row of J is redundant if it lies in the span of rows
kept before it. Lengths are kept before angles and earlier rows before later ones, so that of equal supports
the first bears the load.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symbody.analysis.configurations.assembly import find_configuration
from symbody.analysis.configurations.closed_gaps import gap_assumptions
from symbody.analysis.constraint_evaluator import constraint_evaluator
from symbody.analysis.named_values import named_values, refuse_unknown
from symbody.analysis.scales import mechanism_scales
from symbody.arguments import checked_arguments
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.equations.equation_set import EquationSet
from symbody.equations.freedoms.mobility import count_freedoms, generic_point
from symbody.equations.solving.undetermined import find_undetermined, generic, in_order
from symbody.errors import AssemblyError, Problem
from symbody.manifold import explore_branch, independent_rows

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Redundancy:
    """The independent and the redundant constraints of a mechanism.

    Attributes
    ----------
    degrees_of_freedom : int
        Dimension of the branch of configurations near the guess, less independent constraints on velocities
        alone.
    kept, dropped : tuple of str
        Names of multipliers of independent rows, and of rows that follow from these.
    instantaneous : int or None
        Independent speeds at the guess itself, where their number differs.
    notes : tuple of str
        Where the two counts differ, where branches of several dimensions meet, and undecided counts; also
        ropes and stops that are taken as taut and closed.
    undetermined : tuple of str
        Outputs that do not follow from the motion: components of reactions, "reaction J Fz", and efforts that
        hold motions, "effort J". Their values are those of the minimum-norm solution.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> found = sb.redundancy(sb.form_equations(ladder))
    >>> found.degrees_of_freedom, found.kept, found.dropped
    (1, ('lambda_rod_1',), ())
    """

    degrees_of_freedom: int
    kept: tuple[str, ...]
    dropped: tuple[str, ...]
    instantaneous: int | None = None
    notes: tuple[str, ...] = ()
    undetermined: tuple[str, ...] = field(default=(), compare=False)


@checked_arguments
def redundancy(
    eqs: EquationSet,
    parameters: Mapping[str, Value] | None = None,
    guess: Mapping[str, Value] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> Redundancy:
    """Return the independent and the redundant constraints for values of the parameters.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    guess : mapping of name to number or formula in parameters
        Near which the loops close; by default the model's initial values.
    scales : mapping of "length", "time", "mass" to float, optional
        What counts as large [m, s, kg]; by default it follows from the model, and without any length there
        from the guess.

    Returns
    -------
    Redundancy
        Which constraints are ``kept`` and ``dropped``, the degrees of freedom, what reactions are
        undetermined, and notes.

    Raises
    ------
    UsageError
        If a name in `scales` is unknown, or a value is not positive.
    AssemblyError
        If the loops close nowhere near the guess.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> sb.redundancy(eqs).degrees_of_freedom
    1
    """
    refuse_unknown(eqs, guess or ())
    values, around = dict(parameters or {}), {**eqs.model.initial, **(guess or {})}
    near = named_values(eqs, around, parameters, strict=set(guess or ()))
    evaluator = constraint_evaluator(eqs, values, {}, 0.0, mechanism_scales(eqs, values, scales, near))
    if evaluator.is_tree:
        somewhere = evaluator.normalize(np.linspace(0.2, 0.8, len(eqs.coordinate_names)))
        names = (
            undetermined_outputs(eqs, parameters or {}, [(0.0, somewhere)]) if eqs.formed.redundant else ()
        )
        return Redundancy(len(eqs.speed_names), (), (), undetermined=names)
    q = find_configuration(evaluator, guess or {}, parameters)
    if q is None:
        raise AssemblyError(
            Problem("redundancy.open", eqs.model.name, "no configuration was found that closes the loops", "",
                    "run assemble() to see which joint cannot be closed, or give guess=")
        )  # fmt: skip
    sizes = evaluator.mechanism.constraints(eqs)[:, np.newaxis]

    def velocity_rows(q: Floats) -> Floats:
        return np.asarray(evaluator.velocity_rows(q, {})[0] / sizes * evaluator.speed_sizes)

    branch = explore_branch(evaluator.manifold(), q)
    count = count_freedoms(eqs.formed, branch, velocity_rows)
    rows = eqs.formed.rows
    order = sorted(range(len(rows)), key=lambda k: (rows[k].force.is_zero, k))
    kept = independent_rows(velocity_rows(generic_point(branch, velocity_rows)), order)
    names = eqs.multiplier_names
    return Redundancy(
        count.degrees_of_freedom,
        tuple(names[k] for k in sorted(kept)),
        tuple(name for k, name in enumerate(names) if k not in kept),
        None if count.instantaneous == count.degrees_of_freedom else count.instantaneous,
        (*count.notes, *gap_assumptions(eqs)),
        undetermined_outputs(eqs, parameters or {}, [(0.0, point) for point in branch.points]),
    )


def undetermined_outputs(
    eqs: EquationSet, parameters: Mapping[str, Value], places: Iterable[tuple[float, ArrayLike]]
) -> tuple[str, ...]:
    """Return the outputs that do not follow from the motion at those configurations that are not singular.

    Parameters
    ----------
    places : iterable of (t, (n_q,) array)
        On which the loops close.
    """
    chosen = parameter_set(eqs, parameters)
    values, formed = chosen.floats, chosen.eqs.formed
    others = {"p": [values[name] for name in eqs.parameter_names], "r": [0.0] * len(formed.inputs)}
    points = [{"t": [t], "q": np.asarray(q, dtype=np.float64).tolist(), **others} for t, q in places]
    return in_order(formed, generic(find_undetermined(formed, points)).names)
