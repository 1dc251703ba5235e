"""`singular_configurations`: where independent coordinates do not determine the motion of the others.

There det(J_D) = 0 on the constraints. The curve of positions is traced, so that only places that
can be reached are listed, and the sign of the determinant is watched on it. By ranks (Haug 1989, section
3.7): if J has a higher rank than J_D the mechanism locks up, because the independent coordinate is at a limit
and the others run away from it; if the rank of J itself drops, branches of the motion cross (bifurcation).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize_scalar

from symbody.analysis.configurations.assembly import assemble, assemble_taut
from symbody.analysis.kinematics.continuation import Continuation, Law, continuation
from symbody.analysis.kinematics.driven import joint_of
from symbody.analysis.kinematics.led_values import led_numbers, read_range
from symbody.analysis.kinematics.position_curve import PathPoint, PositionCurve
from symbody.analysis.kinematics.velocity_ratios import VelocityRatios, velocity_ratios
from symbody.analysis.scales import mechanism_scales
from symbody.analysis.state import State
from symbody.arguments import checked_arguments, named_after
from symbody.codegen.formation.names import Value
from symbody.equations.equation_set import EquationSet
from symbody.equations.solving.unilateral import unilateral_elements
from symbody.errors import AssemblyError, Problem, UsageError, number_in_words
from symbody.tolerances import ASSEMBLED, BALANCED, SAME_POSITION, SINGULAR

Floats = NDArray[np.float64]

_STARTS: Final = 5
_NEAR: Final = 1e-3  # of the largest singular value: there a position may be off by 1e-14 over its square
_BESIDE: Final = 1e-2


@dataclass(frozen=True, slots=True)
class SingularConfiguration:
    """One position at which independent speeds do not determine the others.

    Attributes
    ----------
    kind : str
        "lock-up" or "bifurcation".
    q : mapping of coordinate to float
        Where, to about 1e-7.
    joint : str
        The joint of the coordinate that stands still at a lock-up, or that coordinate where frames were
        placed by hand; the cut joint or constraint whose equations depend on others at a bifurcation.
    limits : mapping of coordinate to str
        Behaviour of independent coordinates there along the curve: "maximum", "minimum" or "passes".
    determinant : float
        det(J_D) of scaled rows and speeds there, as a measure of how well the place is known.
    assembly : int
        Equal numbers for places that are reached from each other without taking the mechanism apart, the
        assembly nearest to the guess being 1; 0 where all places are. Where branches cross they are one.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> [lock] = sb.singular_configurations(sb.form_equations(ladder), "x", {"x": (0.0, 5.0)})
    >>> lock.kind, lock.joint, round(lock.q["x"], 6)
    ('lock-up', 'x', 5.0)
    """

    kind: str
    q: Mapping[str, float]
    joint: str
    limits: Mapping[str, str]
    determinant: float
    assembly: int = 0

    def __str__(self) -> str:
        return f"{self._description()}{f', in assembly {self.assembly}' if self.assembly else ''}"

    def __repr__(self) -> str:
        return f"<{self}>"

    def _description(self) -> str:
        # Places are good to about 1e-7: what is smaller than 1e-9 is rounding about 0.
        place = ", ".join(f"{name} = {round(value, 9) + 0.0:.7g}" for name, value in self.q.items())
        if self.kind == "bifurcation":
            return f"bifurcation at {place}: constraints of {self.joint} depend on others, so branches cross"
        ends = ", ".join(f"{name} has a {end}" for name, end in self.limits.items() if end != "passes")
        drive = f"{'coordinate' if self.joint in self.q else 'joint'} {self.joint}"
        return f"dead position (lock-up) at {place}: {drive} cannot drive the mechanism" + (
            f", {ends}" if ends else ""
        )


@named_after(3)
@checked_arguments
def singular_configurations(
    eqs: EquationSet,
    independent: str | Sequence[str],
    over: Mapping[str, Value | tuple[Value, Value]],
    guess: Mapping[str, Value] | None = None,
    parameters: Mapping[str, Value] | None = None,
    *,
    scales: Mapping[str, float] | None = None,
) -> tuple[SingularConfiguration, ...]:
    """Return the singular configurations for a choice of independent coordinates.

    `VelocityRatios.determinant` is det(J_D) as a formula.

    Parameters
    ----------
    eqs : EquationSet
        The equations of the mechanism.
    independent : str or sequence of str
        Coordinates or speeds, as many as there are degrees of freedom.
    over : mapping of coordinate to range or number
        The coordinate to search along, with the ends of its range; numbers fix further degrees of freedom.
        Both may be formulas in parameters, angles texts such as ``"30 deg"``.
    guess : mapping of name to number or formula in parameters
        Near which the loops close; other assemblies that are found are followed, too.
    parameters : mapping of name to number or formula, optional
        Overrides values of the model.
    scales : mapping of "length", "time", "mass" to float, optional
        Sizes of the mechanism [m, s, kg]; by default they follow from the model, and without any length there
        from the range and a configuration near the guess.

    Returns
    -------
    tuple of SingularConfiguration
        In the order in which they are met, each with its positions ``q``, its kind and its joint.

    Raises
    ------
    UsageError
        If names make no sense, there is not exactly one range, or other degrees of freedom are left.
    AssemblyError
        If the loops close nowhere in the range.

    Examples
    --------
    >>> import symbody as sb
    >>> a = sb.Prismatic("a", "ground", sb.Body("A", mass=1), axis="x", coordinate="x")
    >>> b = sb.Prismatic("b", "ground", sb.Body("B", mass=1), axis="y", coordinate="y")
    >>> rod = sb.Distance("rod", "A", "B", 5)
    >>> eqs = sb.form_equations(sb.Model("ladder", [a, b, rod], initial={"x": 3, "y": 4}))
    >>> found = sb.singular_configurations(eqs, "x", {"x": (0.0, 5.0)})
    >>> [round(each.q["x"], 6) for each in found]
    [5.0]
    """
    numbers = led_numbers(eqs, over, parameters)
    first = _first(eqs, numbers, guess, parameters, scales)
    ratios = velocity_ratios(eqs, independent, first, parameters=parameters, scales=scales)
    search = _search(ratios, numbers, dict(parameters or {}), first, scales)
    configurations: list[SingularConfiguration] = []
    for number, points in enumerate(search.curves(guess, parameters, scales), start=1):
        for one in search.find_on_curve(points):
            if not any(search.same(one, other) for other in configurations):
                configurations.append(replace(one, assembly=number))
    names = (search.along, *eqs.coordinate_names)
    ranked = sorted(configurations, key=lambda one: [one.q[name] for name in names])
    several = len({one.assembly for one in ranked}) > 1
    return tuple(one if several else replace(one, assembly=0) for one in ranked)


@dataclass(frozen=True, slots=True, eq=False)
class _Search:
    """Curves of positions over a range, and the determinant on them."""

    ratios: VelocityRatios
    mechanism: Continuation
    curve: PositionCurve
    along: str
    ends: tuple[float, float]
    held: Mapping[str, float]

    def curves(
        self,
        guess: Mapping[str, Value] | None,
        parameters: Mapping[str, Value] | None,
        scales: Mapping[str, float] | None,
    ) -> Iterator[list[PathPoint]]:
        """Return all curves that are met from several starts in the range."""
        traced: list[list[PathPoint]] = []
        for state in self._starts(guess, parameters, scales):
            q = np.array(list(state.q.values()))
            first = self.curve.start(q)
            if first is None or any(self.curve.contains(points, q) for points in traced):
                continue
            points, is_closed = self.curve.trace(first, self._is_inside)
            if not is_closed:
                back, _ = self.curve.trace(PathPoint(q, -first.tangent), self._is_inside)
                points = [PathPoint(p.q, -p.tangent) for p in back[:0:-1]] + points
            traced.append(points)
            yield points

    def find_on_curve(self, points: list[PathPoint]) -> Iterator[SingularConfiguration]:
        """Return the singular configurations on a curve."""
        values = [self.determinant(point.q) for point in points]
        largest = max(map(abs, values))
        for k, (a, b) in enumerate(pairwise(values)):
            if a * b <= 0.0 and a != b:
                yield from self._classify(self._find_crossing(points[k], points[k + 1]))
        for k in range(1, len(points) - 1):
            a, b, c = values[k - 1 : k + 2]
            if a * b > 0.0 and b * c > 0.0 and abs(b) <= min(abs(a), abs(c)) and abs(b) < 0.1 * largest:
                touched = self._find_touch(points[k], points[k - 1], points[k + 1], BALANCED * largest)
                yield from self._classify(touched)

    def determinant(self, q: Floats) -> float:
        """Return det(J_D) of scaled independent rows and speeds."""
        block = self._blocks(q)[1]
        return float(np.linalg.det(block)) if block.size else 1.0

    def same(self, one: SingularConfiguration, other: SingularConfiguration) -> bool:
        """Return whether two places are one; whole turns do not count."""
        apart = self.curve.difference(np.array([*one.q.values()]), np.array([*other.q.values()]))
        return bool(np.abs(apart).max() <= SAME_POSITION)

    def _starts(
        self,
        guess: Mapping[str, Value] | None,
        parameters: Mapping[str, Value] | None,
        scales: Mapping[str, float] | None,
    ) -> Iterator[State]:
        eqs, failed, count = self.ratios.eqs, [], 0
        complete = assemble_taut if unilateral_elements(eqs.formed) else assemble
        for k in range(_STARTS):
            # Off the middle and the ends, where mechanisms like to be singular.
            value = self.ends[0] + (self.ends[1] - self.ends[0]) * (k + 0.382) / _STARTS
            try:
                start = {self.along: value, **self.held}
                state = complete(eqs, start, guess, parameters=parameters, scales=scales)
            except AssemblyError as error:
                failed.append(error)
                continue
            count += 1
            yield state
            yield from state.branches
        if not count:
            raise failed[0]

    def _is_inside(self, q: Floats) -> bool:
        k = self.ratios.eqs.coordinate_names.index(self.along)
        edge = ASSEMBLED * self.mechanism.sizes[k]
        return bool(self.ends[0] - edge <= q[k] <= self.ends[1] + edge)

    def _blocks(self, q: Floats) -> tuple[Floats, Floats]:
        """Return scaled independent rows of J, and of these the columns of dependent speeds."""
        mechanism, eqs = self.mechanism, self.ratios.eqs
        jacobian = mechanism.rows(0.0, q, np.zeros(mechanism.speed_sizes.size))[0]
        rows = mechanism.scaled_rows(jacobian)
        names = [row.name for row in mechanism.eqs.formed.rows]
        kept = rows[[names.index(name) for name in self.ratios.rows]]
        return kept, kept[:, [eqs.speed_names.index(name) for name in self.ratios.dependent]]

    def _find_crossing(self, a: PathPoint, b: PathPoint) -> PathPoint | None:
        length = float(a.tangent @ ((b.q - a.q) / self.mechanism.sizes))

        def value(s: float) -> float:
            point = self.curve.advance(a, s)
            return 0.0 if point is None else self.determinant(point.q)

        ends = self.determinant(a.q), value(length)
        if ends[0] == 0.0 or ends[0] * ends[1] > 0.0:
            return a if ends[0] == 0.0 else b
        s = float(brentq(value, 0.0, length, xtol=1e-13))
        point = self.curve.advance(a, s)
        return self._interpolate_zero(a, s) if point is None or self._is_crossing(point) else point

    def _is_crossing(self, point: PathPoint) -> bool:
        """Return whether positions are badly determined, since branches cross."""
        sizes = np.linalg.svd(self._blocks(point.q)[0], compute_uv=False)
        return bool(sizes.size and sizes[-1] < _NEAR * sizes[0])

    def _interpolate_zero(self, a: PathPoint, s: float) -> PathPoint | None:
        """Return a zero from points beside it, by a cubic: at a crossing itself Newton's method fails."""
        places = s + _BESIDE * np.array([-0.6, -0.2, 0.2, 0.6])
        points = [self.curve.advance(a, float(place)) for place in places]
        if None in points:
            return None
        q = np.array([point.q for point in points if point is not None])
        values = np.array([self.determinant(one) for one in q])
        if values[1] * values[2] > 0.0:
            return None
        smooth = CubicSpline(places, np.column_stack([values, q]))
        root = float(brentq(lambda x: float(smooth(x)[0]), places[1], places[2], xtol=1e-14))
        return PathPoint(np.asarray(smooth(root)[1:]), a.tangent)

    def _find_touch(
        self, at: PathPoint, before: PathPoint, after: PathPoint, enough: float
    ) -> PathPoint | None:
        sizes = self.mechanism.sizes
        bounds = [float(at.tangent @ ((p.q - at.q) / sizes)) for p in (before, after)]

        def value(s: float) -> float:
            point = self.curve.advance(at, s)
            return np.inf if point is None else abs(self.determinant(point.q))

        best = minimize_scalar(value, bounds=bounds, method="bounded", options={"xatol": 1e-10})
        return self.curve.advance(at, float(best.x)) if best.fun <= enough else None

    def _classify(self, point: PathPoint | None) -> Iterator[SingularConfiguration]:
        """Yield a place with its kind, if it lies within the range."""
        eqs = self.ratios.eqs
        if point is None:
            return
        k = eqs.coordinate_names.index(self.along)
        value, near = point.q[k], SAME_POSITION * self.mechanism.sizes[k]
        inside = self.ends[0] - near <= value <= self.ends[1] + near
        if not inside or self.ratios.gaps_out_of_place(point.q):
            return
        kept, block = self._blocks(point.q)
        ranks = [
            int(np.linalg.matrix_rank(rows, tol=SINGULAR * np.linalg.norm(kept, 2))) for rows in (kept, block)
        ]
        place = dict(zip(eqs.coordinate_names, point.q.tolist(), strict=True))
        for name, is_angle in zip(eqs.coordinate_names, self.mechanism.angles, strict=True):
            if is_angle and name != self.along:
                place[name] = float(np.arctan2(np.sin(place[name]), np.cos(place[name])))
        if ranks[0] > ranks[1]:
            kind, joint = "lock-up", self._standing_joint(kept)
        else:
            kind, joint = "bifurcation", self._dependent_element(kept)
        yield SingularConfiguration(kind, place, joint, self._limits(point), self.determinant(point.q))

    def _standing_joint(self, kept: Floats) -> str:
        """Return the joint of the independent speed that stands still in every motion."""
        eqs = self.ratios.eqs
        basis = np.linalg.svd(kept)[2][len(kept) :].T
        places = [eqs.speed_names.index(name) for name in self.ratios.independent]
        left = np.linalg.svd(basis[places])[0][:, -1]
        return joint_of(eqs, self.ratios.independent[int(np.abs(left).argmax())])

    def _dependent_element(self, kept: Floats) -> str:
        """Return the element whose equations depend on others."""
        left = np.linalg.svd(kept)[0][:, -1]
        name = self.ratios.rows[int(np.abs(left).argmax())]
        return next(row.element for row in self.ratios.eqs.formed.rows if row.name == name)

    def _limits(self, point: PathPoint) -> dict[str, str]:
        """Return the behaviour of independent coordinates along the curve."""
        names = self.ratios.eqs.coordinate_names
        sides = [self.curve.advance(point, s) for s in (-_BESIDE, _BESIDE)]
        limits = {}
        for speed in self.ratios.independent:
            name = speed.removesuffix("_dot")
            if name in names and None not in sides:
                k = names.index(name)
                rise = [float(side.q[k] - point.q[k]) for side in sides if side is not None]
                end = "minimum" if min(rise) > 0.0 else "maximum" if max(rise) < 0.0 else "passes"
                limits[name] = end
        return limits


def _first(
    eqs: EquationSet,
    over: Mapping[str, float | tuple[float, float]],
    guess: Mapping[str, Value] | None,
    parameters: Mapping[str, Value] | None,
    scales: Mapping[str, float] | None,
) -> State:
    """Return a configuration near the guess, after the question has been checked.

    Raises
    ------
    UsageError
        If a name in `over` is not a coordinate of the equations.
    """
    along, _, _ = read_range(over)
    if along not in eqs.coordinate_names:
        raise UsageError(
            Problem("kinematics.range_coordinate", f"over {along}",
                    f"{along!r} is not a coordinate of these equations",
                    "coordinates of cut joints, prescribed coordinates and substituted coordinates are not "
                    "available",
                    f"name one of {', '.join(eqs.coordinate_names)}, or put its joint into the tree")
        )  # fmt: skip
    return assemble(eqs, None, guess, parameters=parameters, scales=scales)


def _search(
    ratios: VelocityRatios,
    over: Mapping[str, float | tuple[float, float]],
    parameters: Mapping[str, Value],
    first: State,
    scales: Mapping[str, float] | None,
) -> _Search:
    """Return the search for singular configurations.

    Raises
    ------
    UsageError
        If more than one freedom is left.
    """
    along, ends, held = read_range(over)
    mechanism = continuation(
        ratios.eqs, {}, {name: _still(x) for name, x in held.items()}, parameters, lambda _: 0.0
    )
    left = len(ratios.independent) - len(held)
    if left != 1:
        raise UsageError(
            Problem("kinematics.range_freedoms", "over",
                    f"the mechanism has {number_in_words(len(ratios.independent), 'degree of freedom')}, "
                    f"and {len(held)} are "
                    f"held fixed", "the positions over a range must form a curve",
                    "fix all degrees of freedom but one with numbers")
        )  # fmt: skip
    farthest = {along: max(map(abs, ends)), **held}
    mechanism = mechanism.rescale(mechanism_scales(ratios.eqs, parameters, scales, {**first.q, **farthest}))
    return _Search(ratios, mechanism, PositionCurve(mechanism), along, ends, held)


def _still(value: float) -> Law:
    """Return the law of a coordinate that is held."""
    return lambda s: (value, 0.0, 0.0)
