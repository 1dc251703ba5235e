"""`Body`: a rigid body, and how elements name a place on one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from symbody.arguments import checked_arguments
from symbody.expr.language.formula import Formula
from symbody.expr.language.tokens import normalize
from symbody.model.door import Door, Value
from symbody.model.element import Address, Element, address_of
from symbody.model.frame import Frame
from symbody.model.naming import CENTRE, element_problem
from symbody.model.shapes.shape import BodyShape, shapes_from
from symbody.model.table import Table
from symbody.model.uses import Scope, Triple, Use, triple_uses


@final
@dataclass(frozen=True, slots=True, init=False)
class Body(Element):
    """A rigid body; its own frame stands in the centre of mass.

    Parameters
    ----------
    name : str
        Unique among the elements of the model.
    mass : number or formula
        Mass [kg]; zero is legal as long as the mechanism as a whole can be accelerated.
    inertia : (3,) number or formula
        xx, yy, zz about the centre of mass in the body's axes [kg m^2].
    products : (3,) number or formula
        xy, xz, yz entries of the inertia tensor (the sign of URDF) [kg m^2].
    frames : mapping of name to Frame
        Further frames fixed on the body.
    unphysical : bool
        Whether an inertia that no distribution of mass has is taken as it is, with a note, as in robots that
        were only ever simulated.
    shapes : iterable of Box, Cylinder, Sphere, Capsule, Cone or Mesh
        What is seen of it; without any it is drawn as rods between its joints. They have no influence on
        the motion.

    Raises
    ------
    ModelError
        With everything that is not a name or a formula.

    Examples
    --------
    >>> link = Body("Link", mass="m", frames={"tip": Frame(at=("L", 0, 0))})
    >>> str(link["tip"])
    'Link.tip'
    """

    kind: ClassVar[str] = "body"

    name: str
    mass: Formula
    inertia: Triple
    products: Triple
    frames: Table[Frame]
    unphysical: bool
    shapes: tuple[BodyShape, ...]

    @checked_arguments
    def __init__(
        self,
        name: str,
        mass: Value = 0,
        inertia: Iterable[Value] = (0, 0, 0),
        products: Iterable[Value] = (0, 0, 0),
        frames: Mapping[str, Frame] | None = None,
        unphysical: bool = False,
        shapes: Iterable[BodyShape] = (),
    ) -> None:
        door = Door(f"body {name}")
        object.__setattr__(self, "name", door.element_name(name))
        object.__setattr__(self, "mass", door.formula(mass, "mass"))
        object.__setattr__(self, "inertia", door.triple(inertia, "inertia"))
        object.__setattr__(self, "products", door.triple(products, "products"))
        object.__setattr__(self, "frames", frame_table(door, frames or {}, "frames"))
        object.__setattr__(self, "unphysical", bool(unphysical))
        object.__setattr__(self, "shapes", shapes_from(door, shapes, "shape"))
        door.close()

    def __getitem__(self, frame: str) -> Address:
        """Return a frame of this body, for use in joints and forces."""
        return address_of(self.name, normalize(frame), self)

    def uses(self) -> Iterator[Use]:
        """Return where the formulas stand."""
        yield Use("mass", self.mass, Scope.CONSTANT)
        yield from triple_uses("inertia", self.inertia, Scope.CONSTANT)
        yield from triple_uses("products", self.products, Scope.CONSTANT)
        for name, frame in self.frames.items():
            yield from frame.uses(f"frames.{name}")

    def shape_uses(self) -> Iterator[Use]:
        """Return where the formulas of its shapes stand, which nothing but pictures evaluates."""
        for k, shape in enumerate(self.shapes):
            yield from shape.uses(f"shape[{k}]")


Place = Body | Address | str | tuple[Body | str, str]


def frame_table(door: Door, frames: object, path: str) -> Table[Frame]:
    """Return named frames, checked."""
    table = door.table(frames, path, lambda value, place: _frame(door, value, place))
    for name in table:
        problem = element_problem(name, door.where(f"{path}.{name}"))
        if problem is not None:
            door.problems.append(problem)
        if name == CENTRE:
            door.refuse(
                "names.reserved",
                f"{path}.{name}",
                f"the name {CENTRE!r} is taken: every body has it",
                "it is the centre of mass",
                "rename the frame",
            )
    return table


def address_from(door: Door, place: object, path: str) -> Address:
    """Return the address of a place given as body, ``body["frame"]``, text or (body, frame name)."""
    if isinstance(place, Address):
        return place
    if isinstance(place, Body):
        return address_of(place.name, "", place)
    if isinstance(place, str):
        return _parsed(door, place, path)
    if isinstance(place, tuple) and len(place) == 2 and isinstance(place[1], str):
        body, frame = place
        if isinstance(body, Body):
            return body[frame]
        if isinstance(body, str):
            return address_of(normalize(body), normalize(frame))
    is_frame = isinstance(place, Frame)
    door.refuse(
        "model.not_a_place",
        path,
        f"{'a Frame' if is_frame else repr(place)} is not a place on a body",
        "a Frame does not know which body it is on" if is_frame else "",
        'give a Body, body["frame"], or a text such as "Body.Frame"',
    )
    return Address("ground")


def _parsed(door: Door, text: str, path: str) -> Address:
    body, dot, frame = (part.strip() for part in normalize(text).partition("."))
    if body and bool(frame) == bool(dot) and "." not in frame:
        return address_of(body, frame)
    door.refuse(
        "model.bad_address",
        path,
        f"{text!r} is not an address",
        "",
        "write Body.Frame, or Body for its centre of mass, or ground",
    )
    return Address("ground")


def _frame(door: Door, value: object, path: str) -> Frame:
    if isinstance(value, Frame):
        return value
    door.refuse("model.not_a_frame", path, f"{value!r} is not a frame", "", "write Frame(at=(x, y, z))")
    return Frame()
