"""Joints that stick and slip.

While a joint sticks, a constraint holds it, and the effort it takes is watched; it breaks away where that
reaches the static limit. While it slips, its direction is fixed and its rate is watched; where that comes to
zero the joint sticks if the static limit suffices, and slips the other way if not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.equations.formed import Formed
from symbody.equations.solving.sticking import STICKS, in_modes, switching_joints
from symbody.simulation.events.events import Event
from symbody.simulation.modes.modes import Modes, Moment, Trial
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

_WORDS: Final = MappingProxyType({STICKS: "sticks", 1: "slips forward", -1: "slips backward"})
# Rows of what is known of the joints.
_RESERVE, _EFFORT, _ACCELERATION = range(3)


@dataclass(frozen=True, slots=True)
class Sticking:
    """The joints that stick and slip, the coordinates along which they do, and which of these are angles."""

    names: tuple[str, ...]
    coordinates: tuple[str, ...]
    are_angles: tuple[bool, ...]
    default: int = STICKS

    @property
    def seen(self) -> tuple[str, ...]:
        """Rates."""
        return tuple(f"{name}_dot" for name in self.coordinates)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Reserves, efforts and accelerations."""
        names = [f"{word} {joint}" for word in ("friction_reserve", "friction") for joint in self.names]
        return (*names, *(f"{name}_ddot" for name in self.coordinates))

    def applied(self, formed: Formed, modes: Modes) -> Formed:
        """Return equations with the joints sticking, or slipping in the direction of their sign."""
        return in_modes(formed, dict(zip(self.names, modes, strict=True)))

    def ways(self, moment: Moment, seen: Floats) -> list[tuple[int, ...]]:
        """Return one direction for joints that move; those at rest stick if they can, if no event forbids."""
        ways: list[tuple[int, ...]] = []
        for name, rate, is_angle in zip(self.names, seen[0], self.are_angles, strict=True):
            forced = moment.forced.get(name)
            if abs(rate) > moment.small * (1.0 if is_angle else moment.length):
                ways.append((int(np.sign(rate)),))
            else:
                ways.append((STICKS, 1, -1) if forced is None else (forced, -forced))
        return ways

    def overload(self, modes: Modes, found: Floats) -> Floats:
        """Return by how much the holding effort exceeds the static limit."""
        return np.where([mode == STICKS for mode in modes], -found[_RESERVE], -np.inf)

    def relieved(self, place: int, found: Floats) -> int:
        """Return the direction in which a joint breaks away."""
        return -int(np.sign(found[_EFFORT, place]))

    def fits(self, trial: Trial, place: int, at: int, is_open: bool) -> bool:
        """Return whether what sticks can be held, and what starts to slip slips in its direction."""
        found, mode = trial.found(self), trial.modes[at]
        if not np.isfinite(found[:, place]).all():
            return False
        if mode == STICKS:
            limit = found[_RESERVE, place] + abs(found[_EFFORT, place])
            return bool(found[_RESERVE, place] >= -BALANCED * limit)
        acceleration = found[_ACCELERATION, place]
        if not is_open or acceleration * mode >= 0.0:
            return True
        # At the limit itself nothing accelerates yet: rounding, beside what the other direction would do.
        other = trial.other(at, -mode).found(self)[_ACCELERATION, place]
        return bool(abs(acceleration) <= BALANCED * abs(other))

    def event(self, trial: Trial, place: int, mode: int) -> Event:
        """Return what ends a mode: no reserve, or no rate."""
        name = f"end of {self.word(mode)}: joint {self.names[place]}"
        if mode == STICKS:
            reserve = f"friction_reserve {self.names[place]}"
            return Event(reserve, direction=-1, action="stop", name=name)
        return Event(f"{self.coordinates[place]}_dot", direction=-mode, action="stop", name=name)

    def forced(self, trial: Trial, place: int, mode: int) -> Mapping[str, int]:
        """Return the direction of a joint that breaks away; one that comes to rest is free to do either."""
        if mode != STICKS:
            return {}
        found = trial.mechanism.found(trial.modes, trial.t, trial.x)
        own = next(f for kind, f in zip(trial.mechanism.kinds, found, strict=True) if kind is self)
        return {self.names[place]: self.relieved(place, own)}

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        return _WORDS[mode]


def sticking(formed: Formed) -> Sticking:
    """Return the joints of a mechanism that stick and slip."""
    names = switching_joints(formed)
    laws = {law.joint.name: law for law in formed.friction}
    angles = tuple(laws[name].coordinate in laws[name].joint.rotation_coordinates for name in names)
    return Sticking(names, tuple(laws[name].coordinate for name in names), angles)
