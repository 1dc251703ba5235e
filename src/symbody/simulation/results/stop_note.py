"""What to note about a motion that ended early: when, and what in the mechanism is to blame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.state import State
from symbody.codegen.compile import constant_values
from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.model.loads.forces import SpringDamper
from symbody.model.model import Model
from symbody.simulation.native.run import RawRun
from symbody.simulation.status import Status
from symbody.simulation.task import Task

Floats = NDArray[np.float64]

_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE)
# Configurations of the motion that are looked at to learn how many constraints are independent.
_SAMPLES: Final = 7
_INDEPENDENT: Final = 1e-6
# Constraints that are redundant close together but for this, of the size of the mechanism.
_ROUNDING: Final = 1e-13
# A lock-up is approached like a root: 1e-6 s before it a singular value is still a thousandth.
_LOST: Final = 1e-3
# Shares of a unit vector, and of the prescribed velocities, that count.
_TAKES_PART: Final = 0.1
_DEMANDED: Final = 1e-2
_TWO: Final = 2  # coordinates of a rotation that cannot spin about every axis


def stop_note(task: Task, raw: RawRun) -> str:
    """Return where and on whose account a run ended early, empty if it did not."""
    known = f"the motion is known up to t = {raw.reached:.9g} s"
    if raw.status in _COLLAPSES and task.eqs.multiplier_names:
        position = _singular_position(task, raw)
        told = _nearly_redundant(task, raw) if position is None else position.told
        if told:
            return f"{known}; {told}"
    if raw.status in (Status.SINGULAR, Status.NOT_FINITE):
        told = _massless(task, raw) or _without_direction(task, raw)
        if told:
            return f"{known}; {told}"
    return raw.stop_note((*task.eqs.state_names, "work"))


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
    """

    joints: tuple[str, ...]
    speeds: tuple[str, ...]
    freedoms: int
    lost: int
    is_locked: bool

    @property
    def told(self) -> str:
        """The position in words."""
        joints = f"joint{'s' if len(self.joints) > 1 else ''} {', '.join(self.joints)}"
        speeds = ", ".join(self.speeds)
        if self.is_locked:
            return (
                f"there the mechanism locks: the prescribed motions go on only with infinite {speeds} if "
                f"{joints} stays closed, and {_freedoms(self.freedoms)} left beside them; end the motion "
                "before, or change the lengths or the prescribed motion"
            )
        return (
            f"there the constraints of {joints} become dependent, a singular position (change point or dead "
            f"centre) that leaves {speeds} open: {_freedoms(self.freedoms + self.lost)} there instead of "
            f"{self.freedoms}; sb.Projection() or sb.Partition() may pass it; or change lengths or start"
        )


def _freedoms(count: int) -> str:
    return f"{count} degree{'' if count == 1 else 's'} of freedom {'is' if count == 1 else 'are'}"


def _singular_position(task: Task, raw: RawRun) -> _SingularPosition | None:
    """Return the singular position at which a motion ended, if it is one."""
    eqs = task.eqs
    n_u, scales = len(eqs.speed_names), task.scales.constraints(eqs)
    rows, drift = _constraint_rows(task, raw)
    if n_u == 0 or not np.isfinite(rows).all():
        return None
    sizes = np.linalg.svd(rows, compute_uv=False)
    rank = int((sizes > _INDEPENDENT * sizes.max()).sum(axis=1).max())
    left, last, right = np.linalg.svd(rows[-1])
    lost = [k for k in range(rank) if last[k] < _LOST * sizes[:, k].max()]
    if not lost:
        return None
    by_row = np.linalg.norm(left[:, lost], axis=1)
    by_speed = np.linalg.norm(right[lost], axis=0)
    demand = drift[-1] / scales
    elements = [
        row.element for row, share in zip(eqs.formed.rows, by_row, strict=True) if share > _TAKES_PART
    ]
    return _SingularPosition(
        tuple(dict.fromkeys(elements)),
        tuple(name for name, share in zip(eqs.speed_names, by_speed, strict=True) if share > _TAKES_PART),
        n_u - rank,
        len(lost),
        bool(np.linalg.norm(left[:, lost].T @ demand) > _DEMANDED * np.linalg.norm(demand)),
    )


def _constraint_rows(task: Task, raw: RawRun) -> tuple[Floats, Floats]:
    """Return the constraints on velocities along the motion, without units, and what they demand."""
    eqs = task.eqs
    t, x = _samples(task, raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    function = task.compiled(("jacobian", "velocity_constraints"))
    rows, drift = task.evaluated(function, t, x[n_u:n], np.zeros((n_u, t.size)))
    scales, speeds = task.scales.constraints(eqs), task.scales.displacements(eqs)
    return rows / scales[:, np.newaxis] * speeds, drift


def _nearly_redundant(task: Task, raw: RawRun) -> str:
    """Return which constraints follow from others in direction, but not in value, where a motion ended."""
    eqs = task.eqs
    rows, _ = _constraint_rows(task, raw)
    count = len(eqs.formed.holonomic)
    if not (rows.size and count and np.isfinite(rows[-1]).all()):
        return ""
    t, x = _samples(task, raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    values = task.evaluated(task.compiled("constraints"), t[-1:], x[n_u:n, -1:], x[:n_u, -1:])[0]
    left, sizes, _ = np.linalg.svd(rows[-1][:count])
    rank = int((sizes > _INDEPENDENT * sizes[0]).sum())
    open_by = left[:, rank:].T @ (values[:count] / task.scales.constraints(eqs)[:count])
    largest = float(np.abs(open_by).max(initial=0.0))
    if not largest > _ROUNDING:
        return ""
    taking = np.abs(left[:, rank:] @ open_by) / np.linalg.norm(open_by)
    own = zip(eqs.formed.rows, taking, strict=False)
    joints = ", ".join(dict.fromkeys(row.element for row, part in own if part > _TAKES_PART))
    return (
        f"there the constraints of joints {joints} are nearly redundant: any motion that one allows the "
        f"others allow too, but they do not close together, by {largest:.1e} of the mechanism's size; make "
        "lengths that are to be equal the same to the last digit, or leave one of these joints out"
    )


def _massless(task: Task, raw: RawRun) -> str:
    """Return which motion no mass resists at the last state, if that is why a run ended."""
    eqs = task.eqs
    t, x = _samples(task, raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    function = task.compiled(("mass_matrix", "jacobian"))
    mass, rows = task.evaluated(function, t[-1:], x[n_u:n, -1:], x[:n_u, -1:])
    places = massless_speeds(mass[0], rows[0])
    if not places:
        return ""
    problem = massless_problem("", [eqs.speed_names[k] for k in places], eqs.coordinate_names)
    return f"there {problem.what}; {problem.fix}"


def _without_direction(task: Task, raw: RawRun) -> str:
    """Return which springs have the length zero, and so no direction, at the last state."""
    eqs = task.eqs
    t, x = _samples(task, raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    springs = [spring.name for spring in eqs.model.elements if isinstance(spring, SpringDamper)]
    lengths = [
        float(task.evaluated(task.compiled(f"length {name}"), t[-1:], x[n_u:n, -1:], x[:n_u, -1:])[0])
        for name in springs
    ]
    short = [name for name, length in zip(springs, lengths, strict=True) if length == 0.0]
    if not short:
        return ""
    return (
        f"there spring {', '.join(short)} has length 0, so that its force along it has no direction; start "
        "beside this position, or take the stiffness alone with free length 0, and damp the joint instead"
    )


def idle_notes(task: Task, first: State) -> tuple[str, ...]:
    """Return which speeds no inertia resists at a first state: a rod that spins about itself."""
    eqs = task.eqs
    if not eqs.speed_names or not _has_rods(task):
        return ()
    t, q, u = first.t, np.array(list(first.q.values())), np.array(list(first.u.values()))
    mass, rows = task.compiled(("mass_matrix", "jacobian"), quick=True)(t, q, u, task.laws.at(t, q, u))
    names = [eqs.speed_names[k] for k in massless_speeds(mass, rows)]
    if not names:
        return ()
    return (
        f"no mass or inertia resists a motion of {', '.join(names)}: how it goes on follows from the choice "
        "of speeds, not from mechanics; give the body an inertia about each axis, or do not use it",
    )


def _has_rods(task: Task) -> bool:
    """Return whether a body has no inertia about one of its axes, planar bodies left out."""
    model = task.eqs.model
    if not isinstance(model, Model):
        return False
    spherical = {
        body for joint in model.joints if len(joint.rotation_coordinates) > _TWO
        for body in (joint.start.body, joint.end.body)
    }  # fmt: skip
    formulas = {f"{k} {i}": body.inertia[i] for k, body in enumerate(model.bodies) for i in range(3)}
    values = constant_values(task.eqs, formulas, task.parameters)
    for k, body in enumerate(model.bodies):
        zeros = sum(values[f"{k} {i}"] == 0.0 for i in range(3))
        if zeros == 1 or (zeros > 1 and body.name in spherical):
            return True
    return False


def _samples(task: Task, raw: RawRun) -> tuple[Floats, Floats]:
    """Return times of the motion up to its last, and the states there."""
    if raw.dense_output is None:
        return raw.t[[0, -1]], raw.x[:, [0, -1]]
    t = np.linspace(float(raw.dense_output.breaks[0]), raw.reached, _SAMPLES)
    return t, raw.dense_output(t)
