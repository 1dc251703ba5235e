"""`Mesh`: a shape from a file of triangles."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments, Value
from symbody.model.declarations.declaration import Field
from symbody.model.declarations.fields import FilePath, Quantity, Text, VectorQuantity, part
from symbody.model.declarations.formula_site import FormulaSite, Scope, Triple, component_sites
from symbody.model.frame import RotationMatrix, Turns
from symbody.model.shapes.shape import COLOR, MATRIX, OPACITY, ROTATE, BodyShape, Color


class ScaleFactors(Field[Value | Iterable[Value], Triple]):
    """A factor for all directions, or three."""

    role: ClassVar[str] = "factors"
    takes: ClassVar[str] = "number, formula or three of them"
    annotation: ClassVar[str] = "Value | Iterable[Value]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Triple:
        """Return three formulas."""
        return _scale(arguments, value, path)

    def formula_sites(self, owner: object, value: Triple, path: str) -> Iterator[FormulaSite]:
        """Return where the factors stand."""
        return component_sites(path, value, Scope.CONSTANT)


@final
@part
class Mesh(BodyShape):
    """Triangles from a file: STL, OBJ, glTF or GLB, DAE."""

    path: FilePath = FilePath(
        "Path of the file, relative to the directory of the model file, or to `folder`."
    )
    scale: ScaleFactors = ScaleFactors("Metres per unit of the file; one number or three.", default=1)
    at: VectorQuantity = VectorQuantity(
        "Origin of the file's axes, relative to the centre of mass, in the body's axes.",
        unit="m",
        default=(0, 0, 0),
    )
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY
    folder: Text = Text(
        'Directory that the path is relative to: that of the model file; "" is the working directory.',
        default="",
        is_content=False,
    )

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """None: a scale may be negative, which mirrors."""
        return ()

    @property
    def place(self) -> str:
        """The path of the file from the working directory."""
        return os.path.join(self.folder, self.path)

    def path_from(self, folder: str) -> str:
        """Return the path from another folder, with slashes; absolute paths and addresses do not change."""
        is_same = os.path.realpath(folder) == os.path.realpath(self.folder)
        if is_same or os.path.isabs(self.path) or "://" in self.path:
            return self.path
        try:
            return Path(os.path.relpath(self.place, folder)).as_posix()
        except ValueError:  # on another drive
            return os.path.abspath(self.place)


def _scale(arguments: Arguments, value: object, path: str) -> Triple:
    """Return three factors from three, or from one for all directions."""
    if isinstance(value, Iterable) and not isinstance(value, str):
        return arguments.triple(value, path)
    factor = arguments.formula(value, path)
    return (factor, factor, factor)
