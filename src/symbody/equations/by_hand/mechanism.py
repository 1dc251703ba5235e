"""`MechanismByHand`: bodies, forces and constraints by expressions in coordinates; frozen, without joints."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from symbody.errors import ModelError, Problem, nearest
from symbody.expr.expression import Expr, common_graph
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.rewrite import symbols_of
from symbody.spatial.matrix import Matrix
from symbody.spatial.placed import PlacedPoint, PlacedVector


@dataclass(frozen=True, slots=True, eq=False)
class PlacedBody:
    """A rigid body; its axes are those of the frame in which its centre of mass is given.

    Attributes
    ----------
    name : str
        Empty: named by its place among the bodies, body1, body2.
    centre : PlacedPoint
        Centre of mass.
    mass : Expr
        Mass [kg].
    tensor : (3, 3) Expr
        Inertia about the centre of mass, products as tensor entries [kg m^2].
    """

    name: str
    centre: PlacedPoint
    mass: Expr
    tensor: Matrix


@dataclass(frozen=True, slots=True, eq=False)
class PlacedForce:
    """A force on a body at a point, its opposite on another body at the same place, or on ground (None)."""

    vector: PlacedVector
    point: PlacedPoint
    on: PlacedBody
    reaction_on: PlacedBody | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PlacedTorque:
    """A torque on a body, with its opposite on another body, or on ground (None)."""

    vector: PlacedVector
    on: PlacedBody
    reaction_on: PlacedBody | None = None


PlacedLoad = PlacedForce | PlacedTorque


@dataclass(frozen=True, slots=True, eq=False)
class PlacedConstraint:
    """Expressions that vanish, each with its multiplier.

    Attributes
    ----------
    values : tuple of Expr
        In coordinates and time; with rates, of first degree in these, a constraint on velocities.
    multipliers : tuple of str
        Names of functions of time.
    """

    values: tuple[Expr, ...]
    multipliers: tuple[str, ...]


PlacedObject = PlacedBody | PlacedForce | PlacedTorque | PlacedConstraint


@dataclass(frozen=True, slots=True, eq=False)
class MechanismByHand:
    """A mechanism by hand.

    Attributes
    ----------
    gravity : PlacedVector or None
        Acceleration of free fall [m/s^2].
    """

    bodies: tuple[PlacedBody, ...]
    loads: tuple[PlacedLoad, ...]
    constraints: tuple[PlacedConstraint, ...]
    gravity: PlacedVector | None = None

    @property
    def multipliers(self) -> tuple[str, ...]:
        """Names of the multipliers, in the order of the constraints."""
        return tuple(name for constraint in self.constraints for name in constraint.multipliers)

    @property
    def expressions(self) -> Iterator[Expr]:
        """Everything the mechanism is written in."""
        for body in self.bodies:
            yield body.mass
            yield from (entry for row in body.tensor for entry in row)
            yield from (*body.centre.frame.expressions, *body.centre.coordinates)
        for load in self.loads:
            yield from (*load.vector.frame.expressions, *load.vector.components)
            if isinstance(load, PlacedForce):
                yield from (*load.point.frame.expressions, *load.point.coordinates)
        for constraint in self.constraints:
            yield from constraint.values
        if self.gravity is not None:
            yield from (*self.gravity.frame.expressions, *self.gravity.components)

    @property
    def graph(self) -> Graph:
        """The graph that most of it stands in."""
        return common_graph(self.expressions)[0]

    @property
    def symbols(self) -> list[Symbol]:
        """The symbols that occur, each once."""
        graph, nodes = common_graph(self.expressions)
        return [graph.symbols[graph.left[node]] for node in symbols_of(graph, nodes)]


def build_mechanism(objects: Iterable[PlacedObject], gravity: PlacedVector | None = None) -> MechanismByHand:
    """Return the mechanism that some objects make, bodies and forces and constraints in the order given.

    Raises
    ------
    ModelError
        If there is no body, something is given twice, a force acts on a body that is not among them, or two
        constraints share a multiplier.
    """
    items = list(objects)
    found = MechanismByHand(
        tuple(item for item in items if isinstance(item, PlacedBody)),
        tuple(item for item in items if isinstance(item, PlacedForce | PlacedTorque)),
        tuple(item for item in items if isinstance(item, PlacedConstraint)),
        gravity,
    )
    problems = [*_no_body(found), *_twice(found), *_stray_loads(found), *_repeated_multipliers(found)]
    if problems:
        raise ModelError(*problems)
    return found


def check_coordinates(mechanism: MechanismByHand, coordinates: Sequence[str]) -> None:
    """Refuse coordinates that are not in the mechanism, twice, or missing.

    Raises
    ------
    ModelError
        With all of them at once.
    """
    symbols = [symbol for symbol in mechanism.symbols if symbol.kind is SymbolKind.COORDINATE]
    known = {symbol.name for symbol in symbols}
    problems = [
        Problem("by_hand.unknown_coordinate", name, f"the coordinate {name!r} appears in no frame, force or "
            f"constraint of the mechanism", "nothing depends on it, so no equation determines it",
                f"leave it out, or add the body that it moves; {nearest(name, known)}")
        for name in coordinates if name not in known
    ]  # fmt: skip
    problems += [
        Problem("by_hand.coordinate_twice", name, f"the coordinate {name!r} is listed twice", "",
                "list it once")
        for name in dict.fromkeys(coordinates) if list(coordinates).count(name) > 1
    ]  # fmt: skip
    both = [name for name in coordinates if name in mechanism.multipliers]
    problems += [
        Problem("by_hand.coordinate_is_multiplier", name, f"{name!r} is a coordinate and a multiplier", "",
                "give the constraint another multiplier")
        for name in both
    ]  # fmt: skip
    moving = {symbol.name for symbol in symbols if symbol.order} | _functions_in_frames(mechanism)
    problems += [
        Problem("by_hand.missing_coordinate", name, f"{name!r} moves the mechanism but is not listed as a "
                "coordinate", "frames, constraints or rates depend on it",
                "list it among the coordinates, or write its motion as a formula in t")
        for name in sorted(moving.difference(coordinates, mechanism.multipliers))
    ]  # fmt: skip
    if problems:
        raise ModelError(*problems)


def _functions_in_frames(mechanism: MechanismByHand) -> set[str]:
    """Return the functions of time that frames and constraints depend on."""
    placed = [body.centre for body in mechanism.bodies]
    values = [x for point in placed for x in (*point.frame.expressions, *point.coordinates)]
    values += [x for constraint in mechanism.constraints for x in constraint.values]
    graph, nodes = common_graph(values)
    symbols = (graph.symbols[graph.left[node]] for node in symbols_of(graph, nodes))
    return {symbol.name for symbol in symbols if symbol.kind is SymbolKind.COORDINATE}


def _no_body(mechanism: MechanismByHand) -> Iterator[Problem]:
    if not mechanism.bodies:
        yield Problem("by_hand.no_body", "objects", "there is no body among the objects",
                      "equations of motion need bodies",
                      "add what make_BODY returned, with any mass if only positions matter; "
                      "sb.solve_positions(Phi, unknowns) solves constraints alone")  # fmt: skip


def _twice(mechanism: MechanismByHand) -> Iterator[Problem]:
    for body in dict.fromkeys(b for b in mechanism.bodies if mechanism.bodies.count(b) > 1):
        yield Problem("by_hand.body_twice", _body_title(body), "the body is given twice",
                      "its inertia would be counted twice", "list it once")  # fmt: skip
    for load in dict.fromkeys(x for x in mechanism.loads if mechanism.loads.count(x) > 1):
        yield Problem("by_hand.load_twice", _body_title(load.on), "a force or torque on it is given twice",
                      "it would be counted twice", "list it once")  # fmt: skip
    names = [body.name for body in dict.fromkeys(mechanism.bodies) if body.name]
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        yield Problem("by_hand.body_name", f"body {name}", f"two bodies are named {name!r}", "",
                      "give them different names")  # fmt: skip


def _stray_loads(mechanism: MechanismByHand) -> Iterator[Problem]:
    for load in mechanism.loads:
        kind = "force" if isinstance(load, PlacedForce) else "torque"
        for body in (load.on, load.reaction_on):
            if body is not None and body not in mechanism.bodies:
                yield Problem("by_hand.stray_load", _body_title(body),
                              f"a {kind} acts on the body, which is not among the objects",
                              "its power would be counted, but not its inertia",
                              "add the body to the objects, or leave the force out")  # fmt: skip


def _body_title(body: PlacedBody) -> str:
    return f"body {body.name}" if body.name else "a body has no name"


def _repeated_multipliers(mechanism: MechanismByHand) -> Iterator[Problem]:
    names = mechanism.multipliers
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        yield Problem("by_hand.multiplier_twice", name, f"the multiplier {name!r} appears in two constraints",
                      "each equation needs its own multiplier",
                      "give the multipliers different names")  # fmt: skip
