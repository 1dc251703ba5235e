"""The kernel `solve_saddle` as MATLAB text, to be put once into every function file that needs it.

The steps of `expr.saddle` and `expr.saddle_factors` on whole rows: sums are the language's own, so results
may differ from the others' in their last bits.
"""

from __future__ import annotations

from typing import Final

SADDLE_MATLAB: Final = r"""
function solution = symbody_solve_saddle(n, m, values)
% M udot = F + J' lambda, J udot = gamma: udot, lambda and the rank of J. Rows of J that depend on others to
% rounding are left out, and their multipliers 0. All but the rank are nan where M is not positive definite
% on the null space of J, or J is not finite.
values = values(:);
M = reshape(values(1:n*n), n, n)';
J = reshape(values(n*n+(1:m*n)), n, m)';
F = values(n*n+m*n+(1:n));
gamma = values(n*n+m*n+n+(1:m));
[d, r] = symbody_scales(n, m, M, J);
A = J .* (r * d');
B = M .* (d * d');
[A, order, diagonal, beta, rank] = symbody_factor_rows(n, m, A);
solution = [NaN(n + m, 1); max(rank, 0)];
if rank < 0
    return
end
B = symbody_rotate_mass(n, rank, A, B, order, beta);
[B, order, solvable] = symbody_factor_mass(n, rank, B, order);
if ~solvable
    return
end
udot = zeros(n, 1);
lambda = zeros(m, 1);
kept = order(1:rank, 1);
for step = 1:2  % the solution, then its refinement
    f = (F + J(kept, :)' * lambda(kept, 1) - M * udot) .* d;
    g = (gamma - J * udot) .* r;
    for k = 1:rank
        f = symbody_reflect(k, A(kept(k), :)', beta(k), f);
    end
    y = zeros(n, 1);
    for k = 1:rank  % R' y1 = g
        y(k) = (g(kept(k)) - A(kept(k), 1:k-1) * y(1:k-1, 1)) / diagonal(k);
    end
    rest = rank+1:n;  % B22 y2 = f2 - B21 y1
    y(rest) = f(rest) - B(rest, 1:rank) * y(1:rank, 1);
    for k = rest
        i = order(k);
        later = order(k+1:n, 1);
        y(i) = y(i) / B(i, i);
        y(later, 1) = y(later, 1) - B(later, i) * y(i);
    end
    for k = n:-1:rank+1
        i = order(k);
        later = order(k+1:n, 1);
        y(i) = (y(i) - B(later, i)' * y(later, 1)) / B(i, i);
    end
    for k = rank:-1:1  % R lambda = B11 y1 + B12 y2 - f1
        later = order(k+1:rank, 1);
        g(kept(k)) = (B(k, :) * y - f(k) - A(later, k)' * g(later, 1)) / diagonal(k);
    end
    for k = rank:-1:1
        y = symbody_reflect(k, A(kept(k), :)', beta(k), y);
    end
    udot = udot + d .* y;
    lambda(kept, 1) = lambda(kept, 1) + r(kept, 1) .* g(kept, 1);
end
solution = [udot; lambda; rank];
end

function [d, r] = symbody_scales(n, m, M, J)
% Powers of two that bring diag(M) and the largest entries of the rows of J to about 1
mass = diag(M);
heaviest = max([mass; 0]);
idle = ~(mass > 0);
mass(idle) = heaviest;
mass = max(mass, 2^-40 * heaviest);
d = zeros(n, 1);
for j = 1:n
    e = symbody_exponent(mass(j));
    d(j) = 2^(-floor(e / 2));
end
r = zeros(m, 1);
for i = 1:m
    r(i) = 2^(-symbody_exponent(max(abs(J(i, :)') .* d)));
end
for j = find(idle)'
    d(j) = d(j) * 2^(-symbody_exponent(max([abs(J(:, j)) .* r * d(j); 0])));
end
end

function e = symbody_exponent(x)
e = 0;
if x > 0 && x < Inf
    [~, e] = log2(x);
    e = min(max(e, -1022), 1022);
end
end

function [A, order, diagonal, beta, rank] = symbody_factor_rows(n, m, A)
% A' P = Q R by Householder reflections with pivots; rank -1 if A is not finite
cut = 1000 * m * eps;
order = zeros(n, 1);
diagonal = zeros(n, 1);
beta = zeros(n, 1);
rank = 0;
len = sum(A .* A, 2);
if ~all(len < Inf)
    rank = -1;
    return
end
while rank < n && rank < m
    k = rank + 1;
    share = zeros(m, 1);
    left = len > 0;
    share(left) = sum(A(left, k:n) .* A(left, k:n), 2) ./ len(left, 1);
    best = max([share; 0]);
    if ~(best > cut * cut)
        break
    end
    i = find(share > 0.0625 * best, 1);
    order(k) = i;
    len(i) = 0;
    square = sum(A(i, k:n) .* A(i, k:n));
    beta(k) = 1 / (square + sqrt(square) * abs(A(i, k)));
    diagonal(k) = -sqrt(square);
    if A(i, k) < 0
        diagonal(k) = sqrt(square);
    end
    A(i, k) = A(i, k) - diagonal(k);
    for other = find(len > 0)'
        factor = sum(A(i, k:n) .* A(other, k:n)) * beta(k);
        A(other, k:n) = A(other, k:n) - factor * A(i, k:n);
    end
    rank = k;
end
end

function B = symbody_rotate_mass(n, rank, A, B, order, beta)
% B becomes Q' B Q
for k = 1:rank
    v = A(order(k), k:n)';
    w = B(:, k:n) * v * beta(k);
    w(k:n) = w(k:n) - 0.5 * (w(k:n)' * v * beta(k)) * v;
    B(1:k-1, k:n) = B(1:k-1, k:n) - w(1:k-1) * v';
    B(k:n, 1:k-1) = B(1:k-1, k:n)';
    B(k:n, k:n) = B(k:n, k:n) - (w(k:n) * v' + v * w(k:n)');
end
end

function [B, order, solvable] = symbody_factor_mass(n, rank, B, order)
% Pivoted Cholesky of the trailing block; not solvable if it is not positive definite
solvable = false;
order(rank+1:n) = rank+1:n;
for k = rank+1:n
    pivots = diag(B);
    [~, best] = max(pivots(order(k:n)));
    order([k, k+best-1]) = order([k+best-1, k]);
    i = order(k);
    if ~(B(i, i) > 1000 * n * eps)
        return
    end
    B(i, i) = sqrt(B(i, i));
    later = order(k+1:n, 1);
    B(later, i) = B(later, i) / B(i, i);
    B(later, later) = B(later, later) - B(later, i) * B(later, i)';
end
solvable = true;
end

function x = symbody_reflect(k, v, beta, x)
x(k:end) = x(k:end) - (v(k:end)' * x(k:end) * beta) * v(k:end);
end
"""
