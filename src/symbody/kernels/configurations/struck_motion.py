"""A motion along which prescribed rates jump, piece by piece from one jump to the next."""

from symbody.kernels.block import FINISHED, NO_IMPULSE, RUNNING, TORN_MOTION, Run
from symbody.kernels.configurations.strike import STRUCK, TORN, strike
from symbody.kernels.configurations.strike_problem import RateJumps
from symbody.kernels.events.event_interruptions import end_with_state, watch_behind
from symbody.kernels.events.event_monitor import EventMonitor
from symbody.kernels.language import Function, Reals
from symbody.kernels.runge_kutta import copy
from symbody.kernels.step_machine import store_sample


def end_before_jump(run: Run, jumps: RateJumps) -> None:
    """Let a motion end just before the next jump, or at its own end behind the last one."""
    while jumps.next > 0:
        if (jumps.jumps[jumps.next - 1].behind - run.time) * run.goal.direction <= 0.0:
            break
        jumps.next = jumps.next - 1  # the motion goes on from before
    run.t_end = jumps.t_end
    if jumps.next < jumps.count:
        run.t_end = jumps.jumps[jumps.next].before
        if (run.t_end - run.time) * run.goal.direction < 0.0:
            run.t_end = run.time


def store_before(run: Run, jumps: RateJumps, times: Reals, t: Reals, x: Reals) -> None:
    """Store the present state as the samples before the jump to which the motion has come."""
    meets = jumps.jumps[jumps.next].meets
    while run.counts.samples < run.room.times:
        sample = run.counts.samples
        if (times[sample] - meets) * run.goal.direction >= 0.0:
            break
        store_sample(run, times[sample], run.state_old, t, x)


def store_behind(run: Run, jumps: RateJumps, times: Reals, t: Reals, x: Reals) -> None:
    """Store the present state as the samples at the jump that the motion has passed."""
    jump = jumps.jumps[jumps.next - 1]
    width = abs(jump.behind - jump.meets)
    while run.counts.samples < run.room.times:
        sample = run.counts.samples
        if (times[sample] - jump.meets) * run.goal.direction > width:
            break
        store_sample(run, times[sample], run.state_old, t, x)


def strike_state(
    s: Function, run: Run, jumps: RateJumps, times: Reals, t: Reals, x: Reals, breaks: Reals
) -> int:
    """Strike the state at which a motion has come to a jump; return a code, `FINISHED` without one.

    By what the energy rises is work.
    """
    if jumps.next == jumps.count:
        return FINISHED
    n = run.states
    problem = jumps.problem
    jump = jumps.jumps[jumps.next]
    store_before(run, jumps, times, t, x)
    copy(n, run.state_old, run.state_new)
    code = strike(s, problem, run.time, jump.behind, run.state_old)
    if code == TORN:
        return TORN_MOTION
    if code != STRUCK:
        return NO_IMPULSE
    jump.gained = problem.gained
    jump.change = 0.0
    for i in range(n - 1):
        jump.change = max(jump.change, abs(run.state_old[i] - run.state_new[i]))
    run.state_old[n - 1] = run.state_old[n - 1] + problem.gained
    if run.room.keep_dense != 0.0:
        breaks[run.counts.steps] = jump.meets
    run.time = jump.behind
    jumps.next = jumps.next + 1
    end_before_jump(run, jumps)
    if jumps.ends_behind != 0.0:
        run.t_end = run.time
        jumps.count = jumps.next
    return RUNNING


def watch_struck(
    e: Function, run: Run, monitor: EventMonitor, jumps: RateJumps, breaks: Reals, pieces: Reals
) -> None:
    """Watch the motion just behind a jump: events that happen at once find their state there."""
    jump = jumps.jumps[jumps.next - 1]
    end_with_state(run, breaks, pieces)
    watch_behind(e, run, monitor, abs(jump.behind - jump.before))
