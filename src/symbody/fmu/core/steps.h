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

/* Let prescribed rates that jump strike the mechanism. Joints that stick, ropes and stops hold nothing meanwhile. */
static int strike_rates(Motion *m, double before, double behind)
{
    int code = 0;
    m->unmet = m->ends_jumps ? UNKNOWN_RATES : NOTHING_UNMET;
    if (m->unmet) return UNSOLVED;
    project_state(m); /* what drifts stays as it is where it cannot be closed */
    release(m);
    renew_arguments(m);
#if SB_IS_STRUCK
    code = symbody_strike(symbody_mechanism_strike, m->pool + SB_STRIKE, before, behind, m->x);
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
        look_before(m);
        if (m->strikes && strike_rates(m, before, behind) != SOLVED) return -1;
        changed |= m->strikes;
        m->past_jump = behind;
        m->width = behind - before;
        look_for_jump(m);
        m->valid = 0;
        m->is_fresh = 1;
        note_events(m);
        acted = act(m, must_stop);
        if (acted < 0) return -1;
        changed |= acted;
    }
    return changed;
}

/* Steps of our own, for co-simulation. They lead on until it is known what happens up to the time asked for. */

static void begin_steps(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0};
    renew_arguments(m); /* events and samples may have changed them */
    B[SB_RUN_TIME] = clock_of(m);
    memcpy(B + (int)B[SB_RUN_STATE_OLD], m->x, sizeof m->x);
    B[SB_RUN_COUNTS_FAILED_KERNEL] = B[SB_RUN_COUNTS_STEPS] = B[SB_RUN_COUNTS_SAMPLES] = 0.0;
    B[SB_RUN_AFTER_REJECTION] = B[SB_RUN_STIFF_VOTES] = B[SB_RUN_OTHER_VOTES] = B[SB_RUN_UNJUDGED] = 0.0;
    B[SB_RUN_BREAKS_NEXT] = 0.0;
    m->is_fresh = m->found = 0;
#if SB_IS_IMPLICIT
    m->code = symbody_begin_implicit(
        symbody_mechanism_motion, B, m->pool + SB_IMPLICIT, nothing, nothing, nothing, m->breaks);
#else
    m->code = symbody_begin(symbody_mechanism_motion, B, nothing, nothing, nothing, m->breaks);
#endif
#if SB_WATCH_COUNT
    watch_of(m)[SB_W_FAULT] = 0.0;
    symbody_watch_behind(WATCH, B, watch_of(m), fmax(m->width, 8.0 * DBL_EPSILON * fabs(m->time)));
#endif
#if SB_ELEMENTS
    symbody_forget_ends(switch_of(m), watch_of(m));
#endif
    m->width = 0.0;
    B[SB_RUN_FIRST_STEP] = SB_IS_FIXED ? B[SB_RUN_GOAL_MAX_STEP] : fabs(B[SB_RUN_STEP]);
}

/* Make room for steps. */
static void forget_steps(Motion *m)
{
    double *B = m->pool + SB_BLOCK;
    if (B[SB_RUN_COUNTS_STEPS] < SB_STEPS) return;
#if SB_WATCH_COUNT
    symbody_forget_steps(B, watch_of(m), m->breaks, m->pieces, SB_LAST_STEPS);
#else
    m->breaks[0] = m->breaks[1];
    B[SB_RUN_COUNTS_STEPS] = 0.0;
#endif
}

/* Try one step, which ends at the next sample or jump, and look for events in it. */
static void try_step(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0}, accepted = B[SB_RUN_COUNTS_ACCEPTED];
    double end = B[SB_RUN_T_END], planned = B[SB_RUN_STEP], stop = SB_SAMPLED ? symbody_piece_end(B, sampler_of(m), end) : end;
    if (stop > m->jump - m->jump_margin) stop = m->jump - m->jump_margin;
    forget_steps(m);
    B[SB_RUN_T_END] = stop;
#if SB_IS_IMPLICIT
    m->code = symbody_advance_implicit(
        symbody_mechanism_motion, symbody_mechanism_turn, symbody_mechanism_jacobian, SB_PROJECTION, SB_GAP_FUNCTION, B,
        m->pool + SB_IMPLICIT, nothing, nothing, nothing, m->breaks, m->pieces, 1);
#else
    m->code = symbody_advance(
        symbody_mechanism_motion, SB_PROJECTION, SB_GAP_FUNCTION, B, nothing, nothing, nothing, m->breaks, m->pieces, 1);
#endif
    B[SB_RUN_T_END] = end;
    if (m->code == SB_RUNNING && B[SB_RUN_TIME] >= stop) m->code = SB_FINISHED;
    /* a step that only a sample or a jump cut short says nothing of the next */
    if (stop != end && B[SB_RUN_TIME] == stop && fabs(B[SB_RUN_LENGTH]) < fabs(planned) && fabs(B[SB_RUN_STEP]) < fabs(planned))
        B[SB_RUN_STEP] = planned;
    if (B[SB_RUN_COUNTS_ACCEPTED] != accepted) {
        note_rates(m, B + (int)B[SB_RUN_STATE_OLD]);
        if (!SB_IS_FIXED) B[SB_RUN_FIRST_STEP] = fabs(B[SB_RUN_STEP]);
    }
}

/* Look for events in the steps at hand; those before the time asked for are certain. */
static void look_ahead(Motion *m, double target)
{
#if SB_WATCH_COUNT
    double *B = m->pool + SB_BLOCK;
    if (B[SB_RUN_COUNTS_STEPS] == 0.0) return;
#if SB_ELEMENTS
    symbody_watch_shares(symbody_mechanism_deciding, B, watch_of(m), switch_of(m), m->breaks, m->pieces);
#endif
    do {
        m->found = symbody_look(ACTS, watch_of(m), m->breaks, m->pieces, m->happened, (int)B[SB_RUN_COUNTS_STEPS],
            m->code != SB_RUNNING);
        if (m->found == SB_NO_ROOM) log_happened(m, target);
    } while (m->found == SB_NO_ROOM);
#else
    (void)m, (void)target;
#endif
}

/* Up to when nothing that is still found changes the motion. */
static double settled(Motion *m)
{
    const double *B = m->pool + SB_BLOCK, *W = watch_of(m);
    if (m->found) return W[SB_W_CUT];
    if (!SB_WATCH_COUNT || m->code != SB_RUNNING) return B[SB_RUN_TIME];
    return W[SB_W_SEEN] == 0.0 ? m->breaks[(int)W[SB_W_FIRST_STEP]] : W[SB_W_T_BEFORE];
}

/* What counts as one time for events. */
static double instant(Motion *m, double time)
{
    return SB_WATCH_COUNT ? 2e-12 * fmax(watch_of(m)[SB_W_SPAN], fabs(time)) : 0.0;
}

/* Let events act whose values have jumped through zero with the rates, before samples are taken. Returns whether values
   of states changed, -1 for a fault. */
static int act_behind(Motion *m, int *must_stop)
{
#if SB_WATCH_COUNT
    if (m->is_alone && m->width > 0.0 && is_sample_due(m)) {
        double *B = m->pool + SB_BLOCK;
        begin_steps(m);
        symbody_end_with_state(B, m->breaks, m->pieces);
        m->found = symbody_look(ACTS, watch_of(m), m->breaks, m->pieces, m->happened, 0, 1);
        if (m->found) return act(m, must_stop);
    }
#else
    (void)m, (void)must_stop;
#endif
    return 0;
}

static int show_state(Motion *m, double time)
{
    const double *B = m->pool + SB_BLOCK;
    int k = (int)B[SB_RUN_COUNTS_STEPS] - 1;
    m->valid = 0;
    m->time = time;
    while (k > 0 && time < m->breaks[k]) k--;
    if (k >= 0 && time < m->breaks[k + 1]) {
        double share = fmax((time - m->breaks[k]) / (m->breaks[k + 1] - m->breaks[k]), 0.0);
        symbody_interpolate(SB_N, SB_DENSE_ROWS, m->pieces + k * SB_DENSE_ROWS * SB_N, share, m->x);
        return project_state(m);
    }
    memcpy(m->x, B + (int)B[SB_RUN_STATE_OLD], sizeof m->x);
    return SOLVED;
}

static int has_come(Motion *m, double target)
{
    return m->time >= target || (SB_SAMPLED && symbody_is_instant(sampler_of(m), m->time, target));
}

/* Go on to a time; returns one of the codes of the integrator, and whether an event ends the motion. */
static int go_to(Motion *m, double target, int *must_stop)
{
    double *B = m->pool + SB_BLOCK;
    int restarts = 0;
    *must_stop = 0;
    if (m->is_fresh && SB_ELEMENTS && act(m, must_stop) < 0) return SB_NOT_FINITE; /* inputs may have jumped */
    if (pass_jumps(m, must_stop) < 0) return SB_NOT_FINITE; /* where the last step failed */
    while (!*must_stop && !has_come(m, target)) {
        double end;
        if (B[SB_RUN_T_END] < target) B[SB_RUN_T_END] = target + SB_SPAN;
        if (m->is_fresh) begin_steps(m);
        while (m->code == SB_RUNNING && !m->found && settled(m) < target + instant(m, target)) {
            try_step(m);
            look_ahead(m, target);
        }
        end = settled(m) < target ? settled(m) : target;
        if (m->found && settled(m) <= target) {
            show_state(m, end > m->time ? end : m->time);
            if (act(m, must_stop) < 0) return SB_NOT_FINITE;
        } else if (end > m->time) {
            if (show_state(m, end) != SOLVED) return SB_SINGULAR;
            restarts = 0;
        } else {
            if (m->code != SB_RUNNING && m->code != SB_FINISHED) return m->code;
            if (++restarts > 2) return SB_COLLAPSED; /* the end of an earlier goal, nor does it lead there */
            interrupt(m);
        }
        log_happened(m, clock_of(m));
        if (!*must_stop && pass_jumps(m, must_stop) < 0) return SB_NOT_FINITE;
        if (!*must_stop && act_behind(m, must_stop) < 0) return SB_NOT_FINITE;
        if (!*must_stop && sample(m, must_stop) < 0) return SB_NOT_FINITE;
    }
    if (*must_stop) return SB_RUNNING;
    if (m->time < target) m->time = target; /* the same instant */
    keep_settled(m);
    return SB_RUNNING;
}
