/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Modes: joints stick or slip, ropes are taut or slack, stops closed or open. Each element has a number that is positive while its mode
   lasts; where one ends, the kernel `settle_modes` decides. Its `ModeSwitch` holds the modes. */

#define LONGEST 1e-7 /* of its size: a gap that drifts or overshoots is not negative by more */

/* The impact of ropes and stops that a row of the record of modes holds. */
static void log_shock(Motion *m, const double *row);

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

/* How fast the mechanism has been. */
static void note_rates(Motion *m, const double *x) { symbody_note_rates(switch_of(m), (double *)x); }

/* Whether a state that was set has a negative gap. */
static int has_overlap(Motion *m)
{
    renew_arguments(m);
    return symbody_find_overlap(symbody_mechanism_deciding, switch_of(m), clock_of(m), m->x) != 0;
}

/* The same of a state to which the motion has come: gaps that were closed are not. */
static int has_new_overlap(Motion *m)
{
    int k;
    if (!has_overlap(m)) return 0;
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = element_of(m, k);
        int was_closed = e[SB_M_BEFORE] != 0.0 && e[SB_M_MODE] == 0.0;
        if (e[SB_M_IS_GAP] != 0.0 && !was_closed && e[SB_M_WIDTH] < -LONGEST * e[SB_M_LENGTH]) return 1;
    }
    return 0;
}

/* Find the modes in which the motion goes on; returns whether there are any. */
static int switch_modes(Motion *m)
{
    double *S = switch_of(m), x[SB_N], rows[2 * (3 + SB_ELEMENTS + SB_N)];
    int k, code;
    if (has_new_overlap(m)) return NOT_CLOSED;
    memcpy(x, m->x, sizeof x);
    S[SB_S_RECORDED] = 0.0;
    renew_arguments(m);
    code = symbody_settle_modes(symbody_mechanism_deciding, SB_PROJECTION, S, rows, clock_of(m), x);
    m->valid = m->has_arguments = 0;
    if (code != SB_SETTLED || !are_finite(x, SB_N)) return UNSOLVED;
    memcpy(m->x, x, sizeof x);
    for (k = 0; k < (int)S[SB_S_RECORDED]; k++)
        if (rows[k * (3 + SB_ELEMENTS + SB_N)] == SB_SHOCK) log_shock(m, rows + k * (3 + SB_ELEMENTS + SB_N));
    for (k = 0; k < SB_ELEMENTS; k++) {
        event_of(m, SB_EVENTS + k)[SB_E_BAND] = symbody_slight_value(S, k);
        event_of(m, SB_EVENTS + k)[SB_E_LEVEL] = element_of(m, k)[SB_M_LEVEL];
    }
    symbody_forget_ends(S, watch_of(m));
    watch_of(m)[SB_W_RATE_KNOWN] = 0.0;
    m->has_modes = m->is_fresh = 1;
    return SOLVED;
}

/* Whether elements share the efforts with which they hold, and no shares are within their bounds any more. */
static int have_torn_shares(Motion *m)
{
    double *S = switch_of(m);
    if (!m->has_modes || S[SB_S_SHARES] == 0.0) return 0;
    renew_arguments(m);
    return !symbody_shares_hold(symbody_mechanism_deciding, S, clock_of(m), m->x);
}

/* Whether modes are to be decided: one has ended, at an event or since inputs or parameters jumped. */
static int have_ended(Motion *m)
{
    int k, any = !m->has_modes;
    m->valid &= ~HAS_INDICATORS;
    if (any || have_torn_shares(m) || need(m, HAS_INDICATORS) != SOLVED) return 1;
    for (k = 0; k < SB_ELEMENTS; k++) {
        any |= element_of(m, k)[SB_M_ENDED] != 0.0;
        if (element_of(m, k)[SB_M_SHARES] == 0.0) any |= !(m->indicators[SB_EVENTS + k] >= -symbody_slight_value(switch_of(m), k));
    }
    return any;
}
#else
static void forget_modes(Motion *m) { (void)m; }
static void release(Motion *m) { (void)m; }
static void note_rates(Motion *m, const double *x) { (void)m, (void)x; }
static int has_overlap(Motion *m) { return (void)m, 0; }
static int switch_modes(Motion *m) { return (void)m, SOLVED; }
static int have_torn_shares(Motion *m) { return (void)m, 0; }
static int have_ended(Motion *m) { return (void)m, 0; }
#endif
