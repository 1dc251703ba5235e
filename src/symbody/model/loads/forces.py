"""Drives of joint coordinates, forces and torques, springs along a line or an axis, and bushings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from types import MappingProxyType
from typing import Any, ClassVar, Final, TypeAlias, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO, Arguments, Value
from symbody.model.declarations.combinators import ListOf
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.element_fields import AttachedFrame, Connection, element
from symbody.model.declarations.field import Field, FileTarget, NewNames, Node
from symbody.model.declarations.fields import (
    AngleQuantity,
    Direction,
    Flag,
    Quantity,
    Refusal,
    VectorQuantity,
    part,
)
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import (
    FORMULA_SCHEMA,
    Misfit,
    Path,
    Schema,
    formula_misfits,
    list_misfits,
    wrong_type,
)
from symbody.model.element import Element
from symbody.model.loads.curve import Curve, SpringLaw
from symbody.model.numeric_checks import NumericChecks, note_negative

# What the law of a spring between points may read beside the names of loads.
LENGTH: Final = ("length", "length_rate")


@final
@part
class Drive(Declared):
    """What acts along a joint coordinate: ``applied + law - stiffness*(x - free) - damping*x_dot``.

    Examples
    --------
    >>> import symbody as sb
    >>> drive = sb.Drive(applied="T", stiffness="k", damping="c", free="30 deg")
    >>> joint = sb.Revolute("hinge", "ground", "Flap", coordinate="phi", torque=drive)
    >>> drive.free.text
    '30 deg'
    """

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
    """A force at a point, and its reaction, which acts at the same point.

    Examples
    --------
    >>> import symbody as sb
    >>> arm = sb.Body("Arm", mass="m", frames={"tip": sb.Frame(at=("L", 0, 0))})
    >>> push = sb.Force("push", arm["tip"], ("F", 0, 0), resolved_in=arm)
    >>> [str(value) for value in push.vector]
    ['F', '0', '0']
    """

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
    """A torque on a body, and its reaction.

    Examples
    --------
    >>> import symbody as sb
    >>> spin = sb.Torque("motor", "Rotor", (0, 0, "T"), reaction_on="Stator")
    >>> [str(value) for value in spin.vector]
    ['0', '0', 'T']
    """

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

    Examples
    --------
    >>> import symbody as sb
    >>> spring = sb.SpringDamper("spring", "ground", "Mass", stiffness="k", damping="c", free="L0")
    >>> hard = sb.SpringDamper("hard", "ground", "Mass", law="-k3*(length - L0)^3")
    >>> spring.free.text
    'L0'
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


# What the law of a torsion spring may read beside the names of loads.
ANGLE: Final = ("angle", "angle_rate")

# The coordinates of a bushing: displacements, then Cardan angles.
BUSHING_COORDINATES: Final = ("x", "y", "z", "rx", "ry", "rz")

Row: TypeAlias = tuple[Formula, ...]
Coefficients: TypeAlias = tuple[Formula | Row, ...]
_NONE: Final = (0, 0, 0, 0, 0, 0)


_ROW: Final = {"type": "array", "items": FORMULA_SCHEMA, "minItems": 6, "maxItems": 6}
_SIX_OR_MATRIX: Final[Schema] = {"anyOf": [_ROW, {**_ROW, "items": _ROW}]}


def _six(arguments: Arguments, value: object, path: str) -> Iterable[object]:
    """Return six entries; zeros stand for another number."""
    items = arguments.items(value, path)
    if len(items) == len(_NONE):
        return items
    what = f"{len(items)} entries instead of six"
    why = "a bushing is elastic along x, y, z and about x, y, z"
    arguments.add("model.not_six", path, what, why, "give six entries, or a 6 x 6 matrix")
    return _NONE


def _six_misfits(entry: object, path: Path) -> Iterable[Misfit]:
    if not isinstance(entry, list) or len(entry) != len(_NONE):
        return wrong_type(entry, path, "six numbers or expressions, or six rows of six")
    rows = [item for item in entry if isinstance(item, list)]
    if any(len(row) != len(_NONE) for row in rows):
        return wrong_type(entry, path, "rows of six numbers or expressions")
    if not rows:
        return list_misfits(entry, path, formula_misfits)
    return list_misfits(entry, path, lambda row, place: list_misfits(row, place, formula_misfits))


@dataclass(frozen=True, eq=False, repr=False)
class Six(ListOf[Iterable[Value], Row]):
    """Three lengths and three angles, or one row of a matrix."""

    role: ClassVar[str] = "six"
    takes: ClassVar[str] = "(6,) number or formula"
    annotation: ClassVar[str] = "Iterable[Value]"

    _: KW_ONLY
    item: Any = field(default_factory=lambda: Quantity(scope=Scope.LOAD))

    def items(self, arguments: Arguments, value: object, path: str) -> Iterable[object]:
        """Return six values."""
        return _six(arguments, value, path)

    def schema(self) -> Schema:
        """Return what a file may have: `read` takes six values of it."""
        return _SIX_OR_MATRIX

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of six values, or of six rows."""
        return _six_misfits(entry, path)


class SixOrMatrix(Field[Iterable[Value] | Iterable[Iterable[Value]], Coefficients]):
    """Six coefficients, or six rows of six."""

    role: ClassVar[str] = "six"
    takes: ClassVar[str] = "(6,) or (6, 6) number or formula"
    annotation: ClassVar[str] = "Iterable[Value] | Iterable[Iterable[Value]]"
    explanation: ClassVar[str] = "Values along x, y, z and about x, y, z; a 6 x 6 matrix couples them."

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Coefficients:
        """Return six formulas, or rows of them."""
        items = list(_six(arguments, value, path))
        has_rows = any(isinstance(item, Iterable) and not isinstance(item, str) for item in items)
        role: Field[Any, Any] = _LINE if has_rows else _VALUE
        return tuple(role.read(owner, arguments, item, f"{path}[{k}]") for k, item in enumerate(items))

    def schema(self) -> Schema:
        """Return six formulas, or six rows of six."""
        return _LINE.schema()

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of six values, or of six rows."""
        return _LINE.misfits(entry, path)

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return six formulas, or rows of them."""
        return [list(item) if isinstance(item, tuple) else item for item in value]

    def rename(self, value: Any, names: NewNames) -> Coefficients:
        """Return the formulas in the new names."""
        return tuple(_role_of(item).rename(item, names) for item in value)

    def parts(self, owner: object, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the coefficients or rows."""
        return ((_role_of(item), item, f"{path}[{k}]") for k, item in enumerate(value))


_VALUE: Final = Quantity(scope=Scope.LOAD)
_LINE: Final = Six()


def _role_of(item: Formula | Row) -> Field[Any, Any]:
    return _LINE if isinstance(item, tuple) else _VALUE


@final
@element
class TorsionSpring(Connection):
    """A spring and damper about an axis, with opposite torques on two bodies.

    The torque on end is ``applied + law - stiffness*(angle - free) - damping*angle_rate`` along the axis,
    which is fixed in the start frame; `angle_rate` is the component of end's angular velocity relative to
    start along it. The angle is zero where the frames have the same axes. Joints about parallel axes between
    the two count their turns; else the angle is measured on the frames, within half a turn of `free`.

    Examples
    --------
    >>> import symbody as sb
    >>> spring = sb.TorsionSpring("spring", "ground", "Door", axis="z", stiffness="k", free="90 deg")
    >>> spring.free.text
    '90 deg'
    """

    equation: ClassVar[str] = (
        "applied + law - stiffness (angle - free) - damping angle_rate about `axis`, fixed in start"
    )
    sign: ClassVar[str] = "positive turns the end in the positive direction about the axis"
    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType({"angle": ("",), "effort": ("",)})
    effort_unit: ClassVar[str] = "N m"
    group: ClassVar[str] = "Springs and dampers"
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

    Examples
    --------
    >>> import symbody as sb
    >>> mount = sb.Bushing("mount", "ground", "Engine", stiffness=(2e5, 2e5, 1e5, 50, 50, 50))
    >>> [str(value) for value in mount.stiffness[3:]]
    ['50', '50', '50']
    """

    equation: ClassVar[str] = (
        "-stiffness (x - free) - damping x' in six coordinates; six values or a 6 x 6 matrix"
    )
    sign: ClassVar[str] = "forces and torques on the end along the coordinates"
    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {
            "length": BUSHING_COORDINATES[:3],
            "angle": BUSHING_COORDINATES[3:],
            "effort": BUSHING_COORDINATES,
        }
    )
    effort_unit: ClassVar[str] = "N, N m"
    kind: ClassVar[str] = "joint"
    on_one_body: ClassVar[Refusal | None] = Refusal(
        "model.self_joint", what="both ends are on {value}", fix="put one end on another body, or on ground",
        why="a bushing connects two bodies",
    )  # fmt: skip

    stiffness: SixOrMatrix = SixOrMatrix(unit="N/m, N m/rad", default=_NONE)
    damping: SixOrMatrix = SixOrMatrix(unit="N s/m, N m s/rad", default=_NONE)
    free: Six = Six("Position [m] and angles [rad] at which it is relaxed.", default=_NONE)

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Remark on negative coefficients of its own directions."""
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


def _matrix(values: Coefficients) -> tuple[Row, ...]:
    """Return the rows of a matrix of which, perhaps, the diagonal alone is given."""
    width = range(len(values))
    return tuple(
        tuple(item if j == k else ZERO for j in width) if isinstance(item, Formula) else item
        for k, item in enumerate(values)
    )
