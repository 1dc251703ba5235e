"""Rows of constraints against the graph: each rate is the derivative of its value, each gamma of its rate.

The rows are formed from velocities of frames; here the values are differentiated instead, at random states.
"""

from __future__ import annotations

import numpy as np
import pytest

import symbody as sb
from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.solving.drift_correction import velocity_residual
from symbody.expr.expression import Expr
from symbody.expr.graph import SymbolKind
from symbody.expr.sequences.evaluate import evaluate_sequence
from symbody.expr.sequences.sequence import Input, Roots, build_sequence
from symbody.model.constraint import ConstraintElement

A = sb.Body("A", mass=1, inertia=(1, 2, 2), frames={"P": sb.Frame(at=("a", 0, "0.3"), rotate=[("x", "0.4")])})
B = sb.Body("B", mass=1, inertia=(1, 2, 2), frames={"Q": sb.Frame(at=(0, "b", "0.7"), rotate=[("y", "0.3")])})
JOINTS = [
    sb.Free("fa", "ground", "A", angles="xyz", speeds="end"),
    sb.Free("fb", "ground", "B", angles="zxz", coordinates=["x", "y", "z", "c1", "c2", "c3"]),
]
TILTED = (1, "a", -2)
CONDITIONS = [
    sb.Distance("c", "A.P", "B.Q", value="2 + sin(t)"),
    sb.PointOnLine("c", "A.P", "B.Q", axis=TILTED),
    sb.PointOnPlane("c", "A.P", "B.Q", axis=TILTED),
    sb.PointOnCurve("c", "A.P", "B.Q", curve=["s", "s^2/2 + t", "cos(b*s)"], parameter="s"),
    sb.PointOnSurface("c", "A.P", "B.Q", ["x^2/a^2 + y^2 - sin(z) - t", "z - x*y"]),
    sb.Parallel("c", "A.P", "B.Q", axes=["y", TILTED]),
    sb.Perpendicular("c", "A.P", "B.Q", axes=[TILTED, "x"]),
    sb.Angle("c", "A.P", "B.Q", axes=["z", "x"], value="1 + t/3"),
    sb.KnifeEdge("c", "A.P", "B.Q", axis=TILTED),
    sb.Rolling("c", "A.P", "B.Q", radius="a"),
    sb.Rolling("c", "A.P", "B.Q", radius="a", normal=TILTED, axis="y"),
    sb.Gear("c", ["c1", "c2"], ratio="-a", offset="t^2"),
    sb.RackPinion("c", ["x", "c2"], radius="a"),
    sb.Belt("c", ["c1", "c3"], radii=["a", "b"], crossed=True),
    sb.Differential("c", ["c1", "c2", "c3"]),
    sb.Constraint("c", ["x*y - sin(c1) + t", "x_dot*sin(c1) - fa_wx*y + t*z", "cos(c2)*y_dot"]),
]
NAMES = [f"{type(condition).__name__}-{k}" for k, condition in enumerate(CONDITIONS)]


@pytest.mark.parametrize("condition", CONDITIONS, ids=NAMES)
def test_rates_and_gammas_are_derivatives(condition: ConstraintElement) -> None:
    model = sb.Model("m", [A, B, *JOINTS, condition], parameters={"a": 0.7, "b": 1.3})
    formed = sb.form_equations(model).formed
    kinematics, rows = formed.kinematics, formed.rows
    rates = velocity_residual(formed)
    pairs = [(rates[k], kinematics.rate(row.value)) for k, row in enumerate(rows) if row.is_holonomic]
    pairs += [(row.gamma, -kinematics.bias(rate)) for row, rate in zip(rows, rates, strict=True)]
    assert len(pairs) == len(rows) + len(formed.holonomic)
    first, second = evaluated(formed, pairs)
    # About 1e3 operations on numbers of order one to ten.
    np.testing.assert_allclose(first, second, rtol=1e-11, atol=1e-11)
    assert np.abs(first).max() > 1e-2


def evaluated(formed: EquationsOfMotion, pairs: list[tuple[Expr, Expr]]) -> tuple[np.ndarray, np.ndarray]:
    """Return both sides of pairs at a random state."""
    graph = formed.graph
    symbols = [symbol for symbol in graph.symbols if symbol.kind is not SymbolKind.TIME]
    places = {graph.symbol(symbol): Input(f"{k}", "x", k) for k, symbol in enumerate(symbols)}
    places[formed.names.value("t").index] = Input("t", "t", 0)
    nodes = tuple(x.index for pair in pairs for x in pair)
    program = build_sequence(graph, [Roots("both", (len(nodes),), nodes)], places, merge=False)
    random = np.random.default_rng(7)
    values = evaluate_sequence(program, {"x": list(random.uniform(0.2, 1.2, len(symbols))), "t": [0.4]})[0]
    both = np.array(values, dtype=float).reshape(-1, 2)
    return both[:, 0], both[:, 1]
