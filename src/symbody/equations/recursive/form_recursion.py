"""What the recursive formulation delivers for a mechanism."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from symbody.equations.dynamics.inertia import Rotor
from symbody.equations.formulations.recursive import Recursive
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use
from symbody.equations.loads.loads import Loads
from symbody.equations.recursive.energies import kinetic_energy, potential_energy
from symbody.equations.recursive.recursion import Recursion
from symbody.equations.recursive.tree import base_tree, form_tree, ground_inertia
from symbody.expr.expression import Expr, number
from symbody.graph.topology import Topology
from symbody.vectors.matrix import Vector3


def form_recursion(
    formulation: Recursive,
    topology: Topology,
    names: Names,
    kinematics: Kinematics,
    uses: Sequence[Use],
    loads: Loads,
    armatures: Mapping[str, Rotor],
) -> tuple[Recursion, Expr, Loads]:
    """Return mass matrix and forcing, the kinetic energy, and the loads with the potential of gravity."""
    tree = form_tree(topology, names, kinematics.rates, uses, align=formulation.aligned)
    gravity = Vector3(names.triple(topology.model.gravity, "gravity"))
    on_ground = ground_inertia(names, topology.model.bodies, tree)
    light = tree
    if formulation.regrouped:
        light, share = base_tree(names.graph, tree)
        on_ground = on_ground + share
    rotors = tuple(armatures.values())
    recursion = Recursion(
        topology=topology,
        kinematics=kinematics,
        tree=tree,
        light=light,
        gravity=gravity,
        loads=loads.loads,
        rotors=rotors,
        method=formulation.method,
    )
    potential = loads.potential_energy + potential_energy(light, on_ground, gravity)
    kinetic = kinetic_energy(light, rotors, number(names.graph, 0))
    return recursion, kinetic, replace(loads, potential_energy=potential)
