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

from symbody.analysis.modes.mode_decision import UNDECIDED, Opening
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.sticking import STICKS, set_modes, switching_joints
from symbody.simulation.events.events import Event, LevelEvent
from symbody.simulation.hybrid.modes import HybridState, Modes, ModeTrial

Floats = NDArray[np.float64]

_WORDS: Final = MappingProxyType({STICKS: "sticks", 1: "slips forward", -1: "slips backward"})


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
        """Efforts."""
        return tuple(f"friction {joint}" for joint in self.names)

    def apply_modes(self, formed: EquationsOfMotion, modes: Modes) -> EquationsOfMotion:
        """Return equations with the joints sticking, or slipping in the direction of their sign."""
        return set_modes(formed, dict(zip(self.names, modes, strict=True)))

    def openings(
        self, state: HybridState, motion: Floats, accelerations: Mapping[str, float]
    ) -> dict[str, Opening]:
        """Return the directions of joints that move or break away; those at rest are undecided."""
        openings: dict[str, Opening] = {}
        for name, rate, is_angle in zip(self.names, motion[0], self.are_angles, strict=True):
            if abs(rate) > state.small * (1.0 if is_angle else state.length):
                openings[name] = Opening(int(np.sign(rate)), is_decided=True)
            elif name in state.forced_modes:
                openings[name] = Opening(state.forced_modes[name], is_decided=True)
            else:
                openings[name] = UNDECIDED
        return openings

    def mode_of(self, kernel_mode: int) -> int:
        """Return the sign of slip, 0 while it sticks."""
        return kernel_mode

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
        return {self.names[place]: -int(np.sign(values[0, place]))}

    def word(self, mode: int) -> str:
        """Return a mode in words."""
        return _WORDS[mode]


def stick_slip_joints(formed: EquationsOfMotion) -> StickSlipJoints:
    """Return the joints of a mechanism that stick and slip."""
    names = switching_joints(formed)
    laws = {law.joint.name: law for law in formed.friction}
    angles = tuple(laws[name].turns for name in names)
    return StickSlipJoints(names, tuple(laws[name].coordinate for name in names), angles)
