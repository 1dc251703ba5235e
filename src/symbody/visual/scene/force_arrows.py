"""Forces and torques as arrows: which there are, the outputs they follow from, their values and places."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from symbody.errors import Problem, UsageError, nearest
from symbody.model.constraint import FrameConstraint
from symbody.model.constraints import Rolling
from symbody.model.contacts.contact import Contact
from symbody.model.element import FrameRef
from symbody.model.joint import Joint
from symbody.model.joints.orientation import Free
from symbody.model.loads.forces import Force, SpringDamper, Torque
from symbody.model.model import Model
from symbody.model.naming import GROUND
from symbody.visual.scene.body_poses import Floats
from symbody.visual.scene.scene import Anchor, MotionVector, Scene, VectorKind

Triple = tuple[str, str, str]

# So many forces and torques, applied or of contacts, are drawn without a word.
_FEW: Final = 6
# Forces and torques that never exceed this share of the largest are left out.
_NOTHING: Final = 1e-9
# The square of the length of a spring that is a point [m^2]: it has no direction.
_POINT: Final = 1e-300


@dataclass(frozen=True, slots=True)
class Arrow:
    """A force or torque to be drawn.

    Attributes
    ----------
    name, kind, anchor
        As in `MotionVector`.
    values : (str, str, str)
        Outputs: its components in ground's axes.
    places : (str, str, str), optional
        Outputs: where it acts, in ground's axes, of a force that is fixed on no body.
    prints : bool
        As in `MotionVector`.
    """

    name: str
    kind: VectorKind
    anchor: Anchor
    values: Triple
    places: Triple | None = None
    prints: bool = False

    @property
    def outputs(self) -> tuple[str, ...]:
        """All outputs that it is made of."""
        return (*self.values, *(self.places or ()))


def arrows_of(model: Model, scene: Scene, chosen: str | Iterable[str] | None) -> list[Arrow]:
    """Return the forces and torques to be drawn.

    Parameters
    ----------
    chosen : "all", "applied", "none", names, or None
        Names are those of elements, or of arrows such as ``"reaction elbow"``. None: those of `Force`,
        `Torque` and `Contact` where they are few of a kind.

    Raises
    ------
    UsageError
        If a name is neither.
    """
    every = _all_arrows(model, scene)
    applied = [arrow for arrow in every if arrow.name.startswith(("force ", "torque "))]
    if chosen is None:
        touching = [arrow for arrow in every if arrow.name.startswith("contact ")]
        return [arrow for arrows in (applied, touching) if len(arrows) <= _FEW for arrow in arrows]
    words = {"all": every, "applied": applied, "none": []}
    if isinstance(chosen, str) and chosen in words:
        return words[chosen]
    names = (chosen,) if isinstance(chosen, str) else tuple(chosen)
    known = {name for arrow in every for name in (arrow.name, _element(arrow))}
    problems = [_unknown_name(name, known) for name in names if name not in known]
    if problems:
        raise UsageError(*problems)
    return [arrow for arrow in every if arrow.name in names or _element(arrow) in names]


def vectors_of(
    arrows: Sequence[Arrow], outputs: Mapping[str, Floats], size: float
) -> tuple[MotionVector, ...]:
    """Return arrows with their values; those that are always zero, up to rounding, are left out.

    Parameters
    ----------
    size : float
        Of the scene [m]: torques are compared with the largest force on an arm so long.
    """
    values = [_columns(arrow.values, outputs) for arrow in arrows]
    arms = [size if arrow.kind == "force" else 1.0 for arrow in arrows]
    sizes = [arm * float(np.abs(array).max(initial=0.0)) for arm, array in zip(arms, values, strict=True)]
    least = _NOTHING * max(sizes, default=0.0)
    return tuple(
        MotionVector(
            arrow.name,
            arrow.kind,
            arrow.anchor,
            array,
            None if arrow.places is None else _columns(arrow.places, outputs),
            arrow.prints,
        )
        for arrow, array, large in zip(arrows, values, sizes, strict=True)
        if large > least
    )


def _all_arrows(model: Model, scene: Scene) -> list[Arrow]:
    anchors = _Anchors(scene)
    arrows: list[Arrow] = []
    for element in model.elements:
        if isinstance(element, Force | Torque):
            kind: VectorKind = "force" if isinstance(element, Force) else "torque"
            arrows.append(_applied_arrow(element, kind, anchors.anchor_at(element.on)))
        elif isinstance(element, SpringDamper):
            arrows.append(_spring_arrow(element, anchors.anchor_at(element.end)))
        elif isinstance(element, Contact):
            arrows.append(_contact_arrow(element, anchors.anchor_at(element.end)))
    fixed = [part for part in model.constraints if isinstance(part, FrameConstraint)]
    links: list[Joint | FrameConstraint] = [*model.joints, *fixed]
    for link in links:
        # a point of rolling is fixed on no body, and a free joint holds nothing
        if not isinstance(link, Rolling | Free):
            arrows += _reactions(link.name, link.start, anchors.anchor_at(link.end))
    return arrows


def _element(arrow: Arrow) -> str:
    return arrow.name.partition(" ")[2]


@dataclass(frozen=True, slots=True)
class _Anchors:
    scene: Scene

    def anchor_at(self, address: FrameRef) -> Anchor:
        """Return where a frame is on its body."""
        names = [body.name for body in self.scene.bodies]
        place = 0 if address.body == "ground" else names.index(address.body)
        points = {frame.name: frame.at for frame in self.scene.bodies[place].frames}
        return Anchor(place, points.get(address.frame, (0.0, 0.0, 0.0)))


def _applied_arrow(element: Force | Torque, kind: VectorKind, anchor: Anchor) -> Arrow:
    components = [f"({formula.text})" for formula in element.vector]
    return Arrow(
        f"{kind} {element.name}", kind, anchor, _turn_to_ground(_axes(element.resolved_in), components)
    )


def _spring_arrow(spring: SpringDamper, anchor: Anchor) -> Arrow:
    """Return the force of a spring on its end, along its line; none where both ends are in one point."""
    line = [f'\'frame r "{spring.end.full_name}" "{spring.start.full_name}" ground {x}\'' for x in "xyz"]
    square = " + ".join(f"{each}^2" for each in line)
    x, y, z = (f"'effort {spring.name}'*{each}/sqrt(max({square}, {_POINT}))" for each in line)
    return Arrow(f"spring {spring.name}", "force", anchor, (x, y, z))


def _contact_arrow(contact: Contact, anchor: Anchor) -> Arrow:
    """Return the force of a contact on its end, from the point where it acts."""
    force = [f"'contact_force \"{contact.name}\" {x}'" for x in "xyz"]
    point = [f"'contact_point \"{contact.name}\" {x}'" for x in "xyz"]
    origin = [f"'frame r \"{contact.start.full_name}\" {x}'" for x in "xyz"]
    turned = _turn_to_ground(_axes(contact.start), point)
    x, y, z = (f"{start} + {each}" for start, each in zip(origin, turned, strict=True))
    values = _turn_to_ground(f'frame R "{contact.name}"', force)
    prints = GROUND in (contact.start.body, contact.end.body)
    name = f"contact {contact.name}"
    return Arrow(name, "force", anchor, values, (x, y, z), prints)


def _reactions(name: str, start: FrameRef, anchor: Anchor) -> list[Arrow]:
    axes = _axes(start)
    force, torque = (
        _turn_to_ground(axes, [f"'reaction \"{name}\" {letter}{x}'" for x in "xyz"]) for letter in "FM"
    )
    return [
        Arrow(f"reaction {name}", "force", anchor, force),
        Arrow(f"reaction {name}", "torque", anchor, torque),
    ]


def _axes(address: FrameRef) -> str:
    return f'frame R "{address.full_name}"'


def _turn_to_ground(matrix: str, components: Sequence[str]) -> Triple:
    """Return components in ground's axes, from those in axes whose rotation matrix is an output."""
    x, y, z = (
        " + ".join(f"'{matrix} {row}{column}'*{each}" for column, each in zip("xyz", components, strict=True))
        for row in "xyz"
    )
    return x, y, z


def _columns(names: Triple, outputs: Mapping[str, Floats]) -> Floats:
    """Return outputs (N,) side by side, (N, 3)."""
    return np.stack([outputs[name] for name in names], axis=-1)


def _unknown_name(name: str, known: Iterable[str]) -> Problem:
    return Problem(
        "animation.unknown_vector", repr(name), f"{name!r} names nothing that acts on a body", "",
        f'{nearest(name, known).rstrip(".")} "all" draws every force and reaction'.lstrip(),
    )  # fmt: skip
