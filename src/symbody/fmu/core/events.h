/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Events: each watches a number that passes zero. The end of a mode is one, too: its number falls to zero. */

/* The side of what is watched. That of a mode has to become more than rounding before it can come to zero. */
static int side_of_watched(const Motion *m, int k, double value)
{
    if (k < SB_EVENTS) return side_of(value);
    return value > m->slight[k - SB_EVENTS] ? 1 : value < -m->slight[k - SB_EVENTS] ? -1 : 0;
}

/* Whether a value that was zero is so no more. Closing loops moves it a little. */
static int has_left(Motion *m, int k, double value)
{
    if (k >= SB_EVENTS) return 1;
    if (fabs(value) > m->largest[k]) m->largest[k] = fabs(value);
    return fabs(value) > (SB_PROJECTED ? 1e-6 * m->largest[k] : 0.0);
}

/* Whether an event has happened since a side. A value that is zero belongs to the side where it comes to. */
static int has_happened(const Motion *m, int k, double value)
{
    int before = m->side[k], now = side_of_watched(m, k, value);
    if (k >= SB_EVENTS) return before > 0 ? value <= 0.0 : now < 0;
    return (before > 0 && now <= 0 && sb_directions[k] <= 0) || (before < 0 && now >= 0 && sb_directions[k] >= 0);
}

/* What a start remembers of an event. */
static double *start_of(Motion *m, int k)
{
    double *W = m->pool + SB_WATCH;
    return W + (int)W[SB_W_EVENTS] + k * SB_EVENT_SIZE;
}

/* Note which events have happened since the side of each was looked at; return whether any has. */
static int note_events(Motion *m)
{
    int k, any = 0;
    if (!(SB_EVENTS + SB_ELEMENTS) || need(m, HAS_INDICATORS) != SOLVED) return 0;
    for (k = 0; k < SB_EVENTS + SB_ELEMENTS; k++) {
        double value = m->indicators[k];
        int now = side_of_watched(m, k, value), before = m->side[k];
        int has_passed = (before > 0 && now <= 0) || (before < 0 && now >= 0);
        if (has_happened(m, k, value)) {
            m->pending[k] = any = 1;
            if (SB_ACTIONS && k < SB_EVENTS) start_of(m, k)[SB_E_CAME] = -before;
        }
        if (now != 0 && (before != 0 || has_left(m, k, value))) m->side[k] = now;
        else if (has_passed && k < SB_EVENTS) m->side[k] = 0;
    }
    return any;
}

static void look_at_sides(Motion *m)
{
    int k;
    if (!(SB_EVENTS + SB_ELEMENTS) || need(m, HAS_INDICATORS) != SOLVED) return;
    for (k = 0; k < SB_EVENTS + SB_ELEMENTS; k++)
        m->side[k] = has_left(m, k, m->indicators[k]) ? side_of_watched(m, k, m->indicators[k]) : 0;
}

/* What an importer watches of a mode: not zero where the mode begins. */
static double shown_indicator(const Motion *m, int k)
{
    return m->indicators[SB_EVENTS + k] + (m->side[SB_EVENTS + k] == 0 ? 2.0 * m->slight[k] : 0.0);
}

/* Whether an event has been noted that sets values. */
static int is_acting(const Motion *m, int k)
{
    int j;
    for (j = 0; j < SB_ACTIONS; j++)
        if (m->pending[k] && sb_action_events[j] == k) return 1;
    return 0;
}

/* Set what the events noted set, one after the other. What they set holds; joints that stick and ropes hold nothing
   meanwhile. Returns whether values changed, -1 for a fault. */
static int set_states(Motion *m)
{
    int k, j, changed = 0;
    m->unmet = NOTHING_UNMET;
    for (k = 0; k < SB_EVENTS; k++) {
        int is_set[SB_X + 1] = {0};
        double actions[SB_ACTIONS + 1];
        if (!is_acting(m, k)) continue;
        if (!changed) {
            project_state(m); /* what drifts stays as it is where it cannot be closed */
            release(m);
        }
        if (compute(m, &sb_functions[SB_ACTION], m->x, actions)) return -1;
        note_before(m);
        for (j = 0; j < SB_ACTIONS; j++)
            if (sb_action_events[j] == k) {
                m->x[sb_action_states[j]] = actions[j];
                is_set[sb_action_states[j]] = 1;
            }
        m->valid = 0;
        m->is_fresh = changed = 1;
        if (close_held(m, is_set) != SOLVED) m->unmet = OPEN_LOOP;
        if (m->unmet) return -1;
    }
    if (changed && has_long_rope(m)) m->unmet = LONG_ROPE;
    return m->unmet ? -1 : changed;
}

/* Judge what actions did; returns -1 where one turned nothing that it could have turned. */
static int judge_actions(Motion *m)
{
#if SB_ACTIONS
    int k;
    for (k = 0; k < SB_EVENTS; k++) {
        if (!is_acting(m, k)) continue;
        if (m->largest[k] > start_of(m, k)[SB_E_LARGEST]) start_of(m, k)[SB_E_LARGEST] = m->largest[k];
        renew_arguments(m);
        if (symbody_end_action(SB_WATCHED_FUNCTION, mechanism_motion, m->pool + SB_WATCH, k, clock_of(m), m->x,
                SB_STRAIGHT * SB_TIME_SCALE)) {
            m->unturned = k + 1;
            return -1;
        }
    }
#else
    (void)m;
#endif
    return 1;
}

/* Do what follows at the events noted: new values of states, other modes. Returns whether values changed, -1 for
   a fault. */
static int act(Motion *m, int *must_stop)
{
    int k, changed;
    *must_stop = 0;
    for (k = 0; k < SB_EVENTS + SB_ELEMENTS; k++) {
        if (!m->pending[k]) continue;
        if (k < SB_EVENTS && sb_stops[k]) *must_stop = 1;
        if (m->happened_count < SB_KEPT) {
            m->happened[m->happened_count] = k;
            m->happened_at[m->happened_count++] = m->time;
        }
    }
    changed = set_states(m);
    if (changed >= 0 && have_ended(m)) changed = switch_modes(m) == SOLVED ? 1 : -1;
    if (changed > 0) {
        look_at_sides(m); /* a map leaves what it acts on where it is, up to rounding */
        changed = judge_actions(m);
    }
    memset(m->pending, 0, sizeof m->pending);
    return changed;
}

/* Let events act whose value is zero and leaves zero in their direction. Returns whether values changed, -1 for a
   fault. */
static int act_at_start(Motion *m)
{
    int changed = 0;
#if SB_ACTIONS
    int round, must_stop;
    for (round = 0; round <= SB_MOST_ROUNDS; round++) {
        int k;
        renew_arguments(m);
        k = symbody_starting_event(SB_WATCHED_FUNCTION, mechanism_motion, m->pool + SB_WATCH, clock_of(m), m->x,
                SB_STRAIGHT * SB_TIME_SCALE);
        if (k == 0) return changed;
        m->unturned = round == SB_MOST_ROUNDS ? k : 0;
        if (m->unturned) return -1;
        m->pending[k - 1] = changed = 1;
        if (act(m, &must_stop) < 0) return -1;
    }
#else
    (void)m;
#endif
    return changed;
}
