"""What to note about a motion that ended early: when, and what in the mechanism is to blame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from symbody.codegen.massless import massless_problem, massless_speeds
from symbody.manifold import count_significant
from symbody.model.loads.forces import SpringDamper
from symbody.simulation.methods.closed_loops.crossing import crossing_of_motion
from symbody.simulation.methods.closed_loops.loop_constraints import LoopConstraints, motion_branch
from symbody.simulation.native.run import RawRun
from symbody.simulation.results.start_notes import TAKES_PART, nearly_redundant
from symbody.simulation.simulation_problem import SimulationProblem
from symbody.simulation.status import Status

Floats = NDArray[np.float64]

_COLLAPSES: Final = (Status.STEP_COLLAPSE, Status.SINGULAR, Status.NOT_FINITE)
# Configurations of the motion that are looked at to learn how many constraints are independent.
_SAMPLES: Final = 7
# A lock-up is approached like a root: 1e-6 s before it a singular value is still a thousandth.
_LOST: Final = 1e-3
# Share of the prescribed velocities that counts.
_DEMANDED: Final = 1e-2


def stop_note(problem: SimulationProblem, raw: RawRun) -> str:
    """Return where and on whose account a run ended early, empty if it did not."""
    reached = raw.reach
    if raw.status in _COLLAPSES and problem.eqs.multiplier_names:
        position = _singular_position(problem, raw)
        cause = _open_constraints(problem, raw) if position is None else position.note
        if cause:
            return f"{reached}; {cause}"
    if raw.status in (Status.SINGULAR, Status.NOT_FINITE):
        cause = _massless(problem, raw) or _springs_of_no_length(problem, raw)
        if cause:
            return f"{reached}; {cause}"
    return raw.stop_note((*problem.eqs.state_names, "work")) + _cure(problem, raw)


def _cure(problem: SimulationProblem, raw: RawRun) -> str:
    """Return what to do where a state changes too fast, if the mechanism shows it; empty otherwise."""
    eqs = problem.eqs
    if raw.status is not Status.STEP_COLLAPSE or not eqs.multiplier_names:
        return ""
    balanced = [name for name in eqs.coordinate_names if f"balance_{name}" in eqs.multiplier_names]
    name = (*eqs.state_names, "work")[raw.state or 0].removesuffix("_dot")
    if name in balanced:
        return (
            f": {name} has no mass, so its rate jumps where the balance of forces along it has a kink; put "
            f"a damper along it, give mass to what moves there, or smooth the kink"
        )
    rows, _ = _constraint_rows(problem, raw)
    if (
        np.isfinite(rows).all()
        and count_significant(np.linalg.svd(rows[-1:], compute_uv=False)) < rows.shape[1]
    ):
        return "; some constraints are redundant, see sb.redundancy(): sb.Partition() may pass this position"
    return ""


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
    def note(self) -> str:
        """The position in words."""
        joints = f"joint{'s' if len(self.joints) > 1 else ''} {', '.join(self.joints)}"
        speeds = ", ".join(self.speeds)
        if self.is_locked:
            return (
                f"there the mechanism locks: the prescribed motions can continue only with infinite "
                f"{speeds} if {joints} stays closed, and {_freedoms(self.freedoms)} left besides; end the "
                f"motion earlier, or change the lengths or the prescribed motion"
            )
        if self.opening:
            return (
                f"there the constraints of {joints} are nearly dependent: branches of the mechanism pass "
                f"each other without meeting (lengths that differ by {self.opening:.2g} of the mechanism's "
                f"size would make them meet), and speeds change sharply; sb.Projection() passes it"
            )
        return (
            f"there the constraints of {joints} become dependent, a singular position (change point or dead "
            f"centre) where {speeds} are undetermined: {_freedoms(self.freedoms + self.lost)} there instead "
            f"of {self.freedoms}; sb.Projection() or sb.Partition() may pass it; or change the lengths or "
            f"the start"
        )


def _freedoms(count: int) -> str:
    return f"{count} degree{'' if count == 1 else 's'} of freedom {'is' if count == 1 else 'are'}"


def _singular_position(problem: SimulationProblem, raw: RawRun) -> _SingularPosition | None:
    """Return the singular position at which a motion ended, if it is one."""
    eqs = problem.eqs
    n_u, scales = len(eqs.speed_names), problem.scales.constraints(eqs)
    rows, drift = _constraint_rows(problem, raw)
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
    elements = [row.element for row, share in zip(eqs.formed.rows, by_row, strict=True) if share > TAKES_PART]
    return _SingularPosition(
        tuple(dict.fromkeys(elements)),
        tuple(name for name, share in zip(eqs.speed_names, by_speed, strict=True) if share > TAKES_PART),
        n_u - rank,
        len(lost),
        is_locked,
        0.0 if is_locked else _branch_opening(problem, raw),
    )


def _branch_opening(problem: SimulationProblem, raw: RawRun) -> float:
    """Return how far from meeting branches are at the end of a motion; 0 where they meet or are none."""
    (t, x), loops = _samples(raw), LoopConstraints(problem)
    branch = motion_branch(loops, float(t[0]), x[:, 0])
    crossing = crossing_of_motion(loops, branch, float(t[-1]), x[:, -1])
    return 0.0 if crossing is None or crossing.meets else abs(crossing.opening)


def _constraint_rows(problem: SimulationProblem, raw: RawRun) -> tuple[Floats, Floats]:
    """Return the constraints on velocities along the motion, without units, and what they demand."""
    eqs = problem.eqs
    t, x = _samples(raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    function = problem.compile_outputs(("jacobian", "velocity_constraints"))
    rows, drift = problem.evaluate(function, t, x[n_u:n], np.zeros((n_u, t.size)))
    scales, speeds = problem.scales.constraints(eqs), problem.scales.displacements(eqs)
    return rows / scales[:, np.newaxis] * speeds, drift


def _open_constraints(problem: SimulationProblem, raw: RawRun) -> str:
    """Return which constraints follow from others in direction, but not in value, where a motion ended."""
    eqs = problem.eqs
    rows, _ = _constraint_rows(problem, raw)
    if not (rows.size and eqs.formed.holonomic and np.isfinite(rows[-1]).all()):
        return ""
    t, x = _samples(raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    values = problem.evaluate(problem.compile_outputs("constraints"), t[-1:], x[n_u:n, -1:], x[:n_u, -1:])[0]
    note = nearly_redundant(problem, rows[-1], values)
    return note and f"there {note}"


def _massless(problem: SimulationProblem, raw: RawRun) -> str:
    """Return which motion no mass resists at the last state, if that is why a run ended."""
    eqs = problem.eqs
    t, x = _samples(raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    function = problem.compile_outputs(("mass_matrix", "jacobian"))
    mass, rows = problem.evaluate(function, t[-1:], x[n_u:n, -1:], x[:n_u, -1:])
    places = massless_speeds(mass[0], rows[0])
    if not places:
        return ""
    fault = massless_problem("", [eqs.speed_names[k] for k in places], eqs.coordinate_names)
    return f"there {fault.what}; {fault.fix}"


def _springs_of_no_length(problem: SimulationProblem, raw: RawRun) -> str:
    """Return which springs have the length zero, and so no direction, at the last state."""
    eqs = problem.eqs
    t, x = _samples(raw)
    n_u, n = len(eqs.speed_names), len(eqs.state_names)
    springs = [spring.name for spring in eqs.model.elements if isinstance(spring, SpringDamper)]
    lengths = [
        float(
            problem.evaluate(problem.compile_outputs(f"length {name}"), t[-1:], x[n_u:n, -1:], x[:n_u, -1:])[
                0
            ]
        )
        for name in springs
    ]
    short = [name for name, length in zip(springs, lengths, strict=True) if length == 0.0]
    if not short:
        return ""
    return (
        f"there spring {', '.join(short)} has length 0, so its force has no direction; start near this "
        f"position, or use the stiffness alone with free length 0, and damp the joint instead"
    )


def _samples(raw: RawRun) -> tuple[Floats, Floats]:
    """Return times of the motion up to its last, and the states there."""
    if raw.dense_output is None:
        return raw.t[[0, -1]], raw.x[:, [0, -1]]
    t = np.linspace(float(raw.dense_output.breaks[0]), raw.reached, _SAMPLES)
    return t, raw.dense_output(t)
