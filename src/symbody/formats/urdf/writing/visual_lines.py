"""Shapes of bodies as visuals of links."""

from __future__ import annotations

from collections.abc import Iterator
from xml.sax.saxutils import quoteattr

from symbody.formats.urdf.writing.poses import UrdfPose, frame_pose
from symbody.formats.urdf.writing.values import Values
from symbody.model.shapes import BodyShape, Box, Cone, Mesh, Sphere
from symbody.model.shapes.colors import hex_color


def visual_lines(shape: BodyShape, centre: UrdfPose, values: Values, folder: str) -> Iterator[str]:
    """Return the element of a shape; none of a cone, which URDF has no word for.

    Parameters
    ----------
    centre : UrdfPose
        Of the body's centre of mass, from the frame of its link.
    folder : str
        Where the file stands: paths of meshes lead from there.
    """
    if isinstance(shape, Cone):
        return
    yield "    <visual>"
    yield f"      {centre.then(frame_pose(shape.frame, values)).origin()}"
    yield f"      <geometry>{_geometry(shape, values, folder)}</geometry>"
    opacity = values.text(shape.opacity)
    if shape.color or opacity != "1":
        color = hex_color(shape.color) or "#b4b4b4"
        shares = [f"{int(color[k : k + 2], 16) / 255:.6g}" for k in (1, 3, 5)]
        rgba = " ".join([*shares, opacity])
        yield f'      <material name="{color} {opacity}"><color rgba="{rgba}"/></material>'
    yield "    </visual>"


def _geometry(shape: BodyShape, values: Values, folder: str) -> str:
    """Return the form of a shape."""
    if isinstance(shape, Mesh):
        scale = " ".join(values.text(factor) for factor in shape.scale)
        return f'<mesh filename={quoteattr(shape.path_from(folder))} scale="{scale}"/>'
    sizes = [values.text(formula) for _, formula in shape.lengths]
    if isinstance(shape, Box):
        return f'<box size="{" ".join(sizes)}"/>'
    if isinstance(shape, Sphere):
        return f'<sphere radius="{sizes[0]}"/>'
    return f'<{type(shape).__name__.lower()} radius="{sizes[0]}" length="{sizes[1]}"/>'
