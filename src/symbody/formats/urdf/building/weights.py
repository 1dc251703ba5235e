"""Notes on links without mass, and on mass without influence."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from symbody.formats.urdf.building.lumping import Lump
from symbody.formats.urdf.file.robot import Robot
from symbody.formats.urdf.file.structure import outward

_SHOWN = 6


def weight_notes(robot: Robot, lumps: Sequence[Lump], floats: bool) -> Iterator[str]:
    """Return what a user should know about the masses of a robot."""
    base = lumps[0]
    if not floats and base.mass:
        yield f"the base {base.root} is fixed: its mass of {float(base.mass):g} kg has no influence"
    for lump in lumps if floats else lumps[1:]:
        if not lump.mass and not any(lump.inertia):
            yield f"body {lump.root} is massless: no link of it has mass"
    idle = _idle_joints(robot)
    if idle:
        yield f"nothing that has mass resists the efforts of joints {_list_names(idle)}"


def _idle_joints(robot: Robot) -> list[str]:
    """Return the joints that move whose links, down to the last, have neither mass nor inertia."""
    below = {name: bool(link.mass or any(link.inertia)) for name, link in robot.links.items()}
    joints = outward(robot.joints.values(), robot.root)
    for joint in reversed(joints):
        below[joint.parent] = below[joint.parent] or below[joint.child]
    return [joint.name for joint in joints if joint.moves and not below[joint.child]]


def _list_names(names: Sequence[str]) -> str:
    return ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
