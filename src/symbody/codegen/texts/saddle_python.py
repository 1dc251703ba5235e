"""The kernel `solve_saddle` as Python text, to be put once into every module that needs it.

Operation for operation the loops of `expr.saddle` and `expr.saddle_factors`, on lists of rows, so that all
give the same bits. Python's own sum compensates its roundings from 3.12 on, hence the loop.
"""

from __future__ import annotations

from typing import Final

SADDLE_PYTHON: Final = r'''
def _saddle(n, m, values):
    """Solve a kernel at every point of a batch; the results stand along the first axis."""
    arrays = np.broadcast_arrays(*values)
    points = np.stack([array.ravel() for array in arrays], axis=-1).tolist()
    results = np.array([_solve_saddle(n, m, point) for point in points])
    return np.moveaxis(results.reshape(arrays[0].shape + (n + m + 1,)), -1, 0)


def _solve_saddle(n, m, values):
    """Return udot, lambda and the rank of J, with M udot = F + J^T lambda and J udot = gamma.

    Rows of J that depend on others to rounding are left out, and their multipliers 0. All but the rank are
    NaN where M is not positive definite on the null space of J, or J is not finite.
    """
    M = [values[i * n : i * n + n] for i in range(n)]
    J = [values[n * n + i * n : n * n + i * n + n] for i in range(m)]
    F, gamma = values[n * n + m * n : n * n + m * n + n], values[n * n + m * n + n :]
    d, r = _scales(n, m, M, J)
    A = [[J[i][j] * r[i] * d[j] for j in range(n)] for i in range(m)]
    B = [[M[i][j] * d[i] * d[j] for j in range(n)] for i in range(n)]
    order, diagonal, beta = list(range(n)), [0.0] * n, [0.0] * n
    rank = _factor_rows(n, m, A, order, diagonal, beta)
    if rank < 0:
        return [math.nan] * (n + m) + [0.0]
    _rotate_mass(n, rank, A, B, order, beta)
    if not _factor_mass(n, rank, B, order):
        return [math.nan] * (n + m) + [float(rank)]
    udot, multipliers = [0.0] * n, [0.0] * m
    for _ in range(2):  # the solution, then its refinement
        f, g = [0.0] * n, [0.0] * m
        for j in range(n):
            total = F[j]
            for i in order[:rank]:
                total = total + J[i][j] * multipliers[i]
            f[j] = _less(total, M[j], udot) * d[j]
        for i in order[:rank]:
            g[i] = _less(gamma[i], J[i], udot) * r[i]
        y = _solve_scaled(n, rank, A, B, order, diagonal, beta, f, g)
        for j in range(n):
            udot[j] = udot[j] + d[j] * y[j]
        for i in order[:rank]:
            multipliers[i] = multipliers[i] + r[i] * g[i]
    return udot + multipliers + [float(rank)]


def _more(total, a, b):
    for x, y in zip(a, b):
        total = total + x * y
    return total


def _less(total, a, b):
    for x, y in zip(a, b):
        total = total - x * y
    return total


def _exponent(x):
    return min(max(math.frexp(x)[1], -1022), 1022) if 0.0 < x < math.inf else 0


def _scales(n, m, M, J):
    """Powers of two that bring diag(M) and the largest entries of the rows of J to about 1."""
    heaviest = 0.0
    for j in range(n):
        heaviest = max(heaviest, M[j][j])
    d = []
    for j in range(n):
        mass = M[j][j] if M[j][j] > 0.0 else heaviest
        mass = 2.0**-40 * heaviest if mass < 2.0**-40 * heaviest else mass
        d.append(math.ldexp(1.0, -(_exponent(mass) >> 1)))
    r = []
    for i in range(m):
        top = 0.0
        for j in range(n):
            top = max(top, abs(J[i][j]) * d[j])
        r.append(math.ldexp(1.0, -_exponent(top)))
    for j in range(n):
        if not M[j][j] > 0.0:
            top = 0.0
            for i in range(m):
                top = max(top, abs(J[i][j]) * r[i] * d[j])
            d[j] = d[j] * math.ldexp(1.0, -_exponent(top))
    return d, r


def _factor_rows(n, m, A, order, diagonal, beta):
    """Factor A^T P = Q R by Householder reflections with pivots; return the rank, -1 if A is not finite."""
    cut = 1000.0 * m * 2.0**-52
    size = [_more(0.0, row, row) for row in A]
    if not all(square < math.inf for square in size):
        return -1
    rank = 0
    while rank < n and rank < m:
        k = rank
        share = [_more(0.0, A[i][k:], A[i][k:]) / size[i] if size[i] > 0.0 else 0.0 for i in range(m)]
        best = max(0.0, *share)
        if not best > cut * cut:
            break
        i = next(i for i in range(m) if share[i] > 0.0625 * best)
        order[k], size[i] = i, 0.0
        square = _more(0.0, A[i][k:], A[i][k:])
        length, head = math.sqrt(square), A[i][k]
        beta[k] = 1.0 / (square + length * abs(head))
        diagonal[k], A[i][k] = (length, head - length) if head < 0.0 else (-length, head + length)
        for other in range(m):
            if size[other] > 0.0:
                factor = _more(0.0, A[i][k:], A[other][k:]) * beta[k]
                for j in range(k, n):
                    A[other][j] = A[other][j] - factor * A[i][j]
        rank += 1
    return rank


def _rotate_mass(n, rank, A, B, order, beta):
    """Replace B by Q^T B Q."""
    for k in range(rank):
        v = A[order[k]]
        p = [_more(0.0, B[i][k:], v[k:]) * beta[k] for i in range(n)]
        half = 0.5 * (_more(0.0, p[k:], v[k:]) * beta[k])
        for j in range(k, n):
            p[j] = p[j] - half * v[j]
        for i in range(k):
            for j in range(k, n):
                B[j][i] = B[i][j] = B[i][j] - p[i] * v[j]
        for i in range(k, n):
            for j in range(k, n):
                B[i][j] = B[i][j] - (p[i] * v[j] + v[i] * p[j])


def _factor_mass(n, rank, B, order):
    """Factor the trailing block by Cholesky with diagonal pivots; False if it is not positive definite."""
    order[rank:] = range(rank, n)
    for k in range(rank, n):
        best = max(range(k, n), key=lambda c: B[order[c]][order[c]])
        order[k], order[best] = order[best], order[k]
        i = order[k]
        if not B[i][i] > 1000.0 * n * 2.0**-52:
            return False
        B[i][i] = math.sqrt(B[i][i])
        rest = order[k + 1 :]
        for row in rest:
            B[row][i] = B[row][i] / B[i][i]
        for row in rest:
            for column in rest:
                B[row][column] = B[row][column] - B[row][i] * B[column][i]
    return True


def _reflect(k, v, beta, x):
    total = _more(0.0, v[k:], x[k:]) * beta[k]
    for j in range(k, len(x)):
        x[j] = x[j] - total * v[j]


def _solve_scaled(n, rank, A, B, order, diagonal, beta, f, g):
    """Return the scaled accelerations; g becomes the scaled multipliers."""
    for k in range(rank):
        _reflect(k, A[order[k]], beta, f)
    y = [0.0] * n
    for k in range(rank):
        y[k] = _less(g[order[k]], A[order[k]][:k], y) / diagonal[k]
    for i in range(rank, n):
        y[i] = _less(f[i], B[i][:rank], y)
    for k in range(rank, n):
        i = order[k]
        y[i] = y[i] / B[i][i]
        for row in order[k + 1 :]:
            y[row] = y[row] - B[row][i] * y[i]
    for k in range(n - 1, rank - 1, -1):
        i, rest = order[k], order[k + 1 :]
        y[i] = _less(y[i], [B[row][i] for row in rest], [y[row] for row in rest]) / B[i][i]
    for k in range(rank - 1, -1, -1):
        total, rest = _more(-f[k], B[k], y), order[k + 1 : rank]
        g[order[k]] = _less(total, [A[i][k] for i in rest], [g[i] for i in rest]) / diagonal[k]
    for k in range(rank - 1, -1, -1):
        _reflect(k, A[order[k]], beta, y)
    return y
'''
