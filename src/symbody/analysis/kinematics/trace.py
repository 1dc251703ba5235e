"""`trace_positions`: the positions of a mechanism while some of its coordinates are led through values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.configurations.closed_gaps import LOOSE, equations_with_closed_gaps, gap_shares
from symbody.analysis.configurations.gap_words import gap_words
from symbody.analysis.constraint_evaluator import ConstraintEvaluator, constraint_evaluator
from symbody.analysis.kinematics.continuation import Continuation, Law, continuation
from symbody.analysis.kinematics.driven import element_of
from symbody.analysis.kinematics.led_values import LedValues, led_numbers, read_values
from symbody.analysis.scales import mechanism_scales
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.bound_function import bound_function
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.errors import EnvironmentFault, Problem, UsageError, nearest

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]

_EXACT: Final = 1e-10  # of the path: where on it a gap closes


@dataclass(frozen=True, slots=True, eq=False)
class Positions:
    """Positions of a mechanism, one column each.

    Attributes
    ----------
    coordinate_names : tuple of str
        Names of the rows of `q`.
    q : (n_q, N) array
        As far as the mechanism could be driven.
    driven : mapping of coordinate to (N,) array
        Values of the driven coordinates.
    limits : mapping of coordinate to float
        Empty if all values were reached; else the values of the driven coordinates at the dead end.
    joint : str
        The joint that moves fastest at the dead end; empty if there is none, or a rope or stop ends the path.
    notes : tuple of str
        The reason for the dead end, and the ropes and stops that are taken as taut and closed.
    followers : mapping of coordinate to (N,) array
        Coordinates that couplings give, where they are substituted.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> path = sb.trace_positions(sb.form_equations(ladder), {"x": [0.0, 3.0, 4.0]})
    >>> path.coordinate_names, path["y"].round(6)
    (('x', 'y'), array([5., 4., 3.]))
    """

    coordinate_names: tuple[str, ...]
    q: Floats
    driven: Mapping[str, Floats]
    limits: Mapping[str, float]
    joint: str = ""
    notes: tuple[str, ...] = ()
    followers: Mapping[str, Floats] = field(default_factory=dict)

    def __repr__(self) -> str:
        ends = (
            f"{name} from {values[0]:.6g} to {values[-1]:.6g}"
            for name, values in self.driven.items()
            if values.size
        )
        dead = ", ".join(f"{name} = {value:.6g}" for name, value in self.limits.items())
        reached = f"stopped at a dead end at {dead}" if dead else "all reached"
        path = "; ".join([*ends, reached])
        return f"<Positions of {', '.join(self.coordinate_names)}: {self.q.shape[-1]} of them, {path}>"

    @property
    def success(self) -> bool:
        """Whether all values were reached."""
        return not self.limits

    def __getitem__(self, name: str) -> Floats:
        """Return the values of one coordinate (N,).

        Raises
        ------
        UsageError
            An unknown name.
        """
        columns = self.columns()
        if name not in columns:
            raise UsageError(
                Problem("kinematics.unknown_column", repr(name), f"the positions have no {name!r}", "",
                        nearest(name, columns))
            )  # fmt: skip
        return columns[name]

    def columns(self) -> dict[str, Floats]:
        """Return all coordinates by name, the driven ones first."""
        return {**self.driven, **dict(zip(self.coordinate_names, self.q, strict=True)), **self.followers}

    def to_pandas(self) -> pandas.DataFrame:
        """Return `columns` as a pandas table.

        Raises
        ------
        EnvironmentFault
            If pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            fix = "pip install symbody[pandas], or use .columns()"
            raise EnvironmentFault(
                Problem("kinematics.pandas", "to_pandas", "pandas is not installed", fix=fix)
            ) from None
        return pandas.DataFrame(self.columns())


@named_after(3)
@checked_arguments
def trace_positions(
    eqs: EquationSet,
    over: Mapping[str, LedValues],
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    t: float = 0.0,
    *,
    scales: Mapping[str, float] | None = None,
) -> Positions:
    """Drive coordinates through values, each position found from the one before.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    over : mapping of coordinate to (N,) values or one value
        For each degree of freedom a coordinate: numbers, formulas, ``"30 deg"``. A single value fixes it.
    guess : mapping of name to number or formula in parameters
        Near which the loops close at the first values.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    t : float
        Time [s], for explicit time in the model.
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model, and without any length there
        from the first position and the driven values.

    Returns
    -------
    Positions
        ``path["y"]`` are the values of a coordinate [m, rad], one for each position up to the dead end,
        where there is one: (N,); ``path.q`` all, (n_q, N), in the order of ``path.coordinate_names``.
        `limits` has the driven values at the dead end, to about 1e-9, and is empty if there is none.

    Raises
    ------
    UsageError
        If names or values make no sense, or degrees of freedom are left.
    AssemblyError
        If the loops do not close at the first values.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> path = sb.trace_positions(eqs, {"x": [0.0, 3.0, 4.0]})
    >>> path["y"].round(6)
    array([5., 4., 3.])
    """
    values = read_values(led_numbers(eqs, over, parameters))
    values_given = dict(parameters or {})
    driven = continuation(eqs, {}, _laws(values), values_given, lambda _: t)
    start = {name: float(x[0]) for name, x in values.items()}
    state = assemble(eqs, start, guess, parameters=parameters, inputs=None, t=t, scales=scales)
    q = np.array(list(state.q.values()))
    held, notes = equations_with_closed_gaps(eqs, q, values_given, t)
    if held is not eqs:
        driven = continuation(held, {}, _laws(values), values_given, lambda _: t)
    farthest = {name: float(np.abs(x).max()) for name, x in values.items()}
    mechanism = mechanism_scales(eqs, values_given, scales, {**state.q, **farthest})
    closer = (driven := driven.rescale(mechanism)).correct(0.0, q)
    q = q if closer is None else closer
    check_driven(driven, 0.0, q, notes)
    loose = _OpenGaps(driven, constraint_evaluator(held, values_given, {}, t, mechanism) if notes else None)
    positions = _lead(driven, loose, values, q, notes)
    return replace(positions, followers=_followers(eqs, positions.q, values_given))


def _lead(
    driven: Continuation, loose: _OpenGaps, values: Mapping[str, Floats], q: Floats, notes: tuple[str, ...]
) -> Positions:
    """Return the positions from q on, each found from the one before."""
    columns, reached = [q], 0.0
    for k in range(1, len(next(iter(values.values())))):
        before = q
        reached, q = driven.follow(float(k - 1), q, float(k))
        element, place, at = loose.first_closed(float(k - 1), before, reached, q)
        if element or reached != k:
            return _stop_at_limit(driven, values, np.array(columns).T, place, at, element, notes)
        columns.append(q)
    return Positions(driven.eqs.coordinate_names, np.array(columns).T, values, {}, notes=notes)


def _followers(eqs: EquationSet, q: Floats, parameters: Mapping[str, Value]) -> dict[str, Floats]:
    """Return the coordinates that substituted couplings give."""
    names = tuple(eqs.formed.coupled.values)
    if not names:
        return {}
    silent = dict.fromkeys(eqs.input_names, 0)
    function = bound_function(eqs, names, parameters, (), silent, quick=True)
    still = np.zeros(len(eqs.speed_names))
    rows = np.array([function(0.0, column, still) for column in q.T], dtype=np.float64)
    return dict(zip(names, rows.reshape(-1, len(names)).T, strict=True))


@dataclass(frozen=True, slots=True, eq=False)
class _OpenGaps:
    """The gaps that are open on a path; `evaluator` measures them, and is None where there are none."""

    driven: Continuation
    evaluator: ConstraintEvaluator | None

    def first_closed(self, start: float, before: Floats, stop: float, q: Floats) -> tuple[str, float, Floats]:
        """Return the element whose gap closes first, and where on the path; else no name, and its end."""
        if self.evaluator is None or self._least_gap(q)[1] >= -LOOSE:
            return "", stop, q
        low, high = start, stop
        while high - low > _EXACT * max(1.0, abs(high)):
            middle = (low + high) / 2.0
            place, at = self.driven.follow(start, before, middle)
            if place == middle and self._least_gap(at)[1] >= 0.0:
                low = middle
            else:
                high = middle
        return self._least_gap(q)[0], low, self.driven.follow(start, before, low)[1]

    def _least_gap(self, q: Floats) -> tuple[str, float]:
        """Return the element with the least gap, and this over its size."""
        assert self.evaluator is not None
        return min(gap_shares(self.evaluator, q).items(), key=lambda pair: pair[1])


def check_driven(driven: Continuation, s: float, q: Floats, notes: tuple[str, ...] = ()) -> None:
    """Refuse driven coordinates that leave freedoms, with notes on gaps that are open.

    Raises
    ------
    UsageError
        With their number, and the speeds that show them.
    """
    jacobian = driven.rows(s, q, np.zeros(driven.speed_sizes.size))[0]
    basis = driven.freedoms(jacobian)
    left = basis.shape[1]
    if left:
        free = ", ".join(driven.free_speeds(basis))
        names = ", ".join(driven.driven) or "nothing"
        raise UsageError(
            Problem("kinematics.freedoms_left", "over",
                    f"with {names} driven, {left} more can still move freely: {free}",
                    "; ".join(("the driven coordinates do not determine the positions", *notes)),
                    "drive further coordinates, or hold them fixed: over={..., 'name': value}")
        )  # fmt: skip


def _stop_at_limit(
    driven: Continuation,
    values: Mapping[str, Floats],
    q: Floats,
    s: float,
    last: Floats,
    element: str,
    notes: tuple[str, ...],
) -> Positions:
    """Return the positions up to a dead end, which is the last column."""
    limits = driven.driven_values(s)
    joint = "" if element else driven.blocking_joint(s, last)
    reached = ", ".join(f"{name} = {value:.9g}" for name, value in limits.items())
    subject, why = element_of(driven.eqs, joint), "the driven coordinate has a limit there"
    if element:
        words = gap_words(driven.eqs, element)
        subject, why = words.subject, words.impossible
    note = f"{subject}: the mechanism cannot move beyond {reached}; {why}"
    done = {name: np.append(x[: q.shape[1]], limits[name]) for name, x in values.items()}
    return Positions(
        driven.eqs.coordinate_names, np.column_stack([q, last]), done, limits, joint, (*notes, note)
    )


def _laws(values: Mapping[str, Floats]) -> dict[str, Law]:
    """Return laws that lead from value to value, in equal parts of the path."""

    def law(x: Floats) -> Law:
        places = np.arange(x.size)

        def evaluate(s: float) -> tuple[float, float, float]:
            k = min(int(s), x.size - 2)
            slope = float(x[k + 1] - x[k]) if x.size > 1 else 0.0
            return float(np.interp(s, places, x)), slope, 0.0

        return evaluate

    return {name: law(x) for name, x in values.items()}
