"""Shapes with sizes, and meshes from files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any, ClassVar, final

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import Arguments
from symbody.model.declarations.field import FileTarget, Node
from symbody.model.declarations.fields import (
    THREE_FORMULAS,
    FilePath,
    Folder,
    Quantity,
    VectorQuantity,
    part,
)
from symbody.model.declarations.formula_site import Triple
from symbody.model.declarations.misfits import (
    FORMULA_SCHEMA,
    Misfit,
    Path,
    Schema,
    formula_misfits,
    wrong_type,
)
from symbody.model.frame import RotationMatrix, Turns
from symbody.model.numeric_checks import FINITE
from symbody.model.shapes.shape import CENTRE, COLOR, MATRIX, OPACITY, ROTATE, SIZES, BodyShape, Color
from symbody.model.tables.inner_path import path_from


@final
@part
class Box(BodyShape):
    """A box with its edges along its axes.

    Examples
    --------
    >>> import symbody as sb
    >>> box = sb.Box((0.4, 0.1, 0.1), at=(0.2, 0, 0), color="steelblue")
    >>> link = sb.Body("Link", mass="m", shapes=[box])
    """

    size: VectorQuantity = VectorQuantity("Edges along x, y and z.", unit="m", item=Quantity(fits=SIZES))
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The edges."""
        return tuple((f"size[{k}]", edge) for k, edge in enumerate(self.size))


@part
class RoundShape(BodyShape):
    """A shape about its z axis, given by a radius and a length."""

    radius: Quantity = Quantity(unit="m", fits=SIZES)
    length: Quantity = Quantity(unit="m", fits=SIZES)
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """Radius and length."""
        return (("radius", self.radius), ("length", self.length))


@final
@part
class Cylinder(RoundShape):
    """A cylinder about its z axis.

    Examples
    --------
    >>> import symbody as sb
    >>> along_x = sb.Cylinder(radius=0.02, length="L", rotate=[("y", "pi/2")])
    >>> body = sb.Body("Rod", mass="m", shapes=[along_x])
    """


@final
@part
class Capsule(RoundShape):
    """A cylinder about its z axis with half a sphere on each end.

    Examples
    --------
    >>> import symbody as sb
    >>> leg = sb.Capsule(radius=0.05, length=0.4, color="gray")
    >>> body = sb.Body("Leg", mass="m", shapes=[leg])
    """

    length: Quantity = Quantity("Length without the caps.", unit="m", fits=SIZES)


@final
@part
class Cone(RoundShape):
    """A cone that points along its z axis; its centre is half way up the axis.

    Examples
    --------
    >>> import symbody as sb
    >>> top = sb.Cone(radius=0.05, length=0.1, rotate=[("x", "pi")])
    >>> body = sb.Body("Top", mass="m", shapes=[top])
    """

    radius: Quantity = Quantity("Radius of its base.", unit="m", fits=SIZES)
    length: Quantity = Quantity("Height from base to tip.", unit="m", fits=SIZES)


@final
@part
class Sphere(BodyShape):
    """A sphere.

    Examples
    --------
    >>> import symbody as sb
    >>> ball = sb.Sphere("R", color="#cc3311", opacity=0.5)
    >>> body = sb.Body("Ball", mass="m", shapes=[ball])
    """

    radius: Quantity = Quantity(unit="m", fits=SIZES)
    at: VectorQuantity = CENTRE
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY

    @property
    def lengths(self) -> tuple[tuple[str, Formula], ...]:
        """The radius."""
        return (("radius", self.radius),)


class ScaleFactors(VectorQuantity):
    """A factor for all directions, or three."""

    role: ClassVar[str] = "factors"
    takes: ClassVar[str] = "number, formula or three of them"
    annotation: ClassVar[str] = "Value | Iterable[Value]"

    def read(self, owner: object, arguments: Arguments, value: object, path: str) -> Triple:
        """Return three formulas."""
        if isinstance(value, Iterable) and not isinstance(value, str):
            return arguments.triple(value, path)
        factor = arguments.formula(value, path)
        return (factor, factor, factor)

    def schema(self) -> Schema:
        """Return one formula or three."""
        return {"anyOf": [FORMULA_SCHEMA, THREE_FORMULAS]}

    def misfits(self, entry: object, path: Path) -> Iterable[Misfit]:
        """Return the misfits of one formula or three."""
        if isinstance(entry, dict) or (isinstance(entry, list) and len(entry) != 3):
            return wrong_type(entry, path, "a number, or three")
        return (
            VectorQuantity.misfits(self, entry, path)
            if isinstance(entry, list)
            else formula_misfits(entry, path)
        )

    def to_file(self, owner: Any, value: Any, target: FileTarget) -> Node | None:
        """Return one factor where all are the same."""
        factors: list[Node] = list(value)
        return factors[0] if len(set(value)) == 1 else factors


@final
@part
class Mesh(BodyShape):
    """Triangles from a file: STL, OBJ, glTF or GLB, DAE.

    Examples
    --------
    >>> import symbody as sb
    >>> shell = sb.Mesh("base_link.stl", scale=0.001, color="silver")
    >>> body = sb.Body("Base", mass="m", shapes=[shell])
    """

    path: FilePath = FilePath(
        "Path of the file, relative to the directory of the model file, or to `folder`."
    )
    scale: ScaleFactors = ScaleFactors("Metres per unit of the file; one number or three.", default=1)
    at: VectorQuantity = VectorQuantity(
        "Origin of the file's axes, relative to the centre of mass, in the body's axes.",
        unit="m", default=(0, 0, 0), item=Quantity(fits=FINITE),
    )  # fmt: skip
    rotate: Turns = ROTATE
    matrix: RotationMatrix = MATRIX
    color: Color = COLOR
    opacity: Quantity = OPACITY
    folder: Folder = Folder(
        'Directory that the path is relative to: that of the model file; "" is the working directory.'
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
        is_fixed = os.path.isabs(self.path) or "://" in self.path
        return self.path if is_fixed else path_from(self.path, self.folder, folder)
