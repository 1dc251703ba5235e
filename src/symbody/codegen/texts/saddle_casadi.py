"""The kernel `solve_saddle` as CasADi text, to be put once into every module that needs it.

The method of `expr.saddle` with a fixed number of steps on scalar symbols: what is beyond the rank is masked
out by factors 0 and 1, which have no derivative, so that all else can be differentiated.
"""

from __future__ import annotations

from typing import Final

SADDLE_CASADI: Final = r'''
def _solve_saddle(n, m, values):
    """Return udot, lambda and the rank of J, with M udot = F + J^T lambda and J udot = gamma.

    Rows of J that depend on others to rounding are left out, and their multipliers 0. All but the rank are
    nan where M is not positive definite on the null space of J.
    """
    values = ca.vertcat(*values)
    M, J = ca.reshape(values[: n * n], n, n), ca.reshape(values[n * n : n * n + m * n], n, m).T
    F, gamma = values[n * n + m * n : n * n + m * n + n], values[n * n + m * n + n :]
    d, r = _scales(n, m, M, J)
    steps = min(n, m)
    picks, rows, diagonal, beta, takes = _factor_rows(n, m, J * ca.mtimes(r, d.T), steps)
    V = [ca.vertcat(ca.SX.zeros(k), rows[k][k:]) * takes[k] for k in range(steps)]
    B = M * ca.mtimes(d, d.T)
    for k in range(steps):
        w = ca.mtimes(B, V[k]) * beta[k]
        w = w - 0.5 * (ca.dot(w, V[k]) * beta[k]) * V[k]
        B = B - (ca.mtimes(w, V[k].T) + ca.mtimes(V[k], w.T))
    rest = [1 - takes[k] if k < steps else 1 for k in range(n)]
    C, solvable = _cholesky(n, B, rest)
    udot, multipliers = ca.SX.zeros(n), ca.SX.zeros(m)
    for _ in range(2):  # the solution, then its refinement
        f = (F + ca.mtimes(J.T, multipliers) - ca.mtimes(M, udot)) * d
        g = (gamma - ca.mtimes(J, udot)) * r
        for k in range(steps):
            f = f - (ca.dot(V[k], f) * beta[k]) * V[k]
        y = ca.SX.zeros(n)
        for k in range(steps):  # R^T y1 = g
            y[k] = takes[k] * (ca.dot(picks[k], g) - sum(rows[k][j] * y[j] for j in range(k))) / diagonal[k]
        right = f - ca.mtimes(B, y)  # B22 y2 = f2 - B21 y1
        y = y + _solve_lower(n, C, [right[k] * rest[k] for k in range(n)])
        right = ca.mtimes(B, y) - f  # R lambda = B11 y1 + B12 y2 - f1
        z = [None] * steps
        for k in reversed(range(steps)):
            total = right[k] - sum(rows[c][k] * z[c] for c in range(k + 1, steps))
            z[k] = takes[k] * total / diagonal[k]
        for k in range(steps):
            multipliers = multipliers + r * picks[k] * z[k]
        for k in reversed(range(steps)):
            y = y - (ca.dot(V[k], y) * beta[k]) * V[k]
        udot = udot + d * y
    failed = ca.if_else(solvable, 0.0, float("nan"))
    return ca.vertsplit(ca.vertcat(udot + failed, multipliers + failed, sum(takes, ca.SX(0))))


def _scale(x, share):
    """Return a power of two that brings x, or its root if share is 2, to about 1; 1 if x is not positive."""
    usable = ca.logic_and(x > 0.0, x < 1e300)
    exponent = ca.floor(ca.log(ca.if_else(usable, x, 1.0)) / ca.log(2.0)) + 1.0
    return ca.if_else(usable, ca.power(2.0, -ca.floor(exponent / share)), 1.0)


def _scales(n, m, M, J):
    """Powers of two that bring diag(M) and the largest entries of the rows of J to about 1."""
    heaviest = ca.SX(0.0)
    for j in range(n):
        heaviest = ca.fmax(heaviest, M[j, j])
    masses = [ca.if_else(M[j, j] > 0.0, ca.fmax(M[j, j], 2.0**-40 * heaviest), heaviest) for j in range(n)]
    d = [_scale(mass, 2.0) for mass in masses]
    r = _scale_rows(n, m, J, d)
    massless = [j for j in range(n) if M[j, j].is_zero()]
    if massless:
        d = _scale_massless(n, m, J, massless, d, r)
        r = _scale_rows(n, m, J, d)
    for j in range(n):
        top = ca.SX(0.0)
        for i in range(m):
            top = ca.fmax(top, ca.fabs(J[i, j]) * r[i] * d[j])
        d[j] = ca.if_else(M[j, j] > 0.0, d[j], d[j] * _scale(top, 1.0))
    return ca.vertcat(ca.SX(0, 1), *d), ca.vertcat(ca.SX(0, 1), *r)


def _scale_rows(n, m, J, d):
    """Powers of two that bring the largest entries of the rows of J to about 1."""
    r = []
    for i in range(m):
        top = ca.SX(0.0)
        for j in range(n):
            top = ca.fmax(top, ca.fabs(J[i, j]) * d[j])
        r.append(_scale(top, 1.0))
    return r


def _scale_massless(n, m, J, massless, start, r):
    """Return the scales of columns; columns without mass get those of what rows of J couple them to."""
    size = [[ca.fabs(J[i, j]) for j in range(n)] for i in range(m)]
    for j in range(n):
        top = ca.SX(0.0)
        for i in range(m):
            top = ca.fmax(top, size[i][j] * r[i])
        for i in range(m):
            size[i][j] = ca.if_else(size[i][j] * r[i] > 2.0**-40 * top, size[i][j], 0.0)
    d = [ca.SX(0.0) if j in massless else start[j] for j in range(n)]
    for _ in massless:
        tops = []
        for i in range(m):
            tops.append(ca.SX(0.0))
            for j in range(n):
                tops[i] = ca.fmax(tops[i], size[i][j] * d[j])
        chosen = {}
        for j in massless:
            least, most = ca.SX(1e150), ca.SX(0.0)
            for i in range(m):
                couples = ca.logic_and(size[i][j] > 0.0, tops[i] > 0.0)
                ratio = tops[i] / ca.if_else(couples, size[i][j], 1.0)
                least = ca.if_else(couples, ca.fmin(least, ratio), least)
                most = ca.if_else(couples, ca.fmax(most, ratio), most)
            fits = ca.logic_and(d[j] <= 0.0, most > 0.0)
            chosen[j] = ca.if_else(fits, 1.0 / _scale(least * most, 2.0), d[j])
        for j in massless:
            d[j] = chosen[j]
    return [ca.if_else(d[j] > 0.0, d[j], start[j]) for j in range(n)]


def _factor_rows(n, m, A, steps):
    """A^T P = Q R by Householder reflections with pivots: for each step the row taken as a column of 0 and
    1, the row with the vector of the reflection, the end of R, beta, and 1 if there was a row to take."""
    cut = 1000.0 * m * 2.0**-52
    size = [ca.dot(A[i, :], A[i, :]) for i in range(m)]
    picks, rows, diagonal, betas, takes = [], [], [], [], []
    for k in range(steps):
        squares = [ca.dot(A[i, k:], A[i, k:]) for i in range(m)]
        share = [ca.if_else(s > 0.0, x / ca.if_else(s > 0.0, s, 1.0), 0.0) for s, x in zip(size, squares)]
        best = ca.SX(0.0)
        for each in share:
            best = ca.fmax(best, each)
        take = best > cut * cut
        pick, free = [], take
        for each in share:
            pick.append(ca.logic_and(free, each > 0.0625 * best))
            free = ca.logic_and(free, ca.logic_not(pick[-1]))
        pick = ca.vertcat(*pick)
        row = ca.mtimes(pick.T, A).T
        square = ca.if_else(take, ca.dot(row[k:], row[k:]), 1.0)
        length, head = ca.sqrt(square), row[k]
        end = ca.if_else(head < 0.0, length, -length)
        beta = take / (square + length * ca.fabs(head))
        row[k] = head - end
        size = [s * take * (1 - pick[i]) for i, s in enumerate(size)]
        factor = ca.mtimes(A[:, k:], row[k:]) * beta * ca.vertcat(*[s > 0.0 for s in size])
        A = ca.horzcat(A[:, :k], A[:, k:] - ca.mtimes(factor, row[k:].T))
        picks.append(pick), rows.append(row), diagonal.append(ca.if_else(take, end, 1.0))
        betas.append(beta), takes.append(take)
    return picks, rows, diagonal, betas, takes


def _cholesky(n, B, rest):
    """Return the Cholesky factor of the block of B where rest is 1, and whether it is positive definite."""
    C = ca.SX.zeros(n, n)
    solvable = ca.SX(1)
    for j in range(n):
        pivot = B[j, j] - ca.dot(C[j, :j], C[j, :j]) if j else B[j, j]
        fits = pivot > 1000.0 * n * 2.0**-52
        solvable = ca.logic_and(solvable, ca.logic_or(fits, ca.logic_not(rest[j])))
        C[j, j] = ca.sqrt(ca.if_else(ca.logic_and(fits, rest[j]), pivot, 1.0))
        for i in range(j + 1, n):
            entry = B[i, j] - ca.dot(C[i, :j], C[j, :j]) if j else B[i, j]
            C[i, j] = entry * rest[i] * rest[j] / C[j, j]
    return C, solvable


def _solve_lower(n, C, right):
    """Return x with C C^T x = right."""
    x = list(right)
    for i in range(n):
        x[i] = (x[i] - sum(C[i, j] * x[j] for j in range(i))) / C[i, i]
    for i in reversed(range(n)):
        x[i] = (x[i] - sum(C[j, i] * x[j] for j in range(i + 1, n))) / C[i, i]
    return ca.vertcat(*x)
'''
