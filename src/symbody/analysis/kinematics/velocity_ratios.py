"""`velocity_ratios`: dependent speeds, accelerations and forces by independent ones.

With the constraints ``J_D u_D + J_I u_I = 0`` dependent speeds are ``u_D = tau u_I``, ``tau = -J_D^-1 J_I``
(Nikravesh 1988, section 5.2; García de Jalón & Bayo 1994, section 3.4). By the principle of virtual work the
forces ``Q_I + tau^T Q_D`` balance at rest; reactions do no work and stay out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble, assemble_taut
from symbody.analysis.configurations.closed_gaps import equations_with_closed_gaps, gaps_out_of_place
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.kinematics.continuation import Continuation, continuation
from symbody.analysis.kinematics.driven import element_of
from symbody.analysis.kinematics.independent_speeds import best_speeds, check_names, coupled_notes
from symbody.analysis.redundancy import redundancy
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.errors import Problem, SimulationError, UsageError, nearest, number_in_words
from symbody.expr.sympy.sympy_bridge import SympyExpr, SympyMatrix
from symbody.manifold import least_solution

Floats = NDArray[np.float64]

_SINGULAR: Final = 1e-7  # of scaled motions: independent speeds that all stand still to this share
_BRIEF: Final = 400  # operations up to which formulas are simplified


class MotionSamples(Protocol):
    """A motion: times (N,), coordinates (n_q, N), speeds (n_u, N)."""

    @property
    def t(self) -> Floats:
        """Times."""

    @property
    def q(self) -> Floats:
        """Coordinates."""

    @property
    def u(self) -> Floats:
        """Speeds."""


_MOST_PRINTED: Final = 3  # dependent speeds, and independent ones, of ratios that are printed


@dataclass(frozen=True, slots=True, eq=False)
class VelocityRatios:
    """Ratios of dependent to independent speeds, as formulas and as numbers.

    Attributes
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    independent, dependent : tuple of str
        Names of speeds; rows of `tau` are dependent ones, its columns independent ones.
    rows : tuple of str
        Names of the multipliers of the constraints that `dependent_jacobian` is made of.
    notes : tuple of str
        Choices that were made, with reasons.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> sb.velocity_ratios(sb.form_equations(ladder), "x").tau
    Matrix([[-x(t)/y(t)]])
    """

    eqs: EquationSet = field(repr=False)
    independent: tuple[str, ...]
    dependent: tuple[str, ...]
    rows: tuple[str, ...]
    notes: tuple[str, ...]
    _mechanism: Continuation = field(repr=False)
    _parameters: Mapping[str, Value] = field(repr=False)
    # Measures the gaps of ropes and stops; None where there are none.
    _gaps: ConstraintEvaluator | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        ratios = f"{', '.join(self.dependent) or 'none'} by {', '.join(self.independent)}"
        return f"<VelocityRatios of {self.eqs.model.name!r}: {ratios}>"

    def __str__(self) -> str:
        """Return the ratios as formulas where there are few, else which speeds they are of."""
        if not 0 < len(self.dependent) <= _MOST_PRINTED or len(self.independent) > _MOST_PRINTED:
            return repr(self)
        tau = self.tau
        lines = [
            f"  {name}/{given} = {tau[i, j]}"
            for i, name in enumerate(self.dependent)
            for j, given in enumerate(self.independent)
        ]
        return "\n".join([f"velocity ratios of {self.eqs.model.name!r}:", *lines])

    @property
    def dependent_jacobian(self) -> SympyMatrix:
        """J_D, square."""
        return self._part(self.dependent)

    @property
    def independent_jacobian(self) -> SympyMatrix:
        """J_I."""
        return self._part(self.independent)

    @property
    def determinant(self) -> SympyExpr:
        """det(J_D): where it is 0 on the constraints, the mechanism is in a singular position."""
        return _simplify_short(self.dependent_jacobian.det(method="berkowitz"))

    @property
    def tau(self) -> SympyMatrix:
        """``-J_D^-1 J_I`` as formulas; meant for small mechanisms."""
        block = self.dependent_jacobian
        if not block.rows:
            return self.independent_jacobian
        ratios = -(block.adjugate(method="berkowitz") * self.independent_jacobian)
        determinant = self.determinant
        return ratios.applyfunc(lambda entry: _simplify_short(entry / determinant))

    @property
    def force_balance(self) -> SympyMatrix:
        """``Q_I + tau^T Q_D`` at rest, (f, 1): zero in equilibrium; not valid with dry friction."""
        still = {speed: 0 for speed in self.eqs.speeds}
        forces = self.eqs.forcing.subs(still)
        parts = [forces.extract(self._places(names), [0]) for names in (self.independent, self.dependent)]
        balance = parts[0] + self.tau.T * parts[1] if self.dependent else parts[0]
        return balance.applyfunc(_simplify_short)

    @checked_arguments
    def holding(self, unknown: str) -> SympyExpr:
        """Return the input that holds a mechanism with one degree of freedom at rest, as a formula.

        Raises
        ------
        UsageError
            If the mechanism has more degrees of freedom, or the input does not enter linearly.
        """
        names = self.eqs.input_names
        if unknown not in names or len(self.independent) != 1:
            what = (
                f"{unknown!r} is not an input"
                if unknown not in names
                else f"the mechanism has {number_in_words(len(self.independent), 'degree of freedom')}"
            )
            raise UsageError(
                Problem("kinematics.holding", f"holding {unknown}", what,
                "one force holds one degree of freedom",
                        "solve force_balance for the same number of inputs" if unknown in names
                        else nearest(unknown, names))
            )  # fmt: skip
        symbol = self.eqs.inputs[names.index(unknown)]
        balance = self.force_balance[0]
        slope = _simplify_short(balance.diff(symbol))
        if slope == 0 or slope.has(symbol):
            raise UsageError(
                Problem("kinematics.holding", f"holding {unknown}", f"{unknown} does not hold the mechanism",
                        "its coefficient in the balance of forces is zero, or depends on this input",
                        "name an input that does work in the motion")
            )  # fmt: skip
        return _simplify_short(-balance.subs(symbol, 0) / slope)

    @checked_arguments
    def at(self, state: State | Mapping[str, Value]) -> Floats:
        """Return tau as numbers (n_D, n_I) at a state, or at the position with these values.

        Raises
        ------
        SimulationError
            At a singular position, naming joint and configuration.
        """
        complete = self._state(state)
        return self._tau(complete.t, np.array(list(complete.q.values())))

    @checked_arguments
    def along(self, run: MotionSamples) -> Floats:
        """Return tau along a motion, (n_D, n_I, N)."""
        ratios = [self._tau(float(t), q) for t, q in zip(run.t, run.q.T, strict=True)]
        return np.moveaxis(np.array(ratios), 0, -1)

    @checked_arguments
    def speeds(self, state: State | Mapping[str, Value], rates: Mapping[str, float]) -> dict[str, float]:
        """Return all speeds at a position, from the independent ones; those not given are 0."""
        complete = self._state(state)
        q = np.array(list(complete.q.values()))
        self._tau(complete.t, q)
        u = self._complete(complete.t, q, np.zeros(len(self.eqs.speed_names)), rates, 1)
        return dict(zip(self.eqs.speed_names, u.tolist(), strict=True))

    @checked_arguments
    def accelerations(
        self,
        state: State | Mapping[str, Value],
        rates: Mapping[str, float],
        accelerations: Mapping[str, float],
    ) -> dict[str, float]:
        """Return all accelerations at a position, from independent speeds and their rates.

        Parameters
        ----------
        rates, accelerations : mapping of name to float
            Of independent speeds, the latter by the names of the speeds or of their rates; 0 if not given.
        """
        names = self.eqs.acceleration_names
        of_speed = dict(zip(names, self.eqs.speed_names, strict=True))
        asked = {of_speed.get(name, name): value for name, value in accelerations.items()}
        complete = self._state(state)
        q = np.array(list(complete.q.values()))
        u = np.array(list(self.speeds(complete, rates).values()))
        return dict(zip(names, self._complete(complete.t, q, u, asked, 2).tolist(), strict=True))

    @checked_arguments
    def generalized_forces(self, state: State | Mapping[str, Value]) -> Floats:
        """Return ``F_I + tau^T F_D`` (n_I,) at a state: what its forces do along each independent speed.

        A mapping fixes coordinates and speeds, as in `assemble`; inputs are then 0.
        """
        complete = self._state(state)
        q, u = (np.array(list(x.values())) for x in (complete.q, complete.u))
        inputs = dict.fromkeys(self.eqs.input_names, 0) | dict(complete.inputs)
        forces = bound_function(self.eqs, "forcing", self._parameters, (), inputs)(complete.t, q, u)
        places, others = self._places(self.independent), self._places(self.dependent)
        along: Floats = forces[places] + self._tau(complete.t, q).T @ forces[others]
        return along

    def _part(self, speeds: Sequence[str]) -> SympyMatrix:
        names = self.eqs.multiplier_names
        return self.eqs.constraint_jacobian.extract(
            [names.index(row) for row in self.rows], self._places(speeds)
        )

    def _places(self, names: Sequence[str]) -> list[int]:
        return [self.eqs.speed_names.index(name) for name in names]

    def _state(self, state: State | Mapping[str, Value]) -> State:
        if isinstance(state, State):
            return state
        complete = assemble if self._gaps is None else assemble_taut
        return complete(self.eqs, state, None, parameters=self._parameters)

    def gaps_out_of_place(self, q: Floats) -> str:
        """Return a sentence on the ropes and stops that are not as the ratios assume; empty if all are."""
        return "" if self._gaps is None else gaps_out_of_place(self.eqs, self._gaps, q)

    def _check_gaps(self, q: Floats) -> None:
        """Refuse a position at which other gaps are closed than those of the equations.

        Raises
        ------
        SimulationError
            Naming the ropes and stops.
        """
        wrong = self.gaps_out_of_place(q)
        if wrong:
            raise SimulationError(
                Problem("kinematics.rope", f"speeds {', '.join(self.independent)}",
                        f"{wrong}: the ratios do not hold in this state",
                        "they hold for the gaps that are closed where they were formed",
                        "form the ratios with at= a state like this one")
            )  # fmt: skip

    def _tau(self, t: float, q: Floats) -> Floats:
        mechanism = self._mechanism
        self._check_gaps(q)
        jacobian = mechanism.rows(t, q, np.zeros(mechanism.speed_sizes.size))[0]
        basis = mechanism.freedoms(jacobian)
        places, others = self._places(self.independent), self._places(self.dependent)
        if basis.shape[1] != len(places):
            raise SimulationError(
                self._singular(q, "the constraints depend on each other here (bifurcation)")
            )
        left, sizes, _ = np.linalg.svd(basis[places])
        if sizes.size and sizes[-1] < _SINGULAR:
            k = int(np.abs(left[:, -1]).argmax())
            element = element_of(self.eqs, self.independent[k])
            why = (
                f"{element} stands still while others move (dead position): {self.independent[k]} cannot "
                f"drive the mechanism"
            )
            raise SimulationError(self._singular(q, why))
        ratios = np.linalg.solve(basis[places].T, basis[others].T).T if places else np.zeros((len(others), 0))
        tau: Floats = ratios * mechanism.speed_sizes[others][:, np.newaxis] / mechanism.speed_sizes[places]
        return tau

    def _singular(self, q: Floats, why: str) -> Problem:
        place = ", ".join(f"{name} = {x:.6g}" for name, x in zip(self.eqs.coordinate_names, q, strict=True))
        return Problem("kinematics.singular", f"speeds {', '.join(self.independent)}",
                       f"these speeds do not determine the others at {place}", why,
                       "choose other independent speeds, or a nearby position")  # fmt: skip

    def _complete(self, t: float, q: Floats, u: Floats, asked: Mapping[str, float], order: int) -> Floats:
        """Return all speeds (order 1) or accelerations (order 2) that fit the constraints."""
        unknown = [self._label(name) for name in asked if self._label(name) not in self.independent]
        if unknown:
            raise UsageError(
                Problem("kinematics.not_independent", ", ".join(unknown),
                        "these speeds are not independent", "",
                        f"the independent speeds are {', '.join(self.independent)}")
            )  # fmt: skip
        mechanism, values = self._mechanism, {self._label(name): x for name, x in asked.items()}
        jacobian, rate, acceleration = mechanism.rows(t, q, u)
        right = rate if order == 1 else acceleration
        places = self._places(self.independent)
        independent = np.array([values.get(name, 0.0) for name in self.independent])
        result = np.zeros(mechanism.speed_sizes.size)
        result[places] = independent
        others = self._places(self.dependent)
        columns = mechanism.scaled_rows(jacobian)[:, others]
        missing = (right - jacobian[:, places] @ independent) / mechanism.scales
        result[others] = least_solution(columns, missing) * mechanism.speed_sizes[others]
        return result

    def _label(self, name: str) -> str:
        return name if name in self.eqs.speed_names else f"{name}_dot"


@named_after(3)
@checked_arguments
def velocity_ratios(
    eqs: EquationSet,
    independent: str | Sequence[str] | None = None,
    at: State | None = None,
    parameters: Mapping[str, Value] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> VelocityRatios:
    """Return the ratios of dependent to independent speeds.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    independent : str or sequence of str
        Coordinates or speeds, one per degree of freedom. By default those from which the others follow
        best at a configuration, by pivoting; those with an input are preferred.
    at : State
        That configuration; by default one near the model's initial values.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model, and without any length there
        from the configuration.

    Returns
    -------
    VelocityRatios
        The rows of dependent speeds over the independent ones, in the order of ``ratios.dependent`` and
        ``ratios.independent``: ``tau`` as a SymPy matrix, ``ratios.at(state)`` as an array of the same shape.
        ``determinant`` is 0 where they do not exist.

    Raises
    ------
    UsageError
        If names make no sense, or their number differs from the degrees of freedom.
    AssemblyError
        If the loops do not close.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> ratios = sb.velocity_ratios(eqs, "x")
    >>> ratios.dependent, ratios.independent
    (('y_dot',), ('x_dot',))
    """
    values = dict(parameters or {})
    state = at or assemble(eqs, None, None, parameters=parameters, scales=scales)
    mechanism_sizes = mechanism_scales(eqs, values, scales, state.q)
    q = np.array(list(state.q.values()))
    eqs, notes = equations_with_closed_gaps(eqs, q, values, state.t)
    mechanism = continuation(eqs, {}, {}, values).rescale(mechanism_sizes)
    freedoms = redundancy(eqs, values, dict(state.q), scales=scales) if eqs.multiplier_names else None
    rows = () if freedoms is None else freedoms.kept
    count = len(eqs.speed_names) - len(rows)
    if independent is None:
        chosen = best_speeds(mechanism, eqs, state.t, q, count)
        notes += (f"chosen independent speeds: {', '.join(chosen)}; they determine the others best",)
    else:
        chosen = check_names(
            eqs, (independent,) if isinstance(independent, str) else tuple(independent), count
        )
    others = tuple(name for name in eqs.speed_names if name not in chosen)
    notes += coupled_notes(eqs)
    measured = (
        constraint_evaluator(eqs, values, {}, state.t, mechanism_sizes)
        if unilateral_elements(eqs.formed)
        else None
    )
    return VelocityRatios(eqs, chosen, others, rows, notes, mechanism, values, measured)


def _simplify_short(value: SympyExpr) -> SympyExpr:
    """Return a short formula simplified, a long one as it is."""
    return value.simplify() if value.count_ops() <= _BRIEF else value
