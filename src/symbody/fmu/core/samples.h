/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Held values: the last of the inputs that functions take, computed anew at their samples. */

static double *sampler_of(Motion *m) { return m->pool + SB_SAMPLER; }

/* Count samples from the first time on, with the sample times that parameters give; returns whether these are positive. */
static int begin_samples(Motion *m)
{
    double *Z = sampler_of(m), periods[SB_SAMPLED + 1];
    int k, groups = (int)Z[SB_Z_GROUPS];
    if (!SB_SAMPLED) return 1;
    if (compute(m, &sb_functions[SB_PERIODS], m->x, periods) != 0) return 0;
    for (k = 0; k < groups; k++) {
        if (!(periods[k] > 1e-13 * (fabs(m->time) + 1.0)) || !isfinite(periods[k])) return 0;
        Z[(int)Z[SB_Z_STEPS] + k] = periods[k];
        Z[(int)Z[SB_Z_TAKEN] + k] = 0.0;
    }
    Z[SB_Z_START] = m->time;
    symbody_find_next(Z);
    return 1;
}

static int is_sample_due(Motion *m) { return SB_SAMPLED && symbody_is_due(sampler_of(m), clock_of(m)); }

/* When the next sample is due. */
static double next_sample(Motion *m) { return SB_SAMPLED ? sampler_of(m)[SB_Z_NEXT] : HUGE_VAL; }

/* Take the samples that are due; returns how many instants that were, -1 for a fault. */
static int take_due(Motion *m)
{
    int count = 0;
    while (is_sample_due(m)) {
        double *Z = sampler_of(m), *values = Z + (int)Z[SB_Z_VALUES], row[SB_SAMPLED + 2];
        double *numbers = m->pool + sb_functions[SB_SAMPLING].numbers;
        renew_arguments(m);
        memcpy(values, m->r + SB_R - SB_SAMPLED, SB_SAMPLED * sizeof(double));
        Z[SB_Z_RECORDED] = 0.0;
        if (symbody_take_samples(SB_SAMPLE_FUNCTION, numbers, Z, row, clock_of(m), m->x) != 0) return -1;
        if (!are_finite(values, SB_SAMPLED)) return -1;
        memcpy(m->r + SB_R - SB_SAMPLED, values, SB_SAMPLED * sizeof(double));
        m->has_arguments = m->valid = 0;
        m->is_fresh = 1;
        count++;
    }
    return count;
}

/* Take the samples that are due, and let happen what follows from them: values that jump through zero, other
   modes. Returns whether values of states changed, -1 for a fault. */
static int sample(Motion *m, int *must_stop)
{
    if (!is_sample_due(m)) return 0;
    look_before(m);
    if (take_due(m) < 0) return -1;
    note_events(m);
    return act(m, must_stop);
}
