"""Passages of a motion by positions where three angles do not determine a rotation.

With the second of three angles at such a place, the first and the third turn about one axis: their rates
are unbounded although the body moves smoothly. The integrator takes many small steps there, or stops.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from symbody.equations.equation_set import EquationSet
from symbody.model.joint import Joint
from symbody.model.joints.constant_velocity import ConstantVelocity
from symbody.model.joints.free import Free
from symbody.model.joints.spherical import Spherical
from symbody.simulation.events.events import Occurrence
from symbody.simulation.native.dense_output import DenseOutput

Floats = NDArray[np.float64]

# Within so much of the place the rates are a hundred times the angular velocity.
_NEAR: Final = 1e-2
_SAMPLES: Final = 5  # of each step


@dataclass(frozen=True, slots=True)
class _Angles:
    """Three angles of a joint; `shift` takes the second to where its sine vanishes."""

    joint: str
    second: int
    shift: float
    cure: str

    def measure(self, q: Floats) -> Floats:
        """Return the size of the determinant that relates rates and angular velocity."""
        size: Floats = np.abs(np.sin(q[self.second] + self.shift))
        return size


def singular_passages(eqs: EquationSet, dense: DenseOutput) -> Iterator[tuple[Occurrence, str]]:
    """Return each passage of a motion by a singular position of angles, and what to note about it.

    Parameters
    ----------
    dense : DenseOutput
        Of the states, speeds before coordinates.
    """
    n_u = len(eqs.speed_names)
    triples: list[_Angles] = eqs.plans.get("singular angles", lambda: list(_triples(eqs)))
    if not triples:
        return
    breaks = dense.breaks
    shares = np.arange(_SAMPLES) / _SAMPLES
    t = np.append((breaks[:-1, np.newaxis] + np.diff(breaks)[:, np.newaxis] * shares).ravel(), breaks[-1])
    q = dense(t)[n_u:]
    for angles in triples:
        sizes = angles.measure(q)
        rising = np.append(np.diff(sizes) > 0.0, True)
        falling = np.insert(np.diff(sizes) <= 0.0, 0, True)
        for k in np.flatnonzero(rising & falling & (sizes < 10.0 * _NEAR)).tolist():
            between = (float(t[max(k - 1, 0)]), float(t[min(k + 1, t.size - 1)]))
            moment, size = _least(partial(_measure_at, angles, dense, n_u), between)
            if size < _NEAR:
                state = dict(zip(eqs.state_names, dense(moment).tolist(), strict=True))
                event = Occurrence(f"{angles.joint} singular angles", moment, state)
                yield event, _passage_note(eqs, angles, moment, size)


def _measure_at(angles: _Angles, dense: DenseOutput, n_u: int, t: float) -> float:
    return float(angles.measure(dense(t)[n_u:]))


def _least(measure: Callable[[float], float], between: tuple[float, float]) -> tuple[float, float]:
    """Return when something is least, and how large it is then."""
    low, high = sorted(between)
    found = scipy.optimize.minimize_scalar(
        measure, bounds=(low, high), method="bounded", options={"xatol": 1e-9 * (high - low)}
    )
    return float(found.x), float(found.fun)


def _triples(eqs: EquationSet) -> Iterator[_Angles]:
    """Return the joints in the rotation tree that have three angles."""
    places = {name: k for k, name in enumerate(eqs.coordinate_names)}
    for role in eqs.formed.joint_roles:
        turns = role.joint.turns()
        names = [turn.angle.text for turn in turns]
        if role.has_angles and len(set(names)) == 3 and names[1] in places:
            is_proper = turns[0].axis == turns[2].axis
            yield _Angles(
                role.joint.name, places[names[1]], 0.0 if is_proper else np.pi / 2, _cure(role.joint)
            )


def _cure(joint: Joint) -> str:
    if isinstance(joint, Spherical | Free):
        return 'angles = "quaternion" has no such singularity'
    if isinstance(joint, ConstantVelocity):
        return "cut it with tree = false if its shafts become collinear"
    return "another sequence of angles has its singularities elsewhere"


def _passage_note(eqs: EquationSet, angles: _Angles, t: float, size: float) -> str:
    name = eqs.coordinate_names[angles.second]
    return (
        f"joint {angles.joint}: at t = {t:.6g} s {name} passes within {size:.1e} rad of a singularity of "
        f"its angles; steps are small there and accuracy suffers; {angles.cure}"
    )
