"""What to note about the first state of a motion: speeds without inertia, loops that close only nearly."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.named_values import angle_names
from symbody.analysis.state import State
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.massless import massless_speeds
from symbody.equations.equation_set import EquationSet
from symbody.errors import number_in_words
from symbody.manifold import null_space
from symbody.model.model import Model
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.tolerances import TRACED

Floats = NDArray[np.float64]

TAKES_PART: Final = 0.1  # of a unit vector
# Constraints that are redundant close together but for this, of the size of the mechanism.
_ROUNDING: Final = 1e-13
# First values that moved farther than this are named: what is read off a drawing is not as exact.
_FAR: Final = math.radians(0.1)  # of angles
_FAR_OFF: Final = 1e-3  # of lengths, in sizes of the mechanism
_NEAR: Final = 1e-6  # of both, where balances of forces moved them
_TWO: Final = 2  # coordinates of a rotation that cannot spin about every axis


def start_notes(
    problem: SimulationProblem, first: State, given: Mapping[str, object] | None = None
) -> tuple[str, ...]:
    """Return what should be known of a motion that starts from a state.

    Parameters
    ----------
    given : mapping of name to number or formula
        Initial values and guesses of the caller.
    """
    return (
        *_whole_turns(problem, given or {}),
        *_loose_bodies(problem),
        *_no_freedom(problem, first),
        *_idle_speeds(problem, first),
        *_moved_initial_values(problem, first),
        *_open_loops(problem, first),
    )


def _whole_turns(problem: SimulationProblem, given: Mapping[str, object]) -> tuple[str, ...]:
    """Return which angles are beyond a turn as plain numbers: most are degrees."""
    eqs = problem.eqs
    of_model: dict[str, str] = eqs.plans.get("whole turns", lambda: _turns_of(eqs, eqs.model.initial))
    notes = {name: note for name, note in of_model.items() if name not in given} | _turns_of(eqs, given)
    return tuple(notes[name] for name in {**eqs.model.initial, **given} if name in notes) if notes else ()


def _turns_of(eqs: EquationSet, given: Mapping[str, object]) -> dict[str, str]:
    """Return what to say of angles beyond a turn, by their names."""
    notes, angles = {}, angle_names(eqs)
    for name, value in given.items():
        number = _plain_number(value) if name in angles else None
        if number is not None and abs(number) > math.tau:
            degrees = math.degrees(number)
            notes[name] = (
                f"{name} = {number:g} rad is {degrees:.0f} deg; for {number:g} degrees write '{number:g} deg'"
            )
    return notes


def _plain_number(value: object) -> float | None:
    """Return a number that stands there without a unit, or None."""
    if isinstance(value, float):
        return value
    try:
        return float(str(value).strip())
    except ValueError:
        return None


def _loose_bodies(problem: SimulationProblem) -> tuple[str, ...]:
    """Return which bodies nothing holds, where others are held: most have lost their joint."""
    model = problem.eqs.model
    if not isinstance(model, Model) or not model.joints:
        return ()
    names = [joint.end.body for joint in model.free_joints]
    if not names:
        return ()
    several = len(names) > 1
    return (
        f"{'bodies' if several else 'body'} {', '.join(names)} {'have' if several else 'has'} no joint and "
        f"{'move' if several else 'moves'} freely, {'each ' if several else ''}with six degrees of freedom",
    )


def _no_freedom(problem: SimulationProblem, first: State) -> tuple[str, ...]:
    """Return a note if the constraints leave nothing that can move and time moves nothing either."""
    eqs = problem.eqs
    n_u = len(eqs.speed_names)
    is_driven = any(not row.drift.is_zero for row in eqs.formed.rows)
    if not n_u or len(eqs.multiplier_names) < n_u or is_driven:
        return ()
    slopes = np.asarray(first["jacobian"])
    if len(slopes) < len(eqs.multiplier_names):  # ropes are slack
        return ()
    rows = slopes / problem.scales.constraints(eqs)[:, np.newaxis]
    rows = rows * problem.scales.displacements(eqs)
    if not np.isfinite(rows).all() or null_space(rows).shape[1]:
        return ()
    return (
        "the mechanism has no degree of freedom here and cannot move: "
        f"{number_in_words(len(eqs.multiplier_names), 'constraint')} for {number_in_words(n_u, 'speed')}; "
        "remove a joint that closes a loop, or give such a joint another degree of freedom",
    )


def nearly_redundant(problem: SimulationProblem, rows: Floats, values: Floats) -> str:
    """Return which constraints follow from others in direction, but not in value; empty if there are none.

    Parameters
    ----------
    rows : (n_c, n_u) array
        J without units.
    values : (n_h,) array
        Constraints on positions.
    """
    eqs = problem.eqs
    count = len(eqs.formed.holonomic)
    redundant = null_space(rows[:count].T)
    open_by = redundant.T @ (values[:count] / problem.scales.constraints(eqs)[:count])
    largest = float(np.abs(open_by).max(initial=0.0))
    if not largest > _ROUNDING:
        return ""
    taking = np.abs(redundant @ open_by) / np.linalg.norm(open_by)
    own = zip(eqs.formed.rows, taking, strict=False)
    joints = ", ".join(dict.fromkeys(row.element for row, part in own if part > TAKES_PART))
    return (
        f"the constraints of joints {joints} are nearly redundant: they allow the same motions, but cannot "
        f"all be closed at once: a gap of {largest:.1e} of the mechanism's size remains; make lengths that "
        f"should be equal identical to the last digit, or remove one of these joints"
    )


def _open_loops(problem: SimulationProblem, first: State) -> tuple[str, ...]:
    """Return which loops stay open at a first state because their constraints are nearly redundant."""
    eqs = problem.eqs
    if not (eqs.formed.holonomic and eqs.speed_names and first.residual > TRACED * problem.scales.length):
        return ()
    t, q = first.t, np.array(list(first.q.values()))
    function = problem.compile_outputs(("constraints", "jacobian"), quick=True)
    values, rows = function(t, q, np.zeros(len(eqs.speed_names)))
    rows = rows / problem.scales.constraints(eqs)[:, np.newaxis] * problem.scales.displacements(eqs)
    note = nearly_redundant(problem, rows, values) if np.isfinite(rows).all() else ""
    return (note,) if note else ()


def _moved_initial_values(problem: SimulationProblem, first: State) -> tuple[str, ...]:
    """Return which initial values of the model moved to close the loops."""
    eqs = problem.eqs
    sizes = dict(zip(eqs.coordinate_names, problem.scales.coordinates(eqs).tolist(), strict=True))
    initial = eqs.model.initial
    is_balanced = any(row.is_balance for row in eqs.formed.holonomic)
    angles = angle_names(eqs)
    far = []
    for name, change in first.moved.items():
        limit = _NEAR if is_balanced else _FAR if name in angles else _FAR_OFF
        if name in initial and name in sizes and abs(change) > limit * sizes[name]:
            unit, factor = (" deg", math.degrees(1.0)) if name in angles else ("", 1.0)
            now, before = (factor * value for value in (first.q[name], first.q[name] - change))
            far.append(f"{name} = {now:.6g}{unit} instead of {before:.6g}{unit}")
    if not far:
        return ()
    if is_balanced:
        return (
            f"forces on massless parts do not balance at the model's initial values: the motion starts "
            f"nearby with {', '.join(far)}; values passed to simulate are held",
        )
    return (
        f"the loops do not close at the model's initial values: the motion starts with {', '.join(far)}; "
        f"values passed in initial= are held",
    )


def _idle_speeds(problem: SimulationProblem, first: State) -> tuple[str, ...]:
    """Return which speeds no inertia resists at a first state: a rod that spins about itself."""
    eqs = problem.eqs
    if not eqs.speed_names or not _has_rods(problem):
        return ()
    t, q, u = first.t, np.array(list(first.q.values())), np.array(list(first.u.values()))
    mass, rows = problem.compile_outputs(("mass_matrix", "jacobian"), quick=True)(
        t, q, u, problem.laws.evaluate(t, q, u)
    )
    names = [eqs.speed_names[k] for k in massless_speeds(mass, rows)]
    if not names:
        return ()
    return (
        f"the motion of {', '.join(names)} has no mass or inertia: it follows from the choice of speeds, "
        f"not from mechanics; give the body an inertia about each axis, or ignore this motion",
    )


def _has_rods(problem: SimulationProblem) -> bool:
    """Return whether a body has no inertia about one of its axes, planar bodies left out."""
    model = problem.eqs.model
    if not isinstance(model, Model):
        return False
    moments = parameter_set(problem.eqs, problem.parameters).quantities.moments
    if 0.0 not in moments:
        return False
    spherical: frozenset[str] = problem.eqs.plans.get("spherical bodies", lambda: _spherical_bodies(model))
    for k, body in enumerate(model.bodies):
        zeros = moments[3 * k : 3 * k + 3].count(0.0)
        if zeros == 1 or (zeros > 1 and body.name in spherical):
            return True
    return False


def _spherical_bodies(model: Model) -> frozenset[str]:
    """Return the bodies at joints that turn in all ways."""
    joints = [joint for joint in model.joints if len(joint.rotation_coordinates) > _TWO]
    return frozenset(body for joint in joints for body in (joint.start.body, joint.end.body))
