"""What is drawn: outputs of a motion as curves with names and units, over time or as paths."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from symbody.equations.outputs.units import Units
from symbody.errors import Problem, UsageError
from symbody.simulation.results.trajectory import Trajectory
from symbody.visual.plotting.axis_labels import plain, printed_length, readable, shown_unit, typed_unit

Floats = NDArray[np.float64]

# A unit at the end of a label; digits in brackets are the place of a component.
UNIT: Final = re.compile(r"\[([^\[\]\d][^\[\]]*)\]$")

# What a unit measures, for an axis that several curves share.
QUANTITIES: Final[Mapping[str, str]] = {
    "rad": "angle",
    "deg": "angle",
    "rad/s": "angular velocity",
    "rad/s^2": "angular acceleration",
    "m": "length",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "N": "force",
    "N m": "torque",
    "J": "energy",
    "W": "power",
    "kg": "mass",
    "N/m": "stiffness",
    "kg m^2": "moment of inertia",
}

_FLAT: Final = 1e-9  # of the largest extent: what a path may leave its plane by


@dataclass(frozen=True, slots=True, eq=False)
class PlottedCurve:
    """A name, a unit that may be unknown, one value a sample, and the name as matplotlib prints it."""

    name: str
    unit: str
    values: Floats
    label: str

    @property
    def text(self) -> str:
        """The label with the unit."""
        return with_unit(self.label, shown_unit(self.unit))

    @property
    def shown_unit(self) -> str:
        """The unit at the end of the text, which a label may have brought along."""
        at_end = UNIT.search(self.label)
        return typed_unit(at_end[1]) if at_end else self.unit


@dataclass(frozen=True, slots=True, eq=False)
class PlanePath:
    """Curves that are drawn over each other: two in the plane, three in space."""

    name: str
    curves: tuple[PlottedCurve, ...]
    label: str


Drawn = TypeVar("Drawn", PlottedCurve, PlanePath)


def curves_of(run: Trajectory, expression: str) -> list[PlottedCurve]:
    """Return the components of an output, under names that are short enough for a legend."""
    columns = run.columns(expression, names="outputs")
    states = (*run.coordinate_names, *run.speed_names, *run.signal_state_names)
    return [
        PlottedCurve(_short(name), _unit(run, expression, name), values, readable(_short(name), states))
        for name, values in columns.items()
    ]


def single_curve(run: Trajectory, expression: str) -> PlottedCurve:
    """Return the curve of what runs along the horizontal axis.

    Raises
    ------
    UsageError
        If the output has several components.
    """
    if expression == "t":
        return PlottedCurve("time", "s", np.atleast_1d(run.t), "time")
    found = curves_of(run, expression)
    if len(found) > 1:
        names = ", ".join(repr(name) for name in run.columns(expression))
        fix = f"choose a component: x={names}"
        what = f"{expression!r} has {len(found)} components"
        raise UsageError(Problem("plot.across", f"x={expression!r}", what, fix=fix))
    return found[0]


def path_of(run: Trajectory, expressions: Sequence[str]) -> PlanePath:
    """Return the path through the components of some outputs.

    Raises
    ------
    UsageError
        If there are not two or three components.
    """
    curves = [curve for expression in expressions for curve in curves_of(run, expression)]
    if not 2 <= len(curves) <= 3:
        names = ", ".join(curve.name for curve in curves)
        raise UsageError(
            Problem("plot.path", repr(tuple(expressions)), f"a path has 2 or 3 components, not {len(curves)}",
                    f"they are {names}", "name two or three outputs, or one vector: ('frame r P',)")
        )  # fmt: skip
    stem = _common_stem([curve.name for curve in curves])
    name = stem or ", ".join(curve.name for curve in curves)
    return PlanePath(
        name, tuple(curves), readable(stem) if stem else ", ".join(curve.label for curve in curves)
    )


def in_their_plane(paths: Sequence[PlanePath]) -> Sequence[PlanePath]:
    """Return paths in space without the component that is constant along each of them, if there is one."""
    if {len(path.curves) for path in paths} != {3}:
        return paths
    ranges = np.array([[float(np.ptp(curve.values)) for curve in path.curves] for path in paths])
    still = np.flatnonzero((ranges <= _FLAT * ranges.max(initial=0.0)).all(axis=0))
    if not still.size or not np.isfinite(ranges).all():
        return paths
    left = int(still[-1])  # of a straight line z, then y
    return [
        replace(path, curves=tuple(curve for k, curve in enumerate(path.curves) if k != left))
        for path in paths
    ]


def _common_stem(names: Sequence[str]) -> str:
    """Return ``"r P"`` for ``"r P x"``, ``"r P y"``, or nothing."""
    stems = {name[:-2] if name[-2:] in (" x", " y", " z") else "" for name in names}
    return stems.pop() if len(stems) == 1 else ""


def rename_curves(drawn: list[Drawn], labels: Sequence[str] | None) -> list[Drawn]:
    """Return curves or paths under the labels of the caller.

    Raises
    ------
    UsageError
        If there are too few labels, or too many.
    """
    if labels is None:
        return drawn
    if isinstance(labels, str) or len(labels) != len(drawn):
        count = "one text" if isinstance(labels, str) else f"{len(labels)}"
        what = f"{len(drawn)} curves need {len(drawn)} labels, not {count}"
        fix = f"give a list of labels for {', '.join(each.name for each in drawn)}, in this order"
        raise UsageError(Problem("plot.labels", "labels", what, fix=fix))
    return [replace(each, label=plain(label)) for each, label in zip(drawn, labels, strict=True)]


def shared_quantity(labels: Sequence[str]) -> str:
    """Return the quantity of all labels, such as "angle [rad]", or nothing if they differ."""
    units = {at_end[1] if (at_end := UNIT.search(label)) else "" for label in labels}
    unit = units.pop() if len(units) == 1 else ""
    return with_unit(QUANTITIES.get(typed_unit(unit), ""), unit)


def shared_label(labels: Sequence[str], letters: int) -> str:
    """Return the names with their unit, ``"theta, phi [rad]"``; too many letters: what they measure."""
    names = [UNIT.sub("", label).rstrip() for label in dict.fromkeys(labels)]
    ends = {label[len(name) :] for label, name in zip(dict.fromkeys(labels), names, strict=True)}
    text = ", ".join(names) + (next(iter(ends)) if len(ends) == 1 else "")
    has_room = len(names) == 1 or printed_length(text) <= letters
    return text if len(ends) == 1 and has_room else shared_quantity(labels)


def with_unit(name: str, unit: str) -> str:
    """Return ``"x [m]"``; a name that ends in a unit keeps its own."""
    return f"{name} [{unit}]".lstrip() if unit and not UNIT.search(name) else name


def _short(name: str) -> str:
    """Return the name of a motion without what is plain: "r P x" for "frame r P ground ground x"."""
    words = name.split(" ")
    if words[0] != "frame" or '"' in name:
        return name
    return " ".join([*words[1:3], *(word for word in words[3:] if word.lower() != "ground")])


def _unit(run: Trajectory, expression: str, name: str) -> str:
    """Return the unit of a component, or nothing if its name does not determine it."""
    units = Units(run.units)
    unit = units.get(expression, units.get(name))
    if unit is not None:
        return unit
    rate = run.units.get(f"{expression.removesuffix('_ddot')}_dot", "")
    return f"{rate}^2" if expression.endswith("_ddot") and rate.endswith("/s") else ""
