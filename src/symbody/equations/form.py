"""`form_equations`: from a model to its equations of motion."""

from __future__ import annotations

from symbody.equations.dynamics.virtual_work import VirtualWork
from symbody.equations.equation_set import EquationSet
from symbody.equations.forming import form
from symbody.expr.graph import Graph
from symbody.graph.topology import choose_topology
from symbody.graph.trees import TreeChoice
from symbody.model.model import Model


def form_equations(
    model: Model, formulation: VirtualWork | None = None, *, tree: TreeChoice = None
) -> EquationSet:
    """Return the equations of motion of a model; all parameters stay symbols.

    Parameters
    ----------
    model : Model
        The mechanism.
    formulation : VirtualWork, optional
        How the equations are formed; virtual work by default.
    tree : Trees, "joints", "absolute" or None
        Which joints give the coordinates: those named; those of spanning trees, whatever the model's flags
        say; none, so that all bodies are free and all joints constraints; by default the flags of the
        model, completed to spanning trees. The choice stands in `notes`.

    Raises
    ------
    TopologyError
        If the trees are no trees.
    FormulationError
        If a cut joint cannot do what is asked of it, or a loop can never close.
    """
    topology = choose_topology(model, tree)
    formed = form(topology, Graph())
    return EquationSet(model, formed, model.notes + topology.notes + formed.notes)
