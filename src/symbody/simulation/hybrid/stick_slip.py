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

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.sticking import STICKS, set_modes, switching_joints
from symbody.simulation.events.events import Event, LevelEvent
from symbody.simulation.hybrid.modes import HybridState, Modes, ModeTrial
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

_WORDS: Final = MappingProxyType({STICKS: "sticks", 1: "slips forward", -1: "slips backward"})
# Rows of what is known of the joints.
_RESERVE, _EFFORT, _ACCELERATION = range(3)


@dataclass(frozen=True, slots=True)
class StickSlipJoints:
    """The joints that stick and slip, the coordinates along which they do, and which of these are angles."""

    names: tuple[str, ...]
    coordinates: tuple[str, ...]
    are_angles: tuple[bool, ...]
    default: int = STICKS
    free: int = 1

    @property
    def motion_outputs(self) -> tuple[str, ...]:
        """Rates."""
        return tuple(f"{name}_dot" for name in self.coordinates)

    @property
    def outputs(self) -> tuple[str, ...]:
        """Reserves, efforts and accelerations."""
        names = [f"{word} {joint}" for word in ("friction_reserve", "friction") for joint in self.names]
        return (*names, *(f"{name}_ddot" for name in self.coordinates))

    def apply_modes(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations with the joints sticking, or slipping in the direction of their sign."""
        return set_modes(formed, dict(zip(self.names, modes, strict=True)))

    def candidates(self, state: HybridState, motion: Floats) -> list[tuple[int, ...]]:
        """Return one direction for joints that move; those at rest stick if they can, if no event forbids."""
        candidates: list[tuple[int, ...]] = []
        for name, rate, is_angle in zip(self.names, motion[0], self.are_angles, strict=True):
            forced = state.forced_modes.get(name)
            if abs(rate) > state.small * (1.0 if is_angle else state.length):
                candidates.append((int(np.sign(rate)),))
            else:
                candidates.append((STICKS, 1, -1) if forced is None else (forced, -forced))
        return candidates

    def violation(self, modes: Modes, values: Floats) -> Floats:
        """Return by how much the holding effort exceeds the static limit."""
        return np.where([mode == STICKS for mode in modes], -values[_RESERVE], -np.inf)

    def next_mode(self, place: int, values: Floats) -> int:
        """Return the direction in which a joint breaks away."""
        return -int(np.sign(values[_EFFORT, place]))

    def is_consistent(self, trial: ModeTrial, place: int, element: int, is_open: bool) -> bool:
        """Return whether what sticks can be held, and what starts to slip slips in its direction."""
        values, mode = trial.values(self), trial.modes[element]
        if not np.isfinite(values[:, place]).all():
            return False
        if mode == STICKS:
            limit = values[_RESERVE, place] + abs(values[_EFFORT, place])
            return bool(values[_RESERVE, place] >= -BALANCED * limit)
        acceleration = values[_ACCELERATION, place]
        if not is_open or acceleration * mode >= 0.0:
            return True
        # At the limit itself nothing accelerates yet: rounding, beside what the other direction would do.
        other = trial.with_mode(element, -mode).values(self)[_ACCELERATION, place]
        return bool(abs(acceleration) <= BALANCED * abs(other))

    def end_event(self, trial: ModeTrial, place: int, mode: int) -> Event:
        """Return what ends a mode: no reserve, or no rate."""
        name = f"end of {self.word(mode)}: joint {self.names[place]}"
        if mode == STICKS:
            reserve = f"friction_reserve {self.names[place]}"
            return LevelEvent(reserve, -1, "stop", name)
        return LevelEvent(f"{self.coordinates[place]}_dot", -mode, "stop", name)

    def forced_modes(self, trial: ModeTrial, place: int, mode: int) -> Mapping[str, int]:
        """Return the direction of a joint that breaks away; one that comes to rest is free to do either."""
        if mode != STICKS:
            return {}
        by_kind = zip(
            trial.mechanism.kinds, trial.mechanism.values(trial.modes, trial.t, trial.x), strict=True
        )
        values = next(values for kind, values in by_kind if kind is self)
        return {self.names[place]: self.next_mode(place, values)}

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        return _WORDS[mode]


def stick_slip_joints(formed: EquationsOfMotion) -> StickSlipJoints:
    """Return the joints of a mechanism that stick and slip."""
    names = switching_joints(formed)
    laws = {law.joint.name: law for law in formed.friction}
    angles = tuple(laws[name].coordinate in laws[name].joint.rotation_coordinates for name in names)
    return StickSlipJoints(names, tuple(laws[name].coordinate for name in names), angles)
