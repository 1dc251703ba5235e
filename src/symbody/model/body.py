"""`Body`: a rigid body, and how elements name a place on one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import ClassVar, final

from symbody.expr.language.tokens import normalize
from symbody.model.declaration import Field
from symbody.model.door import Door
from symbody.model.element import Address, Element, address_of
from symbody.model.fields import Flag, Quantity, VectorQuantity, part
from symbody.model.frame import Frame
from symbody.model.naming import CENTRE, element_problem
from symbody.model.shapes.shape import Shapes
from symbody.model.table import Table
from symbody.model.uses import Use


class Frames(Field[Mapping[str, Frame] | None, Table[Frame]]):
    """Frames by name."""

    role: ClassVar[str] = "frames"
    takes: ClassVar[str] = "mapping of name to Frame"
    annotation: ClassVar[str] = "Mapping[str, Frame] | None"

    def read(self, owner: object, door: Door, value: object, path: str) -> Table[Frame]:
        """Return the frames."""
        return frame_table(door, value or {}, path)

    def formula_sites(self, owner: object, value: Table[Frame], path: str) -> Iterator[Use]:
        """Return where their formulas stand."""
        for name, frame in value.items():
            yield from frame.uses(f"{path}.{name}")


@final
@part
class Body(Element):
    """A rigid body; its own frame stands in the centre of mass.

    Examples
    --------
    >>> link = Body("Link", mass="m", frames={"tip": Frame(at=("L", 0, 0))})
    >>> str(link["tip"])
    'Link.tip'
    """

    kind: ClassVar[str] = "body"

    mass: Quantity = Quantity(
        "Mass; zero is legal as long as the mechanism as a whole can be accelerated.", unit="kg", default=0
    )
    inertia: VectorQuantity = VectorQuantity(
        "xx, yy, zz about the centre of mass, in the body's axes.", unit="kg m^2", default=(0, 0, 0)
    )
    products: VectorQuantity = VectorQuantity(
        "Tensor entries xy, xz, yz, with the sign of URDF.", unit="kg m^2", default=(0, 0, 0)
    )
    frames: Frames = Frames("Frames fixed on the body.", default=None)
    unphysical: Flag = Flag("Whether an impossible inertia is taken as it is, with a note.", default=False)
    shapes: Shapes = Shapes(
        "What is seen of it; without any it is drawn as rods between its joints.", default=(), place="shape"
    )

    def __getitem__(self, frame: str) -> Address:
        """Return a frame of this body, for use in joints and forces."""
        return address_of(self.name, normalize(frame), self)

    def shape_uses(self) -> Iterator[Use]:
        """Return where the formulas of its shapes stand, which nothing but pictures evaluates."""
        for k, shape in enumerate(self.shapes):
            yield from shape.uses(f"shape[{k}]")


FrameLike = Body | Address | str | tuple[Body | str, str]


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


def _frame(door: Door, value: object, path: str) -> Frame:
    if isinstance(value, Frame):
        return value
    door.refuse("model.not_a_frame", path, f"{value!r} is not a frame", "", "write Frame(at=(x, y, z))")
    return Frame()
