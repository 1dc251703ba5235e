"""`equations_by_hand`: from a mechanism placed by hand to its `EquationSet`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from symbody.equations.by_hand.derivation_by_hand import derive_by_hand
from symbody.equations.by_hand.mechanism import MechanismByHand, PlacedBody, check_coordinates
from symbody.equations.by_hand.restated import Restatement
from symbody.equations.equation_set import EquationSet
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.lagrange import Lagrange
from symbody.equations.formulations.virtual_work import VirtualWork
from symbody.errors import FormulationError, ModelError, Problem, nearest
from symbody.expr.expression import Expr
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import dependence
from symbody.model.body import Body
from symbody.model.declarations.arguments import Value
from symbody.model.model import Model


def equations_by_hand(
    mechanism: MechanismByHand,
    coordinates: Sequence[str],
    formulation: Formulation | None = None,
    *,
    natural: bool = False,
    reactions: Sequence[str] = (),
    parameters: Mapping[str, Value] | None = None,
    name: str = "mechanism by hand",
) -> EquationSet:
    """Return the equations of motion of a mechanism by hand, the same class as those of drawn joints.

    Functions of time that are neither coordinates nor multipliers are inputs.

    Parameters
    ----------
    formulation : VirtualWork, NewtonEuler or Lagrange, optional
        How they are formed; virtual work by default, Lagrange for natural coordinates.
    natural : bool
        Whether the kinetic energy is the one with a constant mass matrix in natural coordinates.
    reactions : sequence of str
        Functions of time in forces that are reactions: they do no work, so they leave the equations, and the
        constraints with their multipliers take their place.
    parameters : mapping of name to number or formula
        Values.

    Raises
    ------
    ModelError
        If a coordinate, reaction or parameter does not occur, or a moving quantity is not a coordinate.
    FormulationError
        If the formulation does not accept a kinetic energy, or a constraint is not linear in the rates.
    """
    check_coordinates(mechanism, coordinates)
    check_formulation(formulation, natural)
    restated, inputs = _split_functions(mechanism, coordinates, reactions)
    model = _outline_model(name, restated, inputs, parameters or {})
    how = formulation or (Lagrange() if natural else VirtualWork())
    formed = derive_by_hand(model, restated, coordinates, how, natural=natural)
    return EquationSet(model, formed, (*_notes(mechanism, inputs, reactions), *formed.notes))


def check_formulation(formulation: Formulation | None, natural: bool) -> None:
    """Refuse a formulation that does not accept a kinetic energy, where natural coordinates need theirs."""
    if natural and formulation is not None and not formulation.takes_kinetic_energy:
        raise FormulationError(
            Problem("by_hand.natural_energy", "nat_coords",
                    f"{type(formulation).__name__} does not accept a kinetic energy",
                    "the constant mass matrix is derived from the kinetic energy",
                    "use Lagrange(), or leave nat_coords out")
        )  # fmt: skip


def _split_functions(
    mechanism: MechanismByHand, coordinates: Sequence[str], reactions: Sequence[str]
) -> tuple[MechanismByHand, tuple[str, ...]]:
    """Return the mechanism with functions of time as inputs, reactions gone; and the names of the inputs."""
    functions = [s.name for s in mechanism.symbols if s.kind is SymbolKind.COORDINATE and not s.order]
    apart = {*coordinates, *mechanism.multipliers, *reactions}
    inputs = tuple(sorted(name for name in dict.fromkeys(functions) if name not in apart))
    problems = [
        Problem("by_hand.unknown_reaction", name, f"the reaction {name!r} appears in no force", "",
                nearest(name, inputs))
        for name in reactions if name not in functions
    ]  # fmt: skip
    problems += [
        Problem("by_hand.multiplier_in_load", name, f"the multiplier {name!r} appears in a frame or a force",
                "a force that depends on reactions is not linear in them",
                "model the joint with friction, or use an input instead")
        for name in mechanism.multipliers if name in functions
    ]  # fmt: skip
    if problems:
        raise ModelError(*problems)
    replaced: dict[Symbol, Symbol | int] = {
        Symbol(name, SymbolKind.COORDINATE): Symbol(name, SymbolKind.INPUT) for name in inputs
    }
    replaced |= dict.fromkeys((Symbol(name, SymbolKind.COORDINATE) for name in reactions), 0)
    return Restatement(mechanism.graph, replaced).mechanism(mechanism), inputs


def _outline_model(
    name: str, mechanism: MechanismByHand, inputs: Sequence[str], parameters: Mapping[str, Value]
) -> Model:
    """Return a model with the bodies, parameters and inputs of the mechanism, without their positions."""
    own = dict.fromkeys(s.name for s in mechanism.symbols if s.kind is SymbolKind.PARAMETER)
    problems = [
        Problem("by_hand.unknown_parameter", name, f"the mechanism has no parameter {name!r}", "",
                nearest(name, own))
        for name in parameters if name not in own
    ]  # fmt: skip
    if problems:
        raise ModelError(*problems)
    gravity = (0, 0, 0) if mechanism.gravity is None else tuple(map(_text, mechanism.gravity.in_ground))
    values = {parameter: parameters.get(parameter) for parameter in own}
    return Model(name, map(_body, mechanism.bodies), gravity, values, inputs)


def _body(body: PlacedBody) -> Body:
    t = body.tensor
    return Body(
        body.name, _text(body.mass), [_text(t[k][k]) for k in range(3)],
        [_text(t[i][j]) for i, j in ((0, 1), (0, 2), (1, 2))],
    )  # fmt: skip


def _text(x: Expr) -> str:
    """Return a constant as text; 0 for a variable, which a model cannot contain."""
    constant = dependence(x.graph, [x.index])[x.index] <= {SymbolKind.PARAMETER}
    return to_text(x.graph, x.index) if constant else "0"


def _notes(mechanism: MechanismByHand, inputs: Sequence[str], reactions: Sequence[str]) -> Iterator[str]:
    if inputs:
        yield f"these functions of time are not coordinates and become inputs: {', '.join(inputs)}"
    if reactions:
        yield (
            f"the reactions {', '.join(reactions)} do no work and were removed from the equations of "
            f"motion; multipliers of constraints replace them"
        )
    if mechanism.gravity is None:
        yield "there is no gravity"
