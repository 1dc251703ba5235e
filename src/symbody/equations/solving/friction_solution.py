"""Friction from reactions: efforts and accelerations that fit together.

Reactions are affine in the friction efforts, so with ``f_k = -c_k N_k`` the vectors of magnitudes N_j
are ``a_j = a0_j + sum of d_jk N_k``, and ``N_j = |a_j|`` is left to solve. For one joint this is a quadratic
equation. For several, Newton's method is written out: with the unit vectors e_j along a_j of the step before,
``(1 - D) N = e . a0`` with ``D_jk = e_j . d_jk``.

There is one solution, whatever the loads, as long as the spectral radius of ``W_jk = |d_jk|`` is below 1,
because N -> |a(N)| then contracts. That holds exactly if all pivots of ``1 - W`` are positive (Berman &
Plemmons, Nonnegative Matrices in the Mathematical Sciences, 1994, theorem 6.2.3), and elimination without
pivoting is then safe for ``1 - D`` too. The pivots are the margins. Where one is not positive, friction may
have two solutions or none (Painleve 1895): the efforts are NaN there rather than one of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

from symbody.equations.equations_of_motion import EquationsOfMotion
from symbody.equations.kinematics.joint_axes import free_directions, perpendiculars
from symbody.equations.kinematics.variables import axis_rotations
from symbody.equations.loads.friction import FrictionLaw, Resistance
from symbody.equations.solving.self_stress import multiplier_nodes, self_stress
from symbody.expr.calculus import linear_coefficients
from symbody.expr.expression import Expr, maximum, minimum, number, sqrt, symbol
from symbody.expr.graph import Symbol, SymbolKind
from symbody.expr.opcodes import ABS, LT, SELECT
from symbody.expr.rewrite import substitute
from symbody.spatial.vector import components, dot, vector
from symbody.tolerances import UNSOLVED

# From forcing and gamma to accelerations and multipliers.
Linear = Callable[[Sequence[Expr], Sequence[Expr]], tuple[list[Expr], list[Expr]]]

# Of 36,000 random systems with a spectral radius of 0.3 to 0.99, 99.9 in 100 end below 1e-13.
_STEPS: Final = 7
_TINY: Final = 1e-200  # N^2 and N m below which a reaction has no direction


def solve_with_friction(formed: EquationsOfMotion, linear: Linear) -> tuple[list[Expr], list[Expr]]:
    """Return u' and the multipliers; the friction is stored in ``formed.resistances``."""
    return FrictionSolver(formed, linear).solution()


def solve_given(formed: EquationsOfMotion, linear: Linear) -> tuple[list[Expr], list[Expr]]:
    """Return u' and the multipliers where all efforts of friction, and of open gaps, are given."""
    graph = formed.graph
    efforts = [formed.given[law.name] for law in formed.friction]
    known = {law.effort.index: effort.index for law, effort in zip(formed.friction, efforts, strict=True)}
    nodes = substitute(graph, [force.index for force in formed.dynamics.forcing], known)
    forcing = {u: Expr(graph, node) for u, node in zip(formed.kinematics.speeds, nodes, strict=True)}
    for row, multiplier in formed.given_rows:
        for u, slope in row.jacobian.items():
            forcing[u] = forcing[u] + slope * multiplier
    one, none = number(graph, 1), [number(graph, 0)] * len(efforts)
    normals = [one if law.touch is None else formed.given[law.touch.row] for law in formed.friction]
    formed.resistances.append(Resistance(efforts, normals, none, [one] * len(efforts)))
    return linear(list(forcing.values()), [row.gamma for row in formed.rows])


class FrictionSolver:
    """One solution; vectors over all unknowns are ordered u', multipliers, friction efforts, shares.

    Shares are what the multipliers of all rows that bear loads differ by for reactions of least norm.
    """

    def __init__(self, formed: EquationsOfMotion, linear: Linear) -> None:
        self.formed, self.linear = formed, linear
        self.graph = formed.graph
        self.laws = formed.friction
        self.zero = number(self.graph, 0)
        self.unknowns = [self.graph.symbol(symbol) for symbol in unknown_symbols(formed)]
        reads = any(law.reads_reaction for law in self.laws)
        stress = self_stress(formed) if reads else None
        self.stress = stress if stress and stress.blocks else None
        self.loads = self.affine([x.index for x in self.stress.values(formed)] if self.stress else [])
        by_element: dict[str, list[int]] = {}
        for k, law in enumerate(self.laws):
            if law.is_coupled:
                by_element.setdefault(law.element, []).append(k)
        # laws that read one reaction: both directions of a contact
        self.coupled = list(by_element.values())
        efforts = [law.effort.index for law in self.laws]
        slopes, rest = linear_coefficients(
            self.graph, [force.index for force in formed.dynamics.forcing], efforts
        )
        self.columns = [[Expr(self.graph, row[k]) for row in slopes] for k in range(len(efforts))]
        self.forcing = [Expr(self.graph, node) for node in rest]

    def solution(self) -> tuple[list[Expr], list[Expr]]:
        """Return u' and the multipliers."""
        given = [self.independent_effort(law) for law in self.laws]
        base = self._with_shares(self.base(given), is_whole=True)
        if not self.coupled:
            return self._store_resistance(base, [], [], [])
        responses = [self._with_shares(self._slip_response(group), is_whole=False) for group in self.coupled]
        laws = [self.laws[group[0]] for group in self.coupled]
        parts = [self._reaction_parts(law, base, responses) for law in laws]
        reactions = [
            _Reaction(first, rest, law.touch is None) for law, (first, rest) in zip(laws, parts, strict=True)
        ]
        normals = self._normals(reactions)
        margins = _pivots([reaction.gains for reaction in reactions], self.zero)
        residuals = [
            _residual(normal, reaction.norm(normals))
            for normal, reaction in zip(normals, reactions, strict=True)
        ]
        normals = _invalidate_doubtful(normals, margins, residuals)
        found = base
        for normal, response in zip(normals, responses, strict=True):
            found = [x + y * normal for x, y in zip(found, response, strict=True)]
        return self._store_resistance(found, normals, residuals, margins)

    def _slip_response(self, group: list[int]) -> list[Expr]:
        """Return how all unknowns answer to the friction that slips with a reaction of 1."""
        total: list[Expr] = []
        for k in group:
            weight = -(self.laws[k].slip * self.laws[k].strength)
            response = [x * weight for x in self.response(k)]
            total = [x + y for x, y in zip(total, response, strict=True)] if total else response
        return total

    def independent_effort(self, law: FrictionLaw) -> Expr:
        """Return the effort, 0 where it depends on reactions."""
        return self.zero if law.reads_reaction or law.sticks else -(law.slip * law.strength)

    def base(self, given: list[Expr]) -> list[Expr]:
        """Return all unknowns without the friction that depends on reactions."""
        forcing = list(self.forcing)
        for effort, column in zip(given, self.columns, strict=True):
            forcing = [x + y * effort for x, y in zip(forcing, column, strict=True)]
        udot, multipliers = self.linear(forcing, [row.gamma for row in self.formed.rows])
        return [*udot, *multipliers, *given]

    def response(self, k: int) -> list[Expr]:
        """Return how all unknowns answer to a unit of one friction effort."""
        efforts = [number(self.graph, int(k == other)) for other in range(len(self.laws))]
        if all(entry.is_zero for entry in self.columns[k]):
            return [*[self.zero] * (len(self.formed.u) + len(self.formed.rows)), *efforts]
        udot, multipliers = self.linear(self.columns[k], [self.zero] * len(self.formed.rows))
        return [*udot, *multipliers, *efforts]

    def _reaction_parts(
        self, law: FrictionLaw, base: list[Expr], responses: list[list[Expr]]
    ) -> tuple[list[Expr], list[list[Expr]]]:
        """Return a joint's reaction without coupled friction, and the change by a unit of each."""
        rows, rest = self.affine([part.index for part in normal_load(self.formed, law)])
        first = [x + self._product(row, base) for x, row in zip(rest, rows, strict=True)]
        return first, [[self._product(row, response) for row in rows] for response in responses]

    def affine(self, nodes: Sequence[int]) -> tuple[list[list[Expr]], list[Expr]]:
        """Return the coefficients of expressions in all unknowns, and the terms without unknowns."""
        redundant = multiplier_nodes(self.formed)[len(self.formed.rows) :] if self.stress else []
        matrix, rest = linear_coefficients(self.graph, nodes, [*self.unknowns, *redundant])
        n, m, end = len(self.formed.u), len(self.formed.rows), len(self.unknowns)
        rows = [[Expr(self.graph, slope) for slope in row] for row in matrix]
        if self.stress:
            rows = [[*row[:end], *row[n : n + m], *row[end:]] for row in rows]
        return rows, [Expr(self.graph, node) for node in rest]

    def _with_shares(self, found: list[Expr], *, is_whole: bool) -> list[Expr]:
        """Return unknowns, or what is linear in them, with the shares that belong to them."""
        if self.stress is None:
            return found
        idle = [self.zero] * len(self.stress.rows)
        values = [self._product(row, [*found, *idle]) for row in self.loads[0]]
        if is_whole:
            values = [x + y for x, y in zip(self.loads[1], values, strict=True)]
        return [*found, *self.stress.shares(values)]

    def _product(self, row: list[Expr], column: list[Expr]) -> Expr:
        total = self.zero
        for x, y in zip(row, column, strict=True):
            total = total + x * y
        return total

    def _normals(self, reactions: list[_Reaction]) -> list[Expr]:
        """Return N with ``N_j = |start_j + sum of change_jk N_k|``."""
        if len(reactions) == 1 and reactions[0].is_norm:
            a, d = reactions[0].start, reactions[0].change[0]
            p, q = _dot(a, d), _dot(d, d)
            return [(p + sqrt(maximum(p * p + (1 - q) * _dot(a, a), _TINY))) / (1 - q)]
        normals = [reaction.norm() for reaction in reactions]
        for _ in range(_STEPS if any(reaction.is_norm for reaction in reactions) else 1):
            units = [reaction.direction(normals) for reaction in reactions]
            matrix = [
                [-_dot(e, d) for d in reaction.change] for e, reaction in zip(units, reactions, strict=True)
            ]
            for k in range(len(matrix)):
                matrix[k][k] = matrix[k][k] + 1
            starts = [_dot(e, reaction.start) for e, reaction in zip(units, reactions, strict=True)]
            normals = _solve_linear(matrix, starts)
        return normals

    def _store_resistance(
        self, solution: list[Expr], found: list[Expr], residuals: list[Expr], margins: list[Expr]
    ) -> tuple[list[Expr], list[Expr]]:
        """Store the friction, return u' and the multipliers."""
        normals = {
            k: normal for group, normal in zip(self.coupled, found, strict=False) for k in group
        }  # fmt: skip
        n, m, end = len(self.formed.u), len(self.formed.rows), len(self.unknowns)
        nodes = {node: value.index for node, value in zip(self.unknowns, solution[:end], strict=True)}
        if self.stress:
            shared = [
                *(x + y for x, y in zip(solution[n : n + m], solution[end:], strict=False)),
                *solution[end + m :],
            ]
            nodes |= {k: x.index for k, x in zip(multiplier_nodes(self.formed), shared, strict=True)}
        one = number(self.graph, 1)
        for k, law in enumerate(self.laws):
            if k not in normals and law.reads_reaction:
                parts = substitute(self.graph, [part.index for part in normal_load(self.formed, law)], nodes)
                normals[k] = _length([Expr(self.graph, node) for node in parts])
        self.formed.resistances.append(
            Resistance(
                efforts=solution[n + m : end],
                normals=[normals.get(k, one) for k in range(len(self.laws))],
                residuals=self._fill_laws(residuals, self.zero),
                margins=self._fill_laws(margins, one),
            )
        )
        return solution[:n], solution[n : n + m]

    def _fill_laws(self, values: list[Expr], other: Expr) -> list[Expr]:
        """Return values of the coupled laws with another one for the rest."""
        pairs = zip(self.coupled, values, strict=False)
        found = {k: value for group, value in pairs for k in group}
        return [found.get(k, other) for k in range(len(self.laws))]


class _Reaction(NamedTuple):
    """A reaction that friction reads, ``start + sum of change_k N_k``.

    Attributes
    ----------
    is_norm : bool
        Whether N is its magnitude; else it has one component, which is never negative: that of a contact.
    """

    start: list[Expr]
    change: list[list[Expr]]
    is_norm: bool

    @property
    def gains(self) -> list[Expr]:
        """By how much N changes at most with each of the others."""
        return [_length(d) if self.is_norm else d[0] for d in self.change]

    def vector(self, normals: Sequence[Expr]) -> list[Expr]:
        """Return the reaction; without friction if there are no N yet."""
        return _add_combination(self.start, self.change, list(normals)) if normals else self.start

    def norm(self, normals: Sequence[Expr] = ()) -> Expr:
        """Return N for what friction it makes."""
        vector = self.vector(normals)
        return _length(vector) if self.is_norm else vector[0]

    def direction(self, normals: Sequence[Expr]) -> list[Expr]:
        """Return the unit vector along the reaction."""
        if self.is_norm:
            return _unit(self.vector(normals))
        return [number(self.start[0].graph, 1)]


def _residual(normal: Expr, other: Expr) -> Expr:
    """Return the difference of two magnitudes over their sum."""
    size = maximum(normal.apply(ABS) + other.apply(ABS), sqrt(number(normal.graph, 1) * _TINY))
    return (normal - other).apply(ABS) / size


def normal_load(formed: EquationsOfMotion, law: FrictionLaw) -> list[Expr]:
    """Return the components of the vector whose magnitude is N, in u', multipliers and friction efforts.

    They are the joint's force perpendicular to its axis [N], in a screw that along it too; in a joint that
    slides also the moment about the origin of its end frame over the radius, if there is one. In a rigid
    contact it is the force along the normal, 0 in equations in which its gap is open.
    """
    joint, names, tree = law.joint, formed.names, formed.kinematics.tree
    if joint is None:
        gap = "" if law.touch is None else law.touch.row
        closed = any(row.name == gap for row in formed.rows)
        return [
            symbol(formed.graph, Symbol(gap, SymbolKind.MULTIPLIER)) if closed else number(formed.graph, 0)
        ]
    wrench, start = formed.wrenches[joint.name], joint.start.full_name
    turns = axis_rotations(names, joint.turns(), f"joint {joint.name}")
    axis = turns[0].axis if turns else free_directions(names, joint)[0]
    normals = [vector(tree.orientation_frame(start), normal) for normal in perpendiculars(formed.graph, axis)]
    if joint.coupled_coordinates:  # a thread carries the load along its axis
        normals.append(vector(tree.orientation_frame(start), axis))
    found = [dot(tree, normal, wrench.force) for normal in normals]
    if law.radius is not None and not turns:
        found += [part / law.radius for part in components(tree, wrench.moment, start)]
    return found


def unknown_symbols(formed: EquationsOfMotion) -> list[Symbol]:
    """Return the symbols of u', the multipliers and the friction efforts."""
    return [*(u.derivative for u in formed.u), *formed.multipliers, *(law.symbol for law in formed.friction)]


def _invalidate_doubtful(normals: list[Expr], margins: list[Expr], residuals: list[Expr]) -> list[Expr]:
    """Return the normals, NaN where they are not determined or were not found."""
    doubt = margins[0]
    for margin in margins[1:]:
        doubt = minimum(doubt, margin)
    if len(normals) > 1:  # one alone is found in closed form
        for residual in residuals:
            doubt = minimum(doubt, UNSOLVED - residual)
    zero, one = number(doubt.graph, 0), number(doubt.graph, 1)
    sound = sqrt(zero.apply(LT, doubt).apply(SELECT, one, -one))
    return [normal * sound for normal in normals]


def _pivots(w: list[list[Expr]], zero: Expr) -> list[Expr]:
    """Return the pivots of ``1 - w``."""
    n = len(w)
    a = [[(1 if i == j else zero) - w[i][j] for j in range(n)] for i in range(n)]
    for k in range(n):
        for i in range(k + 1, n):
            factor = a[i][k] / a[k][k]
            for j in range(k + 1, n):
                a[i][j] = a[i][j] - factor * a[k][j]
    return [a[k][k] for k in range(n)]


def _solve_linear(a: list[list[Expr]], b: list[Expr]) -> list[Expr]:
    """Return x with ``a x = b``, by elimination in the order given."""
    n = len(b)
    a, x = [list(row) for row in a], list(b)
    for k in range(n):
        for i in range(k + 1, n):
            factor = a[i][k] / a[k][k]
            for j in range(k + 1, n):
                a[i][j] = a[i][j] - factor * a[k][j]
            x[i] = x[i] - factor * x[k]
    for k in reversed(range(n)):
        for j in range(k + 1, n):
            x[k] = x[k] - a[k][j] * x[j]
        x[k] = x[k] / a[k][k]
    return x


def _add_combination(a: list[Expr], row: list[list[Expr]], normals: list[Expr]) -> list[Expr]:
    found = list(a)
    for d, n in zip(row, normals, strict=True):
        found = [x + y * n for x, y in zip(found, d, strict=True)]
    return found


def _scale(a: list[Expr], c: Expr) -> list[Expr]:
    return [x * c for x in a]


def _dot(a: list[Expr], b: list[Expr]) -> Expr:
    total = a[0] * b[0]
    for x, y in zip(a[1:], b[1:], strict=True):
        total = total + x * y
    return total


def _length(a: list[Expr]) -> Expr:
    """Return the magnitude; its slope stays finite where it is 0."""
    return sqrt(maximum(_dot(a, a), _TINY))


def _unit(a: list[Expr]) -> list[Expr]:
    length = _length(a)
    return [x / length for x in a]
