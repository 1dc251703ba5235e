"""`Contact`: two shapes that touch, with a force that is a smooth function of gap and rates."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar, Final, final

from symbody.model.contacts.contact_shapes import POINTS, ContactShapes
from symbody.model.contacts.normal_force import RIGID, NormalLaw
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import OptionalField, optional
from symbody.model.declarations.element_fields import Connection, element
from symbody.model.declarations.fields import DeclaredPart, Quantity, Refusal
from symbody.model.loads.bristles import bristle_signals
from symbody.model.loads.friction import Friction, check_friction
from symbody.model.loads.gap_laws import RESTITUTION
from symbody.model.naming import make_symbol
from symbody.model.numeric_checks import NumericChecks
from symbody.model.signals.signal import Signal

_FRICTION: Final = Refusal(
    "contact.friction", what="{value} is not Friction", fix="give Friction(mu=.., v0=..), or leave it out"
)
# What the friction of a joint has, and what has no meaning between two surfaces.
_OF_JOINTS: Final = ("radius", "force", "static")
# What ends the names of what bristles read: the slip along x and y, and the gap.
BRISTLES_READ: Final = ("slip_x", "slip_y", "gap")


@final
@element
class Contact(Connection):
    """Two shapes that touch: a force along the normal, and friction across it.

    The normal points from the shape on start to that on end; the gap between them is positive while they are
    apart, and negative is how deep they overlap. The force acts in the middle of the overlap, on end along
    the normal, the opposite on start. A box, a capsule or a cylinder on a plane touches in several points,
    each with the whole law: the gap is the least of theirs, the force the sum.

    Friction needs `v0`: with the slip v, the relative velocity across the normal, it is
    ``-mu N v/sqrt(v^2 + v0^2)``, so that what seems to stick creeps; or `deflection`: its bristles hold what
    sticks like springs, each point by its own states.

    With ``normal="rigid"`` the shapes never overlap: where the gap closes its rate jumps, by Poisson's law
    with `restitution`, and while it is closed a multiplier keeps it so. Friction without `v0` sticks then, as
    long as ``mu_static N`` holds it, in each point by itself.

    Examples
    --------
    >>> import symbody as sb
    >>> ball = sb.Body("Ball", mass=1, inertia=(0.4, 0.4, 0.4))
    >>> normal = sb.NormalForce(stiffness=1e6, dissipation=0.1)
    >>> floor = sb.Contact("floor", "ground", ball, ["plane", {"sphere": "r"}], normal=normal,
    ...                    friction=sb.Friction(mu=0.5, v0=1e-3))
    >>> floor.shapes
    ('plane', {'sphere': 'r'})
    """

    equation: ClassVar[str] = "`normal` along the normal, -mu N v/sqrt(v^2 + v0^2) across it"
    sign: ClassVar[str] = "on end, in the axes of its frame: z along the normal, from start to end"
    outputs: ClassVar[Mapping[str, tuple[str, ...]]] = MappingProxyType(
        {"gap": ("",), "contact_force": ("",), "contact_point": ("",), "slip": ("",)}
    )
    group: ClassVar[str] = "Contacts"
    kind: ClassVar[str] = "contact"
    has_frame: ClassVar[bool] = True
    on_one_body: ClassVar[Refusal | None] = Refusal(
        "contact.one_body", what="both shapes are on {value}", fix="put one on another body, or on ground",
        why="their gap never changes",
    )  # fmt: skip

    shapes: ContactShapes = ContactShapes("The shape on start and that on end.")
    normal: NormalLaw = NormalLaw('The force along the normal, or "rigid".')
    restitution: Quantity = Quantity(
        "Of a rigid contact: the share of its rate with which the gap opens after an impact.",
        default=0,
        fits=RESTITUTION,
    )
    friction: OptionalField[Friction, Friction] = optional(
        DeclaredPart(
            "Friction across the normal; of a compliant one with v0 or deflection.",
            kind=Friction,
            refusal=_FRICTION,
        )
    )

    @property
    def is_rigid(self) -> bool:
        """Whether the shapes never overlap; else their force is a law of the gap."""
        return self.normal == RIGID

    @property
    def compliant_gaps(self) -> Mapping[str, bool]:
        """The gap below which it has a force."""
        return {} if self.is_rigid else {f"gap {self.name}": False}

    @property
    def bristles(self) -> tuple[str, ...]:
        """With what the names of bristles begin, one for each point."""
        if self.friction is None or not self.friction.has_bristles:
            return ()
        words = [shape.word for shape in self.shapes]
        count = max(POINTS.get(word, 1) for word in words) if "plane" in words else 1
        label = f"{make_symbol(self.name)}_bristle"
        return (label,) if count == 1 else tuple(f"{label}_{k}" for k in range(1, count + 1))

    @property
    def signals(self) -> tuple[Signal, ...]:
        """The states of bristles along x and y, as functions of slip and gap in their points."""
        signals: list[Signal] = []
        for label in self.bristles:
            x, y, gap = (f"{label}_{word}" for word in BRISTLES_READ)
            assert self.friction is not None
            signals += bristle_signals(self.friction, label, (("_x", x), ("_y", y)), gap)
        return tuple(signals)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """None: it brings no coordinates with it."""
        return ()

    @property
    def multiplier_unit(self) -> str:
        """Of the forces along the normals of a rigid contact."""
        return "N"

    def output_words(self, kind: str) -> tuple[str, ...]:
        """Return what may follow its name in outputs of a kind."""
        return () if kind == "mode" and not self.is_rigid else Connection.output_words(self, kind)

    def check(self, arguments: Arguments) -> None:
        """Note friction that is not one between surfaces."""
        friction = self.friction
        if not self.is_rigid and self.restitution.constant() != 0:
            why = "that of a compliant contact follows from its losses"
            fix = 'write NormalForce(.., restitution=.., speed=..), or normal = "rigid"'
            arguments.add("contact.normal", "restitution", "restitution is that of a rigid contact", why, fix)
        if friction is None:
            return
        if self.is_rigid and friction.deflection is None:
            _check_rigid_friction(friction, arguments)
            return
        odd = [name for name in _OF_JOINTS if getattr(friction, name) is not None]
        for name in odd:
            why = "the force along the normal is known, and friction is mu times that"
            arguments.add(
                "contact.friction", f"friction.{name}", f"{name} is for joints", why, "leave it out"
            )
        if not friction.is_smooth and not odd and not friction.is_none:
            what = "v0 is missing"
            why = "friction of a compliant contact is a function of the slip, or deflects before it slips"
            fix = "give v0 = .. in m/s: the slip at which friction is at 0.71 of its strength; or deflection"
            arguments.add("contact.friction", "friction.v0", what, why, fix)
        is_complete = (friction.mu_static is None) == (friction.stribeck is None)
        if not is_complete and friction.deflection is None:
            what = "mu_static and stribeck belong together"
            why = "the coefficient falls from mu_static to mu over the speed stribeck"
            arguments.add("contact.friction", "friction.mu_static", what, why, "give both, or neither")
        if friction.mu_y is not None and friction.mu_static is not None:
            what, why = "mu_y and mu_static are given", "mu_static is that of all directions"
            arguments.add("contact.friction", "friction.mu_y", what, why, "leave one of them out")
        if friction.mu_y is not None and "plane" not in {shape.word for shape in self.shapes}:
            what = "mu_y is given, and neither shape is a plane"
            why = "the directions x and y of such a contact turn with its normal"
            arguments.add("contact.friction", "friction.mu_y", what, why, "leave mu_y out")

    def check_numbers(self, check: NumericChecks, label: str) -> None:
        """Note sizes, laws and friction that cannot be."""
        Connection.check_numbers(self, check, label)
        if self.friction is not None:
            check_friction(check, self.friction, f"{label}, friction", turns=False)


def _check_rigid_friction(friction: Friction, arguments: Arguments) -> None:
    """Note friction that a rigid contact does not have."""
    smooth = ("mu_static",) if friction.v0 is not None else ()
    for name in (*_OF_JOINTS, "mu_y", "stribeck", *smooth):
        if getattr(friction, name) is not None:
            why = "friction of a rigid contact is mu times its force, alike in all directions"
            arguments.add("contact.friction", f"friction.{name}", f"{name} is given", why, "leave it out")
