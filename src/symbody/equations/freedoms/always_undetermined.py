"""Outputs that constraints leave undetermined whatever the values of the parameters."""

from __future__ import annotations

from random import Random
from typing import Final

from symbody.equations.derivation import derive
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.virtual_work import VirtualWork
from symbody.equations.freedoms.mobility import values_when_assembled
from symbody.equations.solving.negligible_constraints import random_point
from symbody.equations.solving.undetermined import (
    find_identically_undetermined,
    find_undetermined,
    generic,
    in_order,
)
from symbody.errors import AssemblyError, ModelError
from symbody.expr.graph import Graph
from symbody.graph.topology import choose_topology
from symbody.model.model import resolve_parameters
from symbody.tolerances import TYPED

_POINTS: Final = 2


def find_always_undetermined(formed: EquationsOfMotion) -> tuple[str, ...]:
    """Return the outputs that do not follow from the motion, whatever the values of the parameters.

    They are those that share constraints which hold identically in the coordinates of the joints, and those
    that share constraints which depend on each other for random values and, where the loops close with the
    values of the model, there too.
    """
    if not formed.joint_roles or not (formed.rows or formed.redundant):
        return ()
    formed = _in_joint_coordinates(formed)
    certain = find_identically_undetermined(formed)
    random = Random(7)
    points = [random_point(formed, {}, random) for _ in range(_POINTS)]
    everywhere = frozenset.intersection(*(one.names for one in find_undetermined(formed, points, TYPED)))
    if everywhere.issubset(certain):
        return certain
    try:
        values = resolve_parameters(formed.topology.model)
        closed = values_when_assembled(formed, [symbol.label for symbol in formed.q])
    except (AssemblyError, ModelError):
        return certain
    own = [float(values[symbol.name]) for symbol in formed.parameters]
    others = {"p": own, "r": [0.0] * len(formed.inputs), "t": [0.0]}
    found = find_undetermined(formed, [{"q": [x for (x,) in q], **others} for q in closed])
    return in_order(formed, {*certain, *(everywhere & generic(found).names)})


def _in_joint_coordinates(formed: EquationsOfMotion) -> EquationsOfMotion:
    """Return equations of the same mechanism in coordinates of joints."""
    topology, own = choose_topology(formed.topology.model, "joints"), formed.topology
    if (topology.rotation, topology.translation) == (own.rotation, own.translation):
        return formed
    return derive(topology, Graph(), VirtualWork())
