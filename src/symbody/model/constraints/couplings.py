"""Coordinates of joints coupled by wheels, racks and belts; and any equation."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, TypeAlias, final

from symbody.expr.language.formula import Formula
from symbody.model.constraint import ConstraintElement
from symbody.model.declarations.combinators import OptionalField, list_of
from symbody.model.declarations.element_fields import Coupled, VanishingFormulas, element
from symbody.model.declarations.fields import AngleQuantity, Flag, Formulas, Quantity, Refusal
from symbody.model.declarations.formula_site import Scope
from symbody.model.loads.gap_laws import RESTITUTION, Backlash, GapLawPart
from symbody.model.numeric_checks import Domain, positive_length

_ONE: Final = Formula.from_value(1)
_NONZERO: Final = Domain(
    "model.no_ratio", "{formula} is 0", "the first coordinate could not move, regardless of the second",
    "give a nonzero number; to lock the first coordinate, use a joint without this degree of freedom",
    nonzero=True,
)  # fmt: skip
_PULLEY_RADIUS: Final = positive_length("the directions of rotation are given by the angles and by crossed")


_NO_BACKLASH: Final = Refusal(
    "model.not_backlash", what="{value} is not a backlash",
    fix="write Backlash(angle, rigid=True), or stiffness=.. instead of rigid",
)  # fmt: skip
BacklashLike: TypeAlias = Backlash | Mapping[str, Any]


@dataclass(frozen=True, eq=False, repr=False)
class MeshPlay(OptionalField[BacklashLike, Backlash]):
    """The play of teeth."""

    annotation: ClassVar[str]

    _: KW_ONLY
    inner: Any = field(default_factory=lambda: GapLawPart(kind=Backlash, refusal=_NO_BACKLASH))
    is_nullable: bool = True


class JointCoupling(ConstraintElement):
    """A linear equation between coordinates of joints: the sum of factors times coordinates is the offset.

    Attributes
    ----------
    displacements : int
        How many of the first coordinates are displacements; all others are angles.
    coupled : tuple of str
        The coordinates.
    offset : Formula
        In parameters and t.
    """

    __slots__ = ()

    displacements: ClassVar[int] = 0

    coupled: Coupled
    offset: Quantity

    @property
    @abstractmethod
    def factors(self) -> tuple[Formula, ...]:
        """The factor of each coordinate, in parameters."""


@final
@element
class Gear(JointCoupling):
    """Two wheels in mesh: ``first = ratio second + offset``.

    Wheels that mesh on the outside turn against each other: their ratio is negative. The multiplier is the
    torque on the first wheel about its axis [N m]. With `backlash` the wheels are free within the play of
    their teeth; where these are rigid they are two stops, ``stage low`` and ``stage high``; else
    ``effort stage`` is the torque.

    Examples
    --------
    >>> import symbody as sb
    >>> gear = sb.Gear("stage", ["motor", "output"], ratio=-3)
    >>> gear.ratio.text
    '-3'
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`first = ratio second + offset`"
    multiplier: ClassVar[str] = "the torque on the first"
    multiplier_unit: ClassVar[str] = "N m"
    effort_unit: ClassVar[str] = "N m"

    coupled: Coupled = Coupled("The angles of two joints.")
    ratio: Quantity = Quantity(
        "Turns of the first gear per turn of the second; negative for external gears.", fits=_NONZERO
    )
    offset: AngleQuantity = AngleQuantity(
        "The first angle where the second is 0.", unit="rad", default=0, scope=Scope.PRESCRIBED
    )
    backlash: MeshPlay = MeshPlay("Play of the teeth; without it they always touch on both flanks.")

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``1, -ratio``."""
        return (_ONE, _negative(self.ratio))

    @property
    def lead(self) -> str:
        """By how much the first wheel is ahead of the second, as a formula."""
        first, second = self.coupled
        return f"{first} - ({self.ratio.text})*{second} - ({self.offset.text})"

    @property
    def stops(self) -> tuple[Stop, ...]:
        """What rigid teeth with backlash are: a stop at each end of the play."""
        if self.backlash is None or not self.backlash.rigid:
            return ()
        restitution = self.backlash.restitution or 0
        return tuple(
            Stop(f"{self.name} {end}", gap, restitution=restitution)
            for end, gap in self.backlash.gaps(self.lead)
        )

    @property
    def compliant_gaps(self) -> Mapping[str, bool]:
        """The angles below which teeth that are not rigid have a force."""
        if self.backlash is None or self.backlash.rigid:
            return {}
        return {gap.text: True for _, gap in self.backlash.gaps(self.lead)}

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind."""
        return ("",) if kind == "effort" and self.compliant_gaps else ()


@final
@element
class RackPinion(JointCoupling):
    """A rack moved by a wheel: ``displacement = radius angle + offset``.

    The multiplier is the force on the rack along its displacement [N].

    Examples
    --------
    >>> import symbody as sb
    >>> rack = sb.RackPinion("rack", ["x", "steering"], radius="r")
    >>> rack.coupled
    ('x', 'steering')
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`displacement = radius angle + offset`"
    multiplier: ClassVar[str] = "the force on the rack"
    multiplier_unit: ClassVar[str] = "N"
    displacements: ClassVar[int] = 1

    coupled: Coupled = Coupled("The displacement of a joint and the angle of another.")
    radius: Quantity = Quantity(
        "Radius of the pinion; negative if a positive angle moves the rack backward.",
        unit="m",
        fits=_NONZERO,
    )
    offset: Quantity = Quantity(
        "The displacement where the angle is 0.", unit="m", default=0, scope=Scope.PRESCRIBED
    )

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``1, -radius``."""
        return (_ONE, _negative(self.radius))


@final
@element
class Belt(JointCoupling):
    """Two pulleys and a belt that does not slip: ``radius1 first = radius2 second + offset``.

    The multiplier is the pull of the belt at the rim of the first pulley, in the sense of its angle [N].

    Examples
    --------
    >>> import symbody as sb
    >>> belt = sb.Belt("belt", ["alpha", "beta"], radii=("r1", "r2"), crossed=True)
    >>> belt.coupled
    ('alpha', 'beta')
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`radius1 first = radius2 second + offset`; crossed: `- radius2 second`"
    multiplier: ClassVar[str] = "the belt force at the first rim, in the direction of its angle"
    multiplier_unit: ClassVar[str] = "N"

    coupled: Coupled = Coupled("The angles of two joints.")
    radii: Formulas = list_of(
        Quantity("Radii of the pulleys.", unit="m", fits=_PULLEY_RADIUS), 2,
        why="there are two pulleys", fix="give one for each", instead=(1, 1),
    )  # fmt: skip
    crossed: Flag = Flag("Whether the pulleys turn in opposite directions.", default=False)
    offset: Quantity = Quantity(
        "Length of belt unwound from the second pulley where the first angle is 0.",
        unit="m",
        default=0,
        scope=Scope.PRESCRIBED,
    )

    @property
    def factors(self) -> tuple[Formula, ...]:
        """The first radius, and the second with the sign of the belt."""
        first, second = self.radii
        return (first, second if self.crossed else _negative(second))


@final
@element
class Differential(JointCoupling):
    """A differential: the carrier turns by the mean of its two shafts, ``2 carrier = left + right + offset``.

    The multiplier is half the torque on the carrier about its axis [N m].

    Examples
    --------
    >>> import symbody as sb
    >>> axle = sb.Differential("axle", ["carrier", "left", "right"])
    >>> axle.coupled
    ('carrier', 'left', 'right')
    """

    rows: ClassVar[str] = "1"
    holds: ClassVar[str] = "`2 carrier = left + right + offset`"
    multiplier: ClassVar[str] = "half the torque on the carrier"
    multiplier_unit: ClassVar[str] = "N m"

    coupled: Coupled = Coupled("The angles of carrier, left and right shaft.", count=3)
    offset: AngleQuantity = AngleQuantity(
        "Twice the carrier's angle where the shafts are at 0.", unit="rad", default=0, scope=Scope.PRESCRIBED
    )

    @property
    def factors(self) -> tuple[Formula, ...]:
        """``2, -1, -1``."""
        return (Formula.from_value(2), Formula.from_value(-1), Formula.from_value(-1))


@final
@element
class Constraint(ConstraintElement):
    """Equations in coordinates, or affine in speeds.

    One with rates or speeds is a velocity constraint, used unchanged: nonholonomic, unless it is the
    rate of one on positions. The multiplier times the derivative of the equation by a coordinate, or by its
    rate, is the effort along that coordinate.

    Examples
    --------
    >>> import symbody as sb
    >>> parabola = sb.Constraint("parabola", "y - x^2/(2*p)")
    >>> pulley = sb.Constraint("pulley", ["x + 2*y - L", "z_dot - v"])
    >>> len(pulley.equations)
    2
    """

    rows: ClassVar[str] = "their number"
    holds: ClassVar[str] = "each left-hand side is 0"
    multiplier: ClassVar[str] = (
        "times the derivative with respect to a coordinate, or its rate: the force or torque along it"
    )
    word: ClassVar[str] = "equation"

    equations: VanishingFormulas = VanishingFormulas(
        "Left-hand sides that are 0: formulas in coordinates, parameters and t; also in rates and speeds, "
        "if linear in them."
    )


@final
@element
class Stop(ConstraintElement):
    """A gap that never becomes negative: an end stop, a wall, a bumper.

    While the gap is open it does nothing. Where it closes its rate jumps to `restitution` times the opposite,
    and a closed gap opens when its multiplier, which is never negative, comes to zero.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Ball", mass=1), axis="z", coordinate="z")
    >>> floor = sb.Stop("floor", "z", restitution=0.8)
    >>> eqs = sb.form_equations(sb.Model("ball", [rail, floor], gravity=(0, 0, -9.81), initial={"z": 1}))
    >>> sb.simulate(eqs, 10.0).modes[-1].mode
    'closed'
    """

    rows: ClassVar[str] = "1 while it is closed"
    holds: ClassVar[str] = "`gap >= 0`"
    multiplier: ClassVar[str] = "times the derivative of the gap by a coordinate: the effort along it"

    gap: Quantity = Quantity(
        "What is never negative: a formula in coordinates, parameters and t.", scope=Scope.MOTION
    )
    restitution: Quantity = Quantity(
        "Share of the speed with which the gap opens again after an impact.", default=0, fits=RESTITUTION
    )

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind."""
        return ("",) if kind in ("gap", "stop", "mode") else ()


def _negative(formula: Formula) -> Formula:
    return Formula.from_value(f"-({formula.text})")
