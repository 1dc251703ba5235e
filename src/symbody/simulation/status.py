"""How a motion ended."""

from __future__ import annotations

from enum import Enum, unique


@unique
class Status(Enum):
    """The verdict on a run; the value names what happened and what to try.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> run = sb.simulate(sb.form_equations(sb.Model("cart", [rail])), 1.0)
    >>> run.status.name, run.status.value
    ('SUCCESS', 'the motion was computed to the end')
    """

    SUCCESS = "the motion was computed to the end"
    STOPPED = "a stopping event ended the motion"
    STEP_COLLAPSE = (
        "no step is small enough here: the motion grows without bound, locks or jumps; end the run earlier, "
        "smooth the formula that jumps, or loosen rtol and atol if they are close to rounding"
    )
    NOT_FINITE = (
        "the accelerations are not finite: look for a division by zero, a root or logarithm of a negative "
        "number, or an overflow near the last stored state"
    )
    SINGULAR = (
        "the accelerations are undetermined: the mass matrix is not positive definite in a direction that "
        "the constraints leave free; look for a body without mass or inertia or a parameter that is zero"
    )
    FRICTION = (
        "friction and the normal reaction have no solution, or two (Painleve paradox): the joint named in "
        "the notes locks or jumps; lower its mu, change the direction of its load, or model the friction as "
        "a force"
    )
    DEPENDENT_SPEEDS = (
        "a little later the other speeds no longer determine the dependent speeds named in the notes: name "
        "other dependent_speeds, or leave dependent_speeds out, so that multipliers enforce the constraints"
    )
    TOO_MANY_STEPS = (
        "max_steps was reached: increase it, loosen rtol and atol, or use sb.Stiff() if fast damped motions "
        "force small steps, sb.GeneralizedAlpha() if they are hardly damped"
    )
    STIFF = "fast damped motions, not accuracy, keep the steps small: use sb.Stiff()"
    CHATTERING = (
        "an event happens again and again within an instant: use action='stop', give it a dead band, or "
        "describe the motion that follows by a different model"
    )
    NOT_STARTED = "the motion cannot start with these values: look for the reason in the notes of the case"
    WORKER_LOST = (
        "the workers that computed this case ended: check their memory and log, or pass executor=None"
    )
    INTERRUPTED = "the run was interrupted: the results computed so far are available"
    OUT_OF_MEMORY = (
        "the samples do not fit into the memory of this computer: pass times= to store fewer, or shorten "
        "the run"
    )

    UNMET_ACTION = (
        "the action of an event sets values that the constraints do not allow: see the notes, and set fewer "
        "values or consistent ones"
    )

    @property
    def success(self) -> bool:
        """Whether the motion reached its end, or an event that stops it."""
        return self in (Status.SUCCESS, Status.STOPPED)
