/* Copyright (c) 2026, The symbody authors. SPDX-License-Identifier: BSD-3-Clause */
/* Conditions: branches of formulas. They are decided outside continuous time, and stay as they are within it. */

static int side_of(double value)
{
    return value > 0.0 ? 1 : value < 0.0 ? -1 : 0;
}

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
