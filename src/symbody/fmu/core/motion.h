/* The motion of one instance: its state, what follows from it, assembly, events and steps.

   `model.h`, written for each mechanism, defines the kernels `symbody_*`, the functions of the mechanism, the
   sizes SB_* and the tables sb_*. All that an instance is stands in one `Motion`, so that a copy of it is a copy
   of the instance; there is no static data but constants. */

#include <stdlib.h>
#include <string.h>

enum { INSTANTIATED = 1, INITIALIZATION = 2, EVENT = 4, CONTINUOUS = 8, STEP = 16, TERMINATED = 32 };
enum { HAS_SLOPE = 1, HAS_OUTPUTS = 2, HAS_INDICATORS = 4, HAS_CALCULATED = 8, HAS_SLOPES = 16, HAS_SIDES = 32 };
enum { SOLVED, UNSOLVED, NOT_CLOSED };

typedef struct {
    int mode, valid, code;
    int is_settled;       /* the state fulfils the constraints with the values that were set */
    int has_arguments;    /* parameters and inputs stand in the numbers of all functions */
    int is_fresh;         /* the integrator has to begin at x */
    int has_stopped;      /* an event ended the motion */
    int must_project;     /* the state is to be brought back onto the constraints in event mode */
    int side[SB_EVENTS + 1], pending[SB_EVENTS + 1];
    double time, from, to, stop;
    double jump, jump_margin, past_jump; /* next jump of what depends on time alone; behind the last one */
    double x[SB_X + 1], settled_x[SB_X + 1];
    double r[SB_R + 1];
    double p[SB_P + 1], settled_p[SB_P + 1];
    double side_of_condition[SB_CONDITIONS + 1]; /* which branches are taken in model exchange */
    double slope[SB_X + 1], outputs[SB_OUTPUTS + 1], calculated[SB_CALCULATED + 1];
    double indicators[SB_EVENTS + 1], conditions[SB_CONDITIONS + 1];
    double slopes[SB_SLOPES + 1];
    double pieces[SB_PIECES + 1], ends[2];
    double pool[SB_POOL];
} Motion;

/* Write parameters and inputs to the numbers of a function, and what follows from parameters alone. */
static void write_arguments(Motion *m, const SbFunction *f)
{
    static const double none[1] = {0.0};
    double *numbers = m->pool + f->numbers;
    double *p = numbers + (int)numbers[SB_P_PLACE], *c = numbers + (int)numbers[SB_C_PLACE];
    memcpy(numbers + SB_R_PLACE, m->r, SB_R * sizeof(double));
    memcpy(p, m->p, SB_P * sizeof(double));
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

static void begin_motion(Motion *m)
{
    int k;
    memset(m, 0, sizeof *m);
    for (k = 0; k < SB_PLACES; k++) m->pool[sb_places[k]] = sb_values[k];
    memcpy(m->x, sb_x, SB_X * sizeof(double));
    memcpy(m->settled_x, sb_x, SB_X * sizeof(double));
    memcpy(m->p, sb_p, SB_P * sizeof(double));
    memcpy(m->settled_p, sb_p, SB_P * sizeof(double));
    m->stop = m->jump = HUGE_VAL;
    m->past_jump = -HUGE_VAL;
    m->is_fresh = m->is_settled = 1;
}

/* Assembly: constraints hold with the values that were set; what was not set follows. */

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
            double *A = m->pool + SB_ASSEMBLY;
            for (i = 0; i < SB_U + SB_Q; i++) A[(int)A[SB_HELD] + i] = is_given[i] && sb_is_held[i] ? 1.0 : 0.0;
            if (symbody_assemble(SB_ASSEMBLY_FUNCTION, A, clock_of(m), m->x) != 0) return 0;
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
    double x[SB_X + 1], p[SB_P + 1];
    int i, k;
    if (m->is_settled) return SOLVED;
    memcpy(x, m->x, sizeof x);
    memcpy(p, m->p, sizeof p);
    for (k = 0; k < 2; k++) {
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
    static const int none[SB_X + 1] = {0};
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

static int project_state(Motion *m)
{
    if (SB_PROJECTED) {
        renew_arguments(m);
        if (!isfinite(symbody_project(SB_PROJECTION, m->pool + SB_BLOCK, clock_of(m), m->x))) return NOT_CLOSED;
        m->valid = 0;
    }
    return SOLVED;
}

/* Whether the constraints, norms of quaternions among them, are open by more than the limit. */
static int is_open(Motion *m)
{
    if (SB_PROJECTED) {
        double *P = m->pool + SB_BLOCK + (int)m->pool[SB_BLOCK + SB_PROJECTOR];
        double *out = P + (int)P[SB_P_OUT];
        int k, count = (int)P[SB_P_RESIDUALS];
        renew_arguments(m);
        if (symbody_call(SB_PROJECTION, SB_U, P + (int)P[SB_P_FUNCTION], clock_of(m), m->x, out) != 0) return 0;
        for (k = 0; k < count; k++)
            if (fabs(out[k]) / P[SB_P_SCALES + k] * SB_CLOSED > SB_OPEN) return 1;
    }
    return 0;
}

/* What follows from the state. */

static int are_finite(const double *values, int count)
{
    int k;
    for (k = 0; k < count; k++)
        if (!isfinite(values[k])) return 0;
    return 1;
}

static void decide(Motion *m);

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
        if (SB_EVENTS && compute(m, &sb_functions[SB_INDICATORS], m->x, m->indicators)) return UNSOLVED;
        if (SB_CONDITIONS && compute(m, &sb_functions[SB_SIDES], m->x, m->conditions)) return UNSOLVED;
    } else if (what == HAS_CALCULATED) {
        if (SB_CALCULATED && compute(m, &sb_functions[SB_PARAMETERS], m->x, m->calculated)) return UNSOLVED;
    }
    m->valid |= what;
    return SOLVED;
}

/* Events: each watches a number that passes zero. */

static int side_of(double value)
{
    return value > 0.0 ? 1 : value < 0.0 ? -1 : 0;
}

/* Conditions: branches are decided here, outside continuous time, and stay as they are within it. */

static double decided_side(int k, double value)
{
    return sb_is_floor[k] ? floor(value) : (double)side_of(value);
}

/* Where what decides is zero, the side it comes to does: by two small steps, since its rate may be zero, too. */
static double side_to_come(Motion *m, int k)
{
    double x[SB_X + 1], slope[SB_X + 1], values[SB_CONDITIONS + 1], now = m->time, step = 1e-6;
    int i, j, status = 0;
    memcpy(x, m->x, sizeof x);
    for (j = 0; j < 2 && status == 0; j++) {
        status = compute(m, &sb_functions[SB_SLOPE], x, slope);
        for (i = 0; i < SB_X; i++) x[i] += step * slope[i];
        m->time += step;
    }
    if (status == 0) status = compute(m, &sb_functions[SB_SIDES], x, values);
    m->time = now;
    return status ? 0.0 : decided_side(k, values[k]);
}

static void decide(Motion *m)
{
    double values[SB_CONDITIONS + 1];
    int k, trial, changed = 1;
    for (trial = 0; changed && trial < SB_CONDITIONS + 2; trial++) { /* one may depend on another */
        changed = 0;
        if (compute(m, &sb_functions[SB_SIDES], m->x, values)) return;
        for (k = 0; k < SB_CONDITIONS; k++) {
            double side = decided_side(k, values[k]);
            if (values[k] == (sb_is_floor[k] ? side : 0.0)) side = side_to_come(m, k);
            if (m->side_of_condition[k] == side) continue;
            m->side_of_condition[k] = side;
            m->has_arguments = 0;
            changed = 1;
        }
    }
    renew_arguments(m);
    m->valid |= HAS_SIDES;
}

/* What passes zero where a branch ends. */
static double condition_indicator(const Motion *m, int k)
{
    double value = m->conditions[k], side = m->side_of_condition[k];
    return sb_is_floor[k] ? (value - side) * (side + 1.0 - value) : value;
}

static int have_conditions_changed(Motion *m)
{
    int k;
    if (!SB_CONDITIONS || need(m, HAS_INDICATORS) != SOLVED) return 0;
    for (k = 0; k < SB_CONDITIONS; k++)
        if (m->conditions[k] != 0.0 && decided_side(k, m->conditions[k]) != m->side_of_condition[k]) return 1;
    return 0;
}

/* Note which events have happened since the side of each was looked at; return whether any has. */
static int note_events(Motion *m)
{
    int k, any = 0;
    if (!SB_EVENTS || need(m, HAS_INDICATORS) != SOLVED) return 0;
    for (k = 0; k < SB_EVENTS; k++) {
        int now = side_of(m->indicators[k]), before = m->side[k];
        /* a value that is zero belongs to the side where it comes to */
        int has_fallen = before > 0 && now <= 0, has_risen = before < 0 && now >= 0;
        if ((has_fallen && sb_directions[k] <= 0) || (has_risen && sb_directions[k] >= 0)) m->pending[k] = any = 1;
        if (now != 0) m->side[k] = now;
        else if (has_fallen || has_risen) m->side[k] = 0;
    }
    return any;
}

static void look_at_sides(Motion *m)
{
    int k;
    if (!SB_EVENTS || need(m, HAS_INDICATORS) != SOLVED) return;
    for (k = 0; k < SB_EVENTS; k++) {
        m->side[k] = side_of(m->indicators[k]);
        m->pending[k] = 0;
    }
}

/* Do what follows at the events noted: new values of states. Returns whether values changed, -1 for a fault. */
static int act(Motion *m, int *must_stop)
{
    int k, j, changed = 0;
    double actions[SB_ACTIONS + 1];
    *must_stop = 0;
    for (k = 0; k < SB_EVENTS; k++) *must_stop |= m->pending[k] && sb_stops[k];
    if (SB_ACTIONS && compute(m, &sb_functions[SB_ACTION], m->x, actions)) return -1;
    for (j = 0; j < SB_ACTIONS; j++)
        if (m->pending[sb_action_events[j]]) {
            m->x[sb_action_states[j]] = actions[j];
            changed = 1;
        }
    memset(m->pending, 0, sizeof m->pending);
    if (!changed) return 0;
    m->valid = 0;
    m->is_fresh = 1;
    if (project_state(m) != SOLVED) return -1;
    /* A map leaves what it acts on where it is, up to rounding: only a side that is clear counts. */
    if (need(m, HAS_INDICATORS) == SOLVED)
        for (k = 0; k < SB_EVENTS; k++) m->side[k] = side_of(m->indicators[k]);
    return 1;
}

/* Jumps of what depends on time alone. */

static void look_for_jump(Motion *m)
{
    const double *B = m->pool + SB_BLOCK;
    int place = (int)B[SB_FIRST_BREAK];
    if (m->time >= m->jump - m->jump_margin) m->past_jump = m->jump + m->jump_margin;
    m->jump = HUGE_VAL;
    m->jump_margin = 0.0;
    for (; isfinite(B[place + SB_BREAK_TIME]); place += SB_BREAK_SIZE)
        if (B[place + SB_BREAK_JUMPS] != 0.0 && B[place + SB_BREAK_TIME] > m->time + B[place + SB_BREAK_MARGIN]) {
            m->jump = B[place + SB_BREAK_TIME];
            m->jump_margin = B[place + SB_BREAK_MARGIN];
            return;
        }
}

/* Steps of our own, for co-simulation. */

static void begin_steps(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0};
    B[SB_TIME] = m->time;
    memcpy(B + SB_VECTORS + SB_STATE_OLD * SB_X, m->x, SB_X * sizeof(double));
    B[SB_KERNEL] = B[SB_STEPS] = B[SB_SAMPLES] = 0.0;
    B[SB_AFTER_REJECTION] = B[SB_STIFF_VOTES] = B[SB_OTHER_VOTES] = B[SB_UNJUDGED] = 0.0;
    B[SB_NEXT_BREAK] = B[SB_FIRST_BREAK];
    m->from = m->to = m->time;
    m->is_fresh = 0;
    m->code = symbody_begin(mechanism_motion, B, nothing, nothing, nothing, m->ends);
    B[SB_FIRST_STEP] = SB_IS_FIXED ? B[SB_MAX_STEP] : fabs(B[SB_STEP]);
}

static void take_step(Motion *m)
{
    double *B = m->pool + SB_BLOCK, nothing[1] = {0.0}, before = B[SB_TIME];
    m->code = symbody_advance(
        mechanism_motion, SB_PROJECTION, B, nothing, nothing, nothing, m->ends, m->pieces, 1);
    if (B[SB_STEPS] != 0.0) {
        B[SB_STEPS] = 0.0;
        m->from = before;
        m->to = B[SB_T_NEW];
        if (!SB_IS_FIXED) B[SB_FIRST_STEP] = fabs(B[SB_STEP]);
    }
}

/* The state at a time inside the last step. */
static void state_at(Motion *m, double time, double *x)
{
    const double *B = m->pool + SB_BLOCK;
    if (time < m->to)
        symbody_interpolate(SB_X, SB_DENSE_ROWS, m->pieces, (time - m->from) / (m->to - m->from), x);
    else
        memcpy(x, B + SB_VECTORS + SB_STATE_OLD * SB_X, SB_X * sizeof(double));
}

static int show_state(Motion *m, double time)
{
    m->valid = 0;
    m->time = time;
    if (m->to <= m->from) return SOLVED;
    state_at(m, time, m->x);
    return time < m->to ? project_state(m) : SOLVED;
}

/* Set `sides` at a time of the last step; return whether an event has happened since the sides kept. */
static int has_event(Motion *m, double time)
{
    double x[SB_X + 1], values[SB_EVENTS + 1], now = m->time;
    int k, status;
    state_at(m, time, x);
    m->time = time;
    status = compute(m, &sb_functions[SB_INDICATORS], x, values);
    m->time = now;
    for (k = 0; k < SB_EVENTS && status == 0; k++) {
        int side = side_of(values[k]);
        if (m->side[k] > 0 && side <= 0 && sb_directions[k] <= 0) return 1;
        if (m->side[k] < 0 && side >= 0 && sb_directions[k] >= 0) return 1;
    }
    return 0;
}

/* Go on inside the last step to a time, or to the first event before it. */
static int pass_events(Motion *m, double end)
{
    double start = m->time, low = start, high = end;
    int k;
    if (SB_EVENTS == 0) return 0;
    for (k = 1; k <= SB_LOOKS; k++) {
        high = k == SB_LOOKS ? end : start + (end - start) * k / SB_LOOKS;
        if (has_event(m, high)) break;
        show_state(m, high);
        note_events(m); /* sides that change without an event */
        low = high;
    }
    if (k > SB_LOOKS) return 0;
    for (k = 0; k < 200; k++) {
        double middle = low + 0.5 * (high - low);
        if (!(middle > low && middle < high)) break;
        if (has_event(m, middle)) high = middle;
        else low = middle;
    }
    show_state(m, high);
    note_events(m);
    return 1;
}

/* Go on to a time; returns one of the codes of the integrator, and whether an event ends the motion. */
static int go_to(Motion *m, double target, int *must_stop)
{
    double *B = m->pool + SB_BLOCK;
    int events = 0;
    *must_stop = 0;
    renew_arguments(m);
    while (m->time < target) {
        double end;
        if (B[SB_T_END] < target) B[SB_T_END] = target + SB_SPAN;
        if (m->is_fresh) begin_steps(m);
        while (m->code == SB_RUNNING && m->to <= m->time) take_step(m);
        if (m->code != SB_RUNNING && m->code != SB_FINISHED) return m->code;
        if (m->to <= m->time) { /* the end of an earlier goal: begin anew towards the next */
            m->is_fresh = 1;
            continue;
        }
        end = m->to < target ? m->to : target;
        if (pass_events(m, end)) {
            if (act(m, must_stop) < 0) return SB_NOT_FINITE;
            if (*must_stop) return SB_RUNNING;
            if (++events > SB_MOST_EVENTS) return SB_TOO_MANY;
        } else if (show_state(m, end) != SOLVED)
            return SB_SINGULAR;
    }
    keep_settled(m);
    return SB_RUNNING;
}
