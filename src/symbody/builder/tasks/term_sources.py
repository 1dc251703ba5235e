"""Which elements a term of the equations comes from.

The equations are formed once more with twice the inertia of each body, since motions without mass leave the
equations, and without each force, spring or drive. All are multiplied out into products that are compared by
their fingerprints, so that it does not matter how terms are grouped and written. A term comes from the
elements by whose change one of its products gets another factor in its equation; a term that elements share
names them all.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Final

from symbody.equations.equation_set import EquationSet
from symbody.equations.form import form_equations
from symbody.equations.outputs.equation_sections import equation_sides, signed_terms
from symbody.errors import SymbodyError
from symbody.expr.canonical import ZERO, sub
from symbody.expr.fingerprints.monomials import Monomials, monomials
from symbody.expr.graph import SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.formats.native import from_data

Data = Mapping[str, Any]
Term = tuple[int, int]  # the equation, and the node of the term

MOST_ELEMENTS: Final = 40
MOST_SPEEDS: Final = 8
_SECONDS: Final = 3.0  # for the equations without one element
_LOADS: Final = ("spring", "torsion_spring", "force", "torque")
_EFFORTS: Final = ("force", "torque", "friction")
_INERTIA: Final = ("mass", "inertia", "products")


def term_sources(eqs: EquationSet, data: Data, folder: str) -> dict[Term, list[str]]:
    """Return the elements that each term of the equations of motion comes from; nothing of large mechanisms.

    Parameters
    ----------
    data : mapping
        The model as JSON data.
    """
    variants = list(_variants(data))
    if len(variants) > MOST_ELEMENTS or len(eqs.speed_names) > MOST_SPEEDS:
        return {}
    terms, rows = _terms(eqs), _rows(eqs)
    products = monomials(eqs.formed.graph, [node for _, node in terms])
    sources = {term: _constraints_in(eqs, term[1]) for term in terms}
    for name, changed in variants:
        try:
            others = _rows(form_equations(from_data(changed, folder=folder), time_limit=_SECONDS))
        except SymbodyError:  # there are no equations without it
            continue
        for row, node in terms:
            if any(rows[row].get(key) != others[row].get(key) for key in products[node]):
                sources[row, node].append(name)
    return sources


def _constraints_in(eqs: EquationSet, node: int) -> list[str]:
    """Return the joints and constraints whose multipliers are in a term."""
    graph = eqs.formed.graph
    symbols = [graph.symbols[graph.left[leaf]] for leaf in symbols_of(graph, [node])]
    held = {symbol.name for symbol in symbols if symbol.kind is SymbolKind.MULTIPLIER}
    return list(dict.fromkeys(row.element for row in eqs.formed.rows if row.name in held))


def _terms(eqs: EquationSet) -> list[Term]:
    """Return the terms of all equations of motion."""
    graph = eqs.formed.graph
    listed = [
        (row, node)
        for row, sides in enumerate(equation_sides(eqs.textbook))
        for side in sides
        for _, node in signed_terms(graph, side)
        if node != ZERO
    ]
    return list(dict.fromkeys(listed))


def _rows(eqs: EquationSet) -> list[Monomials]:
    """Return each equation multiplied out, everything on its left side."""
    graph = eqs.formed.graph
    nodes = [sub(graph, left, right) for left, right in equation_sides(eqs.textbook)]
    products = monomials(graph, nodes)
    return [products[node] for node in nodes]


def _variants(data: Data) -> Iterator[tuple[str, dict[str, Any]]]:
    """Return the model with each element changed in turn, as far as elements add terms."""
    for k, body in enumerate(data.get("body", [])):
        heavier = {key: _double(value) if key in _INERTIA else value for key, value in body.items()}
        yield body["name"], _replace_entry(data, "body", k, heavier)
    for kind in _LOADS:
        for k, entry in enumerate(data.get(kind, [])):
            yield entry["name"], {**data, kind: [each for j, each in enumerate(data[kind]) if j != k]}
    for k, joint in enumerate(data.get("joint", [])):
        if joint["type"] == "bushing":
            yield joint["name"], {**data, "joint": [each for j, each in enumerate(data["joint"]) if j != k]}
        elif set(joint) & {*_EFFORTS, "armature"}:
            without = {key: value for key, value in joint.items() if key not in (*_EFFORTS, "armature")}
            yield joint["name"], _replace_entry(data, "joint", k, without)


def _double(value: object) -> object:
    """Return twice a number or formula, or twice each entry of a list."""
    if isinstance(value, list):
        return [_double(entry) for entry in value]
    return f"2*({value})"


def _replace_entry(data: Data, kind: str, place: int, entry: Mapping[str, Any]) -> dict[str, Any]:
    return {**data, kind: [entry if k == place else each for k, each in enumerate(data[kind])]}
