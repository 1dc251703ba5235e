"""Gaps and points of contact of pairs of shapes: planes with solids, solids with each other, hollow ones.

Each function takes a pair in the order of its name. Distances of what has an axis follow Ericson, *Real-Time
Collision Detection* (2005), chapter 5; the lowest point of a rim is that of `equations.constraints.rolling`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import Final

from symbody.equations.contacts.contact_geometry import (
    ContactGeometry,
    PlacedShape,
    ShapePair,
    Touch,
    choose,
    is_less,
    perpendicular,
    unit_vector,
)
from symbody.equations.contacts.surfaces import cam_and_ball, height_and_ball
from symbody.equations.kinematics.joint_axes import perpendiculars
from symbody.equations.kinematics.motion import Kinematics
from symbody.equations.kinematics.naming import Names
from symbody.expr.expression import Expr, maximum, minimum, number, sqrt
from symbody.expr.opcodes import ABS
from symbody.model.contacts.contact import Contact
from symbody.model.contacts.contact_shapes import PAIRS, ContactShape
from symbody.spatial.matrix import Triple
from symbody.spatial.vector import ZERO, Vector, in_simplest_frame, vector

# Squares of sines below which two axes count as parallel.
_PARALLEL: Final = 1e-12


def contact_geometry(names: Names, kinematics: Kinematics, contact: Contact) -> ContactGeometry:
    """Return where the shapes of a contact touch, with the normal from start to end."""
    where = f"contact {contact.name}"
    start, end = (
        _place_shape(names, shape, place.full_name, where)
        for shape, place in zip(contact.shapes, (contact.start, contact.end), strict=True)
    )
    function = _FUNCTIONS.get((start.word, end.word))
    if function is not None:
        return function(ShapePair(names, kinematics, start, end, where))
    pair = ShapePair(names, kinematics, end, start, where)
    turned = _FUNCTIONS[end.word, start.word](pair)
    back = kinematics.position(start.frame, end.frame)
    touches = tuple(Touch(touch.gap, touch.point + back) for touch in turned.touches)
    return turned._replace(normal=-turned.normal, touches=touches)


def _place_shape(names: Names, shape: ContactShape, frame: str, where: str) -> PlacedShape:
    if shape.word in ("height", "cam"):
        return PlacedShape(shape.word, frame, (), shape.sizes[0])
    return PlacedShape(shape.word, frame, tuple(names.expression(size, where) for size in shape.sizes))


def _on_plane(pair: ShapePair, balls: list[tuple[Vector, Expr | int]]) -> ContactGeometry:
    """Return the contact of a plane and spheres, given by centre, from the second origin, and radius."""
    normal = pair.axis(pair.first, "z")
    touches = tuple(
        pair.ball(normal, pair.arm + centre, radius, pair.dot(normal, pair.arm + centre))
        for centre, radius in balls
    )
    return ContactGeometry(normal, pair.axis(pair.first, "x"), touches, pair.home(pair.first))


def plane_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a plane and a sphere or point."""
    return _on_plane(pair, [(ZERO, pair.second.radius)])


def plane_and_capsule(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a plane and the two ends of a capsule."""
    radius, length = pair.second.sizes
    half = _axle(pair) * (length / 2)
    return _on_plane(pair, [(half, radius), (-half, radius)])


def plane_and_box(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a plane and the eight corners of a box."""
    edges = pair.second.sizes
    home = pair.home(pair.second)
    corners = [
        vector(home, (edges[0] / 2 * a, edges[1] / 2 * b, edges[2] / 2 * c))
        for a, b, c in product((1, -1), repeat=3)
    ]
    return _on_plane(pair, [(corner, 0) for corner in corners])


def plane_and_ring(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a plane and the lowest point of a disc, or of a torus; x where it rolls."""
    forward, down = _rim(pair)
    radius, *tube = pair.second.sizes
    on_plane = _on_plane(pair, [(down * radius, tube[0] if tube else 0)])
    return on_plane._replace(forward=forward)


def plane_and_cylinder(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a plane and three points of the rim at each end of a cylinder.

    They are the lowest and those a third of a turn away: where it stands upright they bear it alike in all
    directions, where it lies the lowest two touch.
    """
    radius, length = pair.second.sizes
    forward, down = _rim(pair)
    half = _axle(pair) * (length / 2)
    sine = sqrt(number(pair.kinematics.graph, 3)) / 2
    around = (down, forward * sine - down * _half(pair), -(forward * sine) - down * _half(pair))
    return _on_plane(pair, [(end + each * radius, 0) for end in (half, -half) for each in around])


def _half(pair: ShapePair) -> Expr:
    return number(pair.kinematics.graph, 1) / 2


def _axle(pair: ShapePair) -> Vector:
    """Return the axis of the second shape, without turns about it."""
    kinematics = pair.kinematics
    return in_simplest_frame(kinematics.tree, pair.axis(pair.second, "z"), kinematics.driven_frames)


def _rim(pair: ShapePair) -> tuple[Vector, Vector]:
    """Return where a disc rolls that spins positively, and from its centre to its lowest point; unit vectors.

    Of one that lies flat each direction is as good.
    """
    axle = _axle(pair)
    ((home, parts),) = axle.terms.items()
    any_forward = vector(home, perpendiculars(pair.kinematics.graph, parts)[0])
    forward, _ = unit_vector(pair, pair.cross(axle, pair.axis(pair.first, "z")), any_forward)
    return forward, pair.cross(axle, forward)


def _between_balls(pair: ShapePair, near: Vector, far: Vector, along: str = "xy") -> ContactGeometry:
    """Return the contact of two spheres, or of what is round about points, by their centres.

    Parameters
    ----------
    along : str
        The axes of the first frame that x is along, of two the first if the normal allows.
    """
    normal, distance = unit_vector(pair, far - near, pair.axis(pair.first, "z"))
    gap = distance - pair.first.radius - pair.second.radius
    touch = Touch(gap, near + normal * (gap / 2 + pair.first.radius))
    return _one_touch(pair, normal, touch, along)


def _one_touch(pair: ShapePair, normal: Vector, touch: Touch, along: str = "xy") -> ContactGeometry:
    return ContactGeometry(normal, perpendicular(pair, normal, *along), (touch,), pair.home(pair.first))


def ball_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of two spheres or points."""
    return _between_balls(pair, ZERO, pair.arm)


def ball_and_capsule(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a sphere or point and a capsule, in the point of its axis that is nearest."""
    axle = pair.axis(pair.second, "z")
    along = _clip(-pair.dot(axle, pair.arm), pair.second.sizes[1] / 2)
    return _between_balls(pair, ZERO, pair.arm + axle * along)


def capsule_and_capsule(pair: ShapePair) -> ContactGeometry:
    """Return the contact of two capsules in the points of their axes that are nearest.

    Of parallel ones it is the middle of the part that is side by side.
    """
    u, w = pair.axis(pair.first, "z"), pair.axis(pair.second, "z")
    near, far = pair.first.sizes[1] / 2, pair.second.sizes[1] / 2
    cosine, a, b = pair.dot(u, w), pair.dot(u, pair.arm), pair.dot(w, pair.arm)
    sine = pair.cross(u, w)
    square = pair.dot(sine, sine)
    graph = pair.kinematics.graph
    is_parallel = is_less(square, number(graph, _PARALLEL))
    middle = (maximum(-near, a - far) + minimum(near, a + far)) / 2
    crossing = (a - cosine * b) / choose(is_parallel, number(graph, 1), square)
    first = _clip(choose(is_parallel, middle, crossing), near)
    second = _clip(cosine * first - b, far)
    first = _clip(a + cosine * second, near)
    return _between_balls(pair, u * first, pair.arm + w * second, "zx")


def box_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a box and a sphere or point."""
    return _box_and_centre(pair, pair.arm)


def box_and_capsule(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a box and a capsule, in the point of its axis that is nearest.

    Of points equally near, along a face or inside, it is the middle one.
    """
    axle = pair.axis(pair.second, "z")
    start, along = pair.components(pair.arm, pair.first), pair.components(axle, pair.first)
    nearest = _nearest_place(start, along, _halves(pair.first), pair.second.sizes[1] / 2)
    return _box_and_centre(pair, pair.arm + axle * nearest)


def _nearest_place(start: Triple, along: Triple, edges: Sequence[Expr], half: Expr) -> Expr:
    """Return where on a line, within `half` of its middle, the distance from a box is least.

    The slope of the squared distance rises along the line, in straight pieces that end where it crosses
    planes of faces. Its zero is between the last end with a slope up to 0 and the first with one from 0 on.
    """
    graph = half.graph
    tiny, one, zero = number(graph, _PARALLEL), number(graph, 1), number(graph, 0)
    places = [half, -half]
    for p, u, edge in zip(start, along, edges, strict=True):
        rate = choose(is_less(u * u, tiny), one, u)
        places += [_clip((side - p) / rate, half) for side in (edge, -edge)]
    low, high, low_slope, high_slope = -half, half, zero, zero
    for place in places:
        slope = zero
        for p, u, edge in zip(start, along, edges, strict=True):
            x = p + u * place
            slope = slope + u * (x - _clip(x, edge))
        raises = choose(is_less(slope, tiny), place, -half)
        lowers = choose(is_less(-slope, tiny), place, half)
        low_slope = choose(is_less(raises, low), low_slope, choose(is_less(slope, tiny), slope, low_slope))
        high_slope = choose(
            is_less(high, lowers), high_slope, choose(is_less(-slope, tiny), slope, high_slope)
        )
        low, high = maximum(low, raises), minimum(high, lowers)
    is_piece = is_less(low, high)
    rise = choose(is_piece, high_slope - low_slope, one)
    return choose(
        is_piece, low - low_slope * (high - low) / choose(is_less(zero, rise), rise, one), (low + high) / 2
    )


def _box_and_centre(pair: ShapePair, centre: Vector) -> ContactGeometry:
    """Return the contact of a box and a sphere about a centre; of one inside, by the nearest face."""
    graph = pair.kinematics.graph
    zero, one = number(graph, 0), number(graph, 1)
    place = pair.components(centre, pair.first)
    edges = _halves(pair.first)
    beyond = [x - _clip(x, edge) for x, edge in zip(place, edges, strict=True)]
    depths = [edge - x.apply(ABS) for x, edge in zip(place, edges, strict=True)]
    depth = minimum(minimum(depths[0], depths[1]), depths[2])
    is_x = is_less(depths[0], minimum(depths[1], depths[2]))
    is_y = is_less(depths[1], depths[2])
    signs = [choose(is_less(x, zero), -one, one) for x in place]
    face = (
        choose(is_x, signs[0], zero),
        choose(is_x, zero, choose(is_y, signs[1], zero)),
        choose(is_x, zero, choose(is_y, zero, signs[2])),
    )
    home = pair.home(pair.first)
    outward = vector(home, (beyond[0], beyond[1], beyond[2]))
    normal, outside = unit_vector(pair, outward, vector(home, face))
    distance = outside + minimum(-depth, zero) * choose(is_less(zero, outside), zero, one)
    return _one_touch(pair, normal, pair.ball(normal, centre, pair.second.radius, distance))


def socket_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a sphere or point with the hollow sphere that it is in."""
    return _in_hollow(pair, pair.arm, "xy")


def hole_and_ball(pair: ShapePair) -> ContactGeometry:
    """Return the contact of a sphere, point or disc of parallel axis in a hollow cylinder."""
    axis = pair.axis(pair.first, "z")
    return _in_hollow(pair, pair.arm - axis * pair.dot(axis, pair.arm), "zx")


def _in_hollow(pair: ShapePair, offset: Vector, along: str) -> ContactGeometry:
    """Return the contact inside of something round, `offset` from its middle or axis."""
    outward, distance = unit_vector(pair, offset, pair.axis(pair.first, "x"))
    hollow = pair.first.sizes[0]
    gap = hollow - pair.second.radius - distance
    touch = Touch(gap, pair.arm - offset + outward * (hollow - gap / 2))
    return _one_touch(pair, -outward, touch, along)


def _clip(x: Expr, half: Expr) -> Expr:
    """Return a value within an interval about 0."""
    return maximum(-half, minimum(half, x))


def _halves(box: PlacedShape) -> list[Expr]:
    """Return half the edges of a box."""
    return [edge / 2 for edge in box.sizes]


PairFunction = Callable[[ShapePair], ContactGeometry]


def _for_all_pairs(functions: dict[tuple[str, str], PairFunction]) -> Mapping[tuple[str, str], PairFunction]:
    """Return the functions, one for each pair that a model may have."""
    odd = functions.keys() ^ PAIRS
    if odd:
        raise LookupError(f"a function without a pair of shapes, or a pair without one: {sorted(odd)}")
    return MappingProxyType(functions)


_FUNCTIONS: Final = _for_all_pairs(
    {
        ("plane", "point"): plane_and_ball,
        ("plane", "sphere"): plane_and_ball,
        ("plane", "capsule"): plane_and_capsule,
        ("plane", "cylinder"): plane_and_cylinder,
        ("plane", "disc"): plane_and_ring,
        ("plane", "torus"): plane_and_ring,
        ("plane", "box"): plane_and_box,
        ("sphere", "sphere"): ball_and_ball,
        ("sphere", "point"): ball_and_ball,
        ("sphere", "capsule"): ball_and_capsule,
        ("point", "capsule"): ball_and_capsule,
        ("capsule", "capsule"): capsule_and_capsule,
        ("box", "sphere"): box_and_ball,
        ("box", "point"): box_and_ball,
        ("box", "capsule"): box_and_capsule,
        ("socket", "sphere"): socket_and_ball,
        ("socket", "point"): socket_and_ball,
        ("hole", "disc"): hole_and_ball,
        ("hole", "sphere"): hole_and_ball,
        ("hole", "point"): hole_and_ball,
        ("height", "point"): height_and_ball,
        ("height", "sphere"): height_and_ball,
        ("cam", "point"): cam_and_ball,
        ("cam", "disc"): cam_and_ball,
        ("cam", "sphere"): cam_and_ball,
    }
)
