"""Mass and inertia of a body on the graph."""

from __future__ import annotations

from dataclasses import dataclass

from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr
from symbody.model.body import Body
from symbody.spatial.dyadic import Dyadic, symmetric_split


@dataclass(frozen=True, slots=True)
class Inertia:
    """Mass and inertia of a body about its centre of mass.

    Attributes
    ----------
    frame : str
        The body's frame, origin at the centre of mass.
    tensor : Dyadic
        Products are tensor entries.
    """

    frame: str
    mass: Expr
    tensor: Dyadic


@dataclass(frozen=True, slots=True)
class Rotor:
    """An inertia that moves with the rate of a joint coordinate.

    Attributes
    ----------
    rate : Expr
        In the speeds, or in time alone if the coordinate is prescribed.
    coordinate : str
        Its name; several coordinates may have one rate.
    """

    rate: Expr
    inertia: Expr
    coordinate: str


def form_inertia(names: Names, body: Body) -> Inertia:
    """Return the mass and inertia of a body of the model."""
    where = f"body {body.name}"
    xx, yy, zz = names.triple(body.inertia, where)
    xy, xz, yz = names.triple(body.products, where)
    tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    return Inertia(body.name, names.expression(body.mass, where), symmetric_split(body.name, tensor))
