"""Constraints that hold up to rounding: rows that would vanish if their numbers were exact.

A planar loop in axes typed with digits keeps off-plane rows of 1e-17 instead of 0. To a solver such
a row looks like a constraint in small units, but here the motions of the two frames that cancel in it are at
hand. Each row is compared with them at a few random configurations, with values of the parameters.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from collections.abc import Sequence as Items
from dataclasses import replace
from random import Random
from typing import Final

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.expr.expression import Expr, number
from symbody.expr.opcodes import SELECT
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, Sequence, build_sequence
from symbody.spatial.vector import dot
from symbody.tolerances import TYPED

POINTS: Final = 3  # random ones, the same at every call
SEED: Final = 3


def drop_negligible(formed: EquationsOfMotion, parameters: Mapping[str, float]) -> EquationsOfMotion:
    """Return the equations with all rows that are only rounding set to 0 = 0; their multipliers are 0.

    Parameters
    ----------
    parameters : mapping of name to float
        Those not named get random values.
    """
    return drop_rows(formed, negligible_rows(formed, parameters, magnitude_program(formed)))


def drop_rows(formed: EquationsOfMotion, silent: Items[bool]) -> EquationsOfMotion:
    """Return the equations with some rows set to 0 = 0; the same ones if these rows are so already."""
    zero = Expr(formed.graph, 0)
    rows = tuple(
        replace(row, jacobian={}, drift=zero, gamma=zero) if quiet else row
        for row, quiet in zip(formed.rows, silent, strict=True)
    )
    return formed if rows == tuple(formed.rows) else formed.with_rows(rows)


def magnitude_program(formed: EquationsOfMotion) -> Sequence:
    """Return what computes the slopes of all rows and the squares of the motions they compare."""
    pairs = [_slopes_and_squares(formed, row) for row in formed.rows]
    roots = [
        Roots(f"{k} {word}", (len(values),), tuple(value.index for value in values))
        for k, pair in enumerate(pairs)
        for word, values in zip(("slopes", "squares"), pair, strict=True)
    ]
    return build_sequence(formed.graph, roots, input_places(formed), merge=False, contract=False)


def negligible_rows(
    formed: EquationsOfMotion, parameters: Mapping[str, float], program: Sequence
) -> list[bool]:
    """Return which rows are below `TYPED` of the motions they compare, in every speed and at every point.

    Parameters
    ----------
    program : Sequence
        What `magnitude_program` returns for these equations.
    """
    silent = [True] * len(formed.rows)
    random = Random(SEED)
    for _ in range(POINTS if formed.rows else 0):
        values = evaluate_sequence(program, random_point(formed, parameters, random))
        for k in range(len(silent)):
            silent[k] = silent[k] and is_rounding(values[2 * k], values[2 * k + 1])
    return silent


def is_rounding(slopes: Items[float], squares: Items[float]) -> bool:
    """Return whether slopes are below `TYPED` of the motions that they compare, whose squares these are."""
    pairs = zip(slopes, squares, strict=True)
    return all(abs(float(x)) <= TYPED * math.sqrt(max(float(square), 0.0)) for x, square in pairs)


def _slopes_and_squares(formed: EquationsOfMotion, row: ConstraintEquation) -> tuple[list[Expr], list[Expr]]:
    """Return the slopes of a row, and for each the square of the motions whose difference it is part of."""
    kinematics, tree = formed.kinematics, formed.kinematics.tree
    link = formed.topology.link(row.element)
    if link is None or _has_branches(formed, row):  # written in coordinates, not in motions of frames
        return [number(formed.graph, 1)], [number(formed.graph, 0)]
    start, end = link.start.full_name, link.end.full_name
    w, w_end = kinematics.angular_velocities[start], kinematics.angular_velocities[end]
    v, v_end = kinematics.velocities[start], kinematics.velocities[end]
    arm = kinematics.position(start, end)
    # Where a frame stands on the axis its body turns about, what cancels is a turn times a lever.
    levers = [
        (w, arm),
        (w, kinematics.position(link.start.body, start)),
        (w_end, kinematics.position(link.end.body, end)),
    ]
    turned = [(part, dot(tree, lever, lever)) for part, lever in levers]
    # A moment beside a force has the length of a lever; alone it stands for an angle.
    lever = number(formed.graph, 1) if row.force.is_zero else dot(tree, row.moment, row.moment)
    slopes, squares = [], []
    for u, slope in row.jacobian.items():
        square = Expr(formed.graph, 0)
        if not row.force.is_zero:
            for part in (v.partial(u), v_end.partial(u)):
                square = square + dot(tree, part, part)
            for spin, length in turned:
                square = square + dot(tree, spin.partial(u), spin.partial(u)) * length
        if not row.moment.is_zero:
            for part in (w.partial(u), w_end.partial(u)):
                square = square + dot(tree, part, part) * lever
        slopes.append(slope)
        squares.append(square)
    return slopes, squares


def _has_branches(formed: EquationsOfMotion, row: ConstraintEquation) -> bool:
    """Return whether another formula holds at other positions: zero at a few of them says nothing of these.

    The axes across the normal of a contact are such.
    """
    graph, places = formed.graph, {formed.graph.symbol(q) for q in formed.q}
    nodes = graph.reachable(slope.index for slope in row.jacobian.values())
    conditions = [graph.operands(node)[0] for node in nodes if graph.ops[node] == SELECT]
    return not places.isdisjoint(graph.reachable(conditions))


def input_places(formed: EquationsOfMotion) -> dict[int, Input]:
    """Return where coordinates, parameters, inputs and time stand among the inputs of a sequence."""
    graph = formed.graph
    places = {graph.symbol(q): Input(q.label, "q", k) for k, q in enumerate(formed.q)}
    places |= {graph.symbol(p): Input(p.name, "p", k) for k, p in enumerate(formed.parameters)}
    places |= {graph.symbol(r): Input(r.name, "r", k) for k, r in enumerate(formed.inputs)}
    places[formed.names.value("t").index] = Input("t", "t", 0)
    return places


def random_point(
    formed: EquationsOfMotion, parameters: Mapping[str, float], random: Random
) -> dict[str, list[float]]:
    """Return random coordinates and time, and values of parameters where none is given."""
    q = [random.uniform(-1.5, 1.5) for _ in formed.q]
    place = {formed.graph.symbol(symbol): k for k, symbol in enumerate(formed.q)}
    for quaternion in formed.variables.quaternions:
        norm = sum(q[place[node]] ** 2 for node in quaternion) ** 0.5
        for node in quaternion:
            q[place[node]] /= norm
    p = [parameters.get(symbol.name, random.uniform(0.5, 1.5)) for symbol in formed.parameters]
    return {"q": q, "p": p, "r": [0.0] * len(formed.inputs), "t": [random.uniform(0.0, 1.0)]}
