"""Points and vectors, their products and their motion."""

from __future__ import annotations

from symbody.equations.by_hand.mechanism import PlacedForce, PlacedTorque
from symbody.expr.sympy.sympy_writer import SympyExpr, SympyMatrix
from symbody.mbsymba.arguments import as_frame, as_point, as_vector
from symbody.mbsymba.objects import BODY, FORCE, FRAME, POINT, TORQUE, VECTOR
from symbody.mbsymba.workplace import WORKPLACE, to_sympy_expressions, triple
from symbody.spatial.moving import acceleration as acceleration_of
from symbody.spatial.moving import angular_velocity as angular_velocity_of
from symbody.spatial.moving import velocity as velocity_of
from symbody.spatial.placed import GROUND_FRAME, PlacedPoint, PlacedVector, vector_between

Scalar = SympyExpr | float
AnyFrame = FRAME | SympyMatrix
AnyVector = VECTOR | FORCE | TORQUE


def make_POINT(RF: AnyFrame, x: Scalar, y: Scalar, z: Scalar) -> POINT:
    """Return the point with coordinates x, y, z in a frame."""
    return POINT(PlacedPoint(as_frame(RF, "make_POINT"), triple(x, y, z)))


def make_VECTOR(RF: AnyFrame, x: Scalar, y: Scalar, z: Scalar) -> VECTOR:
    """Return the vector with components x, y, z in a frame."""
    return VECTOR(PlacedVector(as_frame(RF, "make_VECTOR"), triple(x, y, z)))


def join_points(P: POINT, Q: POINT) -> VECTOR:
    """Return the vector from P to Q, in the frame of P."""
    return VECTOR(vector_between(as_point(P, "join_points"), as_point(Q, "join_points")))


def project(thing: POINT | VECTOR | FORCE | TORQUE, RF: AnyFrame) -> POINT | VECTOR | FORCE | TORQUE:
    """Return the same point, vector, force or torque, expressed in a frame."""
    frame = as_frame(RF, "project")
    if isinstance(thing, POINT):
        return POINT(thing.placed.express_in(frame))
    if isinstance(thing, FORCE):
        f = thing.placed
        return FORCE(PlacedForce(f.vector.express_in(frame), f.point, f.on, f.reaction_on), thing.serial)
    if isinstance(thing, TORQUE):
        m = thing.placed
        return TORQUE(PlacedTorque(m.vector.express_in(frame), m.on, m.reaction_on), thing.serial)
    return VECTOR(as_vector(thing, "project").express_in(frame))


def origin(RF: AnyFrame) -> POINT:
    """Return the origin of a frame."""
    return POINT(PlacedPoint(as_frame(RF, "origin"), triple(0, 0, 0)))


def uvec_X(RF: AnyFrame) -> VECTOR:
    """Return the unit vector along X of a frame."""
    return make_VECTOR(RF, 1, 0, 0)


def uvec_Y(RF: AnyFrame) -> VECTOR:
    """Return the unit vector along Y of a frame."""
    return make_VECTOR(RF, 0, 1, 0)


def uvec_Z(RF: AnyFrame) -> VECTOR:
    """Return the unit vector along Z of a frame."""
    return make_VECTOR(RF, 0, 0, 1)


def comp_X(v: AnyVector | POINT) -> SympyExpr:
    """Return the component along X of a vector's frame; of a point the coordinate."""
    return comp_XYZ(v)[0]


def comp_Y(v: AnyVector | POINT) -> SympyExpr:
    """Return the component along Y of a vector's frame; of a point the coordinate."""
    return comp_XYZ(v)[1]


def comp_Z(v: AnyVector | POINT) -> SympyExpr:
    """Return the component along Z of a vector's frame; of a point the coordinate."""
    return comp_XYZ(v)[2]


def comp_XYZ(v: AnyVector | POINT) -> list[SympyExpr]:
    """Return the three components of a vector in its frame; of a point the coordinates."""
    return to_sympy_expressions(
        v.placed.coordinates if isinstance(v, POINT) else as_vector(v, "comp_XYZ").components
    )


def dot_prod(u: AnyVector, v: AnyVector) -> SympyExpr:
    """Return the scalar product: 0 for vectors at right angles."""
    return to_sympy_expressions([as_vector(u, "dot_prod").dot(as_vector(v, "dot_prod"))])[0]


def cross_prod(u: AnyVector, v: AnyVector) -> VECTOR:
    """Return the vector product u x v by the right-hand rule, in the frame of u: null for parallel ones."""
    return VECTOR(as_vector(u, "cross_prod").cross(as_vector(v, "cross_prod")))


def velocity(P: POINT | FRAME | BODY) -> VECTOR:
    """Return the velocity of a point relative to ground, in the point's frame.

    Of a frame that of its origin, of a body that of its centre of mass.
    """
    return VECTOR(velocity_of(as_point(P, "velocity")))


def acceleration(P: POINT | FRAME | BODY) -> VECTOR:
    """Return the acceleration of a point relative to ground, in the point's frame."""
    return VECTOR(acceleration_of(as_point(P, "acceleration")))


def angular_velocity(RF: AnyFrame | BODY, RF2: AnyFrame | BODY | None = None) -> VECTOR:
    """Return the angular velocity of RF relative to RF2, or to ground, in RF."""
    first, second = (_frame_axes(item) for item in (RF, RF2))
    return VECTOR(angular_velocity_of(WORKPLACE.graph, as_frame(first, "angular_velocity"), second.placed))


def _frame_axes(given: AnyFrame | BODY | None) -> FRAME:
    """Return the axes that something turns with; of nothing those of ground."""
    if given is None:
        return FRAME(GROUND_FRAME)
    return given.frame if isinstance(given, BODY) else FRAME(as_frame(given, "angular_velocity"))
