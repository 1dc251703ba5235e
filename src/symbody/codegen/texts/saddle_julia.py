"""The kernel `solve_saddle` as Julia text, to be put once into every module that needs it.

The steps of `expr.saddle` and `expr.saddle_factors`, on rows as columns: J[j, i] is entry j of row i. Powers
of two and pivots are chosen by values, so dual numbers pass through the rest.
"""

from __future__ import annotations

from typing import Final

SADDLE_JULIA: Final = r"""
# M udot = F + J' lambda, J udot = gamma: udot, lambda and the rank of J. Rows of J that depend on others to
# rounding are left out, and their multipliers 0. All but the rank are nan where M is not positive definite
# on the null space of J, or J is not finite. The arguments lie in work behind `first` numbers, the solution
# goes behind `place` numbers.
function symbody_solve_saddle!(work, n, m, first, place)
    M = reshape(work[first+1:first+n*n], n, n)
    J = reshape(work[first+n*n+1:first+n*n+m*n], n, m)
    F = work[first+n*n+m*n+1:first+n*n+m*n+n]
    gamma = work[first+n*n+m*n+n+1:first+n*n+m*n+n+m]
    d, r = symbody_scales(n, m, M, J)
    A = [J[j, i] * r[i] * d[j] for j in 1:n, i in 1:m]
    B = [M[j, i] * d[i] * d[j] for j in 1:n, i in 1:n]
    order = zeros(Int, n)
    diagonal = zeros(eltype(work), n)
    beta = zeros(eltype(work), n)
    rank = symbody_factor_rows!(n, m, A, order, diagonal, beta)
    work[place+1:place+n+m] .= NaN
    work[place+n+m+1] = max(rank, 0)
    rank < 0 && return nothing
    symbody_rotate_mass!(n, rank, A, B, order, beta)
    symbody_factor_mass!(n, rank, B, order) || return nothing
    udot = zeros(eltype(work), n)
    lambda = zeros(eltype(work), m)
    kept = order[1:rank]
    for step in 1:2  # the solution, then its refinement
        f = copy(F)
        g = zeros(eltype(work), m)
        for j in 1:n
            for i in kept
                f[j] += J[j, i] * lambda[i]
            end
            for i in 1:n
                f[j] -= M[i, j] * udot[i]
            end
            f[j] *= d[j]
        end
        for i in kept
            g[i] = (gamma[i] - symbody_product(view(J, :, i), udot)) * r[i]
        end
        y = symbody_solve_scaled!(n, rank, A, B, order, diagonal, beta, f, g)
        for j in 1:n
            udot[j] += d[j] * y[j]
        end
        for i in kept
            lambda[i] += r[i] * g[i]
        end
    end
    work[place+1:place+n] .= udot
    work[place+n+1:place+n+m] .= lambda
    return nothing
end

function symbody_product(a, b)
    total = zero(promote_type(eltype(a), eltype(b)))
    for k in eachindex(a, b)
        total += a[k] * b[k]
    end
    return total
end

# The power of two e with 2^(e-1) <= x < 2^e; 0 if x is 0 or not finite
symbody_exponent(x) = 0 < x < Inf ? clamp(exponent(x) + 1, -1022, 1022) : 0

# Powers of two that bring the diagonal of M and the largest entries of the rows of J to about 1
function symbody_scales(n, m, M, J)
    heaviest = zero(eltype(M))
    for j in 1:n
        heaviest = M[j, j] > heaviest ? M[j, j] : heaviest
    end
    d = ones(n)
    for j in 1:n
        mass = M[j, j] > 0 ? M[j, j] : heaviest
        mass = mass < 2.0^-40 * heaviest ? 2.0^-40 * heaviest : mass
        d[j] = ldexp(1.0, -fld(symbody_exponent(mass), 2))
    end
    r = ones(m)
    for i in 1:m
        top = zero(eltype(J))
        for j in 1:n
            entry = abs(J[j, i]) * d[j]
            top = entry > top ? entry : top
        end
        r[i] = ldexp(1.0, -symbody_exponent(top))
    end
    for j in 1:n
        M[j, j] > 0 && continue
        top = zero(eltype(J))
        for i in 1:m
            entry = abs(J[j, i]) * r[i] * d[j]
            top = entry > top ? entry : top
        end
        d[j] *= ldexp(1.0, -symbody_exponent(top))
    end
    return d, r
end

# A' P = Q R by Householder reflections with pivots: the rank, or -1 if A is not finite
function symbody_factor_rows!(n, m, A, order, diagonal, beta)
    cut = 1000.0 * m * eps()
    len = [symbody_product(view(A, :, i), view(A, :, i)) for i in 1:m]
    all(x -> x < Inf, len) || return -1
    rank = 0
    while rank < n && rank < m
        k = rank + 1
        share = zeros(eltype(A), m)
        best = zero(eltype(A))
        for i in 1:m
            if len[i] > 0
                tail = view(A, k:n, i)
                share[i] = symbody_product(tail, tail) / len[i]
            end
            best = share[i] > best ? share[i] : best
        end
        best > cut * cut || break
        i = 1
        while !(share[i] > 0.0625 * best)
            i += 1
        end
        order[k] = i
        len[i] = zero(len[i])
        v = view(A, k:n, i)
        square = symbody_product(v, v)
        beta[k] = 1 / (square + sqrt(square) * abs(A[k, i]))
        diagonal[k] = A[k, i] < 0 ? sqrt(square) : -sqrt(square)
        A[k, i] -= diagonal[k]
        for other in 1:m
            if len[other] > 0
                factor = symbody_product(v, view(A, k:n, other)) * beta[k]
                for j in k:n
                    A[j, other] -= factor * A[j, i]
                end
            end
        end
        rank = k
    end
    return rank
end

# B becomes Q' B Q
function symbody_rotate_mass!(n, rank, A, B, order, beta)
    w = zeros(eltype(B), n)
    for k in 1:rank
        v = view(A, :, order[k])
        for i in 1:n
            w[i] = symbody_product(view(B, k:n, i), view(v, k:n)) * beta[k]
        end
        half = 0.5 * (symbody_product(view(w, k:n), view(v, k:n)) * beta[k])
        for j in k:n
            w[j] -= half * v[j]
        end
        for i in 1:k-1, j in k:n
            B[j, i] -= w[i] * v[j]
            B[i, j] = B[j, i]
        end
        for i in k:n, j in k:n
            B[j, i] -= w[i] * v[j] + v[i] * w[j]
        end
    end
    return nothing
end

# Pivoted Cholesky of the trailing block; false if it is not positive definite
function symbody_factor_mass!(n, rank, B, order)
    for k in rank+1:n
        order[k] = k
    end
    for k in rank+1:n
        best = k
        for c in k+1:n
            if B[order[c], order[c]] > B[order[best], order[best]]
                best = c
            end
        end
        order[k], order[best] = order[best], order[k]
        i = order[k]
        B[i, i] > 1000.0 * n * eps() || return false
        B[i, i] = sqrt(B[i, i])
        for row in order[k+1:n]
            B[i, row] /= B[i, i]
        end
        for row in order[k+1:n], column in order[k+1:n]
            B[column, row] -= B[i, row] * B[i, column]
        end
    end
    return true
end

function symbody_reflect!(k, n, v, beta, x)
    total = symbody_product(view(v, k:n), view(x, k:n)) * beta
    for j in k:n
        x[j] -= total * v[j]
    end
    return nothing
end

# The scaled accelerations; g becomes the scaled multipliers.
function symbody_solve_scaled!(n, rank, A, B, order, diagonal, beta, f, g)
    for k in 1:rank
        symbody_reflect!(k, n, view(A, :, order[k]), beta[k], f)
    end
    y = zeros(eltype(B), n)
    for k in 1:rank  # R' y1 = g
        total = g[order[k]]
        for j in 1:k-1
            total -= A[j, order[k]] * y[j]
        end
        y[k] = total / diagonal[k]
    end
    for i in rank+1:n  # B22 y2 = f2 - B21 y1
        y[i] = f[i]
        for j in 1:rank
            y[i] -= B[j, i] * y[j]
        end
    end
    for k in rank+1:n
        i = order[k]
        y[i] /= B[i, i]
        for row in order[k+1:n]
            y[row] -= B[i, row] * y[i]
        end
    end
    for k in n:-1:rank+1
        i = order[k]
        for row in order[k+1:n]
            y[i] -= B[i, row] * y[row]
        end
        y[i] /= B[i, i]
    end
    for k in rank:-1:1  # R lambda = B11 y1 + B12 y2 - f1
        total = -f[k]
        for j in 1:n
            total += B[j, k] * y[j]
        end
        for i in order[k+1:rank]
            total -= A[k, i] * g[i]
        end
        g[order[k]] = total / diagonal[k]
    end
    for k in rank:-1:1
        symbody_reflect!(k, n, view(A, :, order[k]), beta[k], y)
    end
    return y
end
"""
