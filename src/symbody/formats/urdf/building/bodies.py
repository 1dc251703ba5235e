"""Bodies of the model from lumps of links: mass, inertia and the frames of links and joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbody.expr.graph import Constant
from symbody.formats.urdf.building.lumping import Lump, in_link_axes
from symbody.formats.urdf.file.placement import FramePlacement, numeral, total
from symbody.formats.urdf.file.robot import Robot
from symbody.model.body import Body
from symbody.model.declarations.arguments import Value
from symbody.model.frame import Frame
from symbody.model.inertia import is_possible_inertia
from symbody.model.shapes import BodyShape

ENTRIES = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")


@dataclass(frozen=True, slots=True)
class BodyPlan:
    """A body before its frames are placed.

    Attributes
    ----------
    name : str
        Its name, which the frame of its first link has too.
    values : mapping of parameter to value
        Of a symbolic link.
    centre : (3,) number or name
        Of mass, from the frame of the first link.
    unphysical : bool
        Whether no body has its inertia.
    """

    name: str
    values: Mapping[str, str]
    mass: Value
    centre: tuple[Constant | str, ...]
    inertia: tuple[Value, ...]
    unphysical: bool

    def frame(self, place: FramePlacement) -> Frame:
        """Return the frame at a place given from the frame of the first link."""
        at = [_difference(x, c) for x, c in zip(place.at, self.centre, strict=True)]
        return Frame(at=at, rotate=rotation(place))

    def body(self, frames: Mapping[str, Frame], shapes: Sequence[BodyShape]) -> Body:
        """Return the body."""
        return Body(
            self.name,
            self.mass,
            self.inertia[:3],
            self.inertia[3:],
            frames,
            unphysical=self.unphysical,
            shapes=shapes,
        )


def rotation(place: FramePlacement) -> list[tuple[str, str]]:
    """Return the turns of a placement as a frame takes them."""
    return [(letter, angle.text) for letter, angle in place.turns]


def ground_frame(place: FramePlacement) -> Frame:
    """Return a frame fixed on the ground, which the root link is."""
    return Frame(at=[numeral(x) for x in place.at], rotate=rotation(place))


def plan_body(robot: Robot, lump: Lump, name: str, symbols: Sequence[str] | None) -> BodyPlan:
    """Return a body of a lump; `symbols` are the names of m, cx, cy, cz, Ixx .. Iyz, where they stay."""
    unphysical = not possible(lump.inertia)
    if symbols is None:
        return BodyPlan(
            name,
            {},
            numeral(lump.mass),
            lump.centre,
            tuple(numeral(i) for i in lump.inertia),
            unphysical,
        )
    link = robot.links[lump.root]
    I = in_link_axes(link)
    tensor = (I[0][0], I[1][1], I[2][2], I[0][1], I[0][2], I[1][2])
    values = (link.mass, *link.centre.at, *tensor)
    return BodyPlan(
        name,
        {symbol: numeral(value) for symbol, value in zip(symbols, values, strict=True)},
        symbols[0],
        tuple(symbols[1:4]),
        tuple(symbols[4:]),
        unphysical,
    )


def symbol_names(name: str) -> list[str]:
    """Return how the parameters of a symbolic link are called."""
    return [f"{name}_{part}" for part in ("m", "cx", "cy", "cz", *ENTRIES)]


def possible(inertia: Sequence[Constant]) -> bool:
    """Return whether a body has these tensor entries."""
    numbers = [float(entry) for entry in inertia]
    return is_possible_inertia(numbers[:3], numbers[3:])


def _difference(x: Constant, c: Constant | str) -> Value:
    """Return x less a number or a parameter."""
    if isinstance(c, str):
        return f"{numeral(x)} - {c}" if x else f"-{c}"
    return numeral(total((x, -c)))
