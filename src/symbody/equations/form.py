"""`form_equations`: from a model to its equations of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Final, Literal, NamedTuple

from symbody.arguments import checked_arguments
from symbody.collection import without_collection
from symbody.equations.cache_key import DeferredEquations, identity, load_notes
from symbody.equations.derivation import default_formulation, derive
from symbody.equations.equation_set import EquationSet
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.freedoms.chosen_speeds import choose_dependent_speeds
from symbody.errors import Problem, UsageError
from symbody.expr.deadline import begin, check_limit, in_time
from symbody.expr.graph import Graph
from symbody.graph.topology import choose_topology
from symbody.graph.trees import TreeChoice
from symbody.model.model import Model

_LESS: Final = (
    "make the equations smaller: weld bodies that do not move relative to each other, use Recursive() where "
    'one tree of joints gives all coordinates, or tree="absolute" for many closed loops'
)


@checked_arguments
def form_equations(
    model: Model,
    formulation: Formulation | None = None,
    *,
    tree: TreeChoice = None,
    dependent_speeds: Sequence[str] | Literal["auto"] | None = None,
    substitute: bool = False,
    time_limit: float | None = None,
) -> EquationSet:
    """Return the equations of motion of a model; all parameters stay symbols.

    Parameters
    ----------
    model : Model
        The mechanism.
    formulation : Formulation, optional
        How the equations are formed, as ``sb.NewtonEuler()``; by default recursively where one tree gives all
        coordinates, else by virtual work. All give the same equations: Newton-Euler with every reaction an
        unknown, Lagrange from energies.
    tree : Trees, "joints", "absolute" or None
        Which joints give the coordinates: those named; those of spanning trees, regardless of the model's
        flags; none, so that all bodies are free and all joints constraints; by default the flags of the
        model, completed to spanning trees. The choice is listed in `notes`.
    dependent_speeds : sequence of str, "auto" or None
        Speeds that constraints on velocities eliminate, one for each: rolling, blades, equations in rates.
        The equations are then in the other speeds alone; the multipliers of these constraints, reactions and
        dependent speeds stay outputs. "auto" takes those farthest from where they do not follow from the
        others, by the model's values of the parameters. By default no speed is eliminated.
    substitute : bool, optional
        Whether couplings that give a coordinate outright are put into the equations: gears, racks, belts,
        differentials and written equations of first degree with constant factors. Each leaves one coordinate
        and one constraint fewer; the coordinate and the multiplier stay outputs, the coordinate may have an
        initial value. `notes` lists them, and those that remain constraints, with the reason.
    time_limit : float, optional
        Seconds after which forming ends with an error that names the stage; by default there is no limit.
        Equations that an earlier process formed are formed on first use, without this limit. `compile` has
        a limit of its own.

    Returns
    -------
    EquationSet
        The equations ``M u' = F + J^T lambda`` with ``q' = N u + nu``: as formulas (``mass_matrix``,
        ``forcing``, ...), as names of outputs (``outputs()``), and as what `simulate` and `compile` take.

    Raises
    ------
    UsageError
        If `model` is not a Model, or the time limit not a positive number.
    TimeLimitError
        When time is up.
    TopologyError
        If the joints chosen do not form trees.
    FormulationError
        If the law of a cut joint needs the joint in a tree, a loop can never close, or the others do not
        determine the dependent speeds.
    AssemblyError, ModelError
        If "auto" finds no configuration, or no value of a parameter.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> print(eqs)
    2 x'' + 8 x = F
    >>> eqs.state_names
    ('x_dot', 'x')
    """
    if not isinstance(model, Model):
        raise UsageError(_no_model(model))
    check_limit(time_limit)
    choices = _Choices(model, formulation, tree, dependent_speeds, substitute)
    return _equation_set(choices, time_limit)


class _Choices(NamedTuple):
    """What equations follow from."""

    model: Model
    formulation: Formulation | None
    tree: TreeChoice
    dependent_speeds: Sequence[str] | Literal["auto"] | None
    substitute: bool


def _equation_set(choices: _Choices, time_limit: float | None) -> EquationSet:
    """Return the equations; those that an earlier process formed without an error are formed on first use."""
    model, formulation, tree, dependent_speeds, substitute = choices
    equations = identity(*choices)
    notes = load_notes(equations)
    form = partial(_form, choices)
    given: EquationsOfMotion | DeferredEquations
    if notes is None:
        given = in_time(time_limit, "forming the equations", _LESS, form)
        notes = given.notes
    else:  # nothing was wrong with them, so they can wait; the limit is that of this call alone
        given = DeferredEquations(form)
    again = partial(
        form_equations,
        model,
        formulation,
        tree=tree,
        dependent_speeds=dependent_speeds,
        substitute=substitute,
    )
    return EquationSet(model, given, notes, identity=equations, _again=again)


def exchange_values(eqs: EquationSet, model: Model) -> EquationSet:
    """Return the equations of a model that differs from theirs in the values of parameters alone.

    In equations parameters are symbols, so nothing is formed.

    Parameters
    ----------
    eqs : EquationSet
        As `form_equations` gives them by default, without dependent speeds that values have chosen.
    """
    if model is eqs.model:
        return eqs
    topology = replace(eqs.formed.topology, model=model)
    notes = model.notes + eqs.notes[len(eqs.model.notes) :]
    return EquationSet(model, replace(eqs.formed, topology=topology), notes)


def _no_model(given: object) -> Problem:
    cure = f"form_equations(load_model({given!r}))" if isinstance(given, str) else "give a Model"
    return Problem("equations.not_a_model", "model", f"{given!r} is not a model", fix=cure)


@without_collection()
def _form(choices: _Choices) -> EquationsOfMotion:
    """Return the equations with all notes: trees first, then dependent speeds, then the derivation."""
    model, formulation, tree, dependent_speeds, substitute = choices
    begin("trees")
    topology = choose_topology(model, tree)
    notes = model.notes + topology.notes
    if dependent_speeds is not None and formulation is None:
        formulation = default_formulation(topology, eliminates=True)
    dependent = _names(dependent_speeds)
    if dependent_speeds == "auto":
        begin("equations to choose dependent speeds by", notes)
        dependent = choose_dependent_speeds(derive(topology, Graph(), formulation, substitutes=substitute))
        notes = (*notes, _choice_note(dependent))
    begin("coordinates", notes)
    formed = derive(topology, Graph(), formulation, dependent=dependent, substitutes=substitute)
    return replace(formed, notes=notes + formed.notes)


def _names(speeds: Sequence[str] | None) -> tuple[str, ...]:
    if speeds is None:
        return ()
    return (speeds,) if isinstance(speeds, str) else tuple(speeds)


def _choice_note(dependent: Sequence[str]) -> str:
    return (
        f"dependent speeds {', '.join(dependent)}: chosen by column pivoting at several assembled "
        f"configurations, as far from singularities as possible; set others with dependent_speeds=(...)"
    )
