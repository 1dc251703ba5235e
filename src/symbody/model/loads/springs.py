"""Springs that turn: `TorsionSpring` about an axis, `Bushing` in all directions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import ClassVar, Final, TypeAlias, final

from symbody.expr.language.formula import Formula
from symbody.model.body import Place, address_from
from symbody.model.door import ZERO, Door, Value
from symbody.model.element import Address, Element
from symbody.model.loads.curve import Law, LawValue, law_from
from symbody.model.loads.forces import SpringDamper, law_uses
from symbody.model.turn import Axis, axis_from
from symbody.model.uses import Scope, Use, triple_uses

# What the law of a torsion spring may read beside the names of loads.
ANGLE: Final = ("angle", "angle_rate")

# The coordinates of a bushing: displacements, then Cardan angles.
BUSHING_COORDINATES: Final = ("x", "y", "z", "rx", "ry", "rz")

Row: TypeAlias = tuple[Formula, ...]
Coefficients: TypeAlias = tuple[Formula | Row, ...]


@final
@dataclass(frozen=True, slots=True, init=False)
class TorsionSpring(Element):
    """A spring and damper about an axis, with opposite torques on two bodies.

    The torque on end is ``applied + law - stiffness*(angle - free) - damping*angle_rate`` along the axis,
    which is fixed in the start frame; `angle_rate` is the component of end's angular velocity relative to
    start along it. Joints about parallel axes between the two count their turns; else the angle is measured
    on the frames, within half a turn of `free`.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects.
    axis : "x", "y", "z" or (3,) number or formula
        In the start frame; of any length. The angle is zero where the frames have the same axes.
    stiffness, damping : number or formula
        [N m/rad], [N m s/rad]
    free : number or formula
        Angle at which the spring is relaxed [rad].
    applied : number or formula
        Further torque on end along the axis [N m].
    law : number, formula or Curve
        Further torque on end, in `angle` and `angle_rate` beside the names of loads; a curve is one over
        the angle [N m].

    Raises
    ------
    ModelError
        With everything that is not a name, a place, an axis or a formula.
    """

    kind: ClassVar[str] = "torsion_spring"

    name: str
    start: Address
    end: Address
    axis: Axis
    stiffness: Formula
    damping: Formula
    free: Formula
    applied: Formula
    law: Law

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        axis: str | Iterable[Value] = "z",
        stiffness: Value = 0,
        damping: Value = 0,
        free: Value = 0,
        applied: Value = 0,
        law: LawValue = 0,
    ) -> None:
        door = Door(f"torsion_spring {name}")
        object.__setattr__(self, "name", door.element_name(name))
        object.__setattr__(self, "start", address_from(door, start, "between[0]"))
        object.__setattr__(self, "end", address_from(door, end, "between[1]"))
        object.__setattr__(self, "axis", axis_from(door, axis, "axis"))
        object.__setattr__(self, "stiffness", door.formula(stiffness, "stiffness"))
        object.__setattr__(self, "damping", door.formula(damping, "damping"))
        object.__setattr__(self, "free", door.angle(free, "free"))
        object.__setattr__(self, "applied", door.formula(applied, "applied"))
        object.__setattr__(self, "law", law_from(door, law, "law"))
        door.close()

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        if not isinstance(self.axis, str):
            yield from triple_uses("axis", self.axis, Scope.CONSTANT)
        yield Use("stiffness", self.stiffness, Scope.LOAD)
        yield Use("damping", self.damping, Scope.LOAD)
        yield Use("free", self.free, Scope.LOAD)
        yield Use("applied", self.applied, Scope.LOAD)
        yield from law_uses("law", self.law, ANGLE)


@final
@dataclass(frozen=True, slots=True, init=False)
class Bushing(Element):
    """A compliance between two frames in all six directions; it prevents nothing, so that no joint is there.

    Its coordinates are those of a free joint with ``angles="xyz"``: the position of end's origin in start
    axes, and the Cardan angles, which for small angles are the rotation vector. Along each acts
    ``-stiffness*(x - free) - damping*x_dot``, with the opposite wrench on start. It is singular where the
    second angle is a quarter turn.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    start, end : Body, frame or name
        The frames it connects.
    stiffness, damping : (6,) or (6, 6) number or formula
        Along x, y, z and about x, y, z [N/m, N m/rad], [N s/m, N m s/rad]; a matrix couples them.
    free : (6,) number or formula
        Position [m] and angles [rad] at which it is relaxed.

    Raises
    ------
    ModelError
        With everything that is not a name, a place or a formula.
    """

    kind: ClassVar[str] = "joint"

    name: str
    start: Address
    end: Address
    stiffness: Coefficients
    damping: Coefficients
    free: Row

    def __init__(
        self,
        name: str,
        start: Place,
        end: Place,
        stiffness: Iterable[Value] | Iterable[Iterable[Value]] = (0, 0, 0, 0, 0, 0),
        damping: Iterable[Value] | Iterable[Iterable[Value]] = (0, 0, 0, 0, 0, 0),
        free: Iterable[Value] = (0, 0, 0, 0, 0, 0),
    ) -> None:
        door = Door(f"joint {name}")
        object.__setattr__(self, "name", door.element_name(name))
        object.__setattr__(self, "start", address_from(door, start, "between[0]"))
        object.__setattr__(self, "end", address_from(door, end, "between[1]"))
        object.__setattr__(self, "stiffness", _coefficients(door, stiffness, "stiffness"))
        object.__setattr__(self, "damping", _coefficients(door, damping, "damping"))
        object.__setattr__(self, "free", _row(door, free, "free", door.angle))
        door.close()

    @property
    def stiffness_rows(self) -> tuple[Row, ...]:
        """The stiffness as a matrix."""
        return _matrix(self.stiffness)

    @property
    def damping_rows(self) -> tuple[Row, ...]:
        """The damping as a matrix."""
        return _matrix(self.damping)

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        words = (("stiffness", self.stiffness), ("damping", self.damping), ("free", self.free))
        for path, value in words:
            for k, item in enumerate(value):
                if isinstance(item, Formula):
                    yield Use(f"{path}[{k}]", item, Scope.LOAD)
                else:
                    yield from triple_uses(f"{path}[{k}]", item, Scope.LOAD)


# What gives way between two frames.
Spring: TypeAlias = SpringDamper | TorsionSpring | Bushing


def _coefficients(door: Door, values: object, path: str) -> Coefficients:
    """Return six coefficients, or six rows of six."""
    items = door.items(values, path)
    if not any(isinstance(item, Iterable) and not isinstance(item, str) for item in items):
        return _row(door, items, path, door.formula)
    if len(items) != len(BUSHING_COORDINATES):
        _refuse_length(door, path, len(items))
    return tuple(_row(door, item, f"{path}[{k}]", door.formula) for k, item in enumerate(items))


def _row(door: Door, values: object, path: str, read: Callable[[object, str], Formula]) -> Row:
    items = door.items(values, path)
    if len(items) != len(BUSHING_COORDINATES):
        _refuse_length(door, path, len(items))
        return (ZERO,) * len(BUSHING_COORDINATES)
    return tuple(read(item, f"{path}[{k}]") for k, item in enumerate(items))


def _refuse_length(door: Door, path: str, length: int) -> None:
    door.refuse(
        "model.not_six",
        path,
        f"{length} entries instead of six",
        "a bushing gives way along x, y, z and about x, y, z",
        "give six entries, or six rows of six",
    )


def _matrix(values: Coefficients) -> tuple[Row, ...]:
    """Return the rows of a matrix of which, perhaps, the diagonal alone is given."""
    width = range(len(values))
    return tuple(
        tuple(item if j == k else ZERO for j in width) if isinstance(item, Formula) else item
        for k, item in enumerate(values)
    )
