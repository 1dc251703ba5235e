"""How a motion is held on its constraints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from symbody.analysis.scales import Scales
from symbody.arguments import checked_fields
from symbody.equations.equation_set import EquationSet
from symbody.errors import Problem, UsageError
from symbody.expr.expression import Expr
from symbody.expr.sequences.sequence import Output
from symbody.kernels.step_bounds import EPSILON
from symbody.simulation.native.description import Projector
from symbody.tolerances import CLOSED

Floats = NDArray[np.float64]

# A residual is the difference of two chains of offsets, each turned by the joints before it. A product with
# a 3 by 3 matrix is good to 3 eps of the vector's length [Higham, Accuracy and Stability of Numerical
# Algorithms, 2nd ed., section 3.5], and a coordinate brings one such product; its own rounding turns or
# shifts what follows by eps times it. So residuals are known to 3 eps of the largest coordinate, for each.
ROUNDED_PER_COORDINATE: Final = 3.0

_EMPTY: Final = np.zeros(0)
# Outputs of the projecting function, in the order that the compiled loop expects.
PROJECTED = ("position_residual", "position_move", "velocity_residual", "velocity_move")


@checked_fields
@dataclass(frozen=True, slots=True)
class Projection:
    """After each step the state is moved back onto the constraints, by the least move in the mass matrix.

    Attributes
    ----------
    tolerance : float
        Constraints may be open by this share of the mechanism's size, or by atol of it if that is less; by
        what rounding leaves open if that is more, as at coordinates far larger than the mechanism.
    limit : float
        A move above so many tolerated errors rejects the step, unless its start is as far off already.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> eqs = sb.form_equations(ladder)
    >>> run = sb.simulate(eqs, 1.0, {"x_dot": 1}, constraints=sb.Projection(tolerance=1e-12))
    >>> run.success, bool(run.constraint_violation.max() < 1e-9)
    (True, True)
    """

    tolerance: float = 1e-10
    limit: float = 10.0

    def __post_init__(self) -> None:
        _check_positive(tolerance=self.tolerance, limit=self.limit)


@checked_fields
@dataclass(frozen=True, slots=True, init=False)
class Baumgarte:
    """Constraints decay like ``Phi'' + 2 zeta omega Phi' + omega^2 Phi = 0``; nothing is projected.

    Also ``Phi'' + 2 alpha Phi' + beta^2 Phi = 0``: alpha is zeta omega, beta is omega (Baumgarte 1972).

    Parameters
    ----------
    zeta : float
        Damping ratio; by default 0.95.
    omega : float
        Natural frequency [rad/s]; by default 20. Large values make the equations stiff.
    alpha, beta : float
        Both [1/s], in place of zeta and omega.

    Raises
    ------
    UsageError
        If a value is not positive, or both pairs are given, or only one of alpha and beta.

    Examples
    --------
    >>> import symbody as sb
    >>> x, y = (sb.Prismatic(c, "ground", sb.Body(c.upper(), mass=1), axis=c, coordinate=c) for c in "xy")
    >>> ladder = sb.Model("ladder", [x, y, sb.Distance("rod", "X", "Y", 5)], initial={"x": 3, "y": 4})
    >>> eqs = sb.form_equations(ladder)
    >>> run = sb.simulate(eqs, 1.0, {"x_dot": 1}, constraints=sb.Baumgarte(zeta=1.0, omega=50.0))
    >>> run.success, bool(run.constraint_violation.max() < 1e-6)
    (True, True)
    """

    zeta: float
    omega: float

    def __init__(
        self,
        zeta: float | None = None,
        omega: float | None = None,
        *,
        alpha: float | None = None,
        beta: float | None = None,
    ) -> None:
        given = {"zeta": zeta, "omega": omega, "alpha": alpha, "beta": beta}
        named = {name: value for name, value in given.items() if value is not None}
        _check_positive(**named)
        _check_one_pair(tuple(named))
        if alpha is not None and beta is not None:
            zeta, omega = alpha / beta, beta
        object.__setattr__(self, "zeta", 0.95 if zeta is None else zeta)
        object.__setattr__(self, "omega", 20.0 if omega is None else omega)

    @property
    def alpha(self) -> float:
        """Half the damping of the constraints [1/s]: zeta omega."""
        return self.zeta * self.omega

    @property
    def beta(self) -> float:
        """The root of their stiffness [1/s]: omega."""
        return self.omega

    def applied(self, eqs: EquationSet) -> EquationSet:
        """Return the equations with the stabilizing terms in gamma."""
        stabilized: EquationSet = eqs.variants.get(("baumgarte", self), lambda: self._stabilize(eqs))
        return stabilized

    def _stabilize(self, eqs: EquationSet) -> EquationSet:
        graph = eqs.formed.graph
        rows = []
        for row in eqs.formed.rows:
            rate = row.drift
            for u, slope in row.jacobian.items():
                rate = rate + slope * Expr(graph, u)
            # Quotients, since what is rounded together with a product depends on the digits of constants.
            pull = rate / (0.5 / (self.zeta * self.omega)) + row.value / (1.0 / self.omega**2)
            rows.append(replace(row, gamma=row.gamma - pull))
        return EquationSet(eqs.model, eqs.formed.with_rows(tuple(rows)), eqs.notes)


class ProjectingFunction(Protocol):
    """What computes `PROJECTED`, at an address."""

    @property
    def address(self) -> int:
        """Where it lies."""

    @property
    def work_size(self) -> int:
        """Doubles of scratch that it needs."""

    @property
    def outputs(self) -> tuple[Output, ...]:
        """What it computes."""

    def constants(self) -> Floats:
        """Return the numbers c that it takes."""


def make_projector(
    function: ProjectingFunction,
    eqs: EquationSet,
    sizes: Scales,
    method: Projection,
    atol: float | None,
    constants: Floats | None = None,
) -> Projector:
    """Return what the compiled loop calls to project; `function` computes `PROJECTED`.

    Where `sizes` are those of N motions, the scales and sizes of what is returned are arrays (N, n).
    """
    n_u, n_q = len(eqs.speed_names), len(eqs.coordinate_names)
    tolerance = residual_share(method, atol)
    scales = sizes.constraints(eqs)[..., : len(eqs.formed.holonomic)]
    ones = np.ones((*scales.shape[:-1], function.outputs[0].shape[0]))  # norms of quaternions come last
    ones[..., : scales.shape[-1]] = scales
    return Projector(
        function.address, n_u, _EMPTY, _EMPTY,
        function.constants() if constants is None else constants, function.work_size, n_q,
        tolerance * ones, method.limit, sizes.coordinates(eqs),
        ROUNDED_PER_COORDINATE * n_q * EPSILON / tolerance,
        sum(len(output.values) for output in function.outputs),
    )  # fmt: skip


def residual_share(method: Projection, atol: float | None) -> float:
    """Return by which share of its scale a constraint may be open."""
    return min(method.tolerance, CLOSED if atol is None else atol)


def _check_one_pair(named: tuple[str, ...]) -> None:
    """Refuse alpha and beta beside zeta and omega, and one of them without the other."""
    own = [name for name in named if name in ("alpha", "beta")]
    if not own or named == ("alpha", "beta"):
        return
    mixed = len(own) < len(named)
    raise UsageError(
        Problem("simulation.baumgarte", "Baumgarte",
                f"{' and '.join(named)} are given together" if mixed else f"{own[0]} is given without its "
                    f"partner",
                "alpha = zeta omega and beta = omega: one pair determines the other",
                "give zeta and omega, or alpha and beta")
    )  # fmt: skip


def _check_positive(**values: float) -> None:
    problems = [
        Problem("simulation.constraints", name, f"{name} = {value!r} is not a positive number", "",
                "give a positive number, or leave it out")
        for name, value in values.items() if not value > 0.0
    ]  # fmt: skip
    if problems:
        raise UsageError(*problems)
