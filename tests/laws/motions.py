"""A random mechanism in motion, and what laws read from it: places, energies, momenta."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import symbody as sb
from symbody.graph.trees import TreeChoice
from tests.laws.consistent_states import State
from tests.laws.evaluation import equations
from tests.laws.parts import Mechanism
from tests.laws.rotations import Array

RTOL, ATOL = 1e-9, 1e-12
# A state that is zero but for rounding needs many short steps where its rounding is above ATOL.
MOST_STEPS = 50_000
FRAMES = (
    "frame r {} ground ground",
    "frame R {} ground",
    "frame v {} ground ground",
    "frame w {} ground ground",
)


@dataclass(frozen=True, slots=True)
class Method:
    """How a motion is computed; None leaves the integrator out."""

    integrator: sb.GeneralizedAlpha | sb.Stiff | None = None
    rtol: float = RTOL
    atol: float = ATOL
    most_steps: int = MOST_STEPS


USUAL = Method()


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """A run, with outputs at all of its samples: time comes first.

    Attributes
    ----------
    unbalanced : (N,) array
        Energy less the work done.
    places : mapping of body to (N, 3)
        Centres of mass.
    momentum, spin : (N, 3)
        Of all bodies; the angular one about the origin of ground.
    sizes : (2,) array
        The largest sums of the sizes of what these two add up.
    """

    run: sb.Trajectory
    unbalanced: Array
    energy: float
    places: dict[str, Array]
    momentum: Array
    spin: Array
    sizes: Array


def motion(
    mechanism: Mechanism, state: State, tree: TreeChoice, share: float, method: Method = USUAL
) -> Motion:
    """The motion from a state through a share of the mechanism's unit of time; every step is a sample."""
    return motion_of(mechanism, equations(mechanism, tree), state, share, method)


def motion_of(
    mechanism: Mechanism, eqs: sb.EquationSet, state: State, share: float, method: Method = USUAL
) -> Motion:
    """The motion by given equations of the mechanism."""
    known = {name: state.known[name] for name in (*eqs.coordinate_names, *eqs.speed_names)}
    inputs = {name: state.known[name] for name in eqs.input_names}
    span = (state.t, state.t + share * mechanism.units.time)
    run = sb.simulate(
        eqs, span, guess=known, inputs=inputs, integrator=method.integrator, rtol=method.rtol,
        atol=method.atol, max_steps=method.most_steps,
    )  # fmt: skip
    frames = [word.format(body.name) for body in mechanism.bodies for word in FRAMES]
    function = sb.compile(eqs, ["energy", "kinetic_energy", "potential_energy", *frames])
    energy, kinetic, potential, *found = function(run.t, run.q.T, run.u.T, list(inputs.values()))
    scale = max(float(kinetic.max()), float(np.ptp(potential)))
    places, total, sizes = {}, np.zeros((2, run.t.size, 3)), np.zeros((2, run.t.size))
    for k, body in enumerate(mechanism.bodies):
        r, axes, v, w = found[len(FRAMES) * k : len(FRAMES) * (k + 1)]
        places[body.name] = r
        own = np.einsum("nij,jk,nlk,nl->ni", axes, body.tensor, axes, w)
        for row, part in enumerate((body.mass * v, body.mass * np.cross(r, v), own)):
            total[min(row, 1)] += part
            sizes[min(row, 1)] += np.linalg.norm(part, axis=1)
    return Motion(run, energy - run["work"], scale, places, total[0], total[1], sizes.max(axis=1))
