"""Tables of the model on the graph: names that stand for pieces of polynomials."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from symbody.equations.kinematics.naming import Names
from symbody.equations.loads.curves import piecewise_value
from symbody.errors import FormulationError, Problem
from symbody.expr.expression import Expr
from symbody.model.model import Model
from symbody.model.tables.lookup import Lookup

# Every evaluation chooses among all points, and all of them are looked at before a motion; beyond these a
# table is the law of an input, which is read by halving.
MOST_POINTS: Final = 500


def tables_of_time(names: Names, model: Model) -> dict[str, Expr]:
    """Return the values of tables whose arguments are made of time and parameters."""
    known = {"t", "pi", *model.parameters}
    tables = (table for table in model.tables if known.issuperset(table.argument.names))
    return _values(names, (table for table in tables if table.name not in model.inputs))


def tables_of_states(names: Names, model: Model) -> dict[str, Expr]:
    """Return the values of tables whose arguments contain coordinates or speeds."""
    known = {*names.values, *model.inputs}
    return _values(names, (table for table in model.tables if table.name not in known))


def _values(names: Names, tables: Iterable[Lookup]) -> dict[str, Expr]:
    """Return the values of tables by name.

    Raises
    ------
    FormulationError
        If a table has more points than equations can hold.
    """
    values = {}
    for table in tables:
        where = f"table {table.name}"
        if len(table.points) > MOST_POINTS:
            raise FormulationError(
                Problem("equations.long_table", where, f"it has {len(table.points)} points",
                        f"every evaluation of the equations reads each point; the maximum is {MOST_POINTS}",
                        f"use fewer points, or make it the value of an input: inputs = [{table.name!r}]")
            )  # fmt: skip
        values[table.name] = piecewise_value(
            table.pieces(), names.expression(table.argument, f"{where}, argument")
        )
    return values
