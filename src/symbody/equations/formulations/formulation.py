"""The choice of a formulation: which derivation gives mass matrix and forcing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from symbody.equations.dynamics.inertia import Inertia, Rotor
from symbody.equations.dynamics.projection import Projection
from symbody.equations.formulations.direct import project_directly
from symbody.equations.formulations.lagrange import Lagrange, form_energies, project_energies
from symbody.equations.formulations.newton_euler import NewtonEuler
from symbody.equations.formulations.recursive import Recursive
from symbody.equations.formulations.virtual_work import VIRTUAL_WORK, VirtualWork, project
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import Use
from symbody.equations.loads.loads import Loads
from symbody.graph.topology import Topology

Formulation = VirtualWork | NewtonEuler | Lagrange | Recursive


def differentiates(formulation: Formulation) -> bool:
    """Return whether a formulation takes placements only and differentiates them."""
    return isinstance(formulation, NewtonEuler | Lagrange)


def legal_formulation(
    topology: Topology, formulation: Formulation, *, dependent: bool
) -> tuple[Formulation, tuple[str, ...]]:
    """Return the formulation, virtual work where recursion cannot be done, and what is said of that."""
    if not isinstance(formulation, Recursive):
        return formulation, ()
    if topology.turning == topology.sliding and not dependent:
        return formulation, ()
    why = "speeds are eliminated" if dependent else "the rotation tree is not the translation tree"
    return VIRTUAL_WORK, (f"virtual work takes the place of recursion: {why}",)


def projected(
    formulation: Formulation,
    topology: Topology,
    names: Names,
    kinematics: Kinematics,
    uses: Sequence[Use],
    bodies: Sequence[Inertia],
    loads: Loads,
    armatures: Mapping[str, Rotor],
) -> Projection:
    """Return mass matrix and forcing in the speeds; of Newton-Euler with the reactions eliminated."""
    if isinstance(formulation, Lagrange):
        rotors = [(names.value(coordinate), rotor) for coordinate, rotor in armatures.items()]
        energies = form_energies(kinematics, bodies, loads.potential_energy, loads.without_potential, rotors)
        return project_energies(kinematics, energies)
    if isinstance(formulation, NewtonEuler):
        return project_directly(kinematics, bodies, loads.loads, armatures)
    return project(topology, kinematics, uses, bodies, loads.loads, armatures)
