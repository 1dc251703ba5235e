"""Names that analyses add to equations are no names of the equations that they began with."""

from __future__ import annotations

import pytest

import symbody as sb
from symbody.analysis.derivatives import with_outputs
from symbody.expr.graph import Symbol, SymbolKind
from tests.problems.mechanisms import model_of


@pytest.mark.parametrize("is_first", [True, False])
def test_names_are_found_where_they_were_added(is_first: bool) -> None:
    eqs = sb.form_equations(model_of("four_bar"))
    wider = with_outputs(eqs, [], {"pull": Symbol("pull", SymbolKind.INPUT)})
    if is_first:  # names are formed on request; before, the first who asked decided for both
        assert "pull" not in eqs.formed.readable_names.values
    assert wider.roots("2*pull").nodes
    with pytest.raises(sb.FormulationError):
        eqs.roots("2*pull")
