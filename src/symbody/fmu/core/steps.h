/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Steps of our own, for co-simulation, and jumps of what depends on time alone. */

/* Jumps of what depends on time alone. */

/* Look for the next jump: in co-simulation of prescribed rates alone, since steps end at the others. */
static void look_for_jump(Motion *m)
{
    const double *B = m->pool + SB_BLOCK;
    double now;
    int k = 0, place = SB_RUN_BREAKS + (int)B[SB_RUN_BREAKS_POINTS];
    m->jump = HUGE_VAL; /* the clock does not stop at the last one any more */
    now = clock_of(m);
    while (k < SB_JUMPS - SB_ARE_MORE_JUMPS && !(sb_jumps[k] > now + sb_jump_margins[k])) k++;
    m->strikes = k < SB_JUMPS;
    m->jump = m->strikes ? sb_jumps[k] : HUGE_VAL;
    m->jump_margin = m->strikes ? sb_jump_margins[k] : 0.0;
    m->ends_jumps = SB_ARE_MORE_JUMPS && k == SB_JUMPS - 1;
    for (; !m->is_alone && isfinite(B[place + SB_BREAK_TIME]); place += SB_BREAK_SIZE) {
        const double *P = B + place;
        double margin = P[SB_BREAK_MARGIN];
        if (P[SB_BREAK_TIME] >= m->jump - m->jump_margin - margin) break;
        if (P[SB_BREAK_JUMPS] != 0.0 && P[SB_BREAK_TIME] > now + margin) {
            m->jump = P[SB_BREAK_TIME];
            m->jump_margin = margin;
            m->strikes = m->ends_jumps = 0;
            break;
        }
    }
}

/* Steps begin at the clock: where that has come behind the side before a jump, they cannot lead there. */
static int has_come_to_jump(const Motion *m) { return clock_of(m) >= m->jump - m->jump_margin; }

/* Let prescribed rates that jump strike the mechanism. Joints that stick and ropes hold nothing meanwhile. */
static int strike_rates(Motion *m, double before, double behind)
{
    int code = 0;
    m->unmet = m->ends_jumps ? UNKNOWN_RATES : NOTHING_UNMET;
    if (m->unmet) return UNSOLVED;
    project_state(m); /* what drifts stays as it is where it cannot be closed */
    release(m);
    renew_arguments(m);
#if SB_IS_STRUCK
    code = symbody_strike(mechanism_strike, m->pool + SB_STRIKE, before, behind, m->x);
#else
    (void)before, (void)behind;
#endif
    m->valid = 0;
    m->is_fresh = 1;
    if (code != SB_STRUCK) m->unmet = code == SB_TORN ? TORN_MOTION : NO_SPEEDS;
    return m->unmet ? UNSOLVED : SOLVED;
}

/* Go behind the jumps to which the motion has come, and do what follows: values jump through zero, modes end. Returns
   whether values of states changed, -1 for a fault. */
static int pass_jumps(Motion *m, int *must_stop)
{
    int changed = 0;
    while (!*must_stop && has_come_to_jump(m)) {
        double before = m->jump - m->jump_margin, behind = m->jump + m->jump_margin;
        int acted;
        if (m->strikes && strike_rates(m, before, behind) != SOLVED) return -1;
        changed |= m->strikes;
        m->past_jump = behind;
        look_for_jump(m);
        m->valid = 0;
        note_events(m);
        acted = act(m, must_stop);
        if (acted < 0) return -1;
        changed |= acted;
    }
    return changed;
}

/* Steps of our own, for co-simulation. */

static void begin_steps(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0};
    renew_arguments(m); /* events and samples may have changed them */
    B[SB_RUN_TIME] = clock_of(m);
    memcpy(B + (int)B[SB_RUN_STATE_OLD], m->x, SB_X * sizeof(double));
    B[SB_RUN_COUNTS_FAILED_KERNEL] = B[SB_RUN_COUNTS_STEPS] = B[SB_RUN_COUNTS_SAMPLES] = 0.0;
    B[SB_RUN_AFTER_REJECTION] = B[SB_RUN_STIFF_VOTES] = B[SB_RUN_OTHER_VOTES] = B[SB_RUN_UNJUDGED] = 0.0;
    B[SB_RUN_BREAKS_NEXT] = 0.0;
    m->from = m->to = m->time;
    m->is_fresh = 0;
#if SB_IS_IMPLICIT
    m->code = symbody_begin_implicit(
        mechanism_motion, B, m->pool + SB_IMPLICIT, nothing, nothing, nothing, m->ends);
#else
    m->code = symbody_begin(mechanism_motion, B, nothing, nothing, nothing, m->ends);
#endif
    B[SB_RUN_FIRST_STEP] = SB_IS_FIXED ? B[SB_RUN_GOAL_MAX_STEP] : fabs(B[SB_RUN_STEP]);
}

static void take_step(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0}, before = B[SB_RUN_TIME];
    double end = B[SB_RUN_T_END], planned = B[SB_RUN_STEP], stop = SB_SAMPLED ? symbody_piece_end(B, sampler_of(m), end) : end;
    if (stop > m->jump - m->jump_margin) stop = m->jump - m->jump_margin;
    B[SB_RUN_T_END] = stop;
#if SB_IS_IMPLICIT
    m->code = symbody_advance_implicit(mechanism_motion, mechanism_turn, mechanism_jacobian, SB_PROJECTION, B,
        m->pool + SB_IMPLICIT, nothing, nothing, nothing, m->ends, m->pieces, 1);
#else
    m->code = symbody_advance(
        mechanism_motion, SB_PROJECTION, B, nothing, nothing, nothing, m->ends, m->pieces, 1);
#endif
    B[SB_RUN_T_END] = end;
    /* a step that only a sample or a jump cut short says nothing of the next */
    if (stop != end && B[SB_RUN_TIME] == stop && fabs(B[SB_RUN_LENGTH]) < fabs(planned) && fabs(B[SB_RUN_STEP]) < fabs(planned))
        B[SB_RUN_STEP] = planned;
    if (B[SB_RUN_COUNTS_STEPS] != 0.0) {
        B[SB_RUN_COUNTS_STEPS] = 0.0;
        m->from = before;
        m->to = B[SB_RUN_T_NEW];
        note_rates(m);
        if (!SB_IS_FIXED) B[SB_RUN_FIRST_STEP] = fabs(B[SB_RUN_STEP]);
    }
}

/* The state at a time inside the last step. */
static void state_at(Motion *m, double time, double *x)
{
    const double *B = m->pool + SB_BLOCK;
    if (time < m->to)
        symbody_interpolate(SB_X, SB_DENSE_ROWS, m->pieces, (time - m->from) / (m->to - m->from), x);
    else
        memcpy(x, B + (int)B[SB_RUN_STATE_OLD], SB_X * sizeof(double));
}

static int show_state(Motion *m, double time)
{
    m->valid = 0;
    m->time = time;
    if (m->to <= m->from) return SOLVED;
    state_at(m, time, m->x);
    return time < m->to ? project_state(m) : SOLVED;
}

/* Return whether an event has happened at a time of the last step, since the sides kept. */
static int has_event(Motion *m, double time)
{
    double x[SB_X + 1], values[SB_EVENTS + SB_ELEMENTS + 1], now = m->time;
    int k, status;
    state_at(m, time, x);
    m->time = time;
    if (time < m->to) project_place(m, x); /* as it is shown */
    status = watch(m, x, values);
    m->time = now;
    for (k = 0; k < SB_EVENTS + SB_ELEMENTS && status == 0; k++)
        if (has_happened(m, k, values[k])) return 1;
    return 0;
}

/* Go on inside the last step to a time, or to the first event before it. */
static int pass_events(Motion *m, double end)
{
    double start = m->time, low = start, high = end;
    int k;
    if (SB_EVENTS + SB_ELEMENTS == 0) return 0;
    for (k = 1; k <= SB_LOOKS; k++) {
        high = k == SB_LOOKS ? end : start + (end - start) * k / SB_LOOKS;
        if (has_event(m, high)) break;
        show_state(m, high);
        note_events(m); /* sides that change without an event */
        low = high;
    }
    if (k > SB_LOOKS) return 0;
    for (k = 0; k < 200; k++) {
        double middle = low + 0.5 * (high - low);
        if (!(middle > low && middle < high)) break;
        if (has_event(m, middle)) high = middle;
        else low = middle;
    }
    show_state(m, high);
    note_events(m);
    return 1;
}

static int has_come(Motion *m, double target)
{
    return m->time >= target || (SB_SAMPLED && symbody_is_instant(sampler_of(m), m->time, target));
}

/* Go on to a time; returns one of the codes of the integrator, and whether an event ends the motion. */
static int go_to(Motion *m, double target, int *must_stop)
{
    double *B = m->pool + SB_BLOCK;
    int events = 0, restarts = 0;
    *must_stop = 0;
    renew_arguments(m);
    if (m->is_fresh && SB_ELEMENTS && act(m, must_stop) < 0) return SB_NOT_FINITE; /* inputs may have jumped */
    if (pass_jumps(m, must_stop) < 0) return SB_NOT_FINITE; /* where the last step failed */
    while (!*must_stop && !has_come(m, target)) {
        double end;
        if (B[SB_RUN_T_END] < target) B[SB_RUN_T_END] = target + SB_SPAN;
        if (m->is_fresh) {
            if (act_at_start(m) < 0) return SB_NOT_FINITE;
            begin_steps(m);
        }
        while (m->code == SB_RUNNING && m->to <= m->time) take_step(m);
        if (m->code != SB_RUNNING && m->code != SB_FINISHED) return m->code;
        if (m->to <= m->time) { /* the end of an earlier goal: begin anew towards the next */
            if (++restarts > 2) return SB_COLLAPSED; /* nor does it lead there */
            m->is_fresh = 1;
            continue;
        }
        restarts = 0;
        end = m->to < target ? m->to : target;
        if (pass_events(m, end)) {
            if (act(m, must_stop) < 0) return SB_NOT_FINITE;
            if (*must_stop) return SB_RUNNING;
            if (++events > SB_MOST_EVENTS) return SB_TOO_MANY;
        } else if (show_state(m, end) != SOLVED)
            return SB_SINGULAR;
        if (pass_jumps(m, must_stop) < 0) return SB_NOT_FINITE;
        if (!*must_stop && sample(m, must_stop) < 0) return SB_NOT_FINITE;
        if (*must_stop) return SB_RUNNING;
    }
    if (*must_stop) return SB_RUNNING;
    if (m->time < target) m->time = target; /* the same instant */
    keep_settled(m);
    return SB_RUNNING;
}
