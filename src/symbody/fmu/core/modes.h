/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Modes: joints stick or slip, ropes are taut or slack. Each element has a number that is positive while its mode
   lasts; where one ends, the kernel `settle_modes` decides. Its `ModeSwitch` holds the modes. */

#define LONGEST 1e-7 /* of its length: a rope that drifts or overshoots is not longer by more */

#if SB_ELEMENTS
static double *switch_of(Motion *m) { return m->pool + SB_SWITCH; }
static double *element_of(Motion *m, int k)
{
    double *S = switch_of(m);
    return S + (int)S[SB_S_ELEMENTS] + k * SB_ELEMENT_SIZE;
}

/* Let modes so far not matter any more: the state is another. */
static void forget_modes(Motion *m) { symbody_forget_modes(switch_of(m)); }

/* What holds until modes are known: nothing is held. */
static void release(Motion *m)
{
    int k;
    forget_modes(m);
    for (k = 0; k < SB_ELEMENTS; k++) element_of(m, k)[SB_M_MODE] = 1.0;
    m->has_modes = m->has_arguments = 0;
}

/* What ends modes: behind the values of events, those of modes. */
static int watch(Motion *m, const double *x, double *values)
{
    int k, status = SB_EVENTS ? compute(m, &sb_functions[SB_INDICATORS], x, values) : 0;
    if (status == 0) status = compute(m, &sb_functions[SB_ENDS], x, values + SB_EVENTS);
    for (k = 0; k < SB_ELEMENTS && status == 0; k++) values[SB_EVENTS + k] -= element_of(m, k)[SB_M_LEVEL];
    return status;
}

/* How fast the mechanism has been. */
static void note_rates(Motion *m) { symbody_note_rates(switch_of(m), m->x); }

/* Whether a state that was set has a rope that is longer than it can be. */
static int has_long_rope(Motion *m)
{
    renew_arguments(m);
    return symbody_find_long_rope(mechanism_deciding, switch_of(m), clock_of(m), m->x) != 0;
}

/* The same of a state to which the motion has come: ropes that were taut are not. */
static int has_torn_rope(Motion *m)
{
    int k;
    if (!has_long_rope(m)) return 0;
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = element_of(m, k);
        int was_taut = e[SB_M_BEFORE] != 0.0 && e[SB_M_MODE] == 0.0;
        if (e[SB_M_IS_ROPE] != 0.0 && !was_taut && e[SB_M_SLACKNESS] < -LONGEST * e[SB_M_LENGTH]) return 1;
    }
    return 0;
}

/* Find the modes in which the motion goes on; returns whether there are any. */
static int switch_modes(Motion *m)
{
    double *S = switch_of(m), x[SB_X + 1], rows[2 * (3 + SB_ELEMENTS + SB_X + 1)];
    int k, code;
    if (has_torn_rope(m)) return NOT_CLOSED;
    memcpy(x, m->x, SB_X * sizeof(double));
    x[SB_X] = S[SB_S_RECORDED] = 0.0; /* the work that shocks do, which is of no interest here */
    renew_arguments(m);
    code = symbody_settle_modes(mechanism_deciding, SB_PROJECTION, S, rows, clock_of(m), x);
    m->valid = m->has_arguments = 0;
    if (code != SB_SETTLED || !are_finite(x, SB_X)) return UNSOLVED;
    memcpy(m->x, x, SB_X * sizeof(double));
    for (k = 0; k < SB_ELEMENTS; k++) m->slight[k] = symbody_slight_value(S, k);
    m->has_modes = m->is_fresh = 1;
    return SOLVED;
}

/* Mark the modes that have ended: by an event, or since inputs or parameters jumped. Returns whether modes are to be
   decided. */
static int have_ended(Motion *m)
{
    double values[SB_EVENTS + SB_ELEMENTS + 1];
    int k, any = !m->has_modes || watch(m, m->x, values) != 0;
    for (k = 0; k < SB_ELEMENTS; k++) {
        int ended = m->pending[SB_EVENTS + k];
        element_of(m, k)[SB_M_ENDED] = ended;
        any = any || ended || !(values[SB_EVENTS + k] >= -m->slight[k]);
    }
    return any;
}
#else
static void forget_modes(Motion *m) { (void)m; }
static void release(Motion *m) { (void)m; }
static void note_rates(Motion *m) { (void)m; }
static int has_long_rope(Motion *m) { return (void)m, 0; }
static int switch_modes(Motion *m) { return (void)m, SOLVED; }
static int have_ended(Motion *m) { return (void)m, 0; }
static int watch(Motion *m, const double *x, double *values)
{
    return SB_EVENTS ? compute(m, &sb_functions[SB_INDICATORS], x, values) : 0;
}
#endif
