"""Dry friction of joints and rigid contacts: what is known of it before the reactions are.

The effort of each joint with friction, and along each direction of a contact, is an unknown of its own, a
symbol like a multiplier: all equations of motion are linear in it. `solving.friction` finds it together with
the accelerations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from symbody.equations.dynamics.load import GeneralizedForce, Load, opposite_forces
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, number, sqrt, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import LT, SELECT, SIGN
from symbody.model.joint import Joint
from symbody.model.loads.friction import Friction
from symbody.model.naming import make_symbol
from symbody.spatial.vector import Vector


@dataclass(frozen=True, slots=True)
class FrictionLaw:
    """Dry friction along the coordinate of a joint or in a contact: ``-slip*strength*N`` on the end body.

    Attributes
    ----------
    name : str
        Of the joint, or of the contact and the direction.
    element : str
        What sticks or slips as one: the joint, or both directions of a contact.
    friction : Friction
    joint : Joint or None
        None in a contact.
    rate : Expr
        Of the coordinate; the slip along the direction [m/s].
    slip : Expr
        From -1 to 1, with the sign of the rate.
    strength, limit : Expr
        What multiplies the reaction while it slips, and up to which it sticks; of friction of given strength
        the efforts themselves.
    radius : Expr or None
        Of the bearing [m].
    reads_reaction : bool
        Whether N is the joint's reaction; else it is 1.
    switches : bool
        Whether it sticks and slips by events.
    sticks : bool
        Whether a constraint holds the joint instead; the effort of the law is 0 then.
    may_stick : bool
        Whether a row that holds the joint in one of its modes is among the equations.
    touch : SlipDirection or None
        Where it acts, if in a contact.
    heading : Expr or None
        Along this direction the unit vector along which a contact began to slip, where its mode is an input.
    """

    name: str
    element: str
    friction: Friction
    joint: Joint | None
    rate: Expr
    slip: Expr
    strength: Expr
    limit: Expr
    radius: Expr | None
    reads_reaction: bool
    switches: bool
    sticks: bool = False
    may_stick: bool = False
    touch: SlipDirection | None = None
    heading: Expr | None = None

    @property
    def coordinate(self) -> str:
        """The coordinate it acts along; empty in a contact."""
        return "" if self.joint is None else self.joint.coordinates[0]

    @property
    def turns(self) -> bool:
        """Whether its coordinate is an angle."""
        return self.joint is not None and self.coordinate in self.joint.rotation_coordinates

    @property
    def owner(self) -> str:
        """The joint or the contact."""
        return self.name if self.touch is None else self.touch.contact

    @property
    def symbol(self) -> Symbol:
        """Its effort as an unknown."""
        return Symbol(f"friction_{self.name}", SymbolKind.MULTIPLIER)

    @property
    def effort(self) -> Expr:
        """Its effort along the positive coordinate, as an unknown of the graph."""
        return symbol(self.rate.graph, self.symbol)

    @property
    def normal(self) -> Expr:
        """The reaction N that it comes from as an unknown of the graph, or 1."""
        graph = self.rate.graph
        if not self.reads_reaction:
            return number(graph, 1)
        return symbol(graph, Symbol(f"friction_normal_{self.name}", SymbolKind.MULTIPLIER))

    @property
    def is_coupled(self) -> bool:
        """Whether its effort depends on the reaction."""
        return self.reads_reaction and not self.sticks and not (self.slip * self.strength).is_zero

    @property
    def holding_effort(self) -> str:
        """The name of the row that holds the joint while it sticks."""
        return f"lambda_{self.name}_stick"

    @property
    def loads(self) -> tuple[Load, ...]:
        """What it does to the equations of motion."""
        if self.touch is None:
            return (GeneralizedForce(self.rate, self.effort, self.coordinate),)
        return opposite_forces(
            self.touch.frames, self.touch.reach, self.touch.point, self.touch.direction * self.effort
        )


# A slip below this has no direction [m/s].
STILL: Final = 1e-10


def slip_share(rate: Expr, x: Expr, y: Expr) -> Expr:
    """Return a component of the slip (x, y) over its magnitude; 0 where it has no direction."""
    zero, one = number(rate.graph, 0), number(rate.graph, 1)
    square = x * x + y * y
    moves = (one * STILL**2).apply(LT, square)
    return moves.apply(SELECT, rate / sqrt(moves.apply(SELECT, square, one)), zero)


class SlipDirection(NamedTuple):
    """A direction across the normal of a contact, in a point where shapes touch.

    Attributes
    ----------
    contact : str
    frames : (str, str)
        Of the shapes.
    reach : Vector
        From the origin of the first frame to that of the second.
    point : Vector
        From the origin of the first frame.
    direction : Vector
        A unit vector.
    row : str
        The multiplier of the gap, which is the force along the normal.
    """

    contact: str
    frames: tuple[str, str]
    reach: Vector
    point: Vector
    direction: Vector
    row: str


class Resistance(NamedTuple):
    """What friction is, solved together with the accelerations; one entry a law.

    Attributes
    ----------
    efforts : list of Expr
        Along the positive coordinates.
    normals : list of Expr
        N: magnitudes of reactions, 1 where the strength is given.
    residuals : list of Expr
        By how much each N differs from the magnitude that follows from it, over the sum of both.
    margins : list of Expr
        Positive while friction is determined; see `solving.friction`.
    """

    efforts: list[Expr]
    normals: list[Expr]
    residuals: list[Expr]
    margins: list[Expr]


def form_friction(names: Names, roles: Sequence[JointRole]) -> tuple[FrictionLaw, ...]:
    """Return the friction of all joints that have any."""
    laws = []
    for role in roles:
        friction = role.joint.friction
        if friction is not None and not friction.is_none:
            laws.append(_law(names, role.joint, friction))
    return tuple(laws)


def _law(names: Names, joint: Joint, friction: Friction) -> FrictionLaw:
    where = f"joint {joint.name}"
    rate = names.value(f"{joint.coordinates[0]}_dot")
    moving = friction.mu if friction.force is None else friction.force
    resting = friction.mu_static if friction.force is None else friction.static
    strength = names.expression(moving, where)
    limit = strength if resting is None else names.expression(resting, where)
    radius = None if friction.radius is None else names.expression(friction.radius, where)
    if radius is not None and joint.rotation_coordinates and friction.reads_reaction:
        strength, limit = strength * radius, limit * radius
    if friction.has_bristles:
        strength, slip = limit, names.value(f"{make_symbol(joint.name)}_bristle_share")
    elif friction.v0 is None:
        slip = rate.apply(SIGN)
    else:
        slip = rate / sqrt(rate**2 + names.expression(friction.v0, where) ** 2)
    zero = number(names.graph, 0)
    return FrictionLaw(
        name=joint.name,
        element=joint.name,
        friction=friction,
        joint=joint,
        rate=rate,
        slip=zero if strength.is_zero else slip,
        strength=strength,
        limit=limit,
        radius=radius,
        reads_reaction=friction.reads_reaction,
        switches=not friction.is_smooth,
    )
