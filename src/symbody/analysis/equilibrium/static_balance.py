"""`StaticBalance`: the forces on a mechanism at rest, as functions of its configuration, with derivatives.

At rest ``F(q, 0, r) + J^T lambda = 0`` and ``Phi(q) = 0``, and what a damper alone holds, without mass and so
without a speed, has its forces in balance. For each configuration the multipliers, and inputs that are
unknown, are those that leave the least of the forces; what is left is a function of q alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.analysis.curvature import curved_places
from symbody.analysis.derivatives import laws_key, partial_derivatives, with_laws, with_outputs
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.function import CompiledFunction
from symbody.equations.equation_set import EquationSet
from symbody.equations.loads.friction import FrictionLaw
from symbody.equations.outputs.input_formulas import input_formula
from symbody.expr.canonical import ZERO
from symbody.expr.expression import Expr, number
from symbody.expr.graph import TIME, Symbol, SymbolKind
from symbody.expr.rewrite import substitute, symbols_of
from symbody.expr.sequences.sequence import Roots
from symbody.tolerances import BALANCED, BEARING, EXACT, TINY

Floats = NDArray[np.float64]

_FORCES: Final = "rest forces"
_SLOPES: Final = "rest slopes"
_SHARES: Final = "rest shares"
_PULLS: Final = "rest pulls"
_CROSSING: Final = 1e-7  # of the largest term, where branches cross: as well as the place is known
_ROUNDS: Final = 20  # of fits of states of signals
_ROUNDING: Final = 1e-13  # of the largest term of all equations


@dataclass(frozen=True, slots=True, eq=False)
class StaticResidual:
    """Forces and constraints that do not vanish at a configuration.

    Attributes
    ----------
    q, inputs, multipliers : arrays
        Where; the inputs are those unknown, and behind them the states of signals.
    unbalanced : (n_u + n_b + n_s,) array
        Unbalanced forces as work on unit displacements, in units of the largest term, those along motions
        that move no mass behind those along speeds; then rates of signals, as changes of their size in the
        mechanism's time.
    values, slopes : arrays
        All equations that are to vanish, and their derivatives by q in units of sizes.
    terms : (n_u + n_b + n_s,) array
        Sums of absolute terms, which these are compared with.
    shares : (n,) array
        Singular values of what unit multipliers and unknown inputs do, over the largest.
    bearing : int or None
        The number of these that bear loads, if that is given.
    """

    q: Floats
    inputs: Floats
    multipliers: Floats
    unbalanced: Floats
    values: Floats
    slopes: Floats
    terms: Floats
    shares: Floats
    bearing: int | None

    @property
    def largest_gap(self) -> float:
        """By how much the constraints are open, in sizes."""
        return float(np.abs(self.values[self.unbalanced.size :]).max(initial=0.0))

    @property
    def merit(self) -> float:
        """Norm of all equations."""
        return float(np.linalg.norm(self.values))

    @property
    def is_balanced(self) -> bool:
        """Whether the forces are in balance up to rounding."""
        rounding = _ROUNDING if self.bearing is None else _CROSSING
        return bool((np.abs(self.unbalanced) <= BALANCED * self.terms + rounding).all())


@dataclass(frozen=True, slots=True, eq=False)
class StaticBalance:
    """Forces at rest.

    Attributes
    ----------
    evaluator : ConstraintEvaluator
        The constraints as numbers.
    function : CompiledFunction
        Forces and their derivatives.
    unknowns : int
        Number of unknown inputs, without the states of signals, which are unknown in the same way.
    sizes : (n_u + n_b,) array
        Size of displacements along each speed, then along motions that move no mass.
    scales : (n_c,) array
        Sizes of the constraints.
    timed : bool
        Whether the forces depend on time.
    curved : (n_q,) array of bool
        Mask of the coordinates in which forces, or what multipliers do, are not linear.
    rubs : bool
        Whether multipliers press on bristles, which are states of signals.
    """

    evaluator: ConstraintEvaluator
    function: CompiledFunction
    unknowns: int
    sizes: Floats
    scales: Floats
    timed: bool
    curved: NDArray[np.bool_]
    rubs: bool

    @property
    def first_inputs(self) -> Floats:
        """Where unknown inputs are looked for: at 0, and the states of signals at their first values."""
        return np.concatenate([np.zeros(self.unknowns), self.evaluator.signals])

    def largest_term(self, q: Floats) -> float:
        """Return the largest of the terms that are to balance, as work [J]; 1 if there are none."""
        terms = self._evaluate(q, self.first_inputs, np.zeros(len(self.evaluator.eqs.multiplier_names)))
        n = self.sizes.size
        slopes = np.abs(terms[1][:n]) * self.evaluator.sizes * self.sizes[:, np.newaxis]
        forces = np.abs(terms[0][:n]) * self.sizes
        return max(float(slopes.max(initial=0.0)), float(forces.max(initial=0.0))) or 1.0

    def residual(
        self, q: Floats, inputs: Floats, largest: float, bearing: int | None = None
    ) -> StaticResidual:
        """Return the residual at a configuration, with the best multipliers and unknown inputs.

        Parameters
        ----------
        largest : float
            The unit of work [J].
        bearing : int, optional
            Number of singular values of the loads that count, the largest first; by default all but rounding.
        """
        pressing = np.zeros(len(self.evaluator.eqs.multiplier_names))
        for _ in range(_ROUNDS if self.evaluator.signals.size else 0):  # these need not enter linearly
            fit = self._residual(q, inputs, largest, bearing, pressing)
            before, inputs, pressing = inputs, fit.inputs, fit.multipliers
            if not np.isfinite(inputs).all() or (np.abs(inputs - before) <= EXACT * np.abs(inputs)).all():
                break
        return self._residual(q, inputs, largest, bearing, pressing)

    def _residual(
        self, q: Floats, inputs: Floats, largest: float, bearing: int | None, pressing: Floats
    ) -> StaticResidual:
        """Return the residual with multipliers and unknown inputs from one linear fit.

        Bristles between rigid shapes act in proportion to their multipliers, those of the fit before.
        """
        none = np.zeros_like(pressing)
        scale = np.concatenate([self.sizes / largest, self._rate_scales()])
        first = self._evaluate(q, inputs, none)
        by_inputs = self._evaluate(q, inputs, pressing)[2] if self.rubs else first[2]
        pulls = np.zeros((scale.size, none.size))  # multipliers neither act on signals nor move what is light
        by_multipliers = first[3] if self.rubs else first[3].T
        pulls[: len(by_multipliers)] = by_multipliers
        shares = np.hstack([pulls, by_inputs]) * scale[:, np.newaxis]
        weights = np.linalg.norm(shares, axis=0)
        # Rows of J are of order 1 in their scales: one that is less is nearly none, as where branches cross.
        weights[: none.size] = self.scales / largest
        weights[weights == 0.0] = 1.0
        is_finite = bool(np.isfinite(shares).all())
        loads = _Loads(shares / weights if is_finite else np.zeros_like(shares), bearing)
        fit = loads.fit(-first[0] * scale) / weights
        multipliers, inputs = fit[: none.size], inputs + fit[none.size :]
        found = self._evaluate(q, inputs, multipliers)
        left = found[0] * scale if is_finite else np.full_like(scale, np.nan)
        slopes = found[1] * scale[:, np.newaxis]
        _, open_values, open_rows = self.evaluator.manifold().constraints(q)
        rows = np.vstack([loads.project_out(slopes) * self.evaluator.sizes, open_rows])
        values = np.concatenate([left, open_values])
        with np.errstate(invalid="ignore"):  # where forces or constraints are not finite
            terms = np.abs(shares) @ np.abs(fit) + np.abs(slopes) @ self.evaluator.sizes
            if self.evaluator.signals.size:
                terms += np.abs(shares[:, none.size :]) @ np.abs(inputs)
        return StaticResidual(q, inputs, multipliers, left, values, rows, terms, loads.shares, bearing)

    def _rate_scales(self) -> Floats:
        """Return what makes rates of signals changes of their size in the mechanism's time."""
        signals = np.abs(self.evaluator.signals)
        return np.asarray(self.evaluator.mechanism.time / np.where(signals > 0.0, signals, 1.0))

    def _evaluate(self, q: Floats, inputs: Floats, multipliers: Floats) -> Any:
        """Return forces and rates of signals, their derivatives by q and by what is unknown, and J."""
        still = np.zeros(len(self.evaluator.eqs.speed_names))
        given, signals = inputs[: self.unknowns], inputs[self.unknowns :]
        return self.function(self.evaluator.t, q, still, np.concatenate([given, multipliers]), s=signals)


def static_balance(evaluator: ConstraintEvaluator, unknowns: Sequence[str]) -> StaticBalance:
    """Return the forces at rest of the equations of an evaluator; `unknowns` are inputs."""
    eqs = evaluator.eqs
    given: dict[str, Value] = {
        name: evaluator.inputs.get(name, 0) for name in eqs.input_names if name not in unknowns
    }
    laws = {name: law for name, law in given.items() if not _is_number(law, name)}
    key = "balance", tuple(unknowns), laws_key(laws)
    # the formulas of its outputs contain those rows alone that count with these values
    chosen = parameter_set(eqs, evaluator.parameters).eqs
    plan: _BalancePlan = chosen.variants.get(key, lambda: _plan_balance(chosen, unknowns, laws))
    words = (_FORCES, _SLOPES, _SHARES, _PULLS if plan.rubs else "jacobian")
    function = bound_function(plan.wider, words, evaluator.parameters, (), given)
    scales = evaluator.mechanism.constraints(eqs)
    sizes = np.concatenate([evaluator.speed_sizes, _light_sizes(evaluator)])
    return StaticBalance(
        evaluator, function, plan.unknowns, sizes, scales, plan.timed, plan.curved, plan.rubs
    )


def _light_sizes(evaluator: ConstraintEvaluator) -> Floats:
    """Return the sizes of displacements along motions that move no mass (n_b,): the length, or 1 rad."""
    units, length = evaluator.eqs.units, evaluator.mechanism.length
    names = [speed.label.removesuffix("_dot") for speed in evaluator.eqs.formed.light_balances]
    return np.array([length if units.get(name) == "m" else 1.0 for name in names])


class _BalancePlan(NamedTuple):
    """Equations with the forces at rest and their derivatives, for laws of inputs."""

    wider: EquationSet
    unknowns: int
    timed: bool
    curved: NDArray[np.bool_]
    rubs: bool


def _plan_balance(eqs: EquationSet, unknowns: Sequence[str], laws: Mapping[str, Value]) -> _BalancePlan:
    symbols = [symbol for symbol in eqs.formed.inputs if symbol.name in unknowns]
    signals = eqs.formed.signal_states
    forces, pulls = _forces(eqs, laws)
    roots = [
        Roots(_FORCES, (len(forces),), tuple(forces)),
        partial_derivatives(eqs, _SLOPES, forces, eqs.formed.q),
        partial_derivatives(eqs, _SHARES, forces, (*symbols, *signals)),
    ]
    rubs = any(law.touch is not None and law.friction.has_bristles for law in eqs.formed.friction)
    if rubs:
        roots.append(partial_derivatives(eqs, _PULLS, forces, tuple(pulls.values())))
    graph = eqs.formed.graph
    timed = graph.symbol(TIME) in symbols_of(graph, [*forces, *eqs.roots("constraints").nodes])
    slopes = [*roots[1].nodes, *roots[2].nodes, *eqs.roots("jacobian").nodes]
    curved = curved_places(eqs, forces, slopes)
    return _BalancePlan(with_outputs(eqs, roots, pulls), len(symbols), timed, curved, rubs)


def _is_number(law: Value, name: str) -> bool:
    return isinstance(law, int | float) or input_formula(law, name).constant() is not None


def _forces(eqs: EquationSet, given: Mapping[str, Value]) -> tuple[list[int], dict[str, Symbol]]:
    """Return ``F + J^T lambda`` at rest, and the symbols of the multipliers.

    Friction is 0 at rest, but for bristles of given strength, or between rigid shapes.
    Behind the forces stand those along motions that move no mass, and the rates of signals.
    """
    formed, graph = eqs.formed, eqs.formed.graph
    pulls = {
        f"rest lambda {k}": Symbol(f"rest lambda {k}", SymbolKind.INPUT) for k in range(len(formed.rows))
    }
    rows, multipliers = formed.jacobian, formed.expressions(tuple(pulls.values()))
    totals = []
    for i, force in enumerate(formed.dynamics.forcing):
        total = force
        for row, pull in zip(rows, multipliers, strict=True):
            total = total + row[i] * pull
        totals.append(total.index)
    totals += [row.drift.index for row in formed.light_balances.values()]
    totals += eqs.roots("signal_rates").nodes if formed.signal_states else ()
    still = {graph.symbol(speed): ZERO for speed in formed.u}
    by_row = dict(zip((row.name for row in formed.rows), multipliers, strict=True))
    bearing = [_effort_at_rest(law, by_row).index for law in formed.friction]
    efforts = dict(zip((law.effort.index for law in formed.friction), bearing, strict=True))
    acting = substitute(graph, with_laws(eqs, totals, given), efforts)
    return substitute(graph, acting, still), pulls


def _effort_at_rest(law: FrictionLaw, multipliers: Mapping[str, Expr]) -> Expr:
    """Return what friction does at rest; bristles in a joint whose reaction they read count as none."""
    zero = number(law.rate.graph, 0)
    if not law.friction.has_bristles:
        return zero
    share = -(law.slip * law.strength)
    if not law.reads_reaction:
        return share
    return zero if law.touch is None else share * multipliers.get(law.touch.row, zero)


class _Loads:
    """Generalized forces of unit multipliers and unknown inputs, as columns, by singular values."""

    def __init__(self, columns: Floats, bearing: int | None) -> None:
        self._left, singular, self._right = np.linalg.svd(columns, full_matrices=False)
        self.shares = np.asarray(singular / singular.max(initial=TINY))
        least = BEARING if bearing is None else _ROUNDING
        self._count = min(int((self.shares > least).sum()), len(self.shares) if bearing is None else bearing)
        self._singular = singular[: self._count]

    def fit(self, forces: Floats) -> Floats:
        """Return the least loads that come nearest to some forces."""
        k = self._count
        return np.asarray(self._right[:k].T @ ((self._left[:, :k].T @ forces) / self._singular))

    def project_out(self, rows: Floats) -> Floats:
        """Return the part of rows that no loads balance."""
        kept = self._left[:, : self._count]
        return np.asarray(rows - kept @ (kept.T @ rows))
