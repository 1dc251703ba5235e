/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Results: what follows from the state. It is computed when it is needed, and kept until the state changes. */

static double *watch_of(Motion *m) { return m->pool + SB_WATCH; }

static double *event_of(Motion *m, int k)
{
    double *W = watch_of(m);
    return W + (int)W[SB_W_EVENTS] + k * SB_EVENT_SIZE;
}

/* The values of events, and of what ends modes. */
static int watch(Motion *m, double *x)
{
#if SB_WATCH_COUNT
    double *W = watch_of(m);
    renew_arguments(m);
    W[SB_W_FAULT] = 0.0;
    symbody_compute_values(SB_WATCHED_FUNCTION, W, clock_of(m), x);
    memcpy(m->indicators, W + (int)W[SB_W_VALUES], SB_WATCH_COUNT * sizeof(double));
    if (W[SB_W_FAULT] != 0.0) return UNSOLVED;
#else
    (void)m, (void)x;
#endif
    return SOLVED;
}

/* Compute what is not there yet. */
static int need(Motion *m, int what)
{
    renew_arguments(m);
    if (SB_CONDITIONS && m->mode != CONTINUOUS && !(m->valid & HAS_SIDES)) decide(m);
    if ((m->valid & what) == what) return SOLVED;
    if (what == HAS_SLOPE) {
        if (compute(m, &sb_functions[SB_SLOPE], m->x, m->slope) || !are_finite(m->slope, SB_X)) return UNSOLVED;
    } else if (what == HAS_OUTPUTS) {
        if (compute(m, &sb_functions[SB_OUTPUT], m->x, m->outputs)) return UNSOLVED;
    } else if (what == HAS_SLOPES) {
        if (SB_HAS_DERIVATIVES
            && (compute(m, &sb_functions[SB_DERIVATIVES], m->x, m->slopes)
                || compute(m, &sb_functions[SB_SENSITIVITIES], m->x, m->slopes + SB_X * (SB_X + SB_R))))
            return UNSOLVED;
    } else if (what == HAS_INDICATORS) {
        if (watch(m, m->x) != SOLVED) return UNSOLVED;
        if (SB_CONDITIONS && compute(m, &sb_functions[SB_SIDES], m->x, m->conditions)) return UNSOLVED;
    } else if (what == HAS_CALCULATED) {
        if (SB_CALCULATED && compute(m, &sb_functions[SB_PARAMETERS], m->x, m->calculated)) return UNSOLVED;
    }
    m->valid |= what;
    return SOLVED;
}

/* Whether a branch of a formula has ended: its condition is on another side than the one decided. */
static int have_conditions_changed(Motion *m)
{
    int k;
    if (!SB_CONDITIONS || need(m, HAS_INDICATORS) != SOLVED) return 0;
    for (k = 0; k < SB_CONDITIONS; k++)
        if (m->conditions[k] != 0.0 && decided_side(k, m->conditions[k]) != m->side_of_condition[k]) return 1;
    return 0;
}
