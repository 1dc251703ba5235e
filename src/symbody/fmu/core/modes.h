/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Modes: joints stick or slip, ropes are taut or slack. Each element has a number that is positive while its mode
   lasts. Where one ends, modes are looked for in which all that they assume holds. */

enum { SLACKNESS, RATE, LENGTH, FORCE, ACCELERATION, LIMIT, MEASURES };
#define BALANCED 1e-9  /* loads that differ by less of the limit are equal */
#define CANCELLED 1e-12 /* rounding of a sum, over its terms */
#define AT_LENGTH 2e-9 /* a rope that is closer to its length, over it, is taut */
#define AT_REST 1e-9   /* of the largest rates so far */
#define SLOW 1e6       /* ends of a rope that approach so many times faster than at rest do not come back at once */
#define MOST_TRIED 81

typedef struct {
    int modes[SB_ELEMENTS + 1];
    double x[SB_X + 1], e[MEASURES * SB_ELEMENTS + 1];
} Trial;

typedef struct {
    int count, modes[3];
    int is_open; /* no event decided between them */
} Candidates;

/* Joints: the sign of slip, 0 while they stick. Ropes: 1 while they are taut. */
static void set_modes(Motion *m, const int *modes)
{
    int k;
    double *argument = m->modes;
    for (k = 0; k < SB_ELEMENTS; k++) {
        m->mode_of[k] = modes[k];
        *argument++ = modes[k];
        if (!sb_is_rope[k]) *argument++ = modes[k] == 0;
    }
    m->has_arguments = 0;
}

/* What holds until modes are known: nothing is held. */
static void release(Motion *m)
{
    memset(m->modes, 0, sizeof m->modes);
    memset(m->mode_of, 0, sizeof m->mode_of);
    m->has_modes = m->has_arguments = 0;
}

static void measure(Motion *m, const double *x, double *e)
{
    int i;
    if (SB_ELEMENTS && compute(m, &sb_functions[SB_MEASURES], x, e) != 0)
        for (i = 0; i < MEASURES * SB_ELEMENTS; i++) e[i] = NAN;
}

/* The tension that is rounding. */
static double slight_tension(const double *e) { return CANCELLED * SB_MASS_SCALE * e[LIMIT]; }

static double mode_indicator(const Motion *m, int k, const double *e)
{
    if (sb_is_rope[k]) return m->mode_of[k] ? e[FORCE] - slight_tension(e) : e[SLACKNESS] - m->level[k];
    return m->mode_of[k] ? m->mode_of[k] * e[RATE] : e[LIMIT] - fabs(e[FORCE]);
}

/* What is watched: values of events, then of modes. */
static int watch(Motion *m, const double *x, double *values)
{
    double e[MEASURES * SB_ELEMENTS + 1];
    int k, status = SB_EVENTS ? compute(m, &sb_functions[SB_INDICATORS], x, values) : 0;
    measure(m, x, e);
    for (k = 0; k < SB_ELEMENTS; k++) values[SB_EVENTS + k] = mode_indicator(m, k, e + MEASURES * k);
    return status;
}

/* How fast the mechanism has been, in its size a second. */
static void note_rates(Motion *m)
{
    int k;
    if (m->fastest < 1.0 / SB_TIME_SCALE) m->fastest = 1.0 / SB_TIME_SCALE;
    for (k = 0; k < SB_U; k++) {
        double rate = fabs(m->x[k]) / (sb_nominal[k] * SB_TIME_SCALE);
        if (rate > m->fastest) m->fastest = rate;
    }
}

static int has_long_rope(Motion *m)
{
    double e[MEASURES * SB_ELEMENTS + 1];
    int k;
    measure(m, m->x, e);
    for (k = 0; k < SB_ELEMENTS; k++)
        if (sb_is_rope[k] && e[MEASURES * k + SLACKNESS] < -AT_LENGTH * e[MEASURES * k + LENGTH]) return 1;
    return 0;
}

static double slow_rate(const Motion *m, int k) { return AT_REST * m->fastest * sb_rate_scales[k]; }

/* Give a state speeds that fit the rows that hold. */
static void fit_speeds(Motion *m, double *x)
{
    if (SB_PROJECTED) {
        double *P = m->pool + SB_BLOCK + (int)m->pool[SB_BLOCK + SB_RUN_PROJECTION], *out = P + (int)P[SB_PROJECTOR_OUT];
        int k, first = (int)P[SB_PROJECTOR_OUT_SIZE] - SB_U;
        renew_arguments(m);
        if (symbody_call(SB_PROJECTION, SB_U, P + (int)P[SB_PROJECTOR_NUMBERS], clock_of(m), x, out) != 0) return;
        for (k = 0; k < SB_U; k++) x[k] += out[first + k];
    }
}

static void try_modes(Motion *m, const int *modes, Trial *trial)
{
    memcpy(trial->modes, modes, sizeof trial->modes);
    memcpy(trial->x, m->x, sizeof trial->x);
    set_modes(m, modes);
    fit_speeds(m, trial->x);
    measure(m, trial->x, trial->e);
}

/* The acceleration of one element in another mode. */
static double other_acceleration(Motion *m, const Trial *trial, int k, int mode)
{
    Trial other;
    int modes[SB_ELEMENTS + 1];
    memcpy(modes, trial->modes, sizeof modes);
    modes[k] = mode;
    try_modes(m, modes, &other);
    set_modes(m, trial->modes);
    return other.e[MEASURES * k + ACCELERATION];
}

static int joint_holds(Motion *m, const Trial *trial, int k, int is_open)
{
    const double *e = trial->e + MEASURES * k;
    int mode = trial->modes[k];
    if (!isfinite(e[FORCE]) || !isfinite(e[ACCELERATION]) || !isfinite(e[LIMIT])) return 0;
    if (mode == 0) return e[LIMIT] - fabs(e[FORCE]) >= -BALANCED * e[LIMIT];
    if (!is_open || e[ACCELERATION] * mode >= 0.0) return 1;
    /* at the limit itself nothing accelerates yet: rounding, beside what the other direction would do */
    return fabs(e[ACCELERATION]) <= BALANCED * fabs(other_acceleration(m, trial, k, -mode));
}

static int rope_holds(Motion *m, const Trial *trial, int k, int is_open, double approach, const double *now)
{
    const double *e = trial->e + MEASURES * k;
    int departs = approach > slow_rate(m, k);
    if (trial->modes[k]) {
        double back;
        int pulls = e[FORCE] >= -BALANCED / CANCELLED * slight_tension(e);
        if (!(pulls && departs)) return pulls;
        back = -other_acceleration(m, trial, k, 0); /* taut again before its ends have measurably approached */
        return approach * approach <= 2.0 * back * AT_LENGTH * now[LENGTH];
    }
    return !is_open || departs || e[ACCELERATION] >= -BALANCED * e[LIMIT];
}

/* What each element may do, the likeliest first; `ended` marks those whose mode has ended. */
static void find_candidates(Motion *m, const int *ended, const double *now, const double *loaded, Candidates *some)
{
    int k;
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = now + MEASURES * k;
        int before = m->mode_of[k], was = m->has_modes, is_forced = was && ended[k] && (sb_is_rope[k] ? before : !before);
        Candidates *c = &some[k];
        c->is_open = !is_forced;
        if (sb_is_rope[k]) {
            int was_taut = was && before, is_tight = was_taut || e[SLACKNESS] <= AT_LENGTH * e[LENGTH];
            double approach = was_taut ? 0.0 : e[RATE];
            c->count = is_forced || !is_tight || approach > SLOW * slow_rate(m, k) ? 1 : 2;
            c->modes[0] = c->count == 2;
            c->modes[1] = 0;
        } else if (is_forced) {
            c->modes[0] = loaded[MEASURES * k + FORCE] > 0.0 ? -1 : 1;
            c->modes[1] = -c->modes[0];
            c->count = 2;
        } else if (fabs(e[RATE]) > slow_rate(m, k) && !(was && ended[k] && before * e[RATE] <= 0.0)) {
            c->modes[0] = e[RATE] > 0.0 ? 1 : -1;
            c->count = 1;
        } else {
            c->modes[0] = 0;
            c->modes[1] = 1;
            c->modes[2] = -1;
            c->count = 3;
        }
        c->is_open = c->is_open && c->count > 1;
    }
}

static int all_hold(Motion *m, const Trial *trial, const Candidates *some, const double *now, const int *were_taut)
{
    int k;
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = now + MEASURES * k;
        if (sb_is_rope[k] ? !rope_holds(m, trial, k, some[k].is_open, were_taut[k] ? 0.0 : e[RATE], e)
                          : !joint_holds(m, trial, k, some[k].is_open))
            return 0;
    }
    return 1;
}

/* By how much an element is loaded beyond what its mode can bear. */
static double excess(const Trial *trial, int k)
{
    const double *e = trial->e + MEASURES * k;
    if (sb_is_rope[k]) return trial->modes[k] ? -e[FORCE] : -HUGE_VAL;
    return trial->modes[k] == 0 ? fabs(e[FORCE]) - e[LIMIT] : -HUGE_VAL;
}

/* Free one element after the other, the most overloaded first: that often frees or loads the others. */
static void relieve(Motion *m, const Candidates *some, Trial *trial)
{
    int turn, k, modes[SB_ELEMENTS + 1];
    for (k = 0; k < SB_ELEMENTS; k++) modes[k] = some[k].modes[0];
    for (turn = 0;; turn++) {
        int worst = -1;
        double most = 0.0;
        try_modes(m, modes, trial);
        for (k = 0; k < SB_ELEMENTS && turn < SB_ELEMENTS; k++)
            if (some[k].count > 1 && excess(trial, k) > most) {
                most = excess(trial, k);
                worst = k;
            }
        if (worst < 0) return;
        modes[worst] = sb_is_rope[worst] ? 0 : trial->e[MEASURES * worst + FORCE] > 0.0 ? -1 : 1;
    }
}

/* Try all combinations in turn; returns whether `trial` is one that holds. */
static int search(Motion *m, const Candidates *some, const double *now, const int *were_taut, Trial *trial)
{
    int k, count, place[SB_ELEMENTS + 1] = {0}, modes[SB_ELEMENTS + 1];
    relieve(m, some, trial);
    if (all_hold(m, trial, some, now, were_taut)) return 1;
    for (count = 0; count < MOST_TRIED; count++) {
        for (k = 0; k < SB_ELEMENTS; k++) modes[k] = some[k].modes[place[k]];
        try_modes(m, modes, trial);
        if (all_hold(m, trial, some, now, were_taut)) return 1;
        for (k = SB_ELEMENTS - 1; k >= 0 && ++place[k] == some[k].count; k--) place[k] = 0;
        if (k < 0) return 0;
    }
    return 0;
}

/* The kinetic energy of a change of speeds, twice. */
static double energy_of_change(Motion *m, const double *x)
{
    double mass[SB_U * SB_U + 1], total = 0.0;
    int i, k;
    if (SB_MASS && compute(m, &sb_functions[SB_MASS], m->x, mass) != 0) return HUGE_VAL;
    for (i = 0; i < SB_U; i++)
        for (k = 0; k < SB_U; k++) total += (x[i] - m->x[i]) * mass[SB_U * i + k] * (x[k] - m->x[k]);
    return total;
}

/* Where ends of ropes at their length move apart the speeds jump: of all at which they do not, to those from which
   the change has the least kinetic energy [Moreau 1988]. Returns whether there was a shock, -1 without speeds. */
static int strike(Motion *m, const double *now, const int *were_taut)
{
    int k, some, ropes = 0, is_struck = 0, rope[SB_ELEMENTS + 1], modes[SB_ELEMENTS + 1] = {0};
    double largest = 0.0, least = HUGE_VAL, best[SB_X + 1];
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = now + MEASURES * k;
        if (!sb_is_rope[k]) continue;
        if (fabs(e[RATE]) > largest) largest = fabs(e[RATE]);
        if (!were_taut[k] && !(e[SLACKNESS] <= AT_LENGTH * e[LENGTH])) continue;
        rope[ropes++] = k;
        if (!were_taut[k] && e[RATE] < -slow_rate(m, k)) is_struck = 1;
    }
    if (!is_struck) return 0;
    for (some = 1; some < 1 << ropes; some++) {
        Trial trial;
        double energy;
        int i, fits = 1;
        for (i = 0; i < ropes; i++) modes[rope[i]] = some >> i & 1;
        for (k = 0; k < SB_ELEMENTS; k++)
            if (!sb_is_rope[k]) modes[k] = 1; /* friction does nothing in an instant */
        try_modes(m, modes, &trial);
        for (i = 0; i < ropes; i++) fits &= trial.e[MEASURES * rope[i] + RATE] >= -BALANCED * largest;
        energy = energy_of_change(m, trial.x);
        if (fits && energy < least) {
            least = energy;
            memcpy(best, trial.x, sizeof best);
        }
    }
    if (!(least < HUGE_VAL)) return -1;
    memcpy(m->x, best, sizeof best);
    return 1;
}

/* Find the modes in which the motion goes on. */
static int switch_modes(Motion *m, const int *ended)
{
    double now[MEASURES * SB_ELEMENTS + 1];
    int k, struck, none[SB_ELEMENTS + 1] = {0}, were_taut[SB_ELEMENTS + 1];
    Candidates some[SB_ELEMENTS + 1];
    Trial trial;
    if (!SB_ELEMENTS) return SOLVED;
    note_rates(m);
    measure(m, m->x, now);
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = now + MEASURES * k;
        were_taut[k] = m->has_modes && sb_is_rope[k] && m->mode_of[k];
        if (sb_is_rope[k] && e[SLACKNESS] < -1e-7 * e[LENGTH] && !were_taut[k]) return NOT_CLOSED;
    }
    {
        int modes[SB_ELEMENTS + 1];
        memcpy(modes, m->mode_of, sizeof modes);
        struck = strike(m, now, were_taut);
        if (struck < 0) return UNSOLVED;
        set_modes(m, modes);
    }
    if (struck) { /* what was before does not matter after a shock */
        m->has_modes = 0;
        ended = none;
        memset(were_taut, 0, sizeof were_taut);
        measure(m, m->x, now);
    }
    find_candidates(m, ended, now, now, some);
    if (!search(m, some, now, were_taut, &trial)) return UNSOLVED;
    set_modes(m, trial.modes);
    memcpy(m->x, trial.x, sizeof trial.x);
    for (k = 0; k < SB_ELEMENTS; k++) {
        const double *e = trial.e + MEASURES * k;
        m->level[k] = sb_is_rope[k] && fabs(e[SLACKNESS]) <= AT_LENGTH * e[LENGTH] ? e[SLACKNESS] : 0.0;
        m->slight[k] = sb_is_rope[k]
            ? (m->mode_of[k] ? slight_tension(e) * BALANCED / CANCELLED : AT_LENGTH * e[LENGTH])
            : m->mode_of[k] ? slow_rate(m, k) : BALANCED * e[LIMIT];
    }
    m->valid = 0;
    m->has_modes = m->is_fresh = 1;
    return SOLVED;
}

/* Mark the modes that have ended: by an event, or since inputs or parameters jumped. Returns whether modes are to be
   decided. */
static int have_ended(Motion *m, int *ended)
{
    double e[MEASURES * SB_ELEMENTS + 1];
    int k, any = 0;
    if (!SB_ELEMENTS) return 0;
    any = !m->has_modes;
    measure(m, m->x, e);
    for (k = 0; k < SB_ELEMENTS; k++) {
        ended[k] = m->pending[SB_EVENTS + k] || !(mode_indicator(m, k, e + MEASURES * k) >= -m->slight[k]);
        any |= ended[k];
    }
    return any;
}
