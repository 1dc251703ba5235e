"""What decides about modes: how dry joints, ropes and stops answer to each other's efforts.

Candidates are the joints whose friction is not known beforehand, then ropes and stops. No row of a candidate
holds here: the efforts of all are unknown, and accelerations and reactions are affine in them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.constraint_equation import ConstraintEquation
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.solving.friction_solution import FrictionSolver, normal_load
from symbody.equations.solving.solution import solve_linear
from symbody.equations.solving.sticking import holding_row
from symbody.equations.solving.unilateral import gap_scale, open_gaps, unilateral_elements, unilateral_row
from symbody.expr.calculus import linear_coefficients
from symbody.expr.expression import Expr, number
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS


def candidate_laws(formed: EquationsOfMotion) -> list[FrictionLaw]:
    """Return the friction that switches, or that depends on reactions and slips."""
    return [law for law in formed.friction if law.switches or law.is_coupled]


def candidate_gaps(formed: EquationsOfMotion) -> list[str]:
    """Return the ropes and stops whose rows are among those of the equations."""
    closed = {row.gap for row in formed.rows}
    return [name for name in unilateral_elements(formed) if name in closed]


def reaction_sizes(formed: EquationsOfMotion) -> list[int]:
    """Return how many components of a reaction the friction of each candidate reads."""
    laws = candidate_laws(formed)
    return [len(normal_load(formed, law)) if law.reads_reaction else 0 for law in laws]


def mode_responses(formed: EquationsOfMotion) -> list[Expr]:
    """Return what decides about modes; candidates are the ropes and stops whose rows the equations have.

    One after the other: slip, kinetic and static strength of each joint; along the rows, which are rates of
    joints and gaps, the accelerations without efforts, then by row their change by a unit of each, which
    opens gaps; the same of the components of the reactions that friction reads; what cancels in each
    acceleration, whose rounding is a share of it; the change of the speeds by a unit of impulse of each.
    """
    solver = _ResponseSolver(formed)
    laws = candidate_laws(formed)
    first, *columns = solver.columns()
    held = [holding_row(formed, law) for law in laws]
    rows = [solver.acceleration(row, 1) for row in held]
    rows += [solver.acceleration(row, row.sense) for row in solver.gaps]
    parts = [part for law in laws if law.reads_reaction for part in normal_load(formed, law)]
    slopes, loads = solver.affine(parts)
    return [
        *(value for law in laws for value in (law.slip, law.strength, law.limit)),
        *(solver.product(row, first) + rest for row, rest in rows),
        *(solver.product(row, column) for row, _ in rows for column in columns),
        *(solver.product(row, first) + rest for row, rest in zip(slopes, loads, strict=True)),
        *(solver.product(row, column) for row in slopes for column in columns),
        *(solver.size(row, first) for row in (*held, *solver.gaps)),
        *(x for column in columns for x in column[: len(formed.u)]),
    ]


class _ResponseSolver:
    """Unknowns with all gaps open, ordered as those of `FrictionSolver`, then the multipliers of gaps."""

    def __init__(self, formed: EquationsOfMotion) -> None:
        names = self.names = candidate_gaps(formed)
        self.formed, self.loose = formed, open_gaps(formed, names)
        self.gaps = [unilateral_row(formed, name) for name in names]
        self.nodes = [formed.graph.symbol(Symbol(row.name, SymbolKind.MULTIPLIER)) for row in self.gaps]
        self.zero = number(formed.graph, 0)
        self.solver = FrictionSolver(self.loose, partial(solve_linear, self.loose))
        stress = self.solver.stress
        self.loads = self.affine(stress.values_by(formed, formed.wrenches) if stress else [])

    def columns(self) -> list[list[Expr]]:
        """Return all unknowns without efforts of candidates, and their change by a unit of each."""
        candidates = candidate_laws(self.formed)
        given = [
            self.zero if law in candidates else self.solver.independent_effort(law)
            for law in self.loose.friction
        ]
        idle = [self.zero] * len(self.gaps)
        found = [self._with_shares(self.solver.base(given), idle, is_whole=True)]
        for k, law in enumerate(self.loose.friction):
            if law in candidates:
                found.append(self._with_shares(self.solver.response(k), idle, is_whole=False))
        efforts = [self.zero] * len(self.loose.friction)
        for k, row in enumerate(self.gaps):
            pull = [row.sense * row.jacobian.get(u, self.zero) for u in self.loose.kinematics.speeds]
            udot, multipliers = solve_linear(self.loose, pull, [self.zero] * len(self.loose.rows))
            ends = [number(self.zero.graph, row.sense * (k == other)) for other in range(len(self.gaps))]
            found.append(self._with_shares([*udot, *multipliers, *efforts], ends, is_whole=False))
        return found

    def acceleration(self, row: ConstraintEquation, sign: int) -> tuple[list[Expr], Expr]:
        """Return the second rate of what a row holds, or of its negative, in the unknowns."""
        slopes = [sign * row.jacobian.get(u, self.zero) for u in self.loose.kinematics.speeds]
        return slopes, -sign * row.gamma

    def size(self, row: ConstraintEquation, first: list[Expr]) -> Expr:
        """Return the sum of the magnitudes of what the second rate of a row consists of."""
        total, speed = row.gamma.apply(ABS), self.zero
        for u, rate in zip(self.loose.kinematics.speeds, first, strict=False):
            slope = row.jacobian.get(u, self.zero)
            total = total + (slope * rate).apply(ABS)
            speed = speed + (slope * Expr(self.zero.graph, u)).apply(ABS)
        scale = gap_scale(self.formed, row) if row.gap in self.names else self.zero
        return total if scale.is_zero else total + speed**2 / scale

    def affine(self, values: Sequence[Expr]) -> tuple[list[list[Expr]], list[Expr]]:
        """Return the coefficients of values in all unknowns, and the terms without."""
        graph = self.formed.graph
        slopes, rest = linear_coefficients(graph, [value.index for value in values], self.nodes)
        rows, others = self.solver.affine(rest)
        ends = [[Expr(graph, slope) for slope in row] for row in slopes]
        return [[*row, *end] for row, end in zip(rows, ends, strict=True)], others

    def product(self, row: Sequence[Expr], column: Sequence[Expr]) -> Expr:
        """Return the inner product of coefficients, maybe of the first unknowns only, and unknowns."""
        total = self.zero
        for x, y in zip(row, column, strict=False):
            total = total + x * y
        return total

    def _with_shares(self, found: list[Expr], ends: list[Expr], *, is_whole: bool) -> list[Expr]:
        stress = self.solver.stress
        if stress is None:
            return [*found, *ends]
        idle = [self.zero] * len(stress.rows)
        values = [self.product(row, [*found, *idle, *ends]) for row in self.loads[0]]
        if is_whole:
            values = [x + y for x, y in zip(self.loads[1], values, strict=True)]
        return [*found, *stress.shares(values), *ends]
