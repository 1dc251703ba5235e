"""Arguments of scripts as frames, points, vectors and bodies; a wrong kind raises an error with a cure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NoReturn

from symbody.errors import FrameError, Problem, UsageError
from symbody.expr.sympy.sympy_writer import is_matrix
from symbody.mbsymba.objects import (
    BODY,
    CONSTRAINT,
    FORCE,
    FRAME,
    OBJECT,
    POINT,
    TORQUE,
    VECTOR,
    frame_of_matrix,
)
from symbody.mbsymba.workplace import triple
from symbody.spatial.matrix import Triple
from symbody.spatial.placed import GROUND_FRAME, PlacedFrame, PlacedPoint, PlacedVector


def as_frame(given: object, where: str) -> PlacedFrame:
    """Return a frame, given as one or as a 4 x 4 matrix."""
    if isinstance(given, FRAME):
        return given.placed
    if is_matrix(given):
        return frame_of_matrix(given)
    _refuse(
        given, where, "a frame", "give ground, translate(...), rotate(...), their products, or a 4 x 4 Matrix"
    )


def as_point(given: object, where: str) -> PlacedPoint:
    """Return a point; of a frame its origin, of a body its centre of mass, of a column one in ground."""
    if isinstance(given, POINT):
        return given.placed
    if isinstance(given, BODY):
        return given.placed.centre
    if isinstance(given, FRAME):
        return PlacedPoint(given.placed, triple(0, 0, 0))
    if is_matrix(given) and given.shape == (4, 1) and given[3] == 1:
        return PlacedPoint(GROUND_FRAME, triple(*given[:3]))
    _refuse(given, where, "a point", "give make_POINT(RF, x, y, z), or origin(RF)")


def as_vector(given: object, where: str) -> PlacedVector:
    """Return a vector, or that of a force or torque."""
    if isinstance(given, VECTOR):
        return given.placed
    if isinstance(given, FORCE | TORQUE):
        return given.placed.vector
    _refuse(given, where, "a vector", "give make_VECTOR(RF, x, y, z), join_points(P, Q), uvec_X(RF)")


def as_body(given: object, where: str) -> BODY:
    """Return a body."""
    if isinstance(given, BODY):
        return given
    _refuse(given, where, "a body", "give what make_BODY(...) returned")


def reaction_body(given: object, where: str) -> BODY | None:
    """Return the body a force reacts on; None for ground."""
    if given is None or (isinstance(given, FRAME) and not given.placed.steps):
        return None
    return as_body(given, where)


def read_vector(arguments: Sequence[object], count: int, where: str) -> tuple[PlacedVector, Sequence[object]]:
    """Return the vector that arguments begin with, a VECTOR or a frame and three components, and the rest.

    Raises
    ------
    UsageError
        If there are fewer than the vector and one, or more than `count`, behind it.
    """
    if arguments and isinstance(arguments[0], VECTOR):
        vector, others = arguments[0].placed, arguments[1:]
    elif len(arguments) >= 4:
        vector = PlacedVector(as_frame(arguments[0], where), components(arguments[1:4]))
        others = arguments[4:]
    else:
        vector, others = None, ()
    if vector is None or not count - 1 <= len(others) <= count:
        last = "P, B1" if count == 3 else "B1"
        raise UsageError(
            Problem("mbsymba.arguments", where, f"{len(arguments)} arguments do not match",
                    "", f"write {where}(RF, x, y, z, {last}) or {where}(VECTOR, {last}), followed by the "
                        f"body on which it reacts")
        )  # fmt: skip
    return vector, others


def components(given: Sequence[object]) -> Triple:
    """Return three components."""
    x, y, z = given
    return triple(x, y, z)


def read_objects(given: object, where: str) -> list[OBJECT]:
    """Return bodies, forces, torques, constraints: one, or any iterable; of a set in order of making."""
    if isinstance(given, BODY | FORCE | TORQUE | CONSTRAINT):
        return [given]
    if not isinstance(given, Iterable):
        _refuse(given, where, "a collection of bodies, forces, constraints", "give a list or a set of them")
    items = list(given)
    wrong = [item for item in items if not isinstance(item, BODY | FORCE | TORQUE | CONSTRAINT)]
    if wrong:
        raise UsageError(
            *(
                Problem("mbsymba.not_an_object", where,
                        f"{_kind(item)} is not a body, force, torque or constraint",
                        "only these enter the equations of motion",
                        "put equations into make_CONSTRAINT(Phi, lambdas), vectors into make_FORCE")
                for item in wrong
            )
        )  # fmt: skip
    return sorted(items, key=lambda item: item.serial) if isinstance(given, set | frozenset) else items


def read_bodies(given: object, where: str) -> list[BODY]:
    """Return bodies: one, or any iterable; those of a set in order of making."""
    return [as_body(item, where) for item in read_objects(given, where)]


def _refuse(given: object, where: str, kind: str, cure: str) -> NoReturn:
    raise FrameError(Problem("mbsymba.wrong_kind", where, f"{_kind(given)} is not {kind}", "", cure))


def _kind(given: object) -> str:
    """Return a short text of an object."""
    text = str(given).partition("\n")[0]
    short = text if len(text) <= 40 else text[:37] + "..."
    kind = type(given).__name__
    return f"a {kind}" if short == kind else f"{short} ({kind})"
