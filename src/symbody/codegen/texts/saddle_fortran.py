"""The kernel `solve_saddle` as Fortran text, to be put once into every module that needs it.

Operation for operation the loops of `expr.saddle` and `expr.saddle_factors`. Matrices come by rows, so the
first index runs along a row: J(j, i) is entry j of row i.
"""

from __future__ import annotations

from typing import Final

SADDLE_FORTRAN: Final = r"""
! M udot = F + J^T lambda, J udot = gamma: udot, lambda and the rank of J. Rows of J that depend on others to
! rounding are left out, and their multipliers 0. All but the rank are nan where M is not positive definite
! on the null space of J, or J is not finite.
subroutine symbody_solve_saddle(n, m, mass, J, F, gamma, solution)
    integer, intent(in) :: n, m
    real(dp), intent(in) :: mass(n, n), J(n, m), F(n), gamma(m)
    real(dp), intent(out) :: solution(n + m + 1)
    real(dp) :: A(n, m), B(n, n), d(n), r(m), diagonal(n), beta(n), y(n)
    real(dp) :: scaled_force(n), scaled_gamma(m), total
    integer :: order(n), rank, i, k, l, step
    logical :: is_solvable
    call symbody_scales(n, m, mass, J, d, r)
    do i = 1, m
        A(:, i) = J(:, i) * r(i) * d
    end do
    do i = 1, n
        B(:, i) = mass(:, i) * d(i) * d
    end do
    call symbody_factor_rows(n, m, A, order, diagonal, beta, rank, is_solvable)
    if (is_solvable) call symbody_rotate_mass(n, m, rank, A, B, order, beta)
    if (is_solvable) call symbody_factor_mass(n, rank, B, order, is_solvable)
    solution = merge(0.0_dp, ieee_value(1.0_dp, ieee_quiet_nan), is_solvable)
    solution(n + m + 1) = real(rank, dp)
    if (.not. is_solvable) return
    do step = 1, 2 ! the solution, then its refinement
        do l = 1, n
            total = F(l)
            do k = 1, rank
                total = total + J(l, order(k)) * solution(n + order(k))
            end do
            do i = 1, n
                total = total - mass(i, l) * solution(i)
            end do
            scaled_force(l) = total * d(l)
        end do
        do k = 1, rank
            i = order(k)
            total = gamma(i)
            do l = 1, n
                total = total - J(l, i) * solution(l)
            end do
            scaled_gamma(i) = total * r(i)
        end do
        call symbody_solve_scaled(n, m, rank, A, B, order, diagonal, beta, scaled_force, scaled_gamma, y)
        solution(1:n) = solution(1:n) + d * y
        do k = 1, rank
            i = order(k)
            solution(n + i) = solution(n + i) + r(i) * scaled_gamma(i)
        end do
    end do
end subroutine symbody_solve_saddle

! Power of two that brings x, or its root, to about 1; 1 if x is 0 or not finite.
function symbody_scale(x, is_root) result(factor)
    real(dp), intent(in) :: x
    logical, intent(in) :: is_root
    real(dp) :: factor
    integer :: e
    factor = 1.0_dp
    if (.not. (x > 0.0_dp .and. x <= huge(x))) return
    e = min(max(exponent(x), -1022), 1022)
    if (is_root) e = (e - modulo(e, 2)) / 2
    factor = scale(1.0_dp, -e)
end function symbody_scale

subroutine symbody_scales(n, m, mass, J, d, r)
    integer, intent(in) :: n, m
    real(dp), intent(in) :: mass(n, n), J(n, m)
    real(dp), intent(out) :: d(n), r(m)
    real(dp) :: heaviest, weight, top
    integer :: i, k
    heaviest = 0.0_dp
    do k = 1, n
        if (mass(k, k) > heaviest) heaviest = mass(k, k)
    end do
    do k = 1, n
        weight = merge(mass(k, k), heaviest, mass(k, k) > 0.0_dp)
        if (weight < 2.0_dp**(-40) * heaviest) weight = 2.0_dp**(-40) * heaviest
        d(k) = symbody_scale(weight, .true.)
    end do
    do i = 1, m
        top = 0.0_dp
        do k = 1, n
            if (abs(J(k, i)) * d(k) > top) top = abs(J(k, i)) * d(k)
        end do
        r(i) = symbody_scale(top, .false.)
    end do
    do k = 1, n
        if (mass(k, k) > 0.0_dp) cycle
        top = 0.0_dp
        do i = 1, m
            if (abs(J(k, i)) * r(i) * d(k) > top) top = abs(J(k, i)) * r(i) * d(k)
        end do
        d(k) = d(k) * symbody_scale(top, .false.)
    end do
end subroutine symbody_scales

function symbody_product(a, b) result(total)
    real(dp), intent(in) :: a(:), b(:)
    real(dp) :: total
    integer :: k
    total = 0.0_dp
    do k = 1, size(a)
        total = total + a(k) * b(k)
    end do
end function symbody_product

! A^T P = Q R by Householder reflections with pivots; unsolvable if A is not finite
subroutine symbody_factor_rows(n, m, A, order, diagonal, beta, rank, is_solvable)
    integer, intent(in) :: n, m
    real(dp), intent(inout) :: A(n, m)
    integer, intent(out) :: order(n), rank
    real(dp), intent(out) :: diagonal(n), beta(n)
    logical, intent(out) :: is_solvable
    real(dp) :: length(m), share(m), best, cut, square, factor
    integer :: i, k, other
    cut = 1000.0_dp * m * epsilon(1.0_dp)
    order = 0
    diagonal = 0.0_dp
    beta = 0.0_dp
    rank = 0
    do i = 1, m
        length(i) = symbody_product(A(:, i), A(:, i))
    end do
    is_solvable = all(length <= huge(cut))
    do while (is_solvable .and. rank < n .and. rank < m)
        k = rank + 1
        best = 0.0_dp
        do i = 1, m
            share(i) = 0.0_dp
            if (length(i) > 0.0_dp) share(i) = symbody_product(A(k:, i), A(k:, i)) / length(i)
            if (share(i) > best) best = share(i)
        end do
        if (.not. best > cut * cut) exit
        i = 1
        do while (.not. share(i) > 0.0625_dp * best)
            i = i + 1
        end do
        order(k) = i
        length(i) = 0.0_dp
        square = symbody_product(A(k:, i), A(k:, i))
        beta(k) = 1.0_dp / (square + sqrt(square) * abs(A(k, i)))
        diagonal(k) = merge(sqrt(square), -sqrt(square), A(k, i) < 0.0_dp)
        A(k, i) = A(k, i) - diagonal(k)
        do other = 1, m
            if (.not. length(other) > 0.0_dp) cycle
            factor = symbody_product(A(k:, i), A(k:, other)) * beta(k)
            A(k:, other) = A(k:, other) - factor * A(k:, i)
        end do
        rank = k
    end do
end subroutine symbody_factor_rows

! B becomes Q^T B Q.
subroutine symbody_rotate_mass(n, m, rank, A, B, order, beta)
    integer, intent(in) :: n, m, rank, order(n)
    real(dp), intent(in) :: A(n, m), beta(n)
    real(dp), intent(inout) :: B(n, n)
    real(dp) :: v(n), w(n), half
    integer :: i, k, l
    do k = 1, rank
        v = A(:, order(k))
        do i = 1, n
            w(i) = symbody_product(B(k:, i), v(k:)) * beta(k)
        end do
        half = 0.5_dp * (symbody_product(w(k:), v(k:)) * beta(k))
        w(k:) = w(k:) - half * v(k:)
        do i = 1, k - 1
            do l = k, n
                B(l, i) = B(l, i) - w(i) * v(l)
                B(i, l) = B(l, i)
            end do
        end do
        do i = k, n
            B(k:, i) = B(k:, i) - (w(i) * v(k:) + v(i) * w(k:))
        end do
    end do
end subroutine symbody_rotate_mass

! Pivoted Cholesky of the trailing block; unsolvable if it is not positive definite.
subroutine symbody_factor_mass(n, rank, B, order, is_solvable)
    integer, intent(in) :: n, rank
    real(dp), intent(inout) :: B(n, n)
    integer, intent(inout) :: order(n)
    logical, intent(out) :: is_solvable
    integer :: best, c, i, k, row
    is_solvable = .false.
    do k = rank + 1, n
        order(k) = k
    end do
    do k = rank + 1, n
        best = k
        do c = k + 1, n
            if (B(order(c), order(c)) > B(order(best), order(best))) best = c
        end do
        i = order(best)
        order(best) = order(k)
        order(k) = i
        if (.not. B(i, i) > 1000.0_dp * n * epsilon(1.0_dp)) return
        B(i, i) = sqrt(B(i, i))
        do c = k + 1, n
            B(i, order(c)) = B(i, order(c)) / B(i, i)
        end do
        do c = k + 1, n
            row = order(c)
            B(order(k + 1:), row) = B(order(k + 1:), row) - B(i, row) * B(i, order(k + 1:))
        end do
    end do
    is_solvable = .true.
end subroutine symbody_factor_mass

subroutine symbody_reflect(k, v, beta, x)
    integer, intent(in) :: k
    real(dp), intent(in) :: v(:), beta
    real(dp), intent(inout) :: x(:)
    real(dp) :: total
    total = symbody_product(v(k:), x(k:)) * beta
    x(k:) = x(k:) - total * v(k:)
end subroutine symbody_reflect

! The scaled accelerations y; g becomes the scaled multipliers.
subroutine symbody_solve_scaled(n, m, rank, A, B, order, diagonal, beta, f, g, y)
    integer, intent(in) :: n, m, rank, order(n)
    real(dp), intent(in) :: A(n, m), B(n, n), diagonal(n), beta(n)
    real(dp), intent(inout) :: f(n), g(m)
    real(dp), intent(out) :: y(n)
    real(dp) :: total
    integer :: c, i, k
    do k = 1, rank
        call symbody_reflect(k, A(:, order(k)), beta(k), f)
    end do
    do k = 1, rank ! R^T y1 = g
        total = g(order(k))
        do c = 1, k - 1
            total = total - A(c, order(k)) * y(c)
        end do
        y(k) = total / diagonal(k)
    end do
    do i = rank + 1, n ! B22 y2 = f2 - B21 y1
        total = f(i)
        do c = 1, rank
            total = total - B(c, i) * y(c)
        end do
        y(i) = total
    end do
    do k = rank + 1, n
        i = order(k)
        y(i) = y(i) / B(i, i)
        do c = k + 1, n
            y(order(c)) = y(order(c)) - B(i, order(c)) * y(i)
        end do
    end do
    do k = n, rank + 1, -1
        i = order(k)
        total = y(i)
        do c = k + 1, n
            total = total - B(i, order(c)) * y(order(c))
        end do
        y(i) = total / B(i, i)
    end do
    do k = rank, 1, -1 ! R lambda = B11 y1 + B12 y2 - f1
        total = -f(k)
        do c = 1, n
            total = total + B(c, k) * y(c)
        end do
        do c = k + 1, rank
            total = total - A(k, order(c)) * g(order(c))
        end do
        g(order(k)) = total / diagonal(k)
    end do
    do k = rank, 1, -1
        call symbody_reflect(k, A(:, order(k)), beta(k), y)
    end do
end subroutine symbody_solve_scaled
"""
