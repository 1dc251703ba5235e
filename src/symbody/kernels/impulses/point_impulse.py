"""The impulse at one point: along the normal, and within Coulomb's cone across it, exactly.

With the rates b that the point would have without its own impulse P, the rates are ``b + G P``. Sticking has
none across; slipping has ``P_t = -P_n mu v/abs(v)``, which is ``(G_tt + k) P_t + G_tn P_n + b_t = 0`` with
the one curb k >= 0 at which the norm of P_t is ``mu P_n``. Where sticking needs too much, such a curb exists:
with growing k the impulse across vanishes. It is found between bounds.
"""

from __future__ import annotations

from typing import Final

from symbody.kernels.language import Reals, is_finite, sqrt

NEARLY: Final = 4.0e-16
FLAT: Final = 1e-14  # share of a diagonal entry below which a pivot is rounding


def solve_curbed(rows: int, first: int, G: Reals, b: Reals, curb: float, P: Reals, A: Reals) -> None:
    """Set P (rows,) to the solution of ``(G + curb) P = -b``, the curb in rows from `first` on.

    Rows that follow from others get none. A is scratch (9,).
    """
    for i in range(rows):
        P[i] = -b[i]
        for j in range(rows):
            A[3 * i + j] = G[3 * i + j]
        if i >= first:
            A[4 * i] = A[4 * i] + curb
    for k in range(rows):
        size = G[4 * k]
        if k >= first:
            size = size + curb
        if A[4 * k] > FLAT * size:
            for i in range(k + 1, rows):
                share = A[3 * i + k] / A[4 * k]
                for j in range(k + 1, rows):
                    A[3 * i + j] = A[3 * i + j] - share * A[3 * k + j]
                P[i] = P[i] - share * P[k]
        else:
            A[4 * k] = 0.0
    for i in range(rows - 1, -1, -1):
        total = P[i]
        for j in range(i + 1, rows):
            total = total - A[3 * i + j] * P[j]
        if A[4 * i] > 0.0:
            P[i] = total / A[4 * i]
        else:
            P[i] = 0.0


def excess(rows: int, first: int, strength: float, pressing: float, P: Reals) -> float:
    """Return by how much an impulse across the normal is over what friction can do."""
    total = 0.0
    for i in range(first, rows):
        total = total + P[i] * P[i]
    normal = pressing
    if first == 1:
        normal = P[0]
    return sqrt(total) - strength * normal


def largest_across(rows: int, first: int, P: Reals) -> float:
    """Return the largest entry of an impulse across the normal."""
    most = 0.0
    for i in range(first, rows):
        most = max(most, abs(P[i]))
    return most


def solve_point(
    rows: int, first: int, strength: float, limit: float, pressing: float, G: Reals, b: Reals, curb: float,
    P: Reals, A: Reals,
) -> float:  # fmt: skip
    """Set P (rows,) to the impulse at a point; return the share of the curb of its slip, 0 without slip.

    Parameters
    ----------
    rows, first : int
        How many rows it has; 1 where the first one is a gap, else 0.
    strength, limit : float
        Of friction while it slips and up to which it sticks.
    pressing : float
        What these multiply where there is no gap.
    curb : float
        Where to begin the search.
    """
    for i in range(rows):
        P[i] = 0.0
    if first == 1:
        if not b[0] < 0.0 or not G[0] > 0.0:
            return 0.0
        P[0] = -b[0] / G[0]
    if rows == first:
        return 0.0
    solve_curbed(rows, first, G, b, 0.0, P, A)
    if not excess(rows, first, limit, pressing, P) > 0.0:
        if first == 0 or P[0] >= 0.0:
            return 0.0
    return search_curb(rows, first, strength, pressing, G, b, curb, P, A)


def search_curb(
    rows: int, first: int, strength: float, pressing: float, G: Reals, b: Reals, begin: float, P: Reals,
    A: Reals,
) -> float:  # fmt: skip
    """Set P to the impulse of a point that slips; return the share of its curb.

    The curb k is looked for by the share ``g/(g + k)`` from 0 to 1, g the largest response across: the impulse
    across grows nearly as that.
    """
    stiffest = G[4 * first]
    if rows > first + 1:
        stiffest = max(stiffest, G[4 * first + 4])
    pushes = pressing
    if first == 1:
        pushes = max(0.0, -b[0] / G[0])
    low = 0.0
    below = -strength * pushes
    high = 1.0
    above = excess(rows, first, strength, pressing, P)
    share = begin
    side = 0
    if not below < 0.0 or not stiffest > 0.0:
        high = 0.0
    while high - low > NEARLY * high:
        if not (share > low and share < high):
            share = (low * above - high * below) / (above - below)
        if not (share > low and share < high):
            share = 0.5 * (low + high)
        if not (share > low and share < high):
            break
        solve_curbed(rows, first, G, b, stiffest * (1.0 - share) / share, P, A)
        value = excess(rows, first, strength, pressing, P)
        if abs(value) <= NEARLY * largest_across(rows, first, P):
            low = share
            high = share
        elif value > 0.0:
            high = share
            above = value
            if side == 1:
                below = 0.5 * below
            side = 1
        else:
            low = share
            below = value
            if side == 2:
                above = 0.5 * above
            side = 2
        share = (low * above - high * below) / (above - below)
    if not low > 0.0:
        for i in range(rows):
            P[i] = 0.0
        if first == 1:
            P[0] = pushes
        return 0.0
    solve_curbed(rows, first, G, b, stiffest * (1.0 - low) / low, P, A)
    if first == 1:
        if not P[0] > 0.0 or not is_finite(P[0]):
            for i in range(rows):
                P[i] = 0.0
            P[0] = pushes
    return low
