"""`find_equilibrium`: configurations at which nothing moves, the nearest to a guess first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.accelerations import complete_state
from symbody.analysis.configurations.assembly import assemble
from symbody.analysis.configurations.one_sided import settle
from symbody.analysis.constraint_evaluator import STARTS, ConstraintEvaluator, constraint_evaluator
from symbody.analysis.equilibrium.closed_gap_search import Candidate, ClosedGapSearch
from symbody.analysis.equilibrium.equilibrium_search import examine_neighbourhood
from symbody.analysis.held_inputs import refuse_held
from symbody.analysis.linear.linearization import Linearization
from symbody.analysis.linear.linearize import linearize
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.analysis.value_lines import values_line
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.sticking import switching_joints
from symbody.errors import AssemblyError, Problem, SimulationError, SymbodyError, nearest
from symbody.single_flight import SingleFlight
from symbody.tolerances import BALANCED

Floats = NDArray[np.float64]

_VERDICTS: Final = {"stable": True, "unstable": False}


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Equilibrium(State):
    """A state at rest.

    Attributes
    ----------
    notes : tuple of str
        Properties beyond the numbers.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Mass", mass=2), axis="z", coordinate="z",
    ...                     force=sb.Drive(stiffness=100))
    >>> eqs = sb.form_equations(sb.Model("scale", [rail], gravity=(0, 0, -10)))
    >>> rest = sb.find_equilibrium(eqs)
    >>> round(rest["z"], 9), bool(rest.residual < 1e-9)
    (-0.2, True)
    """

    notes: tuple[str, ...] = ()
    # Why linear equations do not show whether it is stable; empty where they may.
    _doubt: str = field(default="", repr=False)
    _linear: SingleFlight[None, Linearization] = field(default_factory=SingleFlight, repr=False)

    def __repr__(self) -> str:
        try:
            verdict = self.verdict
        except SymbodyError:  # no linear equations here
            verdict = "stability unknown"
        lines = [values_line(values, self.eqs.units) for values in (self.q, self.s)]
        return f"Equilibrium, {verdict}: {'; '.join(filter(None, lines))}"

    @property
    def linearization(self) -> Linearization:
        """The equations of small deviations from it."""
        return self._linear.get(None, lambda: linearize(self.eqs, self))

    @property
    def verdict(self) -> str:
        """The verdict of the linear equations on small deviations, see `Linearization`.

        "critical" where the stiffness vanishes along a direction without further equilibria: terms of
        higher order decide, unless something else grows. "undecided" where there are no linear equations:
        where branches cross, or a gap is closed without effort.
        """
        if self._doubt == "undecided":
            return self._doubt
        found = self.linearization.verdict
        return self._doubt if self._doubt and found != "unstable" else found

    @property
    def stable(self) -> bool | None:
        """True if all small deviations die out, False if some grow, None if linear equations show neither."""
        return _VERDICTS.get(self.verdict)


@named_after(3)
@checked_arguments
def find_equilibrium(
    eqs: EquationSet,
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    inputs: Mapping[str, Value] | None = None,
    unknowns: str | Sequence[str] = (),
    fixed: Mapping[str, Value] | None = None,
    t: float = 0.0,
    *,
    scales: Mapping[str, float] | None = None,
) -> Equilibrium:
    """Return the equilibrium nearest to a guess, with others found as its ``branches``.

    Ropes pull or are slack and stops are closed or open, as the equilibrium requires: no rope pushes or is
    stretched, no stop pulls or has a negative gap. A note says what each does, and with which effort. The
    states of signals are those whose rates vanish.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    guess : mapping of name to number or formula
        Coordinates near which to look; by default the model's initial values, then 0. Where equilibria form a
        continuum, the one that is reached by the shortest steps is taken, with a note.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    inputs : mapping of name to number or formula
        Constant, by default 0; formulas may read the state.
    unknowns : str or sequence of str
        Inputs that take the value that holds the mechanism; they are in ``inputs`` of the result.
    fixed : mapping of name to number or formula
        Coordinates that keep these values, usually together with `unknowns`.
    t : float
        Time at which motions and forces that depend on it are frozen [s].
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model, see `assemble`.

    Returns
    -------
    Equilibrium
        A `State` at rest: ``rest["x"]`` is one coordinate [m, rad], ``rest.q`` all by name, ``rest.inputs``
        the unknowns, ``rest.residual`` how far loops are open. ``stable`` and ``verdict`` say what small
        deviations do; ``branches`` has other equilibria.

    Raises
    ------
    AssemblyError
        If the loops do not close, a motion in time leaves no rest, or forces balance nowhere near the guess:
        with what is left of them at the best configuration, and along which speed.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=2), axis="x", coordinate="x",
    ...                     force=sb.Drive(applied="F", stiffness=8))
    >>> model = sb.Model("oscillator", [rail], inputs=["F"], initial={"x": 0.1})
    >>> eqs = sb.form_equations(model)
    >>> rest = sb.find_equilibrium(eqs, inputs={"F": 4})
    >>> print(f"{rest['x']:.6f}")
    0.500000
    """
    unknowns = (unknowns,) if isinstance(unknowns, str) else unknowns
    refuse_held(eqs, "an equilibrium", {*(inputs or {}), *unknowns})
    first = assemble(eqs, fixed, guess, parameters=parameters, inputs=dict(inputs or {}), t=t, scales=scales)
    leaders = eqs.formed.coupled.leaders
    held = frozenset(leaders[name][0] if name in leaders else name for name in fixed or ())
    _check(eqs, unknowns, held)
    mechanism = mechanism_scales(eqs, dict(parameters or {}), scales, first.q)
    evaluator = constraint_evaluator(
        eqs, dict(parameters or {}), dict(inputs or {}), t, mechanism,
        signals=np.array(list(first.s.values()), dtype=np.float64),
    )  # fmt: skip
    searches = ClosedGapSearch(evaluator, tuple(unknowns), np.array(list(first.q.values())), held)
    searches.nearest_set().check_at_rest()
    try:
        candidates = _distinct_equilibria(evaluator, searches)
    except AssemblyError:
        stuck = None if unknowns else _friction_equilibrium(searches)
        if stuck is None:
            raise
        return stuck
    states = [_state(candidate, unknowns) for candidate in candidates]
    return replace(states[0], _others=partial(tuple, states[1:]))


def _check(eqs: EquationSet, unknowns: Sequence[str], fixed: Iterable[str]) -> None:
    problems = [
        Problem("equilibrium.signal", name, f"{name!r} is a state of a signal, not a coordinate in q",
                "the search finds states of signals together with the positions, where their rates are 0",
                f"leave it out; guess={{{name!r}: ..}} sets where the search starts; a signal with a value "
                f"instead of a rate stays constant")
        for name in fixed
        if name in eqs.signal_state_names
    ]  # fmt: skip
    problems += [
        Problem("equilibrium.unknown_name", name, f"there is no {word} {name!r}", "", nearest(name, existing))
        for word, names, existing in (
            ("input", unknowns, eqs.input_names),
            ("coordinate in q", fixed, eqs.coordinate_names),
        )
        for name in names
        if name not in existing and name not in eqs.signal_state_names
    ]
    if problems:
        raise AssemblyError(*problems)


def _distinct_equilibria(evaluator: ConstraintEvaluator, searches: ClosedGapSearch) -> list[Candidate]:
    """Return different equilibria, the nearest first.

    Raises
    ------
    AssemblyError
        If there is none.
    """
    candidates, others = searches.candidates()
    regular = [one for one in candidates if one.search.is_regular(one.residual)]
    good = sorted(regular, key=lambda one: one.search.distance(one.residual))
    if candidates and not good:
        raise AssemblyError(_singular(evaluator, candidates[0].residual.q))
    if not good:
        raise AssemblyError(_unbalanced_problem(others))
    different = [good[0]]
    for one in good[1:]:
        isolated = one.search.flat_directions(one.residual).shape[1] == 0
        if isolated and all(evaluator.differs(one.residual.q, other.residual.q) for other in different):
            different.append(one)
    return different


def _unbalanced_problem(attempts: Sequence[Candidate]) -> Problem:
    """Return the refusal, with the unbalanced force at the best configuration."""
    finite = [one for one in attempts if np.isfinite(one.residual.merit)]
    eqs, cause = attempts[0].search.evaluator.eqs, ""
    if not finite:
        what = "the forces are not finite"
    else:
        best = min(finite, key=lambda one: one.residual.merit)
        forces, search = best.residual.unbalanced, best.search
        k = int(np.argmax(np.abs(forces))) if forces.size else 0
        speeds = (*eqs.speed_names, *(speed.label for speed in eqs.formed.light_balances))
        if k >= len(speeds):
            name = eqs.signal_state_names[k - len(speeds)]
            left = f"the rate of signal {name} does not vanish"
        else:
            name = speeds[k]
            unit = "N" if eqs.units.get(name) == "m/s" else "N m"
            force = forces[k] * search.balance.largest_term(search.start) / search.balance.sizes[k]
            left = f"along {name}, {force:.4g} {unit} are not balanced"
        place = ", ".join(
            f"{q} = {x:.4g}" for q, x in zip(eqs.coordinate_names, best.residual.q, strict=True)
        )
        what = f"{best.fault or left}, at the best point found ({place})"
        cause = _loose_body(eqs, name) if not best.fault else ""
    dry = "; friction at rest was assumed to be 0" if switching_joints(eqs.formed) else ""
    return Problem(
        "equilibrium.none", eqs.model.name, what, f"{cause}{STARTS} starting points around the guess were "
            f"tried{dry}",
        "restrain what moves by a joint, a spring or an unknown input, or give guess= closer to an "
        "equilibrium",
    )  # fmt: skip


def _loose_body(eqs: EquationSet, speed: str) -> str:
    """Return which body nothing holds, if a speed is its own."""
    for joint in eqs.model.free_joints:
        if speed in (*joint.quasi_speed_names, *(f"{name}_dot" for name in joint.coordinates)):
            return f"body {joint.end.body} has no joint and moves freely; "
    return ""


def _singular(evaluator: ConstraintEvaluator, q: Floats) -> Problem:
    place = ", ".join(f"{name} = {x:.4g}" for name, x in zip(evaluator.eqs.coordinate_names, q, strict=True))
    return Problem(
        "equilibrium.singular", evaluator.eqs.model.name, "forces balance only where accelerations are not "
            "defined",
        f"at {place} the angles are singular, or some motion has no mass",
        "use a quaternion or other angles, give mass to what moves, or give guess= closer to an equilibrium",
    )  # fmt: skip


def _state(candidate: Candidate, unknowns: Sequence[str]) -> Equilibrium:
    search, residual = candidate.search, candidate.residual
    evaluator, eqs = search.evaluator, search.evaluator.eqs
    order = [name for name in eqs.input_names if name in unknowns]
    held = dict(zip(order, residual.inputs.tolist(), strict=False))
    signals = residual.inputs[len(order) :]
    if held or signals.size:
        evaluator = constraint_evaluator(
            eqs, evaluator.parameters, {**evaluator.inputs, **held}, evaluator.t, evaluator.mechanism,
            signals=signals,
        )  # fmt: skip
    state = complete_state(evaluator, residual.q, np.zeros(len(eqs.speed_names)), search.start, {})
    further = examine_neighbourhood(search, residual)
    notes = [*evaluator.mechanism.notes(eqs), *further.notes, *candidate.notes]
    if search.balance.timed:
        notes.append(
            f"forces or motions depend on time: they are evaluated at t = {evaluator.t:g} s and held constant"
        )
    if eqs.formed.friction:
        notes.append(
            "friction is assumed to be 0 at rest; with sticking, more configurations are in equilibrium"
        )
    edges = (*candidate.edges, *(settle(eqs, state).edges if switching_joints(eqs.formed) else ()))
    return _equilibrium(state, notes, "undecided" if edges else further.doubt)


def _friction_equilibrium(searches: ClosedGapSearch) -> Equilibrium | None:
    """Return the guess as an equilibrium if dry joints hold it there; None if they do not."""
    search = searches.nearest_set()
    evaluator, eqs = search.evaluator, search.evaluator.eqs
    if not switching_joints(eqs.formed) or eqs.signal_state_names:
        return None
    still = np.zeros(len(eqs.speed_names))
    try:
        sides = settle(eqs, complete_state(evaluator, search.start, still, search.start, {}))
    except (AssemblyError, SimulationError):
        return None
    left = np.asarray(sides.state["mass_matrix"]) @ list(sides.state.udot.values()) * evaluator.speed_sizes
    if not float(np.abs(left).max(initial=0.0)) <= BALANCED * search.balance.largest_term(search.start):
        return None
    note = (
        "friction holds the mechanism at the guess; without friction it has no equilibrium. Configurations "
        "around the guess are held, too"
    )
    return _equilibrium(sides.state, [note, *sides.notes], "undecided" if sides.edges else "")


def _equilibrium(state: State, notes: Sequence[str], doubt: str) -> Equilibrium:
    entries = {entry.name: getattr(state, entry.name) for entry in fields(State)}
    return Equilibrium(**entries, notes=tuple(notes), _doubt=doubt)
