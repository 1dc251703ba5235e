"""SI units of outputs by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.dimensions import expression_unit
from symbody.equations.outputs.parameter_units import symbol_units
from symbody.model.joint import Joint
from symbody.model.output_names import FRAME_OUTPUT, MOTION_UNITS, kind_of, list_outputs, parse_derivative

_TRANSLATION: Final = ("m", "m/s", "m/s^2")
_ROTATION: Final = ("rad", "rad/s", "rad/s^2")
# What acts along a speed, by the unit of that.
_EFFORTS: Final[Mapping[str, str]] = {"m/s": "N", "rad/s": "N m"}
_GRAVITY: Final = "gravity_forcing"


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
        kind = kind_of(name)
        if kind is not None and kind.word == FRAME_OUTPUT:
            unit: str | None = MOTION_UNITS.get(name.split(maxsplit=2)[1]) or None
        else:
            is_name = kind is not None or name.isidentifier() or parse_derivative(name) is not None
            unit = None if is_name else expression_unit(name, self.get)
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


def output_units(formed: EquationsOfMotion) -> Units:
    """Return the units of coordinates, rates, parameters, multipliers, and of outputs that are numbers."""
    scope = formed.topology.output_scope
    units = symbol_units(formed.topology.model) | {"t": "s", "work": "J"}
    for asked in list_outputs(scope):
        if asked.kind.word != FRAME_OUTPUT and asked.is_number and (unit := asked.unit(scope)):
            units[asked.text(scope)] = unit
    for name in formed.angles:
        units |= dict(zip((name, f"{name}_dot", f"{name}_ddot"), _ROTATION, strict=True))
    for joint in formed.topology.joints:
        units |= _joint_units(joint)
    for speed in formed.u:
        if units.get(speed.label) in _EFFORTS:
            units[f"{_GRAVITY} {speed.name}"] = _EFFORTS[units[speed.label]]
    own = {part.name: part.multiplier_unit for part in formed.topology.model.constraints}
    rows = (*formed.rows, *formed.coupled.rows)
    units |= {row.name: own[row.element] for row in rows if own.get(row.element)}
    return Units(units | _signal_units(formed, Units(units)))


def _signal_units(formed: EquationsOfMotion, listed: Units) -> dict[str, str]:
    """Return the units of signals that name outputs."""
    outputs = {signal.name: signal.output or "" for signal in formed.topology.model.signals}
    units = {name: listed.get(output, "") for name, output in outputs.items() if output}
    return {name: unit for name, unit in units.items() if unit}


def _joint_units(joint: Joint) -> dict[str, str]:
    """Return the units of a joint's coordinates and speeds."""
    units: dict[str, str] = {}
    turning = joint.rotation_coordinates if joint.quaternion is None else ()
    for names, of_kind in ((joint.translation_coordinates, _TRANSLATION), (turning, _ROTATION)):
        for name in names:
            units |= dict(zip((name, f"{name}_dot", f"{name}_ddot"), of_kind, strict=True))
    for speeds, (_, rate, second) in (
        (joint.translation_speeds, _TRANSLATION),
        (joint.rotation_speeds, _ROTATION),
    ):
        for name in speeds.names if speeds else ():
            units |= {name: rate, f"{name}_dot": second}
    return units
