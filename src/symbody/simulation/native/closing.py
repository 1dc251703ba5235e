"""The block of `symbody.kernels.configurations.closing`: what closes states after they were set."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from symbody.analysis.curvature import limited_coordinates
from symbody.analysis.scales import Scales
from symbody.equations.closing_equations import closing_equations, follower_names, follower_outputs
from symbody.equations.equation_set import EquationSet
from symbody.kernels.configurations.assembly_problem import AssemblyProblem
from symbody.kernels.configurations.closing import closing_size
from symbody.kernels.pack import pack
from symbody.simulation.native.description import Floats

# What the function of a closing writes; the mass matrix, and behind it what is substituted, to hold values.
POSED: Final = ("constraints", "position_jacobian", "velocity_residual", "jacobian")
CLOSING: Final = (*POSED, "mass_matrix")


class StateShape(NamedTuple):
    """What a closing knows of states and of the equations that close them.

    Attributes
    ----------
    speeds, coordinates : int
        How many the equations have.
    quaternions : tuple of int
        Places of their components among the coordinates.
    limited : tuple of float
        1 for coordinates whose steps are limited.
    places, followers : tuple of int
        Of each state, and of what is substituted in its equations, among those of the equations; empty where
        these are the same.
    """

    speeds: int
    coordinates: int
    quaternions: tuple[int, ...]
    limited: tuple[float, ...]
    places: tuple[int, ...] = ()
    followers: tuple[int, ...] = ()


class Closing(NamedTuple):
    """Which equations close states, with which outputs, and what is known of them."""

    eqs: EquationSet
    outputs: tuple[str, ...]
    shape: StateShape

    @property
    def is_needed(self) -> bool:
        """Whether there is anything to close."""
        return bool(self.eqs.multiplier_names or self.eqs.quaternions)


def closing_of(eqs: EquationSet, *, holds: bool) -> Closing:
    """Return what closes states of equations, some of them held or none."""
    if not holds:
        return Closing(eqs, POSED, _shape_of(eqs))
    whole = closing_equations(eqs)
    if whole is eqs:
        return Closing(eqs, CLOSING, _shape_of(eqs))
    index = whole.state_names.index
    places = tuple(index(name) for name in eqs.state_names)
    followers = tuple(index(name) for name in follower_names(eqs))
    shape = _state_shape(whole)._replace(places=places, followers=followers)
    return Closing(whole, (*CLOSING, *follower_outputs(eqs)), shape)


def _shape_of(eqs: EquationSet) -> StateShape:
    shape: StateShape = eqs.plans.get("state shape", lambda: _state_shape(eqs))
    return shape


def _state_shape(eqs: EquationSet) -> StateShape:
    """Return the shape of the states of equations."""
    names = eqs.coordinate_names
    four = (names.index(name) for group in eqs.quaternions for name in group)
    return StateShape(
        len(eqs.speed_names), len(names), tuple(four), tuple(map(float, limited_coordinates(eqs)))
    )


def metric(eqs: EquationSet, scales: Scales) -> Floats:
    """Return the sizes of all states (u, q), then of the constraints on positions; of N motions (N, n)."""
    count = len(eqs.formed.holonomic)
    sizes = scales.displacements(eqs), scales.coordinates(eqs), scales.constraints(eqs)[..., :count]
    return np.concatenate(sizes, axis=-1)


def place_sizes(block: AssemblyProblem, sizes: Floats, share: float) -> None:
    """Write into a closing what counts as large, see `metric`, and by which share of that it is closed."""
    states = block.speeds + block.coordinates
    np.asarray(block.sizes)[:states] = sizes[:states]
    np.asarray(block.scales)[:] = sizes[states:]
    block.share = block.enough = math.sqrt(max(block.residuals, 1)) * share


def closing_block(
    shape: StateShape, sizes: Floats, outputs: Sequence[int], numbers: Floats, share: float
) -> Floats:
    """Return the block of a closing.

    Parameters
    ----------
    sizes : array
        What `metric` returns.
    outputs : sequence of int
        How many numbers each output of the function has.
    numbers : array
        Of the function, see `blocks.function_numbers`.
    share : float
        Each residual over its size that counts as closed; states as close as that stay where they are.
    """
    (n_u, n_q, four, limited, places, followers), count = shape, outputs[0]
    whole = n_u + n_q + len(places) if places else 0  # states of signals lie behind
    closed = math.sqrt(max(count, 1)) * share
    block = pack(
        AssemblyProblem, speeds=n_u, coordinates=n_q, residuals=count, rows=outputs[2], out_size=sum(outputs),
        quaternion_count=len(four) // 4, share=closed, enough=closed, weighed=len(outputs) >= len(CLOSING),
        followers=len(followers), states=len(places),
        held=np.zeros(n_u + n_q), sizes=sizes[: n_u + n_q], scales=sizes[n_u + n_q :],
        matrices=np.zeros(closing_size(max(n_q, n_u))), numbers=numbers, quaternion_places=four,
        limited=limited, places=places, follower_places=followers, whole=np.zeros(whole),
        asked=np.zeros(n_u + n_q - len(followers) if places else 0),
    )  # fmt: skip
    if not places:
        fields = AssemblyProblem.fields
        block[fields["asked"].place] = block[fields["held"].place]
    return block
