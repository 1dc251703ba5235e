"""The problems, written once for any algebra.

Each comes in two parts, as a user would do it: `build` writes expressions down, `differentiate` takes
derivatives of them and returns all results.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from benchmarks.engines.algebra import Algebra, Floats, Matrix, Scalar

Scalars = Sequence[Scalar]


@dataclass(frozen=True, slots=True)
class Problem:
    """One problem of one size.

    Attributes
    ----------
    inputs : int
        Number of variables.
    build : callable
        From (algebra, variables) to expressions.
    differentiate : callable
        From (algebra, variables, what was built) to all results.
    """

    name: str
    inputs: int
    build: Callable[[Algebra, Scalars], list[Scalar]]
    differentiate: Callable[[Algebra, Scalars, Scalars], list[Scalar]]

    def points(self, count: int) -> Floats:
        """Return (count, inputs) values of the variables between 0.2 and 1, always the same ones."""
        return np.random.default_rng(7).uniform(0.2, 1.0, (count, self.inputs))


def serial_chain(links: int) -> Problem:
    """Return the position of the last link of a spatial chain, and its derivatives by the angles.

    Variables: `links` angles [rad], `links` lengths [m]. Results: the 12 entries of the last link's
    transform, row-major, then their 12 x `links` derivatives.
    """
    return Problem(
        f"spatial chain, {links} links", 2 * links, partial(_chain, links), partial(_with_jacobian, links)
    )


# Twists about x from joint to joint as (cos, sin): neither parallel nor at right angles, so that nothing
# vanishes from the matrices by luck.
_TWISTS: Final = ((0.8, 0.6), (0.96, -0.28), (0.6, 0.8))


def _chain(links: int, algebra: Algebra, x: Scalars) -> list[Scalar]:
    total = None
    for k in range(links):
        total = _times(algebra, total, algebra.matrix(_turn(algebra, x[k])))
        total = _times(algebra, total, algebra.matrix(_link(x[links + k], *_TWISTS[k % len(_TWISTS)])))
    return [entry for row in algebra.rows(total)[:3] for entry in row]


def _times(algebra: Algebra, a: Matrix | None, b: Matrix) -> Matrix:
    return b if a is None else algebra.product(a, b)


def _turn(algebra: Algebra, angle: Scalar) -> list[list[Scalar]]:
    c, s = algebra.cos(angle), algebra.sin(angle)
    return [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def _link(length: Scalar, c: float, s: float) -> list[list[Scalar]]:
    return [[1, 0, 0, length], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]


def _with_jacobian(by: int, algebra: Algebra, x: Scalars, roots: Scalars) -> list[Scalar]:
    """Return `roots` and their derivatives by the first `by` variables."""
    slopes = algebra.rows(algebra.jacobian(roots, x[:by]))
    return [*roots, *(entry for row in slopes for entry in row)]


@dataclass(frozen=True, slots=True)
class Step:
    """One operation of a random program on values `a` and `b`, numbered from the first input."""

    operation: str
    a: int
    b: int


_OUTPUTS: Final = 6


def random_operations(count: int, inputs: int = 8) -> Problem:
    """Return a random graph of about `count` operations, and its 6 x `inputs` derivatives."""
    program = random_program(count, inputs, lanes=min(60, count // 4))
    return Problem(
        f"random graph, {count} operations", inputs, partial(_run, program), partial(_with_jacobian, inputs)
    )


def random_program(count: int, inputs: int, lanes: int) -> tuple[Step, ...]:
    """Return `count` operations of which every one reaches an output.

    Each step takes the end of one of `lanes` lanes and any earlier value. Bounds of values and slopes
    for inputs between -1 and 1 are kept small by "halve", so that rounding stays rounding.
    """
    choose = random.Random(1)
    bounds = [(1.0, 1.0)] * inputs  # of the value, of its derivative by any one input
    ends = list(range(inputs)) * (lanes // inputs + 1)
    steps: list[Step] = []
    for k in range(count):
        lane = k % lanes
        a = ends[lane]
        b = choose.randrange(max(0, len(bounds) - 400), len(bounds)) if k % 5 else choose.randrange(inputs)
        operation = choose.choices(("mul", "add", "sub", "sin", "cos"), (8, 5, 4, 1, 1))[0]
        bound = _bound(operation, bounds[a], bounds[b])
        if max(bound) > 2.0:
            operation, bound = "halve", (bounds[a][0] / 2, bounds[a][1] / 2)
        steps.append(Step(operation, a, b))
        ends[lane] = len(bounds)
        bounds.append(bound)
    return tuple(steps)


def _bound(operation: str, a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    if operation == "mul":
        return a[0] * b[0], a[1] * b[0] + a[0] * b[1]
    if operation in ("add", "sub"):
        return a[0] + b[0], a[1] + b[1]
    return 1.0, a[1]


def _run(program: Sequence[Step], algebra: Algebra, x: Scalars) -> list[Scalar]:
    rules: dict[str, Callable[[Scalar, Scalar], Scalar]] = {
        "mul": lambda a, b: a * b,
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "sin": lambda a, b: algebra.sin(a),
        "cos": lambda a, b: algebra.cos(a),
        "halve": lambda a, b: a * 0.5,
    }
    values = list(x)
    used: set[int] = set()
    for step in program:
        values.append(rules[step.operation](values[step.a], values[step.b]))
        used.update((step.a, step.b) if step.operation in ("mul", "add", "sub") else (step.a,))
    ends = [value for k, value in enumerate(values) if k not in used]
    return [sum(ends[k::_OUTPUTS], start=0) for k in range(_OUTPUTS)]


def pendulum(links: int) -> Problem:
    """Return mass matrix and bias of a planar chain of point masses, by Lagrange from its energies.

    Variables: `links` each of relative angles q [rad], their rates [rad/s], masses [kg], lengths [m];
    gravity [m/s^2]. Results: M, row-major, and h of ``M q'' + h = 0``.
    """
    return Problem(
        f"planar pendulum, {links} links",
        4 * links + 1,
        partial(_positions, links),
        partial(_lagrange, links),
    )


def _positions(links: int, algebra: Algebra, x: Scalars) -> list[Scalar]:
    across, down, angle = 0, 0, 0
    places: list[Scalar] = []
    for k in range(links):
        angle = angle + x[k]
        across = across + x[3 * links + k] * algebra.sin(angle)
        down = down + x[3 * links + k] * algebra.cos(angle)
        places += [across, down]
    return places


def _lagrange(links: int, algebra: Algebra, x: Scalars, places: Scalars) -> list[Scalar]:
    q, rates, masses, gravity = x[:links], x[links : 2 * links], x[2 * links : 3 * links], x[4 * links]
    column = algebra.matrix([[rate] for rate in rates])
    speeds = [row[0] for row in algebra.rows(algebra.product(algebra.jacobian(places, q), column))]
    kinetic, potential = 0, 0
    for k, mass in enumerate(masses):
        kinetic = kinetic + mass * (speeds[2 * k] ** 2 + speeds[2 * k + 1] ** 2) * 0.5
        potential = potential - mass * gravity * places[2 * k + 1]
    momenta = algebra.rows(algebra.jacobian([kinetic], rates))[0]
    M = algebra.rows(algebra.jacobian(momenta, rates))
    h = algebra.rows(algebra.product(algebra.jacobian(momenta, q), column))
    slopes = algebra.rows(algebra.jacobian([kinetic - potential], q))[0]
    return [*(entry for row in M for entry in row), *(h[k][0] - slopes[k] for k in range(links))]
