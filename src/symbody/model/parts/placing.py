"""Frames of a part's ground placed on the body that takes its place, as formulas."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from symbody.expr.language.formula import Formula
from symbody.model.declarations.arguments import ZERO
from symbody.model.declarations.formula_site import Triple
from symbody.model.frame import Frame
from symbody.model.shapes.shape import BodyShape

P = TypeVar("P", Frame, BodyShape)


def place_frame(base: Frame, frame: Frame) -> Frame:
    """Return a frame given in the axes of `base` in the axes of the body on which that stands.

    Raises
    ------
    NotImplementedError
        If the rotation cannot be written with sines and cosines of the angles of `base`; it says what it is.
    """
    return _place(base, frame)


def place_shape(base: Frame, shape: BodyShape) -> BodyShape:
    """Return a shape in the axes of the body on which `base` stands; see `place_frame`."""
    return _place(base, shape)


def _place(base: Frame, item: P) -> P:
    if base == Frame():
        return item
    at = _sum(base.at, _rotate(base, item.at))
    if base.matrix is not None and not item.rotate and item.matrix is None:
        return replace(item, at=at, matrix=base.matrix)
    if item.matrix is not None and not base.rotate and base.matrix is None:
        return replace(item, at=at)
    if base.matrix is not None or item.matrix is not None:
        raise NotImplementedError("a matrix, as well as the frame on it")
    return replace(item, at=at, rotate=(*base.rotate, *item.rotate))


def _rotate(base: Frame, vector: Triple) -> Triple:
    if base.matrix is not None:
        x, y, z = (_sum_of(_product(a, b) for a, b in zip(row, vector, strict=True)) for row in base.matrix)
        return (x, y, z)
    for axis, angle in reversed(base.rotate):
        if not isinstance(axis, str):
            raise NotImplementedError("an angle about an oblique axis")
        vector = _turn(axis, angle, vector)
    return vector


def _turn(axis: str, angle: Formula, vector: Triple) -> Triple:
    """Return a vector turned about a letter's axis."""
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    c, s = Formula.from_value(f"cos({angle.text})"), Formula.from_value(f"sin({angle.text})")
    entries = list(vector)
    entries[i] = _difference(_product(c, vector[i]), _product(s, vector[j]))
    entries[j] = _sum_of((_product(s, vector[i]), _product(c, vector[j])))
    x, y, z = entries
    return (x, y, z)


def _sum(a: Triple, b: Triple) -> Triple:
    x, y, z = (_sum_of(pair) for pair in zip(a, b, strict=True))
    return (x, y, z)


def _sum_of(terms: Iterable[Formula]) -> Formula:
    shown = [term for term in terms if term.constant() != 0]
    if not shown:
        return ZERO
    return shown[0] if len(shown) == 1 else Formula.from_value(" + ".join(f"({x.text})" for x in shown))


def _product(a: Formula, b: Formula) -> Formula:
    if a.constant() == 0 or b.constant() == 0:
        return ZERO
    if b.constant() == 1:
        return a
    return b if a.constant() == 1 else Formula.from_value(f"({a.text})*({b.text})")


def _difference(a: Formula, b: Formula) -> Formula:
    if b.constant() == 0:
        return a
    return Formula.from_value(f"-({b.text})" if a.constant() == 0 else f"({a.text}) - ({b.text})")
