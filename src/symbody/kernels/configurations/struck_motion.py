"""A motion along which prescribed rates jump, piece by piece from one jump to the next."""

from symbody.kernels.block import FINISHED, NO_IMPULSE, RUNNING, TORN_MOTION, Run
from symbody.kernels.configurations.strike import STRUCK, TORN, strike
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.events.event_interruptions import end_with_state, values_before, watch_behind
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.language import Function, Reals
from symbody.kernels.step_machine import begin_again, store_sample


def end_before_jump(run: Run, jumps: RateJumps) -> None:
    """Let a motion end just before the next jump, or at its own end behind the last one."""
    while jumps.next > 0:
        if (jumps.times[2 * jumps.next - 1] - run.time) * run.goal.direction <= 0.0:
            break
        jumps.next = jumps.next - 1  # the motion goes on from before
    run.t_end = jumps.t_end
    if jumps.next < jumps.count:
        run.t_end = jumps.times[2 * jumps.next]
        if (run.t_end - run.time) * run.goal.direction < 0.0:
            run.t_end = run.time


def strike_state(s: Function, run: Run, jumps: RateJumps) -> int:
    """Strike the state at which a motion has come to a jump; return a code of `block`.

    By what the energy rises is work.
    """
    n = run.states
    problem = jumps.problem
    behind = jumps.times[2 * jumps.next + 1]
    code = strike(s, problem, run.time, behind, run.state_old)
    if code == TORN:
        return TORN_MOTION
    if code != STRUCK:
        return NO_IMPULSE
    run.state_old[n - 1] = run.state_old[n - 1] + problem.gained
    run.time = behind
    jumps.next = jumps.next + 1
    end_before_jump(run, jumps)
    return RUNNING


def pass_jump_of_rates(
    f: Function, s: Function, run: Run, jumps: RateJumps, times: Reals, t: Reals, x: Reals, breaks: Reals
) -> int:
    """Go on behind the jump to which a motion has come; return a code of `block`, `FINISHED` without one.

    Samples at the time of a jump are of the state behind it.
    """
    if jumps.next == jumps.count:
        return FINISHED
    code = strike_state(s, run, jumps)
    if code != RUNNING:
        return code
    while run.counts.samples < run.room.times:
        sample = run.counts.samples
        if (times[sample] - run.time) * run.goal.direction > 0.0:
            break
        store_sample(run, times[sample], run.state_old, t, x)
    return begin_again(f, run, times, t, x, breaks)


def pass_watched_jump(
    f: Function, s: Function, e: Function, run: Run, monitor: EventMonitor, jumps: RateJumps, times: Reals,
    t: Reals, x: Reals, breaks: Reals, pieces: Reals,
) -> int:  # fmt: skip
    """Go on behind a jump as `pass_jump_of_rates`, and watch what passes zero there.

    Behind the steps that are stored pieces have room for one more.
    """
    if jumps.next == jumps.count:
        return FINISHED
    before = run.time
    values_before(e, run, monitor)
    code = pass_jump_of_rates(f, s, run, jumps, times, t, x, breaks)
    if code == FINISHED:
        code = RUNNING
    if code == RUNNING:
        end_with_state(run, breaks, pieces)  # events that happen at once find their state there
        watch_behind(e, run, monitor, abs(run.time - before))
    return code
