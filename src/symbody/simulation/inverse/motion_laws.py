"""Prescribed motions: formulas become constraints, tables and callables are evaluated along the path."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import ArrayLike

from symbody.analysis.kinematics.continuation import Law
from symbody.codegen.formation.names import Value
from symbody.errors import Problem, UsageError
from symbody.expr.graph import Graph
from symbody.expr.language.formula import Formula
from symbody.expr.printing.text import to_text
from symbody.expr.sympy.sympy_bridge import from_sympy, is_expression
from symbody.model.declarations.arguments import plain_value
from symbody.simulation.inputs.tables import Table

# A function of time returns the coordinate, its rate and its acceleration. SymPy's expressions, which have no
# types, are taken too.
MotionLaw = Value | Table | tuple[ArrayLike, ArrayLike] | Callable[[float], tuple[float, float, float]]


def motion_laws(
    motion: Mapping[str, MotionLaw], span: tuple[float, float]
) -> tuple[dict[str, Value], dict[str, Law]]:
    """Return the motions that are formulas, and the others as functions of time with two derivatives.

    Raises
    ------
    UsageError
        If a table has corners, or ends within the span.
    """
    formulas: dict[str, Value] = {}
    laws: dict[str, Law] = {}
    problems = []
    for name, given in motion.items():
        table = Table(given[0], given[1], kind="cubic") if isinstance(given, tuple) else given
        if isinstance(table, Table):
            problems += _table_problems(name, table, span)
            laws[name] = _spline(replace(table, kind="cubic"))
        elif isinstance(table, str | int | float | Formula):
            formulas[name] = table
        elif is_expression(table):
            formulas[name] = _formula_of(table)
        elif callable(table):
            laws[name] = _wrap_function(name, table)
        else:
            formulas[name] = Formula.from_value(plain_value(table))
    if problems:
        raise UsageError(*problems)
    return formulas, laws


def _formula_of(law: object) -> Formula:
    """Return a law that SymPy wrote as a formula."""
    graph = Graph()
    return Formula.from_value(to_text(graph, from_sympy(law, graph)))


def _table_problems(name: str, table: Table, span: tuple[float, float]) -> list[Problem]:
    where, times = f"motion {name}", np.asarray(table.t, dtype=np.float64)
    problems = []
    if table.kind != "cubic":
        problems.append(
            Problem("inverse.table_corners", where, "a table of straight lines has infinite accelerations",
                    "its slope jumps at every point", 'write sb.Table(..., kind="cubic")')
        )  # fmt: skip
    if span[0] < times[0] or span[1] > times[-1]:
        problems.append(
            Problem("inverse.table_span", where,
                    f"the table covers {times[0]:g} s to {times[-1]:g} s, the times {span[0]:g} s to "
                    f"{span[1]:g} s", "",
                    "extend the table, or choose times within it")
        )  # fmt: skip
    return problems


def _spline(table: Table) -> Law:
    spline = scipy.interpolate.CubicSpline(np.asarray(table.t), np.asarray(table.values))

    def law(t: float) -> tuple[float, float, float]:
        return float(spline(t)), float(spline(t, 1)), float(spline(t, 2))

    return law


def _wrap_function(name: str, function: Callable[[float], tuple[float, float, float]]) -> Law:
    def law(t: float) -> tuple[float, float, float]:
        try:
            given = np.asarray(function(t), dtype=np.float64)
        except Exception as error:
            raise _function_problem(
                name, f"at t = {t:.9g} s it raised {type(error).__name__}: {error}"
            ) from error
        if given.shape != (3,) or not np.isfinite(given).all():
            raise _function_problem(name, f"at t = {t:.9g} s it returned {given.tolist()}")
        return float(given[0]), float(given[1]), float(given[2])

    return law


def _function_problem(name: str, what: str) -> UsageError:
    return UsageError(
        Problem("inverse.motion_function", f"motion {name}", what,
                "accelerations need the motion and its first two derivatives",
                "return three finite numbers: the coordinate, its rate and its acceleration")
    )  # fmt: skip
