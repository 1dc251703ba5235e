"""`complete_state`: the accelerations and multipliers of a configuration and its speeds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.configurations.plain_assembly import PlainState
from symbody.analysis.constraint_evaluator import ConstraintEvaluator
from symbody.analysis.scales import Scales
from symbody.analysis.signal_values import signals_by_name
from symbody.analysis.state import State
from symbody.codegen.formation.names import Value
from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.equations.equation_set import EquationSet
from symbody.errors import AssemblyError, Problem, SimulationError
from symbody.manifold import rank
from symbody.tolerances import TINY

Floats = NDArray[np.float64]

# Rounding of solve_saddle on badly scaled mechanisms is far below; a broken row is of order one.
_CONSISTENT: Final = 1e-3
_SINGULAR: Final = Problem(
    "assembly.singular", "configuration", "the accelerations do not exist here",
    "the position is singular, as in a flat parallelogram, and no motion through it has these "
    "velocities", "start near this position, or give other velocities",
)  # fmt: skip
# Rates closer to their guess are that up to the rounding of a least squares solution.
_CHANGED: Final = 1e-9
_STAYED: Final = 1e-12  # of the size of a coordinate


def complete_state(
    evaluator: ConstraintEvaluator,
    q: Floats,
    u: Floats,
    start: Floats,
    guess: Mapping[str, float],
    others: Callable[[], Iterable[State]] = tuple,
) -> State:
    """Return the state with its accelerations and multipliers; `guess` has the rates guessed."""
    eqs = evaluator.eqs
    solved = _accelerations(evaluator, q, u)
    sizes = evaluator.speed_sizes
    if not (
        _have_accelerations(u, solved, sizes, 0.0)
        or _have_accelerations(u, solved, sizes, _free_acceleration(evaluator, q, u))
    ):
        raise AssemblyError(_SINGULAR)
    phi = evaluator.constraints(evaluator.t, q, u).constraints
    places = zip(eqs.coordinate_names, q - start, evaluator.sizes, strict=True)
    moved = {name: float(d) for name, d, size in places if abs(d) > _STAYED * size}
    moved |= _changed_rates(evaluator, q, u, guess)
    return State(
        eqs,
        dict(zip(eqs.coordinate_names, q.tolist(), strict=True)),
        dict(zip(eqs.speed_names, u.tolist(), strict=True)),
        dict(zip(eqs.acceleration_names, solved.udot.tolist(), strict=True)),
        dict(zip(eqs.multiplier_names, np.ravel(solved[1]).tolist(), strict=True)),
        float(np.abs(phi).max(initial=0.0)),
        moved,
        evaluator.t,
        evaluator.parameters,
        evaluator.inputs,
        others,
        s=signals_by_name(eqs, evaluator.signals),
        _functions=evaluator.functions,
        _dependent=_count_dependent(solved.jacobian),
    )


def state_of_plain(
    eqs: EquationSet,
    plain: PlainState,
    near: tuple[Mapping[str, float], Mapping[str, float]],
    given: tuple[Mapping[str, Value], Mapping[str, Value]],
    t: float,
    mechanism: Scales,
    others: Callable[[], Iterable[State]],
) -> State:
    """Return a plain state with its names.

    Parameters
    ----------
    near : pair of mappings
        Values that were kept, and those that were guessed.
    given : pair of mappings
        Of parameters and of inputs.
    """
    fixed, guess = near
    rates = dict(zip(eqs.speed_names, plain.u.tolist(), strict=True))
    apart = np.abs(plain.q - plain.start) > _STAYED * mechanism.coordinates(eqs)
    moved = {
        eqs.coordinate_names[k]: float(plain.q[k] - plain.start[k]) for k in np.flatnonzero(apart).tolist()
    }
    guessed = {name: value for name, value in guess.items() if name in rates and name not in fixed}
    return State(
        eqs,
        dict(zip(eqs.coordinate_names, plain.q.tolist(), strict=True)),
        rates,
        dict(zip(eqs.acceleration_names, plain.udot.tolist(), strict=True)),
        dict(zip(eqs.multiplier_names, plain.multipliers.tolist(), strict=True)),
        plain.residual,
        moved | _changes(rates, guessed),
        t,
        *given,
        others,
        _plain=plain,
    )


def _changes(rates: Mapping[str, float], guess: Mapping[str, float]) -> dict[str, float]:
    """Return by how much rates differ from what was guessed for them."""
    scale = max(map(abs, [*rates.values(), *guess.values()]), default=0.0)
    changes = {name: rates[name] - value for name, value in guess.items() if name in rates}
    return {name: change for name, change in changes.items() if abs(change) > _CHANGED * scale}


def _accelerations(evaluator: ConstraintEvaluator, q: Floats, u: Floats) -> Any:
    """Return accelerations, multipliers, J and gamma.

    Raises
    ------
    SimulationError
        If no mass resists some motion, naming its coordinates.
    """
    try:
        solved = evaluator.compile(("udot", "lambda", "jacobian", "gamma"))
        return solved(evaluator.t, q, u, s=evaluator.signals)
    except SimulationError as error:
        eqs = evaluator.eqs
        places = massless_speeds(*evaluator.compile(("mass_matrix", "jacobian"))(evaluator.t, q, u))
        if not places:
            raise
        names = [eqs.speed_names[k] for k in places]
        raise SimulationError(
            massless_problem("numerics.singular_mass", names, eqs.coordinate_names)
        ) from error


def _free_acceleration(evaluator: ConstraintEvaluator, q: Floats, u: Floats) -> float:
    """Return the largest acceleration that the forces would give without constraints, over its size."""
    solved = evaluator.compile(("mass_matrix", "forcing"))(evaluator.t, q, u, s=evaluator.signals)
    sizes = evaluator.speed_sizes
    mass = solved.mass_matrix * np.outer(sizes, sizes)
    free = np.linalg.lstsq(mass, solved.forcing * sizes, rcond=None)[0]
    return float(np.abs(free).max(initial=0.0))


def _changed_rates(
    evaluator: ConstraintEvaluator, q: Floats, u: Floats, guess: Mapping[str, float]
) -> dict[str, float]:
    """Return by how much speeds, and rates of coordinates, differ from what was guessed for them."""
    eqs = evaluator.eqs
    rates = dict(zip(eqs.speed_names, u.tolist(), strict=True))
    names = [f"{name}_dot" for name in eqs.coordinate_names]
    if any(name in guess and name not in rates for name in names):
        qdot = evaluator.compile("qdot")(evaluator.t, q, u).tolist()
        rates = dict(zip(names, qdot, strict=True)) | rates
    for name in evaluator.split_values(guess)[1]:  # of cut joints
        if name not in rates:
            rates[name] = float(evaluator.compile(name)(evaluator.t, q, u))
    return _changes(rates, guess)


def _have_accelerations(u: Floats, solved: Any, sizes: Floats, held: float) -> bool:
    """Return whether accelerations fulfil ``J u' = gamma``, which has no solution at some singular positions.

    Parameters
    ----------
    sizes : (n_u,) array
        Size of displacements along each speed.
    held : float
        Accelerations, over their sizes, that constraints keep from happening: what is left of them is
        rounding.
    """
    udot, jacobian, gamma = solved.udot / sizes, solved.jacobian * sizes, solved.gamma
    slopes = np.abs(jacobian).max(axis=1, initial=0.0)
    # gamma is quadratic in u; where all its terms cancel, that is what they are small against.
    fastest = float(np.abs(u / sizes).max(initial=0.0))
    largest = slopes * (fastest * fastest)  # infinite rather than a fault
    terms = np.abs(jacobian) @ np.abs(udot) + np.abs(gamma) + largest
    # A row whose accelerations vanish holds nothing but the rounding of the others, and of the velocities
    # that cancel in its gamma: at a change point nothing else may be left of the row itself.
    eps = udot.size * np.finfo(float).eps
    rounding = slopes * eps * max(held, float(np.abs(udot).max(initial=0.0)))
    rounding = rounding + eps * float(largest.max(initial=0.0))
    apart: Floats = np.abs(jacobian @ udot - gamma)
    return not (apart > _CONSISTENT * terms + rounding + TINY).any()


def _count_dependent(rows: Floats) -> int:
    """Return the number of rows that follow from the others, without those of zeros."""
    return int(np.abs(rows).max(axis=1, initial=0.0).astype(bool).sum()) - rank(rows)
