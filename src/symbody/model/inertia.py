"""Which inertia tensors a body can have."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from symbody.tolerances import TYPED

# A 2 x 2 minor or a determinant of the three entries below is rounded by less than this many units.
_MINOR: Final = 1e-14


def is_possible_inertia(moments: Sequence[float], products: Sequence[float]) -> bool:
    """Return whether a distribution of mass has this tensor.

    Its matrix of second moments, ``tr(I)/2 - I``, must be positive semidefinite, which contains that
    each moment is at most the sum of the other two.

    Parameters
    ----------
    moments : (3,) xx, yy, zz
    products : (3,) tensor entries xy, xz, yz
    """
    scale = max(map(abs, (*moments, *products)))
    if scale == 0:
        return True
    half = sum(moments) / (2 * scale) + TYPED / 2
    a, b, c = (half - moment / scale for moment in moments)
    d, e, f = (-product / scale for product in products)
    minors = (a * b - d * d, a * c - e * e, b * c - f * f)
    return min(a, b, c) >= 0 and min((*minors, determinant([[a, d, e], [d, b, f], [e, f, c]]))) >= -_MINOR


def may_be_about(
    place: Sequence[float], mass: float, moments: Sequence[float], products: Sequence[float]
) -> bool:
    """Return whether a tensor could be about `place` on a body: whether one about the centre remains.

    Of a planar body, which has one moment alone, that moment must not become negative.
    """
    square = sum(x * x for x in place)
    rest = [moment - mass * (square - x * x) for moment, x in zip(moments, place, strict=True)]
    if sum(map(bool, moments)) == 1 and not any(products):
        return max(zip(moments, rest, strict=True))[1] >= 0
    x, y, z = place
    pairs = zip(products, (x * y, x * z, y * z), strict=True)
    return is_possible_inertia(rest, [product + mass * xy for product, xy in pairs])


def determinant(rows: Sequence[Sequence[float]]) -> float:
    """Return the determinant of a 3 x 3 matrix."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
