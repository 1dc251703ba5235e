"""The kernel `solve_saddle` as JAX text, to be put once into every module that needs it.

The method of `expr.saddle` with a fixed number of steps: those beyond the rank are masked out. Derivatives
do not pass through the factors, but solve the same system once more.
"""

from __future__ import annotations

from typing import Final

SADDLE_JAX: Final = r'''
def _solve_saddle(n, m, values):
    """Return udot, lambda and the rank of J, with M udot = F + J^T lambda and J udot = gamma.

    Rows of J that depend on others to rounding are left out, and their multipliers 0. All but the rank are
    nan where M is not positive definite on the null space of J, or J is not finite.
    """
    values = jnp.stack([jnp.float64(value) for value in values])
    M, J = values[: n * n].reshape(n, n), values[n * n : n * n + m * n].reshape(m, n)
    F, gamma = values[n * n + m * n : n * n + m * n + n], values[n * n + m * n + n :]
    factors = _factor_saddle(n, m, jax.lax.stop_gradient(M), jax.lax.stop_gradient(J))

    def product(x):
        return M @ x[:n] + J.T @ x[n:], J @ x[:n]

    def solution(_, right):
        return _solve_factored(n, m, factors, right)

    # Unknowns udot and -lambda: symmetric, so derivatives and their transposes are the same system.
    x = jax.lax.custom_linear_solve(
        lambda x: jnp.concatenate(product(x)), jnp.concatenate([F, gamma]), solution, symmetric=True
    )
    x = jnp.where(factors["solvable"], x, jnp.nan)
    return jnp.concatenate([x[:n], -x[n:], factors["rank"][None]])


def _repeat(steps, step, state):
    return jax.lax.fori_loop(0, steps, step, state) if steps else state


def _power_of_two(x, share):
    """Return 2^-floor(e / share) with 2^(e-1) <= x < 2^e; 1 if x is 0 or not finite."""
    usable = (x > 0.0) & (x < jnp.inf)
    exponent = jnp.clip(jnp.frexp(jnp.where(usable, x, 0.5))[1], -1022, 1022)
    return jnp.ldexp(jnp.ones_like(x), -jnp.where(usable, exponent // share, 0))


def _scales(M, J):
    """Powers of two that bring diag(M) and the largest entries of the rows of J to about 1."""
    mass = jnp.diag(M)
    heaviest, massless = jnp.max(mass, initial=0.0), ~(mass > 0.0)
    d = _power_of_two(jnp.where(massless, heaviest, jnp.maximum(mass, 2.0**-40 * heaviest)), 2)
    r = _power_of_two(jnp.max(jnp.abs(J) * d, axis=1, initial=0.0), 1)
    share = jnp.abs(J) * r[:, None]
    size = jnp.where(share > 2.0**-40 * jnp.max(share, axis=0, initial=0.0), jnp.abs(J), 0.0)

    def scale_neighbors(_, d):  # columns that share a row with one that has a scale
        top = jnp.max(size * d, axis=1, initial=0.0)[:, None]
        ratio, couples = top / jnp.where(size > 0.0, size, 1.0), (size > 0.0) & (top > 0.0)
        least = jnp.min(jnp.where(couples, ratio, jnp.inf), axis=0, initial=jnp.inf)
        most = jnp.max(jnp.where(couples, ratio, 0.0), axis=0, initial=0.0)
        product = jnp.where(most > 0.0, least, 0.0) * most
        return jnp.where((d > 0.0) | ~(most > 0.0), d, 1.0 / _power_of_two(product, 2))

    d = _repeat(len(mass), scale_neighbors, jnp.where(massless, 0.0, d))
    d = jnp.where(d > 0.0, d, _power_of_two(heaviest, 2))
    r = _power_of_two(jnp.max(jnp.abs(J) * d, axis=1, initial=0.0), 1)
    top = jnp.max(jnp.abs(J) * r[:, None] * d, axis=0, initial=0.0)
    return jnp.where(massless, d * _power_of_two(top, 1), d), r


def _factor_saddle(n, m, M, J):
    """A^T P = Q R by Householder reflections with pivots, Q^T B Q, and Cholesky of its trailing block."""
    d, r = _scales(M, J)
    A, B = J * r[:, None] * d, M * d[:, None] * d
    steps, cut = min(n, m), 1000.0 * m * 2.0**-52
    columns = jnp.arange(n)

    def take_row(k, state):
        A, size, order, diagonal, beta, rank = state
        tails = jnp.sum(jnp.where(columns >= k, A * A, 0.0), axis=1)
        share = jnp.where(size > 0.0, tails / jnp.where(size > 0.0, size, 1.0), 0.0)
        best = jnp.max(share)
        takes = best > cut * cut
        i = jnp.argmax(share > 0.0625 * best)
        square = jnp.where(takes, tails[i], 1.0)
        head, length = A[i, k], jnp.sqrt(square)
        end = jnp.where(head < 0.0, length, -length)
        factor = jnp.where(takes, 1.0 / (square + length * jnp.abs(head)), 0.0)
        row = A[i].at[k].add(-end)
        v = jnp.where(columns >= k, row, 0.0)
        size = jnp.where(takes, size.at[i].set(0.0), 0.0)
        A = A - jnp.where(size > 0.0, A @ v * factor, 0.0)[:, None] * v
        A = A.at[i].set(jnp.where(takes, row, A[i]))
        end = jnp.where(takes, end, 1.0)
        return A, size, order.at[k].set(i), diagonal.at[k].set(end), beta.at[k].set(factor), rank + takes

    size = jnp.sum(A * A, axis=1)
    state = (A, size, jnp.zeros(steps, int), jnp.ones(steps), jnp.zeros(steps), 0)
    A, _, order, diagonal, beta, rank = _repeat(steps, take_row, state)
    rows, kept = A[order], jnp.arange(steps) < rank
    V = jnp.where((columns >= jnp.arange(steps)[:, None]) & kept[:, None], rows, 0.0)

    def rotate(k, B):
        w = B @ V[k] * beta[k]
        w = w - 0.5 * (w @ V[k] * beta[k]) * V[k]
        return B - (jnp.outer(w, V[k]) + jnp.outer(V[k], w))

    B = _repeat(steps, rotate, B)
    L = jnp.where(kept[:, None] & kept, jnp.tril(rows[:, :steps], -1), 0.0) + jnp.diag(diagonal)
    rest = columns >= rank
    C = jnp.linalg.cholesky(jnp.where(rest[:, None] & rest, B, jnp.eye(n)))
    finite = jnp.all(size < jnp.inf)
    # A pivot that is not a number compares false too.
    solvable = finite & jnp.all(jnp.diag(C) ** 2 > 1000.0 * n * 2.0**-52)
    return {"M": M, "J": J, "d": d, "r": r, "order": order, "kept": kept, "beta": beta, "V": V, "B": B,
            "L": L, "C": C, "rest": rest, "solvable": solvable, "rank": jnp.where(finite, rank, 0) * 1.0}


def _solve_factored(n, m, factors, right):
    """Return udot and -lambda for the right-hand sides F and gamma."""
    M, J, d, r, order, kept, beta, V, B, L, C, rest = (
        factors[key] for key in ("M", "J", "d", "r", "order", "kept", "beta", "V", "B", "L", "C", "rest")
    )
    steps, triangular = min(n, m), jax.scipy.linalg.solve_triangular

    def reflect(k, x):
        return x - (V[k] @ x * beta[k]) * V[k]

    udot, multipliers = jnp.zeros(n), jnp.zeros(m)
    for _ in range(2):  # the solution, then its refinement
        f = (right[:n] + J.T @ multipliers - M @ udot) * d
        g = (right[n:] - J @ udot) * r
        f = _repeat(steps, reflect, f)
        y = jnp.zeros(n)
        if steps:
            y = y.at[:steps].set(triangular(L, jnp.where(kept, g[order], 0.0), lower=True))
        y = y + jax.scipy.linalg.cho_solve((C, True), jnp.where(rest, f - B @ y, 0.0))
        if steps:
            z = triangular(L, jnp.where(kept, (B @ y - f)[:steps], 0.0), lower=True, trans=1)
            multipliers = multipliers.at[order].add(jnp.where(kept, r[order] * z, 0.0))
        y = _repeat(steps, lambda k, x: reflect(steps - 1 - k, x), y)
        udot = udot + d * y
    return jnp.concatenate([udot, -multipliers])
'''
