"""`form_equations`: from a model to its equations of motion."""

from __future__ import annotations

from collections.abc import Sequence

from symbody.equations.equation_set import EquationSet
from symbody.equations.formed import Formed
from symbody.equations.forming import form
from symbody.equations.formulations.choice import chosen_formulation
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.freedoms.chosen_speeds import chosen_speeds
from symbody.equations.known import Deferred, identity, known_notes
from symbody.errors import Problem, UsageError
from symbody.expr.graph import Graph
from symbody.graph.topology import Topology, choose_topology
from symbody.graph.trees import TreeChoice
from symbody.model.model import Model


def form_equations(
    model: Model,
    formulation: Formulation | None = None,
    *,
    tree: TreeChoice = None,
    dependent_speeds: Sequence[str] | None = None,
) -> EquationSet:
    """Return the equations of motion of a model; all parameters stay symbols.

    Parameters
    ----------
    model : Model
        The mechanism.
    formulation : VirtualWork, Recursive, NewtonEuler or Lagrange, optional
        How the equations are formed; by default recursively where one tree gives all coordinates, else by
        virtual work. All give the same equations: Newton-Euler with every reaction an unknown, Lagrange from
        energies; formulas of short ones are shown by virtual work.
    tree : Trees, "joints", "absolute" or None
        Which joints give the coordinates: those named; those of spanning trees, whatever the model's flags
        say; none, so that all bodies are free and all joints constraints; by default the flags of the
        model, completed to spanning trees. The choice stands in `notes`.
    dependent_speeds : sequence of str, "auto" or None
        Speeds that constraints on velocities eliminate, one for each: rolling, blades, equations in rates.
        The equations are then in the other speeds alone; the multipliers of these constraints, reactions and
        dependent speeds stay outputs. "auto" takes those farthest from where they do not follow from the
        others, by the model's values of the parameters. By default no speed is eliminated.

    Raises
    ------
    UsageError
        If `model` is none.
    TopologyError
        If the trees are no trees.
    FormulationError
        If a cut joint cannot do what is asked of it, a loop can never close, or the dependent speeds do not
        follow from the others.
    AssemblyError, ModelError
        If "auto" finds no configuration, or no value of a parameter.
    """
    if not isinstance(model, Model):
        raise UsageError(_no_model(model))
    equations = identity(model, formulation, tree, dependent_speeds)
    notes = known_notes(equations)
    if notes is not None:  # nothing was wrong with them, so they can wait
        later = Deferred(lambda: _formed(model, formulation, tree, dependent_speeds)[0])
        return EquationSet(model, later, notes, identity=equations)
    return EquationSet(model, *_formed(model, formulation, tree, dependent_speeds), identity=equations)


def _no_model(given: object) -> Problem:
    cure = f"form_equations(load_model({given!r}))" if isinstance(given, str) else "give a Model"
    return Problem("equations.not_a_model", "model", f"{given!r} is no model", fix=cure)


def _formed(
    model: Model,
    formulation: Formulation | None,
    tree: TreeChoice,
    dependent_speeds: Sequence[str] | None,
) -> tuple[Formed, tuple[str, ...]]:
    """Return the equations and all notes."""
    topology = choose_topology(model, tree)
    how = chosen_formulation(topology, formulation, dependent_speeds is not None)
    if dependent_speeds == "auto":
        dependent, told = _chosen(topology, how)
    else:
        dependent, told = _named(dependent_speeds), ()
    formed = form(topology, Graph(), how, dependent=dependent)
    return formed, model.notes + topology.notes + told + formed.notes


def _named(wanted: Sequence[str] | None) -> tuple[str, ...]:
    if wanted is None:
        return ()
    return (wanted,) if isinstance(wanted, str) else tuple(wanted)


def _chosen(topology: Topology, how: Formulation) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return dependent speeds, and what is said of the choice."""
    chosen = chosen_speeds(form(topology, Graph(), how))
    note = (
        f"dependent speeds {', '.join(chosen)}: chosen by column pivoting at several assembled "
        "configurations, farthest from where they do not follow from the others; dependent_speeds=(...) "
        "names others"
    )
    return chosen, (note,)
