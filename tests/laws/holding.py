"""States that actions set one after the other: what each asked for, and what the motion went on with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import symbody as sb
from symbody.analysis.scales import mechanism_scales
from symbody.manifold import null_space

# A rate of which all motions have less than this share of their largest, each in its size, may stand still.
MOVES = 0.05
STEP = 1e-3  # between two actions, of the mechanism's unit of time
RATE, PLACE = 0.3, 1e-3  # changes of rates and coordinates, in their sizes


@dataclass(frozen=True, slots=True)
class Setting:
    """One action: the state it set, to which value, and the sample with which the motion went on."""

    name: str
    asked: float
    sample: int


def movable(eqs: sb.EquationSet, state: sb.State) -> list[str]:
    """Rates that the constraints leave free at a state, and the coordinates whose rates they are.

    Components of quaternions are left out: one of them alone may have no value but its own.
    """
    scales = mechanism_scales(eqs, {}, None, state.q)
    rows = np.asarray(state["jacobian"]) / scales.constraints(eqs)[:, np.newaxis]
    free = null_space(rows * scales.displacements(eqs))
    pairs = zip(eqs.speed_names, np.abs(free).max(axis=1, initial=0.0), strict=True)
    rates = [name for name, most in pairs if most > MOVES]
    four = {name for names in eqs.quaternions for name in names}
    return rates + [name for name in eqs.coordinate_names if f"{name}_dot" in rates and name not in four]


def settings_of(
    eqs: sb.EquationSet, names: list[str], rounds: int, seed: int, start: sb.State | None = None
) -> tuple[sb.Trajectory, list[Setting]]:
    """The motion in which each of these states is set in turn, and what became of each."""
    state = sb.assemble(eqs) if start is None else start
    given = {} if start is None else {**state.q, **state.u}
    scales = mechanism_scales(eqs, {}, None, state.q)
    all_names = (*state.u, *state.q)
    sizes = dict.fromkeys(all_names, 1.0)
    sizes |= {name: scales.length for name in all_names if state.eqs.units.get(name) in ("m", "m/s")}
    random = np.random.default_rng(seed)
    changes = [
        (name, float(random.choice([-1.0, 1.0]) * sizes[name] * (RATE / scales.time if name in state.u else PLACE)))
        for _ in range(rounds) for name in names
    ]  # fmt: skip
    step = STEP * scales.time
    events = [
        sb.Event(f"t - {(k + 1) * step!r}", action={name: f"{name} + ({change!r})"}, name=f"{k}")
        for k, (name, change) in enumerate(changes)
    ]
    first = {name: value for name, value in given.items() if name in eqs.state_names}
    run = sb.simulate(eqs, (len(changes) + 1) * step, initial=first, events=events, integrator=sb.Explicit())
    found = []
    for (_, t, _), (name, change) in zip(run.events, changes, strict=False):
        sample = int(np.searchsorted(run.t, t, side="right")) - 1  # the one after the action
        found.append(Setting(name, float(run[name][sample - 1]) + change, sample))
    return run, found
