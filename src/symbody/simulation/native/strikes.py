"""What prescribed rates that jump do to the speeds, by `symbody.kernels.configurations.strike`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from symbody.analysis.derivatives import partial_derivatives, with_outputs
from symbody.analysis.scales import Scales
from symbody.equations.equation_set import EquationSet
from symbody.kernels.configurations.strike import strike_room
from symbody.kernels.configurations.strike_problem import StrikeProblem
from symbody.kernels.pack import pack
from symbody.simulation.native.description import Floats

_MOMENTA: Final = "momenta of the speeds"
_TORN: Final = 1e-5  # of the mechanism's size: more than a motion has drifted by then


def strike_equations(eqs: EquationSet) -> EquationSet:
    """Return equations with the momenta of their speeds among the outputs."""
    formed = eqs.formed

    def make() -> EquationSet:
        momenta = partial_derivatives(eqs, _MOMENTA, [formed.kinetic_energy.index], formed.u)
        return with_outputs(eqs, [momenta])

    made: EquationSet = eqs.plans.get(_MOMENTA, make)
    return made


def strike_outputs(eqs: EquationSet) -> tuple[str, ...]:
    """Return what the function of a strike writes."""
    closed = ("constraints", "velocity_constraints", "jacobian") if eqs.multiplier_names else ()
    return (*closed, _MOMENTA, "mass_matrix", "energy")


def strike_block(eqs: EquationSet, scales: Scales, sizes: Sequence[int], numbers: Floats) -> Floats:
    """Return the array of a `StrikeProblem`, whose function has outputs of so many numbers."""
    n = len(eqs.speed_names)
    count, rows, *_ = sizes if eqs.multiplier_names else (0, 0)
    return pack(
        StrikeProblem, speeds=n, positions=count, rows=rows, out_size=sum(sizes), room=strike_room(n, rows),
        numbers=numbers, limits=_TORN * scales.constraints(eqs)[:count],
    )  # fmt: skip
