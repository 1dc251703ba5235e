"""How a motion ended."""

from __future__ import annotations

from enum import Enum, unique


@unique
class Status(Enum):
    """The verdict on a run; the value names what happened and what to try."""

    SUCCESS = "the motion was computed to its end"
    STOPPED = "a stopping event ended the motion"
    STEP_COLLAPSE = (
        "no step is small enough here: the motion runs to infinity, locks or jumps; end the run earlier, "
        "smooth the law that jumps, or loosen rtol and atol if they are close to rounding"
    )
    NOT_FINITE = (
        "the accelerations are not finite: look for a division by zero, a root or logarithm of a negative "
        "number, or an overflow near the last stored state"
    )
    SINGULAR = (
        "the accelerations are not determined: the mass matrix is not positive definite in some direction "
        "that the constraints leave free; look for a body without mass or inertia or a zero parameter"
    )
    FRICTION = (
        "friction and the reaction it comes from have no solution, or two (Painleve): the joint named in "
        "the notes locks or jumps; lower its mu, change the direction of what loads it, or give the friction "
        "as a force"
    )
    DEPENDENT_SPEEDS = (
        "the dependent speeds named in the notes do not follow from the others a little farther on: name "
        "other dependent_speeds, or leave them out, so that multipliers hold the constraints"
    )
    TOO_MANY_STEPS = (
        "max_steps ran out: raise it, loosen rtol and atol, or use sb.Stiff() if fast damped motions force "
        "small steps, sb.GeneralizedAlpha() if they are hardly damped"
    )
    STIFF = "fast damped motions, not accuracy, keep the steps small: use sb.Stiff()"
    CHATTERING = (
        "an event happens again and again within an instant: use action='stop', give it a dead band, or "
        "describe what follows by another law"
    )
    NOT_STARTED = "the motion cannot start with these values: look for the reason in the notes of the case"
    WORKER_LOST = (
        "the workers that computed this case ended again and again: look for their memory and their log, or "
        "pass executor=None"
    )
    INTERRUPTED = "the run was interrupted: what had been computed by then is kept"
    OUT_OF_MEMORY = (
        "the samples outgrew the memory of this computer: pass times= to store fewer, or shorten the run"
    )

    UNMET_ACTION = (
        "the action of an event sets what the constraints do not admit: look for its values in the notes, "
        "and set fewer of them, or such that fit each other"
    )

    @property
    def success(self) -> bool:
        """Whether the motion reached its end, or an event that stops it."""
        return self in (Status.SUCCESS, Status.STOPPED)
