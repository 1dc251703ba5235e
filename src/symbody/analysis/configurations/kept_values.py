"""`kept_initial_values`: the model's first positions that are kept, and not only guessed.

Those of `surplus_initial_values` are kept where the loops close with all of them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial

from symbody.analysis.configurations.loop_search import newton_end
from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.errors import SymbodyError


def held_initial_values(eqs: EquationSet, fixed: Collection[str], guess: Collection[str]) -> dict[str, Value]:
    """Return the first values of the model that hold, where a caller gives no others."""
    return {
        name: eqs.model.initial[name]
        for name in eqs.model.held_initial
        if name not in fixed and name not in guess
    }


def kept_initial_values(
    eqs: EquationSet, fixed: Collection[str], guess: Collection[str]
) -> Mapping[str, Value]:
    """Return the first positions of the model if they are no more than there are freedoms.

    Parameters
    ----------
    fixed, guess : collections of str
        Names that have values of a caller, which go first.

    Returns
    -------
    mapping of name to value
        Empty where the model gives more positions than freedoms are left, or where a caller guesses
        positions: those of the model are guesses then. So they are where quaternions are among them, or
        balances of forces on what has no mass among the constraints.
    """
    freedoms, names = eqs.plans.get("kept initial values", partial(_initial_positions, eqs))
    kept = [name for name in names if name not in fixed]
    if not kept or len(kept) + _positions(eqs, fixed) > freedoms or _positions(eqs, guess):
        return {}
    return {name: eqs.model.initial[name] for name in kept}


def surplus_initial_values(
    eqs: EquationSet, fixed: Collection[str], guess: Collection[str]
) -> Mapping[str, Value]:
    """Return the first positions of the model if they are more than there are freedoms.

    They may fit all the same, as equal angles of a parallelogram do. Empty where a caller fixes or guesses
    positions, or ropes or stops are among the constraints.
    """
    freedoms, names = eqs.plans.get("kept initial values", partial(_initial_positions, eqs))
    if (
        len(names) <= freedoms
        or _positions(eqs, fixed)
        or _positions(eqs, guess)
        or unilateral_elements(eqs.formed)
    ):
        return {}
    return {name: eqs.model.initial[name] for name in names}


def do_values_fit(evaluator: ConstraintEvaluator, values: Mapping[str, float]) -> bool:
    """Return whether the loops close with all of these positions, for the others nearest to 0."""
    return newton_end(evaluator, evaluator.initial_coordinates(values), values).is_closed


def _initial_positions(eqs: EquationSet) -> tuple[int, tuple[str, ...]]:
    """Return the number of freedoms, and the coordinates with first values, unless these are guesses."""
    holonomic, coordinates = eqs.formed.holonomic, eqs.coordinate_names
    names = tuple(name for name in coordinates if name in eqs.model.initial)
    in_quaternions = {name for four in eqs.quaternions for name in four}
    is_guess = len(names) == len(coordinates) or not in_quaternions.isdisjoint(names)
    if not holonomic or not names or is_guess or any(row.is_balance for row in holonomic):
        return 0, ()
    freedoms = len(coordinates) - len(eqs.quaternions) - len(holonomic)
    if len(names) > freedoms:
        freedoms = _counted_freedoms(eqs)
    return freedoms, names


def _counted_freedoms(eqs: EquationSet) -> int:
    """Return the freedoms where constraints follow from others, 0 where they cannot be counted."""
    try:
        return eqs.degrees_of_freedom
    except SymbodyError:
        return 0


def _positions(eqs: EquationSet, names: Collection[str]) -> int:
    """Return how many names are those of positions, of cut joints too."""
    rates = {*eqs.speed_names, *eqs.signal_state_names}
    return sum(name not in rates and not name.endswith("_dot") for name in names)
