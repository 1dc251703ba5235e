/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* The motion of one instance: its state, what follows from it, assembly, events and steps.

   `model.h`, written for each mechanism, defines the kernels `symbody_*`, the functions of the mechanism, the
   sizes SB_* and the tables sb_*. All that an instance is stands in one `Motion`, so that a copy of it is a copy
   of the instance; there is no static data but constants. */

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, STEP = 16, TERMINATED = 32 };
enum { HAS_SLOPE = 1, HAS_OUTPUTS = 2, HAS_INDICATORS = 4, HAS_CALCULATED = 8, HAS_SLOPES = 16, HAS_SIDES = 32 };
enum { SOLVED, UNSOLVED, NOT_CLOSED };
enum { NOTHING_UNMET, OPEN_LOOP, OVERLAP, TORN_MOTION, NO_SPEEDS, UNKNOWN_RATES, NOT_A_NUMBER, CHATTERING };
#define SB_N (SB_X + 1)     /* states of kernels: the work is the last one */
#define SB_WATCH_COUNT (SB_EVENTS + SB_ELEMENTS)
#define SB_STRAIGHT 1e-3    /* of the mechanism's time: in which rates decide where values go */

typedef struct {
    int mode, valid, code;
    int is_alone;         /* in co-simulation */
    int is_settled;       /* the state fulfils the constraints with the values that were set */
    int has_arguments;    /* parameters and inputs stand in the numbers of all functions */
    int is_fresh;         /* the integrator has to begin at x */
    int has_stopped;      /* an event ended the motion */
    int unmet;            /* what does not admit what an action sets, or what rates do at a jump */
    int strikes, ends_jumps; /* whether prescribed rates jump at the next jump; whether they are known up to there */
    int found;            /* what `look` found ahead, as it calls it */
    int logged;           /* so many of the events that happened are logged */
    int must_project;     /* the state is to be brought back onto the constraints in event mode */
    int has_modes; /* see modes.h */
    double time, stop;
    double jump, jump_margin, past_jump; /* next jump of what depends on time alone; behind the last one */
    double width;         /* of the instant behind which steps begin */
    double x[SB_N], settled_x[SB_N];
    double r[SB_R + 1];
    double p[SB_P + 1], settled_p[SB_P + 1];
    double side_of_condition[SB_CONDITIONS + 1]; /* which branches are taken in model exchange */
    double slope[SB_N], outputs[SB_OUTPUTS + 1], calculated[SB_CALCULATED + 1];
    double indicators[SB_WATCH_COUNT + 1], conditions[SB_CONDITIONS + 1];
    double slopes[SB_SLOPES + 1];
    double breaks[SB_STEPS + 2], pieces[(SB_STEPS + 1) * SB_DENSE_ROWS * SB_N]; /* the steps at hand */
    double happened[SB_HAPPENED * (SB_N + 2)]; /* events that are not yet logged: place, time, state */
    double pool[SB_POOL];
} Motion;

/* Write parameters, inputs and modes to the numbers of a function, and what follows from parameters alone. */
static void write_arguments(Motion *m, const SbFunction *f)
{
    static const double none[1] = {0.0};
    double *numbers = m->pool + f->numbers;
    double *p = numbers + (int)numbers[SB_NUMBERS_PARAMETERS], *c = numbers + (int)numbers[SB_NUMBERS_CONSTANTS];
    memcpy(numbers + (int)numbers[SB_NUMBERS_INPUTS], m->r, SB_R * sizeof(double));
    memcpy(p, m->p, SB_P * sizeof(double));
#if SB_ELEMENTS
    if ((int)numbers[SB_NUMBERS_INPUT_COUNT] > SB_R) symbody_show_modes(m->pool + SB_SWITCH, numbers);
#endif
    memcpy(p + SB_P, m->side_of_condition, SB_CONDITIONS * sizeof(double));
    if (f->values) f->values(none, none, none, none, p, c, c, m->pool + SB_SCRATCH);
}

static void renew_arguments(Motion *m)
{
    int k;
    if (m->has_arguments) return;
    for (k = 0; k < SB_FUNCTIONS; k++) write_arguments(m, &sb_functions[k]);
    m->has_arguments = 1;
    m->valid = 0;
}

/* The time at which functions are evaluated: on the side of a jump where the motion is. */
static double clock_of(const Motion *m)
{
    if (m->time >= m->jump) return m->jump - m->jump_margin;
    return m->time < m->past_jump ? m->past_jump : m->time;
}

static int compute(Motion *m, const SbFunction *f, const double *x, double *out)
{
    renew_arguments(m);
    return symbody_call(f->call, SB_U, m->pool + f->numbers, clock_of(m), x, out);
}

static int are_finite(const double *values, int count)
{
    int k;
    for (k = 0; k < count; k++)
        if (!isfinite(values[k])) return 0;
    return 1;
}

static void begin_motion(Motion *m)
{
    int k;
    memset(m, 0, sizeof *m);
    for (k = 0; k < SB_PLACES; k++) m->pool[sb_places[k]] = sb_values[k];
    memcpy(m->x, sb_x, SB_X * sizeof(double));
    memcpy(m->settled_x, sb_x, SB_X * sizeof(double));
    memcpy(m->r + SB_R - SB_SAMPLED, m->pool + SB_SAMPLER + (int)m->pool[SB_SAMPLER + SB_Z_VALUES],
        SB_SAMPLED * sizeof(double));
    memcpy(m->p, sb_p, SB_P * sizeof(double));
    memcpy(m->settled_p, sb_p, SB_P * sizeof(double));
    m->stop = m->jump = HUGE_VAL;
    m->past_jump = -HUGE_VAL;
    m->is_fresh = m->is_settled = 1;
}

/* Closing: constraints hold with the values that were set; what was not set follows. */

/* What closing has to know of the state before it changes. */
static void note_before(Motion *m)
{
    if (!SB_IS_CLOSED) return;
    renew_arguments(m);
    symbody_note_followers(SB_ASSEMBLY_FUNCTION, m->pool + SB_ASSEMBLY, clock_of(m), m->x);
}

static int close_held(Motion *m, const int *is_held)
{
    int i;
    if (SB_IS_CLOSED) {
        double *A = m->pool + SB_ASSEMBLY;
        for (i = 0; i < SB_U + SB_Q; i++) A[(int)A[SB_HELD] + i] = is_held[i] ? 1.0 : 0.0;
        renew_arguments(m);
        if (symbody_close_state(SB_ASSEMBLY_FUNCTION, A, clock_of(m), m->x) != 0) return NOT_CLOSED;
    }
    return SOLVED;
}

static int try_assembly(Motion *m, const double *x, const double *p, const int *is_given, int parts)
{
    int i, k;
    for (k = 1; k <= parts; k++) {
        double share = (double)k / parts;
        for (i = 0; i < SB_P; i++) m->p[i] = k == parts ? p[i] : m->settled_p[i] + share * (p[i] - m->settled_p[i]);
        m->has_arguments = 0;
        renew_arguments(m);
        for (i = 0; i < SB_X; i++)
            if (is_given[i]) m->x[i] = k == parts ? x[i] : m->settled_x[i] + share * (x[i] - m->settled_x[i]);
        if (SB_IS_CLOSED) {
            int is_held[SB_N];
            for (i = 0; i < SB_X; i++) is_held[i] = is_given[i] && sb_is_held[i];
            if (close_held(m, is_held) != SOLVED) return 0;
        }
    }
    for (i = 0; i < SB_X; i++)
        if (!isfinite(m->x[i])) return 0;
    return 1;
}

/* The motion has come here: what is set from now on starts from this state. */
static void keep_settled(Motion *m)
{
    memcpy(m->settled_x, m->x, sizeof m->x);
    memcpy(m->settled_p, m->p, sizeof m->p);
}

/* Bring the state onto the constraints; `is_given` marks states whose values were set. */
static int settle(Motion *m, const int *is_given)
{
    static const int parts[] = {1, 12};
    double x[SB_N], p[SB_P + 1];
    int i, k;
    if (m->is_settled) return SOLVED;
    memcpy(x, m->x, sizeof x);
    memcpy(p, m->p, sizeof p);
    for (k = 0; k < 2; k++) {
        memcpy(m->x, m->settled_x, sizeof x);
        memcpy(m->p, m->settled_p, sizeof p);
        m->has_arguments = 0;
        note_before(m);
        for (i = 0; i < SB_X; i++) m->x[i] = is_given[i] ? x[i] : m->settled_x[i];
        if (try_assembly(m, x, p, is_given, parts[k])) {
            keep_settled(m);
            m->is_settled = m->is_fresh = 1;
            m->valid = 0;
            return SOLVED;
        }
    }
    memcpy(m->x, x, sizeof x);
    memcpy(m->p, p, sizeof p);
    m->has_arguments = 0;
    return NOT_CLOSED;
}

/* The same in the course of a motion: no state is given, each follows from where it is. */
static int settle_anew(Motion *m)
{
    static const int none[SB_N] = {0};
    memcpy(m->settled_x, m->x, sizeof m->x);
    return settle(m, none);
}

/* The largest position constraint over its size. */
static double violation(const double *outputs)
{
    double worst = 0.0;
    int k;
    for (k = 0; k < SB_CONSTRAINTS; k++) {
        double size = fabs(outputs[k]) / sb_scales[k];
        if (!(size <= worst)) worst = size;
    }
    return worst;
}

static int project_place(Motion *m, double *x)
{
    if (!SB_PROJECTED) return SOLVED;
    renew_arguments(m);
    return isfinite(symbody_project(SB_PROJECTION, m->pool + SB_BLOCK, clock_of(m), x)) ? SOLVED : NOT_CLOSED;
}

static int project_state(Motion *m)
{
    if (project_place(m, m->x) != SOLVED) return NOT_CLOSED;
    if (SB_PROJECTED) m->valid = 0;
    return SOLVED;
}

/* Whether the constraints, norms of quaternions among them, are open by more than the limit. */
static int is_open(Motion *m)
{
    if (SB_PROJECTED) {
        double *P = m->pool + SB_BLOCK + (int)m->pool[SB_BLOCK + SB_RUN_PROJECTION];
        double *out = P + (int)P[SB_PROJECTOR_OUT];
        int k, count = (int)P[SB_PROJECTOR_RESIDUALS];
        renew_arguments(m);
        if (symbody_call(SB_PROJECTION, SB_U, P + (int)P[SB_PROJECTOR_NUMBERS], clock_of(m), m->x, out) != 0) return 0;
        for (k = 0; k < count; k++)
            if (fabs(out[k]) / P[(int)P[SB_PROJECTOR_SCALES] + k] * SB_CLOSED > SB_OPEN) return 1;
    }
    return 0;
}
