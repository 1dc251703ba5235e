"""`closing_equations`: the equations in which states are closed, whatever those of the motion substitute.

When an action sets one coordinate of a coupling, the change of the others is least, measured in all of them.
Where one is substituted it is no state: such states are closed with all couplings as constraints.
"""

from __future__ import annotations

from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.form import form_equations
from symbody.equations.solving.modal_equations import modal_equations
from symbody.equations.solving.sticking import STICKS, set_modes
from symbody.equations.solving.unilateral import open_gaps
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr
from symbody.expr.printing.text import to_text


def closing_equations(eqs: EquationSet) -> EquationSet:
    """Return the equations that close the states of others, in the same modes: themselves, or unsubstituted.

    These suffice in a tree where each substituted coordinate follows from one other.
    """
    formed = eqs.formed
    coupled = formed.coupled
    if not coupled.values or not (
        formed.rows or any(len(coupled.sources(name)) > 1 for name in coupled.values)
    ):
        return eqs
    whole: EquationSet = coupled.unsubstituted.get(None, lambda: _form_unsubstituted(eqs))
    if any(law.may_stick for law in formed.friction) or _has_modes(formed):
        return modal_equations(whole).eqs
    slack = {row.gap for row in formed.slack}
    stuck = tuple(law.name for law in formed.friction if law.sticks)
    if not (slack or stuck):
        return whole
    in_modes: EquationSet = whole.plans.get(
        ("modes of closing", tuple(sorted(slack)), stuck),
        lambda: EquationSet(
            whole.model,
            set_modes(open_gaps(whole.formed, slack), dict.fromkeys(stuck, STICKS)),
            whole.notes,
        ),
    )
    return in_modes


def _has_modes(formed: EquationsOfMotion) -> bool:
    """Return whether gaps are rows in some of their modes."""
    return not {row.gap for row in formed.slack}.isdisjoint(row.gap for row in formed.rows)


def follower_outputs(eqs: EquationSet) -> tuple[str, ...]:
    """Return formulas of the coordinates that are substituted, then of their rates, in the states."""
    values = eqs.formed.coupled.values
    places = [f"({to_text(value.graph, value.index)})" for value in values.values()]
    return (*places, *(_rate(eqs.formed, name) for name in values))


def follower_names(eqs: EquationSet) -> tuple[str, ...]:
    """Return the coordinates that are substituted, then their rates."""
    names = tuple(eqs.formed.coupled.values)
    return (*names, *(f"{name}_dot" for name in names))


def _rate(formed: EquationsOfMotion, name: str) -> str:
    """Return the formula of a rate: the value is of first degree, its factors are constant."""
    value, leaders = formed.coupled.values[name], formed.coupled.sources(name)
    by = [formed.names.value(leader).index for leader in leaders]
    slopes = gradient(value.graph, value.index, by)
    terms = [
        f"({to_text(value.graph, slope)})*{leader}_dot"
        for leader, slope in zip(leaders, slopes, strict=True)
        if not Expr(value.graph, slope).is_zero
    ]
    return f"({' + '.join(terms) or '0'})"


def _form_unsubstituted(eqs: EquationSet) -> EquationSet:
    """Return the equations of the same model, in the same trees, with all couplings as constraints."""
    dependent = eqs.formed.dependent_names or None
    return form_equations(eqs.model, tree=eqs.formed.topology.trees, dependent_speeds=dependent)
