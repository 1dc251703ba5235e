"""Calls of a function in a chain, in the kernel language."""

from __future__ import annotations

from symbody.kernels.language import Function, Reals, part


def chain_calls(
    f: Function, count: int, n_u: int, n_q: int, states: Reals, link: float, t: Reals, r: Reals, c: Reals,
    work: Reals, place: Reals, out: Reals,
) -> None:  # fmt: skip
    """Call a right-hand side at all states; unless `link` is 0, each waits for the result before."""
    n = n_u + n_q
    for k in range(count):
        if link == 0.0:
            x = part(states, k * n, n)
            f(t, part(x, n_u, n_q), x, r, r, c, out, work)
        else:
            for i in range(n):
                place[i] = states[k * n + i] + link * out[i]
            f(t, part(place, n_u, n_q), place, r, r, c, out, work)
