"""Equations of motion: Newton's, Euler's and Lagrange's written out, and as an `EquationSet`."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping

from symbody.equations.by_hand.balance_by_hand import euler, is_weight, newton
from symbody.equations.by_hand.energies_by_hand import gravitational_energy as gravitational
from symbody.equations.by_hand.energies_by_hand import kinetic_energy as kinetic
from symbody.equations.by_hand.energies_by_hand import lagrange
from symbody.equations.by_hand.equations_by_hand import equations_by_hand
from symbody.equations.by_hand.mechanism import (
    MechanismByHand,
    PlacedForce,
    PlacedObject,
    build_mechanism,
    check_coordinates,
)
from symbody.equations.equation_set import EquationSet
from symbody.equations.formulations.formulation import Formulation
from symbody.equations.formulations.lagrange import Lagrange
from symbody.expr.sympy.sympy_writer import SympyExpr
from symbody.mbsymba.arguments import as_point, read_bodies, read_objects
from symbody.mbsymba.objects import BODY, FRAME, OBJECT, POINT, VECTOR
from symbody.mbsymba.workplace import WORKPLACE, function_names, to_sympy_expressions
from symbody.model.declarations.arguments import Value

Objects = OBJECT | Iterable[OBJECT]


class Equations(list[SympyExpr]):
    """Expressions that vanish in every motion; a list that also leads to the `EquationSet`.

    Attributes
    ----------
    mechanism : MechanismByHand
        What they are the equations of.
    coordinates : tuple of str
        Names of the coordinates.
    """

    def __init__(
        self,
        expressions: Iterable[SympyExpr],
        mechanism: MechanismByHand,
        coordinates: tuple[str, ...],
        natural: bool,
    ) -> None:
        list.__init__(self, expressions)
        self.mechanism = mechanism
        self.coordinates = coordinates
        self._natural = natural

    @property
    def equation_set(self) -> EquationSet:
        """The same equations for compile, assemble, simulate, linearize and all else."""
        return equations_by_hand(self.mechanism, self.coordinates, Lagrange(), natural=self._natural)


def newton_equations(objects: Objects) -> VECTOR:
    """Return Newton's equation of the bodies among the objects, in ground: ``m a - F``, 0 in every motion.

    Forces on other bodies do not count, forces between the bodies cancel. Weights count by themselves once
    set_gravity was called: then leave them out of the forces.
    """
    items = [item.placed for item in read_objects(objects, "newton_equations")]
    _warn_of_weights(items)
    return VECTOR(newton(WORKPLACE.graph, items, WORKPLACE.gravity))


def euler_equations(objects: Objects, pole: POINT | FRAME | BODY) -> VECTOR:
    """Return Euler's equation of the bodies among the objects about a pole, in the axes of the pole's frame.

    ``I alpha + w x I w + (G - P) x m a - M``, 0 in every motion, whatever the pole. Weights count as in
    `newton_equations`.
    """
    items = [item.placed for item in read_objects(objects, "euler_equations")]
    _warn_of_weights(items)
    return VECTOR(euler(WORKPLACE.graph, items, as_point(pole, "euler_equations"), WORKPLACE.gravity))


def kinetic_energy(bodies: BODY | Iterable[BODY], nat_coords: bool = False) -> SympyExpr:
    """Return the kinetic energy of bodies relative to ground.

    With ``nat_coords`` its mass matrix is constant in natural coordinates; where they are unit vectors, it is
    the same.
    """
    items = [body.placed for body in read_bodies(bodies, "kinetic_energy")]
    return to_sympy_expressions([kinetic(WORKPLACE.graph, items, nat_coords)])[0]


def gravitational_energy(bodies: BODY | Iterable[BODY]) -> SympyExpr:
    """Return the potential energy of bodies in the gravity of set_gravity, 0 at the origin of ground."""
    items = [body.placed for body in read_bodies(bodies, "gravitational_energy")]
    return to_sympy_expressions([gravitational(WORKPLACE.graph, items, WORKPLACE.gravity)])[0]


def lagrange_equations(
    objects: Objects, variables: Iterable[SympyExpr], t: SympyExpr | None = None, *, nat_coords: bool = False
) -> Equations:
    """Return Lagrange's equations, one a coordinate, then the constraints; all are 0 in every motion.

    ``d/dt dT/dq' - dT/dq + dV/dq - Phi_q^T lambda - Q``, V that of the gravity of set_gravity.

    Parameters
    ----------
    variables : list of functions of time
        The coordinates, and behind them, or left out, the multipliers of the constraints.
    t : symbol
        Time; it is dynamicsymbols._t, whatever is given.
    nat_coords : bool
        Whether the kinetic energy is that of natural coordinates; see `kinetic_energy`.

    Raises
    ------
    ModelError
        If a coordinate does not occur, something moves that is not a coordinate, or the objects do not fit.
    """
    mechanism = _mechanism(objects, "lagrange_equations")
    names = function_names(variables, "lagrange_equations")
    coordinates = tuple(name for name in names if name not in mechanism.multipliers)
    check_coordinates(mechanism, coordinates)
    equations = to_sympy_expressions(lagrange(mechanism, coordinates, nat_coords))
    return Equations(equations, mechanism, coordinates, nat_coords)


def equation_set(
    objects: Objects,
    coordinates: Iterable[SympyExpr],
    formulation: Formulation | None = None,
    *,
    nat_coords: bool = False,
    reactions: Iterable[SympyExpr] = (),
    parameters: Mapping[str, Value] | None = None,
    name: str = "mechanism by hand",
) -> EquationSet:
    """Return the equations of motion for compile, assemble, simulate, linearize and all else.

    Parameters
    ----------
    objects : iterable of BODY, FORCE, TORQUE, CONSTRAINT
        The mechanism, in the gravity of set_gravity.
    coordinates : list of functions of time
        Multipliers of the constraints may stand among them. All other functions of time are inputs.
    formulation : Formulation, optional
        Virtual work by default; Lagrange with nat_coords.
    reactions : iterable of functions of time
        Reactions in the forces, as of Newton's equations; they do no work, so they leave the equations, and
        the constraints' multipliers take their place.
    parameters : mapping of name to number or formula
        Values of parameters.

    Raises
    ------
    ModelError, FormulationError
        If coordinates, reactions or parameters do not occur, something moves that is not a coordinate, or the
        objects do not fit.
    """
    mechanism = _mechanism(objects, "equation_set")
    names = function_names(coordinates, "equation_set")
    return equations_by_hand(
        mechanism,
        [item for item in names if item not in mechanism.multipliers],
        formulation,
        natural=nat_coords,
        reactions=function_names(reactions, "equation_set"),
        parameters=parameters,
        name=name,
    )


def _mechanism(objects: Objects, where: str) -> MechanismByHand:
    items = [item.placed for item in read_objects(objects, where)]
    _warn_of_weights(items)
    return build_mechanism(items, WORKPLACE.gravity)


def _warn_of_weights(items: Iterable[PlacedObject]) -> None:
    """Warn of a force that is the weight of its body, while gravity adds the weight already."""
    gravity = WORKPLACE.gravity
    forces = [item for item in items if isinstance(item, PlacedForce)]
    if gravity is None or not any(is_weight(force, gravity) for force in forces):
        return
    warnings.warn(
        "a force is the weight of its body, and set_gravity adds the weight too: it counts twice. Leave the "
        "force out, or call set_gravity(None)",
        stacklevel=4,
    )
