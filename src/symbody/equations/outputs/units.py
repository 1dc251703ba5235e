"""SI units of outputs by name."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.loads.loads import effort_name
from symbody.equations.outputs.dimensions import expression_unit
from symbody.equations.outputs.friction_outputs import friction_names
from symbody.equations.outputs.joint_outputs import effort_names
from symbody.equations.outputs.parameter_units import symbol_units
from symbody.equations.solving.ropes import ropes
from symbody.model.joint import Joint

_GENERAL: Final = {
    "t": "s",
    "kinetic_energy": "J",
    "potential_energy": "J",
    "energy": "J",
    "work": "J",
    "power": "W",
}
_FRAME: Final = {"r": "m", "v": "m/s", "vdot": "m/s^2", "w": "rad/s", "wdot": "rad/s^2"}
_TRANSLATION: Final = ("m", "m/s", "m/s^2", "N")
_ROTATION: Final = ("rad", "rad/s", "rad/s^2", "N m")


@dataclass(frozen=True, slots=True, eq=False)
class Units(Mapping[str, str]):
    """Units of known names and, though no list of them ends, of motions of frames and of expressions.

    Attributes
    ----------
    known : mapping of name to str
        What is listed.
    """

    known: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        """Return the unit of an output or an expression; that of a pure number is ``""``.

        Raises
        ------
        KeyError
            If it is not known.
        """
        if name in self.known:
            return self.known[name]
        first, kind = [*name.split(maxsplit=2), "", ""][:2]
        if first == "frame" and kind in _FRAME:
            return _FRAME[kind]
        unit = None if is_output_name(name) else expression_unit(name, self.get)
        if unit is None:
            raise KeyError(name)
        return unit

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the names that are listed."""
        return iter(self.known)

    def __len__(self) -> int:
        """Return how many names are listed."""
        return len(self.known)

    def __repr__(self) -> str:
        return f"Units({dict(self.known)!r})"


def is_output_name(name: str) -> bool:
    """Return whether a name is a symbol or begins with a word and a blank, as outputs do."""
    return re.fullmatch(r"\w+|[A-Za-z_]+ [^-+*/^<>=(,].*", name.strip()) is not None


def output_units(formed: EquationsOfMotion) -> Units:
    """Return the units of coordinates, rates, energies, efforts, reactions, multipliers and parameters."""
    units = symbol_units(formed.topology.model) | _GENERAL
    for name in formed.angles:
        units |= dict(zip((name, f"{name}_dot", f"{name}_ddot"), _ROTATION[:3], strict=True))
    driven, rough = set(effort_names(formed)), set(friction_names(formed))
    for joint in formed.topology.joints:
        units |= _joint_units(joint, driven, rough)
    for name in (*(joint.name for joint in formed.topology.joints), *formed.topology.contacts):
        units |= {f"reaction {name} F{letter}": "N" for letter in "xyz"}
        units |= {f"reaction {name} M{letter}": "N m" for letter in "xyz"}
    own = {part.name: part.multiplier_unit for part in formed.topology.model.constraints}
    rows = (*formed.rows, *formed.coupled.rows)
    units |= {row.name: own[row.element] for row in rows if own.get(row.element)}
    for measure in formed.loads.measures:  # of springs: "length S" or "angle S"
        kind, _, name = measure.partition(" ")
        place, _, _, effort = _TRANSLATION if kind == "length" else _ROTATION
        units |= {measure: place, f"effort {name}": effort}
    for name in ropes(formed):
        units |= {f"rope_tension {name}": "N", f"rope_length {name}": "m", f"rope_slack {name}": "m"}
        units |= {f"rope_slack_dot {name}": "m/s", f"rope_slack_ddot {name}": "m/s^2"}
    return Units(units | _signal_units(formed, Units(units)))


def _signal_units(formed: EquationsOfMotion, listed: Units) -> dict[str, str]:
    """Return the units of signals that name outputs."""
    outputs = {signal.name: signal.output or "" for signal in formed.topology.model.signals}
    units = {name: listed.get(output, "") for name, output in outputs.items() if output}
    return {name: unit for name, unit in units.items() if unit}


def _joint_units(joint: Joint, driven: Collection[str], rough: Collection[str]) -> dict[str, str]:
    """Return the units of a joint's coordinates and speeds, and of the efforts and friction it has."""
    units: dict[str, str] = {}
    for name, (place, rate, second, effort) in _coordinates(joint):
        units |= {name: place, f"{name}_dot": rate, f"{name}_ddot": second}
        word = effort_name(joint, name)
        if word in driven:
            units[f"effort {word}"] = effort
        if joint.name in rough:
            units |= {f"friction {joint.name}": effort, f"friction_reserve {joint.name}": effort}
    for speeds, (_, rate, second, _) in (
        (joint.translation_speeds, _TRANSLATION),
        (joint.rotation_speeds, _ROTATION),
    ):
        for name in speeds.names if speeds else ():
            units |= {name: rate, f"{name}_dot": second}
    return units


def _coordinates(joint: Joint) -> Iterator[tuple[str, tuple[str, str, str, str]]]:
    """Yield the coordinates that have units, with those of their value, rates and effort."""
    for name in joint.translation_coordinates:
        yield name, _TRANSLATION
    for name in joint.rotation_coordinates if joint.quaternion is None else ():
        yield name, _ROTATION
