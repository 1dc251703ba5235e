"""`NormalForce`: the force of a contact along its normal, a law of the gap and its rate."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, final

from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import OptionalField, optional
from symbody.model.declarations.declaration import Declared
from symbody.model.declarations.field import Field, FileTable, FileTarget, NewNames, Node
from symbody.model.declarations.fields import DeclaredPart, OptionalQuantity, Quantity, part, read_part
from symbody.model.declarations.formula_site import Scope
from symbody.model.declarations.misfits import Misfit, Path, Schema
from symbody.model.loads.curve import Law, LawValue, SpringLaw
from symbody.model.numeric_checks import Domain

RIGID: Final = "rigid"  # in place of a law
# What a law of the user may read beside the names of loads.
GAP: Final = ("gap", "gap_rate")

_STIFFNESS: Final = Domain(
    "contact.domain", "the stiffness is {value}", "what touches is pushed apart",
    "give 0 or more, in N/m^exponent", 0.0,
)  # fmt: skip
_EXPONENT: Final = Domain(
    "contact.domain", "the exponent {formula} is {value}",
    "below 1 the stiffness is infinite where the shapes begin to touch",
    "give 1 for a linear law, 1.5 for spheres (Hertz), or more", 1.0,
)  # fmt: skip
_DISSIPATION: Final = Domain(
    "contact.domain", "{formula} is {value}", "it would make energy", "give 0 or more", 0.0
)
_RESTITUTION: Final = Domain(
    "contact.domain", "the restitution {formula} is {value}",
    "it is the speed after an impact over that before; no finite dissipation makes it 0",
    "give a number from 1e-6 to 1, or the dissipation itself", 1e-6, most=1.0,
)  # fmt: skip
_SCALE: Final = Domain(
    "contact.domain", "{formula} is {value}", "a law is divided by it", "give a number above 0", 0.0,
    above=True,
)  # fmt: skip


_PARTNERS: Final = (
    ("restitution", "speed", "the losses of an impact depend on its speed"),
    ("speed", "restitution", "it is the speed of the impact with this restitution"),
    ("depth", "damping", "it is where the damper is at its full strength"),
)


@final
@part
class NormalForce(Declared):
    """The force of a contact along its normal.

    With the penetration ``d = max(0, -gap)`` one of

    - ``stiffness d^exponent max(0, 1 - dissipation gap_rate)``, the law of Hunt and Crossley; `restitution`
      at an impact with `speed` may stand for the dissipation, exactly, for any stiffness, exponent and mass;
    - ``max(0, stiffness d^exponent - damping min(1, d/depth) gap_rate)``, a spring and a damper; without
      `depth` the damper is there at once, and the force jumps where the shapes begin to touch;
    - ``max(0, law)`` while the gap is negative, else 0; a curve is a function of the penetration.

    It never pulls.

    Examples
    --------
    >>> import symbody as sb
    >>> normal = sb.NormalForce(stiffness=1e6, restitution=0.8, speed="v0")
    >>> floor = sb.Contact("floor", "ground", "Ball", ["plane", {"sphere": 0.1}], normal=normal)
    >>> normal.exponent.text
    '1.5'
    """

    equation: ClassVar[str] = (
        "stiffness d^exponent max(0, 1 - dissipation gap'), or max(0, stiffness d^exponent - damping "
        "min(1, d/depth) gap'), or max(0, law), with d = max(0, -gap)"
    )
    sign: ClassVar[str] = "pushes apart, never pulls"

    stiffness: OptionalQuantity = optional(Quantity(unit="N/m^exponent", scope=Scope.LOAD, fits=_STIFFNESS))
    exponent: Quantity = Quantity("Of the penetration; 1.5 for spheres.", default=1.5, fits=_EXPONENT)
    dissipation: OptionalQuantity = optional(
        Quantity("Factor of the rate in Hunt and Crossley's law.", unit="s/m", scope=Scope.LOAD,
                 fits=_DISSIPATION)
    )  # fmt: skip
    restitution: OptionalQuantity = optional(
        Quantity("Speed after an impact over that before, instead of the dissipation.", fits=_RESTITUTION)
    )
    speed: OptionalQuantity = optional(
        Quantity("Speed of the impact for which the restitution is given.", unit="m/s", fits=_SCALE)
    )
    damping: OptionalQuantity = optional(
        Quantity("Of a damper beside the spring.", unit="N s/m", scope=Scope.LOAD, fits=_DISSIPATION)
    )
    depth: OptionalQuantity = optional(
        Quantity("Penetration from which on the damper is at its full strength.", unit="m", fits=_SCALE)
    )
    law: OptionalField[LawValue, Law] = optional(
        SpringLaw(
            "The force itself, a formula in gap and gap_rate; a curve is a function of the penetration.",
            unit="N",
            own=GAP,
        )
    )

    def check(self, arguments: Arguments) -> None:
        """Note arguments of several laws given together, and those that miss another."""
        given = [name for name in self.fields if name != "exponent" and getattr(self, name) is not None]
        if "law" in given:
            others = [name for name in given if name != "law"]
            if others:
                _refuse(
                    arguments, others[0], f"law and {', '.join(others)} are given", "law is the whole force"
                )
            return
        if "stiffness" not in given:
            _refuse(arguments, "stiffness", "the stiffness is missing", "nothing pushes the shapes apart")
        lossy = [name for name in ("dissipation", "restitution", "damping") if name in given]
        if len(lossy) > 1:
            _refuse(
                arguments, lossy[1], f"{' and '.join(lossy)} are given", "each of them makes the losses alone"
            )
        for name, partner, why in _PARTNERS:
            if name in given and partner not in given:
                _refuse(arguments, name, f"{name} requires {partner}, which is missing", why)


@dataclass(frozen=True, eq=False, repr=False)
class NormalLaw(Field[NormalForce | str, NormalForce | str]):
    """The law of a contact along its normal, or "rigid"."""

    role: ClassVar[str] = "normal_law"
    takes: ClassVar[str] = 'NormalForce or "rigid"'
    annotation: ClassVar[str] = "NormalForce | str"

    _: KW_ONLY
    inner: Any = field(default_factory=lambda: DeclaredPart(kind=NormalForce))

    def read(self, owner: Any, arguments: Arguments, value: object, path: str) -> NormalForce | str:
        """Return the law; one without force stands for what is none."""
        if isinstance(value, NormalForce):
            return value
        if isinstance(value, str) and value == RIGID:
            return RIGID
        what = f"{value!r} is not a normal force"
        why = "the force is a law of the gap and its rate, or what keeps rigid shapes apart"
        arguments.add("contact.normal", path, what, why, 'give NormalForce(stiffness=.., ..), or "rigid"')
        return _FORCELESS

    def schema(self) -> Schema:
        """Return the word, or its table."""
        return {"anyOf": [{"type": "string", "enum": [RIGID]}, self._inner().schema()]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of the table."""
        return () if isinstance(entry, str) else self._inner().misfits(entry, path)

    def tables(self) -> Iterable[FileTable]:
        """Return its table."""
        return self._inner().tables()

    def from_file(self, entry: object, arguments: Arguments, path: str, folder: str) -> object:
        """Return the law that a table describes; one without force for a table with faults."""
        if isinstance(entry, str):
            return entry
        return read_part(NormalForce, entry, arguments, path, folder) or _FORCELESS

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return the word, or its table."""
        return value if isinstance(value, str) else self._inner().to_file(owner, value, target)

    def rename(self, value: Any, names: NewNames) -> NormalForce | str:
        """Return the law in the new names."""
        return value if isinstance(value, str) else self._inner().rename(value, names)

    def parts(self, owner: Any, value: Any, path: str) -> Iterable[tuple[Field[Any, Any], Any, str]]:
        """Return the law as one of its role."""
        return () if isinstance(value, str) else ((self.inner, value, path),)

    def _inner(self) -> DeclaredPart[NormalForce]:
        inner: DeclaredPart[NormalForce] = self.inner
        return inner


_FORCELESS: Final = NormalForce(stiffness=0)


def _refuse(arguments: Arguments, word: str, what: str, why: str) -> None:
    fix = "write stiffness with dissipation, with restitution and speed, with damping, or alone; or law alone"
    arguments.add("contact.normal", word, what, why, fix)
