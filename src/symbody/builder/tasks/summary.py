"""What a model is: coordinates, freedoms, trees, and which joint closes which loop."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from symbody.analysis.redundancy import redundancy
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.modal_equations import permanent_equations
from symbody.errors import SymbodyError
from symbody.graph.spanning_tree import SpanningTree
from symbody.graph.topology import Topology
from symbody.model.element import Element
from symbody.model.naming import GROUND

Summary = dict[str, Any]


def tree_summary(topology: Topology) -> Summary:
    """Return the trees of a model, before its equations are formed."""
    return {
        "bodies": len(topology.model.bodies),
        "rotation_tree": _members(topology, topology.rotation_branches),
        "translation_tree": _members(topology, topology.translation_branches),
        "tree_choice": {
            joint.name: {
                "rotation": joint.name in topology.rotation_branches,
                "translation": joint.name in topology.translation_branches,
            }
            for joint in topology.model.joints
        },
    }


def equation_summary(eqs: EquationSet) -> Summary:
    """Return what the equations say of a model."""
    formed = eqs.formed
    lasting = permanent_equations(eqs)  # what limits or contacts hold while they are closed is not counted
    freedoms, instant, redundant, notes = _freedoms(lasting)
    named = (*eqs.coordinate_names, *formed.topology.model.parameters)
    return {
        **tree_summary(formed.topology),
        "coordinates": list(eqs.coordinate_names),
        "speeds": list(eqs.speed_names),
        "units": {name: eqs.units.get(name, "") for name in named},
        "freedoms": freedoms,
        "instant_freedoms": instant,
        "constraints": len(lasting.multiplier_names),
        "unilateral": len(eqs.multiplier_names) - len(lasting.multiplier_names),
        "chords": _chords(eqs),
        "redundant": redundant,
        "counting": notes,
    }


def _members(topology: Topology, names: frozenset[str]) -> list[str]:
    return [joint.name for joint in topology.model.joints if joint.name in names]


def _freedoms(eqs: EquationSet) -> tuple[int | None, int | None, list[str], list[str]]:
    """Return freedoms, those of the instant where they differ, what is redundant in words, and notes."""
    if not eqs.multiplier_names:
        return len(eqs.speed_names), None, [], []
    try:
        count = redundancy(eqs)
    except SymbodyError:  # loops without lengths, or loops that do not close: nothing can be counted
        return None, None, [], []
    owners = {row.name: row.element for row in eqs.formed.rows}
    texts = [f"{owners.get(name, name)}: {name} follows from the others" for name in count.dropped]
    return count.degrees_of_freedom, count.instantaneous, texts, list(count.notes)


def _chords(eqs: EquationSet) -> list[Summary]:
    """Return what closes loops: joints out of a tree and constraints, each with its equations and loop."""
    topology = eqs.formed.topology
    rows = [row.element for row, _ in eqs.formed.rows_and_multipliers]
    elements: list[Element] = [*topology.model.joints, *topology.model.constraints]
    return [
        {
            "joint": element.name,
            "equations": rows.count(element.name),
            "loop": _loop(topology.translation, topology.link(element.name)),
        }
        for element in elements
        if rows.count(element.name)
    ]


def _loop(tree: SpanningTree, link: Any) -> list[str]:
    """Return the bodies of the loop that a joint closes with the branches of a tree."""
    if link is None:
        return []
    parents = {branch.child: branch.parent for branch in tree.branches}
    left, right = _way(parents, link.start.body), _way(parents, link.end.body)
    shared = [body for body in left if body in right]
    meeting = shared[0] if shared else GROUND
    up = left[: left.index(meeting) + 1] if meeting in left else left
    down = right[: right.index(meeting)] if meeting in right else right
    return [*up, *reversed(down)]


def _way(parents: dict[str, str], body: str) -> Sequence[str]:
    way = [body]
    while way[-1] in parents:
        way.append(parents[way[-1]])
    return way
