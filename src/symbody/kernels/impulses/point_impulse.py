"""The impulse at one point: along the normal, and within Coulomb's cone across it, exactly.

With the rates b that the point would have without its own impulse P, the rates are ``b + G P``. Sticking has
none across; slipping has ``P_t = -P_n mu v/abs(v)``, which is ``(G_tt + k) P_t + G_tn P_n + b_t = 0`` with
the one multiplier k >= 0, of the bound on P_t, at which the norm of P_t is ``mu P_n``. Where sticking needs
too much, such a multiplier exists: with growing k the impulse across vanishes. It is found between bounds.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Reals, is_finite, part, sqrt

NEARLY: Final = 4.0e-16
FLAT: Final = 1e-14  # share of a diagonal entry below which a pivot is rounding

# Scratch: a matrix (9,), then the bracket of a search.
LOW: Final = 0  # a share of the multiplier at which the point can slip, and by how much
BELOW: Final = 1
HIGH: Final = 2  # one at which friction cannot do what it takes
ABOVE: Final = 3
SIDE: Final = 4  # which of both was found last
SCRATCH: Final = 16


def solve_with_multiplier(
    rows: int, first: int, G: Reals, b: Reals, multiplier: float, P: Reals, A: Reals
) -> None:  # fmt: skip
    """Set P (rows,) to the solution of ``(G + multiplier) P = -b``, the multiplier in rows from `first` on.

    Rows that follow from others get none. A is scratch (9,).
    """
    for i in range(rows):
        P[i] = -b[i]
        for j in range(rows):
            A[3 * i + j] = G[3 * i + j]
        if i >= first:
            A[4 * i] = A[4 * i] + multiplier
    for k in range(rows):
        size = G[4 * k]
        if k >= first:
            size = size + multiplier
        if not A[4 * k] > FLAT * size:
            A[4 * k] = 0.0
        else:
            eliminate_row(rows, k, A, P)
    for i in range(rows - 1, -1, -1):
        total = P[i]
        for j in range(i + 1, rows):
            total = total - A[3 * i + j] * P[j]
        P[i] = 0.0
        if A[4 * i] > 0.0:
            P[i] = total / A[4 * i]


def eliminate_row(rows: int, k: int, A: Reals, P: Reals) -> None:
    """Take a row of a matrix (3, 3) from those below, and of the right-hand side P."""
    for i in range(k + 1, rows):
        share = A[3 * i + k] / A[4 * k]
        for j in range(k + 1, rows):
            A[3 * i + j] = A[3 * i + j] - share * A[3 * k + j]
        P[i] = P[i] - share * P[k]


def friction_excess(rows: int, first: int, strength: float, pressing: float, P: Reals) -> float:
    """Return by how much an impulse across the normal is over what friction can do."""
    normal = pressing
    if first == 1:
        normal = P[0]
    return norm_across(rows, first, P) - strength * normal


def norm_across(rows: int, first: int, P: Reals) -> float:
    """Return the norm of an impulse across the normal."""
    total = 0.0
    for i in range(first, rows):
        total = total + P[i] * P[i]
    return sqrt(total)


def solve_point(
    rows: int, first: int, strength: float, limit: float, pressing: float, G: Reals, b: Reals, begin: float,
    P: Reals, A: Reals,
) -> float:  # fmt: skip
    """Set P (rows,) to the impulse at a point; return the share of its multiplier, 0 without slip.

    Parameters
    ----------
    rows, first : int
        How many rows it has; 1 where the first one is a gap, else 0.
    strength, limit : float
        Of friction while it slips and up to which it sticks.
    pressing : float
        What these multiply where there is no gap.
    begin : float
        Where to begin the search; nothing depends on it but how long that takes.
    A : array
        Scratch.
    """
    for i in range(rows):
        P[i] = 0.0
    if first == 1:
        if not b[0] < 0.0 or not G[0] > 0.0:
            return 0.0
        P[0] = -b[0] / G[0]
    if rows == first:
        return 0.0
    solve_with_multiplier(rows, first, G, b, 0.0, P, A)
    if not friction_excess(rows, first, limit, pressing, P) > 0.0:
        if first == 0 or P[0] >= 0.0:
            return 0.0
    return search_multiplier(rows, first, strength, pressing, G, b, begin, P, A)


def search_multiplier(
    rows: int, first: int, strength: float, pressing: float, G: Reals, b: Reals, begin: float, P: Reals,
    A: Reals,
) -> float:  # fmt: skip
    """Set P to the impulse of a point that slips; return the share of its multiplier.

    The multiplier k is looked for by the share ``g/(g + k)`` from 0 to 1, g the largest response across: the
    impulse across grows nearly as that.
    """
    stiffest = stiffest_across(rows, first, G)
    pushes = pressing
    if first == 1:
        pushes = -b[0] / G[0]
    bracket = part(A, 9, 5)
    bracket[LOW] = 0.0
    bracket[BELOW] = -strength * pushes
    bracket[HIGH] = 1.0
    bracket[ABOVE] = friction_excess(rows, first, strength, pressing, P)
    bracket[SIDE] = 0.0
    if not bracket[BELOW] < 0.0 or not stiffest > 0.0:
        bracket[HIGH] = 0.0
    share = begin
    while bracket[HIGH] - bracket[LOW] > NEARLY * bracket[HIGH]:
        share = inner_share(bracket, share)
        if is_inside(bracket, share) == 0:
            break
        solve_with_multiplier(rows, first, G, b, stiffest * (1.0 - share) / share, P, A)
        narrow(
            bracket, share, friction_excess(rows, first, strength, pressing, P), norm_across(rows, first, P)
        )
        share = 0.0
    low = bracket[LOW]
    if low > 0.0:
        solve_with_multiplier(rows, first, G, b, stiffest * (1.0 - low) / low, P, A)
        if first == 0 or P[0] > 0.0 and is_finite(P[0]):
            return low
    for i in range(first, rows):
        P[i] = 0.0
    if first == 1:
        P[0] = pushes
    return 0.0


def stiffest_across(rows: int, first: int, G: Reals) -> float:
    """Return the largest response across the normal."""
    stiffest = G[4 * first]
    if rows > first + 1:
        stiffest = max(stiffest, G[4 * first + 4])
    return stiffest


def is_inside(bracket: Reals, share: float) -> int:
    """Return 1 if a share lies between the bounds, else 0."""
    if share > bracket[LOW] and share < bracket[HIGH]:
        return 1
    return 0


def inner_share(bracket: Reals, begin: float) -> float:
    """Return a share between the bounds: one given, where the chord has its zero, or the middle."""
    if is_inside(bracket, begin) == 1:
        return begin
    above = bracket[ABOVE]
    below = bracket[BELOW]
    share = (bracket[LOW] * above - bracket[HIGH] * below) / (above - below)
    if is_inside(bracket, share) == 1:
        return share
    return 0.5 * (bracket[LOW] + bracket[HIGH])


def narrow(bracket: Reals, share: float, value: float, size: float) -> None:
    """Make a share a bound, by the excess there; the other counts half if it stays twice (Illinois)."""
    if abs(value) <= NEARLY * size:
        bracket[LOW] = share
        bracket[HIGH] = share
    elif value > 0.0:
        bracket[HIGH] = share
        bracket[ABOVE] = value
        if bracket[SIDE] == 1.0:
            bracket[BELOW] = 0.5 * bracket[BELOW]
        bracket[SIDE] = 1.0
    else:
        bracket[LOW] = share
        bracket[BELOW] = value
        if bracket[SIDE] == 2.0:
            bracket[ABOVE] = 0.5 * bracket[ABOVE]
        bracket[SIDE] = 2.0
