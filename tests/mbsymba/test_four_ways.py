"""One slider-crank in four sets of coordinates, by three formulations: one motion, the same reactions, F = m a."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import symbody as sb
from symbody import mbsymba as mb
from symbody.equations.formulations.formulation import Formulation
from tests.formulations import UNLIMITED
from tests.mbsymba import slider_crank as sc

Array = NDArray[np.float64]
WAYS = (*sc.MECHANISMS, "drawn")
TIMES = np.linspace(0.0, 1.0, 6)


@pytest.fixture(autouse=True)
def gravity() -> Iterator[None]:
    yield
    mb.set_gravity(None)


@cache
def motion(way: str, formulation: Formulation) -> sb.Trajectory:
    mb.set_gravity(mb.make_VECTOR(mb.ground, 0, -sc.g, 0))
    if way == "drawn":
        eqs = sb.form_equations(sc.drawn(), formulation)
    else:
        objects, q = sc.objects_of(sc.MECHANISMS[way]())
        eqs = mb.equation_set(objects, q, formulation, parameters=sc.DATA)
    key = "recursive" if way == "drawn" else way
    return sb.simulate(eqs, 1.0, sc.INITIAL[key], guess=sc.GUESS[key], times=TIMES, rtol=1e-12, atol=1e-13)


def moment(arm: Array, F: Array) -> Array:
    """The moment about z of forces (2, n) at an arm (2,)."""
    return arm[0] * F[1] - arm[1] * F[0]


def balanced(run: sb.Trajectory, k: int) -> tuple[Array, float]:
    """The reactions in the equations of Newton and Euler in one sample, and those left undetermined.

    Nine equations for eight unknowns: forces of A on the crank, B on the rod, C on the rod, N and the moment on
    the slider. The motion alone enters, so they close only if the accelerations of all bodies are right.
    """
    names = ("crank", "rod", "slider")
    G, a = ([run[f"frame {kind} {name} ground ground"][:2, k] for name in names] for kind in ("r", "vdot"))
    turning = [run[f"frame wdot {name} ground ground"][2, k] for name in names]
    along = run["frame R crank ground"][:2, 0, k]
    A, B, C = np.zeros(2), sc.DATA["L1"] * along, G[2]
    masses = [sc.DATA[name] for name in ("m1", "m2", "m3")]
    inertias = [sc.DATA["J1"], sc.DATA["J2"], 1.0]
    on, zero = np.eye(2), np.zeros((2, 2))
    rows = [
        np.hstack([on, -on, zero, zero]),
        np.hstack([moment(A - G[0], on), -moment(B - G[0], on), 0, 0, 0, 0]),
        np.hstack([zero, on, on, zero]),
        np.hstack([0, 0, moment(B - G[1], on), moment(C - G[1], on), 0, 0]),
        np.hstack([zero, zero, -on, [[0, 0], [1, 0]]]),
        np.array([0, 0, 0, 0, 0, 0, 0, 1]),
    ]
    up = np.array([0, 9.81])
    wanted = [
        part
        for mass, inertia, own, spin in zip(masses, inertias, a, turning, strict=True)
        for part in (mass * (own + up), inertia * spin)
    ]
    left, right = np.vstack(rows), np.hstack(wanted)
    found = np.linalg.lstsq(left, right, rcond=None)[0]
    return found, float(np.abs(left @ found - right).max())


def reported(run: sb.Trajectory, k: int) -> Array:
    """The same reactions as the drawn mechanism reports them, all in ground axes."""
    R = run["frame R crank ground"][:2, :2, k]
    on_rod = R @ [run[f"reaction B F{axis}"][k] for axis in "xy"]  # of the crank, in its axes
    ends = [run[f"reaction {joint} F{axis}"][k] for joint in "AC" for axis in "xy"]
    return np.array([*ends[:2], *on_rod, *ends[2:], run["reaction D Fy"][k], run["reaction D Mz"][k]])


@pytest.mark.parametrize("formulation", UNLIMITED, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("way", WAYS)
def test_same_motion_same_reactions_and_newtons_law(way: str, formulation: sb.VirtualWork) -> None:
    run, reference = motion(way, formulation), motion("drawn", sb.VirtualWork())
    assert run.success and run.t.tolist() == TIMES.tolist()
    angle = np.unwrap(np.arctan2(run["u1y"], run["u1x"])) if way == "natural" else run["theta"]
    # Errors of 1e-12 a step over some hundred steps; accelerations and forces, up to 30 N, follow from states.
    assert np.abs(angle - reference["theta"]).max() < 1e-8
    assert np.abs(run["s"] - reference["s"]).max() < 1e-8
    assert np.ptp(reference["theta"]) > 1.0
    for k in range(TIMES.size):
        reactions, left_open = balanced(run, k)
        wanted = reported(reference, k)
        scale = np.abs(wanted).max()
        assert left_open < 1e-8 * scale
        assert np.abs(reactions - wanted).max() < 1e-8 * scale
        if way in ("recursive", "natural"):
            # The multipliers of the first two constraints are the force in C, as make_CONSTRAINT has them.
            own = [run[name][k] for name in ("lambda1", "lambda2")]
            assert np.abs(own - wanted[4:6]).max() < 1e-8 * scale
