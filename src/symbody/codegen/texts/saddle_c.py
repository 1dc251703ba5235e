"""The kernel `solve_saddle` as C99 text, to be put once into every C file that needs it.

Operation for operation the loops of `expr.saddle` and `expr.saddle_factors`, with the same names, so that all
give the same bits. No heap, no arrays of variable length; of math.h only sqrt, fabs, frexp and ldexp. GCC
does not know the standard pragma against contraction and warns of it, hence its own.
"""

from __future__ import annotations

from typing import Final

SADDLE_C: Final = r"""
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif
#include <math.h>

/* M udot = F + J^T lambda, J udot = gamma; see solve_saddle.md of symbody for the method. */
typedef struct {
    int n, m, rank;
    const double *M, *J;
    double *d, *r;         /* powers of two: udot = d v, lambda = r scaled lambda */
    double *A, *B;         /* scaled J, then R and Householder vectors; Q^T M Q, then its Cholesky factor */
    double *order;         /* kept rows of J, then pivots of the trailing block of B */
    double *diagonal, *beta;
    double *size, *share;  /* squared length of rows not taken; squared sine of their angle to those taken */
    double *f, *g, *y;
} symbody_saddle;

static int symbody_saddle_at(const symbody_saddle *w, int k)
{
    return (int)w->order[k];
}

/* 2^-e (or, halved, 2^-floor(e/2)) with 2^(e-1) <= x < 2^e; 1 if x is 0 or not finite */
static double symbody_saddle_scale(double x, int halved)
{
    int e = 0;
    if (!(x > 0.0 && x < HUGE_VAL)) return 1.0;
    (void)frexp(x, &e);
    if (e < -1022) e = -1022;
    if (e > 1022) e = 1022;
    if (halved) e = (e - (e & 1)) / 2;
    return ldexp(1.0, -e);
}

static double symbody_saddle_row_top(const symbody_saddle *w, int i)
{
    double top = 0.0;
    for (int j = 0; j < w->n; j++) {
        double entry = fabs(w->J[i * w->n + j]) * w->d[j];
        if (entry > top) top = entry;
    }
    return top;
}

static double symbody_saddle_column_top(const symbody_saddle *w, int j)
{
    double top = 0.0;
    for (int i = 0; i < w->m; i++) {
        double entry = fabs(w->J[i * w->n + j]) * w->r[i] * w->d[j];
        if (entry > top) top = entry;
    }
    return top;
}

static void symbody_saddle_scales(const symbody_saddle *w)
{
    const int n = w->n, m = w->m;
    const double lightest = 9.094947017729282379150390625e-13; /* 2^-40 */
    double heaviest = 0.0;
    for (int j = 0; j < n; j++)
        if (w->M[j * n + j] > heaviest) heaviest = w->M[j * n + j];
    for (int j = 0; j < n; j++) {
        double mass = w->M[j * n + j];
        if (!(mass > 0.0)) mass = heaviest;
        else if (mass < lightest * heaviest) mass = lightest * heaviest;
        w->d[j] = symbody_saddle_scale(mass, 1);
    }
    for (int i = 0; i < m; i++) w->r[i] = symbody_saddle_scale(symbody_saddle_row_top(w, i), 0);
    for (int j = 0; j < n; j++)
        if (!(w->M[j * n + j] > 0.0))
            w->d[j] = w->d[j] * symbody_saddle_scale(symbody_saddle_column_top(w, j), 0);
}

static double symbody_saddle_tail_product(const symbody_saddle *w, int first, int second, int start)
{
    const double *a = w->A + first * w->n, *b = w->A + second * w->n;
    double total = 0.0;
    for (int j = start; j < w->n; j++) total = total + a[j] * b[j];
    return total;
}

static int symbody_saddle_next_row(const symbody_saddle *w, int k, double rank_cut)
{
    double best = 0.0;
    int i;
    for (i = 0; i < w->m; i++) {
        w->share[i] = 0.0;
        if (w->size[i] > 0.0) {
            w->share[i] = symbody_saddle_tail_product(w, i, i, k) / w->size[i];
            if (w->share[i] > best) best = w->share[i];
        }
    }
    if (!(best > rank_cut * rank_cut)) return -1;
    i = 0;
    while (!(w->share[i] > 0.0625 * best)) i++;
    return i;
}

static void symbody_saddle_reflect(const symbody_saddle *w, int i, int k)
{
    double square = symbody_saddle_tail_product(w, i, i, k);
    double length = sqrt(square);
    double *head = w->A + i * w->n + k;
    w->beta[k] = 1.0 / (square + length * fabs(*head));
    if (*head < 0.0) {
        w->diagonal[k] = length;
        *head = *head - length;
    } else {
        w->diagonal[k] = -length;
        *head = *head + length;
    }
}

/* A^T P = Q R; 1 if A is not finite */
static int symbody_saddle_factor_rows(symbody_saddle *w, double rank_cut)
{
    const int n = w->n, m = w->m;
    double *A = w->A;
    for (int i = 0; i < m; i++) {
        w->size[i] = symbody_saddle_tail_product(w, i, i, 0);
        if (!(w->size[i] < HUGE_VAL)) return 1;
    }
    while (w->rank < n && w->rank < m) {
        int k = w->rank, i = symbody_saddle_next_row(w, k, rank_cut);
        if (i < 0) break;
        w->order[k] = (double)i;
        w->size[i] = 0.0;
        symbody_saddle_reflect(w, i, k);
        for (int other = 0; other < m; other++) {
            if (w->size[other] > 0.0) {
                double factor = symbody_saddle_tail_product(w, i, other, k) * w->beta[k];
                for (int j = k; j < n; j++) A[other * n + j] = A[other * n + j] - factor * A[i * n + j];
            }
        }
        w->rank = k + 1;
    }
    return 0;
}

/* B becomes Q^T B Q */
static void symbody_saddle_rotate_mass(const symbody_saddle *w)
{
    const int n = w->n;
    double *B = w->B, *p = w->y;
    for (int k = 0; k < w->rank; k++) {
        const double *v = w->A + symbody_saddle_at(w, k) * n;
        double total = 0.0, half;
        for (int i = 0; i < n; i++) {
            double sum = 0.0;
            for (int j = k; j < n; j++) sum = sum + B[i * n + j] * v[j];
            p[i] = sum * w->beta[k];
        }
        for (int j = k; j < n; j++) total = total + p[j] * v[j];
        half = 0.5 * (total * w->beta[k]);
        for (int j = k; j < n; j++) p[j] = p[j] - half * v[j];
        for (int i = 0; i < k; i++) {
            for (int j = k; j < n; j++) {
                B[i * n + j] = B[i * n + j] - p[i] * v[j];
                B[j * n + i] = B[i * n + j];
            }
        }
        for (int i = k; i < n; i++)
            for (int j = k; j < n; j++) B[i * n + j] = B[i * n + j] - (p[i] * v[j] + v[i] * p[j]);
    }
}

/* pivoted Cholesky of the trailing block; 1 if it is not positive definite */
static int symbody_saddle_factor_mass(const symbody_saddle *w)
{
    const int n = w->n;
    double *B = w->B, *order = w->order;
    const double floor_ = 1000.0 * n * 2.220446049250313080847263336181640625e-16;
    for (int k = w->rank; k < n; k++) order[k] = (double)k;
    for (int k = w->rank; k < n; k++) {
        int best = k, i;
        for (int c = k + 1; c < n; c++) {
            int old = symbody_saddle_at(w, best), new_ = symbody_saddle_at(w, c);
            if (B[new_ * n + new_] > B[old * n + old]) best = c;
        }
        i = symbody_saddle_at(w, best);
        order[best] = order[k];
        order[k] = (double)i;
        if (!(B[i * n + i] > floor_)) return 1;
        B[i * n + i] = sqrt(B[i * n + i]);
        for (int c = k + 1; c < n; c++) {
            double *entry = B + symbody_saddle_at(w, c) * n + i;
            *entry = *entry / B[i * n + i];
        }
        for (int a = k + 1; a < n; a++) {
            double *row = B + symbody_saddle_at(w, a) * n;
            for (int c = k + 1; c < n; c++) {
                int column = symbody_saddle_at(w, c);
                row[column] = row[column] - row[i] * B[column * n + i];
            }
        }
    }
    return 0;
}

static void symbody_saddle_residual(const symbody_saddle *w, const double *F, const double *gamma,
                                    const double *udot, const double *lambda)
{
    const int n = w->n;
    for (int j = 0; j < n; j++) {
        double total = F[j];
        for (int k = 0; k < w->rank; k++) {
            int i = symbody_saddle_at(w, k);
            total = total + w->J[i * n + j] * lambda[i];
        }
        for (int i = 0; i < n; i++) total = total - w->M[j * n + i] * udot[i];
        w->f[j] = total * w->d[j];
    }
    for (int k = 0; k < w->rank; k++) {
        int i = symbody_saddle_at(w, k);
        double total = gamma[i];
        for (int j = 0; j < n; j++) total = total - w->J[i * n + j] * udot[j];
        w->g[i] = total * w->r[i];
    }
}

static void symbody_saddle_apply_reflection(const symbody_saddle *w, int k, double *x)
{
    const double *v = w->A + symbody_saddle_at(w, k) * w->n;
    double total = 0.0;
    for (int j = k; j < w->n; j++) total = total + v[j] * x[j];
    total = total * w->beta[k];
    for (int j = k; j < w->n; j++) x[j] = x[j] - total * v[j];
}

static void symbody_saddle_solve_mass(const symbody_saddle *w)
{
    const int n = w->n;
    const double *B = w->B;
    double *y = w->y;
    for (int k = w->rank; k < n; k++) {
        int i = symbody_saddle_at(w, k);
        y[i] = y[i] / B[i * n + i];
        for (int c = k + 1; c < n; c++) {
            int row = symbody_saddle_at(w, c);
            y[row] = y[row] - B[row * n + i] * y[i];
        }
    }
    for (int k = n - 1; k >= w->rank; k--) {
        int i = symbody_saddle_at(w, k);
        double total = y[i];
        for (int c = k + 1; c < n; c++) {
            int row = symbody_saddle_at(w, c);
            total = total - B[row * n + i] * y[row];
        }
        y[i] = total / B[i * n + i];
    }
}

/* y = Q^T v from R^T y1 = g and B22 y2 = f2 - B21 y1 */
static void symbody_saddle_accelerations(const symbody_saddle *w)
{
    const int n = w->n;
    double *y = w->y;
    for (int k = 0; k < w->rank; k++) {
        int i = symbody_saddle_at(w, k);
        double total = w->g[i];
        for (int j = 0; j < k; j++) total = total - w->A[i * n + j] * y[j];
        y[k] = total / w->diagonal[k];
    }
    for (int i = w->rank; i < n; i++) {
        double total = w->f[i];
        for (int j = 0; j < w->rank; j++) total = total - w->B[i * n + j] * y[j];
        y[i] = total;
    }
    symbody_saddle_solve_mass(w);
}

/* g becomes the solution of R lambda = B11 y1 + B12 y2 - f1 */
static void symbody_saddle_multipliers(const symbody_saddle *w)
{
    const int n = w->n;
    for (int k = w->rank - 1; k >= 0; k--) {
        double total = -w->f[k];
        for (int j = 0; j < n; j++) total = total + w->B[k * n + j] * w->y[j];
        for (int c = k + 1; c < w->rank; c++) {
            int i = symbody_saddle_at(w, c);
            total = total - w->A[i * n + k] * w->g[i];
        }
        w->g[symbody_saddle_at(w, k)] = total / w->diagonal[k];
    }
}

static void symbody_saddle_add_solution(const symbody_saddle *w, double *udot, double *lambda)
{
    for (int k = 0; k < w->rank; k++) symbody_saddle_apply_reflection(w, k, w->f);
    symbody_saddle_accelerations(w);
    symbody_saddle_multipliers(w);
    for (int k = w->rank - 1; k >= 0; k--) symbody_saddle_apply_reflection(w, k, w->y);
    for (int j = 0; j < w->n; j++) udot[j] = udot[j] + w->d[j] * w->y[j];
    for (int k = 0; k < w->rank; k++) {
        int i = symbody_saddle_at(w, k);
        lambda[i] = lambda[i] + w->r[i] * w->g[i];
    }
}

static symbody_saddle symbody_saddle_layout(int n, int m, const double *M, const double *J, double *work)
{
    symbody_saddle w;
    w.n = n, w.m = m, w.rank = 0, w.M = M, w.J = J;
    w.d = work, w.order = w.d + n, w.diagonal = w.order + n, w.beta = w.diagonal + n;
    w.f = w.beta + n, w.y = w.f + n;
    w.r = w.y + n, w.size = w.r + m, w.share = w.size + m, w.g = w.share + m;
    w.A = w.g + m, w.B = w.A + m * n;
    return w;
}

/* 0, or 1 if M is not positive definite where J u = 0 or J is not finite; then udot and lambda are NaN */
static int symbody_solve_saddle_cut(int n, int m, const double *M, const double *J, const double *F,
                                    const double *gamma, double rank_cut, double *result, double *work)
{
    symbody_saddle w = symbody_saddle_layout(n, m, M, J, work);
    int failed;
    symbody_saddle_scales(&w);
    for (int i = 0; i < m; i++)
        for (int j = 0; j < n; j++) w.A[i * n + j] = J[i * n + j] * w.r[i] * w.d[j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) w.B[i * n + j] = M[i * n + j] * w.d[i] * w.d[j];
    failed = symbody_saddle_factor_rows(&w, rank_cut);
    if (failed) {
        w.rank = 0;
    } else {
        symbody_saddle_rotate_mass(&w);
        failed = symbody_saddle_factor_mass(&w);
    }
    for (int i = 0; i < n + m; i++) result[i] = failed ? NAN : 0.0;
    result[n + m] = (double)w.rank;
    for (int step = 0; step < 2 && !failed; step++) { /* the solution, then its refinement */
        symbody_saddle_residual(&w, F, gamma, result, result + n);
        symbody_saddle_add_solution(&w, result, result + n);
    }
    return failed;
}

static int symbody_solve_saddle(int n, int m, const double *M, const double *J, const double *F,
                                const double *gamma, double *result /* n+m+1 */, double *work)
{
    const double rank_cut = 1000.0 * m * 2.220446049250313080847263336181640625e-16;
    return symbody_solve_saddle_cut(n, m, M, J, F, gamma, rank_cut, result, work);
}
"""
