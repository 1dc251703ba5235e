"""Dry friction of joints: what is known of it before the reactions are.

The effort of each joint with friction is an unknown of its own, a symbol like a multiplier: all equations of
motion are linear in it. `solving.friction` finds it together with the accelerations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from symbody.equations.dynamics.load import GeneralizedForce
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.variables import JointRole
from symbody.expr.expression import Expr, number, sqrt, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import SIGN
from symbody.model.joint import Joint
from symbody.model.loads.friction import Friction


@dataclass(frozen=True, slots=True)
class FrictionLaw:
    """Dry friction along the coordinate of a joint: effort ``-slip*strength*N`` on the end body.

    Attributes
    ----------
    rate : Expr
        Of the coordinate.
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
    """

    joint: Joint
    rate: Expr
    slip: Expr
    strength: Expr
    limit: Expr
    radius: Expr | None
    reads_reaction: bool
    switches: bool
    sticks: bool = False
    may_stick: bool = False

    @property
    def coordinate(self) -> str:
        """The coordinate it acts along."""
        return self.joint.coordinates[0]

    @property
    def turns(self) -> bool:
        """Whether its coordinate is an angle."""
        return self.coordinate in self.joint.rotation_coordinates

    @property
    def symbol(self) -> Symbol:
        """Its effort as an unknown."""
        return Symbol(f"friction_{self.joint.name}", SymbolKind.MULTIPLIER)

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
        return symbol(graph, Symbol(f"friction_normal_{self.joint.name}", SymbolKind.MULTIPLIER))

    @property
    def is_coupled(self) -> bool:
        """Whether its effort depends on the reaction."""
        return self.reads_reaction and not self.sticks and not (self.slip * self.strength).is_zero

    @property
    def holding_effort(self) -> str:
        """The name of the row that holds the joint while it sticks."""
        return f"lambda_{self.joint.name}_stick"

    @property
    def load(self) -> GeneralizedForce:
        """What it does to the equations of motion."""
        return GeneralizedForce(self.rate, self.effort, self.coordinate)


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
    if friction.v0 is None:
        slip = rate.apply(SIGN)
    else:
        slip = rate / sqrt(rate**2 + names.expression(friction.v0, where) ** 2)
    zero = number(names.graph, 0)
    return FrictionLaw(
        joint=joint,
        rate=rate,
        slip=zero if strength.is_zero else slip,
        strength=strength,
        limit=limit,
        radius=radius,
        reads_reaction=friction.reads_reaction,
        switches=not friction.is_smooth,
    )
