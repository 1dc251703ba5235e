"""What gravity alone does along each speed: the part of the forcing that balances weights."""

from __future__ import annotations

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.outputs.frame_motion import frame_motion_entries
from symbody.expr.calculus import jacobian
from symbody.expr.expression import Expr


def gravity_forcing(formed: EquationsOfMotion) -> list[Expr]:
    """Return the generalized forces of gravity (n_u,): power of all weights by each speed [N, N m]."""
    graph, model = formed.graph, formed.topology.model
    gravity = formed.names.triple(model.gravity, "gravity")
    forces = [Expr(graph, 0)] * len(formed.u)
    speeds = [graph.symbol(symbol) for symbol in formed.u]
    for body in model.bodies:
        velocity = frame_motion_entries(formed, "v", body.name)[1]
        mass = formed.names.expression(body.mass, f"body {body.name}, mass")
        rows = jacobian(graph, [entry.index for entry in velocity], speeds)
        for along, row in zip(gravity, rows, strict=True):
            forces = [
                force + mass * along * Expr(graph, slope) for force, slope in zip(forces, row, strict=True)
            ]
    return forces
