"""Drives of joint coordinates, and forces, torques and springs between frames."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.declaration import ElementPart
from symbody.model.declarations.element_fields import AttachedFrame, Connection, element
from symbody.model.declarations.fields import AngleQuantity, Flag, Quantity, VectorQuantity, part
from symbody.model.declarations.formula_site import Scope
from symbody.model.element import Element
from symbody.model.loads.curve import Curve, SpringLaw
from symbody.model.numeric_checks import note_negative

# What the law of a spring between points may read beside the names of loads.
LENGTH: Final = ("length", "length_rate")


@final
@part
class Drive(ElementPart):
    """What acts along a joint coordinate: ``applied + law - stiffness*(x - free) - damping*x_dot``."""

    equation: ClassVar[str] = "applied + law - stiffness (x - free) - damping x'"
    sign: ClassVar[str] = "positive drives the end along the positive coordinate"
    outputs: ClassVar[str] = "`effort J`, or `effort J x` for several coordinates"

    applied: Quantity = Quantity(
        "Applied force or torque on the end body.", unit="N, N m", default=0, scope=Scope.LOAD
    )
    stiffness: Quantity = Quantity(unit="N/m, N m/rad", default=0, scope=Scope.LOAD, fits=note_negative)
    damping: Quantity = Quantity(unit="N s/m, N m s/rad", default=0, scope=Scope.LOAD, fits=note_negative)
    free: AngleQuantity = AngleQuantity(
        "Value of the coordinate at which the spring is relaxed.", unit="m, rad", default=0, scope=Scope.LOAD
    )
    law: SpringLaw = SpringLaw(
        "Additional force or torque; a curve is a function of the coordinate.", unit="N, N m", default=0
    )

    @property
    def reads_coordinate(self) -> bool:
        """Whether the effort depends on the coordinate itself, by spring or curve."""
        return self.stiffness.constant() != 0 or isinstance(self.law, Curve)


@final
@element
class Force(Element):
    """A force at a point, and its reaction, which acts at the same point."""

    equation: ClassVar[str] = "vector at the point `on`, in the axes of `resolved_in`"
    sign: ClassVar[str] = "the opposite force acts on `reaction_on` at the same point"
    group: ClassVar[str] = "Forces and torques"
    kind: ClassVar[str] = "force"

    on: AttachedFrame = AttachedFrame("The point where the force acts.")
    vector: VectorQuantity = VectorQuantity("Components.", unit="N", scope=Scope.LOAD)
    resolved_in: AttachedFrame = AttachedFrame(
        "The frame in whose axes the components are given.", default="ground"
    )
    reaction_on: AttachedFrame = AttachedFrame("The body on which the opposite force acts.", default="ground")


@final
@element
class Torque(Element):
    """A torque on a body, and its reaction."""

    equation: ClassVar[str] = "vector on `on`"
    sign: ClassVar[str] = "the opposite torque acts on `reaction_on`"
    group: ClassVar[str] = "Forces and torques"
    kind: ClassVar[str] = "torque"

    on: AttachedFrame = AttachedFrame("The body on which the torque acts.")
    vector: VectorQuantity = VectorQuantity("Components.", unit="N m", scope=Scope.LOAD)
    resolved_in: AttachedFrame = AttachedFrame(
        "The frame in whose axes the components are given.", default="ground"
    )
    reaction_on: AttachedFrame = AttachedFrame(
        "The body on which the opposite torque acts.", default="ground"
    )


@final
@element
class SpringDamper(Connection):
    """A spring and damper between two points: on their line, or in all directions alike.

    A free length of exactly 0 makes the spring a vector law, smooth at length 0; the damper acts on the line,
    which has no direction there. With `isotropic` both are vector laws: ``-stiffness r - damping v`` on end,
    the opposite on start, with r the position of end relative to start and v the difference of their
    velocities as seen from ground, so that a turn of both bodies together is damped too.
    """

    equation: ClassVar[str] = (
        "applied + law - stiffness (length - free) - damping length' along the line; "
        "`isotropic`: the vector -stiffness r - damping r' on end, r' as seen from ground"
    )
    sign: ClassVar[str] = "positive pushes the ends apart; `free` exactly 0: vector law, smooth at length 0"
    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({"length": ("",), "effort": ("",)})
    effort_unit: ClassVar[str] = "N"
    group: ClassVar[str] = "Springs and dampers"
    kind: ClassVar[str] = "spring"

    stiffness: Quantity = Quantity(unit="N/m", default=0, scope=Scope.LOAD, fits=note_negative)
    damping: Quantity = Quantity(unit="N s/m", default=0, scope=Scope.LOAD, fits=note_negative)
    free: Quantity = Quantity("Length at which it is relaxed.", unit="m", default=0, scope=Scope.LOAD)
    applied: Quantity = Quantity(
        "Additional force that pushes the ends apart.", unit="N", default=0, scope=Scope.LOAD
    )
    law: SpringLaw = SpringLaw(
        "Additional force that pushes the ends apart, a formula in length and length_rate; a curve is a "
        "function of the length.",
        unit="N",
        default=0,
        own=LENGTH,
    )
    isotropic: Flag = Flag(
        "Whether spring and damper act equally in all directions, not only along the line.",
        default=False,
    )

    def check(self, arguments: Arguments) -> None:
        """Note what an isotropic spring, which has no line, cannot have."""
        given = {"free": self.free, "applied": self.applied, "law": self.law}
        lost = [
            name for name, value in given.items() if isinstance(value, Curve) or value.constant() != 0
        ] if self.isotropic else []  # fmt: skip
        for name in lost:
            why = "its force is -stiffness r - damping v for any direction of r"
            fix = f"remove {name} or isotropic, or add a second spring in parallel"
            arguments.add("model.isotropic", name, f"an isotropic spring has no {name}", why, fix)
