"""`FixedStep`: methods whose steps are all of one length."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

from symbody.arguments import checked_fields
from symbody.errors import Problem, UsageError
from symbody.simulation.native.runge_kutta import RUNGE_KUTTA_4, SEMI_IMPLICIT, Tableau

_TABLEAUS: Final = {"rk4": RUNGE_KUTTA_4, "semi-implicit": SEMI_IMPLICIT}


@checked_fields
@dataclass(frozen=True, slots=True)
class FixedStep:
    """Steps of one length: for real time, for comparisons, for laws that jump at regular times.

    No error is estimated: tolerances do not matter, and nothing shows whether the step was short enough.
    Closed loops are closed after every step, however far they moved. The last step is shorter where the
    length does not divide the span; between steps the motion is the cubic through states and rates of both
    ends.

    Attributes
    ----------
    step : float
        Length of the steps [s].
    method : "rk4" or "semi-implicit"
        The classical Runge-Kutta method of order 4, or Euler's with new speeds for the coordinates
        (symplectic Euler, order 1), which keeps energies bounded where forces have potentials.

    Raises
    ------
    UsageError
        A step that is not positive, or another method.

    Examples
    --------
    >>> import symbody as sb
    >>> rail = sb.Prismatic("rail", "ground", sb.Body("Cart", mass=1), axis="x", coordinate="x")
    >>> eqs = sb.form_equations(sb.Model("cart", [rail], initial={"x_dot": 3}))
    >>> sb.simulate(eqs, 1.0, integrator=sb.FixedStep(0.01)).success
    True
    """

    step: float
    method: Literal["rk4", "semi-implicit"] = "rk4"

    def __post_init__(self) -> None:
        problems = []
        if not (self.step > 0.0 and math.isfinite(self.step)):
            problems.append(
                Problem("simulation.fixed_step", "step", f"step = {self.step!r} is not a valid step size", "",
                        "give seconds, such as sb.FixedStep(1e-3)")
            )  # fmt: skip
        if self.method not in _TABLEAUS:
            problems.append(
                Problem("simulation.fixed_method", "method", f"there is no method {self.method!r}", "",
                        "give method='rk4' or method='semi-implicit'")
            )  # fmt: skip
        if problems:
            raise UsageError(*problems)

    @property
    def tableau(self) -> Tableau:
        """Its coefficients."""
        return _TABLEAUS[self.method]

    @property
    def max_step(self) -> float:
        """Its only step [s]."""
        return self.step

    @property
    def first_step(self) -> float:
        """Its only step [s]."""
        return self.step
