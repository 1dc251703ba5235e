"""What the numbers of a model say: masses, inertias, axes and rotations that cannot be, or look odd."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from symbody.errors import ExpressionError, Problem
from symbody.expr.formula import Formula
from symbody.expr.graph import Constant
from symbody.model.body import Body
from symbody.model.forces import Drive, SpringDamper
from symbody.model.frame import Frame
from symbody.model.joint import Joint
from symbody.model.numbers import as_float, value_of
from symbody.model.table import Table

# Rounding allowed where inertias of thin bodies are just possible, relative to the largest one.
_ROUNDING: Final = 1e-9
# Rotation matrices typed with 6 digits pass.
_ORTHONORMAL: Final = 1e-5


@dataclass(frozen=True, slots=True)
class Findings:
    """Errors, and remarks on what is legal but unusual."""

    problems: tuple[Problem, ...] = ()
    notes: tuple[str, ...] = ()

    def __add__(self, other: Findings) -> Findings:
        return Findings(self.problems + other.problems, self.notes + other.notes)


class Checker:
    """Values of formulas under given parameters, with the faults of evaluating them."""

    __slots__ = ("_notes", "_problems", "_values")

    def __init__(self, values: Mapping[str, Constant]) -> None:
        self._values = values
        self._problems: list[Problem] = []
        self._notes: list[str] = []

    @property
    def findings(self) -> Findings:
        """What was found so far."""
        return Findings(tuple(self._problems), tuple(self._notes))

    def value(self, formula: Formula, where: str) -> float | None:
        """Return the value of a formula, None if a name has none, and note it if it is not finite."""
        try:
            value = value_of(formula, self._values)
        except ExpressionError as error:
            self._problems.extend(Problem(p.code, where, p.what, p.why, p.fix) for p in error.problems)
            return None
        if value is None:
            return None
        if not math.isfinite(as_float(value)):
            self.refuse("model.not_finite", where, f"{formula} is {as_float(value)} with the values given",
                        "a function has no real value there, or the result is too large", "change the values")  # fmt: skip
            return None
        return as_float(value)

    def values(self, formulas: Iterable[Formula], where: str) -> list[float] | None:
        """Return several values, or None if one is missing."""
        found = [self.value(formula, f"{where}[{k}]") for k, formula in enumerate(formulas)]
        numbers = [value for value in found if value is not None]
        return numbers if len(numbers) == len(found) else None

    def refuse(self, code: str, where: str, what: str, why: str, fix: str) -> None:
        """Note an error."""
        self._problems.append(Problem(code, where, what, why, fix))

    def remark(self, text: str) -> None:
        """Note something legal but unusual."""
        self._notes.append(text)


def check_body(check: Checker, body: Body, label: str) -> None:
    """Check mass, inertia and frames of a body."""
    mass = check.value(body.mass, f"{label}, mass")
    if mass is not None and mass < 0:
        check.refuse("model.negative_mass", f"{label}, mass", f"the mass is {mass:g} kg", "a sign is wrong",
                     "give a positive mass, or 0 for a massless body")  # fmt: skip
    inertia = check.values(body.inertia, f"{label}, inertia")
    products = check.values(body.products, f"{label}, products")
    if inertia is not None and products is not None:
        _check_inertia(check, label, inertia, products)
        _check_size(check, body, label, mass, inertia)
    check_frames(check, body.frames, f"{label}, frames")


def check_frames(check: Checker, frames: Table[Frame], where: str) -> None:
    """Check the rotations of frames."""
    for name, frame in frames.items():
        place = f"{where}.{name}"
        check.values(frame.at, f"{place}.at")
        for k, (axis, angle) in enumerate(frame.rotate):
            if not isinstance(axis, str):
                _check_axis(check, axis, f"{place}.rotate[{k}][0]")
            _check_angle(check, angle, f"{place}.rotate[{k}][1]")
        if frame.matrix is not None:
            rows = [check.values(row, f"{place}.matrix[{k}]") for k, row in enumerate(frame.matrix)]
            _check_matrix(check, [row for row in rows if row is not None], f"{place}.matrix")


def check_joint(check: Checker, joint: Joint, label: str) -> None:
    """Check axes and drives of a joint."""
    for path, axis in joint.axes.items():
        if not isinstance(axis, str):
            _check_axis(check, axis, f"{label}, {path}")
    for drive in joint.drives.values():
        _check_spring(check, drive, label)


def check_spring(check: Checker, spring: SpringDamper, label: str) -> None:
    """Check the coefficients of a spring."""
    _check_spring(check, spring, label)


def _check_spring(check: Checker, spring: Drive | SpringDamper, label: str) -> None:
    for word, formula in (("stiffness", spring.stiffness), ("damping", spring.damping)):
        try:
            value = value_of(formula, check_values(check))
        except ExpressionError:  # told by the equations, which know the states
            continue
        if value is not None and value < 0:
            check.remark(f"{label}: the {word} {formula} is negative ({as_float(value):g})")


def check_values(check: Checker) -> Mapping[str, Constant]:
    """Return the values a checker works with."""
    return check._values


def _check_axis(check: Checker, axis: Sequence[Formula], where: str) -> None:
    values = check.values(axis, where)
    if values is None:
        return
    length = math.hypot(*values)
    if length == 0:
        check.refuse("model.zero_axis", where, "the axis has length zero", "all its components are 0",
                     'give a direction, for instance "z" or [0, 0, 1]')  # fmt: skip
    elif abs(length - 1) > _ROUNDING:
        check.remark(f"{where}: the axis of length {length:g} is normalized")


def _check_angle(check: Checker, angle: Formula, where: str) -> None:
    value = check.value(angle, where)
    if value is not None and abs(value) > 2 * math.pi:
        check.remark(f'{where}: {value:g} rad is more than a turn; degrees are written "{value:g} deg"')


def _check_matrix(check: Checker, r: list[list[float]], where: str) -> None:
    if len(r) < 3:
        return
    products = [(i, j, sum(a * b for a, b in zip(r[i], r[j], strict=True))) for i in range(3) for j in range(i + 1)]
    defect = max(abs(product - (i == j)) for i, j, product in products)
    determinant = _determinant(r)
    if defect > _ORTHONORMAL:
        check.refuse("model.not_a_rotation", where, f"the rows are off an orthonormal set by {defect:.3g}",
                     "rows of a rotation matrix have length 1 and are perpendicular",
                     "give more digits, or use rotate instead")  # fmt: skip
    elif determinant < 0:
        check.refuse("model.not_a_rotation", where, "the determinant is -1: the axes are left-handed",
                     "two rows are exchanged, or one has the wrong sign", "use a right-handed set of axes")  # fmt: skip


def _check_inertia(check: Checker, label: str, inertia: list[float], products: list[float]) -> None:
    """Check that a distribution of mass with this tensor exists: its second moments are not negative."""
    if _is_possible(inertia, products):
        return
    a, b, c = inertia
    if not any(products):
        check.refuse("model.impossible_inertia", f"{label}, inertia",
                     f"no body has the moments {a:g}, {b:g}, {c:g}: each is at most the sum of the other two",
                     "an entry is wrong or in another place; in a plane only the one about the normal matters",
                     _inertia_cure(inertia))  # fmt: skip
        return
    signs = " It would be possible with the products' signs changed." if _is_possible(
        inertia, [-p for p in products]) else ""  # fmt: skip
    check.refuse("model.impossible_inertia", f"{label}, inertia",
                 f"no body has the inertia {a:g}, {b:g}, {c:g} with products {', '.join(f'{p:g}' for p in products)}."
                 + signs, "products are the tensor entries xy, xz, yz, as in URDF",
                 "check values, signs and that they refer to the centre of mass")  # fmt: skip


def _inertia_cure(inertia: list[float]) -> str:
    if min(inertia) < 0:
        return "give moments that are not negative"
    largest = max(inertia)
    half = f"{largest / 2:g}"
    cure = [f"{value:g}" if value == largest else f"at least {half}" for value in inertia]
    return "for instance " + ", ".join(cure)


def _is_possible(inertia: list[float], products: list[float]) -> bool:
    """Return whether tr(I)/2 - I, the matrix of second moments, is positive semidefinite."""
    half, slack = sum(inertia) / 2, _ROUNDING * max(map(abs, (*inertia, *products)), default=0.0)
    a, b, c = (half - moment + slack for moment in inertia)
    d, e, f = (-product for product in products)
    scale = slack * max(a, b, c, 0.0)
    minors = (a * b - d * d, a * c - e * e, b * c - f * f)
    determinant = a * minors[2] - d * (d * c - e * f) + e * (d * f - b * e)
    return min(a, b, c) >= 0 and min(minors) >= -scale and determinant >= -scale * max(a, b, c)


def _check_size(check: Checker, body: Body, label: str, mass: float | None, inertia: list[float]) -> None:
    """Remark on a radius of gyration that is 1,000 times larger or smaller than the body's frames."""
    places = [check.values(frame.at, f"{label}, frames") for frame in body.frames.values()]
    reach = max((math.hypot(*place) for place in places if place is not None), default=0.0)
    if not mass or not reach or not max(inertia) > 0 or mass < 0:
        return
    ratio = math.sqrt(max(inertia) / mass) / reach
    if not 1e-3 < ratio < 1e3:
        check.remark(f"{label}: the radius of gyration is {ratio:.2g} times the distance of the farthest frame; "
                     "are lengths in m and inertias in kg m^2?")  # fmt: skip


def _determinant(r: list[list[float]]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = r
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
