"""What to note about a motion: `CHECKS` at its start and at an early end, and singular angles on its way."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Final, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.analysis.named_values import angle_names
from symbody.analysis.state import State
from symbody.codegen.formation.parameter_set import parameter_set
from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.equations.equation_set import EquationSet
from symbody.errors import number_in_words
from symbody.manifold import count_significant, null_space
from symbody.model.joint import Joint
from symbody.model.joints import ConstantVelocity, Free, Spherical
from symbody.model.loads.forces import SpringDamper
from symbody.model.model import Model
from symbody.simulation.events.events import Occurrence
from symbody.simulation.methods.closed_loops.crossing import crossing_of_motion
from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints, motion_branch
from symbody.simulation.native.dense_output import DenseOutput
from symbody.simulation.native.run import RawRun
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status
from symbody.tolerances import TRACED

Floats = NDArray[np.float64]
Words = tuple[object, ...]

_TAKES_PART: Final = 0.1  # of a unit vector
# Constraints that are redundant close together but for this, of the size of the mechanism.
_ROUNDING: Final = 1e-13
# First values that moved farther than this are named: what is read off a drawing is not as exact.
_FAR: Final = math.radians(0.1)  # of angles
_FAR_OFF: Final = 1e-3  # of lengths, in sizes of the mechanism
_NEAR: Final = 1e-6  # of both, where balances of forces moved them
_TWO: Final = 2  # coordinates of a rotation that cannot spin about every axis
# Configurations of the motion that are looked at to learn how many constraints are independent.
_SAMPLES: Final = 7
# A lock-up is approached like a root: 1e-6 s before it a singular value is still a thousandth.
_LOST: Final = 1e-3
# Share of the prescribed velocities that counts.
_DEMANDED: Final = 1e-2
# Within so much of a singular position of angles their rates are a hundred times the angular velocity.
_CLOSE_BY: Final = 1e-2
_PER_STEP: Final = 5  # samples that are looked at for it
_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE)
_UNSOLVED: Final = (Status.SINGULAR, Status.NOT_FINITE)
_REDUNDANT: Final = (
    "the constraints of joints {} are nearly redundant: they allow the same motions, but cannot all be "
    "closed at once: a gap of {:.1e} of the mechanism's size remains; make lengths that should be equal "
    "identical to the last digit, or remove one of these joints"
)


class Check(NamedTuple):
    """One thing that is worth a note.

    Attributes
    ----------
    needs : callable
        Says of equations whether it can occur in motions of theirs.
    test : callable
        Yields the words of each note on a `MotionStart`, or a `MotionEnd`.
    sentence : str
        What these words are put into.
    statuses : tuple of Status
        Of ends: those in which it is looked for.
    """

    name: str
    needs: Callable[[EquationSet], bool]
    test: Callable[[Any], Iterator[Words]]
    sentence: str
    statuses: tuple[Status, ...] = ()


class MotionStart(NamedTuple):
    """A first state, and the initial values and guesses of the caller."""

    problem: SimulationProblem
    first: State
    given: Mapping[str, object]


@dataclass(frozen=True, eq=False)
class MotionEnd:
    """The run of a motion that ended early."""

    problem: SimulationProblem
    raw: RawRun

    @cached_property
    def position(self) -> _SingularPosition | None:
        """The singular position at which it ended, if it is one."""
        return _singular_position(self)

    @cached_property
    def samples(self) -> tuple[Floats, Floats]:
        """Times of the motion up to its last, and the states there."""
        dense = self.raw.dense_output
        if dense is None:
            return self.raw.t[[0, -1]], self.raw.x[:, [0, -1]]
        t = np.linspace(float(dense.breaks[0]), self.raw.reached, _SAMPLES)
        return t, dense(t)

    @cached_property
    def rows(self) -> tuple[Floats, Floats]:
        """The constraints on velocities along the motion, without units, and what they demand."""
        problem, (t, x) = self.problem, self.samples
        n_u, n = len(problem.eqs.speed_names), len(problem.eqs.state_names)
        function = problem.compile_outputs(("jacobian", "velocity_constraints"))
        rows, drift = problem.evaluate(function, t, x[n_u:n], np.zeros((n_u, t.size)))
        scales = problem.scales.constraints(problem.eqs)[:, np.newaxis]
        return rows / scales * problem.scales.displacements(problem.eqs), drift

    def last(self, outputs: str | tuple[str, ...]) -> Any:
        """Return outputs at the last state, along an axis of one sample."""
        (t, x), eqs = self.samples, self.problem.eqs
        n_u, n = len(eqs.speed_names), len(eqs.state_names)
        function = self.problem.compile_outputs(outputs)
        return self.problem.evaluate(function, t[-1:], x[n_u:n, -1:], x[:n_u, -1:])


def start_notes(
    problem: SimulationProblem, first: State, given: Mapping[str, object] | None = None
) -> tuple[str, ...]:
    """Return what should be known of a motion that starts from a state.

    Parameters
    ----------
    given : mapping of name to number or formula
        Initial values and guesses of the caller.
    """
    eqs, start = problem.eqs, MotionStart(problem, first, given or {})
    checks: tuple[Check, ...] = eqs.plans.get("checks", partial(_fitting_checks, eqs))
    return tuple([check.sentence.format(*words) for check in checks for words in check.test(start)])


def _fitting_checks(eqs: EquationSet) -> tuple[Check, ...]:
    return tuple(check for check in CHECKS if not check.statuses and check.needs(eqs))


def stop_note(problem: SimulationProblem, raw: RawRun) -> str:
    """Return where and on whose account a run ended early, empty if it did not."""
    eqs, end = problem.eqs, MotionEnd(problem, raw)
    for check in CHECKS:
        if raw.status in check.statuses and check.needs(eqs):
            for words in check.test(end):
                return f"{raw.reach}; {check.sentence.format(*words)}"
    note = raw.stop_note((*eqs.state_names, "work"))
    if raw.status is Status.STEP_COLLAPSE and eqs.multiplier_names:
        note += next((cure.format(*words) for test, cure in _CURES for words in test(end)), "")
    return note


# At the start


def _whole_turns(start: MotionStart) -> Iterator[Words]:
    """Yield angles beyond a turn as plain numbers: most are degrees."""
    eqs = start.problem.eqs
    angles = eqs.plans.get("first angles", lambda: _plain_angles(eqs, eqs.model.initial))
    if start.given:
        others = _plain_angles(eqs, start.given)
        angles = {name: x for name, x in angles.items() if name not in start.given} | others
    for name in {**eqs.model.initial, **start.given} if angles else ():
        if name in angles:
            yield name, angles[name], math.degrees(angles[name])


def _plain_angles(eqs: EquationSet, given: Mapping[str, object]) -> dict[str, float]:
    """Return the angles beyond a turn that stand there without a unit."""
    angles = angle_names(eqs)
    numbers = {name: _plain_number(value) for name, value in given.items() if name in angles}
    return {name: x for name, x in numbers.items() if x is not None and abs(x) > math.tau}


def _plain_number(value: object) -> float | None:
    """Return a number that stands there without a unit, or None."""
    if isinstance(value, float):
        return value
    try:
        return float(str(value).strip())
    except ValueError:
        return None


def _loose_bodies(start: MotionStart) -> Iterator[Words]:
    """Yield bodies that nothing holds, where others are held: most have lost their joint."""
    model = start.problem.eqs.model
    assert isinstance(model, Model)
    names = ", ".join(joint.end.body for joint in model.free_joints)
    if len(model.free_joints) > 1:
        yield "bodies", names, "have", "move", "each "
    else:
        yield "body", names, "has", "moves", ""


def _is_held_in_part(eqs: EquationSet) -> bool:
    return isinstance(eqs.model, Model) and bool(eqs.model.joints and eqs.model.free_joints)


def _may_be_fixed(eqs: EquationSet) -> bool:
    """Return whether constraints may leave nothing that can move, and time moves nothing either."""
    n_u, is_driven = len(eqs.speed_names), any(not row.drift.is_zero for row in eqs.formed.rows)
    return bool(n_u) and len(eqs.multiplier_names) >= n_u and not is_driven


def _no_freedom(start: MotionStart) -> Iterator[Words]:
    problem, eqs = start.problem, start.problem.eqs
    slopes = np.asarray(start.first["jacobian"])
    if len(slopes) < len(eqs.multiplier_names):  # ropes are slack, or stops open
        return
    rows = slopes / problem.scales.constraints(eqs)[:, np.newaxis] * problem.scales.displacements(eqs)
    if np.isfinite(rows).all() and not null_space(rows).shape[1]:
        constraints = number_in_words(len(eqs.multiplier_names), "constraint")
        yield constraints, number_in_words(len(eqs.speed_names), "speed")


def _idle_speeds(start: MotionStart) -> Iterator[Words]:
    """Yield speeds that no inertia resists at a first state: a rod that spins about itself."""
    problem, first, eqs = start.problem, start.first, start.problem.eqs
    if not _has_rods(problem):
        return
    t, q, u = first.t, np.array(list(first.q.values())), np.array(list(first.u.values()))
    mass, rows = problem.compile_outputs(("mass_matrix", "jacobian"), quick=True)(
        t, q, u, problem.laws.evaluate(t, q, u)
    )
    names = [eqs.speed_names[k] for k in massless_speeds(mass, rows)]
    if names:
        yield (", ".join(names),)


def _has_rods(problem: SimulationProblem) -> bool:
    """Return whether a body has no inertia about one of its axes, planar bodies left out."""
    model = problem.eqs.model
    if not isinstance(model, Model):
        return False
    moments = parameter_set(problem.eqs, problem.parameters).quantities.moments
    if 0.0 not in moments:
        return False
    spherical: set[str] = problem.eqs.plans.get("spherical bodies", lambda: {
        body for joint in model.joints if len(joint.rotation_coordinates) > _TWO
        for body in (joint.start.body, joint.end.body)
    })  # fmt: skip
    for k, body in enumerate(model.bodies):
        zeros = moments[3 * k : 3 * k + 3].count(0.0)
        if zeros == 1 or (zeros > 1 and body.name in spherical):
            return True
    return False


def _moves_by_balances(eqs: EquationSet) -> bool:
    return any(row.is_balance for row in eqs.formed.holonomic)


def _moved_initial_values(start: MotionStart) -> Iterator[Words]:
    """Yield initial values of the model that moved to close the loops, or to balance forces."""
    problem, first, eqs = start.problem, start.first, start.problem.eqs
    moved = {name: change for name, change in first.moved.items() if name in eqs.model.initial}
    if not moved:
        return
    sizes = dict(zip(eqs.coordinate_names, problem.scales.coordinates(eqs).tolist(), strict=True))
    is_balanced, angles, far = _moves_by_balances(eqs), angle_names(eqs), []
    for name, change in moved.items():
        limit = _NEAR if is_balanced else _FAR if name in angles else _FAR_OFF
        if name in sizes and abs(change) > limit * sizes[name]:
            unit, factor = (" deg", math.degrees(1.0)) if name in angles else ("", 1.0)
            now, before = (factor * value for value in (first.q[name], first.q[name] - change))
            far.append(f"{name} = {now:.6g}{unit} instead of {before:.6g}{unit}")
    if far:
        yield (", ".join(far),)


def _open_loops(start: MotionStart) -> Iterator[Words]:
    """Yield loops that stay open at a first state because their constraints are nearly redundant."""
    problem, first, eqs = start.problem, start.first, start.problem.eqs
    if first.residual <= TRACED * problem.scales.length:
        return
    t, q = first.t, np.array(list(first.q.values()))
    function = problem.compile_outputs(("constraints", "jacobian"), quick=True)
    u, inputs = np.zeros(len(eqs.speed_names)), np.zeros(len(problem.laws.callbacks))  # neither is read
    values, rows = function(t, q, u, inputs)
    rows = rows / problem.scales.constraints(eqs)[:, np.newaxis] * problem.scales.displacements(eqs)
    if np.isfinite(rows).all():
        yield from _nearly_redundant(problem, rows, values)


def _nearly_redundant(problem: SimulationProblem, rows: Floats, values: Floats) -> Iterator[Words]:
    """Yield constraints that follow from others in direction, but not in value, with the gap they leave.

    `rows` (n_c, n_u) is J without units, `values` (n_h,) are the constraints on positions.
    """
    eqs = problem.eqs
    count = len(eqs.formed.holonomic)
    redundant = null_space(rows[:count].T)
    open_by = redundant.T @ (values[:count] / problem.scales.constraints(eqs)[:count])
    largest = float(np.abs(open_by).max(initial=0.0))
    if largest > _ROUNDING:
        taking = np.abs(redundant @ open_by) / np.linalg.norm(open_by)
        own = zip(eqs.formed.rows, taking, strict=False)
        yield ", ".join(dict.fromkeys(row.element for row, part in own if part > _TAKES_PART)), largest


# At an early end


@dataclass(frozen=True, slots=True)
class _SingularPosition:
    """A position at which constraints become dependent.

    Attributes
    ----------
    joints, speeds : tuple of str
        Whose constraints these are, and what they leave open there.
    freedoms, lost : int
        Degrees of freedom elsewhere, and constraints that are lost here.
    is_locked : bool
        Whether the prescribed motions need what the constraints do not allow.
    opening : float
        By what share of the mechanism's size lengths would have to be others for branches to meet near it.
    """

    joints: tuple[str, ...]
    speeds: tuple[str, ...]
    freedoms: int
    lost: int
    is_locked: bool
    opening: float

    @property
    def owners(self) -> str:
        """The joints in words."""
        return f"joint{'s' if len(self.joints) > 1 else ''} {', '.join(self.joints)}"


def _freedoms(count: int) -> str:
    return f"{count} degree{'' if count == 1 else 's'} of freedom {'is' if count == 1 else 'are'}"


def _singular_position(end: MotionEnd) -> _SingularPosition | None:
    """Return the singular position at which a motion ended, if it is one."""
    problem, eqs, (rows, drift) = end.problem, end.problem.eqs, end.rows
    n_u, scales = len(eqs.speed_names), problem.scales.constraints(eqs)
    if n_u == 0 or not np.isfinite(rows).all():
        return None
    sizes = np.linalg.svd(rows, compute_uv=False)
    rank = count_significant(sizes)
    left, last, right = np.linalg.svd(rows[-1])
    lost = [k for k in range(rank) if last[k] < _LOST * sizes[:, k].max()]
    if not lost:
        return None
    by_row = np.linalg.norm(left[:, lost], axis=1)
    by_speed = np.linalg.norm(right[lost], axis=0)
    demand = drift[-1] / scales
    is_locked = bool(np.linalg.norm(left[:, lost].T @ demand) > _DEMANDED * np.linalg.norm(demand))
    elements = [
        row.element for row, share in zip(eqs.formed.rows, by_row, strict=True) if share > _TAKES_PART
    ]
    return _SingularPosition(
        tuple(dict.fromkeys(elements)),
        tuple(name for name, share in zip(eqs.speed_names, by_speed, strict=True) if share > _TAKES_PART),
        n_u - rank,
        len(lost),
        is_locked,
        0.0 if is_locked else _branch_opening(end),
    )


def _branch_opening(end: MotionEnd) -> float:
    """Return how far from meeting branches are at the end of a motion; 0 where they meet or are none."""
    (t, x), loops = end.samples, LoopConstraints(end.problem)
    branch = motion_branch(loops, float(t[0]), x[:, 0])
    crossing = crossing_of_motion(loops, branch, float(t[-1]), x[:, -1])
    return 0.0 if crossing is None or crossing.meets else abs(crossing.opening)


def _lock_up(end: MotionEnd) -> Iterator[Words]:
    position = end.position
    if position is not None and position.is_locked:
        yield ", ".join(position.speeds), position.owners, _freedoms(position.freedoms)


def _near_passage(end: MotionEnd) -> Iterator[Words]:
    position = end.position
    if position is not None and not position.is_locked and position.opening:
        yield position.owners, position.opening


def _change_point(end: MotionEnd) -> Iterator[Words]:
    position = end.position
    if position is not None and not (position.is_locked or position.opening):
        there = _freedoms(position.freedoms + position.lost)
        yield position.owners, ", ".join(position.speeds), there, position.freedoms


def _open_constraints(end: MotionEnd) -> Iterator[Words]:
    rows, _ = end.rows
    if (
        end.position is None
        and rows.size
        and end.problem.eqs.formed.holonomic
        and np.isfinite(rows[-1]).all()
    ):
        yield from _nearly_redundant(end.problem, rows[-1], end.last("constraints")[0])


def _massless(end: MotionEnd) -> Iterator[Words]:
    """Yield the motion that no mass resists at the last state, if that is why a run ended."""
    eqs, (mass, rows) = end.problem.eqs, end.last(("mass_matrix", "jacobian"))
    places = massless_speeds(mass[0], rows[0])
    if places:
        fault = massless_problem("", [eqs.speed_names[k] for k in places], eqs.coordinate_names)
        yield fault.what, fault.fix


def _springs_of_no_length(end: MotionEnd) -> Iterator[Words]:
    """Yield springs that have the length zero, and so no direction, at the last state."""
    springs = [spring.name for spring in end.problem.eqs.model.elements if isinstance(spring, SpringDamper)]
    short = [name for name in springs if float(end.last(f"length {name}")[0]) == 0.0]
    if short:
        yield (", ".join(short),)


def _kinks(end: MotionEnd) -> Iterator[Words]:
    """Yield the coordinate without mass whose rate jumps."""
    eqs = end.problem.eqs
    balanced = [name for name in eqs.coordinate_names if f"balance_{name}" in eqs.multiplier_names]
    name = (*eqs.state_names, "work")[end.raw.state or 0].removesuffix("_dot")
    if name in balanced:
        yield (name,)


def _redundant_constraints(end: MotionEnd) -> Iterator[Words]:
    rows, _ = end.rows
    if not np.isfinite(rows).all():
        return
    if count_significant(np.linalg.svd(rows[-1:], compute_uv=False)) < rows.shape[1]:
        yield ()


def _always(_: EquationSet) -> bool:
    return True


def _has_constraints(eqs: EquationSet) -> bool:
    return bool(eqs.multiplier_names)


CHECKS: Final = (
    Check("whole turns", lambda eqs: bool(angle_names(eqs)), _whole_turns,
        "{0} = {1:g} rad is {2:.0f} deg; for {1:g} degrees write '{1:g} deg'"),
    Check("loose bodies", _is_held_in_part, _loose_bodies,
        "{} {} {} no joint and {} freely, {}with six degrees of freedom"),
    Check("no freedom", _may_be_fixed, _no_freedom,
        "the mechanism has no degree of freedom here and cannot move: {} for {}; remove a joint that closes "
        "a loop, or give such a joint another degree of freedom"),
    Check("idle speeds", lambda eqs: bool(eqs.speed_names), _idle_speeds,
        "the motion of {} has no mass or inertia: it follows from the choice of speeds, not from mechanics; "
        "give the body an inertia about each axis, or ignore this motion"),
    Check("moved by balances", _moves_by_balances, _moved_initial_values,
        "forces on massless parts do not balance at the model's initial values: the motion starts nearby "
        "with {}; values passed to simulate are held"),
    Check("moved by loops", lambda eqs: not _moves_by_balances(eqs), _moved_initial_values,
        "the loops do not close at the model's initial values: the motion starts with {}; values passed in "
        "initial= are held"),
    Check("open loops", lambda eqs: bool(eqs.formed.holonomic and eqs.speed_names), _open_loops, _REDUNDANT),
    Check("lock-up", _has_constraints, _lock_up,
        "there the mechanism locks: the prescribed motions can continue only with infinite {} if {} stays "
        "closed, and {} left besides; end the motion earlier, or change the lengths or the prescribed "
        "motion", _COLLAPSES),
    Check("near passage", _has_constraints, _near_passage,
        "there the constraints of {} are nearly dependent: branches of the mechanism pass each other without "
        "meeting (lengths that differ by {:.2g} of the mechanism's size would make them meet), and speeds "
        "change sharply; sb.Projection() passes it", _COLLAPSES),
    Check("change point", _has_constraints, _change_point,
        "there the constraints of {} become dependent, a singular position (change point or dead centre) "
        "where {} are undetermined: {} there instead of {}; sb.Projection() or sb.Partition() may pass it; "
        "or change the lengths or the start", _COLLAPSES),
    Check("open constraints", _has_constraints, _open_constraints, f"there {_REDUNDANT}", _COLLAPSES),
    Check("massless", _always, _massless, "there {}; {}", _UNSOLVED),
    Check("springs of no length", _always, _springs_of_no_length,
        "there spring {} has length 0, so its force has no direction; start near this position, or use the "
        "stiffness alone with free length 0, and damp the joint instead", _UNSOLVED),
)  # fmt: skip

# What to do where a state changes too fast, if the mechanism shows it.
_CURES: Final = (
    (_kinks, ": {} has no mass, so its rate jumps where the balance of forces along it has a kink; put a "
        "damper along it, give mass to what moves there, or smooth the kink"),
    (_redundant_constraints, "; some constraints are redundant, see sb.redundancy(): sb.Partition() may pass "
        "this position"),
)  # fmt: skip


# On the way: with the second of three angles at such a place, the first and the third turn about one axis.
# Their rates are unbounded although the body moves smoothly, and the integrator takes many small steps.


@dataclass(frozen=True, slots=True)
class _Angles:
    """Three angles of a joint; `shift` takes the second to where its sine vanishes."""

    joint: str
    second: int
    shift: float
    cure: str

    def measure(self, q: Floats) -> Floats:
        """Return the size of the determinant that relates rates and angular velocity."""
        size: Floats = np.abs(np.sin(q[self.second] + self.shift))
        return size


def singular_passages(eqs: EquationSet, dense: DenseOutput) -> Iterator[tuple[Occurrence, str]]:
    """Return each passage of a motion by a singular position of angles, and what to note about it.

    Parameters
    ----------
    dense : DenseOutput
        Of the states, speeds before coordinates.
    """
    n_u = len(eqs.speed_names)
    triples: list[_Angles] = eqs.plans.get("singular angles", lambda: list(_triples(eqs)))
    if not triples:
        return
    breaks = dense.breaks
    shares = np.arange(_PER_STEP) / _PER_STEP
    t = np.append((breaks[:-1, np.newaxis] + np.diff(breaks)[:, np.newaxis] * shares).ravel(), breaks[-1])
    q = dense(t)[n_u:]
    for angles in triples:
        sizes = angles.measure(q)
        rising = np.append(np.diff(sizes) > 0.0, True)
        falling = np.insert(np.diff(sizes) <= 0.0, 0, True)
        for k in np.flatnonzero(rising & falling & (sizes < 10.0 * _CLOSE_BY)).tolist():
            bounds = sorted([float(t[max(k - 1, 0)]), float(t[min(k + 1, t.size - 1)])])
            least = scipy.optimize.minimize_scalar(
                lambda at, own=angles: float(own.measure(dense(at)[n_u:])), bounds=bounds, method="bounded",
                options={"xatol": 1e-9 * (bounds[1] - bounds[0])},
            )  # fmt: skip
            moment, size = float(least.x), float(least.fun)
            if size < _CLOSE_BY:
                state = dict(zip(eqs.state_names, dense(moment).tolist(), strict=True))
                event = Occurrence(f"{angles.joint} singular angles", moment, state)
                name = eqs.coordinate_names[angles.second]
                note = (
                    f"joint {angles.joint}: at t = {moment:.6g} s {name} passes within {size:.1e} rad of "
                    f"a singularity of its angles; steps are small there and accuracy suffers; {angles.cure}"
                )
                yield event, note


def _triples(eqs: EquationSet) -> Iterator[_Angles]:
    """Return the joints in the rotation tree that have three angles."""
    places = {name: k for k, name in enumerate(eqs.coordinate_names)}
    for role in eqs.formed.joint_roles:
        turns = role.joint.turns()
        names = [turn.angle.text for turn in turns]
        if role.has_angles and len(set(names)) == 3 and names[1] in places:
            is_proper = turns[0].axis == turns[2].axis
            yield _Angles(
                role.joint.name, places[names[1]], 0.0 if is_proper else np.pi / 2, _cure(role.joint)
            )


def _cure(joint: Joint) -> str:
    if isinstance(joint, Spherical | Free):
        return 'angles = "quaternion" has no such singularity'
    if isinstance(joint, ConstantVelocity):
        return "cut it with tree = false if its shafts become collinear"
    return "another sequence of angles has its singularities elsewhere"
