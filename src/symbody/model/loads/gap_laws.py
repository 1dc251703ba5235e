"""`Limits` of a joint coordinate and `Backlash` of a gear: gaps that a rigid stop or a force keeps open."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final, final

from symbody.expr.language.formula import Formula
from symbody.model.contacts.normal_force import GAP, NormalForce
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import OptionalField, optional
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.fields import (
    AngleQuantity,
    DeclaredPart,
    Flag,
    OptionalQuantity,
    P,
    Quantity,
    part,
    read_part,
)
from symbody.model.declarations.formula_site import Scope
from symbody.model.loads.curve import Law, LawValue, SpringLaw
from symbody.model.numeric_checks import Domain, NumericChecks

LOW: Final = "low"
HIGH: Final = "high"

# Of a stop.
RESTITUTION: Final = Domain(
    "model.restitution", "restitution is {value}", "it is the share of the speed left after an impact",
    "give a number from 0 to 1", 0.0, most=1.0,
)  # fmt: skip
_WIDTH: Final = Domain(
    "model.backlash",
    "the backlash {formula} is {value} rad",
    "it is the play of the teeth",
    "give 0 or more",
    0.0,
)

# Arguments that limits and backlash share: those of a stop, and those of `NormalForce`.
_RIGID: Final = Flag("Whether nothing gives way: an impact by Poisson's law ends the motion.", default=False)
_STIFFNESS: Final = optional(
    Quantity("Of the force beyond the end; with an exponent n in N/m^n or N m/rad^n.", unit="N/m, N m/rad",
             scope=Scope.LOAD)
)  # fmt: skip
_EXPONENT: Final = Quantity("Of the distance beyond the end.", default=1)
_DISSIPATION: Final = optional(
    Quantity("Factor of the rate in Hunt and Crossley's law.", unit="s/m, s/rad", scope=Scope.LOAD)
)
_RESTITUTION: Final = optional(
    Quantity("Speed after an impact over that before: of a rigid end (default 0), or at `speed`.")
)
_SPEED: Final = optional(
    Quantity("Speed of the impact for which the restitution of a compliant end is given.", unit="m/s, rad/s")
)
_DAMPING: Final = optional(
    Quantity("Of a damper besides the spring.", unit="N s/m, N m s/rad", scope=Scope.LOAD)
)
_DEPTH: Final = optional(
    Quantity("Distance beyond the end from which on the damper is at its full strength.", unit="m, rad")
)
_LAW: Final = optional(
    SpringLaw("The force itself, a formula in gap and gap_rate; a curve is a function of the distance beyond "
              "the end.", unit="N, N m", own=GAP)
)  # fmt: skip

_OF_FORCE: Final = tuple(NormalForce.fields)
_CURE: Final = (
    "write rigid = true, with restitution if it bounces; or stiffness, alone, with dissipation, with "
    "restitution and speed, or with damping; or law alone"
)


class GapLaw(Declared):
    """What keeps gaps open: rigid stops, or forces by the law of `NormalForce`.

    A concrete one declares its arguments, `rigid` and those of `NormalForce` among them.
    """

    __slots__ = ()

    @property
    def rigid(self) -> bool:
        """Whether nothing gives way."""
        return False

    @property
    def restitution(self) -> Formula | None:
        """Speed after an impact over that before."""
        return None

    @property
    def normal(self) -> NormalForce:
        """The force of one that is not rigid."""
        return NormalForce(**{name: getattr(self, name) for name in _OF_FORCE})

    def gaps(self, x: str) -> Iterator[tuple[str, Formula]]:
        """Yield each end with the gap that it keeps open.

        Parameters
        ----------
        x : str
            What has limits, as a formula.
        """
        raise NotImplementedError

    def check(self, arguments: Arguments) -> None:
        """Note laws that are missing or mixed."""
        lost = [
            name for name in _OF_FORCE
            if name not in ("exponent", "restitution") and getattr(self, name) is not None
        ]  # fmt: skip
        if self.rigid:
            if lost:
                what, why = f"rigid and {', '.join(lost)} are given", "a rigid end has no force of its own"
                arguments.add("model.gap_law", lost[0], what, why, _CURE)
        elif not {"stiffness", "law"}.intersection(lost):
            what, why = "neither a stiffness nor rigid is given", "nothing stops the motion at the end"
            arguments.add("model.gap_law", "stiffness", what, why, _CURE)
        else:
            arguments.attempt(lambda: self.normal)

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers that cannot be."""
        Declared.check_numbers(self, check, label)
        if self.rigid and self.restitution is not None:
            RESTITUTION(check, self.restitution, f"{label}.restitution")
        elif not self.rigid:
            self.normal.check_numbers(check, label)


@final
@part
class Limits(GapLaw):
    """The ends of a joint coordinate: rigid, or a force that pushes it back.

    Rigid ends are stops, which are named after the joint and the end, ``slider high``; of a joint with
    several coordinates after the coordinate too. Beyond a compliant end the law of `NormalForce` acts along
    the coordinate.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), coordinate="x",
    ...                     limits=sb.Limits(0, "L", rigid=True, restitution=0.5))
    >>> [stop.name for stop in sb.Model("cart", [rail], parameters={"L": 1}).constraints]
    ['rail low', 'rail high']
    """

    equation: ClassVar[str] = (
        "low <= x <= high; or beyond an end, with the gap x - low or high - x, the law of `NormalForce`"
    )
    sign: ClassVar[str] = "pushes back, never pulls"
    outputs: ClassVar[str] = "in `effort J`; of rigid ones `gap J high`, `opening_effort J high`"

    low: OptionalQuantity = optional(
        AngleQuantity("Least value of the coordinate.", unit="m, rad", scope=Scope.PRESCRIBED)
    )
    high: OptionalQuantity = optional(
        AngleQuantity("Greatest value of the coordinate.", unit="m, rad", scope=Scope.PRESCRIBED)
    )
    rigid: Flag = _RIGID
    stiffness: OptionalQuantity = _STIFFNESS
    exponent: Quantity = _EXPONENT
    dissipation: OptionalQuantity = _DISSIPATION
    restitution: OptionalQuantity = _RESTITUTION
    speed: OptionalQuantity = _SPEED
    damping: OptionalQuantity = _DAMPING
    depth: OptionalQuantity = _DEPTH
    law: OptionalField[LawValue, Law] = _LAW

    @property
    def ends(self) -> tuple[Formula, ...]:
        """The bounds that are given."""
        return tuple(end for end in (self.low, self.high) if end is not None)

    def gaps(self, x: str) -> Iterator[tuple[str, Formula]]:
        """Yield each end with the gap that it keeps open."""
        if self.low is not None:
            yield LOW, Formula.from_value(f"{x} - ({self.low.text})")
        if self.high is not None:
            yield HIGH, Formula.from_value(f"({self.high.text}) - {x}")

    def check(self, arguments: Arguments) -> None:
        """Note limits without an end, and laws that are missing or mixed."""
        if not self.ends:
            why = "neither low nor high is given"
            arguments.add("model.limits", "high", "the limits have no end", why, "give low, high, or both")
        GapLaw.check(self, arguments)

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note numbers that cannot be, and ends in the wrong order."""
        GapLaw.check_numbers(self, check, label)
        values = [
            None if end is None or "t" in end.names else check.value(end, f"{label}.{word}")
            for word, end in ((LOW, self.low), (HIGH, self.high))
        ]
        low, high = values
        if low is not None and high is not None and low > high:
            what, why = f"low = {low:g} is above high = {high:g}", "no value of the coordinate is within them"
            check.refuse("model.limits", f"{label}.low", what, why, "exchange them")


@final
@part
class Backlash(GapLaw):
    """The play of teeth: the first wheel may turn by `angle` while the second is held.

    Within the play, ``abs(first - ratio second - offset) < angle/2``, the wheels turn freely. At its ends the
    teeth meet: rigid, or by the law of `NormalForce` with the angle by which they overlap.

    Examples
    --------
    >>> import symbody as sb
    >>> play = sb.Backlash("0.5 deg", stiffness="k", damping="c")
    >>> gear = sb.Gear("stage", ["motor", "output"], ratio=-3, backlash=play)
    >>> play.angle.text
    '0.5 deg'
    """

    equation: ClassVar[str] = (
        "-angle/2 <= first - ratio second - offset <= angle/2; or beyond an end the law of `NormalForce`"
    )
    sign: ClassVar[str] = "the torque on the first wheel"
    outputs: ClassVar[str] = "`effort G`; of a rigid one `gap G high`, `opening_effort G high`"

    angle: AngleQuantity = AngleQuantity(
        "By which the first wheel may turn while the second is held.", unit="rad", fits=_WIDTH
    )
    rigid: Flag = _RIGID
    stiffness: OptionalQuantity = _STIFFNESS
    exponent: Quantity = _EXPONENT
    dissipation: OptionalQuantity = _DISSIPATION
    restitution: OptionalQuantity = _RESTITUTION
    speed: OptionalQuantity = _SPEED
    damping: OptionalQuantity = _DAMPING
    depth: OptionalQuantity = _DEPTH
    law: OptionalField[LawValue, Law] = _LAW

    def gaps(self, x: str) -> Iterator[tuple[str, Formula]]:
        """Yield each end with the gap that it keeps open."""
        yield LOW, Formula.from_value(f"({self.angle.text})/2 + ({x})")
        yield HIGH, Formula.from_value(f"({self.angle.text})/2 - ({x})")


@dataclass(frozen=True, eq=False, repr=False)
class GapLawPart(DeclaredPart[P]):
    """A part with gaps, or a mapping of its arguments."""

    def __post_init__(self) -> None:
        """Take over the name of the class."""
        DeclaredPart.__post_init__(self)
        object.__setattr__(self, "takes", f"{self.kind.__name__} or mapping")
        object.__setattr__(self, "annotation", f"{self.kind.__name__}Like")

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> P:
        """Return the part; one that does nothing stands for something else."""
        kind: type[P] = self.kind
        if isinstance(value, kind):
            return value
        made: P | None = None
        if isinstance(value, Mapping):
            make: Callable[..., P] = kind
            named = {str(word): item for word, item in value.items()}
            made = arguments.attempt(lambda: make(**named), path)
        else:
            code, what, fix, why = self.refusal
            arguments.add(code, path, what.format(value=repr(value)), why, fix)
        return _harmless(kind) if made is None else made

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the part that a table describes; one that does nothing for a table with faults."""
        kind: type[P] = self.kind
        return read_part(kind, entry, arguments, path, folder) or _harmless(kind)


def _harmless(kind: type[P]) -> P:
    """Return limits or backlash that stand for those with faults."""
    make: Callable[..., P] = kind
    return make(**{next(iter(kind.fields)): 0}, rigid=True)
