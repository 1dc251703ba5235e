"""Curves under names: what people read has ``law_spring(x)`` where the graph has the pieces of a curve."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from numbers import Real
from typing import Any

from symbody.equations.loads.curves import piecewise_value
from symbody.expr.canonical import neg
from symbody.expr.expression import Expr
from symbody.expr.graph import Graph
from symbody.expr.opcodes import CALL, LT
from symbody.expr.rewrite import substitute
from symbody.model.contacts.contact import Contact
from symbody.model.loads.curve import Curve
from symbody.model.loads.forces import SpringDamper, TorsionSpring
from symbody.model.model import Model

Piece = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class CurveFunction:
    """The law of a spring or drive as a function with a name.

    Attributes
    ----------
    name : str
        ``law_`` and the name of the spring or joint.
    pieces : tuple of (start, x0, c0, c1, ..)
        Polynomials from left to right, as `Curve.pieces` returns them.
    """

    name: str
    pieces: tuple[Piece, ...]

    def __call__(self, *arguments: Any) -> Any:
        """Return the value at a number; at each of an array too, for functions made by SymPy."""
        (given,) = arguments
        x = float(given) if isinstance(given, Real) else given  # numbers of SymPy too
        ends = (*(piece[0] for piece in self.pieces[1:]), math.inf)
        values = (
            (start <= x) * (x < end) * _polynomial(coefficients, x - x0)
            for (start, x0, *coefficients), end in zip(self.pieces, ends, strict=True)
        )
        return sum(values, 0.0)

    def derivative(self, position: int) -> CurveFunction:
        """Return the slope, a curve too; at a corner that of the piece to the right."""
        pieces = tuple((*piece[:2], *_slopes(piece[2:])) for piece in self.pieces)
        return replace(self, name=f"{self.name}_slope", pieces=pieces)

    def formula(self, x: Expr) -> Expr:
        """Return the value at `x` in its pieces, the very node that is computed."""
        return piecewise_value(self.pieces, x)


def curve_functions(model: Model) -> tuple[CurveFunction, ...]:
    """Return the curves of a model by name: ``law_S`` of a spring, ``law_J`` of a joint's drive.

    A joint with several coordinates has ``law_J_x``. What no name may contain becomes ``_``; names that a
    coordinate, input or parameter has get ``_`` behind them.
    """
    taken = {*model.parameters, *model.inputs}
    taken |= {name for joint in model.joints for name in joint.coordinates}
    functions: dict[str, CurveFunction] = {}
    for owner, curve in _curves(model):
        name = "law_" + re.sub(r"\W", "_", owner)
        while name in taken or name in functions:
            name += "_"
        functions[name] = CurveFunction(name, tuple(curve.pieces()))
    return tuple(functions.values())


def name_curves(graph: Graph, nodes: Sequence[int], functions: Iterable[CurveFunction]) -> list[int]:
    """Return nodes with calls of `functions` where their formulas stand.

    Equal formulas are one node of a graph: what stands there is the formula made once more for whatever is
    compared with the places of the curve.
    """
    functions = tuple(functions)
    if not functions:
        return list(nodes)
    reachable = graph.reachable(nodes)
    present = set(reachable)
    compared = [(graph.left[node], graph.right[node]) for node in reachable if graph.ops[node] == LT]
    calls: dict[int, int] = {}
    for function in functions:
        bounds = {graph.constant(piece[0]) for piece in function.pieces[1:]}
        for x in sorted({left for left, right in compared if right in bounds}):
            value = function.formula(Expr(graph, x)).index
            if graph.number(value) is None:
                call = graph.many(CALL, (x,), graph.function(function))
                calls.setdefault(value, call)
                calls.setdefault(neg(graph, value), neg(graph, call))
    return substitute(graph, nodes, {node: call for node, call in calls.items() if node in present})


def _curves(model: Model) -> Iterator[tuple[str, Curve]]:
    for joint in model.joints:
        for coordinate, drive in joint.drives.items():
            if isinstance(drive.law, Curve):
                yield joint.effort_name(coordinate), drive.law
    for element in model.elements:
        if isinstance(element, SpringDamper | TorsionSpring) and isinstance(element.law, Curve):
            yield element.name, element.law
        elif isinstance(element, Contact) and not isinstance(element.normal, str):
            if isinstance(element.normal.law, Curve):
                yield element.name, element.normal.law


def _slopes(coefficients: Sequence[float]) -> Sequence[float]:
    return [k * c for k, c in enumerate(coefficients)][1:] or [0.0]


def _polynomial(coefficients: Sequence[float], x: float) -> float:
    return reduce(lambda value, c: c + value * x, reversed(coefficients), 0.0 * x)
