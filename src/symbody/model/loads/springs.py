"""Springs that turn: `TorsionSpring` about an axis, `Bushing` in all directions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import ClassVar, Final, TypeAlias, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value
from symbody.model.declarations.declaration import Field
from symbody.model.declarations.element_fields import Connection, element
from symbody.model.declarations.fields import AngleQuantity, Direction, Quantity
from symbody.model.declarations.formula_site import FormulaSite, Scope, component_sites
from symbody.model.loads.curve import SpringLaw
from symbody.model.loads.forces import SpringDamper
from symbody.model.numeric_checks import NumericChecks, note_negative

# What the law of a torsion spring may read beside the names of loads.
ANGLE: Final = ("angle", "angle_rate")

# The coordinates of a bushing: displacements, then Cardan angles.
BUSHING_COORDINATES: Final = ("x", "y", "z", "rx", "ry", "rz")

Row: TypeAlias = tuple[Formula, ...]
Coefficients: TypeAlias = tuple[Formula | Row, ...]
_NONE: Final = (0, 0, 0, 0, 0, 0)


class SixOrMatrix(Field[Iterable[Value] | Iterable[Iterable[Value]], Coefficients]):
    """Six coefficients, or six rows of six."""

    role: ClassVar[str] = "six"
    takes: ClassVar[str] = "(6,) or (6, 6) number or formula"
    annotation: ClassVar[str] = "Iterable[Value] | Iterable[Iterable[Value]]"
    explanation: ClassVar[str] = "Values along x, y, z and about x, y, z; a 6 x 6 matrix couples them."

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Coefficients:
        """Return six formulas, or rows of them."""
        items = arguments.items(value, path)
        if not any(isinstance(item, Iterable) and not isinstance(item, str) for item in items):
            return _row(arguments, items, path, arguments.formula)
        if len(items) != len(BUSHING_COORDINATES):
            _refuse_length(arguments, path, len(items))
        return tuple(_row(arguments, item, f"{path}[{k}]", arguments.formula) for k, item in enumerate(items))

    def formula_sites(self, owner: object, value: Coefficients, path: str) -> Iterator[FormulaSite]:
        """Return where the coefficients stand."""
        for k, item in enumerate(value):
            if isinstance(item, Formula):
                yield FormulaSite(f"{path}[{k}]", item, Scope.LOAD)
            else:
                yield from component_sites(f"{path}[{k}]", item, Scope.LOAD)


class Six(Field[Iterable[Value], Row]):
    """Three lengths and three angles."""

    role: ClassVar[str] = "six"
    takes: ClassVar[str] = "(6,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Row:
        """Return six formulas."""
        return _row(arguments, value, path, arguments.formula)

    def formula_sites(self, owner: object, value: Row, path: str) -> Iterator[FormulaSite]:
        """Return where the values stand."""
        return component_sites(path, value, Scope.LOAD)


@final
@element
class TorsionSpring(Connection):
    """A spring and damper about an axis, with opposite torques on two bodies.

    The torque on end is ``applied + law - stiffness*(angle - free) - damping*angle_rate`` along the axis,
    which is fixed in the start frame; `angle_rate` is the component of end's angular velocity relative to
    start along it. The angle is zero where the frames have the same axes. Joints about parallel axes between
    the two count their turns; else the angle is measured on the frames, within half a turn of `free`.
    """

    equation: ClassVar[str] = (
        "applied + law - stiffness (angle - free) - damping angle_rate about `axis`, fixed in start"
    )
    sign: ClassVar[str] = "positive turns the end in the positive direction about the axis"
    outputs: ClassVar[str] = "`angle S`, `effort S`"
    kind: ClassVar[str] = "torsion_spring"

    axis: Direction = Direction("In the start frame.", default="z")
    stiffness: Quantity = Quantity(unit="N m/rad", default=0, scope=Scope.LOAD, fits=note_negative)
    damping: Quantity = Quantity(unit="N m s/rad", default=0, scope=Scope.LOAD, fits=note_negative)
    free: AngleQuantity = AngleQuantity(
        "Angle at which it is relaxed.", unit="rad", default=0, scope=Scope.LOAD
    )
    applied: Quantity = Quantity(
        "Additional torque on the end along the axis.", unit="N m", default=0, scope=Scope.LOAD
    )
    law: SpringLaw = SpringLaw(
        "Additional torque on the end, a formula in angle and angle_rate; a curve is a function of the "
        "angle.",
        unit="N m",
        default=0,
        own=ANGLE,
    )


@final
@element
class Bushing(Connection):
    """A compliance between two frames in all six directions; it constrains no motion, so there is no joint.

    Its coordinates are those of a free joint with ``angles="xyz"``: the position of end's origin in start
    axes, and the Cardan angles, which for small angles are the rotation vector. Along each acts
    ``-stiffness*(x - free) - damping*x_dot``, with the opposite wrench on start. It is singular where the
    second angle is a quarter turn.
    """

    equation: ClassVar[str] = (
        "-stiffness (x - free) - damping x' in six coordinates; six values or a 6 x 6 matrix"
    )
    sign: ClassVar[str] = "forces and torques on the end along the coordinates"
    outputs: ClassVar[str] = "`length B x` `y` `z`, `angle B rx` `ry` `rz`, `effort B x` .. `rz`"
    kind: ClassVar[str] = "joint"

    stiffness: SixOrMatrix = SixOrMatrix(unit="N/m, N m/rad", default=_NONE)
    damping: SixOrMatrix = SixOrMatrix(unit="N s/m, N m s/rad", default=_NONE)
    free: Six = Six("Position [m] and angles [rad] at which it is relaxed.", default=_NONE)

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Reject a bushing of a body on itself; remark on negative coefficients of its own directions."""
        if self.start.body == self.end.body:
            check.refuse(
                "model.self_joint",
                f"{label}, between",
                f"both ends are on {self.start.body}",
                "a bushing connects two bodies",
                "put one end on another body, or on ground",
            )
        for word, rows in (("stiffness", self.stiffness_rows), ("damping", self.damping_rows)):
            for k, row in enumerate(rows):
                values = [check.value(formula, f"{label}, {word}[{k}]") for formula in row]
                diagonal = values[k]
                if diagonal is not None and diagonal < 0:
                    check.note(f"{label}: the {word} {row[k]} is negative ({diagonal:g})")

    @property
    def stiffness_rows(self) -> tuple[Row, ...]:
        """The stiffness as a matrix."""
        return _matrix(self.stiffness)

    @property
    def damping_rows(self) -> tuple[Row, ...]:
        """The damping as a matrix."""
        return _matrix(self.damping)


# What gives way between two frames.
Spring: TypeAlias = SpringDamper | TorsionSpring | Bushing


def _row(arguments: Arguments, values: object, path: str, read: Callable[[object, str], Formula]) -> Row:
    items = arguments.items(values, path)
    if len(items) != len(BUSHING_COORDINATES):
        _refuse_length(arguments, path, len(items))
        return (ZERO,) * len(BUSHING_COORDINATES)
    return tuple(read(item, f"{path}[{k}]") for k, item in enumerate(items))


def _refuse_length(arguments: Arguments, path: str, length: int) -> None:
    arguments.add(
        "model.not_six",
        path,
        f"{length} entries instead of six",
        "a bushing is elastic along x, y, z and about x, y, z",
        "give six entries, or a 6 x 6 matrix",
    )


def _matrix(values: Coefficients) -> tuple[Row, ...]:
    """Return the rows of a matrix of which, perhaps, the diagonal alone is given."""
    width = range(len(values))
    return tuple(
        tuple(item if j == k else ZERO for j in width) if isinstance(item, Formula) else item
        for k, item in enumerate(values)
    )
