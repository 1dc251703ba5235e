/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Events: each watches a number that passes zero. The end of a mode is one, too: its number falls to zero.
   The kernels of an `EventMonitor` find and judge them: along steps of our own, or where an importer looks. */

#define WATCH SB_WATCHED_FUNCTION
#define ACTS WATCH, SB_ACTION_FUNCTION, SB_ASSEMBLY_FUNCTION

/* Log what has happened up to a time, and keep room for more. */
static void log_happened(Motion *m, double until);

/* Before what may let values jump: on which sides they are. Importers have shown them. */
static void look_before(Motion *m)
{
#if SB_WATCH_COUNT
    double *B = m->pool + SB_BLOCK;
    if (!m->is_alone) return;
    B[SB_RUN_TIME] = clock_of(m);
    memcpy(B + (int)B[SB_RUN_STATE_OLD], m->x, sizeof m->x);
    symbody_values_before(WATCH, B, watch_of(m));
#else
    (void)m;
#endif
}

/* What follows changes the motion from here on: forget what lies ahead. */
static void interrupt(Motion *m)
{
    if (m->is_fresh) return;
    m->is_fresh = 1;
    m->found = 0;
#if SB_WATCH_COUNT
    symbody_rewind_events(watch_of(m), m->happened, clock_of(m));
#endif
    look_before(m);
}

/* Where a motion goes on: steps of our own find by themselves what leaves zero. */
static void look_at_sides(Motion *m)
{
#if SB_WATCH_COUNT
    int k;
    renew_arguments(m);
    watch_of(m)[SB_W_FAULT] = 0.0;
    if (!m->is_alone) symbody_look_at_sides(WATCH, watch_of(m), clock_of(m), m->x);
    else
        for (k = 0; k < SB_WATCH_COUNT; k++) event_of(m, k)[SB_E_SIDE] = 0.0;
#else
    (void)m;
#endif
}

/* Note which events have happened since the side of each was looked at; return whether any has. */
static int note_events(Motion *m)
{
#if SB_WATCH_COUNT
    renew_arguments(m);
    watch_of(m)[SB_W_FAULT] = 0.0;
    return !m->is_alone && symbody_note_events(WATCH, watch_of(m), clock_of(m), m->x) > 0;
#else
    return (void)m, 0;
#endif
}

/* What an importer watches of a mode: not zero where the mode begins. */
static double shown_indicator(Motion *m, int k)
{
    const double *event = event_of(m, SB_EVENTS + k);
#if SB_ELEMENTS
    if (element_of(m, k)[SB_M_SHARES] != 0.0) return have_torn_shares(m) ? -1.0 : 1.0; /* no single value tells that */
#endif
    return m->indicators[SB_EVENTS + k] + (event[SB_E_SIDE] == 0.0 ? 2.0 * event[SB_E_BAND] : 0.0);
}

/* Let the events happen that were noted, or found by steps of our own; what they set holds. Returns one of the
   codes of `look`. */
static int happen(Motion *m)
{
    int code = m->found;
#if SB_WATCH_COUNT
    double *W = watch_of(m);
    renew_arguments(m);
    if (!m->is_alone)
        code = symbody_process_noted(
            ACTS, W, clock_of(m), m->x, SB_STRAIGHT * SB_TIME_SCALE, m->breaks, m->pieces, m->happened);
    else if (code == SB_GOES_ON)
        memcpy(m->x, W + (int)W[SB_W_AFTER], sizeof m->x);
    log_happened(m, clock_of(m));
    m->found = 0;
    if (code == SB_GOES_ON) {
        m->is_fresh = 1;
        m->valid = 0;
#if SB_ELEMENTS
        symbody_note_ends(SB_WATCHED_FUNCTION, switch_of(m), W, clock_of(m), m->x);
#endif
        if (W[SB_W_HAS_ACTED] != 0.0) m->has_modes = 0;
        W[SB_W_HAS_ACTED] = 0.0;
        if (!m->has_modes && has_overlap(m)) m->unmet = OVERLAP;
    }
#endif
    return code;
}

/* Do what follows at the events noted or found: new values of states, other modes. Returns whether values changed,
   -1 for a fault. */
static int act(Motion *m, int *must_stop)
{
    int code, changed;
    m->unmet = NOTHING_UNMET;
    code = happen(m);
    changed = code == SB_GOES_ON;
    *must_stop = code == SB_ENDS;
    if (code == SB_CHATTERS) m->unmet = CHATTERING;
    else if (code == SB_MISSES) m->unmet = OPEN_LOOP;
    else if (code == SB_SPOILS || code == SB_FAILS) m->unmet = NOT_A_NUMBER;
    if (m->unmet) return -1;
    if (have_ended(m)) {
        if (switch_modes(m) != SOLVED) return -1;
        changed = 1;
    }
    if (changed && (!m->is_alone || code == SB_GOES_ON)) look_at_sides(m); /* what jumps keeps the sides before */
    return changed;
}

/* Let events act whose value is zero and leaves zero in their direction; steps of our own begin so. Returns whether
   values changed, -1 for a fault. */
static int act_at_start(Motion *m)
{
    int changed = 0;
#if SB_WATCH_COUNT
    int must_stop;
    while (!m->is_alone) {
        renew_arguments(m);
        watch_of(m)[SB_W_FAULT] = 0.0;
        if (!symbody_note_start(WATCH, SB_ACTION_FUNCTION, watch_of(m), clock_of(m), m->x, SB_STRAIGHT * SB_TIME_SCALE))
            break;
        if (act(m, &must_stop) < 0) return -1;
        changed = 1;
    }
#else
    (void)m;
#endif
    return changed;
}
