"""`load_urdf`: a robot in URDF as a model."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable, Sequence
from typing import Final

from symbody.arguments import checked_arguments
from symbody.errors import ModelError, Problem
from symbody.formats.places import Path, relocate
from symbody.formats.reading import read_text
from symbody.formats.urdf.building.conversion import Parts, convert_robot
from symbody.formats.urdf.building.loops import NO_LOOPS, Loops, read_loops
from symbody.formats.urdf.file.robot import Robot
from symbody.formats.urdf.file.robot_reading import robot_from_text
from symbody.model.declarations.arguments import Value
from symbody.model.element import Element
from symbody.model.frame_index import element_labels
from symbody.model.model import Model

_ROBOT: Final = "robot"


@checked_arguments
def load_urdf(
    path: str | os.PathLike[str],
    floating_base: bool = False,
    symbolic: Collection[str] = (),
    gravity: Iterable[Value] = (0, 0, -9.81),
    snap_angles: float = 0,
    loops: str | os.PathLike[str] | None = None,
) -> Model:
    """Return the model of a robot in a URDF file.

    Links held together by fixed joints are one body, named after the first, with a frame for each link.
    Coordinates are named after the joints; each joint that moves, except those that follow others and those
    that float, has the input ``tau_<joint>``, its effort. What was assumed, made exact or ignored is in
    `Model.notes`. Visuals are shapes of the bodies; collision shapes are left out.

    Parameters
    ----------
    path : str or path
        The file.
    floating_base : bool
        Whether the root link moves freely, with coordinates base_x, base_y, base_z, base_qw .. base_qz and
        speeds base_vx .. base_vz, base_wx .. base_wz along axes of the base; otherwise it is the ground.
    symbolic : collection of str
        Links that stay bodies of their own, whose mass, centre and inertia are the parameters ``<link>_m``,
        ``_cx``, ``_cy``, ``_cz``, ``_Ixx``, ``_Iyy``, ``_Izz``, ``_Ixy``, ``_Ixz``, ``_Iyz`` in axes
        of the link; their values are the file's.
    gravity : (3,) number or formula
        Acceleration of free fall in axes of the ground [m/s^2].
    snap_angles : float
        Angles this near to a multiple of pi/12 are taken as that [rad]; nearer than 2e-11 they always are.
    loops : str or path, optional
        A TOML file of joints, constraints and springs in the syntax of the model file, between links.

    Returns
    -------
    Model
        The robot; what was assumed is in its ``notes``.

    Raises
    ------
    FormatError
        If a file cannot be read, is not XML, or has elements and numbers that do not fit.
    ModelError
        If links and joints form no tree, or the mechanism contradicts itself.
    UsageError
        If an argument names a link that is not there, or the base would float twice.

    Notes
    -----
    The meaning of elements and attributes is that of https://wiki.ros.org/urdf/XML.

    Examples
    --------
    >>> import symbody as sb
    >>> robot = sb.load_urdf("ur5.urdf", floating_base=False)  # doctest: +SKIP
    >>> eqs = sb.form_equations(robot)  # doctest: +SKIP
    """
    text = read_text(path)
    return model_from_urdf(text, os.fsdecode(path), floating_base, symbolic, gravity, snap_angles, loops)


def model_from_urdf(
    text: str,
    where: str = "robot",
    floating_base: bool = False,
    symbolic: Collection[str] = (),
    gravity: Iterable[Value] = (0, 0, -9.81),
    snap_angles: float = 0,
    loops: str | os.PathLike[str] | None = None,
) -> Model:
    """Return the model of a URDF text, which messages call `where`; faults as of `load_urdf`."""
    robot = robot_from_text(text, where, snap_angles)
    named = [symbolic] if isinstance(symbolic, str) else list(symbolic)
    parts = convert_robot(robot, floating_base, named)
    return _assemble(robot, parts, gravity, loops)


def _assemble(
    robot: Robot, parts: Parts, gravity: Iterable[Value], loops: str | os.PathLike[str] | None
) -> Model:
    extra = NO_LOOPS if loops is None else read_loops(loops, parts)
    elements = [*extra.with_frames(parts.elements), *extra.elements]
    parameters: dict[str, Value | None] = {**parts.parameters, **extra.parameters}
    try:
        return Model(
            robot.name,
            elements,
            gravity=gravity,
            parameters=parameters,
            inputs=(*parts.inputs, *extra.inputs),
            initial=extra.initial,
            ground={**parts.ground, **extra.ground_frames},
            notes=parts.notes,
            ground_shapes=parts.ground_shapes,
        )
    except ModelError as error:
        raise ModelError(*_add_lines(error.problems, robot, parts, elements, extra)) from None


def _add_lines(
    problems: Iterable[Problem], robot: Robot, parts: Parts, elements: Sequence[Element], extra: Loops
) -> list[Problem]:
    """Return problems of the model with lines of the robot's file, or of the loops."""
    labels = element_labels(elements)
    added = len(elements) - len(extra.elements)
    bases: dict[str, Path] = {"model": ()}
    for k, label in labels.items():
        bases[label] = extra.paths[k - added] if k >= added and extra.paths else (_ROBOT, label)

    def locate(path: Path) -> str:
        if path and path[0] != _ROBOT:
            return extra.locate(path)
        line = parts.lines.get(str(path[1])) if path else None
        return robot.where if line is None else f"{robot.where}:{line}"

    return relocate(problems, bases, locate)
