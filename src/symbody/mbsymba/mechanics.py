"""Bodies, forces, torques, constraints and gravity."""

from __future__ import annotations

import warnings
from collections.abc import Iterable

from symbody.equations.by_hand.mechanism import PlacedBody, PlacedConstraint, PlacedForce, PlacedTorque
from symbody.errors import ModelError, Problem
from symbody.expr.expression import Expr
from symbody.expr.sympy.sympy_writer import SympyEquation, SympyExpr, SympyMatrix, nodes_from_equations
from symbody.mbsymba.arguments import as_body, as_point, as_vector, reaction_body, read_vector
from symbody.mbsymba.objects import BODY, CONSTRAINT, FORCE, FRAME, POINT, TORQUE, VECTOR
from symbody.mbsymba.workplace import WORKPLACE, function_names, to_expressions
from symbody.spatial.placed import PlacedFrame, PlacedPoint
from symbody.spatial.rotation import AxisRotation

Scalar = SympyExpr | float


def make_BODY(
    G: POINT | FRAME | SympyMatrix,
    m: Scalar,
    Ixx: Scalar = 0,
    Iyy: Scalar = 0,
    Izz: Scalar = 0,
    Cyz: Scalar = 0,
    Cxz: Scalar = 0,
    Cxy: Scalar = 0,
    *,
    name: str = "",
) -> BODY:
    """Return a rigid body.

    Parameters
    ----------
    G : POINT or frame
        The centre of mass, as a point or as the origin of a frame; the body has the axes of its frame.
    m : expression
        Mass [kg].
    Ixx, Iyy, Izz, Cyz, Cxz, Cxy : expression
        Inertia about the centre of mass in these axes, products as tensor entries [kg m^2]. They are taken in
        this order: ``make_BODY(G, m, iz)`` gives iz to Ixx, and in the plane only Izz counts.
    name : str
        In the names of results; body1, body2 by default.
    """
    mass, xx, yy, zz, yz, xz, xy = to_expressions((m, Ixx, Iyy, Izz, Cyz, Cxz, Cxy))
    tensor = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    body = PlacedBody(name, as_point(G, "make_BODY"), mass, tensor)
    _warn_of_plane(body)
    return BODY(body, next(WORKPLACE.serial))


def make_FORCE(*arguments: object) -> FORCE:
    """Return a force: ``make_FORCE(RF, Fx, Fy, Fz, P, B1, B2)`` or ``make_FORCE(VECTOR, P, B1, B2)``.

    It acts on body B1 at the point P, its opposite on body B2 at the same place; left out, on ground.

    Raises
    ------
    UsageError, FrameError
        If the arguments are not these.
    """
    vector, (P, B1, *B2) = read_vector(arguments, 3, "make_FORCE")
    on, back = as_body(B1, "make_FORCE"), reaction_body(B2[0] if B2 else None, "make_FORCE")
    force = PlacedForce(vector, as_point(P, "make_FORCE"), on.placed, back.placed if back else None)
    return FORCE(force, next(WORKPLACE.serial))


def make_TORQUE(*arguments: object) -> TORQUE:
    """Return a torque: ``make_TORQUE(RF, Tx, Ty, Tz, B1, B2)`` or ``make_TORQUE(VECTOR, B1, B2)``.

    It acts on body B1, its opposite on body B2; left out, on ground.

    Raises
    ------
    UsageError, FrameError
        If the arguments are not these.
    """
    vector, (B1, *B2) = read_vector(arguments, 2, "make_TORQUE")
    on, back = as_body(B1, "make_TORQUE"), reaction_body(B2[0] if B2 else None, "make_TORQUE")
    return TORQUE(PlacedTorque(vector, on.placed, back.placed if back else None), next(WORKPLACE.serial))


def make_CONSTRAINT(
    Phi: SympyExpr | SympyEquation | Iterable[SympyExpr | SympyEquation],
    lambdas: SympyExpr | Iterable[SympyExpr],
) -> CONSTRAINT:
    """Return constraints Phi = 0 with their multipliers, one or as many of each.

    One with first derivatives constrains velocities: it enters by its derivatives by these, and is returned
    as it stands.

    Raises
    ------
    ModelError
        If there are not as many multipliers as equations.
    UsageError
        If a multiplier is not a function of time.
    """
    graph = WORKPLACE.graph
    equations = list(Phi) if isinstance(Phi, Iterable) else [Phi]
    names = function_names(lambdas, "make_CONSTRAINT")
    if len(names) != len(equations):
        raise ModelError(
            Problem("mbsymba.multipliers", "make_CONSTRAINT",
                    f"{len(equations)} equations and {len(names)} multipliers do not match", "",
                    "give each equation one multiplier")
        )  # fmt: skip
    values = tuple(Expr(graph, node) for node in nodes_from_equations(equations, graph))
    return CONSTRAINT(PlacedConstraint(values, tuple(names)), next(WORKPLACE.serial))


def set_gravity(g: VECTOR | None) -> None:
    """Set the acceleration of free fall of all that this thread computes from now on; None: there is none.

    It takes the place of ``_gravity := make_VECTOR(ground, 0, -g, 0)``.
    """
    WORKPLACE.gravity = None if g is None else as_vector(g, "set_gravity")


def CoM(body: BODY) -> POINT:
    """Return the centre of mass of a body."""
    return POINT(as_body(body, "CoM").placed.centre)


def _warn_of_plane(body: PlacedBody) -> None:
    """Warn once of a body that turns about Z only and has inertia only about other axes."""
    moments = [body.tensor[k][k] for k in range(3)]
    if moments[2].is_zero and not (moments[0].is_zero and moments[1].is_zero) and _is_planar(body.centre):
        warnings.warn(
            "make_BODY: the body rotates about Z but has no Izz, so its inertia does nothing. The order is "
            "make_BODY(G, m, Ixx, Iyy, Izz): write make_BODY(G, m, 0, 0, Izz)",
            stacklevel=3,
        )


def _is_planar(centre: PlacedPoint) -> bool:
    frame: PlacedFrame = centre.frame
    turns = [step for step in frame.steps if isinstance(step, AxisRotation)]
    return bool(turns) and all(turn.axis[0].is_zero and turn.axis[1].is_zero for turn in turns)
