/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* An instance: its variables by value reference, the modes of the standard, messages. */

#include <stdio.h>

enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR, STATUS_FATAL };
enum { MODEL_EXCHANGE, CO_SIMULATION };

/* Where the groups of variables begin. */
enum {
    AT_X = 1,
    AT_SLOPE = AT_X + SB_X,
    AT_R = AT_SLOPE + SB_X,
    AT_P = AT_R + SB_R,
    AT_CALCULATED = AT_P + SB_P,
    AT_OUTPUTS = AT_CALCULATED + SB_CALCULATED,
    AT_INDICATORS = AT_OUTPUTS + SB_SHOWN,
    AT_CONDITIONS = AT_INDICATORS + SB_EVENTS,
    AT_ELEMENTS = AT_CONDITIONS + SB_CONDITIONS,
    AT_END = AT_ELEMENTS + SB_ELEMENTS
};

typedef struct {
    Motion motion;
    int kind, logs_events;
    void *environment;
    void (*logger)(void);
    const void *callbacks;
    char *name;
} Instance;

static void deliver(Instance *instance, int status, const char *category, const char *text);

/* Messages of motions: each is the first part of its instance. */

static void log_happened(Motion *m, double until)
{
#if SB_WATCH_COUNT
    Instance *instance = (Instance *)m;
    double *count = &watch_of(m)[SB_W_HAPPENED];
    char text[512];
    int rest;
    for (; m->logged < (int)*count && m->happened[m->logged * (SB_N + 2) + 1] <= until; m->logged++) {
        const double *row = m->happened + m->logged * (SB_N + 2);
        int k = (int)row[0];
        snprintf(text, sizeof text, "%s at t = %.17g", sb_names[k < SB_EVENTS ? AT_INDICATORS + k : AT_ELEMENTS + k - SB_EVENTS],
            m->is_alone ? row[1] : m->time);
        if (instance->logs_events) deliver(instance, STATUS_OK, "logEvents", text);
    }
    rest = (int)*count - m->logged + 1;
    if (m->logged <= 1) return;
    memmove(m->happened, m->happened + (m->logged - 1) * (SB_N + 2), rest * (SB_N + 2) * sizeof(double));
    *count = rest; /* the last one tells that something has happened */
    m->logged = 1;
#else
    (void)m, (void)until;
#endif
}

static void log_shock(Motion *m, const double *row)
{
    Instance *instance = (Instance *)m;
    char text[1024];
    int k, stops = 0, ropes = 0, count = 0, size;
    for (k = 0; k < SB_ELEMENTS; k++)
        if (row[3 + k] != 0.0) *(sb_stops[k] ? &stops : &ropes) += 1;
    size = snprintf(text, sizeof text, "at t = %.9g s %s with an impact:", row[1],
        !stops ? "ropes go taut" : !ropes ? "stops close" : "ropes go taut and stops close");
    for (k = 0; k < SB_ELEMENTS && size < (int)sizeof text; k++)
        if (row[3 + k] != 0.0)
            size += snprintf(text + size, sizeof text - size, "%s %s by %.6g%s", count++ ? " and" : "", sb_elements[k], row[3 + k],
                sb_stops[k] ? "" : " N s");
    if (size < (int)sizeof text) snprintf(text + size, sizeof text - size, "; %.6g J are lost", row[2]);
    if (instance->logs_events) deliver(instance, STATUS_OK, "logEvents", text);
}

static int fail(Instance *instance, int status, const char *function, const char *what)
{
    char text[1024];
    snprintf(text, sizeof text, "%s: %s", function, what);
    deliver(instance, status, "logStatusError", text);
    return status;
}

static int fail_about(Instance *instance, const char *function, unsigned reference, const char *what)
{
    char text[1024];
    if (reference < AT_END)
        snprintf(text, sizeof text, "%s: variable %s %s", function, sb_names[reference], what);
    else
        snprintf(text, sizeof text, "%s: there is no variable with value reference %u", function, reference);
    deliver(instance, STATUS_ERROR, "logStatusError", text);
    return STATUS_ERROR;
}

static const char *mode_name(int mode)
{
    switch (mode) {
    case INSTANTIATED: return "just after instantiation; enter initialization mode first";
    case INITIALIZATION: return "in initialization mode; exit it first";
    case EVENT: return "in event mode; enter continuous-time mode first";
    case CONTINUOUS: return "in continuous-time mode; enter event mode first";
    case STEP: return "in step mode, which this call does not belong to";
    default: return "after the simulation was terminated; reset the instance or free it";
    }
}

/* Whether a function may be called now; if not, the message says what to do. */
static int is_legal(Instance *instance, const char *function, int modes)
{
    char text[512];
    if (instance == NULL) return 0;
    if (instance->motion.mode & modes) return 1;
    snprintf(text, sizeof text, "%s was called %s", function, mode_name(instance->motion.mode));
    deliver(instance, STATUS_ERROR, "logStatusError", text);
    return 0;
}

static Instance *new_instance(const char *name, int kind, const char *token)
{
    Instance *instance;
    if (token == NULL || strcmp(token, SB_TOKEN) != 0) return NULL;
    instance = (Instance *)calloc(1, sizeof(Instance));
    if (instance == NULL) return NULL;
    if (name == NULL) name = "";
    instance->name = (char *)malloc(strlen(name) + 1);
    if (instance->name == NULL) {
        free(instance);
        return NULL;
    }
    strcpy(instance->name, name);
    instance->kind = kind;
    begin_motion(&instance->motion);
    instance->motion.mode = INSTANTIATED;
    return instance;
}

static void free_instance(Instance *instance)
{
    if (instance == NULL) return;
    free(instance->name);
    free(instance);
}

/* Values that were set before and in initialization mode hold, the others follow from them. */
static int prepare(Instance *instance, const char *function)
{
    Motion *m = &instance->motion;
    if (!(m->mode & (INSTANTIATED | INITIALIZATION))) return STATUS_OK;
    if (!m->is_settled) {
        release(m);
        if (settle(m, sb_is_given) != SOLVED)
            return fail(instance, STATUS_ERROR, function,
                "no configuration near the one before fulfils the constraints with the values that were set");
    }
    if (!SB_ELEMENTS || m->has_modes) return STATUS_OK;
    forget_modes(m);
    if (switch_modes(m) == SOLVED) return STATUS_OK;
    return fail(instance, STATUS_ERROR, function,
        "no way of sticking and slipping, and of gaps closed and open, fits the values that were set");
}

static int enter_initialization(Instance *instance, double start, int has_stop, double stop, double tolerance)
{
    Motion *m = &instance->motion;
    double *B = m->pool + SB_BLOCK;
    m->time = start;
    if (has_stop && stop > start) m->stop = stop;
    if (tolerance > 0.0) B[SB_RUN_GOAL_RTOL] = tolerance > 1e-13 ? tolerance : 1e-13;
    B[SB_RUN_T_END] = isfinite(m->stop) ? m->stop : start + SB_SPAN;
    if (SB_WATCH_COUNT && isfinite(m->stop)) watch_of(m)[SB_W_SPAN] = m->stop - start;
    if (start != 0.0) m->is_settled = !SB_IS_CLOSED; /* constraints may depend on time */
    m->valid = 0;
    m->mode = INITIALIZATION;
    return STATUS_OK;
}

/* What is held from the first time on; modes are those with the first samples. */
static int first_samples(Instance *instance, const char *function)
{
    Motion *m = &instance->motion;
    if (!SB_SAMPLED) return STATUS_OK;
    if (!begin_samples(m))
        return fail(instance, STATUS_ERROR, function, "a time between samples is not positive: set other parameters");
    if (take_due(m) < 0) return fail(instance, STATUS_ERROR, function, "a sampled value is not finite");
    m->has_modes = 0;
    return prepare(instance, function);
}

static int exit_initialization(Instance *instance, const char *function)
{
    Motion *m = &instance->motion;
    int status;
    status = prepare(instance, function);
    if (status != STATUS_OK) return status;
    status = first_samples(instance, function);
    if (status != STATUS_OK) return status;
    m->is_alone = instance->kind == CO_SIMULATION;
    look_at_sides(m);
    m->is_fresh = 1;
    look_for_jump(m);
    m->mode = instance->kind == MODEL_EXCHANGE ? EVENT : STEP;
    return STATUS_OK;
}

/* Values of variables. */

static int get_value(Instance *instance, const char *function, unsigned reference, double *value)
{
    Motion *m = &instance->motion;
    int what = reference < AT_SLOPE ? 0 : reference < AT_R ? HAS_SLOPE : reference < AT_CALCULATED ? 0
        : reference < AT_OUTPUTS ? HAS_CALCULATED : reference < AT_INDICATORS ? HAS_OUTPUTS : HAS_INDICATORS;
    if (reference >= AT_END) return fail_about(instance, function, reference, "");
    if (reference < AT_R || reference >= AT_CALCULATED) {
        int status = prepare(instance, function);
        if (status != STATUS_OK) return status;
    }
    if (what && need(m, what) != SOLVED)
        return fail(instance, STATUS_DISCARD, function, "the accelerations have no solution in this state");
    if (reference == 0) *value = m->time;
    else if (reference < AT_SLOPE) *value = m->x[reference - AT_X];
    else if (reference < AT_R) *value = m->slope[reference - AT_SLOPE];
    else if (reference < AT_P) *value = m->r[reference - AT_R];
    else if (reference < AT_CALCULATED) *value = m->p[reference - AT_P];
    else if (reference < AT_OUTPUTS) *value = m->calculated[reference - AT_CALCULATED];
    else if (reference == AT_OUTPUTS) *value = violation(m->outputs);
    else if (reference < AT_INDICATORS) *value = m->outputs[SB_CONSTRAINTS + reference - AT_OUTPUTS - 1];
    else if (reference < AT_CONDITIONS) *value = m->indicators[reference - AT_INDICATORS];
    else if (reference < AT_ELEMENTS) *value = condition_indicator(m, (int)(reference - AT_CONDITIONS));
    else *value = shown_indicator(m, (int)(reference - AT_ELEMENTS));
    return STATUS_OK;
}

static int set_parameter(Instance *instance, const char *function, unsigned reference, double value)
{
    Motion *m = &instance->motion;
    unsigned k = reference - AT_P;
    int early = INSTANTIATED | INITIALIZATION;
    if (!(m->mode & (sb_is_fixed[k] ? early : early | EVENT | STEP)))
        return fail_about(instance, function, reference,
            sb_is_fixed[k] ? "is fixed: set it before initialization mode ends"
                           : "is tunable: set it in event mode, or between steps of co-simulation");
    if (m->p[k] == value) return STATUS_OK;
    interrupt(m);
    m->p[k] = value;
    m->has_arguments = 0;
    m->valid = 0;
    if (m->mode & early) m->has_modes = 0;
    if (sb_closes[k]) m->is_settled = 0;
    return STATUS_OK;
}

static int set_value(Instance *instance, const char *function, unsigned reference, double value)
{
    Motion *m = &instance->motion;
    if (!isfinite(value)) return fail_about(instance, function, reference, "was given no finite number");
    if (reference >= AT_P && reference < AT_CALCULATED) return set_parameter(instance, function, reference, value);
    if (reference >= AT_P - SB_SAMPLED && reference < AT_P && !(m->mode & (INSTANTIATED | INITIALIZATION)))
        return fail_about(instance, function, reference, "is sampled: set it before initialization mode ends only");
    if (reference >= AT_R && reference < AT_P) {
        if (m->r[reference - AT_R] == value) return STATUS_OK;
        interrupt(m);
        m->r[reference - AT_R] = value;
        if (m->mode & (INSTANTIATED | INITIALIZATION)) m->has_modes = 0;
        m->has_arguments = 0;
        m->valid = 0;
        return STATUS_OK;
    }
    if (reference >= AT_X && reference < AT_SLOPE) {
        unsigned k = reference - AT_X;
        if (!sb_is_given[k])
            return fail_about(instance, function, reference, "follows from the constraints: set others instead");
        if (!(m->mode & (INSTANTIATED | INITIALIZATION)))
            return fail_about(instance, function, reference, "can be set before initialization mode ends only");
        m->x[k] = value;
        m->has_modes = 0;
        m->is_settled = 0;
        m->valid = 0;
        return STATUS_OK;
    }
    return fail_about(instance, function, reference, "is computed and cannot be set");
}

static int get_values(Instance *instance, const char *function, const unsigned *references, size_t count, double *values)
{
    size_t k;
    int worst = STATUS_OK;
    for (k = 0; k < count; k++) {
        int status = get_value(instance, function, references[k], &values[k]);
        if (status > worst) worst = status;
    }
    return worst;
}

static int set_values(
    Instance *instance, const char *function, const unsigned *references, size_t count, const double *values)
{
    size_t k;
    int worst = STATUS_OK;
    for (k = 0; k < count; k++) {
        int status = set_value(instance, function, references[k], values[k]);
        if (status > worst) worst = status;
    }
    return worst;
}

/* Event mode. */

/* Why the motion ends at an event, unless its action turned nothing. */
static const char *reason(const Motion *m, const char *otherwise)
{
    return m->unmet == CHATTERING ? "an event happens again and again within an instant"
        : m->unmet == NOT_A_NUMBER ? "the value of an event, or what it sets, is not finite"
        : m->unmet == OPEN_LOOP ? "the constraints do not admit what the action of an event sets"
        : m->unmet == TORN_MOTION ? "a prescribed position jumps"
        : m->unmet == NO_SPEEDS ? "no speeds satisfy the prescribed rates behind a jump"
        : m->unmet == UNKNOWN_RATES ? "prescribed rates jump further on, which is not known to this FMU"
        : m->unmet == OVERLAP
        ? "the action of an event moves the ends of a rope farther apart than it is long, or beyond a stop; set coordinates within"
        : otherwise;
}

/* The event that ends the motion, from 1, if it goes on as before its action. */
static int unturned(Motion *m)
{
    const double *W = watch_of(m);
    return SB_WATCH_COUNT && m->unmet == CHATTERING && W[SB_W_UNTURNED] != 0.0 ? (int)W[SB_W_CULPRIT] : 0;
}

/* Fail because of what an event did: its action turned nothing, cannot be met, or `otherwise`. */
static int fail_at_event(Instance *instance, const char *function, const char *otherwise)
{
    Motion *m = &instance->motion;
    char text[512];
    if (!unturned(m)) return fail(instance, STATUS_ERROR, function, reason(m, otherwise));
    snprintf(text, sizeof text, "%s happens at t = %.17g where its value is zero, and after its action the value "
        "is zero again and goes the same way; let the action turn the value back or move it off zero",
        sb_names[AT_INDICATORS + unturned(m) - 1], m->time);
    watch_of(m)[SB_W_UNTURNED] = 0.0;
    return fail(instance, STATUS_ERROR, function, text);
}

/* One update of discrete states; `next` becomes the time of the next event, infinite without one. */
static int update(Instance *instance, const char *function, int *has_changed, int *must_stop, double *next)
{
    Motion *m = &instance->motion;
    int acted, stops = 0, stops_at_jump = 0;
    *has_changed = *must_stop = 0;
    if (!m->is_settled) {
        if (settle_anew(m) != SOLVED)
            return fail(instance, STATUS_ERROR, function, "the constraints cannot be fulfilled with these parameters");
        *has_changed = 1;
    }
    if (m->must_project) {
        if (project_state(m) != SOLVED)
            return fail(instance, STATUS_ERROR, function, "the constraints are out of reach");
        m->must_project = 0;
        *has_changed = 1;
    }
    acted = act(m, must_stop);
    if (acted < 0)
        return fail_at_event(instance, function, "the state after an event has no solution");
    *has_changed |= acted;
    acted = pass_jumps(m, &stops_at_jump);
    if (acted < 0) return fail_at_event(instance, function, "the state behind a jump has no solution");
    *has_changed |= acted;
    acted = sample(m, &stops);
    if (acted < 0) return fail_at_event(instance, function, "a sampled value, or the state behind it, is not finite");
    *has_changed |= acted;
    acted = act_at_start(m);
    if (acted < 0) return fail_at_event(instance, function, "the state after an event has no solution");
    *has_changed |= acted;
    *must_stop |= stops | stops_at_jump;
    *next = m->jump < next_sample(m) ? m->jump : next_sample(m);
    m->valid = 0; /* branches are decided anew, behind a jump in time */
    if (SB_CONDITIONS) need(m, HAS_INDICATORS);
    keep_settled(m);
    return STATUS_OK;
}

static int event_indicators(Instance *instance, const char *function, double *values)
{
    Motion *m = &instance->motion;
    int k;
    if (need(m, HAS_INDICATORS) != SOLVED)
        return fail(instance, STATUS_DISCARD, function, "events have no value in this state");
    memcpy(values, m->indicators, SB_EVENTS * sizeof(double));
    for (k = 0; k < SB_CONDITIONS; k++) values[SB_EVENTS + k] = condition_indicator(m, k);
    for (k = 0; k < SB_ELEMENTS; k++) values[SB_EVENTS + SB_CONDITIONS + k] = shown_indicator(m, k);
    return STATUS_OK;
}

static void completed_step(Instance *instance, int *enters_events)
{
    Motion *m = &instance->motion;
    note_rates(m, m->x);
    *enters_events = note_events(m) | have_conditions_changed(m);
    if (is_open(m)) *enters_events = m->must_project = 1;
}

/* One communication step. */
static int do_step(Instance *instance, const char *function, double start, double length, int *must_stop)
{
    Motion *m = &instance->motion;
    char text[256];
    double gap = fabs(start - m->time);
    int code;
    *must_stop = 0;
    if (!(length > 0.0)) return fail(instance, STATUS_ERROR, function, "the step is not positive");
    if (gap > 1e-6 * length + 1e-9 * fabs(start))
        return fail(instance, STATUS_ERROR, function, "the step does not begin where the last one ended");
    if (settle_anew(m) != SOLVED)
        return fail(instance, STATUS_ERROR, function, "the constraints cannot be fulfilled with these parameters");
    code = go_to(m, start + length, must_stop);
    if (code == SB_RUNNING) return STATUS_OK;
    if (unturned(m)) return fail_at_event(instance, function, "");
    snprintf(text, sizeof text, "the motion cannot go on from t = %.17g: %s", m->time,
        code == SB_SINGULAR ? "the accelerations have no solution"
        : code == SB_TOO_MANY ? "too many events or steps"
        : code == SB_COLLAPSED ? "steps become too short" : reason(m, "values are not finite"));
    return fail(instance, STATUS_DISCARD, function, text);
}

/* Derivatives of slopes and outputs by states and inputs. */

static int column_of(unsigned reference)
{
    if (reference >= AT_X && reference < AT_X + SB_X) {
        int k = (int)(reference - AT_X); /* columns are q, s, u, r; states are u, q, s */
        return k < SB_U ? SB_X - SB_U + k : k - SB_U;
    }
    if (reference >= AT_R && reference < AT_P) return SB_X + (int)(reference - AT_R);
    return -1;
}

static double slope_of_violation(const Motion *m, int column)
{
    int k, place = -1;
    double worst = 0.0;
    for (k = 0; k < SB_CONSTRAINTS; k++) {
        double size = fabs(m->outputs[k]) / sb_scales[k];
        if (size > worst) {
            worst = size;
            place = k;
        }
    }
    if (place < 0) return 0.0;
    return (m->outputs[place] < 0.0 ? -1.0 : 1.0) / sb_scales[place] * m->slopes[(SB_X + place) * (SB_X + SB_R) + column];
}

static int derivative(Instance *instance, const char *function, unsigned unknown, unsigned known, double *value)
{
    Motion *m = &instance->motion;
    int column = column_of(known), row;
    if (unknown >= AT_X && unknown < AT_SLOPE) { /* states, while they are set, follow each other */
        *value = unknown == known ? 1.0 : 0.0;
        return STATUS_OK;
    }
    if (column < 0) return fail_about(instance, function, known, "is neither a state nor an input");
    if (unknown == AT_OUTPUTS) {
        *value = slope_of_violation(m, column);
        return STATUS_OK;
    }
    if (unknown >= AT_SLOPE && unknown < AT_R) row = (int)(unknown - AT_SLOPE);
    else if (unknown > AT_OUTPUTS && unknown < AT_INDICATORS) row = SB_X + SB_CONSTRAINTS + (int)(unknown - AT_OUTPUTS) - 1;
    else return fail_about(instance, function, unknown, "is neither an output nor the derivative of a state");
    *value = m->slopes[row * (SB_X + SB_R) + column];
    return STATUS_OK;
}

static int directional_derivative(
    Instance *instance, const char *function, const unsigned *unknowns, size_t rows, const unsigned *knowns,
    size_t columns, const double *seed, double *result)
{
    size_t i, k;
    int status = prepare(instance, function);
    if (status != STATUS_OK) return status;
    if (!SB_HAS_DERIVATIVES) return fail(instance, STATUS_ERROR, function, "there are no derivatives in this FMU");
    if (need(&instance->motion, HAS_SLOPES) != SOLVED || need(&instance->motion, HAS_OUTPUTS) != SOLVED)
        return fail(instance, STATUS_DISCARD, function, "the accelerations have no solution in this state");
    for (i = 0; i < rows; i++) {
        result[i] = 0.0;
        for (k = 0; k < columns; k++) {
            double value = 0.0;
            status = derivative(instance, function, unknowns[i], knowns[k], &value);
            if (status != STATUS_OK) return status;
            if (seed[k] != 0.0) result[i] += value * seed[k]; /* 0 times what is no number is 0 here */
        }
    }
    return STATUS_OK;
}

/* States in continuous time. */

static int get_states(Instance *instance, const char *function, double *x)
{
    int status = prepare(instance, function);
    memcpy(x, instance->motion.x, SB_X * sizeof(double));
    return status;
}

static int get_slope(Instance *instance, const char *function, double *slope)
{
    int status = prepare(instance, function);
    if (status != STATUS_OK) return status;
    if (need(&instance->motion, HAS_SLOPE) != SOLVED)
        return fail(instance, STATUS_DISCARD, function, "the accelerations have no solution in this state");
    memcpy(slope, instance->motion.slope, SB_X * sizeof(double));
    return STATUS_OK;
}

static void set_states(Instance *instance, const double *x)
{
    memcpy(instance->motion.x, x, SB_X * sizeof(double));
    instance->motion.valid = 0;
}

/* Copies of the motion are copies of the instance. */

static int keep_motion(Instance *instance, const char *function, void **state)
{
    if (*state == NULL) *state = malloc(sizeof(Motion));
    if (*state == NULL) return fail(instance, STATUS_ERROR, function, "memory is exhausted");
    memcpy(*state, &instance->motion, sizeof(Motion));
    return STATUS_OK;
}

static int restore_motion(Instance *instance, const char *function, const void *state)
{
    if (state == NULL) return fail(instance, STATUS_ERROR, function, "no state was given");
    memcpy(&instance->motion, state, sizeof(Motion));
    return STATUS_OK;
}

static void forget_motion(void **state)
{
    if (state == NULL) return;
    free(*state);
    *state = NULL;
}

static int write_motion(Instance *instance, const char *function, const void *state, void *bytes, size_t size)
{
    if (size < sizeof(Motion) || state == NULL)
        return fail(instance, STATUS_ERROR, function, "the buffer is too small, or no state was given");
    memcpy(bytes, state, sizeof(Motion));
    return STATUS_OK;
}

static int read_motion(Instance *instance, const char *function, const void *bytes, size_t size, void **state)
{
    int status;
    if (size != sizeof(Motion)) return fail(instance, STATUS_ERROR, function, "the size is not that of a state");
    status = keep_motion(instance, function, state);
    if (status == STATUS_OK) memcpy(*state, bytes, sizeof(Motion));
    return status;
}
