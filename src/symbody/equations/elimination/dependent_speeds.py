"""From names of dependent speeds to their elimination, or to the problems of the names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from symbody.equations.elimination.dependent_block import DependentBlock, Pivot, find_solution_order
from symbody.equations.elimination.elimination import SpeedElimination
from symbody.equations.formulations.formulation import Dynamics
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.kinematics.naming import Names
from symbody.equations.kinematics.placements import fold_zeros
from symbody.errors import FormulationError, Problem, nearest
from symbody.expr.calculus import gradient
from symbody.expr.expression import Expr, maximum, number, sqrt
from symbody.expr.fingerprints.fingerprint import find_zeros, fingerprints
from symbody.expr.graph import Graph, Symbol, SymbolKind
from symbody.expr.printing.text import to_text
from symbody.expr.rewrite import symbols_of, tree_size

_TINY: Final = 1e-200  # under a root that would be 0 where a speed has no mass for an instant
_SHOWN: Final = 40  # operations of a pivot that is written down in a note


def named_speeds(
    names: Names, speeds: Sequence[Symbol], rows: Sequence[ConstraintEquation], dependent: Sequence[str]
) -> tuple[Symbol, ...]:
    """Return the speeds that are to be eliminated by the rows that are not holonomic.

    Parameters
    ----------
    names : Names
        With every name of the model.
    speeds, rows
        Of the equations with multipliers.
    dependent : sequence of str
        Names of speeds, as many as there are such rows.

    Raises
    ------
    FormulationError
        If there are no such rows, a name is not that of a speed, or their number is wrong.
    """
    tied = [row for row in rows if not row.is_holonomic]
    problems = list(_name_problems(names, speeds, tied, dependent))
    if problems:
        raise FormulationError(*problems)
    return tuple(next(u for u in speeds if u.label == name) for name in dependent)


def eliminate_speeds(
    graph: Graph,
    speeds: Sequence[Symbol],
    rows: Sequence[ConstraintEquation],
    dynamics: Dynamics,
    chosen: Sequence[Symbol],
    tied: Sequence[ConstraintEquation],
) -> SpeedElimination:
    """Return the elimination of chosen speeds.

    Parameters
    ----------
    speeds, rows, dynamics
        Of the equations with multipliers.
    chosen : sequence of Symbol
        The dependent speeds.
    tied : sequence of ConstraintEquation
        As many rows by which they are eliminated; balances of forces may be among them.

    Raises
    ------
    FormulationError
        If the rows determine the speeds at no configuration.
    """
    zero = number(graph, 0)
    columns = [graph.symbol(u) for u in chosen]
    block = find_solution_order(graph, [[row.jacobian.get(u, zero) for u in columns] for row in tied])
    if block is None:
        raise FormulationError(_singular(graph, speeds, tied, [u.label for u in chosen]))
    offsets = dict(zip(columns, block.solve([-row.drift for row in tied]), strict=True))
    units = [[number(graph, int(i == k)) for i in range(len(tied))] for k in range(len(tied))]
    inverse = list(zip(*(block.solve(unit) for unit in units), strict=True))
    # gamma contains speeds, the dependent ones too.
    slow = SpeedElimination(
        graph=graph,
        speeds=tuple(speeds),
        dependent=tuple(chosen),
        rows=tuple(tied),
        given={row.name: (row.jacobian, row.drift) for row in (*rows, *tied)},
        slopes=_slopes(tied, block, columns, [graph.symbol(u) for u in speeds if u not in chosen]),
        rest=offsets,
        bias=dict.fromkeys(columns, zero),
        inverse=tuple(inverse),
        block=block,
        pivots=_pivots(graph, speeds, tied, chosen, block, dynamics),
        full=dynamics,
    )
    return slow.with_bias([row.gamma for row in tied])


def _slopes(
    rows: Sequence[ConstraintEquation], block: DependentBlock, columns: Sequence[int], others: Sequence[int]
) -> dict[int, dict[int, Expr]]:
    """Return T: of each dependent speed by the others, zeros left out."""
    T: dict[int, dict[int, Expr]] = {column: {} for column in columns}
    for u in others:
        if any(u in row.jacobian for row in rows):
            zero = rows[0].drift * 0
            found = block.solve([-row.jacobian.get(u, zero) for row in rows])
            for column, slope in zip(columns, fold_zeros(zero.graph, found), strict=True):
                if not slope.is_zero:
                    T[column][u] = slope
    return T


def nothing_to_eliminate() -> Problem:
    """Return the problem that there are no constraints on velocities."""
    return Problem(
        "equations.nothing_to_eliminate", "dependent_speeds",
        "no velocity constraint relates speeds to each other",
        "there are only position constraints, or no constraints",
        "leave dependent_speeds out; for dependent coordinates of loops choose another tree",
    )  # fmt: skip


def elimination_notes(elimination: SpeedElimination) -> tuple[str, ...]:
    """Return which speeds were eliminated, by which rows, and where they do not follow from the others."""
    graph, dependent = elimination.graph, elimination.dependent
    pairs = list(zip(elimination.rows, dependent, strict=True))
    tied = [(row.name, u.label) for row, u in pairs if not row.is_balance]
    light = [u.label for row, u in pairs if row.is_balance]
    notes = []
    if tied:
        listed, speeds = (", ".join(words) for words in zip(*tied, strict=True))
        notes.append(
            f"dependent speeds {speeds} are eliminated by the velocity constraints {listed}, whose "
            f"multipliers are outputs; {len(elimination.independent)} speeds remain"
        )
    if light:
        follows = "follows from the balance" if len(light) == 1 else "follow from the balances"
        notes.append(
            f"a motion that involves {', '.join(light)} has no mass: {', '.join(light)} {follows} of forces "
            f"in springs and dampers, and is not a state, but the coordinates are. Where this is not "
            f"intended, give the body mass, or inertia about the axis about which it rotates"
        )
    for pivot in elimination.block.pivots:
        if _varies(graph, pivot):
            which = ", ".join(dependent[k].label for k in pivot.columns)
            shown = tree_size(graph, pivot.determinant.index) <= _SHOWN
            where = (
                f"{to_text(graph, pivot.determinant.index).removeprefix('-')} = 0"
                if shown
                else "their determinant vanishes"
            )
            notes.append(
                f"dependent speeds {which}: the others do not determine them where {where}; "
                f"{dependent[pivot.columns[0]].label}_pivot shows how close that is, and a simulation stops "
                f"before it"
            )
    return tuple(notes)


def _varies(graph: Graph, pivot: Pivot) -> bool:
    """Return whether a pivot depends on coordinates or time, by fingerprint of its derivatives."""
    node = pivot.determinant.index
    first, second = fingerprints(graph, list(graph.reachable([node])))[node]
    if first == second:  # at two random points: a number, such as the square of a norm that is 1
        return False
    kinds = (SymbolKind.COORDINATE, SymbolKind.TIME, SymbolKind.INPUT)
    by = [x for x in symbols_of(graph, [node]) if graph.symbols[graph.left[x]].kind in kinds]
    return not all(find_zeros(graph, gradient(graph, node, by)))


def _pivots(
    graph: Graph,
    speeds: Sequence[Symbol],
    rows: Sequence[ConstraintEquation],
    chosen: Sequence[Symbol],
    block: DependentBlock,
    dynamics: Dynamics,
) -> dict[str, Expr]:
    """Return determinants that vary over what they could be at most, by the names of their speeds.

    Speeds are measured by their share of the kinetic energy, the determinant by the lengths of its rows
    (Hadamard's inequality), so that the result does not depend on units.
    """
    weights = {graph.symbol(u): dynamics.mass_matrix[k][k] for k, u in enumerate(speeds)}
    sizes = {u: 1 / sqrt(maximum(m, _TINY)) for u, m in weights.items() if not m.is_zero}
    one = number(graph, 1)
    pivots: dict[str, Expr] = {}
    for pivot in block.pivots:
        if not _varies(graph, pivot):
            continue
        share = pivot.determinant
        for k in pivot.columns:
            share = share * sizes.get(graph.symbol(chosen[k]), one)
        for k in pivot.rows:
            square = number(graph, 0)
            for u, slope in rows[k].jacobian.items():
                if u in sizes or u in {graph.symbol(own) for own in chosen}:
                    square = square + (slope * sizes.get(u, one)) ** 2
            share = share / sqrt(square)
        pivots |= {f"{chosen[k].label}_pivot": share for k in pivot.columns}
    return pivots


def _name_problems(
    names: Names, speeds: Sequence[Symbol], rows: Sequence[ConstraintEquation], dependent: Sequence[str]
) -> Iterator[Problem]:
    """Return the problems of the names alone."""
    where, labels = "dependent_speeds", [u.label for u in speeds]
    if not rows:
        yield nothing_to_eliminate()
        return
    counted_rows = f"{len(rows)} constraint{'s' if len(rows) > 1 else ''} on velocities ({_list_rows(rows)})"
    for name in dict.fromkeys(dependent):
        if name not in labels:
            yield Problem("equations.unknown_speed", where, f"{name!r} is not a speed of these equations",
                          f"the speeds are {', '.join(labels)}", nearest(name, labels))  # fmt: skip
        elif f"{name}_pivot" in names.symbols or f"{name}_pivot" in names.values:
            yield Problem("equations.name_clash", where, f"{name}_pivot is defined twice",
                          f"it shows how well the other speeds determine {name}",
                          "rename this symbol of the model")  # fmt: skip
    if len(dependent) != len(rows) or len(set(dependent)) != len(dependent):
        yield Problem(
            "equations.dependent_number", where,
            f"{len(set(dependent))} different dependent speeds are named, for {counted_rows}",
            "each of these constraints determines one speed",
            f"name {len(rows)} of {', '.join(_speeds_in_rows(names.graph, speeds, rows))}, or write \"auto\"",
        )  # fmt: skip


def _singular(
    graph: Graph, speeds: Sequence[Symbol], rows: Sequence[ConstraintEquation], dependent: Sequence[str]
) -> Problem:
    return Problem(
        "equations.singular_choice", "dependent_speeds",
        f"the other speeds do not determine {', '.join(dependent)} at any configuration",
        f"their coefficients in the velocity constraints {_list_rows(rows)} form a singular matrix",
        f"name others of {', '.join(_speeds_in_rows(graph, speeds, rows))}, or write \"auto\"; leave "
        "dependent_speeds out if one of the constraints follows from the others",
    )  # fmt: skip


def _list_rows(rows: Sequence[ConstraintEquation]) -> str:
    return ", ".join(row.name for row in rows)


def _speeds_in_rows(graph: Graph, speeds: Sequence[Symbol], rows: Sequence[ConstraintEquation]) -> list[str]:
    """Return the speeds that occur in the rows."""
    return [u.label for u in speeds if any(graph.symbol(u) in row.jacobian for row in rows)]
