"""Chapters 1 and 2 of the notes, line by line: frames, points, vectors, constraint equations."""

from __future__ import annotations

import math

import pytest
import sympy as sp
from sympy import cos, sin
from sympy.physics.vector import dynamicsymbols

from symbody import mbsymba as mb
from tests.mbsymba.spots import all_same, same, value

th1, th2, th3, th4 = dynamicsymbols("theta1:5")
x10, x20, x30, x40 = dynamicsymbols("x10 x20 x30 x40")
y10, y20, y30, y40 = dynamicsymbols("y10 y20 y30 y40")
s = dynamicsymbols("s")
beta1, beta2, L = sp.symbols("beta1 beta2 L")
# The numbers of the checklist; the values below were found there by an independent construction.
DATA = {
    th1: 0.3, th2: 0.7, th3: -0.4, th4: 1.1, x10: 1.2, y10: -0.5, x20: 2.1, y20: 0.8, x30: -0.6, y30: 1.7,
    x40: 0.9, y40: -1.3, s: 0.45, beta1: 0.35, beta2: 0.25, L: 1.5,
}  # fmt: skip
# They are given with this many digits.
DIGITS = 5.1e-7


def body_frames() -> list[mb.FRAME]:
    places = [(x10, y10, th1), (x20, y20, th2), (x30, y30, th3), (x40, y40, th4)]
    return [mb.translate(x, y, 0) * mb.rotate("Z", angle) for x, y, angle in places]


def test_global_frames_are_printed_as_in_the_notes() -> None:
    RF1, RF2, *_ = body_frames()
    for frame, x, y, a in ((RF1, x10, y10, th1), (RF2, x20, y20, th2)):
        rows = [[cos(a), -sin(a), 0, x], [sin(a), cos(a), 0, y], [0, 0, 1, 0], [0, 0, 0, 1]]
        assert frame.matrix == sp.Matrix(rows)


def test_recursive_frames() -> None:
    RF1 = body_frames()[0]
    RF2 = RF1 * mb.rotate("Z", th2)
    RF3 = RF2 * mb.translate(s, 0, 0)
    c, d = cos(th1) * cos(th2) - sin(th1) * sin(th2), sin(th1) * cos(th2) + cos(th1) * sin(th2)
    assert all_same(RF2.matrix, [c, -d, 0, x10, d, c, 0, y10, 0, 0, 1, 0, 0, 0, 0, 1])
    assert all_same(RF3.matrix.col(3), [c * s + x10, d * s + y10, 0, 1])
    assert value(RF3.matrix[0, 3], DATA) == pytest.approx(1.443136, abs=DIGITS)
    assert value(RF3.matrix[1, 3], DATA) == pytest.approx(-0.121338, abs=DIGITS)


def test_natural_frames() -> None:
    ux, uy, x, y = dynamicsymbols("u1_x u1_y x1 y1")
    matrix = sp.Matrix([[ux, -uy, 0, x], [uy, ux, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]])
    P = mb.project(mb.make_POINT(matrix, 1, 2, 0), mb.ground)
    assert all_same(P.coords, [ux - 2 * uy + x, uy + 2 * ux + y, 0, 1])
    assert (mb.ground * matrix).matrix == matrix
    assert all_same((matrix * mb.translate(1, 2, 0)).matrix.col(3), P.coords)


def test_unit_vectors_and_the_fourth_number() -> None:
    RF1 = body_frames()[0]
    v = mb.project(mb.uvec_X(RF1), mb.ground)
    assert v.obj == "VECTOR" and v.frame == mb.ground
    assert v.comps == sp.Matrix([cos(th1), sin(th1), 0, 0])
    assert mb.comp_XYZ(mb.uvec_Y(RF1)) == [0, 1, 0] and mb.comp_Z(mb.uvec_Z(RF1)) == 1
    P = mb.make_POINT(RF1, 1, 2, 0)
    assert P.obj == "POINT" and P.frame == RF1 and P.coords == sp.Matrix([1, 2, 0, 1])


def test_a_point_by_hand_and_by_the_library() -> None:
    RF1 = body_frames()[0]
    by_hand = RF1 * sp.Matrix([1, 2, 0, 1])
    P10 = mb.project(mb.make_POINT(RF1, 1, 2, 0), mb.ground)
    wanted = [cos(th1) - 2 * sin(th1) + x10, sin(th1) + 2 * cos(th1) + y10, 0, 1]
    assert all_same(by_hand, wanted) and all_same(P10.coords, wanted)
    assert value(by_hand[0], DATA) == pytest.approx(1.564296, abs=DIGITS)
    assert value(by_hand[1], DATA) == pytest.approx(1.706193, abs=DIGITS)
    assert RF1 * mb.make_POINT(mb.ground, 1, 2, 0) == P10


def test_joined_points_and_products() -> None:
    RF1, RF2, *_ = body_frames()
    vec1 = mb.join_points(mb.make_POINT(RF1, 1, 1, 0), mb.make_POINT(RF2, 0.5, 0.5, 0))
    vec2 = mb.join_points(mb.make_POINT(RF1, 0, 0, 0), mb.make_POINT(RF2, 3, 2, 0))
    assert vec1.frame == RF1
    assert value(mb.comp_X(vec1), DATA) == pytest.approx(0.50980043, abs=5.1e-9)
    assert value(mb.comp_Y(vec1), DATA) == pytest.approx(0.63120892, abs=5.1e-9)
    assert value(mb.comp_X(vec2), DATA) == pytest.approx(3.22832541, abs=5.1e-9)
    assert value(mb.comp_Y(vec2), DATA) == pytest.approx(3.98634626, abs=5.1e-9)
    assert value(mb.dot_prod(vec1, vec2), DATA) == pytest.approx(4.16201901, abs=5.1e-9)
    assert mb.dot_prod(mb.uvec_X(RF1), mb.uvec_Y(RF1)) == 0
    assert mb.cross_prod(mb.uvec_X(RF1), mb.uvec_Y(RF1)) == mb.uvec_Z(RF2)
    assert mb.cross_prod(vec1, vec1 * th4) == mb.make_VECTOR(RF2, 0, 0, 0)


def test_vectors_by_operators() -> None:
    RF1, RF2, *_ = body_frames()
    a, b = mb.make_VECTOR(RF1, 1, 2, 3), mb.make_VECTOR(RF2, s, -1, 2)
    P = mb.make_POINT(RF2, 1, 0, 1)
    assert a + b == b + a and a + b - b == a and 2 * a == a + a and (s * b) / s == b and -a != a
    assert (P + a) - P == a and P - (P + a) == -a
    assert mb.dot_prod(a + b, b) != mb.dot_prod(a, b)
    assert len({a, mb.project(a, RF2), b}) == 2


def test_a_frame_and_its_inverse() -> None:
    RF1, RF2, *_ = body_frames()
    assert RF1 * mb.inv_frame(RF1) == mb.ground == mb.inv_frame(RF2) * RF2
    assert mb.rotate("x", s) == mb.rotate(mb.uvec_X(RF1), s) == mb.rotate(mb.make_VECTOR(RF1, 3, 0, 0), s)
    slanted = mb.rotate(mb.make_VECTOR(mb.ground, 1, 1, 1), 2 * sp.pi / 3)
    assert all_same((slanted * mb.make_POINT(mb.ground, 1, 2, 3)).coords, [3, 1, 2, 1])


def revolute(RF1: mb.FRAME, RF2: mb.FRAME) -> list[sp.Expr]:
    vec1 = mb.project(mb.join_points(mb.make_POINT(RF1, -1, 0, 0), mb.make_POINT(RF2, 1, 0, 0)), mb.ground)
    return [mb.comp_X(vec1), mb.comp_Y(vec1)]


def prismatic(RF2: mb.FRAME, RF3: mb.FRAME) -> list[sp.Expr]:
    RF2aux, RF3aux = RF2 * mb.rotate("Z", beta1), RF3 * mb.rotate("Z", beta2)
    P22, P33 = mb.origin(RF2aux), mb.origin(RF3aux)
    across = mb.uvec_Y(RF2aux)
    return [mb.dot_prod(across, mb.uvec_X(RF3aux)), mb.dot_prod(across, mb.join_points(P22, P33))]


def rod(RF3: mb.FRAME, RF4: mb.FRAME) -> mb.VECTOR:
    return mb.project(mb.join_points(mb.make_POINT(RF3, 1, 0, 0), mb.make_POINT(RF4, 2, 3, 0)), mb.ground)


def test_constraints_of_joints() -> None:
    RF1, RF2, RF3, RF4 = body_frames()
    phi_r, phi_p, v45 = revolute(RF1, RF2), prismatic(RF2, RF3), rod(RF3, RF4)
    wanted = [cos(th2) + x20 - x10 + cos(th1), sin(th2) + y20 - y10 + sin(th1)]
    assert all_same(phi_r, wanted)
    assert [value(e, DATA) for e in phi_r] == pytest.approx([2.62017868, 2.23973789], abs=5.1e-9)
    assert same(phi_p[0], sin(th3 + beta2 - th2 - beta1))
    assert [value(e, DATA) for e in phi_p] == pytest.approx([-0.93203909, 2.78985665], abs=5.1e-9)
    spots = [value(e, DATA) for e in mb.comp_XYZ(v45)[:2]]
    assert spots == pytest.approx([-1.18749083, 0.53262143], abs=5.1e-9)
    phi_l = [mb.dot_prod(v45, v45) - L**2]
    assert value(phi_l[0], DATA) == pytest.approx(-0.55617994, abs=5.1e-9)
    length = sp.sqrt(mb.dot_prod(v45, v45)) - L
    assert value(length, DATA) == pytest.approx(math.hypot(*spots) - 1.5, abs=1e-12)
    assert len(phi_r + phi_p + phi_l) == 5


def test_the_line_of_a_cam() -> None:
    RF1, RF2, *_ = body_frames()
    joined = mb.project(mb.join_points(mb.origin(RF1), mb.make_POINT(RF2, 1, 0, 0)), mb.ground)
    wanted = -sin(th1) * (x20 + cos(th2) - x10) + cos(th1) * (y20 + sin(th2) - y10)
    assert same(mb.dot_prod(mb.uvec_Y(RF1), joined), wanted)


def test_velocities() -> None:
    RF1, RF2, *_ = body_frames()
    P = mb.make_POINT(RF1, s, 2, 0)
    v = mb.velocity(P)
    ground = mb.project(v, mb.ground)
    place = mb.project(P, mb.ground)
    t = dynamicsymbols._t
    assert v.frame == RF1 and all_same(mb.comp_XYZ(ground), mb.diff(mb.comp_XYZ(place), t))
    twice = mb.project(mb.acceleration(P), mb.ground)
    assert all_same(mb.comp_XYZ(twice), mb.diff(mb.comp_XYZ(place), t, t))
    assert mb.comp_XYZ(mb.angular_velocity(RF1)) == [0, 0, th1.diff()]
    assert same(mb.comp_Z(mb.angular_velocity(RF1, RF2)), th1.diff() - th2.diff())


def test_angular_velocity_in_space_is_that_of_the_rotation_matrix() -> None:
    axis = mb.make_VECTOR(mb.ground, 1, s, 0)  # a moving axis
    RF = mb.rotate("Z", th1) * mb.rotate("X", th2) * mb.translate(s, 1, 2) * mb.rotate(axis, th3)
    R = RF.matrix[:3, :3]
    wanted = R.T * R.diff(dynamicsymbols._t)
    found = mb.comp_XYZ(mb.angular_velocity(RF))
    assert all_same(found, [wanted[2, 1], wanted[0, 2], wanted[1, 0]])


def test_describe_and_show(capsys: pytest.CaptureFixture[str]) -> None:
    """N-01: help as a comment, then the signature with the kinds of the arguments."""
    mb.Describe(mb.cross_prod)
    mb.Describe(mb.gravitational_energy)
    mb.Describe(mb.kinetic_energy)
    mb.Describe(mb.state_space)
    text = capsys.readouterr().out
    assert text.startswith("# Return the vector product")
    assert "\ncross_prod(u: VECTOR | FORCE | TORQUE, v: VECTOR | FORCE | TORQUE) -> VECTOR\n" in text
    assert "\ngravitational_energy(bodies: BODY | Iterable[BODY]) -> Expr\n" in text
    assert "# With ``nat_coords`` its mass matrix is constant" in text
    assert "\nkinetic_energy(bodies: BODY | Iterable[BODY], nat_coords: bool = False) -> Expr\n" in text
    assert "state_space(eqns: Iterable[Expr | Equality], t: Expr | None, x: Iterable[Expr])" in text
    mb.Describe(mb.make_FORCE)
    mb.Describe(mb.set_gravity)
    text = capsys.readouterr().out
    assert "make_FORCE(RF, Fx, Fy, Fz, P, B1, B2)" in text and "\nmake_FORCE(*arguments) -> FORCE\n" in text
    assert text.endswith("set_gravity(g: VECTOR | None)\n")
    mb.show(mb.make_POINT(mb.rotate("Z", th1), 1, 2, 0))
    text = capsys.readouterr().out
    assert "coords = [1, 2, 0, 1]" in text and "[cos(theta1(t)), -sin(theta1(t)), 0, 0]" in text


def test_every_word_describes_itself(capsys: pytest.CaptureFixture[str]) -> None:
    for name in mb.__all__:
        if callable(getattr(mb, name)):
            mb.Describe(getattr(mb, name))
            text = capsys.readouterr().out
            assert text.startswith("# ") and f"\n{name}(" in text, name
