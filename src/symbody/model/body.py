"""`Body`: a rigid body, and how elements name a place on one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar, Final, final

from symbody.expr.language.tokens import normalize
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.combinators import ByName
from symbody.model.declarations.fields import DeclaredPart, Flag, Quantity, Refusal, VectorQuantity, part
from symbody.model.declarations.formula_site import FormulaSite
from symbody.model.element import Element, FrameRef, make_frame_ref
from symbody.model.frame import Frame
from symbody.model.frozen_mapping import FrozenMapping
from symbody.model.naming import CENTRE, element_problem
from symbody.model.shapes.shape import Shapes

_NO_FRAME: Final = Refusal(
    "model.not_a_frame", what="{value} is not a frame", fix="write Frame(at=(x, y, z))"
)


@dataclass(frozen=True, eq=False, repr=False)
class Frames(ByName[Mapping[str, Frame] | None, Frame]):
    """Frames by name."""

    role: ClassVar[str] = "frames"
    takes: ClassVar[str] = "mapping of name to Frame"
    annotation: ClassVar[str] = "Mapping[str, Frame] | None"

    _: KW_ONLY
    default: Any = None
    item: Any = field(default_factory=lambda: DeclaredPart(kind=Frame, refusal=_NO_FRAME))

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> FrozenMapping[Frame]:
        """Return the frames; none may have the name of the centre of mass."""
        table = ByName.read(self, owner, arguments, value or {}, path)
        for name in table:
            problem = element_problem(name, arguments.where(f"{path}.{name}"))
            if problem is not None:
                arguments.problems.append(problem)
            if name == CENTRE:
                what = f"the name {CENTRE!r} is reserved: every body has a frame of this name"
                why = "it is the centre of mass"
                arguments.add("names.reserved", f"{path}.{name}", what, why, "rename the frame")
        return table


# The frames of the ground, which has no declaration of its own.
GROUND_FRAMES: Final = Frames("Frames fixed to the ground.")


@final
@part
class Body(Element):
    """A rigid body; its own frame is at the centre of mass.

    Examples
    --------
    >>> link = Body("Link", mass="m", frames={"tip": Frame(at=("L", 0, 0))})
    >>> str(link["tip"])
    'Link.tip'
    """

    kind: ClassVar[str] = "body"
    group: ClassVar[str] = "Bodies"

    mass: Quantity = Quantity(
        "Mass; zero is allowed as long as the mechanism as a whole has mass in every direction of motion.",
        unit="kg",
        default=0,
    )
    inertia: VectorQuantity = VectorQuantity(
        "Moments xx, yy, zz about the centre of mass, in the body's axes.", unit="kg m^2", default=(0, 0, 0),
        example='the moments about x, y and z of the body, such as inertia = ["0", "0", "I"]',
    )  # fmt: skip
    products: VectorQuantity = VectorQuantity(
        "Tensor entries xy, xz, yz, with the sign of URDF.", unit="kg m^2", default=(0, 0, 0)
    )
    frames: Frames = Frames("Frames fixed to the body.")
    unphysical: Flag = Flag(
        "Whether a physically impossible inertia is used unchanged, with a note.", default=False
    )
    shapes: Shapes = Shapes(
        "Shapes to draw; without any the body is drawn as rods between its joints.", default=(), place="shape"
    )

    def __str__(self) -> str:
        facts = [f"mass {self.mass}"]
        for word, triple in (("inertia", self.inertia), ("products", self.products)):
            if any(entry.text != "0" for entry in triple):
                facts.append(f"{word} ({', '.join(entry.text for entry in triple)})")
        if self.frames:
            facts.append(f"frames {', '.join(self.frames)}")
        return f"Body {self.name}: {', '.join(facts)}"

    def __getitem__(self, frame: str) -> FrameRef:
        """Return a frame of this body, for use in joints and forces."""
        return make_frame_ref(self.name, normalize(frame), self)

    def shape_formula_sites(self) -> Iterator[FormulaSite]:
        """Return where the formulas of its shapes stand, which nothing but pictures evaluates."""
        for k, shape in enumerate(self.shapes):
            yield from shape.formula_sites(f"shape[{k}]")


FrameLike = Body | FrameRef | str | tuple[Body | str, str]


def read_frame_ref(arguments: Arguments, place: object, path: str) -> FrameRef:
    """Return the address of a place given as body, ``body["frame"]``, text or (body, frame name)."""
    if isinstance(place, FrameRef):
        return place
    if isinstance(place, Body):
        return make_frame_ref(place.name, "", place)
    if isinstance(place, str):
        return _parse_frame_ref(arguments, place, path)
    if isinstance(place, tuple) and len(place) == 2 and isinstance(place[1], str):
        body, frame = place
        if isinstance(body, Body):
            return body[frame]
        if isinstance(body, str):
            return make_frame_ref(normalize(body), normalize(frame))
    is_frame = isinstance(place, Frame)
    what = f"{'a Frame' if is_frame else repr(place)} is not a point of a body"
    fix = 'give a Body, body["frame"], or a text such as "Body.Frame"'
    arguments.add("model.not_a_place", path, what, "a Frame does not know its body" if is_frame else "", fix)
    return FrameRef("ground")


def _parse_frame_ref(arguments: Arguments, text: str, path: str) -> FrameRef:
    body, dot, frame = (part.strip() for part in normalize(text).partition("."))
    if body and bool(frame) == bool(dot) and "." not in frame:
        return make_frame_ref(body, frame)
    fix = "write Body.Frame, or Body for its centre of mass, or ground"
    arguments.add("model.bad_address", path, f"{text!r} is not an address", "", fix)
    return FrameRef("ground")
