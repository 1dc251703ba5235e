"""`Mesh`: a shape from a file of triangles."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

from symbody.arguments import checked_arguments
from symbody.expr.language.formula import Formula
from symbody.model.door import Door, Value
from symbody.model.shapes.shape import BodyShape, Rows, Turns, set_shape
from symbody.model.uses import Scope, Triple, Use, triple_uses


@final
@dataclass(frozen=True, slots=True, init=False)
class Mesh(BodyShape):
    """Triangles of a file: STL, OBJ, glTF or GLB, DAE.

    Parameters
    ----------
    path : str or path
        Of the file; one that is not absolute starts from `folder`. Whether it is there is seen when it is
        drawn.
    scale : number, formula or three of them
        Metres for one unit of the file, along x, y and z.
    folder : str
        Where the path starts: that of the model file that names it; "" is the working directory.
    at : (3,) number or formula
        Origin of the file's axes [m], in the body's axes from its centre of mass.
    rotate : iterable of (axis, angle)
        Successive turns from the body's axes to its own.
    matrix : (3, 3) number or formula, optional
        Rotation matrix instead of turns.
    color : str
        ``"#rrggbb"``, a CSS name, or "" for the colour of the body.
    opacity : number or formula
        From 0 to 1.

    Raises
    ------
    ModelError
        With everything that is not a formula or a colour.
    """

    path: str
    scale: Triple
    folder: str = field(compare=False)

    @checked_arguments
    def __init__(
        self,
        path: str | os.PathLike[str],
        scale: Value | Iterable[Value] = 1,
        at: Iterable[Value] = (0, 0, 0),
        rotate: Turns = (),
        matrix: Rows | None = None,
        color: str = "",
        opacity: Value = 1,
        folder: str = "",
    ) -> None:
        sizes = {"path": (_path, path), "scale": (_scale, scale)}
        object.__setattr__(self, "folder", folder)
        set_shape(self, sizes, at, rotate, matrix, color, opacity)

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """None: a scale may be negative, which mirrors."""
        return ()

    def uses(self, path: str) -> Iterator[Use]:
        """Return where the formulas stand, below `path`."""
        yield from triple_uses(f"{path}.scale", self.scale, Scope.CONSTANT)
        yield from BodyShape.uses(self, path)

    @property
    def place(self) -> str:
        """The path of the file from the working directory."""
        return os.path.join(self.folder, self.path)

    def path_from(self, folder: str) -> str:
        """Return the path from another folder, with slashes; absolute paths and addresses stay."""
        is_same = os.path.realpath(folder) == os.path.realpath(self.folder)
        if is_same or os.path.isabs(self.path) or "://" in self.path:
            return self.path
        try:
            return Path(os.path.relpath(self.place, folder)).as_posix()
        except ValueError:  # on another drive
            return os.path.abspath(self.place)


def _path(door: Door, value: object, path: str) -> str:
    text = os.fsdecode(value) if isinstance(value, str | os.PathLike) else ""
    if not text.strip() or not text.isprintable():
        door.refuse(
            "model.mesh_path", path, f"{value!r} is not the path of a file", "",
            'write the path of a file, such as "meshes/link.stl"',
        )  # fmt: skip
    return text


def _scale(door: Door, value: object, path: str) -> Triple:
    """Return three factors from three, or from one for all directions."""
    if isinstance(value, Iterable) and not isinstance(value, str):
        return door.triple(value, path)
    factor = door.formula(value, path)
    return (factor, factor, factor)
